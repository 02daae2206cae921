"""Statics in closed form: ideal load sharing between pins or lobes, Hertz line contact, Palmgren's line stiffness.

Ideal means equally stiff contacts, no clearance and no friction. Angles as in `kinematics`: counter-clockwise crank
angle, gear centre on +y at 0. A positive load torque acts counter-clockwise on the gear, so it opposes the gear that a
counter-clockwise crank drives; the contacts that lie up to half a turn ahead of the crank carry it. A negative torque
loads the other side.
"""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError
from cycloid_mj.geometry import envelope, profile
from cycloid_mj.geometry.profile import CycloidGear

SHEAR_DEPTH = math.sqrt((math.sqrt(5) - 1) / 2)
"""Depth of the largest shear stress below a line contact, over its half width: 0.786."""
LARGEST_SHEAR = SHEAR_DEPTH - SHEAR_DEPTH**2 / math.sqrt(1 + SHEAR_DEPTH**2)
"""Largest shear stress below a line contact, over its peak pressure: 0.300."""
PALMGREN = 3.84e-5 * 1e-3 / 1e3**0.8
"""Palmgren's 3.84e-5 mm at 1 N on 1 mm, as the deflection [m] at 1 N on 1 m."""


@dataclass(frozen=True)
class LoadSharing:
    """Forces of an ideal mesh under a load torque; the last axis of arrays (..., n) runs over the contacts.

    `arms` [m] (..., n) about the gear centre, positive where the contact's push turns the gear counter-clockwise;
    `forces` [N] (..., n), zero on the idle side; and the force of the eccentric on the gear [N] (...), `tangential`
    counter-clockwise and `radial` outwards along the eccentric. The output's reaction is taken as a pure couple.
    """

    arms: Array
    forces: Array
    eccentric_tangential: Array
    eccentric_radial: Array


@dataclass(frozen=True)
class HertzContact:
    """Stresses of a Hertz line contact.

    `half_width` b [m] of the contact strip, `peak_pressure` p0 [Pa], and the `largest_shear` stress [Pa], 0.300 p0,
    at the depth `shear_depth` [m], 0.786 b, below its middle.
    """

    half_width: Array
    peak_pressure: Array
    largest_shear: Array
    shear_depth: Array


def share_load(arms: npt.ArrayLike, torque: npt.ArrayLike) -> Array:
    """Share a torque among equally stiff contacts, and return their forces (..., n) [N], 0 for those that cannot push.

    F_i = -T l_i / sum l^2 with the torque T (...) [N m], counter-clockwise on the gear, and the `arms` l (..., n) [m],
    as in `LoadSharing`, for n contacts; the sum is over the loaded contacts.
    """
    arms, torque = np.asarray(arms, float), np.asarray(torque, float)[..., np.newaxis]
    relative_force = -torque * arms
    is_loaded = relative_force > 0
    squares = np.sum(np.where(is_loaded, arms**2, 0.0), axis=-1, keepdims=True)
    return np.divide(
        relative_force, squares, out=np.zeros(np.broadcast_shapes(relative_force.shape, squares.shape)), where=is_loaded
    )


def ideal_load_sharing(gear: CycloidGear, torque: npt.ArrayLike, crank_angle: npt.ArrayLike) -> LoadSharing:
    """Share a torque on the gear among the N pins, and compute the reaction of the eccentric.

    `torque` [N m] and `crank_angle` [rad], both counter-clockwise, broadcast to the shape (...). The pins are in the
    order of `profile.pin_angles`; arms and forces have shape (..., N).
    """
    torque, theta = np.broadcast_arrays(torque, crank_angle)
    zeta = profile.pin_angles(gear)
    B = zeta + theta[..., np.newaxis]
    normals = profile.unit(zeta - profile.conjugate_alpha(gear, B))
    return _equilibrate_gear(profile.moment_arm(gear, B), normals, torque, theta)


def ideal_internal_gear_load_sharing(gear: CycloidGear, torque: float, crank_angle: float) -> LoadSharing:
    """Share a torque on the gear among its contacts with an internal gear, and compute the eccentric's reaction.

    The arrays have shape (n,) for n contacts. They contain first the contacts with the N arcs, in the order of
    `envelope.arc_contacts`, then those with the flanks Sigma between the arcs, in the order of
    `envelope.sigma_contacts`. All contacts are equally stiff. `torque` [N m] acts on the gear; it and `crank_angle`
    [rad] are counter-clockwise.
    """
    contacts = envelope.arc_contacts(gear, crank_angle), envelope.sigma_contacts(gear, crank_angle)
    arms = profile.moment_arm(gear, np.concatenate([contacts_of_surface.B for contacts_of_surface in contacts]))
    gear_normals = -np.concatenate([contacts_of_surface.normals for contacts_of_surface in contacts])
    return _equilibrate_gear(arms, gear_normals, np.asarray(torque, float), np.asarray(crank_angle, float))


