"""Data-sheet figures of an RV reducer by statics."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.powers import Powers
from cycloid_mj.base.result import Quantity
from cycloid_mj.base.statistics import peak_to_peak
from cycloid_mj.base.units import ARCMINUTE, ARCSECOND
from cycloid_mj.design.materials import YIELD_PRESSURE
from cycloid_mj.geometry.measured import part_notes
from cycloid_mj.geometry.rv_loads import IdealRvLoads, closed_form_error, ideal_rv_loads, mean_force
from cycloid_mj.reducer import RvReducer, once
from cycloid_mj.statics.film import FilmInputs, drag_power, drag_torques
from cycloid_mj.statics.film_spread import RAISED_FRICTION, SAMPLES, extrapolate_losses, loss_growth
from cycloid_mj.statics.kernel import CARRYING_SHARE
from cycloid_mj.statics.rv import (
    RunningFriction,
    RvLoads,
    RvSprings,
    compute_rv_springs,
    crank_misfits,
    phase_errors,
    runout_error,
    solve_rv_loads,
)
from cycloid_mj.statics.rv_film import (
    RvFilm,
    RvFilmLosses,
    build_rv_losses,
    running_friction,
    rv_film_assumption,
)
from cycloid_mj.statics.rv_pin_errors import PinErrorEquilibrium, pin_error_equilibrium
from cycloid_mj.statics.sheet_figures import sheet_quantity
from cycloid_mj.statics.stops import stop_width
from cycloid_mj.statics.windup import LOST_MOTION_SHARE, STRAIGHT


@dataclass(frozen=True)
class RvSheetSettings:
    """Settings of the figures of an RV reducer.

    Attributes
    ----------
    force_angles
        Crank angles over a turn of the carrier: peak forces are within 0.1 % of those at 3510 angles.
    error_angles
        The same for the range of rotations: within 1 % of that at 720 angles.
    rotation_angles
        The same for means of rotations.
    stop_torque_share
        Torque that moves the parts to their stops, over the load; the stop is extrapolated to no torque.
    closed_angles
        The same for closed forms: 24 in each turn of a crank of 40 pins.
    """

    force_angles: int = 720
    error_angles: int = 241
    rotation_angles: int = 61
    closed_angles: int = 960
    stop_torque_share: float = 1e-4


SETTINGS = RvSheetSettings()


def carrier_turn_angles(reducer: RvReducer, count: int = SETTINGS.force_angles) -> Array:
    """Return `count` crank angles against the ring [rad] that cover a turn of the carrier nearly evenly.

    Divided by the turn, they are the fractional parts of k times the golden ratio for k = 0, 1, ..., sorted in the
    order in which the drive passes them. The angles within any part of the turn then cover this part nearly evenly,
    too.
    """
    turn_shares = np.sort(np.mod(0.5 * (np.sqrt(5.0) - 1.0) * np.arange(count), 1.0))
    return np.asarray(-_carrier_sense(reducer) * reducer.crank_turn * turn_shares)


def _carrier_sense(reducer: RvReducer) -> float:
    """Return the direction of rotation of the carrier, seen from the ring: that of the sun; the cranks turn back."""
    return float(np.copysign(1.0, reducer.design.drive.speed))


def torque_on_carrier(reducer: RvReducer, torque: float) -> float:
    """Convert a torque on the output [N m] that brakes the drive to that on the carrier, seen from the ring."""
    return -_carrier_sense(reducer) * reducer.share * torque


@once
def solve_rv_equilibrium(reducer: RvReducer, torque: float, count: int = SETTINGS.force_angles) -> RvLoads:
    """Solve for the static equilibrium of an RV reducer without friction, at `count` angles over a turn of the carrier.

    `torque` is the torque on the output [N m], not 0. The result has the contact forces [N], displacements [m] and
    rotation of the carrier [rad] at these angles.

    Raises
    ------
    RunError
        The Newton method does not converge.
    """
    return solve_rv_loads(springs_over_turn(reducer, count), torque_on_carrier(reducer, torque))


@once
def solve_running_equilibrium(reducer: RvReducer, torque: float, count: int = SETTINGS.force_angles) -> RvLoads:
    """Solve for the static equilibrium of a running RV reducer with friction, at angles over a turn of the carrier.

    The result has the contact forces [N], displacements [m] and rotation of the carrier [rad] at `count` crank angles.
    `torque` [N m], not 0, acts on the output and brakes the drive. A negative torque brakes a drive that runs in
    reverse.

    Raises
    ------
    RunError
        The Newton method or the iteration of friction does not converge.
    """
    springs, on_carrier = springs_over_turn(reducer, count), torque_on_carrier(reducer, torque)
    return solve_rv_loads(springs, on_carrier, friction_over_turn(reducer, float(np.sign(torque)), count))


def solve_forward_equilibrium(reducer: RvReducer, torque: float, count: int = SETTINGS.force_angles) -> RvLoads:
    """Solve for the static equilibrium with friction of a reducer that rotates in the direction of its design.

    Unlike in `solve_running_equilibrium`, friction has this direction at either sign of the torque.

    Parameters
    ----------
    reducer
        The reducer; the sign of ``drive.speed_rpm`` is its direction of rotation.
    torque
        Torque on the output [N m], not 0. If it is positive, it brakes the output and the sun drives; if it is
        negative, the output drives the sun.
    count
        Number of crank angles over a turn of the carrier, those of `carrier_turn_angles`.

    Raises
    ------
    RunError
        The Newton method or the iteration of friction does not converge.
    """
    if torque > 0.0:
        return solve_running_equilibrium(reducer, torque, count)
    friction = friction_over_turn(reducer, 1.0, count)
    return solve_rv_loads(springs_over_turn(reducer, count), torque_on_carrier(reducer, torque), friction)


def output_rotation(reducer: RvReducer, carrier_turn: Array) -> Array:
    """Convert rotations of the carrier from its ideal angle to those of the output [rad], counter-clockwise."""
    return (-1.0 if reducer.design.output.turns_ring else 1.0) * reducer.share * carrier_turn


def running_rotation(reducer: RvReducer, torque: float) -> Array:
    """Compute the output's rotation from its ideal angle [rad] over a turn of the carrier, shape (`error_angles`,).

    The rotation is counter-clockwise, with friction; `torque` [N m] is an argument of `solve_running_equilibrium`.
    """
    return output_rotation(reducer, solve_running_equilibrium(reducer, torque, SETTINGS.error_angles).carrier_turn)


@once
def springs_over_turn(reducer: RvReducer, count: int = SETTINGS.force_angles) -> RvSprings:
    """Return the springs at the angles of `carrier_turn_angles`."""
    return compute_rv_springs(reducer, carrier_turn_angles(reducer, count))


@once
def friction_over_turn(reducer: RvReducer, sign: float, count: int = SETTINGS.force_angles) -> RunningFriction:
    """Return the friction of the running drive at the angles of `carrier_turn_angles`.

    `sign` is that of the torque on the output that brakes the drive: 1, or -1 of a drive that runs in reverse.
    """
    sense = np.sign(torque_on_carrier(reducer, sign))
    return running_friction(reducer, springs_over_turn(reducer, count).crank, float(sense))


def film_over_turn(reducer: RvReducer, sign: float, count: int = SETTINGS.force_angles) -> RvFilm:
    """Return `friction_over_turn` of a reducer with the law ``film``."""
    film = friction_over_turn(reducer, sign, count)
    assert isinstance(film, RvFilm)
    return film


@once
def ideal_rv(reducer: RvReducer, torque: float) -> IdealRvLoads:
    """Return the forces of ideal sharing over a turn of the carrier under a torque on the output [N m]."""
    return ideal_rv_loads(reducer.stage, torque_on_carrier(reducer, torque), carrier_turn_angles(reducer))


def closed_form_angles(reducer: RvReducer) -> Array:
    """Return `RvSheetSettings.closed_angles` crank angles against the ring [rad] over a turn of the carrier."""
    return np.linspace(0.0, reducer.crank_turn, SETTINGS.closed_angles, endpoint=False)


def closed_rotation(reducer: RvReducer) -> Array:
    """Compute the rotation of the output due to errors of cranks, bores, planets and output, in closed form [rad].

    The shape is (n,), for n crank angles from `closed_form_angles`. The sun is fixed; clearance and load are left out.
    """
    crank_angles = closed_form_angles(reducer)
    rotation = closed_form_error(
        reducer.stage, crank_angles, phase_errors(reducer, crank_angles), crank_misfits(reducer, crank_angles)
    )
    # a crank turns N - 1 times against the ring per turn of the output, against the carrier's direction of rotation
    output_angle = (1.0 if reducer.design.output.turns_ring else -1.0) * crank_angles / reducer.design.lobes
    return reducer.share * rotation + runout_error(reducer, output_angle)


def pin_equilibrium(reducer: RvReducer) -> PinErrorEquilibrium:
    """Return the equilibrium under the nominal torque, for the rotation due to position errors of pins."""
    return pin_error_equilibrium(reducer, torque_on_carrier(reducer, reducer.design.rated_torque))


def error_rotation(reducer: RvReducer) -> Array:
    """Compute the rotation of the output [rad] due to errors of cranks, bores, planets, output and positions of pins.

    It is the sum of `closed_rotation` and of the rotation by the pins (`pin_equilibrium`) under the nominal torque, at
    the n angles of `closed_form_angles`, shape (n,).
    """
    rotation, displacements = closed_rotation(reducer), reducer.deviations.pin_displacement
    if not displacements.any():
        return rotation
    equilibrium = pin_equilibrium(reducer)
    return rotation + equilibrium.interpolate(equilibrium.rotation(displacements), closed_form_angles(reducer))


def motion_figures(reducer: RvReducer, load: float) -> Iterator[Quantity]:
    """Yield backlash [arcmin], lost motion [arcmin] and stiffness [N m/arcmin] of an RV reducer at a fixed sun.

    Backlash is the mean, smallest and largest over a turn of the carrier; lost motion and stiffness are means. Lost
    motion is taken between +3 % and -3 % of `load`, the torque on the output [N m], stiffness from 50 to 100 % of it.
    Friction and weight are not included.
    """

    def rotation(torque: float) -> Array:
        """Return the output's rotation under a torque on it [N m] in [rad], shape (m,)."""
        return reducer.share * solve_rv_equilibrium(reducer, torque, SETTINGS.rotation_angles).carrier_turn

    backlash = np.abs(stop_width(rotation, SETTINGS.stop_torque_share * load)) / ARCMINUTE
    yield sheet_quantity("backlash", float(backlash.mean()))
    yield sheet_quantity("backlash_min", float(backlash.min()))
    yield sheet_quantity("backlash_max", float(backlash.max()))
    yield sheet_quantity("lost_motion_ideal", lost_motion(reducer, load) / ARCMINUTE)
    low_share, high_share = STRAIGHT
    forward_turn, backward_turn = (
        np.abs(rotation(sign * high_share * load) - rotation(sign * low_share * load)) for sign in (1, -1)
    )
    total_rotation = forward_turn + backward_turn
    stiffness = 2.0 * (high_share - low_share) * load / total_rotation * ARCMINUTE
    yield sheet_quantity("stiffness_ideal", float(stiffness.mean()))


