"""Backlash of the output, from stop to stop at a locked crank: by all clearances and by each alone.

The output is pressed to either stop by two small torques; the line through both, drawn on to zero, is the stop of rigid
parts. Without friction and weight: friction would hold the parts on their way, weight press them to one side.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from cycloid_mj.analysis.transmission import output_error
from cycloid_mj.base.array import Array
from cycloid_mj.base.engine import Progress, each_in_threads, silent
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.names import SOLVERS
from cycloid_mj.base.record import Run
from cycloid_mj.base.result import Curve, Quantity, keyed
from cycloid_mj.base.units import ARCMINUTE
from cycloid_mj.design import Errors, Modification, Named, resolve
from cycloid_mj.dynamics.massless import assumptions, massless
from cycloid_mj.dynamics.run import Solver
from cycloid_mj.dynamics.settling import rotation_time
from cycloid_mj.measure import bench, rigid_backlash
from cycloid_mj.measure.measurement import Measurement
from cycloid_mj.measure.sampled import Known, added, error_of_extreme, error_of_mean
from cycloid_mj.reducer import Reducer, limits

ANGLES, QUICK_ANGLES = 8, 2
PRESS = 0.0025
"""The smaller torque as a share of the rated one; the other one is twice as large."""

LEVELS = (20.0, 2.0, 1.0, -20.0, -2.0, -1.0)
"""Torques, one after the other, in units of the smaller one; the large ones seat the parts."""

SETTLING = 4.0
"""Time for each torque, in times that it takes to carry output and gear over the play."""

PATIENCE = 4.0
"""How many times as long it takes until all parts have come to rest in all their plays together."""

READ = 0.25
"""Last share of that time, over which the turn is averaged."""

CLOSED_UP = 1e-10
"""Clearance [m] of the other pairs where one is measured alone."""

SAMPLES = 200
LONGER, FINER = 1.5, 1.5
"""The check: each torque this many times as long, at a step this many times shorter."""

COARSE = 0.5
"""By how much finer planar steps are than the bench's own: massless pins do not chatter, and only rest is read.

At 35 us against 17.5 us the mean of `pin` is 8e-6 larger; that of 54 sleeved pins with 20 um of play, which settle
late, 0.5 %, and nearer to the linear programme's.
"""

NAMES = {
    "pin_gear": "teeth on pins",
    "pin_socket": "pins in sockets",
    "pin_sleeve": "sleeves on pins",
    "tooth": "teeth",
    "cam": "cam",
    "output": "output pins",
}
_FORMULAS = {
    "cam": "2 delta/(c (N-1))",
    "output": "delta (1/max R sin beta + 1/max -R sin beta)",
}
_MESH_FORMULA = "delta (1/max l + 1/max -l), about 2 delta/(c (N-1))"
_ALL = "all"


@dataclass(frozen=True)
class Press:
    """The stops that one run found at a crank angle [rad]: the output's turns [rad], of rigid parts."""

    crank: float
    low: float
    high: float
    run: Run

    @property
    def backlash(self) -> float:
        """From stop to stop [rad]."""
        return self.high - self.low


