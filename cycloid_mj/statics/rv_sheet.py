"""Data-sheet figures of an RV reducer by statics."""

from collections.abc import Iterator

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.result import Quantity
from cycloid_mj.base.statistics import peak_to_peak
from cycloid_mj.base.units import ARCMINUTE, ARCSECOND
from cycloid_mj.design.materials import YIELD_PRESSURE
from cycloid_mj.geometry.measured import part_notes
from cycloid_mj.geometry.rv import mesh_loss_factor
from cycloid_mj.geometry.rv_loads import IdealRvLoads, closed_error, ideal_rv_loads, mean_force
from cycloid_mj.reducer import RvReducer, once
from cycloid_mj.statics.kernel import CARRYING_SHARE
from cycloid_mj.statics.rv import RvLoads, RvSprings, crank_misfits, phase_errors, rv_loads, rv_springs
from cycloid_mj.statics.sheet_figures import sheet_quantity
from cycloid_mj.statics.windup import LOST_MOTION_SHARE, STRAIGHT

ANGLES = 720
"""Crank angles over a turn of the carrier: peak forces are within 0.1 % of those at 3510 angles."""
FEW_ANGLES = 61
"""The same for means of rotations."""
CLOSED_ANGLES = 960
"""Crank angles over a turn of the carrier for closed forms: 24 in each turn of a crank of 40 pins."""
STOP_TORQUE_SHARE = 1e-4
"""Torque that moves the parts to their stops, over the load; the stop is extrapolated to no torque."""


def carrier_turn(reducer: RvReducer, count: int = ANGLES) -> Array:
    """Return crank angles against the ring in order [rad], shape (count,), that cover a turn of the carrier evenly.

    They are multiples of the golden ratio of the turn, which cover any of its parts evenly too.
    """
    return np.asarray(reducer.crank_turn * np.sort(np.mod(0.5 * (np.sqrt(5.0) - 1.0) * np.arange(count), 1.0)))


def torque_on_carrier(reducer: RvReducer, torque: float) -> float:
    """Convert a torque on the output [N m] that brakes the drive to that on the carrier, seen from the ring."""
    return reducer.share * float(np.copysign(torque, reducer.design.drive.speed)) * np.sign(torque)


@once
def balanced(reducer: RvReducer, torque: float, count: int = ANGLES) -> RvLoads:
    """Balance the drive over a turn of the carrier under a torque on the output [N m]; errors as in `rv_loads`."""
    return rv_loads(springs_over_turn(reducer, count), torque_on_carrier(reducer, torque))


@once
def springs_over_turn(reducer: RvReducer, count: int = ANGLES) -> RvSprings:
    """Return the springs at the angles of `carrier_turn`."""
    return rv_springs(reducer, carrier_turn(reducer, count))


@once
def ideal(reducer: RvReducer, torque: float) -> IdealRvLoads:
    """Return the forces of ideal sharing over a turn of the carrier under a torque on the output [N m]."""
    return ideal_rv_loads(reducer.stage, torque_on_carrier(reducer, torque), carrier_turn(reducer))


def closed_turn(reducer: RvReducer) -> Array:
    """Compute the rotation of the output by the errors of the design in closed form [rad], over a turn of the carrier.

    At `CLOSED_ANGLES` crank angles.
    """
    crank = np.linspace(0.0, reducer.crank_turn, CLOSED_ANGLES, endpoint=False)
    turn = closed_error(reducer.stage, crank, phase_errors(reducer, crank), crank_misfits(reducer, crank))
    return reducer.share * turn


def motions(reducer: RvReducer, load: float) -> Iterator[Quantity]:
    """Yield backlash, lost motion and stiffness at a fixed sun, without friction and weight."""

    def turn(share: float) -> Array:
        return reducer.share * balanced(reducer, share * load, FEW_ANGLES).carrier_turn

    small = STOP_TORQUE_SHARE
    ahead, back = (2.0 * turn(sign * small) - turn(2.0 * sign * small) for sign in (1.0, -1.0))
    width = np.abs(ahead - back) / ARCMINUTE
    yield sheet_quantity("backlash", float(width.mean()))
    yield sheet_quantity("backlash_min", float(width.min()))
    yield sheet_quantity("backlash_max", float(width.max()))
    lost = np.abs(turn(LOST_MOTION_SHARE) - turn(-LOST_MOTION_SHARE))
    yield sheet_quantity("lost_motion_ideal", float(lost.mean()) / ARCMINUTE)
    low, high = STRAIGHT
    rise = np.abs(turn(high) - turn(low)) + np.abs(turn(-high) - turn(-low))
    stiffness = 2.0 * (high - low) * load / rise * ARCMINUTE
    yield sheet_quantity("stiffness_ideal", float(stiffness.mean()))