def lost_motion(reducer: RvReducer, load: float) -> float:
    """Compute the rotation of the output between +3 % and -3 % of a load, without friction [rad].

    `load` is in [N m]; the rotation is the mean over a turn of the carrier.
    """
    rotations = [
        solve_rv_equilibrium(reducer, share * load, SETTINGS.rotation_angles).carrier_turn
        for share in (LOST_MOTION_SHARE, -LOST_MOTION_SHARE)
    ]
    return reducer.share * float(np.mean(np.abs(rotations[0] - rotations[1])))


def force_figures(reducer: RvReducer, load: float) -> Iterator[Quantity]:
    """Yield forces [N] of cranks, pins and planets, pressure [MPa] on the pins, and transmission errors p-p [arcsec].

    Forces are the largest and the mean over a turn of the carrier. Crank forces are yielded for ideal sharing and for
    equilibrium with and without friction. `load` is the torque on the output [N m]. Keys and definitions are in
    `sheet_figures`.
    """
    ideal_loads, equilibrium_loads, springs = (
        ideal_rv(reducer, load),
        solve_rv_equilibrium(reducer, load),
        springs_over_turn(reducer),
    )
    running_loads = solve_running_equilibrium(reducer, load)
    kind = reducer.design.tooth_pair
    contact, force = reducer.at_rated_load.contacts[kind], running_loads.pins
    is_loaded = force > CARRYING_SHARE * force.max()
    strength_ratio = contact.strength / float(contact.pressure(force, springs.curvature).max())
    for name, loads in (("", ideal_loads), ("balanced_", equilibrium_loads), ("running_", running_loads)):
        yield sheet_quantity(f"crank_bearing_{name}force", float(loads.bearings.max()))
        yield sheet_quantity(f"crank_bearing_{name}mean_force", largest_mean_force(loads.bearings))
    yield sheet_quantity("planet_mesh_force", float(running_loads.flanks.max()))
    yield sheet_quantity("te_ideal", reducer.share * peak_to_peak(equilibrium_loads.carrier_turn) / ARCSECOND)
    yield sheet_quantity("te_errors", peak_to_peak(error_rotation(reducer)) / ARCSECOND)
    ideal_peak = float(ideal_loads.pins.max())
    yield sheet_quantity(f"{kind}_peak_force", float(force.max()), reference=ideal_peak, source="ideal sharing")
    yield sheet_quantity(f"{kind}_mean_force", float(force[is_loaded].mean()))
    yield sheet_quantity(f"{kind}_carrying", float(is_loaded.sum(axis=1).mean()))
    yield sheet_quantity(f"{kind}_pressure", 1e-6 * contact.strength / strength_ratio)
    yield sheet_quantity(f"{kind}_margin", YIELD_PRESSURE * strength_ratio)


