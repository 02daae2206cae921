"""Distribution of a line contact over the slices of a surface: an elastic foundation.

Each slice is a spring with a stiffness in proportion to its width. Under the working force the springs in contact add
up to the stiffness of the line contact, whatever their number.
"""

import math

from cycloid_mj.dynamics.law import ContactParameters
from cycloid_mj.parts.convex import Slice


def slice_law(law: ContactParameters, factor: float, surface_slice: Slice, force: float) -> ContactParameters:
    """Compute the contact law of one slice of a surface, which has a share of the stiffness K of the line contact.

    The share is the width of the slice over the effective width of the line contact at the working force, at most 1.
    Damping, added mass and creep are reduced by the same share.

    Parameters
    ----------
    law
        Law of the entire line contact.
    factor
        Stiffness K of a line contact with the curvature of this slice, over the stiffness of `law` [1].
    surface_slice
        The slice: its width, and curvature or radius and clearance.
    force
        Working force F of the line contact [N]; its penetration is d = F/K.
    """
    stiffness = law.stiffness * factor
    penetration = force / stiffness
    contact_width = (
        hole_contact_width(penetration, surface_slice.radius, surface_slice.play)
        if surface_slice.play
        else flank_contact_width(penetration, surface_slice.curvature)
    )
    share = min(1.0, surface_slice.width / contact_width)
    return ContactParameters(
        stiffness=stiffness * share,
        damping=law.damping * share,
        added_mass=law.added_mass * max(1.0, factor) * share,
        friction=law.friction,
        creep=law.creep * share,
    )


def flank_contact_width(depth: float, curvature: float) -> float:
    """Compute the effective width [m] of the contact of two flanks at a penetration [m]: 4/3 sqrt(2 d / kappa).

    The gap opens as kappa s^2 / 2 next to the deepest point: springs of k per width push with 4/3 sqrt(2 d/kappa) k d.
    """
    return 4.0 / 3.0 * math.sqrt(2.0 * depth / curvature)


def hole_contact_width(depth: float, radius: float, play: float) -> float:
    """Compute the effective width [m] of the contact of a round part in a hole at a penetration d = `depth` [m].

    The width is measured along the circumference, in the plane of the disc. The part has the `radius` R [m] and the
    radial clearance `play` [m]. Displaced by x = play + d, it penetrates by x cos(theta) - play at the angle theta, up
    to theta_0 = acos(play / x). Springs of the stiffness k per width push radially. Their total force along the
    displacement is k R [x (theta_0 + sin theta_0 cos theta_0) - 2 play sin theta_0]. The effective width is this force
    divided by k d.
    """
    displacement = play + depth
    half_angle = math.acos(play / displacement)
    return (
        radius
        * (
            displacement * (half_angle + math.sin(half_angle) * math.cos(half_angle))
            - 2.0 * play * math.sin(half_angle)
        )
        / depth
    )
