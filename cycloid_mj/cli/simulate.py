"""``cycloid-mj simulate``: simulate a design, log the run, and compare it with theory."""

import time
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, count
from json import dumps
from math import isnan
from pathlib import Path
from shlex import join
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from cycloid_mj.base.errors import CycloidError, LogError, RunError, UsageError, warn
from cycloid_mj.base.interrupt import defer_signals, signal_name
from cycloid_mj.base.names import FORCES
from cycloid_mj.base.outcome import Outcome
from cycloid_mj.base.overwrite_guard import claim_outputs
from cycloid_mj.cli.analyze import outcome_of
from cycloid_mj.cli.delivery import Destination, claim_page, deliver
from cycloid_mj.cli.flags import FLAT, HOLD, LOAD, RAMP, SPEED, STEP, TIMESTEP, Delivery, DesignOptions
from cycloid_mj.cli.outfile import claim_folder, create_folder
from cycloid_mj.cli.progress import Progress, show_activity
from cycloid_mj.design import Design
from cycloid_mj.reducer import Reducer, RvReducer, reducer_of

if TYPE_CHECKING:
    from cycloid_mj.analysis import Findings
    from cycloid_mj.base.record import Run
    from cycloid_mj.dynamics.run import Contact, Model, SampleBlock, Schedule, Solver
    from cycloid_mj.log import LogWriter

EXAMPLES = """Examples:
  cycloid-mj simulate --design pin
  cycloid-mj simulate --design pin --ramp-s 0 --hold-s 0.05 --load-nm 36
  cycloid-mj simulate --design my.toml --set friction.pin_gear=0.02 --out sweep
  cycloid-mj simulate --design pin --contact mesh --ramp-s 0 --hold-s 0.05
  cycloid-mj simulate --design nonpin --json --quiet > nonpin.json"""

RUNS = "runs"
FEWEST_HELD = 2
"""Samples at constant speed that an analysis needs."""

ContactFlag = Annotated[
    Literal["profile", "mesh"],
    Parameter(
        help="Contact model. profile: exact tooth profiles; mesh: convex slices of them with MuJoCo's own "
        "collision detection, as in the folders of `cycloid-mj build`. With mesh, a time step takes 10 "
        "to 70 times as long, means are within 3 % and rms speed errors up to ten times those of "
        "profile. Default: profile."
    ),
]
SolverFlag = Annotated[
    Literal["mujoco", "planar"],
    Parameter(
        help="Solver: mujoco, or planar (a compiled solver of the planar equations of motion, independent of "
        "MuJoCo, with the same contacts and the same log, many times faster). Default: mujoco."
    ),
]


@dataclass(frozen=True, kw_only=True)
class SimulateDelivery(Delivery):
    """Output flags of a run."""

    out: Annotated[
        str | None,
        Parameter(
            metavar="DIR",
            help="Folder of the log DIR/<design>.mcap; it is created if it does not exist. An existing log is "
            f"overwritten with --force only. Default: {RUNS}, where further runs of a design are named "
            "<design>-2.mcap, <design>-3.mcap, ...",
        ),
    ] = None
    force: Annotated[
        bool,
        Parameter(
            help="Overwrite an existing DIR/<design>.mcap when the new run is complete. Until then, its samples "
            "are in DIR/<design>.partial.mcap; if the run fails, they stay there and the old log is "
            "unchanged."
        ),
    ] = False


DELIVERED = SimulateDelivery()

NEW_ACTUATOR = "--ratio 15 --diameter-mm 100 --torque-nm 3 --process printed"
"""Requirements of a printed actuator, as an example of `design new`."""

LOADED_FIGURES = {
    "transmission error (peak to peak)": "te_loaded_arcsec",
    "stiffness": "stiffness_nm_per_arcmin",
    "largest tooth force": "tooth_force_n",
    "efficiency": "efficiency_percent",
}
"""Words -> key of a figure by statics that is printed next to an unloaded run."""


