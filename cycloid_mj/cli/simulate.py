"""``cycloid-mj simulate``: run a design, log it as it goes, and hold the run against the closed form."""

import time
from collections.abc import Iterable
from dataclasses import replace
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, NoReturn

from cyclopts import Parameter

from cycloid_mj.cli.flags import HOLD, LOAD, RAMP, SPEED, TIMESTEP, DesignFlag, JsonFlag, SetFlag, designed
from cycloid_mj.cli.interrupt import unbroken
from cycloid_mj.cli.outfile import folder
from cycloid_mj.cli.progress import Progress
from cycloid_mj.cli.report import report
from cycloid_mj.design import Design
from cycloid_mj.errors import CycloidError, LogError, RunError, UsageError

if TYPE_CHECKING:
    from cycloid_mj.analysis import Findings
    from cycloid_mj.log import LogWriter
    from cycloid_mj.simulate import Block, Contact, Schedule

EXAMPLES = """Examples:
  cycloid-mj simulate --design pin
  cycloid-mj simulate --design pin --ramp-s 0 --hold-s 0.05 --load-nm 36
  cycloid-mj simulate --design my.toml --set friction.pin_gear=0.02 --out sweep
  cycloid-mj simulate --design pin --contact mesh --timestep-us 5 --ramp-s 0 --hold-s 0.05
  cycloid-mj simulate --design nonpin --json --quiet > nonpin.json"""

RUNS = "runs"
MOST_STEPS = 10**9
"""A run of more steps would take a day and more; it is a slip of the flags."""

FEWEST_HELD = 2
"""Samples at constant speed that an analysis needs."""

ContactFlag = Annotated[
    Literal["profile", "mesh"],
    Parameter(
        help="profile: the exact profiles meet; mesh: convex slices of them meet in MuJoCo's own collision, as in the "
        "folders of `cycloid-mj build`. A step takes 10 to 70 times as long by mesh, but for mean values 5 us will do. "
        "Default: profile."
    ),
]
OutFlag = Annotated[
    str | None,
    Parameter(
        metavar="DIR",
        help=f"Folder of the log, made if there is none; the log is DIR/<design>.mcap and must not exist yet, unless "
        f"--force. Default: {RUNS}, where a design's next runs become <design>-2.mcap, <design>-3.mcap, ...",
    ),
]
ForceFlag = Annotated[bool, Parameter(help="Replace DIR/<design>.mcap if it exists.")]
QuietFlag = Annotated[bool, Parameter(help="No progress and no messages but errors on stderr.")]


def simulate(
    *,
    design: DesignFlag,
    set_: SetFlag = (),
    contact: ContactFlag = "profile",
    out: OutFlag = None,
    timestep_us: Annotated[float | None, TIMESTEP.flag("Time step")] = None,
    speed_rpm: Annotated[float | None, SPEED.flag("Crank speed after the ramp; negative turns the other way")] = None,
    ramp_s: Annotated[float | None, RAMP.flag("Duration of the linear ramp from rest; 0 starts at full speed")] = None,
    hold_s: Annotated[float | None, HOLD.flag("Duration at constant speed after the ramp")] = None,
    load_nm: Annotated[float | None, LOAD.flag("Constant torque against the output's rotation")] = None,
    force: ForceFlag = False,
    json: JsonFlag = False,
    quiet: QuietFlag = False,
) -> int:
    """Run a design in MuJoCo, log it, and compare the run with the closed form.

    The crank speeds up linearly from rest, then keeps its speed. Over that
    hold phase the table (or, with --json, one JSON object) compares with
    theory: gear speed, path and speed of the centre of hole 1, transmission
    error; and tells contacts, pin 1, torques and losses. The MCAP log is
    written as the run goes, with the design, the model and every sample;
    `cycloid-mj analyze` and `cycloid-mj plot` read it.

    A run that goes wrong (not a number, a warning of MuJoCo's, a contact too
    deep, a jumped tooth) or is stopped by Ctrl-C ends with an error and exit
    code 1; its log holds what came before.
    """
    values = [(TIMESTEP, timestep_us), (SPEED, speed_rpm), (RAMP, ramp_s), (HOLD, hold_s), (LOAD, load_nm)]
    chosen = designed(design, set_, values)
    require_possible(chosen)
    path = _log_path(chosen, out, force)
    with Progress(chosen.drive.ramp + chosen.drive.hold, quiet) as progress:
        steps, wall = run_into_log(chosen, path, force, progress, contact)
    report(_judged(path, steps, wall), json)
    return 0


