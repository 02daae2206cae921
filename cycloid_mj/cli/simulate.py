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
from cycloid_mj.base.overwrite_guard import claim
from cycloid_mj.cli.analyze import outcome_of
from cycloid_mj.cli.delivery import Destination, claim_page, deliver
from cycloid_mj.cli.flags import FLAT, HOLD, LOAD, RAMP, SPEED, STEP, TIMESTEP, Delivery, DesignOptions
from cycloid_mj.cli.outfile import folder, new_folder
from cycloid_mj.cli.progress import Progress, show_activity
from cycloid_mj.design import Design
from cycloid_mj.reducer import Reducer

if TYPE_CHECKING:
    from cycloid_mj.analysis import Findings
    from cycloid_mj.base.record import Run
    from cycloid_mj.dynamics.run import Contact, SampleBlock, Schedule, Solver
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

NEW_ACTUATOR = "--ratio 15 --diameter-mm 100 --torque-nm 1.5 --process printed --speed-rpm 200 --life-h 500"
"""Requirements of a printed actuator, as an example of `design new`."""

LOADED_FIGURES = {
    "transmission error (peak to peak)": "te_loaded_arcsec",
    "stiffness": "stiffness_nm_per_arcmin",
    "largest tooth force": "tooth_force_n",
    "efficiency": "efficiency_percent",
}
"""Words -> key of a figure by statics that is printed next to an unloaded run."""


def simulate(
    chosen: Annotated[DesignOptions, FLAT],
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
    delivery: Annotated[SimulateDelivery, FLAT] = DELIVERED,
) -> int:
    """Simulate a design, log the run, and compare it with theory.

    The crank is accelerated linearly from rest and then kept at its speed. For this hold phase, the results are
    compared with theory: disc speed, path and speed of the centre of hole 1, transmission error; contacts, pin 1,
    torques and losses are added. The MCAP log is written during the run, with the design, the model and every sample;
    the page of `cycloid-mj report` is written next to it, unless --json is set.

    A failed run (not a number, a MuJoCo warning, excessive penetration, a jumped tooth) ends with an error and exit
    code 1, a stopped run (Ctrl-C, SIGTERM, SIGHUP) with 128 plus the number of the signal; the log contains the
    samples up to that time. Two runs never write the same log: the second uses the next name, or ends with an error.
    """
    values = [(TIMESTEP, timestep_us), (SPEED, speed_rpm), (RAMP, ramp_s), (HOLD, hold_s), (LOAD, load_nm)]
    design = chosen.resolve(values)
    chosen.warn_of_inherited_motor(design)
    require_possible(design, solver)
    force = delivery.force
    into = folder(delivery.out or RUNS, "the log", (), force)
    page = claim_page(delivery, design.name, into)
    names: Iterable[Path] = [into / f"{design.name}.mcap"]
    if delivery.out is None and not force:
        names = _free_names(into, design.name)
    else:
        claim(*names, *(review_of(log) for log in names if page is None and not delivery.json), force=force)
    with Progress(design.drive.ramp + design.drive.hold, delivery.quiet) as progress:
        ran = run_into_log(design, names, force, progress, contact, solver, keep_run=True)
    findings = ran.require_findings()
    warn(findings.design, findings.warnings)
    page = page or (None if delivery.json else review_of(ran.log))
    outcome = _with_explanations(outcome_of(findings), findings, ran, page, chosen, delivery.quiet)
    if not delivery.all:
        outcome = replace(outcome, tables=(), notes=())  # the page has them
    return deliver(outcome, Destination(design.name, None, page), delivery)


def review_of(log: Path) -> Path:
    """Return the path of the review page next to a log."""
    return log.with_name(f"{log.stem}-review.html")


def _with_explanations(
    outcome: Outcome, findings: "Findings", ran: "Ran", page: Path | None, chosen: DesignOptions, quiet: bool
) -> Outcome:
    """Return an outcome with explanations of its figures in place of the headline, and with commands to continue."""
    from cycloid_mj.analysis import explain

    log = ran.log
    written = f"log: {log}{f'; page for a browser: {page}' if page else ''}"
    return replace(
        outcome,
        condition=f"{outcome.condition}, {findings.steps} steps in {findings.wall_s:.1f} s of wall time",
        headline={},
        summary=[
            *explain(findings),
            *([] if findings.condition.load else _explain_unloaded_run(chosen.resolve())),
            written,
            *(f"next: {words}" for words in _next(findings, chosen)),
        ],
        page=lambda: _draw_page(ran, quiet),
    )