def forces(reducer: RvReducer, load: float) -> Iterator[Quantity]:
    """Yield forces of cranks, pins and planets, and the pressure on the pins."""
    shared, solved, springs = ideal(reducer, load), balanced(reducer, load), springs_over_turn(reducer)
    kind = reducer.design.tooth_pair
    contact, force = reducer.at_rated_load.contacts[kind], solved.pins
    carries = force > CARRYING_SHARE * force.max()
    spare = contact.strength / float(contact.pressure(force, springs.curvature).max())
    yield sheet_quantity("crank_bearing_force", float(shared.bearings.max()))
    yield sheet_quantity("crank_bearing_mean_force", _largest_mean(shared.bearings))
    yield sheet_quantity("crank_bearing_balanced_force", float(solved.bearings.max()))
    yield sheet_quantity("crank_bearing_balanced_mean_force", _largest_mean(solved.bearings))
    yield sheet_quantity("planet_mesh_force", float(np.abs(solved.meshes).max()))
    yield sheet_quantity("te_ideal", reducer.share * peak_to_peak(solved.carrier_turn) / ARCSECOND)
    yield sheet_quantity("te_errors", peak_to_peak(closed_turn(reducer)) / ARCSECOND)
    peak = float(shared.pins.max())
    yield sheet_quantity(f"{kind}_peak_force", float(force.max()), reference=peak, source="ideal sharing")
    yield sheet_quantity(f"{kind}_mean_force", float(force[carries].mean()))
    yield sheet_quantity(f"{kind}_carrying", float(carries.sum(axis=1).mean()))
    yield sheet_quantity(f"{kind}_pressure", 1e-6 * contact.strength / spare)
    yield sheet_quantity(f"{kind}_margin", YIELD_PRESSURE * spare)


def _largest_mean(bearings: Array) -> float:
    """Return the largest of the means of the forces on the bearings (m, D, n) [N]."""
    return max(mean_force(force) for force in bearings.reshape(len(bearings), -1).T)


def losses(reducer: RvReducer, load: float) -> Iterator[Quantity]:
    """Yield efficiency and losses, from the forces of the balance without friction."""
    lost = friction_powers(reducer, load)
    design, kind = reducer.design, reducer.design.tooth_pair
    delivered = load * abs(reducer.output_speed)
    supplied = delivered + sum(lost.values())
    yield sheet_quantity("efficiency", 100.0 * delivered / supplied)
    note = f"including {design.seat_pair}" if design.seat_pair else ""
    yield sheet_quantity(f"{kind}_friction_power", lost["teeth"], note=note)
    yield sheet_quantity("crank_bearing_friction_power", lost["crank bearings"])
    yield sheet_quantity("planet_friction_power", lost["planets"])
    yield sheet_quantity("seals_power", lost["seals"])
    yield sheet_quantity("input_power", supplied)
    yield sheet_quantity("output_power", delivered)


def friction_powers(reducer: RvReducer, load: float) -> dict[str, float]:
    """Compute the mean powers lost to friction under a torque on the output [W], by part.

    Needles and tapered bearings of a crank carry the force of the disc; their coefficient acts at the radius of the
    eccentric.
    """
    design, planet = reducer.design, reducer.planet
    solved, springs = balanced(reducer, load), springs_over_turn(reducer)
    output, kinematics = abs(reducer.output_speed), reducer.kinematics
    against_ring = output * reducer.share * float(abs(kinematics.crank_per_carrier))
    sliding = np.sum(solved.pins * np.abs(springs.slip), axis=1).mean() * against_ring
    rolled = 2.0 * solved.bearings.sum(axis=(1, 2)).mean() * reducer.cranks.eccentric_radius * reducer.crank_speed
    # the sun's torque acts at its speed against the carrier
    through_mesh = load * output * float((kinematics.to_carrier - 1) / abs(kinematics.ratio))
    factor = mesh_loss_factor(planet.sun_teeth, planet.planet_teeth, planet.pressure_angle)
    return {
        "teeth": float(design.mesh_friction * sliding),
        "crank bearings": float(design.friction.cam_rolling * rolled),
        "planets": planet.friction * factor * through_mesh,
        "seals": design.drag.crank * abs(design.drive.speed) + design.drag.output * output,
    }


def assumptions(reducer: RvReducer) -> tuple[str, ...]:
    """Return the assumptions of the figures, a sentence each."""
    design = reducer.design
    return (
        "statics: parts are rigid, pins, planet teeth and crank bearings are springs with all clearances and "
        "manufacturing errors, to first order in displacements; no weight and no inertia",
        f"crank bearings: needles and taper in series, {reducer.bearing_stiffness:.4g} N/m and "
        f"{1e6 * reducer.bearing_clearance:.4g} um for each crank and disc; discs do not tilt",
        f"planet mesh: {reducer.mesh_stiffness:.4g} N/m along the line of action"
        + ("" if reducer.planet.mesh_stiffness else " (ISO 6336-1, method B)"),
        "losses: Coulomb friction of the forces without friction; "
        f"mesh {design.mesh_friction:g}, crank bearings {design.friction.cam_rolling:g}, "
        f"planets {reducer.planet.friction:g}",
        f"{ANGLES} crank angles over a turn of the carrier, {FEW_ANGLES} for backlash, lost motion and stiffness",
        *part_notes(design),
    )