def largest_mean_force(bearings: Array) -> float:
    """Return the largest of the means of the forces on the bearings (m, D, n) [N]."""
    return max(mean_force(force) for force in bearings.reshape(len(bearings), -1).T)


@once
def friction_powers(reducer: RvReducer, load: float, count: int = SETTINGS.force_angles) -> dict[str, float]:
    """Compute the mean powers lost to friction under a `load` on the output [N m], over a turn of the carrier.

    A negative load drives the output. The mean is over `count` crank angles. Needles and tapered bearings of a crank
    both carry the force of the disc. With the law ``coulomb``, their friction acts at the radius of the eccentric. With
    the law ``film``, "seals" include the main bearings (`rv_film`).

    Returns
    -------
    dict
        Power [W] lost by the "teeth", "crank bearings", "planets" and "seals".
    """
    design = reducer.design
    if design.has_film:
        return _film_losses(reducer, load, count).powers()
    springs, equilibrium_loads = springs_over_turn(reducer, count), solve_forward_equilibrium(reducer, load, count)
    sliding = np.sum(equilibrium_loads.pins * np.abs(springs.slip), axis=1).mean() * abs(reducer.speed_against_ring)
    bearing_power = (
        2.0 * equilibrium_loads.bearings.sum(axis=(1, 2)).mean() * reducer.cranks.eccentric_radius * reducer.crank_speed
    )
    mesh_power = equilibrium_loads.meshes.sum(axis=1).mean() * reducer.planet_mesh.arm * reducer.planet_mesh_speed
    return {
        "teeth": float(design.mesh_friction * sliding),
        "crank bearings": float(design.friction.cam_rolling * bearing_power),
        "planets": float(reducer.planet.friction * mesh_power),
        "seals": drag_power(reducer),
    }


