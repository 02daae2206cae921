"""Quantities and curves of `lost_motion` from its loops and static solutions."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.result import Curve, Quantity, by_key
from cycloid_mj.base.units import ARCMINUTE
from cycloid_mj.measure import bench, rigid_backlash
from cycloid_mj.measure.hysteresis import HysteresisLoop
from cycloid_mj.measure.sampled import Known, add_errors, error_of_extreme, error_of_mean, extreme_quantities
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.windup import LOST_MOTION_SHARE, SERIES, Windup, split_in_series

STATICS, RIGID = "statics: springs in balance", "rigid contacts: linear programme"
IDEAL = "without friction and weight"
BY_WAY = "by the relative motion of the parts; the compliance of each spring is listed by statics"
_PARTS = {"output": "output pins", "cam": "cam", "mesh": "teeth, pins and sockets"}
_OF_SPRINGS = {**_PARTS, "output": "output pins, including bending and twisting parts"}

Loops = list[HysteresisLoop]
Reading = Callable[[HysteresisLoop], float]


@dataclass(frozen=True, eq=False)
class LostMotionLoops:
    """Loops and static solutions at some crank angles.

    Attributes
    ----------
    design
        The drive.
    service, ideal
        Loops of the design as it is, and without friction and weight, one for each crank angle.
    service_checks, ideal_checks
        Loops at the first crank angle, slower and with a shorter time step, for the numerical error.
    statics
        One for each crank angle; none where statics find no balance.
    """

    reducer: Reducer
    service: list[HysteresisLoop]
    ideal: list[HysteresisLoop]
    service_checks: list[HysteresisLoop]
    ideal_checks: list[HysteresisLoop]
    statics: list[Windup]


def quantities(measured: LostMotionLoops) -> dict[str, Quantity]:
    """Collect all quantities of the measurement."""
    return by_key(_motions(measured), _stiffness(measured), _friction(measured))


def _quantity(
    key: str,
    name: str,
    read: Reading,
    loops: Loops,
    checks: Loops,
    unit: str = "arcmin",
    closed: Sequence[float] | Array = (),
    source: str = "",
    note: str = "",
    known: Known | None = None,
) -> Quantity:
    """Compute the mean of a reading over the crank angles; `known` is for the error of the mean over the turn."""
    reference = float(np.mean(closed)) if len(closed) else None
    values = [read(loop) for loop in loops]
    error = add_errors(_error(read, loops, checks), error_of_mean(values, known))
    return Quantity(key, name, float(np.mean(values)), unit, error, reference, source if len(closed) else "", note)


def _error(read: Reading, loops: Loops, checks: Loops) -> float:
    """Compute the sum of the changes of a reading at the first crank angle with each check."""
    return sum(abs(read(check) - read(loops[0])) for check in checks)


def _extremes(
    key: str, name: str, read: Reading, loops: Loops, checks: Loops, unit: str, known: Known | None = None
) -> list[Quantity]:
    """List the smallest and the largest of a reading over the crank angles."""
    values, numerical = [read(loop) for loop in loops], _error(read, loops, checks)
    return list(extreme_quantities(key, name, values, numerical, unit, known=known))


def lost_motion(loop: HysteresisLoop) -> float:
    """Compute the lost motion at +-3 % of the nominal torque [arcmin]."""
    return loop.lost_motion / ARCMINUTE


def offset(loop: HysteresisLoop) -> float:
    """Compute the middle of the loop [rad]."""
    return loop.offset


def stiffness(loop: HysteresisLoop) -> float:
    """Compute the torsional stiffness [N m/arcmin]."""
    return loop.stiffness * ARCMINUTE


def _motions(measured: LostMotionLoops) -> Iterator[Quantity]:
    """Yield lost motion and backlash, as designed and without friction and weight."""
    solved = [windup.lost_motion / ARCMINUTE for windup in measured.statics]
    known = _rigid(measured)
    rigid = known.turn if known is not None else ()
    loops = {"": (measured.service, measured.service_checks), "_ideal": (measured.ideal, measured.ideal_checks)}
    for suffix, pair in loops.items():
        case = f", {IDEAL}" if suffix else ""
        label = f"lost motion at +-3 % of nominal torque{case}"
        yield _quantity("lost_motion" + suffix, label, lost_motion, *pair, closed=solved, source=STATICS, known=known)
        if not suffix:
            yield from _extremes("lost_motion", "lost motion", lost_motion, *pair, "arcmin", known)
        name = f"backlash{case}"
        backlash = "backlash" + suffix
        yield _quantity(
            backlash, name, lambda loop: loop.backlash / ARCMINUTE, *pair, closed=rigid, source=RIGID, known=known
        )


def _rigid(measured: LostMotionLoops) -> Known | None:
    """Return the backlash of rigid parts [arcmin] at the crank angles and over the turn; lost motion varies with it."""
    if measured.reducer.design.ring.preload or not rigid_backlash.has_linear_gaps(measured.reducer):
        return None
    cranks = np.array([loop.crank for loop in measured.service])
    return Known(
        rigid_backlash.total_backlash(measured.reducer, cranks) / ARCMINUTE,
        rigid_backlash.backlash_over_turn(measured.reducer)[1] / ARCMINUTE,
    )


def _stiffness(measured: LostMotionLoops) -> Iterator[Quantity]:
    """Yield the torsional stiffness and the compliances of its parts."""
    unit = "N m/arcmin"
    solved = [ARCMINUTE / item.compliance(item.turn) for item in measured.statics]
    name = "torsional stiffness, 50 to 100 % of nominal torque"
    note = "friction holds the parts where the torque reverses, which makes the curve steeper there"
    pair, ideal = (measured.service, measured.service_checks), (measured.ideal, measured.ideal_checks)
    yield _quantity("stiffness", name, stiffness, *pair, unit, solved, STATICS, note)
    yield from _extremes("stiffness", "stiffness", stiffness, *pair, unit)
    yield _quantity("stiffness_ideal", f"{name}, {IDEAL}", stiffness, *ideal, unit, solved, STATICS)
    called = _OF_SPRINGS if measured.reducer.design.structure == "springs" else _PARTS
    for part in SERIES:
        closed = [item.series(measured.reducer)[part] / ARCMINUTE for item in measured.statics]

        def compliance(loop: HysteresisLoop, part: str = part) -> float:
            return loop_series(measured.reducer, loop)[part] / ARCMINUTE

        name = f"compliance by the motion of {called[part]}, {IDEAL}"
        yield _quantity(f"compliance_{part}", name, compliance, *ideal, "arcmin/(N m)", closed, STATICS, BY_WAY)


def loop_series(reducer: Reducer, loop: HysteresisLoop) -> dict[str, float]:
    """Compute the compliance of each part in series [rad/(N m)] by a loop, keyed by `SERIES`."""
    return split_in_series(
        reducer, loop.compliance(), loop.compliance(loop.gear_turn), loop.compliance(loop.centre_lead)
    )


def _friction(measured: LostMotionLoops) -> list[Quantity]:
    """List width, work and shift of the loop."""
    pair, width = (measured.service, measured.service_checks), "width of the loop at half the nominal torque"
    damped = float(np.mean([loop.width for loop in measured.ideal])) / ARCMINUTE
    viscous = (
        f"friction, and {damped:.2g} arcmin of damping, which vanishes in slower loops; friction is viscous below the "
        "creep speed, which is as low as the time step allows: free pins roll, and their sliding speeds are below it"
    )
    shifts = [abs(a.offset - b.offset) / ARCMINUTE for a, b in zip(measured.service, measured.ideal, strict=True)]
    numerical = (_error(offset, *pair) + _error(offset, measured.ideal, measured.ideal_checks)) / ARCMINUTE
    return [
        _quantity("hysteresis", width, lambda loop: loop.width / ARCMINUTE, *pair, note=viscous),
        _quantity(
            "loop_work",
            "work of one loop",
            lambda loop: 1e3 * loop.work,
            *pair,
            "mJ",
            [1e3 * loop.dissipation for loop in measured.service],
            "friction and damping, logged",
            "the area is the result; the logged powers of light free pins may differ where the time step does not "
            "resolve them",
        ),
        Quantity(
            "shift",
            "shift of the loop by weight and friction, largest",
            max(shifts),
            "arcmin",
            add_errors(numerical, error_of_extreme(shifts, True)),
            note="the weight of the disc turns it about the pitch point; the lock of the crank supports it",
        ),
    ]


def curves(measured: LostMotionLoops) -> tuple[Curve, ...]:
    """List the loop at the first crank angle, in full and near zero, and the readings over the crank angle."""
    loop, ideal = measured.service[0], measured.ideal[0]
    torque, turn = "torque [N m]", "turn [arcmin]"
    near = np.abs(loop.torque) <= 3.0 * LOST_MOTION_SHARE * loop.rated
    title = f"hysteresis, crank at {np.degrees(loop.crank):.1f}°"
    drawn = [
        Curve(title, "no friction", ideal.torque, ideal.turn / ARCMINUTE, torque, turn, "theory"),
        Curve(title, "as designed", loop.torque, loop.turn / ARCMINUTE, torque, turn),
        Curve("near zero torque", "as designed", loop.torque[near], loop.turn[near] / ARCMINUTE, torque, turn),
    ]
    marks = LOST_MOTION_SHARE * loop.rated * np.array([-1.0, 1.0])
    middles = np.array([loop.middle(LOST_MOTION_SHARE, side) for side in (-1, 1)]) / ARCMINUTE
    drawn.append(Curve("near zero torque", "±3 %", marks, middles, torque, turn, "points"))
    if measured.statics:
        shares = sorted(measured.statics[0].turn)
        turns = np.array([measured.statics[0].turn[share] for share in shares]) / ARCMINUTE
        drawn.append(Curve(title, "statics", np.array(shares) * loop.rated, turns, torque, turn, "points"))
    crank = np.degrees([item.crank for item in measured.service])
    over_angle = {
        ("lost motion at ±3 %", "arcmin"): (lost_motion, [item.lost_motion / ARCMINUTE for item in measured.statics]),
        ("stiffness", "N m/arcmin"): (stiffness, [ARCMINUTE / item.compliance(item.turn) for item in measured.statics]),
    }
    known = _rigid(measured)
    for (panel, unit), (read, solved) in over_angle.items():
        axes = "crank angle [deg]", f"{panel.split(' at')[0]} [{unit}]"
        if read is lost_motion and known is not None:
            everywhere = np.degrees(rigid_backlash.turn_angles(measured.reducer))
            drawn.append(Curve(panel, "backlash of rigid parts", everywhere, known.turn, *axes, "theory"))
        if solved:
            drawn.append(Curve(panel, "statics", crank, np.array(solved), *axes, "rings"))
        for name, loops in (("as designed", measured.service), ("no friction", measured.ideal)):
            drawn.append(Curve(panel, name, crank, np.array([read(item) for item in loops]), *axes, "points"))
    return tuple(drawn)


def by_angle(measured: LostMotionLoops) -> list[dict[str, Any]]:
    """Convert the readings at each crank angle to JSON values."""
    rows: list[dict[str, Any]] = []
    for index, (service, ideal) in enumerate(zip(measured.service, measured.ideal, strict=True)):
        row: dict[str, Any] = {"crank_angle_deg": float(np.degrees(service.crank))}
        for name, loop in (("service", service), ("ideal", ideal)):
            row[name] = {
                "lost_motion_arcmin": lost_motion(loop),
                "stiffness_nm_per_arcmin": stiffness(loop),
                "backlash_arcmin": loop.backlash / ARCMINUTE,
                "hysteresis_arcmin": loop.width / ARCMINUTE,
                "timestep_s": bench.step_of(loop.run),
            }
        if measured.statics:
            solved = measured.statics[index]
            row["statics"] = {
                "lost_motion_arcmin": solved.lost_motion / ARCMINUTE,
                "stiffness_nm_per_arcmin": ARCMINUTE / solved.compliance(solved.turn),
            }
        rows.append(row)
    return rows