def backlash(
    design: Named,
    angles: int | None = None,
    quick: bool = False,
    progress: Progress = silent,
    solver: Solver = "planar",
) -> Measurement:
    """Measure the backlash of a design at several locked crank angles, whole and by each clearance alone.

    Parameters
    ----------
    design
        A design, or the name of a preset or a file: what to measure; its own load, speed, friction and weight
        do not matter.
    angles
        How many crank angles, spread over the turn and over the mesh period; by default `ANGLES`.
    quick
        By default `QUICK_ANGLES`.
    progress
        Called after each run with how many are done, and how many there are.
    solver
        What takes the steps of the runs.

    Raises
    ------
    UsageError
        There is no angle.
    RunError
        A run went wrong, or the gear jams.
    """
    design = resolve(design)
    reducer = Reducer(design)
    angles = (QUICK_ANGLES if quick else ANGLES) if angles is None else angles
    if angles < 1:
        raise UsageError(f"cannot measure at {angles} crank angles: give 1 or more")
    reducer = reducer.at_rated_load
    cranks = [float(crank) for crank in bench.crank_angles(reducer, angles)]
    cases = {_ALL: bench.ideal(reducer)} | {kind: alone(reducer, kind) for kind in reducer.design.pair_kinds}
    if solver == "planar":
        cases = {name: massless(case) for name, case in cases.items()}
    longer = {name: PATIENCE if name == _ALL else 1.0 for name in cases}
    finer = COARSE if solver == "planar" and not design.settings.timestep else 1.0
    jobs = [(case, cranks[0], LONGER * longer[name], FINER * finer) for name, case in cases.items()]
    jobs += [(case, crank, longer[name], finer) for name, case in cases.items() for crank in cranks]
    runs = each_in_threads(lambda job: press(*job, solver), jobs, progress)
    checked = dict(zip(cases, runs, strict=False))
    rest = runs[len(cases) :]
    by_kind = {name: rest[place * angles : (place + 1) * angles] for place, name in enumerate(cases)}
    closed = _closed_forms(reducer, cranks)
    return Measurement(
        measure="backlash",
        design=reducer.design,
        condition=f"crank locked, without friction and weight, {SOLVERS[solver]}",
        quantities=keyed(_quantities(by_kind, checked, closed)),
        curves=_curves(reducer, by_kind, closed),
        assumptions=_assumptions(reducer, [press.run for presses in by_kind.values() for press in presses], solver),
        runs={name: presses[0].run for name, presses in by_kind.items()},
        details={"angles": _by_angle(by_kind, closed)},
    )


def alone(reducer: Reducer, kind: str) -> Reducer:
    """Return the design with the clearance of one kind of pairs alone, without errors, friction and weight."""
    design = reducer.design
    others = {other: CLOSED_UP for other in design.pair_kinds if other != kind}
    clearance = design.clearance.model_copy(update=others)
    output = design.output.model_copy(update={"hole_radius": design.output.pin_radius + design.gear.eccentricity})
    exact = {"clearance": clearance, "errors": Errors(), "modification": Modification(), "output": output}
    return bench.ideal(Reducer(design.model_copy(update=exact)))


def press(reducer: Reducer, crank: float, longer: float = 1.0, finer: float = 1.0, solver: Solver = "planar") -> Press:
    """Press the output of a design without friction and weight to both stops, at a crank angle [rad].

    `longer` multiplies the time, `finer` divides the step.
    """
    torque = PRESS * reducer.design.rated_torque
    dwell = longer * SETTLING * rotation_time(reducer, limits.widest_play(reducer, crank), torque)
    levels = torque * np.array(LEVELS)

    def signal(time: Array) -> Array:
        return levels[np.minimum(time / dwell, len(LEVELS) - 0.5).astype(int)]

    largest, duration, samples = max(LEVELS) * torque, len(LEVELS) * dwell, len(LEVELS) * SAMPLES
    run = bench.run_to_the_end(reducer, crank, signal, largest, duration, samples, finer, solver)
    turn, phase = output_error(run, reducer), run.time / dwell
    ends = [float(turn[(phase > n + 1 - READ) & (phase < n + 1)].mean()) for n in range(len(LEVELS))]
    return Press(crank, low=2.0 * ends[5] - ends[4], high=2.0 * ends[2] - ends[1], run=run)


def _closed_forms(reducer: Reducer, cranks: list[float]) -> dict[str, Known]:
    """Collect the backlash [rad] by the closed forms, whole and by each clearance alone; none of a preloaded ring."""
    if reducer.design.ring.preload:
        return {}
    turn = rigid_backlash.turn(reducer)
    closed_forms = {}
    if rigid_backlash.has_linear_gaps(reducer):
        closed_forms[_ALL] = Known(
            rigid_backlash.total(reducer, np.array(cranks)), rigid_backlash.over_a_turn(reducer)[1]
        )
    for kind in reducer.design.pair_kinds:
        single = alone(reducer, kind)
        sampled, whole = (rigid_backlash.parts_alone(single, way)[kind] for way in (np.array(cranks), turn))
        closed_forms[kind] = Known(sampled, whole)
    return closed_forms


