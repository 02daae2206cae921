"""Quantities and curves of `lost_motion` from its loops and static solutions."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.result import Curve, Quantity, by_key
from cycloid_mj.base.units import ARCMINUTE
from cycloid_mj.design.layouts import Layout
from cycloid_mj.measure import bench, rigid_backlash
from cycloid_mj.measure.hysteresis import LOOP, HysteresisLoop
from cycloid_mj.measure.sampled import ClosedForm, add_errors, error_of_extreme, error_of_mean, extreme_quantities
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.statics.rv_motion import rv_backlash
from cycloid_mj.statics.windup import LOST_MOTION_SHARE, SERIES, Windup, split_in_series

STATICS, RIGID = "statics: springs in balance", "rigid contacts: linear programme"
STATIC_STOPS = "statics, extrapolated to zero torque"
IDEAL = "without friction and weight"
MOTION_NOTE = "by the relative motion of the parts; the compliance of each spring is listed by statics"
_PART_NAMES = {"output": "output pins", "cam": "cam", "mesh": "teeth, pins and sockets"}
SERIES_BY_LAYOUT: Mapping[Layout, tuple[str, ...]] = {"central": SERIES, "rv": ()}
"""Parts in series whose compliances are listed, for each layout."""
_SPRING_PART_NAMES = {**_PART_NAMES, "output": "output pins, including bending and twisting parts"}

Loops = list[HysteresisLoop]
Reading = Callable[[HysteresisLoop], float]


@dataclass(frozen=True, eq=False)
class LostMotionLoops:
    """Loops and static solutions at some crank angles.

    Attributes
    ----------
    reducer
        The drive.
    service, ideal
        Loops of the design as it is, and without friction and weight, one for each crank angle.
    service_checks, ideal_checks
        Loops at the first crank angle, slower and with a shorter time step, for the numerical error.
    statics
        One for each crank angle; none where statics find no equilibrium.
    """

    reducer: Reducer
    service: list[HysteresisLoop]
    ideal: list[HysteresisLoop]
    service_checks: list[HysteresisLoop]
    ideal_checks: list[HysteresisLoop]
    statics: list[Windup]


def quantities(measured: LostMotionLoops) -> dict[str, Quantity]:
    """Collect all quantities of the measurement."""
    return by_key(_lost_motion_quantities(measured), _stiffness_quantities(measured), _friction_quantities(measured))


def _mean_quantity(
    key: str,
    name: str,
    read_value: Reading,
    loops: Loops,
    check_loops: Loops,
    unit: str = "arcmin",
    reference_values: Sequence[float] | Array = (),
    source: str = "",
    note: str = "",
    closed_form: ClosedForm | None = None,
) -> Quantity:
    """Return the mean over the crank angles of a value read from each torque loop, with errors and reference.

    Parameters
    ----------
    key, name, unit, source, note
        Attributes of the resulting quantity; `source` is the source of the reference.
    read_value
        Function that reads the value from a loop, in `unit`.
    loops
        Loops, one per crank angle.
    check_loops
        Loops at the first crank angle with other settings, for the numerical error.
    reference_values
        Reference at some crank angles, whose mean is the reference of the result; empty for none.
    closed_form
        Closed form that approximates the values, for the sampling error of the mean over the turn.
    """
    reference = float(np.mean(reference_values)) if len(reference_values) else None
    loop_values = [read_value(loop) for loop in loops]
    error = add_errors(_numerical_error(read_value, loops, check_loops), error_of_mean(loop_values, closed_form))
    return Quantity(
        key, name, float(np.mean(loop_values)), unit, error, reference, source if len(reference_values) else "", note
    )


def _numerical_error(read_value: Reading, loops: Loops, check_loops: Loops) -> float:
    """Return the sum of the changes of a reading at the first crank angle with each check loop."""
    return sum(abs(read_value(check) - read_value(loops[0])) for check in check_loops)


def _extreme_quantities(
    key: str,
    name: str,
    read_value: Reading,
    loops: Loops,
    check_loops: Loops,
    unit: str,
    closed_form: ClosedForm | None = None,
) -> list[Quantity]:
    """Return the smallest and the largest value over the crank angles read from the torque loops, with errors.

    `read_value` reads the value from a loop, in `unit`; `loops` are one per crank angle, `check_loops` those at the
    first angle with other settings, for the numerical error. The keys and names of both quantities begin with `key` and
    `name`. `closed_form` approximates the values, for the sampling error.
    """
    loop_values, numerical_error = (
        [read_value(loop) for loop in loops],
        _numerical_error(read_value, loops, check_loops),
    )
    return list(extreme_quantities(key, name, loop_values, numerical_error, unit, closed_form=closed_form))


def lost_motion(loop: HysteresisLoop) -> float:
    """Compute the lost motion at +-3 % of the nominal torque [arcmin]."""
    return loop.lost_motion / ARCMINUTE


def offset(loop: HysteresisLoop) -> float:
    """Compute the middle of the loop [rad]."""
    return loop.offset


def stiffness(loop: HysteresisLoop) -> float:
    """Compute the torsional stiffness [N m/arcmin]."""
    return loop.stiffness * ARCMINUTE


def _lost_motion_quantities(data: LostMotionLoops) -> Iterator[Quantity]:
    """Yield lost motion and backlash [arcmin] that are read from the simulated torque loops of a drive.

    Both are evaluated for the drive as designed, and again without friction and weight. `data` are the simulated torque
    loops.
    """
    static_values = [windup.lost_motion / ARCMINUTE for windup in data.statics]
    rigid_form = BACKLASH[data.reducer.LAYOUT](data)
    rigid_values, rigid_source = (rigid_form.turn, rigid_form.source) if rigid_form is not None else ((), "")
    loops = {"": (data.service, data.service_checks), "_ideal": (data.ideal, data.ideal_checks)}
    for suffix, loop_sets in loops.items():
        case_text = f", {IDEAL}" if suffix else ""
        label = f"lost motion at +-3 % of nominal torque{case_text}"
        yield _mean_quantity(
            "lost_motion" + suffix,
            label,
            lost_motion,
            *loop_sets,
            reference_values=static_values,
            source=STATICS,
            closed_form=rigid_form,
        )
        if not suffix:
            yield from _extreme_quantities("lost_motion", "lost motion", lost_motion, *loop_sets, "arcmin", rigid_form)
        name = f"backlash{case_text}"
        backlash_key = "backlash" + suffix
        yield _mean_quantity(
            backlash_key,
            name,
            lambda loop: loop.backlash / ARCMINUTE,
            *loop_sets,
            reference_values=rigid_values,
            source=rigid_source,
            closed_form=rigid_form,
        )


def _rigid_backlash(data: LostMotionLoops) -> ClosedForm | None:
    """Return the backlash of rigid parts [arcmin], at the crank angles and over the turn; it approximates lost motion.

    None where the linear programme is not valid: a preloaded ring, or modified flanks. `data` are the simulated torque
    loops.
    """
    if data.reducer.design.ring.preload or not rigid_backlash.has_linear_gaps(data.reducer):
        return None
    crank_angles = np.array([loop.crank for loop in data.service])
    return ClosedForm(
        rigid_backlash.total_backlash(data.reducer, crank_angles) / ARCMINUTE,
        rigid_backlash.backlash_over_turn(data.reducer)[1] / ARCMINUTE,
        RIGID,
    )


def _static_backlash(data: LostMotionLoops) -> ClosedForm | None:
    """Return the backlash of an RV reducer by statics [arcmin], at the crank angles of the loops and over the turn.

    It is extrapolated to zero torque; the smaller of its two torques is the smallest at which the unloading branch of
    the torque loop is evaluated (`LOOP.unloading`). `data` are the simulated torque loops.
    """
    assert isinstance(data.reducer, RvReducer)
    torque = LOOP.unloading[0] * data.service[0].rated
    sampled_backlash, turn_backlash = (
        rv_backlash(data.reducer, crank_angles, torque) / ARCMINUTE
        for crank_angles in ([loop.crank for loop in data.service], rigid_backlash.full_turn_angles(data.reducer))
    )
    return ClosedForm(sampled_backlash, turn_backlash, STATIC_STOPS)


BACKLASH: Mapping[Layout, Callable[[LostMotionLoops], ClosedForm | None]] = {
    "central": _rigid_backlash,
    "rv": _static_backlash,
}
"""Function that computes the backlash without simulation for each layout."""

BACKLASH_NAMES: Mapping[Layout, str] = {"central": "backlash of rigid parts", "rv": "backlash by statics"}
"""Its name in the figure."""


def _stiffness_quantities(data: LostMotionLoops) -> Iterator[Quantity]:
    """Yield the torsional stiffness [N m/arcmin], and the compliances of output, cam and mesh in series [arcmin/(N m)].

    The stiffness is evaluated for the drive as designed, and again without friction and weight; the compliances only
    without friction and weight. An RV reducer, whose parts are not in series, has none. `data` are the simulated torque
    loops.
    """
    unit = "N m/arcmin"
    static_values = [ARCMINUTE / windup.compliance(windup.turn) for windup in data.statics]
    name = "torsional stiffness, 50 to 100 % of nominal torque"
    note = "friction holds the parts where the torque reverses, which makes the curve steeper there"
    service_loops, ideal_loops = (data.service, data.service_checks), (data.ideal, data.ideal_checks)
    yield _mean_quantity("stiffness", name, stiffness, *service_loops, unit, static_values, STATICS, note)
    yield from _extreme_quantities("stiffness", "stiffness", stiffness, *service_loops, unit)
    yield _mean_quantity("stiffness_ideal", f"{name}, {IDEAL}", stiffness, *ideal_loops, unit, static_values, STATICS)
    part_names = _SPRING_PART_NAMES if data.reducer.design.structure == "springs" else _PART_NAMES
    for part in SERIES_BY_LAYOUT[data.reducer.LAYOUT]:
        static_compliances = [windup.series(data.reducer)[part] / ARCMINUTE for windup in data.statics]

        def compliance(loop: HysteresisLoop, part: str = part) -> float:
            return loop_series(data.reducer, loop)[part] / ARCMINUTE

        name = f"compliance by the motion of {part_names[part]}, {IDEAL}"
        yield _mean_quantity(
            f"compliance_{part}",
            name,
            compliance,
            *ideal_loops,
            "arcmin/(N m)",
            static_compliances,
            STATICS,
            MOTION_NOTE,
        )


def loop_series(reducer: Reducer, loop: HysteresisLoop) -> dict[str, float]:
    """Compute the compliance of each part in series [rad/(N m)] by a loop, keyed by `SERIES`."""
    return split_in_series(
        reducer, loop.compliance(), loop.compliance(loop.gear_turn), loop.compliance(loop.centre_lead)
    )


def _friction_quantities(data: LostMotionLoops) -> list[Quantity]:
    """Return the quantities of the torque loops that friction causes: width, work, and shift.

    The width of the loop [arcmin] is taken at half the nominal torque. Width and work [mJ], the area inside a loop, are
    means over the crank angles. The shift [arcmin] is the distance between the middles of the loops with and without
    weight and friction, the largest over the crank angles. `data` are the simulated torque loops.
    """
    service_loops, width_name = (data.service, data.service_checks), "width of the loop at half the nominal torque"
    damping_width = float(np.mean([loop.width for loop in data.ideal])) / ARCMINUTE
    width_note = (
        f"friction, and {damping_width:.2g} arcmin of damping, which vanishes in slower loops; friction is viscous "
        "below the creep speed, which is as low as the time step allows: free pins roll, and their sliding speeds are "
        "below it"
    )
    shifts = [
        abs(service_loop.offset - ideal_loop.offset) / ARCMINUTE
        for service_loop, ideal_loop in zip(data.service, data.ideal, strict=True)
    ]
    numerical_error = (
        _numerical_error(offset, *service_loops) + _numerical_error(offset, data.ideal, data.ideal_checks)
    ) / ARCMINUTE
    return [
        _mean_quantity("hysteresis", width_name, lambda loop: loop.width / ARCMINUTE, *service_loops, note=width_note),
        _mean_quantity(
            "loop_work",
            "work of one loop",
            lambda loop: 1e3 * loop.work,
            *service_loops,
            "mJ",
            [1e3 * loop.dissipation for loop in data.service],
            "friction and damping, logged",
            "the area is the result; the logged powers of light free pins may differ where the time step does not "
            "resolve them",
        ),
        Quantity(
            "shift",
            "shift of the loop by weight and friction, largest",
            max(shifts),
            "arcmin",
            add_errors(numerical_error, error_of_extreme(shifts, True)),
            note="the weight of the disc turns it about the pitch point; the locked shaft supports it",
        ),
    ]


def curves(data: LostMotionLoops) -> tuple[Curve, ...]:
    """Return curves of the torque loop at the first crank angle, and of lost motion and stiffness over the angle.

    The loop is drawn as a whole, and its part near zero torque once more. `data` are the simulated torque loops; curves
    of statics and of the backlash of rigid parts are omitted if `data` lacks them.
    """
    service_loop, ideal_loop = data.service[0], data.ideal[0]
    x_label, y_label = "torque [N m]", "turn [arcmin]"
    is_near_zero = np.abs(service_loop.torque) <= 3.0 * LOST_MOTION_SHARE * service_loop.rated
    title = f"hysteresis, crank at {np.degrees(service_loop.crank):.1f}°"
    curve_list = [
        Curve(title, "no friction", ideal_loop.torque, ideal_loop.turn / ARCMINUTE, x_label, y_label, "theory"),
        Curve(title, "as designed", service_loop.torque, service_loop.turn / ARCMINUTE, x_label, y_label),
        Curve(
            "near zero torque",
            "as designed",
            service_loop.torque[is_near_zero],
            service_loop.turn[is_near_zero] / ARCMINUTE,
            x_label,
            y_label,
        ),
    ]
    mark_torques = LOST_MOTION_SHARE * service_loop.rated * np.array([-1.0, 1.0])
    mark_turns = np.array([service_loop.read_middle(LOST_MOTION_SHARE, sign) for sign in (-1, 1)]) / ARCMINUTE
    curve_list.append(Curve("near zero torque", "±3 %", mark_torques, mark_turns, x_label, y_label, "points"))
    if data.statics:
        torque_shares = sorted(data.statics[0].turn)
        turns = np.array([data.statics[0].turn[share] for share in torque_shares]) / ARCMINUTE
        curve_list.append(
            Curve(title, "statics", np.array(torque_shares) * service_loop.rated, turns, x_label, y_label, "points")
        )
    crank_deg = np.degrees([loop.crank for loop in data.service])
    panels = {
        ("lost motion at ±3 %", "arcmin"): (lost_motion, [windup.lost_motion / ARCMINUTE for windup in data.statics]),
        ("stiffness", "N m/arcmin"): (
            stiffness,
            [ARCMINUTE / windup.compliance(windup.turn) for windup in data.statics],
        ),
    }
    rigid_form = BACKLASH[data.reducer.LAYOUT](data)
    for (panel, unit), (read_value, static_values) in panels.items():
        labels = "crank angle [deg]", f"{panel.split(' at')[0]} [{unit}]"
        if read_value is lost_motion and rigid_form is not None:
            turn_angles = np.degrees(rigid_backlash.full_turn_angles(data.reducer))
            curve_list.append(
                Curve(panel, BACKLASH_NAMES[data.reducer.LAYOUT], turn_angles, rigid_form.turn, *labels, "theory")
            )
        if static_values:
            curve_list.append(Curve(panel, "statics", crank_deg, np.array(static_values), *labels, "rings"))
        for name, loops in (("as designed", data.service), ("no friction", data.ideal)):
            curve_list.append(
                Curve(panel, name, crank_deg, np.array([read_value(loop) for loop in loops]), *labels, "points")
            )
    return tuple(curve_list)


def angle_rows(data: LostMotionLoops) -> list[dict[str, Any]]:
    """Return a JSON object for each crank angle, with the values that are read from its torque loops.

    Its keys are ``crank_angle_deg``, ``service`` (loop of the drive as designed) and ``ideal`` (loop without friction
    and weight), each with lost motion, stiffness, backlash and hysteresis by keys that end in the unit, and
    ``statics``, with lost motion and stiffness. `data` are the simulated torque loops.
    """
    rows: list[dict[str, Any]] = []
    for index, (service_loop, ideal_loop) in enumerate(zip(data.service, data.ideal, strict=True)):
        row: dict[str, Any] = {"crank_angle_deg": float(np.degrees(service_loop.crank))}
        for name, loop in (("service", service_loop), ("ideal", ideal_loop)):
            row[name] = {
                "lost_motion_arcmin": lost_motion(loop),
                "stiffness_nm_per_arcmin": stiffness(loop),
                "backlash_arcmin": loop.backlash / ARCMINUTE,
                "hysteresis_arcmin": loop.width / ARCMINUTE,
                "timestep_s": bench.timestep_of(loop.run),
            }
        if data.statics:
            statics = data.statics[index]
            row["statics"] = {
                "lost_motion_arcmin": statics.lost_motion / ARCMINUTE,
                "stiffness_nm_per_arcmin": ARCMINUTE / statics.compliance(statics.turn),
            }
        rows.append(row)
    return rows
