"""All stages in order; a failed stage keeps its error, and the others still run."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from time import monotonic

from cycloid_mj.base.memory import return_free_memory
from hsieh2014.authors import authors
from hsieh2014.geometry import equal, geometry
from hsieh2014.motion import gear_speed, input_law, pin_1, q_path, q_velocity
from hsieh2014.plan import Plan, open_parameters
from hsieh2014.stage import Progress, Runs, Stage, StageResult, StageRun
from hsieh2014.stress import stress
from hsieh2014.torque import torque
from hsieh2014.verdicts import as_searched
from hsieh2014.vibration import vibration

STRESS = "stress"
"""The stage that needs the extra ``fem``."""

STEPS = (
    Stage("geometry", "Generation of the profiles", "Figs 1-4", geometry, 4, 4),
    Stage("equal", "What differs between the designs", "section 3.1", equal, 0.1, 0.1),
    Stage("input", "Input law", "Fig. 5", input_law, 6, 70),
    Stage("gear_speed", "Angular velocity of the gear", "Fig. 6", gear_speed, 55, 450, True),
    Stage("q_path", "Path of q", "Fig. 7", q_path, 4, 8, True),
    Stage("q_velocity", "Velocity of q and its error", "Fig. 8", q_velocity, 0.5, 0.5, True),
    Stage("pin_1", "Spin and centre of pin 1", "Fig. 9", pin_1, 2, 4, True),
    Stage("vibration", "Pin against nonpin", "Figs 6-8", vibration, 10, 150, True),
    Stage(STRESS, "Grids and stress", "Figs 10-16", stress, 70, 600, True),
    Stage("torque", "Output torque", "Fig. 19", torque, 8, 120),
)

AUTHORS = Stage("authors", "As the authors may have run it", "Figs 6, 8, 9, 12-16, 19", authors, 120, 300)
"""A stage that runs only on request."""

Report = Callable[[Stage, str, float], None]
"""Callback with a stage, its current task, and the remaining time of all stages [s]."""


def run_steps(plan: Plan, runs: Runs, report: Report, chosen: Sequence[str] = ()) -> list[StageRun]:
    """Run the stages with the keys `chosen`, or all of `STEPS`; report each with the remaining time.

    `runs` is the provider of runs. Any error is kept in the result of its stage.
    """
    steps = [step for step in (*STEPS, AUTHORS) if step.key in (chosen or [each.key for each in STEPS])]
    shares = [step.quick if plan.quick else step.full for step in steps]
    start, stages = monotonic(), []
    for number, step in enumerate(steps):
        rate = pace(monotonic() - start, sum(shares[:number]), sum(shares))
        ends, later = monotonic() + rate * shares[number], rate * sum(shares[number + 1 :])
        progress = partial(_progress, report, step, ends, later)
        progress("")
        stages.append(run_step(step, plan, runs, progress))
        return_free_memory()
    return stages


def pace(passed: float, done: float, total: float) -> float:
    """Estimate the run time relative to the shares, which are seconds on two idle cores.

    Half of the total counts as already done at that pace, because existing logs make the first stages fast.
    """
    return (passed + total / 2) / (done + total / 2)


def _progress(report: Report, stage: Stage, ends: float, later: float, text: str) -> None:
    """Report a stage with the remaining time [s]: until its own end, and of the later stages."""
    report(stage, text, max(ends - monotonic(), 0.0) + later)


def run_step(stage: Stage, plan: Plan, runs: Runs, progress: Progress) -> StageRun:
    """Run a stage; an error becomes part of its result, and claims get the ranges that were searched."""
    start = monotonic()
    try:
        result, error = stage.work(plan, runs, progress), ""
        claims = [as_searched(claim, open_parameters(plan)) for claim in result.claims]
        if stage.judged_on_starts:
            claims = [replace(claim, condition=replace(claim.condition, solver=plan.solver)) for claim in claims]
        result = replace(result, claims=tuple(claims))
    except Exception as problem:  # whatever breaks a stage, the page shall have the others
        result, error = StageResult(), f"{type(problem).__name__}: {problem}"
    return StageRun(stage, result, monotonic() - start, error)
