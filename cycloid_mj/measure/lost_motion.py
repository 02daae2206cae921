"""Lost motion, torsional stiffness and hysteresis by a slow torque loop at the output, with locked crank."""

from cycloid_mj.base.engine import Progress, each_in_threads, silent
from cycloid_mj.base.errors import RunError, UsageError
from cycloid_mj.base.names import SOLVERS
from cycloid_mj.base.notebook_progress import shows_progress
from cycloid_mj.design import Named, resolve
from cycloid_mj.dynamics.massless import assumptions, massless
from cycloid_mj.dynamics.run import Solver
from cycloid_mj.measure import bench, hysteresis
from cycloid_mj.measure.lost_motion_table import LostMotionLoops, by_angle, curves, quantities
from cycloid_mj.measure.measurement import Measurement
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.structure import structure_text
from cycloid_mj.statics.windup import Windup, solve_windups

ANGLES, QUICK_ANGLES = 6, 2
SLOWER, FINER = 2.0, 4.0
"""Factors of the checks: a slower loop, and a loop with a shorter time step."""
LEFT_OUT = "no values by statics: no static balance was found"


@shows_progress
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
        A design, or the name of a preset or a file; its load and speed do not matter.
    load
        Largest torque of the loop at the output [N m]; by default the rated input torque times the ratio.
    angles
        Number of crank angles, spread over the turn and over the mesh period; by default `ANGLES`.
    quick
        Whether the default is `QUICK_ANGLES`.
    progress, solver
        Called after each run with the numbers of finished and of all runs; solver of the runs.

    Returns
    -------
    Measurement
        Figures with their numerical errors and closed forms, curves and tables.

    Raises
    ------
    UsageError
        The torque or the number of angles is not positive.
    RunError
        A run failed.
    """
    reducer = Reducer(resolve(design))
    rated = reducer.design.rated_torque if load is None else load
    angles = (QUICK_ANGLES if quick else ANGLES) if angles is None else angles
    if not rated > 0.0 or angles < 1:
        raise UsageError(
            f"the torque is {rated:g} N m and the number of crank angles is {angles}: give a torque greater than 0 N m "
            "and at least 1 crank angle"
        )
    reducer = reducer.working_at(rated)
    cranks = [float(crank) for crank in bench.crank_angles(reducer, angles)]
    period, level = hysteresis.slow_period(reducer, rated), bench.without_friction(reducer)
    if solver == "planar":
        level = massless(level)
    # the longest first, so that no processor waits for one at the end
    settings = ((period, FINER), (SLOWER * period, 1.0))
    jobs = [(drive, cranks[0], *setting) for drive in (reducer, level) for setting in settings]
    jobs += [(drive, crank, period, 1.0) for drive in (reducer, level) for crank in cranks]
    loops = each_in_threads(lambda job: hysteresis.loop(job[0], job[1], rated, *job[2:], solver), jobs, progress)
    checks, loops = loops[:4], loops[4:]
    measured = LostMotionLoops(
        reducer, loops[:angles], loops[angles:], checks[:2], checks[2:], _statics(reducer, cranks, rated)
    )
    loop = {"nominal_torque_nm": rated, "rated_torque_nm": rated, "period_s": period}
    return Measurement(
        measure="lost-motion",
        design=reducer.design,
        condition=f"crank locked, up to {rated:.4g} N m on the output, {SOLVERS[solver]}",
        quantities=quantities(measured),
        curves=curves(measured),
        assumptions=_assumptions(measured, period, solver),
        runs={"loop": measured.service[0].run, "loop-ideal": measured.ideal[0].run},
        details={**loop, "angles": by_angle(measured)},
    )


def _statics(reducer: Reducer, cranks: list[float], rated: float) -> list[Windup]:
    """List the static solutions; none where no balance exists."""
    try:
        return solve_windups(reducer, cranks, rated)
    except RunError:
        return []


def _assumptions(measured: LostMotionLoops, period: float, solver: Solver) -> tuple[str, ...]:
    """List the assumptions of the loops."""
    steps = [bench.steps_text(loop.run for loop in loops) for loops in (measured.service, measured.ideal)]
    checks = [bench.steps_text([loops[0].run]) for loops in (measured.service_checks, measured.ideal_checks)]
    beyond = () if measured.statics else (LEFT_OUT,)
    return (
        f"the crank is locked; the torque at the output follows sin^5 over {1e3 * period:.3g} ms, up to "
        f"{measured.service[0].rated:.4g} N m (rated input torque times the ratio by default)",
        f"time step {steps[0]}, without friction and weight {steps[1]}; numerical error: changes with a {SLOWER:g} "
        f"times slower loop and with time steps of {checks[0]} and {checks[1]} at the first crank angle, and the error "
        "of the turn's mean by its angles (by the backlash of rigid parts, and by the scatter of the readings)",
        "friction is viscous below the creep speed, which is as low as the time step allows: with free pins a shorter "
        "time step lowers the stiffness by some percent",
        structure_text(measured.reducer),
        f"contacts have the secant stiffness of one working force, that at the loop's end: "
        f"{measured.reducer.contacts.working_forces_text(measured.reducer.design.pair_kinds)}",
        *(assumptions(measured.reducer, "runs without friction and weight") if solver == "planar" else ()),
        *beyond,
    )