def ideal_output_forces(
    gear: CycloidGear,
    pins: int,
    pin_circle_radius: float,
    torque: npt.ArrayLike,
    crank_angle: npt.ArrayLike,
    phase: float = 0.0,
) -> Array:
    """Share a torque on the gear among the output pins; return their forces (..., pins) [N], which are not negative.

    A pin touches its hole at -c along the eccentric, with the eccentricity c. So all pins push the gear in the same
    direction, opposite to the eccentric, with the arm r sin(beta) about the gear centre; beta is the angle from the
    eccentric to the hole.

    Parameters
    ----------
    gear, pins, pin_circle_radius
        The mesh, the number of output pins and the radius r of their circle [m]; the first pin is on +y at crank angle
        0, the others follow clockwise.
    torque, crank_angle
        Torque [N m] and crank angle [rad], counter-clockwise; they broadcast to the shape (...).
    phase
        Angle by which the disc's eccentric is ahead of the crank [rad].
    """
    torque, theta = np.broadcast_arrays(torque, crank_angle)
    pin_angle = theta * gear.ring_teeth / gear.lobes + phase
    angle_from_eccentric = 2 * np.pi * np.arange(pins) / pins + pin_angle[..., np.newaxis]
    # The pins transmit the load itself, which the ring balances: the sign is opposite to that in `share_load`.
    return share_load(-pin_circle_radius * np.sin(angle_from_eccentric), -torque)


def cam_force(
    ring: LoadSharing, output_forces: npt.ArrayLike, crank_angle: npt.ArrayLike, body_force: npt.ArrayLike = (0.0, 0.0)
) -> Array:
    """Compute the force of the cam on the gear (..., 2) [N], which is in equilibrium with all other forces on it.

    These are the forces of the ring and of the output pins, and the body force of the gear.

    Parameters
    ----------
    ring
        Loads of the ring at `crank_angle`, as returned by `ideal_load_sharing`.
    output_forces
        Forces of `ideal_output_forces` [N], shape (..., pins).
    crank_angle
        Crank angle [rad], counter-clockwise, shape (...).
    body_force
        Force on the gear's centre [N], shape (..., 2): the weight minus mass times acceleration.
    """
    cos, sin = np.cos(crank_angle), np.sin(crank_angle)
    radial_force = ring.eccentric_radial + np.asarray(output_forces, float).sum(axis=-1)
    outward_axis, forward_axis = np.stack([-sin, cos], axis=-1), np.stack([-cos, -sin], axis=-1)
    resultant = radial_force[..., np.newaxis] * outward_axis + ring.eccentric_tangential[..., np.newaxis] * forward_axis
    return resultant - np.asarray(body_force, float)


def contact_modulus(
    young: float, poisson: float, young_2: float | None = None, poisson_2: float | None = None
) -> float:
    """Modulus E* [Pa] of a pair, 1/E* = (1 - nu_1^2)/E_1 + (1 - nu_2^2)/E_2; the second body defaults to the first."""
    young_2 = young if young_2 is None else young_2
    poisson_2 = poisson if poisson_2 is None else poisson_2
    return 1 / ((1 - poisson**2) / young + (1 - poisson_2**2) / young_2)


def hertz_line_contact(
    force: npt.ArrayLike, length: npt.ArrayLike, relative_curvature: npt.ArrayLike, modulus: float
) -> HertzContact:
    """Compute half width, peak pressure and largest shear stress of Hertz's line contact.

    The half width is 2 sqrt(F / (pi L kappa E*)), the peak pressure sqrt(F kappa E* / (pi L)). `force` F >= 0 [N] acts
    over the contact `length` L [m], `relative_curvature` kappa [1/m] is the sum of the curvatures of both bodies,
    convex positive, and `modulus` E* [Pa] is that of `contact_modulus`. Arrays broadcast.

    Raises
    ------
    DesignError
        If a force is negative, or a length, curvature or modulus is not positive.
    """
    force, length, kappa = (np.asarray(array, float) for array in (force, length, relative_curvature))
    inputs = {
        "force": (force, "N"),
        "length": (length, "m"),
        "relative curvature": (kappa, "1/m"),
        "modulus": (modulus, "Pa"),
    }
    for name, (array, unit) in inputs.items():
        smallest = float(np.asarray(array).min())
        if not (smallest > 0.0 or (name == "force" and smallest == 0.0)):
            raise DesignError(
                f"{name} = {smallest:.4g} {unit} is not valid for a Hertz line contact: a force must be at least 0, "
                "and length, relative curvature and modulus must be positive. Correct this value, or remove contacts "
                "of conformal surfaces, whose relative curvature is 0"
            )
    half_width = 2 * np.sqrt(force / (np.pi * length * kappa * modulus))
    peak_pressure = np.sqrt(force * kappa * modulus / (np.pi * length))
    return HertzContact(half_width, peak_pressure, LARGEST_SHEAR * peak_pressure, SHEAR_DEPTH * half_width)