def require_possible(design: Design) -> None:
    """Raise UsageError for a run that is too long or stands still, DesignError for an unsound design."""
    drive, timestep = design.drive, design.settings.timestep
    steps = (drive.ramp + drive.hold) / timestep
    if steps > MOST_STEPS:
        raise UsageError(
            f"the run would take {steps:.3g} steps of {timestep * 1e6:g} us, more than {MOST_STEPS:.0e}: "
            "enlarge --timestep-us or shorten --ramp-s and --hold-s"
        )
    if drive.speed == 0.0:
        raise UsageError("drive.speed_rpm is 0: the crank would stand still; give --speed-rpm")
    from cycloid_mj.checks import require_sound

    require_sound(design)


def _log_path(design: Design, out: str | None, force: bool) -> Path:
    """Give the log's file: in the folder asked for, or the next free name in the usual one."""
    path = folder(RUNS if out is None else out, "the log") / f"{design.name}.mcap"
    if force or not path.exists():
        return path
    if out is not None:
        raise LogError(f"log {path} exists already: give another --out, or --force to replace it")
    number = 2
    while (path := path.with_name(f"{design.name}-{number}.mcap")).exists():
        number += 1
    return path


def _judged(path: Path, steps: int, wall: float) -> "Findings":
    from cycloid_mj.analysis import analyze
    from cycloid_mj.log import read

    try:
        findings = analyze(read(path), log=str(path))
    except LogError as error:
        raise LogError(f"the run was logged to {path}, but cannot be judged: {error}") from error
    return replace(findings, steps=steps, wall_s=wall)


def run_into_log(
    design: Design, path: Path, force: bool, progress: Progress, contact: "Contact" = "profile"
) -> tuple[int, float]:
    """Run a design into its log; give steps and wall time [s] of the step loop with its log."""
    progress.tell("preparing the model")
    from cycloid_mj.contact.regime import warnings
    from cycloid_mj.log import LogWriter
    from cycloid_mj.scene import Scene
    from cycloid_mj.simulate import attachments, blocks, columns, provenance, reducer_model, schedule

    plan = schedule(design)
    _require_held_samples(design, plan)
    reducer = reducer_model(design, contact)
    troubles = warnings(design, reducer)
    for trouble in troubles:
        progress.tell(f"warning: {trouble}")
    groups = {topic: list(units.items()) for topic, units in columns(reducer, design).items()}
    told = provenance(design, contact) | {"steps": str(plan.steps)}
    told |= {"warnings": "; ".join(troubles)} if troubles else {}
    start = time.perf_counter()
    scene = Scene(design, design.settings.scene_rate)
    with LogWriter(path, groups, told, attachments(reducer, design), force=force, viewer=scene) as log:
        _record(blocks(reducer, design), log, progress)
        wall = time.perf_counter() - start
        log.flush()
        log.close(attachments=_findings(path))
    return plan.steps, wall


def _findings(path: Path) -> dict[str, bytes]:
    """Give the judgement of a log that is whole but for its end, as an attachment; none if it cannot be judged."""
    from cycloid_mj.analysis import analyze
    from cycloid_mj.log import read

    try:
        findings = analyze(replace(read(path), complete=True, note=""), log=str(path))
    except CycloidError:
        return {}
    return {"findings.json": dumps(findings.as_json(), indent=2).encode()}


def _require_held_samples(design: Design, plan: "Schedule") -> None:
    sampling = plan.stride * plan.timestep
    if design.drive.hold < FEWEST_HELD * sampling:
        raise UsageError(
            f"a hold of {design.drive.hold:g} s is shorter than {FEWEST_HELD} samples of {sampling:g} s: "
            "enlarge --hold-s (or settings.log_rate_hz)"
        )


def _record(samples: "Iterable[Block]", log: "LogWriter", progress: Progress) -> None:
    """Write blocks of samples as they come; close the log as incomplete if the run fails or is stopped."""
    try:
        for block in samples:
            with unbroken():
                log.write(block.time, block.values)
            progress.reached(float(block.time[-1]))
    except KeyboardInterrupt:
        _broken_off(log, "stopped by Ctrl-C")
    except RunError as error:
        _broken_off(log, str(error))


def _broken_off(log: "LogWriter", why: str) -> NoReturn:
    with unbroken():
        log.close(note=why, complete=False)
    kept = f"the {log.samples} samples up to then are in {log.path}" if log.samples else "nothing was logged"
    raise RunError(f"{why}; {kept}")
