"""``cycloid-mj compare``: two or more designs, or logs of them, side by side by the same measures."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from cycloid_mj.base.comparison_runs import DEFAULTS, IDLE_TURNS, QUICK_STARTS, TURNS
from cycloid_mj.base.errors import LogError, UsageError, warn
from cycloid_mj.base.outcome import Outcome, Picture
from cycloid_mj.cli import flags
from cycloid_mj.cli.delivery import Destination, claim_page, deliver
from cycloid_mj.cli.outfile import claim_folder
from cycloid_mj.cli.simulate import logs_folder, require_runnable
from cycloid_mj.cli.verdict import capacity_of, outcome_of, overload_words
from cycloid_mj.design import Design
from cycloid_mj.papers import RunsJudged, judge_runs

if TYPE_CHECKING:
    from cycloid_mj.analysis import Series
    from cycloid_mj.comparison import Comparison, Trial
    from cycloid_mj.explore.compared import RunPlan

EXAMPLES = """Examples:
  cycloid-mj compare pin nonpin
  cycloid-mj compare pin nonpin --sweep --out decided
  cycloid-mj compare pin my.toml --load-nm 20 --set friction.pin_gear=0.02
  cycloid-mj compare pin-no-load.mcap nonpin-no-load.mcap --json"""

RUNS = "runs/compare"
STEM = "compare"
FILES = ("compare_curvature.png", f"{STEM}.json", f"{STEM}.csv")
"""Files of every comparison."""

DesignsOrLogs = Annotated[
    str,
    Parameter(
        metavar="DESIGN|RUN.mcap",
        help=f"Two or more designs (presets {flags.NAMES}, or TOML files) to simulate, or logs of earlier runs to "
        "read.",
    ),
]


@dataclass(frozen=True)
class CompareOptions:
    """Settings of the runs of a comparison, and its output flags."""

    set_: flags.SetFlag = ()
    at_c: flags.TemperatureFlag = None
    solver: flags.StudySolverFlag = "planar"
    load_nm: Annotated[
        float | None,
        flags.LOAD.flag(
            "Load torque of the loaded runs; 0: unloaded runs only",
            f". Default: the first design's {flags.RATED}.",
        ),
    ] = None
    timestep_us: Annotated[
        float | None,
        flags.TIMESTEP.flag(
            "Time step of all runs",
            ". Default: chosen for each run; with the planar solver at most 5 us for all, as moving pins require.",
        ),
    ] = None
    speed_rpm: Annotated[
        float | None, flags.SPEED.flag("Crank speed of all runs, by default that of the first design")
    ] = None
    ramp_s: Annotated[
        float | None,
        flags.RAMP.flag("Duration of the linear ramp from rest", ". Default: 0, which starts at full speed."),
    ] = None
    hold_s: Annotated[
        float | None,
        flags.HOLD.flag(
            "Duration at constant speed",
            f". Default: {TURNS} crank turns after the load has been applied and settled for one turn "
            f"(0.2661 of pin); {IDLE_TURNS} without load (0.1198).",
        ),
    ] = None
    q: flags.PointFlag = None
    sweep: Annotated[
        bool,
        Parameter(
            help="Vary contact damping (ratio 0.1, 1), friction of teeth and sockets (0, 0.1) and the freedom of "
            "the pins (fixed) one at a time, to show what decides the ranking. Five times as many runs."
        ),
    ] = False
    quick: Annotated[
        bool,
        Parameter(
            help="Skip the repeated loaded runs that show the sensitivity to creep speed and contact damping, "
            f"and run only {QUICK_STARTS} starts without load: the ranking of unloaded results is then "
            "undetermined."
        ),
    ] = False

    @property
    def simulation_flags(self) -> tuple[str, ...]:
        """Flags of the command line that apply to simulations only."""
        changed_fields = [
            field.name for field in fields(self) if field.name != "q" and getattr(self, field.name) != field.default
        ]
        return tuple(f"--{name.strip('_').replace('_', '-')}" for name in changed_fields)

    @property
    def first_design_values(self) -> flags.Values:
        """Return the flags that change the first design, with which all designs run, as pairs of quantity and value.

        The quantities are time step, speed, and durations of ramp and hold. A value is None if its flag is not set.
        """
        return (
            (flags.TIMESTEP, self.timestep_us),
            (flags.SPEED, self.speed_rpm),
            (flags.RAMP, self.ramp_s),
            (flags.HOLD, self.hold_s),
        )

    @property
    def has_hold_flag(self) -> bool:
        """True if the user sets the duration of the hold."""
        return self.hold_s is not None or any(change.strip().startswith(flags.HOLD.key) for change in self.set_)


DEFAULT = CompareOptions()


@dataclass(frozen=True, kw_only=True)
class CompareDelivery(flags.Delivery):
    """Destination of figures and logs."""

    out: Annotated[
        str | None,
        Parameter(
            metavar="DIR",
            help="Folder of logs, figures, compare.json and compare.csv; it is created if it does not exist. "
            f"Default: {RUNS}, or the first unused of {RUNS}-2, ...; for logs, the path of the first log "
            "with -compare instead of .mcap.",
        ),
    ] = None


DELIVERED = CompareDelivery()


def compare(
    *names: DesignsOrLogs,
    design: flags.SeveralFlag = (),
    options: Annotated[CompareOptions, flags.FLAT] = DEFAULT,
    output_flags: Annotated[CompareDelivery, flags.FLAT] = DELIVERED,
) -> int:
    """Compare designs in simulations without load and under load.

    For each load, the tables list errors of disc speed, path and speed of the point q, transmission error, contacts,
    forces and vibration (acceleration relative to the closed form), and the figures of geometry and statics. The last
    table shows how far each dynamic figure changes with the assumed creep speed and damping ratio of the contacts.
    Plots are written to --out.

    Without load, motion is chaotic, so each design is run from 8 independent starts. Figures are printed as minimum,
    maximum and mean. One design has the larger value if all its starts exceed all starts of the other by more than 5 %;
    otherwise, or with fewer starts, the order is undetermined. Under load, the designs are ordered by a rank test of
    the values in single crank turns, at a significance level of 5 %. A log counts as one start.

    For a pin and a nonpin design, a third design is added: the nonpin design with the total play and stiffness of the
    pin design. It separates the effect of the ring from that of the clearance. The command also prints which findings
    of Hsieh 2014 on vibration (Figs 6-8) the runs confirm.

    All designs run with drive, load, environment and settings of the first; --set changes every design. Signals are
    logged at 20 kHz unless settings.log_rate_hz is set, so vibration is resolved up to 10 kHz. Logs of additional
    starts and of varied contacts have no frames for viewers.
    """
    from cycloid_mj.explore.compared import list_cases

    q = flags.parse_point(options.q)
    designs = (*names, *design)
    logs = [name for name in designs if name.endswith(".mcap")]
    _require_consistent(designs, logs, options)
    if logs:
        default_folder = f"{logs[0].removesuffix('.mcap')}-compare"
        destination = _claim(
            claim_folder(output_flags.out or default_folder, "the figures", FILES, output_flags.force), output_flags
        )
        return deliver(_compare_logs(logs, q, destination), destination, output_flags)
    first_design = flags.load_design(designs[0], (*DEFAULTS, *options.set_), options.first_design_values, options.at_c)
    compared_designs = [flags.load_design(name, options.set_, (), options.at_c) for name in designs]
    flags.require_distinct_names(compared_designs)
    plan = _plan_runs(
        list_cases(compared_designs, first_design, options.load_nm, options.solver, options.has_hold_flag), options
    )
    warn_of_overloads(plan.starts)
    names_of_files = [*(f"{name}.mcap" for name in plan.names.values()), *FILES]
    destination = _claim(logs_folder(RUNS, output_flags.out, names_of_files, output_flags.force), output_flags)
    return deliver(_compare_runs(plan, q, destination, output_flags), destination, output_flags)


def _require_consistent(designs: Sequence[str], logs: Sequence[str], options: CompareOptions) -> None:
    """Raise UsageError unless at least two designs, or two logs and no designs, are named.

    It is also raised if logs are named together with `options` that apply to new simulations only.
    """
    if logs and len(logs) < len(designs):
        raise UsageError(
            f"{logs[0]} is a log, but {_first_design(designs)} is a design, and they cannot be mixed: name designs "
            "only, or logs only"
        )
    if len(designs) < 2:
        raise UsageError(
            "a comparison needs at least two designs: name another one, e.g. cycloid-mj compare pin nonpin"
        )
    if logs and options.simulation_flags:
        raise UsageError(
            f"{options.simulation_flags[0]} applies only to new simulations and has no effect on logs: remove this flag"
        )


def warn_of_overloads(cases: Iterable[Design]) -> None:
    """Warn of each design whose contacts yield under its load, before its run."""
    for case in cases:
        load, capacity = abs(case.load.torque), capacity_of(case)
        if load > capacity:
            warn(case.name, [f"{overload_words(load, capacity)}. Use --load-nm {0.99 * capacity:.3g} or less"])


def _claim(directory: Path, output_flags: flags.Delivery) -> Destination:
    return Destination(STEM, directory, claim_page(output_flags, STEM, directory))


def _first_design(names: Sequence[str]) -> str:
    return next(name for name in names if not name.endswith(".mcap"))


def _compare_logs(names: Sequence[str], q: tuple[float, float] | None, destination: Destination) -> Outcome:
    """Compare logged runs, and return their comparison as printable results (`Outcome`).

    `names` are the files of the logs, `q` is the point of the disc whose motion is compared [m]; None: the default
    point. `destination` has the paths of the output files.
    """
    from cycloid_mj.comparison import compare as compare_trials

    trials = [_measure_trial(Path(name), q) for name in names]
    comparison = compare_trials([trial for _, trial in trials])
    motions = {trial: motion for motion, trial in trials}
    verdicts = judge_runs(comparison.trials, {})
    return outcome_of(
        comparison, verdicts, _figure_encoders(comparison, [motions[trial] for trial in comparison.trials]), destination
    )


def _plan_runs(cases: Sequence[Design], options: CompareOptions) -> "RunPlan":
    """Plan the runs of a comparison: several initial states of each design, and variations of contact parameters.

    `cases` are the designs under their loads, from `list_cases`. Among the `options`, ``--sweep`` adds runs with other
    damping, friction and fixed pins; ``--quick`` omits most initial states, and the runs with other assumed contact
    values.

    Raises
    ------
    UsageError, DesignError
        A run is not possible.
    """
    from cycloid_mj.comparison import ASSUMPTIONS, STARTS, SWEEP
    from cycloid_mj.explore.compared import plan_runs

    plan = plan_runs(
        cases,
        options.solver,
        QUICK_STARTS if options.quick else STARTS,
        SWEEP if options.sweep else (),
        () if options.quick else ASSUMPTIONS,
    )
    for design in plan.names:
        require_runnable(design, options.solver)
    return plan


def _compare_runs(
    plan: "RunPlan", q: tuple[float, float] | None, destination: Destination, output_flags: flags.Delivery
) -> Outcome:
    """Simulate all runs of a plan into logs, and return their comparison as printable results.

    `q` is the point of the disc whose motion is compared [m], or None for the default point. `destination` has the
    paths of the output files, `output_flags` those of the output, such as ``--quiet``.
    """
    from cycloid_mj.cli.batch import run_all

    cases = list(plan.starts)
    paths = map(Path, destination.paths(f"{name}.mcap" for name in plan.names.values()))
    logs = dict(zip(plan.names, paths, strict=True))
    run_all(logs, output_flags.force, output_flags.quiet, plan.solver, viewable=plan.starts)
    motions, measures_by_design = {}, {}
    for design, log in logs.items():
        motion, trial = _measure_trial(log, q)
        measures_by_design[design] = trial.measures
        if design in plan.starts:
            motions[design] = motion
    comparison = plan.compare(measures_by_design, motions)
    verdicts = judge_runs(
        comparison.trials,
        {variation: plan.collect_trials(measures_by_design, cases, variation) for variation in plan.variations},
    )
    pictures = _figure_encoders(comparison, [motions[design] for design in cases]) | _paper_figure_encoders(verdicts)
    return outcome_of(comparison, verdicts, pictures, destination)


def _measure_trial(log: Path, q: tuple[float, float] | None) -> "tuple[Series, Trial]":
    """Read a log, and evaluate its run for a comparison.

    `q` is the point of the disc whose motion is evaluated, in the disc's frame [m], or None for the default point.

    Returns
    -------
    tuple
        Time series of the run after it has settled; and a `Trial` of this run alone: its design and its `Measures`,
        the results of the analysis, rms deviations from the closed form, vibration and forces.

    Raises
    ------
    LogError
        The run is incomplete.
    """
    from cycloid_mj.comparison import Trial, measure_run, settle_run
    from cycloid_mj.log import read

    run = read(log)
    if not run.complete:
        raise LogError(
            f"the run in {log} is incomplete ({run.note}), and only complete runs can be compared: simulate the design "
            "again"
        )
    motion = settle_run(run, q)
    return motion, Trial(motion.design, measure_run(motion, str(log)))


def _figure_encoders(comparison: "Comparison", motions: "Sequence[Series]") -> dict[str, Picture]:
    """Return functions that encode the diagrams of a comparison in a file format, by name of the diagram.

    `motions` are the time series of its runs after they have settled. The diagram of the curvature shows the designs
    of the runs under the first load.
    """
    from cycloid_mj.plots.comparison import comparison_figures
    from cycloid_mj.plots.curvature import curvature_figure
    from cycloid_mj.plots.save import encode_figure

    figures = comparison_figures(motions)
    first_load_trials = comparison.at(comparison.loads[0])
    figures["compare_curvature"] = curvature_figure([trial.design for trial in first_load_trials])
    return {name: partial(encode_figure, figure) for name, figure in figures.items()}


def _paper_figure_encoders(verdicts: RunsJudged) -> dict[str, Picture]:
    from cycloid_mj.plots.save import encode_figure

    return {name: partial(encode_figure, draw()) for name, draw in verdicts.figures.items()}