@once
def _film_losses(reducer: RvReducer, load: float, count: int) -> RvFilmLosses:
    """Return the losses of the running drive with the law ``film``; arguments are those of `friction_powers`."""
    equilibrium_loads = solve_forward_equilibrium(reducer, load + drag_torques(reducer)[1], count)
    return build_rv_losses(film_over_turn(reducer, 1.0, count), springs_over_turn(reducer, count), equilibrium_loads)


def rv_powers(reducer: RvReducer, torque: float, count: int = SETTINGS.force_angles) -> Powers:
    """Compute the mean powers through sun and output and the friction losses of an RV reducer in static equilibrium.

    Parameters
    ----------
    reducer
        The reducer; its speed must not be 0.
    torque
        Torque on the output [N m], not 0: it brakes if positive, and drives if negative.
    count
        Number of crank angles over a turn of the carrier.

    Returns
    -------
    Powers
        Mean powers into the reducer through sun and output [W], and lost to friction [W] by the keys of
        `friction_powers`.

    Raises
    ------
    RunError
        There is no equilibrium.
    """
    losses = friction_powers(reducer, torque, count)
    output_power = torque * abs(reducer.output_speed)
    return Powers(output_power + sum(losses.values()), -output_power, losses)


@once
def rv_lost_powers(reducer: RvReducer, load: float, samples: int = SAMPLES) -> tuple[float, Array]:
    """Compute the power lost with the law ``film``, for the design's own inputs of the law and for samples of them.

    `load` is the torque on the output [N m]. Powers are means over `RvSheetSettings.rotation_angles` crank angles.
    Returns the power lost with the design's inputs [W], and with the inputs of each sample [W], shape (samples,).

    Raises
    ------
    RunError
        The Newton method or the iteration of friction does not converge.
    """
    angle_count = SETTINGS.rotation_angles
    losses, springs = _film_losses(reducer, load, angle_count), springs_over_turn(reducer, angle_count)
    torque = load + drag_torques(reducer)[1]
    raised_film = replace(film_over_turn(reducer, float(np.sign(torque)), angle_count), factor=RAISED_FRICTION)
    raised_loads = solve_rv_loads(springs, torque_on_carrier(reducer, torque), raised_film)
    raised_losses = build_rv_losses(raised_film, springs, raised_loads)
    design_loss, raised_loss = (sum(film_losses.contact_powers().values()) for film_losses in (losses, raised_losses))
    growth = loss_growth(design_loss, RAISED_FRICTION * raised_loss)

    def contact_power(inputs: FilmInputs) -> float:
        """Compute the friction power of all contacts for inputs of the law [W]."""
        return sum(losses.contact_powers(inputs).values())

    return extrapolate_losses(reducer, contact_power, growth, samples)