def _quantities(
    by_kind: dict[str, list[Press]], checked: dict[str, Press], closed: dict[str, Known]
) -> Iterator[Quantity]:
    parts = []
    for name, presses in by_kind.items():
        values, known = np.array([press.backlash for press in presses]), closed.get(name)
        numerical = abs(checked[name].backlash - presses[0].backlash)
        error = _arcminutes(added(numerical, error_of_mean(values, known)))
        reference = None if known is None else float(known.turn.mean()) / ARCMINUTE
        mean = float(values.mean()) / ARCMINUTE
        if name == _ALL:
            source = "" if known is None else "rigid contacts: linear programme"
            yield Quantity("backlash", "backlash of the output, mean", mean, "arcmin", error, reference, source)
            for word, largest in (("least", False), ("largest", True)):
                statistic = np.max if largest else np.min
                yield Quantity(
                    "backlash_max" if largest else "backlash_min",
                    f"backlash, {word} over the crank angle",
                    float(statistic(values)) / ARCMINUTE,
                    "arcmin",
                    _arcminutes(added(numerical, error_of_extreme(values, largest, known))),
                    None if known is None else float(statistic(known.turn)) / ARCMINUTE,
                    source,
                )
        else:
            label, source = f"by clearance of {NAMES[name]} alone, mean", _FORMULAS.get(name, _MESH_FORMULA)
            parts.append(Quantity(f"backlash_{name}", label, mean, "arcmin", error, reference, source))
    yield from parts
    yield Quantity(
        "sum_of_parts",
        "sum of the parts",
        sum(part.value for part in parts),
        "arcmin",
        added(*(part.error for part in parts)),
        note="less than the whole: clearances together let the gear move in ways that none allows alone",
    )


def _arcminutes(error: float | None) -> float | None:
    return None if error is None else error / ARCMINUTE


def _curves(reducer: Reducer, by_kind: dict[str, list[Press]], closed: dict[str, Known]) -> tuple[Curve, ...]:
    drawn = []
    axes = "crank angle [deg]", "backlash [arcmin]"
    for name, presses in by_kind.items():
        panel = "all clearances" if name == _ALL else f"clearance of {NAMES[name]} alone"
        crank = np.degrees([press.crank for press in presses])
        if name in closed:
            turn = np.degrees(rigid_backlash.turn(reducer))
            drawn.append(Curve(panel, "closed form", turn, closed[name].turn / ARCMINUTE, *axes, "theory"))
        values = np.array([press.backlash for press in presses]) / ARCMINUTE
        drawn.append(Curve(panel, "simulated", crank, values, *axes, "points"))
    return tuple(drawn)


def _assumptions(reducer: Reducer, runs: list[Run], solver: Solver) -> tuple[str, ...]:
    torque = PRESS * reducer.design.rated_torque
    return (
        f"the crank is locked; the output is pressed to its stops by {torque:.2g} and {2.0 * torque:.2g} N m, and the "
        "line through both turns is drawn on to zero",
        "without friction and weight; see lost-motion for what they do",
        "contacts are as stiff as under the rated load, which the line drawn on to zero takes out: "
        f"{reducer.contacts.working_forces_text(reducer.design.pair_kinds)}",
        f"a clearance alone: the others {1e6 * CLOSED_UP:g} um, no manufacturing errors, no modification",
        f"time step {bench.steps_text(runs)}; the numerical error is what {LONGER:g} times the time at a step "
        f"{FINER:g} times shorter changes at the first crank angle, and "
        "what the angles leave out of the turn: by the closed form, and by the scatter of what that does not explain",
        *(assumptions(reducer, "all runs") if solver == "planar" else ()),
    )


def _by_angle(by_kind: dict[str, list[Press]], closed: dict[str, Known]) -> list[dict[str, Any]]:
    return [
        {
            "crank_angle_deg": math.degrees(one.crank),
            "low_arcmin": one.low / ARCMINUTE,
            "high_arcmin": one.high / ARCMINUTE,
            "backlash_arcmin": {name: presses[place].backlash / ARCMINUTE for name, presses in by_kind.items()},
            "timestep_s": {name: bench.step_of(presses[place].run) for name, presses in by_kind.items()},
            "closed_form_arcmin": {name: float(known.sampled[place]) / ARCMINUTE for name, known in closed.items()},
        }
        for place, one in enumerate(by_kind[_ALL])
    ]
