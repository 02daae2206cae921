"""Lost motion, torsional stiffness and hysteresis by a slow torque loop at the output, with locked crank."""

from cycloid_mj.base.engine import Progress, each_in_threads, silent
from cycloid_mj.base.errors import RunError, UsageError
from cycloid_mj.base.names import SOLVERS
from cycloid_mj.base.notebook_progress import shows_progress
from cycloid_mj.design import Named, resolve
from cycloid_mj.dynamics.massless import assumptions, massless
from cycloid_mj.dynamics.run import Solver
from cycloid_mj.measure import bench, hysteresis
from cycloid_mj.measure.hysteresis import LOOP
from cycloid_mj.measure.lost_motion_table import LostMotionLoops, angle_rows, curves, quantities
from cycloid_mj.measure.measurement import Measurement
from cycloid_mj.reducer import Reducer, reducer_of
from cycloid_mj.statics.structure import structure_text
from cycloid_mj.statics.windup import Windup, solve_windups

NO_STATICS_NOTE = "no values by statics: no static balance was found"


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
    angles, quick
        Number of crank angles, spread over the turn and over the mesh period, by default `SlowLoopSettings.angles`
        or, if `quick` is True, the smaller `SlowLoopSettings.quick_angles`.
    progress, solver
        Called after each run with the numbers of finished and of all runs; solver of the runs.

    Returns
    -------
    Measurement
        Lost motion, backlash and hysteresis [arcmin], stiffness [N m/arcmin], compliances of the parts [arcmin/(N m)]
        and work of the loop [mJ], with numerical errors and static solutions; curves of the loop.

    Raises
    ------
    UsageError
        The torque or the number of angles is not positive.
    RunError
        A run failed.
    """
    reducer = reducer_of(resolve(design))
    rated_torque = reducer.design.rated_torque if load is None else load
    angles = (LOOP.quick_angles if quick else LOOP.angles) if angles is None else angles
    if not rated_torque > 0.0 or angles < 1:
        raise UsageError(
            f"lost motion cannot be measured with a torque of {rated_torque:g} N m at {angles} crank angles: give a "
            "torque greater than 0 N m (load) and at least 1 crank angle (angles)"
        )
    reducer = reducer.working_at(rated_torque)
    period = hysteresis.quasi_static_period(reducer, rated_torque)
    loops = _run_loops(reducer, rated_torque, period, angles, solver, progress)
    loop_details = {"nominal_torque_nm": rated_torque, "rated_torque_nm": rated_torque, "period_s": period}
    return Measurement(
        measure="lost-motion",
        design=reducer.design,
        condition=(
            f"{reducer.INPUT} locked, up to {rated_torque:.4g} N m on the output, {reducer.design.condition_words}, "
            f"{SOLVERS[solver]}"
        ),
        quantities=quantities(loops),
        curves=curves(loops),
        assumptions=_assumptions(loops, period, solver),
        runs={"loop": loops.service[0].run, "loop-ideal": loops.ideal[0].run},
        details={**loop_details, "angles": angle_rows(loops)},
    )


def _run_loops(
    reducer: Reducer, peak_torque: float, period: float, angles: int, solver: Solver, progress: Progress
) -> LostMotionLoops:
    """Simulate the torque loops at several crank angles, and solve for the static wind-up at the same angles.

    There are loops of the drive as designed, and loops without friction and weight. For the numerical error, both are
    repeated at the first angle, once with a shorter time step and once with a longer period. `solver` is the solver of
    the runs, MuJoCo or the planar solver.

    Parameters
    ----------
    peak_torque, period
        Peak [N m] and period [s] of the torque.
    angles
        Number of crank angles.
    """
    crank_angles = [float(angle) for angle in bench.crank_angles(reducer, angles)]
    ideal_drive = bench.without_friction(reducer)
    if solver == "planar":
        ideal_drive = massless(ideal_drive)
    # the longest first, so that no processor waits for one at the end
    settings = ((period, LOOP.finer), (LOOP.slower * period, 1.0))
    jobs = [(drive, crank_angles[0], *setting) for drive in (reducer, ideal_drive) for setting in settings]
    jobs += [(drive, angle, period, 1.0) for drive in (reducer, ideal_drive) for angle in crank_angles]
    loops = each_in_threads(
        lambda job: hysteresis.run_loop(job[0], job[1], peak_torque, *job[2:], solver), jobs, progress
    )
    check_loops, loops = loops[:4], loops[4:]
    statics = _solve_statics(reducer, crank_angles, peak_torque)
    return LostMotionLoops(reducer, loops[:angles], loops[angles:], check_loops[:2], check_loops[2:], statics)


def _solve_statics(reducer: Reducer, crank_angles: list[float], peak_torque: float) -> list[Windup]:
    """Solve the static wind-up at each crank angle [rad] up to the torque [N m]; empty if no equilibrium exists."""
    try:
        return solve_windups(reducer, crank_angles, peak_torque)
    except RunError:
        return []


def _assumptions(data: LostMotionLoops, period: float, solver: Solver) -> tuple[str, ...]:
    """Return the assumptions of a lost motion measurement by simulation, a sentence each.

    They are about torque loop, time steps, friction, structure and contact stiffness. `data` are the loops, `period` is
    the period of the torque [s]. `solver` is the solver of the runs, MuJoCo or the planar solver.
    """
    timesteps = [bench.timesteps_text(loop.run for loop in loops) for loops in (data.service, data.ideal)]
    check_timesteps = [bench.timesteps_text([loops[0].run]) for loops in (data.service_checks, data.ideal_checks)]
    missing_statics = () if data.statics else (NO_STATICS_NOTE,)
    return (
        f"the {data.reducer.INPUT} is locked; the torque at the output follows sin^5 over {1e3 * period:.3g} ms, up to "
        f"{data.service[0].rated:.4g} N m (rated input torque times the ratio by default)",
        f"time step {timesteps[0]}, without friction and weight {timesteps[1]}; numerical error: changes with a "
        f"{LOOP.slower:g} times slower loop and with time steps of {check_timesteps[0]} and {check_timesteps[1]} at "
        "the first crank angle, and the error of the turn's mean by its angles (by the backlash of rigid parts, and "
        "by the scatter of the readings)",
        "friction is viscous below the creep speed, which is as low as the time step allows: with free pins a shorter "
        "time step lowers the stiffness by some percent",
        structure_text(data.reducer),
        f"contacts have the secant stiffness of one working force, that at the loop's end: "
        f"{data.reducer.contacts.working_forces_text(tuple(data.reducer.clearance_keys))}",
        *(assumptions(data.reducer, "runs without friction and weight") if solver == "planar" else ()),
        *missing_statics,
    )
