"""``cycloid-mj compare``: two or more designs, or logs of them, side by side by the same measures."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from cycloid_mj.cli.flags import (
    HOLD,
    LOAD,
    RAMP,
    SPEED,
    TIMESTEP,
    JsonFlag,
    PointFlag,
    QuietFlag,
    SetFlag,
    designed,
    point,
    require_distinct,
    whole,
    within,
)
from cycloid_mj.cli.outfile import folder
from cycloid_mj.cli.simulate import logs_folder, require_possible
from cycloid_mj.cli.verdict import report
from cycloid_mj.design import Design
from cycloid_mj.errors import LogError, UsageError
from cycloid_mj.papers import vibration

if TYPE_CHECKING:
    from cycloid_mj.analysis import Series
    from cycloid_mj.comparison import Comparison, Trial, Varied

    Runs = dict[Design, Path]
    Measured = dict[Design, tuple[Series, Trial]]

EXAMPLES = """Examples:
  cycloid-mj compare pin nonpin
  cycloid-mj compare pin nonpin --sweep --out decided
  cycloid-mj compare pin my.toml --load-nm 20 --set friction.pin_gear=0.02
  cycloid-mj compare pin-no-load.mcap nonpin-no-load.mcap --json"""

RUNS = "runs/compare"
TURNS = 6
IDLE_TURNS = 2
"""Settled crank turns of a loaded run, and of each start at no load, unless the user says how long."""
QUICK_STARTS = 2
"""Starts of each design at no load with --quick: too few to rank designs by, and the verdicts say so."""
DEFAULTS = ("drive.ramp_s=0.0", "settings.log_rate_hz=20000.0")

DesignsOrLogs = Annotated[
    str,
    Parameter(
        metavar="DESIGN|RUN.mcap",
        help="Two or more designs (pin, nonpin, TOML files), which are run; or logs of such runs, which are read.",
    ),
]
LoadFlag = Annotated[
    float | None,
    LOAD.flag(
        "Torque of the loaded runs",
        "; with 0, there is no load only. Default: the first design's rated torque, drive.torque_nm times the ratio "
        "(36.68 in the presets).",
    ),
]
RampFlag = Annotated[
    float | None, RAMP.flag("Duration of the linear ramp from rest", ". Default: 0, which starts at full speed.")
]
HoldFlag = Annotated[
    float | None,
    HOLD.flag(
        "Duration at constant speed",
        f". Default: {TURNS} crank turns after the load has come on and settled for a turn (0.2661 in the presets); "
        f"{IDLE_TURNS} at no load (0.1198).",
    ),
]
OutFlag = Annotated[
    str | None,
    Parameter(
        metavar="DIR",
        help="Folder of logs and figures, made if there is none. It must not hold any of the logs yet, unless --force; "
        f"its figures are replaced. Default: {RUNS}, or the first new one of {RUNS}-2, ...; for logs, the first log's "
        "path with -compare for .mcap.",
    ),
]
ForceFlag = Annotated[bool, Parameter(help="Replace logs that exist.")]
SweepFlag = Annotated[
    bool,
    Parameter(
        help="Vary contact damping (ratio 0.1, 1), friction of teeth and sockets (0, 0.1) and the pins' "
        "freedom (fixed) one at a time, to show what decides the rankings. Five times the runs."
    ),
]
QuickFlag = Annotated[
    bool,
    Parameter(
        help="Leave out how far the dynamic figures move with creep speed and contact damping, for which the loaded "
        f"runs are repeated with each, and run {QUICK_STARTS} starts at no load: the order of the designs is then not "
        "determined there."
    ),
]
JobsFlag = Annotated[
    int | None,
    Parameter(
        metavar="N",
        converter=whole,
        validator=within(1, 256),
        help="Runs at a time, from 1 to 256. Default: one for each processor.",
    ),
]


def compare(
    *designs: DesignsOrLogs,
    set_: SetFlag = (),
    load_nm: LoadFlag = None,
    timestep_us: Annotated[float | None, TIMESTEP.flag("Time step; the first design's holds for all")] = None,
    speed_rpm: Annotated[float | None, SPEED.flag("Crank speed; the first design's holds for all")] = None,
    ramp_s: RampFlag = None,
    hold_s: HoldFlag = None,
    q: PointFlag = None,
    sweep: SweepFlag = False,
    quick: QuickFlag = False,
    out: OutFlag = None,
    jobs: JobsFlag = None,
    force: ForceFlag = False,
    json: JsonFlag = False,
    quiet: QuietFlag = False,
) -> int:
    """Run designs at no load and under load and put them side by side.

    For each load a table: errors of gear speed, path and speed of q,
    transmission error, contacts and forces, and vibration, which is the
    acceleration of the gear's centre and of the output about their closed
    forms. Then, for a pin and a nonpin design, which of the paper's findings
    on vibration (Hsieh 2014, Figs 6-8) the runs confirm, with the numbers. A
    last table says how far each dynamic figure moves when creep speed and
    damping ratio of the contacts, which are assumed, go to the other end of
    their range; it holds for these designs, load and speed only. A figure for
    each measure, and one of the relative curvature of the contact lines, go
    to --out.

    The motion at no load is chaotic. Each design has 8 independent starts
    there (gravity turned by whole tooth pitches), and each figure is stated
    as least to largest over them, and mean. Designs are ranked where all
    starts of the one lie beyond all of the other by more than 5 %; else, and
    with fewer starts, the order is not determined. A log is one start. Under
    load a rank test (5 %) of the rms values of the crank turns decides.

    A pin and a nonpin design are joined by a third: the nonpin design with the
    pin design's total play and series stiffness. What is left between it and
    the pin design is the effect of the design apart from its clearance.

    Every design runs under the settings of the first one (drive, load,
    environment, settings); --set changes every design. Signals are logged at
    20 kHz (unless --set settings.log_rate_hz), so vibration is told up to
    10 kHz. With --json, one JSON object instead of the tables.
    """
    place = point(q)
    logs = [name for name in designs if name.endswith(".mcap")]
    if logs and len(logs) < len(designs):
        raise UsageError(f"{logs[0]} is a log, {_first_design(designs)} a design: give designs only, or logs only")
    if len(designs) < 2:
        raise UsageError("a comparison needs two designs or more, such as: cycloid-mj compare pin nonpin")
    if logs:
        flags = (set_, load_nm, timestep_us, speed_rpm, ramp_s, hold_s, sweep, quick, jobs, force)
        report(*_from_logs(logs, any(flag not in ((), None, False) for flag in flags), place, out), json)
        return 0
    values = [(TIMESTEP, timestep_us), (SPEED, speed_rpm), (RAMP, ramp_s), (HOLD, hold_s)]
    first = designed(designs[0], (*DEFAULTS, *set_), values)
    held = hold_s is not None or any(change.strip().startswith("drive.hold_s") for change in set_)
    cases = _cases([designed(name, set_, ()) for name in designs], first, load_nm, held)
    report(*_from_runs(cases, sweep, quick, place, out, jobs or os.cpu_count() or 1, force, quiet), json)
    return 0


def _first_design(names: Sequence[str]) -> str:
    return next(name for name in names if not name.endswith(".mcap"))


def _held_for_turns(design: Design) -> Design:
    """Give a design with a hold of whole turns after the settling, fewer at no load, where each has several starts."""
    from cycloid_mj.comparison import settling

    if design.drive.speed == 0.0:
        return design
    turns = TURNS if design.load.torque else IDLE_TURNS
    # a sample more: the last turn shall be whole
    return design.steady(settling(design), turns, samples=1.0, drive={"ramp": design.drive.ramp})


def _cases(designs: Sequence[Design], first: Design, load_nm: float | None, held: bool) -> list[Design]:
    """Give every design under the settings of `first`, at no load and under load, of its hold if that is `held` to.

    A pin and a nonpin design are joined by the nonpin design with the other's total play and series stiffness at that
    load: it tells the effect of the design from that of the clearance.
    """
    from cycloid_mj.comparison import conditions, under, with_play_of
    from cycloid_mj.contact.massless import require_pin_bodies

    for design in designs:
        require_pin_bodies(design, "the idle and dynamic figures of a comparison")
    require_distinct(designs)
    shared = conditions(first)
    rated = round(first.drive.torque * first.lobes, 9) if load_nm is None else load_nm
    compared = list(designs)
    if len(designs) == 2 and {design.ring.kind for design in designs} == {"pin", "nonpin"}:
        pin, nonpin = sorted(designs, key=lambda design: design.ring.kind, reverse=True)
        compared.append(with_play_of(nonpin, under(pin, shared, rated)))
    cases = [under(design, shared, load) for load in dict.fromkeys((0.0, rated)) for design in compared]
    return cases if held else [_held_for_turns(design) for design in cases]


def _from_logs(
    names: Sequence[str], flagged: bool, place: tuple[float, float] | None, out: str | None
) -> "tuple[Comparison, list[Path]]":
    if flagged:
        raise UsageError("logs are read as they are: give only --q, --out, --json and --quiet with them")
    from cycloid_mj.comparison import compare as compared

    found = [_measured(Path(name), place) for name in names]
    comparison = compared([trial for _, trial in found], figures=vibration().figures)
    motions = {trial: motion for motion, trial in found}
    into = folder(f"{names[0].removesuffix('.mcap')}-compare" if out is None else out, "the figures")
    return comparison, _drawn(comparison, [motions[trial] for trial in comparison.trials], into)


def _from_runs(
    cases: Sequence[Design],
    sweep: bool,
    quick: bool,
    q: tuple[float, float] | None,
    out: str | None,
    workers: int,
    force: bool,
    quiet: bool,
) -> "tuple[Comparison, list[Path]]":
    from cycloid_mj.cli.batch import run_all
    from cycloid_mj.comparison import ASSUMPTIONS, STARTS, SWEEP, Trial, Variation, all_started, sensitivities, varied
    from cycloid_mj.comparison import compare as compared

    count = QUICK_STARTS if quick else STARTS
    starts = {design: (design,) if design.load.torque else all_started(design, count) for design in cases}
    as_it_is = Variation("", "as it is", ())
    variations, assumptions = SWEEP if sweep else (), () if quick else ASSUMPTIONS
    loaded = [design for design in cases if design.load.torque]
    names = {start: _log_name(start, place) for each in starts.values() for place, start in enumerate(each)}
    for variation, changed in [*((each, cases) for each in variations), *((each, loaded) for each in assumptions)]:
        for design in changed:
            words = f"{variation.parameter}-{variation.value}".replace(" ", "-").replace("/", "-per-")
            for place, start in enumerate(starts[design]):
                names.setdefault(variation.of(start), f"{_log_name(start, place)}-{words}")
    for design in names:
        require_possible(design)
    into = logs_folder(RUNS, out, list(names.values()), force)
    logs = {design: into / f"{name}.mcap" for design, name in names.items()}
    run_all(logs, min(workers, len(logs)), force, quiet)
    motions, measured = {}, {}
    for design, log in logs.items():
        motion, trial = _measured(log, q)
        measured[design] = trial.measures
        if design in cases:
            motions[design] = motion

    def trials(designs: Sequence[Design], variation: Variation = as_it_is) -> list[Trial]:
        """Give designs with one variation and the measures of all their starts."""
        found = ([variation.of(start) for start in starts[design]] for design in designs)
        return [Trial(first, measured[first], tuple(measured[other] for other in others)) for first, *others in found]

    figures = vibration().figures
    points: list[Varied] = [varied(each, trials(cases, each), figures) for each in variations]
    moved = sensitivities(trials(loaded), {each: trials(loaded, each) for each in assumptions})
    comparison = compared(trials(cases), points, moved if assumptions else (), figures)
    return comparison, _drawn(comparison, [motions[design] for design in cases], into)


def _log_name(design: Design, start: int = 0) -> str:
    load = design.load.torque
    case = f"{design.name}-{f'{load:g}Nm' if load else 'no-load'}"
    return f"{case}-start-{start + 1}" if start else case


def _measured(log: Path, place: tuple[float, float] | None) -> "tuple[Series, Trial]":
    from cycloid_mj.comparison import Trial, measure, settled
    from cycloid_mj.log import read

    run = read(log)
    if not run.complete:
        raise LogError(f"the run of {log} did not reach its end ({run.note}): run it again to compare it")
    motion = settled(run, place)
    return motion, Trial(motion.design, measure(motion, str(log)))


def _drawn(comparison: "Comparison", motions: "Sequence[Series]", into: Path) -> list[Path]:
    from cycloid_mj.plots import save
    from cycloid_mj.plots.comparison import comparison_figures
    from cycloid_mj.plots.curvature import curvature_figure
    from cycloid_mj.plots.sweep import sweep_figure

    figures = comparison_figures(motions)
    first = comparison.at(comparison.loads[0])
    figures["compare_curvature"] = curvature_figure([trial.design for trial in first])
    if comparison.sweep and comparison.rankings:
        figures["compare_sweep"] = sweep_figure(comparison)
    return save(figures, into)