def simulate(
    design_options: Annotated[DesignOptions, FLAT],
    *,
    contact: ContactFlag = "profile",
    solver: SolverFlag = "mujoco",
    timestep_us: Annotated[float | None, TIMESTEP.flag(f"Time step{STEP}")] = None,
    speed_rpm: Annotated[float | None, SPEED.flag("Crank speed after the ramp; negative: opposite direction")] = None,
    ramp_s: Annotated[
        float | None, RAMP.flag("Duration of the linear ramp from rest; 0: constant speed from the start")
    ] = None,
    hold_s: Annotated[float | None, HOLD.flag("Duration at constant speed after the ramp")] = None,
    load_nm: Annotated[float | None, LOAD.flag("Constant load torque against the rotation of the output")] = None,
    output_flags: Annotated[SimulateDelivery, FLAT] = DELIVERED,
) -> int:
    """Simulate a design, log the run, and compare it with theory.

    The crank is accelerated linearly from rest and then kept at its speed. For this hold phase, the results are
    compared with theory: disc speed, path and speed of the centre of hole 1, transmission error; contacts, pin 1,
    torques and losses are added. The MCAP log is written during the run, with the design, the model and every sample;
    the page of `cycloid-mj report` is written next to it, unless --json is set. An RV reducer is driven by its sun.
    --contact mesh replaces the exact tooth profiles by the convex slices that `cycloid-mj build` writes.

    A failed run (not a number, a MuJoCo warning, excessive penetration, a jumped tooth) ends with an error and exit
    code 1, a stopped run (Ctrl-C, SIGTERM, SIGHUP) with 128 plus the number of the signal; the log contains the
    samples up to that time. Two runs never write the same log: the second uses the next name, or ends with an error.
    """
    values = [(TIMESTEP, timestep_us), (SPEED, speed_rpm), (RAMP, ramp_s), (HOLD, hold_s), (LOAD, load_nm)]
    design = design_options.resolve(values)
    design_options.warn_of_inherited_motor(design)
    require_runnable(design, solver)
    has_page = not output_flags.json
    if design.layout != "central" and contact == "mesh":
        raise UsageError(f'--contact mesh is not supported for layout = "{design.layout}": remove --contact')
    force = output_flags.force
    folder = claim_folder(output_flags.out or RUNS, "the log", (), force)
    page = claim_page(output_flags, design.name, folder)
    names: Iterable[Path] = [folder / f"{design.name}.mcap"]
    if output_flags.out is None and not force:
        names = _unused_logs(folder, design.name)
    else:
        claim_outputs(*names, *(review_of(log) for log in names if page is None and has_page), force=force)
    with Progress(design.drive.ramp + design.drive.hold, output_flags.quiet) as progress:
        logged_run = run_into_log(design, names, force, progress, contact, solver, keep_run=True)
    findings = logged_run.require_findings()
    warn(findings.design, findings.warnings)
    page = page or (review_of(logged_run.log) if has_page else None)
    outcome = _add_explanations(outcome_of(findings), findings, logged_run, page, design_options, output_flags.quiet)
    if not output_flags.all and page:
        outcome = replace(outcome, tables=(), notes=())  # the page has them
    return deliver(outcome, Destination(design.name, None, page), output_flags)


def review_of(log: Path) -> Path:
    """Return the path of the review page next to a log."""
    return log.with_name(f"{log.stem}-review.html")


def _add_explanations(
    outcome: Outcome,
    findings: "Findings",
    logged_run: "LoggedRun",
    page: Path | None,
    design_options: DesignOptions,
    quiet: bool,
) -> Outcome:
    """Return a copy of the printable results of a run, without headline, whose summary explains the results.

    The summary also has the names of the files, and commands to continue with. The number of steps and the
    wall time are appended to the run conditions. The review page is drawn when the results are delivered.

    Parameters
    ----------
    outcome, findings
        Printable results, and the results of the run's analysis.
    logged_run
        The run with its log.
    page
        File of the review page; None without one.
    design_options
        Flags that choose the design.
    quiet
        Whether to print no progress lines.
    """
    from cycloid_mj.analysis import explain

    log = logged_run.log
    log_text = f"log: {log}{f'; page for a browser: {page}' if page else ''}"
    return replace(
        outcome,
        condition=f"{outcome.condition}, {findings.steps} steps in {findings.wall_s:.1f} s of wall time",
        headline={},
        summary=[
            *explain(findings),
            *([] if findings.condition.load else _explain_unloaded_run(design_options.resolve())),
            log_text,
            *(f"next: {command}" for command in _suggest_commands(findings, design_options)),
        ],
        page=lambda: _draw_page(logged_run, quiet),
    )


