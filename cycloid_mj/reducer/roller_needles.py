"""Needles between the rollers of the output pins and their cores.

A roller is a rigid ring on its core, on Z needles. By default, the needles of a roller are a single spring in series
with the contact of the roller with its hole: the secant stiffness of the same needles without clearance, averaged over
a turn of their cage.

With ``contact.needles = "each"``, each needle is a spring that can push but not pull. The hole of the disc presses the
roller towards the core; across this direction, it is free, as it rolls in the hole. The force follows from the least
energy of the contact with the hole and of the needles.
"""

import math
from typing import TYPE_CHECKING, NamedTuple

from cycloid_mj.geometry import ideal_loads
from cycloid_mj.reducer.contact import STRIBECK
from cycloid_mj.reducer.rv_bodies import needle_share

if TYPE_CHECKING:
    from cycloid_mj.design.model import Output
    from cycloid_mj.reducer import Reducer

NEEDLE_SHARE = 0.35
"""Assumed diameter of the needles over the difference in diameter of an output roller and its core."""


class NeedleRow(NamedTuple):
    """Needles around a core: their number, and their diameter and pitch diameter [m]."""

    needles: int
    diameter: float
    pitch: float


class RollerNeedles(NamedTuple):
    """Needles of the rollers of a reducer.

    Attributes
    ----------
    needles
        Number of needles of a roller; 0 without separate needles.
    stiffness
        Stiffness of a needle between core and roller [N/m].
    clearance
        Radial clearance of the needles [m]: all of the clearance between output pin and hole.
    cage_ratio
        Turns of the cage per turn of the crank, both relative to the carrier; negative.
    """

    needles: int
    stiffness: float
    clearance: float
    cage_ratio: float


NO_NEEDLES = RollerNeedles(0, 0.0, 0.0, 0.0)


def needle_row(output: "Output") -> NeedleRow:
    """Return the needles of an output roller: as many as fit around the core, of the size `NEEDLE_SHARE`."""
    diameter = NEEDLE_SHARE * 2.0 * (output.pin_radius - output.root_radius)
    pitch = 2.0 * output.root_radius + diameter
    return NeedleRow(max(int(math.pi * pitch / diameter), 3), diameter, pitch)


def has_needle_springs(reducer: "Reducer") -> bool:
    """Return whether rollers are parts of their own with needles (``output.core_radius``), on line contacts."""
    output = reducer.design.output
    return output.has_needles and output.has_roller_parts and reducer.design.contact.law != "impact"


def bearing_stiffness(reducer: "Reducer") -> float:
    """Compute the radial stiffness of the needles of a roller on its core, at the working force of output pins [N/m].

    Clearance is left out. It is the secant stiffness of the bearing: that of the most loaded needle, which carries
    4.08/Z of the force (Stribeck). A needle is in contact with core and roller; both contacts are as stiff as a pin on
    a flat (`ideal_loads.line_contact_stiffness`), with the material of the output.
    """
    design = reducer.design
    bearing_row, force = needle_row(design.output), reducer.contacts["output"].force
    material, depth = design.material_of("output"), 0.5 * bearing_row.diameter
    line_stiffness = design.contact.stiffness or float(
        ideal_loads.line_contact_stiffness(
            STRIBECK * force / bearing_row.needles,
            design.gear.face_width,
            ideal_loads.contact_modulus(material.youngs_modulus, material.poisson),
            depth,
            1.0 / depth,
        )
    )
    return 0.5 * line_stiffness * bearing_row.needles / STRIBECK


def lumped_compliance(reducer: "Reducer") -> float:
    """Compute the compliance of the needles of a roller as a single spring [m/N]; 0 without needles.

    With ``contact.needles = "each"``, it is also 0, because each needle is a spring of its own (`roller_needles`).
    """
    if reducer.design.contact.needles == "each" or not has_needle_springs(reducer):
        return 0.0
    return 1.0 / bearing_stiffness(reducer)