def palmgren_stiffness(force: npt.ArrayLike, length: npt.ArrayLike) -> Array:
    """Compute the secant stiffness [N/m] of a steel line contact under a force F [N] over a length L [m] (Palmgren).

    The approach of both bodies is 3.84e-5 F^0.9 / L^0.8 in mm and N.
    """
    return np.asarray(force, float) ** 0.1 * np.asarray(length, float) ** 0.8 / PALMGREN


def line_contact_constant(force: float, length: float, modulus: float, depth: float) -> float:
    """Compute the constant a of the compliance factor a + ln kappa = 2 ln(4 D/b) - 1 of a line contact.

    Each body's approach, from the contact to a point at the depth D, is F (1 - nu^2)/(pi E L) [2 ln(4 D/b) - 1]
    with Hertz's half width b (Johnson 1985, Contact Mechanics, section 5.6); b^2 kappa does not depend on the relative
    curvature kappa [1/m]. `force` F [N] over the `length` L [m], `modulus` E* [Pa], `depth` D [m], the same for both
    bodies.
    """
    b_squared_kappa = 4 * force / (math.pi * length * modulus)
    return 2 * math.log(4 * depth) - math.log(b_squared_kappa) - 1


def line_contact_stiffness(
    force: float, length: float, modulus: float, depth: float, relative_curvature: npt.ArrayLike
) -> Array:
    """Compute the secant stiffness pi E* L / (a + ln kappa) [N/m] of a line contact.

    The constant a is that of `line_contact_constant`. The formula requires a half width b below 2 D/e, so the caller
    must keep kappa large enough.

    Parameters
    ----------
    force, length, modulus, depth
        Force [N], length L [m] and modulus E* [Pa] of the contact, and depth D [m] of the reference point in each body.
    relative_curvature
        Relative curvature kappa [1/m], any shape; the result has the same shape.
    """
    constant = line_contact_constant(force, length, modulus, depth)
    return math.pi * modulus * length / (constant + np.log(np.asarray(relative_curvature, float)))


def conformal_stiffness(force: float, length: float, modulus: float, play: float) -> float:
    """Compute the secant stiffness [N/m] of a plain bearing: a shaft in a bore of nearly its own radius R.

    The bore is an elastic bed as thick as the radius (assumed; Winkler's foundation, Johnson 1985, section 4.3). The
    shaft is displaced by x = `play` + d, and penetrates the bed by x cos(theta) - play at the angle theta from the
    load, up to theta_0 = acos(play/x). The pressure is E*/R times the penetration. So the force is F = E* L [x (theta_0
    + sin theta_0 cos theta_0) - 2 play sin theta_0], independent of R, and the stiffness F/d is at most pi/2 E* L.

    Parameters
    ----------
    force
        F > 0 [N].
    length, modulus
        Length L of the bearing [m], and modulus E* of `contact_modulus` [Pa].
    play
        Radial clearance, at least 0 [m].
    """
    from scipy.optimize import brentq

    bed_stiffness = modulus * length

    def excess_force(depth: float) -> float:
        """Compute the force of the bed at a deflection `depth` [m] minus the load [N]."""
        displacement = play + depth
        half_angle = math.acos(play / displacement)
        sine, cosine = math.sin(half_angle), math.cos(half_angle)
        return bed_stiffness * (displacement * (half_angle + sine * cosine) - 2 * play * sine) - force

    # The bed is at least as stiff as the last bracket's end: the force grows without bound.
    max_deflection = 2 * force / (math.pi * bed_stiffness)
    while excess_force(max_deflection) < 0:
        max_deflection *= 2
    return float(force / brentq(excess_force, max_deflection * 1e-9, max_deflection, xtol=1e-18, rtol=1e-12))


def _equilibrate_gear(arms: Array, gear_normals: Array, torque: Array, crank_angle: Array) -> LoadSharing:
    """Share a torque [N m] among n contacts by their lever arms (..., n) [m], and compute the eccentric's reaction.

    The reaction acts on the gear. `gear_normals` (..., n, 2) are the directions in which the contacts push the gear.
    `torque` and `crank_angle` [rad] have the shape (...).
    """
    forces = share_load(arms, torque)
    resultant = np.sum(forces[..., np.newaxis] * gear_normals, axis=-2)
    cos, sin = np.cos(crank_angle), np.sin(crank_angle)
    return LoadSharing(
        arms=arms,
        forces=forces,
        eccentric_tangential=-resultant[..., 0] * cos - resultant[..., 1] * sin,
        eccentric_radial=resultant[..., 1] * cos - resultant[..., 0] * sin,
    )