def _explain_unloaded_run(design: Design) -> Iterator[str]:
    """Yield lines that explain a run without load, with quantities of the loaded drive by statics."""
    yield (
        "no load: the output drives nothing (load.torque_nm = 0), so the parts rattle within their clearances; the "
        "transmission error and the contact forces above differ from run to run and do not describe the loaded drive"
    )
    from cycloid_mj.figures import quantity

    reducer = reducer_of(design)
    figures = [(figure_name, quantity(reducer, key)) for figure_name, key in LOADED_FIGURES.items()]
    figure_texts = [
        f"{figure_name} {figure.value:.3g} {figure.unit}" for figure_name, figure in figures if not isnan(figure.value)
    ]
    if figure_texts:
        yield f"at the nominal torque of {design.rated_torque:.4g} N m, by statics: {', '.join(figure_texts)}"


def _draw_page(logged_run: "LoggedRun", quiet: bool) -> str:
    from cycloid_mj.report import review_page

    with show_activity("drawing the page of the run", quiet):
        return review_page(logged_run.log, logged_run.run)


def _suggest_commands(findings: "Findings", design_options: DesignOptions) -> Iterator[str]:
    """Yield command lines to continue with after a simulated run, with reasons.

    `findings` are the results of its analysis, `design_options` the flags that choose the design. The first command
    rates the drive, or runs it under load if it had none. Another follows for each kind of user: who prints an
    actuator, designs reducers or, except for RV reducers, simulates robots.
    """
    design_flags = [design_options.design, *(word for change in design_options.set_ for word in ("--set", change))]
    resolved_design = design_options.resolve()
    if findings.condition.load:
        yield _command(["rate", *design_flags], "life, and the weakest part")
    else:
        hold_text = "0.05" if resolved_design.layout == "central" else "0.2"
        load_flags = ["--load-nm", f"{resolved_design.rated_torque:.4g}", "--ramp-s", "0", "--hold-s", hold_text]
        yield _command(["simulate", *design_flags, *load_flags], "the same drive under its nominal torque")
    yield _command(
        ["design", "new", "actuator", *NEW_ACTUATOR.split()], "I print an actuator: a drive that meets requirements"
    )
    yield _command(["statics", *design_flags], "I design reducers: backlash, stiffness, loads, efficiency")
    if resolved_design.layout == "central":
        yield _command(["reduce", *design_flags, "--out", "joint"], "I simulate a robot: one joint for a MuJoCo model")


def _command(words: Sequence[str], comment: str) -> str:
    """Return a command of this program as it is typed, with a comment."""
    return f"{join(['cycloid-mj', *words])}    # {comment}"


@dataclass(frozen=True)
class LoggedRun:
    """Summary of a run that was simulated into a log.

    Attributes
    ----------
    log
        The file.
    steps
        Steps of the run.
    wall
        Wall time of the simulation, including the log [s].
    findings
        Results of the run's analysis, or the error if it cannot be evaluated.
    run
        The run without its forces; None if it is not to be kept or cannot be evaluated.
    """

    log: Path
    steps: int
    wall: float
    findings: "Findings | CycloidError"
    run: "Run | None" = None

    def require_findings(self) -> "Findings":
        """Return the results of the analysis of a run; raise LogError if the run cannot be evaluated."""
        if isinstance(self.findings, CycloidError):
            raise LogError(
                f"the run is logged in {self.log}, but cannot be evaluated: {self.findings}. Correct the cause and "
                f"simulate again, or look at the run with `{join(['cycloid-mj', 'view', str(self.log)])}`"
            ) from self.findings
        return replace(self.findings, steps=self.steps, wall_s=self.wall)


def require_runnable(design: Design, solver: "Solver" = "mujoco") -> None:
    """Raise an error if a design cannot be simulated by a solver.

    Raises
    ------
    UsageError
        The crank does not turn, or the run would have more than `RUN.max_steps` time steps.
    DesignError
        A check of the design fails.
    """
    reducer = reducer_of(design)
    if design.drive.speed == 0.0:
        raise UsageError(
            f"{design.name}: drive.speed_rpm is 0, so the crank would not turn: set a speed other than 0, e.g. "
            "--speed-rpm 1640"
        )
    from cycloid_mj.checks import require_sound
    from cycloid_mj.dynamics.run import RUN, STEP_RULES

    require_sound(reducer)
    timestep = STEP_RULES[solver].choose(reducer).seconds
    step_count = (design.drive.ramp + design.drive.hold) / timestep
    if step_count > RUN.max_steps:
        raise UsageError(
            f"the run of {design.name} would take {step_count:.3g} time steps of {timestep * 1e6:g} us, but at most "
            f"{RUN.max_steps:.0e} are allowed: increase --timestep-us, or reduce --ramp-s and --hold-s"
        )