def roller_needles(reducer: "Reducer") -> RollerNeedles:
    """Return the separate needles of the rollers of a reducer, at the stiffness of its working force.

    Rollers have separate needles if ``contact.needles`` is "each" (`has_needle_springs`).
    """
    output = reducer.design.output
    if reducer.design.contact.needles != "each" or not has_needle_springs(reducer):
        return NO_NEEDLES
    bearing_row = needle_row(output)
    # the centre of the hole circles around the pin, so that the roller turns back
    roller_turn = 1.0 - output.hole_radius / output.pin_radius
    inner_raceway, outer_raceway = bearing_row.pitch - bearing_row.diameter, bearing_row.pitch + bearing_row.diameter
    return RollerNeedles(
        needles=bearing_row.needles,
        stiffness=needle_share(bearing_row.needles) * bearing_stiffness(reducer),
        clearance=max(reducer.output_clearance, 0.0),
        cage_ratio=roller_turn * outer_raceway / (inner_raceway + outer_raceway),
    )


def onset(needles: RollerNeedles, angle: float) -> float:
    """Compute the approach of hole and core at which a roller begins to carry load [m].

    Without load, the roller rests on the two needles next to the direction of the force. `angle` is this direction,
    relative to that of a needle [rad].
    """
    half_spacing = math.pi / needles.needles
    return needles.clearance * math.cos(angle % (2.0 * half_spacing) - half_spacing) / math.cos(half_spacing)


def roller_contact(
    approach: float,
    angle: float,
    stiffness: float,
    needles: int,
    needle_stiffness: float,
    clearance: float,
) -> tuple[float, float]:
    """Compute force [N] and stiffness [N/m] of a roller between hole and core, by a semismooth Newton method.

    The stiffness is the derivative of the force by `approach`, which must exceed `onset`. The unknowns are the
    displacements of the roller on its core, x along the force and y across. The energy of all springs is convex; steps
    that raise it are halved. In the code, xx, xy and yy are its second derivatives [N/m].

    Parameters
    ----------
    approach
        Approach of the hole to the core since the roller touches the hole, centred on its core [m].
    angle
        Direction of the force, relative to that of a needle [rad].
    stiffness
        Stiffness of the contact with the hole [N/m].
    needles, needle_stiffness, clearance
        Number, stiffness [N/m] and clearance [m] of the needles, as in `RollerNeedles`.
    """
    x, y, step_x, step_y, min_energy = approach, 0.0, 0.0, 0.0, math.inf
    spacing, regularisation = 2.0 * math.pi / needles, 1e-9 * stiffness
    xx, xy, yy = stiffness, 0.0, regularisation
    for _ in range(100):
        trial_x, trial_y = x + step_x, y + step_y
        force = stiffness * (approach - trial_x)
        energy, gradient_x, gradient_y = 0.5 * force * (approach - trial_x), -force, 0.0
        hessian_xx, hessian_xy, hessian_yy = stiffness + regularisation, 0.0, regularisation
        for needle in range(needles):
            cosine, sine = math.cos(needle * spacing - angle), math.sin(needle * spacing - angle)
            depth = trial_x * cosine + trial_y * sine - clearance
            if depth > 0.0:
                needle_force = needle_stiffness * depth
                energy += 0.5 * needle_force * depth
                gradient_x += needle_force * cosine
                gradient_y += needle_force * sine
                hessian_xx += needle_stiffness * cosine * cosine
                hessian_xy += needle_stiffness * cosine * sine
                hessian_yy += needle_stiffness * sine * sine
        if energy > min_energy * (1.0 + 1e-12):
            step_x, step_y = 0.5 * step_x, 0.5 * step_y
            continue
        x, y, min_energy, xx, xy, yy = trial_x, trial_y, energy, hessian_xx, hessian_xy, hessian_yy
        if abs(gradient_x) + abs(gradient_y) <= 1e-9 * stiffness * approach:
            break
        determinant = xx * yy - xy * xy
        step_x = -(yy * gradient_x - xy * gradient_y) / determinant
        step_y = -(xx * gradient_y - xy * gradient_x) / determinant
    return stiffness * (approach - x), stiffness * (1.0 - stiffness * yy / (xx * yy - xy * xy))