def _explain_unloaded_run(design: Design) -> Iterator[str]:
    """Explain an unloaded run, and yield figures of the loaded drive next to it, by statics."""
    yield (
        "no load: the output drives nothing (load.torque_nm = 0), so the parts rattle within their clearances; the "
        "transmission error and the contact forces above differ from run to run and do not describe the loaded drive"
    )
    from cycloid_mj.figures import quantity

    reducer = Reducer(design)
    figures = [(words, quantity(reducer, key)) for words, key in LOADED_FIGURES.items()]
    known = [f"{words} {figure.value:.3g} {figure.unit}" for words, figure in figures if not isnan(figure.value)]
    if known:
        yield f"at the nominal torque of {design.rated_torque:.4g} N m, by statics: {', '.join(known)}"


def _draw_page(ran: "Ran", quiet: bool) -> str:
    from cycloid_mj.report import review_page

    with show_activity("drawing the page of the run", quiet):
        return review_page(ran.log, ran.run)


def _next(findings: "Findings", chosen: DesignOptions) -> Iterator[str]:
    """Yield commands to continue with: the same run under load, or the life; and one for each kind of user."""
    design = [chosen.design, *(word for change in chosen.set_ for word in ("--set", change))]
    if findings.condition.load:
        yield _command(["rate", *design], "life, and the weakest part")
    else:
        loaded = ["--load-nm", f"{chosen.resolve().rated_torque:.4g}", "--ramp-s", "0", "--hold-s", "0.05"]
        yield _command(["simulate", *design, *loaded], "the same drive under its nominal torque")
    yield _command(["design", "new", "actuator", *NEW_ACTUATOR.split()], "I print an actuator: a drive to order")
    yield _command(["statics", *design], "I design reducers: backlash, stiffness, loads, efficiency")
    yield _command(["reduce", *design, "--out", "joint"], "I simulate a robot: one joint for a MuJoCo model")


def _command(words: Sequence[str], comment: str) -> str:
    """Return a command of this program as it is typed, with a comment."""
    return f"{join(['cycloid-mj', *words])}    # {comment}"


@dataclass(frozen=True)
class Ran:
    """A logged run.

    Attributes
    ----------
    log
        The file.
    steps
        Steps of the run.
    wall
        Time that they took, with the log [s].
    findings
        The run's judgement, or why it cannot be judged.
    run
        The run without its forces, if it was to be kept and can be judged.
    """

    log: Path
    steps: int
    wall: float
    findings: "Findings | CycloidError"
    run: "Run | None" = None

    def require_findings(self) -> "Findings":
        """Return the findings of the run; raise LogError if it cannot be judged."""
        if isinstance(self.findings, CycloidError):
            raise LogError(
                f"the run is logged in {self.log}, but cannot be evaluated: {self.findings}. Correct the cause and "
                f"simulate again, or look at the run with `{join(['cycloid-mj', 'view', str(self.log)])}`"
            ) from self.findings
        return replace(self.findings, steps=self.steps, wall_s=self.wall)


def require_possible(design: Design, solver: "Solver" = "mujoco") -> None:
    """Raise UsageError for a run that is too long or does not turn, DesignError for an unsound design."""
    reducer = Reducer(design)
    if design.drive.speed == 0.0:
        raise UsageError(
            "drive.speed_rpm is 0, so the crank would not turn: set a speed other than 0, e.g. --speed-rpm 1640"
        )
    from cycloid_mj.checks import require_sound
    from cycloid_mj.dynamics.run import RUN, STEP_RULES

    require_sound(reducer)
    step = STEP_RULES[solver].choose(reducer).seconds
    steps = (design.drive.ramp + design.drive.hold) / step
    if steps > RUN.max_steps:
        raise UsageError(
            f"the run would take {steps:.3g} time steps of {step * 1e6:g} us, but at most {RUN.max_steps:.0e} are "
            "allowed: increase --timestep-us, or reduce --ramp-s and --hold-s"
        )


def logs_folder(usual: str, out: str | None, names: Sequence[str], force: bool) -> Path:
    """Return the folder of the files `names`: the requested one, or the first unused of `usual`, `usual`-2, ...

    Making the folder claims it: of two commands at once each gets its own.

    Raises
    ------
    CycloidError
        The folder cannot be created.
    TakenError
        The requested folder contains one of the files, and `--force` is absent.
    """
    if out is None and not force:
        numbered = (f"{usual}-{number}" for number in count(2))
        return next(path for name in chain([usual], numbered) if (path := new_folder(name, "the logs")))
    return folder(usual if out is None else out, "the logs", names, force)


def _free_names(into: Path, name: str) -> Iterator[Path]:
    """Yield the names that the usual folder has for a design's runs and that are free, one after the other."""
    numbered = (into / f"{name}-{number}.mcap" for number in count(2))
    logs = chain([into / f"{name}.mcap"], numbered)
    yield from (log for log in logs if not log.exists() and not review_of(log).exists())


