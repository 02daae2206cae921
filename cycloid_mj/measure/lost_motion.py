"""Lost motion, torsional stiffness and friction's hysteresis: a slow torque loop at the output, the crank locked."""

from cycloid_mj.base.engine import Progress, each_in_threads, silent
from cycloid_mj.base.errors import RunError, UsageError
from cycloid_mj.base.names import SOLVERS
from cycloid_mj.design import Named, resolve
from cycloid_mj.dynamics.massless import assumptions, massless
from cycloid_mj.dynamics.run import Solver
from cycloid_mj.measure import bench, hysteresis
from cycloid_mj.measure.lost_motion_table import LostMotionLoops, by_angle, curves, quantities
from cycloid_mj.measure.measurement import Measurement
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.structure import structure_text
from cycloid_mj.statics.windup import Windup, windups

ANGLES, QUICK_ANGLES = 6, 2
SLOWER, FINER = 2.0, 4.0
"""The checks: a loop this many times as slow, and one at a step this many times shorter."""
LEFT_OUT = "statics is left out: it found no balance"


def lost_motion(
    design: Named,
    load: float | None = None,
    angles: int | None = None,
    quick: bool = False,
    progress: Progress = silent,
    solver: Solver = "planar",
) -> Measurement:
    """Measure lost motion, stiffness and hysteresis of a design at several locked crank angles.

    Parameters
    ----------
    design
        A design, or the name of a preset or a file: what to measure; its own load and speed do not matter.
    load
        Largest torque of the loop at the output [N m]; by default the rated input torque times the ratio.
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
        The rated torque is not positive, or there is no angle.
    RunError
        A run went wrong.
    """
    design = resolve(design)
    reducer = Reducer(design)
    rated = reducer.design.rated_torque if load is None else load
    angles = (QUICK_ANGLES if quick else ANGLES) if angles is None else angles
    if not rated > 0.0 or angles < 1:
        raise UsageError(f"cannot measure under {rated:g} N m at {angles} crank angles: both must be more than 0")
    reducer = reducer.working_at(rated)
    cranks = [float(crank) for crank in bench.crank_angles(reducer, angles)]
    period, level = hysteresis.slow_period(reducer, rated), bench.ideal(reducer)
    if solver == "planar":
        level = massless(level)
    # the longest first, so that no processor is left alone with one
    jobs = [(one, cranks[0], *check) for one in (reducer, level) for check in ((period, FINER), (SLOWER * period, 1.0))]
    jobs += [(one, crank, period, 1.0) for one in (reducer, level) for crank in cranks]
    loops = each_in_threads(lambda job: hysteresis.loop(job[0], job[1], rated, *job[2:], solver), jobs, progress)
    checks, loops = loops[:4], loops[4:]
    measured = LostMotionLoops(
        reducer, loops[:angles], loops[angles:], checks[:2], checks[2:], _statics(reducer, cranks, rated)
    )
    return Measurement(
        measure="lost-motion",
        design=reducer.design,
        condition=f"crank locked, up to {rated:.4g} N m on the output, {SOLVERS[solver]}",
        quantities=quantities(measured),
        curves=curves(measured),
        assumptions=_assumptions(measured, period, solver),
        runs={"loop": measured.service[0].run, "loop-ideal": measured.ideal[0].run},
        details={
            "nominal_torque_nm": rated,
            "rated_torque_nm": rated,
            "period_s": period,
            "angles": by_angle(measured),
        },
    )


def _statics(reducer: Reducer, cranks: list[float], rated: float) -> list[Windup]:
    """List the static solutions; none where statics finds no balance."""
    try:
        return windups(reducer, cranks, rated)
    except RunError:
        return []


def _assumptions(measured: LostMotionLoops, period: float, solver: Solver) -> tuple[str, ...]:
    steps = [bench.steps_text(loop.run for loop in loops) for loops in (measured.service, measured.ideal)]
    checks = [bench.steps_text([loops[0].run]) for loops in (measured.service_checks, measured.ideal_checks)]
    beyond = () if measured.statics else (LEFT_OUT,)
    return (
        f"the crank is locked; the torque at the output follows sin^5 over {1e3 * period:.3g} ms, up to "
        f"{measured.service[0].rated:.4g} N m (rated input torque times the ratio, unless given)",
        f"time step {steps[0]}, without friction and weight {steps[1]}; the numerical error is what a loop {SLOWER:g} "
        f"times as slow and one at a step of {checks[0]} and {checks[1]} change at the first crank angle, together, "
        "and what the crank angles leave out of the turn: by the backlash of rigid parts, and by the readings' scatter",
        "friction is viscous below the creep speed, which is as low as the step bears: with free pins the stiffness "
        "falls by some percent as the step does",
        structure_text(measured.reducer),
        f"contacts have the secant stiffness of one working force, that at the loop's end: "
        f"{measured.reducer.contacts.working_forces_text(measured.reducer.design.pair_kinds)}",
        *(assumptions(measured.reducer, "runs without friction and weight") if solver == "planar" else ()),
        *beyond,
    )