def assumptions(reducer: RvReducer) -> tuple[str, ...]:
    """Return the assumptions behind the static data-sheet quantities of an RV reducer, a sentence each."""
    design = reducer.design
    return (
        "statics: parts are rigid, pins, planet teeth and crank bearings are springs with all clearances and "
        "manufacturing errors; no weight and no inertia",
        f"crank bearings: needles and taper in series, {reducer.bearing_stiffness:.4g} N/m and "
        f"{1e6 * reducer.bearing_clearance:.4g} um for each crank and disc; discs do not tilt",
        f"planet mesh: {reducer.mesh_stiffness:.4g} N/m along the line of action"
        + ("" if reducer.planet.mesh_stiffness else " (ISO 6336-1, method B)"),
        rv_film_assumption(reducer)
        if design.has_film
        else "friction: Coulomb friction of a running drive; none in figures without friction by name, backlash, lost "
        f"motion and stiffness; mesh {design.mesh_friction:g}, crank bearings {design.friction.cam_rolling:g}, "
        f"planets {reducer.planet.friction:g}",
        f"{SETTINGS.force_angles} crank angles over a turn of the carrier, {SETTINGS.error_angles} for the "
        f"transmission error, {SETTINGS.rotation_angles} for backlash, lost motion and stiffness",
        *part_notes(design),
    )