def logs_folder(default_folder: str, out: str | None, names: Sequence[str], force: bool) -> Path:
    """Return the folder for the logs `names`: the requested one, or `default_folder` with -2, -3, ... if it exists.

    The folder is created, which claims it: two commands at the same time get different folders. `out` is the requested
    folder, None without one; `force` is whether existing files are replaced.

    Raises
    ------
    CycloidError
        The folder cannot be created.
    TakenError
        The requested folder contains one of the files, and `force` is not set.
    """
    if out is None and not force:
        numbered_folders = (f"{default_folder}-{number}" for number in count(2))
        return next(
            path for name in chain([default_folder], numbered_folders) if (path := create_folder(name, "the logs"))
        )
    return claim_folder(default_folder if out is None else out, "the logs", names, force)


def _unused_logs(directory: Path, name: str) -> Iterator[Path]:
    """Yield unused paths for logs of the design `name` in a folder: NAME.mcap, NAME-2.mcap and so on."""
    numbered = (directory / f"{name}-{number}.mcap" for number in count(2))
    logs = chain([directory / f"{name}.mcap"], numbered)
    yield from (log for log in logs if not log.exists() and not review_of(log).exists())


def run_into_log(
    design: Design,
    names: Iterable[Path],
    force: bool,
    progress: Progress,
    contact: "Contact" = "profile",
    solver: "Solver" = "mujoco",
    viewable: bool = True,
    keep_run: bool = False,
) -> LoggedRun:
    """Simulate a design into the first log of `names` that does not exist, evaluate the run, and return its summary.

    If the run cannot be evaluated, the summary has the error in place of the findings.

    Parameters
    ----------
    names
        Paths of the log, the preferred one first.
    force
        Whether an existing log is replaced.
    progress
        Reports the progress of the run.
    contact, solver
        Contact model, and solver.
    viewable
        Whether to evaluate the run, and log findings, frames and model for viewers; else only samples and design.
    keep_run
        Whether the result has the run in memory, without its forces.

    Raises
    ------
    RunError
        The run failed or was stopped; the log has the samples up to then.
    UsageError
        The hold, the time at constant speed, is too short.
    LogTakenError
        All of the logs exist.
    """
    reducer = reducer_of(design)
    from cycloid_mj.dynamics.run import blocks, model_for, provenance, schedule

    compiled = model_for(solver, reducer, contact)
    plan = schedule(reducer, compiled.timestep)
    _require_held_samples(design, plan)
    run_provenance = provenance(reducer, contact, plan.timestep, solver)
    open_log = _make_log_opener(compiled, reducer, run_provenance | {"steps": str(plan.steps)}, force, viewable)
    progress.tell(f"time step {run_provenance['timestep']}; accuracy of the results: {run_provenance['timestep_for']}")
    start = time.perf_counter()
    with _open_unused_log(design.name, names, open_log) as log:
        note = "; ".join(_record_samples(blocks(compiled, reducer), log, progress))
        wall_time = time.perf_counter() - start
        progress.judging()
        not_evaluated = LogError(f"the run in {log.name} has not been evaluated: evaluate it with `cycloid-mj analyze`")
        findings, run = _evaluate_log(log, note, isinstance(reducer, RvReducer)) if viewable else (not_evaluated, None)
        findings_file = {}
        if not isinstance(findings, CycloidError):
            findings_file = {"findings.json": dumps(findings.as_json(), indent=2).encode()}
        log.close(note, attachments=findings_file)
    kept_run = replace(run, attachments={**run.attachments, **findings_file}) if run and keep_run else None
    return LoggedRun(log.path, plan.steps, wall_time, findings, kept_run)