def run_into_log(
    design: Design,
    names: Iterable[Path],
    force: bool,
    progress: Progress,
    contact: "Contact" = "profile",
    solver: "Solver" = "mujoco",
    shown: bool = True,
    keep_run: bool = False,
) -> Ran:
    """Run a design into the first log of `names` that no other run has taken.

    One that is not to be `shown` has its samples and the design alone: no frames, no model, no findings.
    """
    reducer = Reducer(design)
    from cycloid_mj.analysis.series import DESIGN_FILE
    from cycloid_mj.dynamics.run import (
        attachments,
        blocks,
        log_columns,
        model_for,
        provenance,
        run_warnings,
        schedule,
        warnings_entry,
    )
    from cycloid_mj.log import LogWriter
    from cycloid_mj.scene import Scene, frame_rate

    compiled = model_for(solver, reducer, contact)
    plan = schedule(reducer, compiled.timestep)
    _require_held_samples(design, plan)
    groups = {topic: list(units.items()) for topic, units in log_columns(compiled, reducer).items()}
    entries = provenance(reducer, contact, plan.timestep, solver) | {"steps": str(plan.steps)}
    entries |= warnings_entry(run_warnings(compiled, reducer))
    progress.tell(f"time step {entries['timestep']}, for {entries['timestep_for']}")
    start = time.perf_counter()
    scene: Scene | None = Scene(design, frame_rate(reducer))
    files = attachments(compiled, reducer)
    if not shown:
        scene, files = None, {DESIGN_FILE: files[DESIGN_FILE]}
    with _first(names, lambda path: LogWriter(path, groups, entries, files, force=force, viewer=scene)) as log:
        note = "; ".join(_record(blocks(compiled, reducer), log, progress))
        wall = time.perf_counter() - start
        progress.judging()
        log.flush()
        unjudged = LogError(f"the run in {log.name} has not been evaluated: evaluate it with `cycloid-mj analyze`")
        findings, run = _judgement(log, note) if shown else (unjudged, None)
        attached = {} if isinstance(findings, CycloidError) else _findings_attachment(findings)
        log.close(note, attachments=attached)
    kept = replace(run, attachments={**run.attachments, **attached}) if run and keep_run else None
    return Ran(log.path, plan.steps, wall, findings, kept)


def _first(names: Iterable[Path], opened: Callable[[Path], "LogWriter"]) -> "LogWriter":
    """Open the first unused log of `names`; raise LogTakenError if all are taken."""
    from cycloid_mj.log import LogTakenError

    taken: LogError = LogError(
        "there is no free file name left for the log in the output folder: choose another folder with --out"
    )
    for path in names:
        try:
            return opened(path)
        except LogTakenError as problem:
            taken = problem
    raise taken


def _judgement(log: "LogWriter", note: str) -> "tuple[Findings | CycloidError, Run | None]":
    """Judge a log that lacks only its end, and return its run without forces; it may get its name when it is closed."""
    from cycloid_mj.analysis import analyze
    from cycloid_mj.log import read

    try:
        run = replace(read(log.path, without=(FORCES,)), complete=True, note=note)
        return analyze(run, log=str(log.name)), run
    except CycloidError as problem:
        return problem, None


def _findings_attachment(findings: "Findings") -> dict[str, bytes]:
    return {"findings.json": dumps(findings.as_json(), indent=2).encode()}


def _require_held_samples(design: Design, plan: "Schedule") -> None:
    sampling = plan.stride * plan.timestep
    if design.drive.hold < FEWEST_HELD * sampling:
        raise UsageError(
            f"--hold-s {design.drive.hold:g} (drive.hold_s) is too short: it must contain at least {FEWEST_HELD} "
            f"samples at intervals of {sampling:g} s. Increase --hold-s to {FEWEST_HELD * sampling:.4g} or more, or "
            "increase settings.log_rate_hz"
        )


def _record(
    samples: "Generator[SampleBlock, None, tuple[str, ...]]", log: "LogWriter", progress: Progress
) -> tuple[str, ...]:
    """Write blocks of samples as they come; close the log as incomplete if the run fails or is stopped.

    Returns the warnings of the run that are known at its end alone.
    """
    late: tuple[str, ...] = ()

    def simulate_blocks() -> "Iterator[SampleBlock]":
        nonlocal late
        late = yield from samples

    try:
        for block in simulate_blocks():
            with defer_signals():
                log.write(block.time, block.values)
            progress.report_time(float(block.time[-1]))
        return late
    except KeyboardInterrupt as stop:
        raise _close_incomplete_log(log, f"stopped by {signal_name(stop)}") from stop
    except RunError as error:
        raise _close_incomplete_log(log, str(error)) from error


def _close_incomplete_log(log: "LogWriter", why: str) -> RunError:
    """Close the log of a run that did not reach its end, and return the error that says where its samples are."""
    log.close(note=why, complete=False)
    kept = f"the {log.samples} samples up to then are in {log.path}" if log.samples else "nothing was logged"
    old = f"; the previous log {log.name} is unchanged" if log.path != log.name else ""
    return RunError(f"{why}; {kept}{old}")