def _make_log_opener(
    compiled: "Model", reducer: Reducer, provenance: dict[str, str], force: bool, viewable: bool
) -> "Callable[[Path], LogWriter]":
    """Return a function that opens a path as the log of a run, with its columns, provenance and files for viewers.

    `compiled` is the model of the run; `force` is whether an existing log is replaced. Logs that are not `viewable`
    have the design as their only file; those of an RV reducer have no 3-D scene.
    """
    from cycloid_mj.analysis.series import DESIGN_FILE
    from cycloid_mj.dynamics.run import attachments, log_columns, run_warnings, warnings_entry
    from cycloid_mj.log import LogWriter
    from cycloid_mj.scene import Scene, frame_rate

    column_groups = {topic: list(units.items()) for topic, units in log_columns(compiled, reducer).items()}
    metadata_entries = provenance | warnings_entry(run_warnings(compiled, reducer))
    files = attachments(compiled, reducer)
    scene = Scene(reducer.design, frame_rate(reducer)) if viewable else None
    if not viewable:
        files = {DESIGN_FILE: files[DESIGN_FILE]}
    return lambda path: LogWriter(path, column_groups, metadata_entries, files, force=force, viewer=scene)


def _open_unused_log(name: str, names: Iterable[Path], open_log: Callable[[Path], "LogWriter"]) -> "LogWriter":
    """Open the first log of `names` that does not exist; raise LogTakenError if all exist.

    `name` is that of the design, for an error message; `open_log` opens a path for writing.
    """
    from cycloid_mj.log import LogTakenError

    last_error: LogError = LogError(
        f"no unused file name is left for the log of the design {name!r}: choose another folder with --out"
    )
    for path in names:
        try:
            return open_log(path)
        except LogTakenError as problem:
            last_error = problem
    raise last_error


def _evaluate_log(log: "LogWriter", note: str, with_forces: bool) -> "tuple[Findings | CycloidError, Run | None]":
    """Evaluate the run in a log that is still open for writing; return the results and the run.

    `note` has the warnings that were known only at the end of the run; it becomes `Run.note`. `with_forces` is whether
    to read the contact forces too, which the findings of an RV reducer include.

    Returns
    -------
    tuple
        The results (`Findings`), or the error if the log cannot be evaluated; and the run, None in that case.
    """
    from cycloid_mj.analysis import analyze
    from cycloid_mj.log import read

    log.flush()
    try:
        run = replace(read(log.path, without=() if with_forces else (FORCES,)), complete=True, note=note)
        return analyze(run, log=str(log.name)), run
    except CycloidError as problem:
        return problem, None


def _require_held_samples(design: Design, plan: "Schedule") -> None:
    """Raise UsageError if the hold of a design, the time at constant speed, has fewer than `FEWEST_HELD` samples.

    `plan` has the interval of the samples.
    """
    interval = plan.stride * plan.timestep
    if design.drive.hold < FEWEST_HELD * interval:
        raise UsageError(
            f"--hold-s {design.drive.hold:g} (drive.hold_s) is too short: it must contain at least {FEWEST_HELD} "
            f"samples at intervals of {interval:g} s. Increase --hold-s to {FEWEST_HELD * interval:.4g} or more, or "
            "increase settings.log_rate_hz"
        )


def _record_samples(
    samples: "Generator[SampleBlock, None, tuple[str, ...]]", log: "LogWriter", progress: Progress
) -> tuple[str, ...]:
    """Write blocks of samples to a log while they are simulated; return warnings that are known at the end only.

    `progress` reports the simulated time.

    Raises
    ------
    RunError
        The run failed or was stopped; the log is closed as incomplete.
    """
    final_warnings: tuple[str, ...] = ()

    def simulate_blocks() -> "Iterator[SampleBlock]":
        nonlocal final_warnings
        final_warnings = yield from samples

    try:
        for block in simulate_blocks():
            with defer_signals():
                log.write(block.time, block.values)
            progress.report_time(float(block.time[-1]))
        return final_warnings
    except KeyboardInterrupt as stop:
        raise _close_incomplete_log(log, f"stopped by {signal_name(stop)}") from stop
    except RunError as error:
        raise _close_incomplete_log(log, str(error)) from error


def _close_incomplete_log(log: "LogWriter", reason: str) -> RunError:
    """Close the log of a run that did not reach its end, and return an error that states where its samples are."""
    log.close(note=reason, complete=False)
    samples_text = f"the {log.samples} samples up to then are in {log.path}" if log.samples else "nothing was logged"
    previous_log_text = f"; the previous log {log.name} is unchanged" if log.path != log.name else ""
    return RunError(f"{reason}; {samples_text}{previous_log_text}")
