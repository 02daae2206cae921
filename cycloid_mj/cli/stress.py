"""``cycloid-mj stress``: stress of every part by finite elements, under the forces of a run, over one crank turn."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Annotated, Literal, NamedTuple

from cyclopts import Parameter

from cycloid_mj.base.errors import UsageError, warn
from cycloid_mj.base.outcome import MOST_FIGURES, Outcome
from cycloid_mj.cli import flags
from cycloid_mj.cli.delivery import Destination, claim_page, deliver
from cycloid_mj.cli.outfile import claim_folder
from cycloid_mj.cli.simulate import logs_folder, require_runnable
from cycloid_mj.cli.stressfiles import FIGURES, FILES, STEM, Drawn, outcome_of
from cycloid_mj.cli.terminal import tell
from cycloid_mj.design import Design
from cycloid_mj.papers import stress_references
from cycloid_mj.reducer import Reducer, reducer_of

if TYPE_CHECKING:
    from cycloid_mj.base.record import Run
    from cycloid_mj.stress.grid import Grid
    from cycloid_mj.stress.study import StressStudy, StudySettings

EXAMPLES = """Examples:
  cycloid-mj stress --design pin nonpin
  cycloid-mj stress --design pin --part gear pin_1 --quick --figure map
  cycloid-mj stress --log runs/pin.mcap --angle-deg 74 --out pin-stress
  cycloid-mj stress --design my.toml --load-nm 20 --json > stress.json
  cycloid-mj stress --design printed --springs --out parts"""

RUNS = "runs/stress"
GIGABYTE = 1e9
"""Bytes."""

PartsFlag = Annotated[
    tuple[str, ...],
    Parameter(
        name="--part",
        metavar="NAME",
        consume_multiple=True,
        help="Parts: shaft, gear (gear_1, gear_2, ... of several discs), ring (pinwheel or internal gear), "
        "output, pin_1. Default: all parts of the design.",
    ),
]
LogsFlag = Annotated[
    tuple[str, ...],
    Parameter(
        name="--log",
        metavar="RUN.mcap",
        consume_multiple=True,
        help="Logs with the contact forces, one for each design. Default: each design is simulated.",
    ),
]
LoadFlag = Annotated[
    float | None,
    flags.LOAD.flag(
        "Load torque of the simulation, against the rotation of the output",
        f". Default: load.torque_nm of the design or, if that is 0, its {flags.RATED}.",
    ),
]
AngleFlag = Annotated[
    float | None,
    flags.number_flag(
        "Crank angle of the stress maps and VTU files [deg]. Default: for each part, the angle of its "
        "largest bulk stress.",
        (0.0, 360.0),
    ),
]
StressQuickFlag = Annotated[
    bool,
    Parameter(
        name="--quick",
        help="Use every tenth degree and coarser grids: the same files in about 15 s of processor time and "
        "0.8 GB of memory (preset pin) instead of 60 s and 1.4 GB. The requirements of a design are "
        "printed before the work.",
    ),
]
FiguresFlag = Annotated[
    tuple[Drawn | Literal["all"], ...],
    Parameter(
        name="--figure",
        consume_multiple=True,
        help="Figures to draw into --out: grid, map (stress map), turn (maxima over the crank angle), "
        "refinement, or all. Default: map and turn with --html, else none.",
    ),
]
SpringsFlag = Annotated[
    bool,
    Parameter(
        name="--springs",
        negative="",
        help="Instead of stresses, compute the compliance of each part at the output and write each design "
        "with it as its springs (DESIGN-springs.toml), for statics, protocol and calibrate of printed "
        "parts.",
    ),
]
MountsFlag = Annotated[
    str | None,
    Parameter(
        name="--mounts",
        metavar="FILE.toml",
        help="With --springs: TOML file of the mounting of output pins and crank in compliant plates, and "
        "the limits of their modulus (example in docs/printed-drive.md). Default: pins are clamped, and the "
        "shaft is as in the design.",
    ),
]
SolidFlag = Annotated[
    bool,
    Parameter(
        name="--solid",
        negative="",
        help="Model disc, ring and pin 1 as solid bodies (3-D) in addition, on coarser grids, which takes "
        "longer. Shaft and output are always solid.",
    ),
]


@dataclass(frozen=True, kw_only=True)
class StressDelivery(flags.Delivery):
    """Destination of figures, maps and logs."""

    out: Annotated[
        str | None,
        Parameter(
            metavar="DIR",
            help="Folder of logs, figures, VTU files, stress.json and stress.csv; it is created if it does not "
            f"exist. Default: {RUNS}, or the first unused of {RUNS}-2, ...; with --log, the path of the "
            "first log with -stress instead of .mcap.",
        ),
    ] = None


DELIVERED = StressDelivery()


def stress(
    *designs: Annotated[
        flags.DesignNames,
        Parameter(
            help=f"Designs: presets ({flags.NAMES}) or TOML files. With --log, they are optional and must match it."
        ),
    ],
    design: flags.SeveralFlag = (),
    part: PartsFlag = (),
    log: LogsFlag = (),
    set_: flags.SetFlag = (),
    at_c: flags.TemperatureFlag = None,
    load_nm: LoadFlag = None,
    angle_deg: AngleFlag = None,
    quick: StressQuickFlag = False,
    solid: SolidFlag = False,
    springs: SpringsFlag = False,
    mounts: MountsFlag = None,
    figure: FiguresFlag = (),
    output_flags: Annotated[StressDelivery, flags.FLAT] = DELIVERED,
) -> int:
    """Compute the stress of the parts by finite elements.

    The loads are inertia and the contact forces of a logged run, on patches of Hertz's width, at each degree of a crank
    turn. Without --log, each design is simulated first: at full speed, for one turn after the load has settled.

    For each part, the tables list the largest von Mises stress away from the contacts (bulk) and below them (Hertz),
    with position, crank angle, safety factor against yield, and change with a finer grid; then stress at fillets and
    with other supports. Designs of Hsieh 2014 without load are compared with Figs 10-16 of that paper.

    An RV reducer is not simulated: the forces on its discs, ring and pins are those of its static balance with
    friction. A further table lists cranks (beams with notch factors) and tooth roots (ISO 6336-3).

    The bulk begins at a distance d from narrow contacts and sharp inner corners, where the largest stress reaches a
    plateau. The tables list d and how much the bulk stress depends on its choice: its relative drop from the distance d
    to 2 d or, if larger, its change with half or twice the distance from corners. If the nominal stress times the notch
    factor of a fillet is larger than the bulk stress, the safety factor is that of the fillet.

    stress.json, a VTU file of each part for ParaView, and the figures are written to --out. Requires the extra `fem`.
    With --springs, only the compliance of the parts is computed, and written to a design file as its springs.
    """
    names, map_angle = (*designs, *design), None if angle_deg is None else math.radians(angle_deg)
    _require_consistent(names, log, has_changes=bool(set_ or load_nm is not None))
    from cycloid_mj.base.memory import keep_freed_memory
    from cycloid_mj.stress.packages import import_package
    from cycloid_mj.stress.study import QUICK, StudySettings

    for module in ("gmsh", "skfem"):
        import_package(module)
    keep_freed_memory()
    selected_designs = (flags.load_design(name, set_, (), at_c) for name in names)
    if springs or mounts is not None:
        _require_springs(springs, has_selection=bool(log or part or figure or solid or angle_deg is not None))
        return _write_springs(list(selected_designs), load_nm, mounts, output_flags)
    settings = replace(QUICK if quick else StudySettings(), solid=solid, map_angle=map_angle)
    arguments = (part, settings, output_flags)
    job = _read_logs(log, names, *arguments) if log else _simulate_designs(list(selected_designs), load_nm, *arguments)
    studies = _study_parts(job.runs, job.grids, settings, output_flags.quiet)
    outcome = outcome_of(studies, job.destination, _choose_figures(figure, job.destination))
    return deliver(outcome, job.destination, output_flags)


def _require_consistent(designs: Sequence[str], logs: Sequence[str], has_changes: bool) -> None:
    """Raise UsageError if neither designs nor logs are named, or if flags change designs whose runs are logged.

    `has_changes` is whether flags such as ``--set`` change the designs.
    """
    if not designs and not logs:
        raise UsageError("no design or log is given: name one, e.g. cycloid-mj stress --design pin")
    if logs and has_changes:
        raise UsageError("--set and --load-nm have no effect on logs: remove them, or remove --log")
    if logs and designs and len(logs) != len(designs):
        raise UsageError(
            f"the number of designs ({len(designs)}) differs from the number of logs ({len(logs)}): name one design "
            "per --log, in the same order, or name no design"
        )


def _require_springs(springs: bool, has_selection: bool) -> None:
    """Raise UsageError if ``--mounts`` is used without ``--springs``, or ``--springs`` with flags that select results.

    At least one of both flags is set; `springs` is whether ``--springs`` is. `has_selection` is whether another flag
    selects parts, logs, figures, solids or an angle.
    """
    if not springs:
        raise UsageError("--mounts applies only with --springs: add --springs, or remove --mounts")
    if has_selection:
        raise UsageError(
            "--springs always covers all parts of the designs and cannot be combined with --log, --part, --figure, "
            "--solid or --angle-deg: remove those flags"
        )


Logged = tuple[Design, "Run | None", Path | None]
"""A design, its run, and the log of the run; without run: an RV reducer, whose forces are those of statics."""
Grids = dict[str, "Grid"]
"""Part -> its finite-element mesh."""


class _Job(NamedTuple):
    """Runs whose parts are studied, the meshes of the parts of each run, and the destination of the results."""

    runs: list[Logged]
    grids: list[Grids]
    destination: Destination


def _read_logs(
    logs: Sequence[str],
    designs: Sequence[str],
    parts: Sequence[str],
    settings: "StudySettings",
    output_flags: StressDelivery,
) -> _Job:
    """Read the logs of runs for a stress computation, mesh the parts, and check that results can be written.

    `settings` are those of the computation, `output_flags` are those of the output (``--out``, ``--quiet``). `designs`
    are the names of the designs of the logs, empty to accept any; `parts` are empty for all parts. The `_Job` that is
    returned has the runs, the meshes and the destination of the results.
    """
    runs = [_read_log(Path(log), designs[index] if designs else "") for index, log in enumerate(logs)]
    grids = _mesh_parts([design for design, _, _ in runs], parts, settings, output_flags.quiet)
    default_folder = f"{logs[0].removesuffix('.mcap')}-stress"
    destination = _claim(
        claim_folder(output_flags.out or default_folder, "the figures", FILES, output_flags.force), output_flags
    )
    return _Job(runs, grids, destination)


def _simulate_designs(
    designs: Sequence[Design],
    load: float | None,
    parts: Sequence[str],
    settings: "StudySettings",
    output_flags: StressDelivery,
) -> _Job:
    """Mesh the parts, check that results can be written, and simulate one turn of each design under load.

    `settings` are those of the stress computation, `output_flags` are those of the output (``--out``, ``--quiet``).
    `load` is the load torque [N m]; None: that of the design, or its nominal torque. RV reducers are not simulated. The
    `_Job` that is returned has the runs, the meshes and the destination of the results.
    """
    from cycloid_mj.cli.batch import run_all
    from cycloid_mj.log import read
    from cycloid_mj.stress.figures import for_one_turn

    designs = [for_one_turn(design, load) for design in designs]
    _require_runnable(designs)
    grids = _mesh_parts(designs, parts, settings, output_flags.quiet)
    simulated_designs = [design for design in designs if design.layout == Reducer.LAYOUT]
    files = (*(f"{design.name}.mcap" for design in simulated_designs), *FILES)
    directory = logs_folder(RUNS, output_flags.out, files, output_flags.force)
    destination = _claim(directory, output_flags)
    logs = {design: directory / f"{design.name}.mcap" for design in simulated_designs}
    if logs:
        run_all(logs, output_flags.force, output_flags.quiet)
    runs = ((design, logs.get(design)) for design in designs)
    return _Job([(design, read(path) if path else None, path) for design, path in runs], grids, destination)


def _write_springs(
    designs: Sequence[Design], load: float | None, mounts: str | None, output_flags: StressDelivery
) -> int:
    """Write each design to a file in which springs have the compliance of its parts; return the exit code 0.

    `output_flags` are those of the output (``--out``, ``--quiet``). The compliance is computed by finite elements under
    the output torque `load` [N m]; None: the design's load or its rated torque. `mounts` is the path of a TOML file on
    the compliant plates that hold output pins and crank; None: the pins are clamped, and the shaft is as in the design.
    """
    from cycloid_mj.design import dump
    from cycloid_mj.stress.mounts import read_mounts
    from cycloid_mj.stress.springs import part_springs

    for design in designs:
        if design.layout != Reducer.LAYOUT:
            raise UsageError(
                f'--springs does not support layout = "{design.layout}" ({design.name}): remove --springs, or choose a '
                f'design with layout = "{Reducer.LAYOUT}"'
            )
    mounting = None if mounts is None else read_mounts(Path(mounts))
    _require_runnable(designs)
    file_names = [f"{design.name}-springs.toml" for design in designs]
    destination = _claim(
        claim_folder(output_flags.out or RUNS, "the designs", [*file_names, *FILES], output_flags.force), output_flags
    )
    springs_by_design = []
    for design in designs:
        if not output_flags.quiet:
            tell(
                f"{design.name}: simulating without friction, then computing the compliance of its parts by finite "
                "elements at 12 crank angles"
            )
        torque = load if load is not None else design.load.torque or round(design.rated_torque, 9)
        springs_by_design.append(part_springs(Reducer(design.but(load={"torque": torque})), mounting))
    outcome = Outcome(
        title="springs by finite elements",
        headline={springs.design.name: springs.text for springs in springs_by_design[:MOST_FIGURES]},
        tables=[springs.table() for springs in springs_by_design],
        files={
            name: dump(springs.design).encode() for name, springs in zip(file_names, springs_by_design, strict=True)
        },
        result={"designs": [springs.as_json() for springs in springs_by_design]},
    )
    return deliver(outcome, destination, output_flags)


def _choose_figures(requested: Sequence[str], destination: Destination) -> tuple[Drawn, ...]:
    """Return the kinds of figures to draw: those requested, else those of the page if there is one."""
    if not requested:
        return ("map", "turn") if destination.page else ()
    return tuple(name for name in FIGURES if name in requested or "all" in requested)


def _claim(directory: Path, output_flags: flags.Delivery) -> Destination:
    """Claim the page of the study, and return the destination of its files in a folder."""
    return Destination(STEM, directory, claim_page(output_flags, STEM, directory))


def _require_runnable(designs: Sequence[Design]) -> None:
    """Raise UsageError if two designs have the same name, or if a design cannot run."""
    flags.require_distinct_names(designs)
    for design in designs:
        require_runnable(design)


def _mesh_parts(designs: Sequence[Design], parts: Sequence[str], settings: "StudySettings", quiet: bool) -> list[Grids]:
    """Mesh the requested parts of every design; return the finite-element meshes by part, a mapping for each design.

    `settings` are those of the stress computation. The time and the memory that it needs are printed unless `quiet`. An
    empty `parts` selects all parts.
    """
    from cycloid_mj.stress.cost import add_costs, estimate_cost
    from cycloid_mj.stress.study import study_grids

    parts_by_design = _parts_by_design(designs, parts)
    grids = [
        study_grids(reducer_of(design), names, settings) for design, names in zip(designs, parts_by_design, strict=True)
    ]
    cost_of_study = add_costs(
        estimate_cost(grid, settings) for grids_of_design in grids for grid in grids_of_design.values()
    )
    unknowns = sum(grid.unknowns for grids_of_design in grids for grid in grids_of_design.values())
    if not quiet:
        tell(
            f"finite elements: {unknowns:,} unknowns at {settings.angles} crank angles; about "
            f"{cost_of_study.seconds:.0f} s of CPU time and {cost_of_study.memory / GIGABYTE:.1f} GB of memory"
        )
    return grids


def _read_log(path: Path, design: str) -> Logged:
    """Read the log of a run, and issue its warnings again; return the design of the run, the run and the path.

    Raises UsageError if the run is not that of `design`, a name or a file; an empty `design` accepts any run.
    """
    from cycloid_mj.analysis.series import design_of
    from cycloid_mj.log import read
    from cycloid_mj.stress.turn import require_same

    run = read(path)
    logged_design = design_of(run)
    warn(logged_design.name, run.warnings)
    if design:
        require_same(Reducer(flags.load_design(design, (), ())), Reducer(logged_design))
    return logged_design, run, path


def _study_parts(
    runs: Sequence[Logged], grids_by_run: Sequence[Grids], settings: "StudySettings", quiet: bool
) -> "list[StressStudy]":
    """Compute the stress of the meshed parts of every run by finite elements, with progress on stderr.

    `settings` are those of the computation. `runs` are the designs with their runs, `grids_by_run` are the meshes by
    part of each run. With `quiet` no progress is printed.
    """
    from cycloid_mj.stress.cost import estimate_cost
    from cycloid_mj.stress.study import stress_study

    reporter = _TimeReporter(
        [estimate_cost(grid, settings).seconds for grids in grids_by_run for grid in grids.values()], quiet
    )
    return [
        stress_study(
            run,
            reducer_of(design),
            tuple(grids),
            settings,
            str(path) if path else None,
            partial(reporter.report_part, design.name),
            grids,
            stress_references(reducer_of(design)),
        )
        for (design, run, path), grids in zip(runs, grids_by_run, strict=True)
        if grids
    ]


def _parts_by_design(designs: Sequence[Design], parts: Sequence[str]) -> list[list[str]]:
    """Return the names of the requested parts for each design, in the order of the designs.

    No `parts` mean all parts. Parts that a design lacks are left out of its list. Raises UsageError if one of the parts
    exists in none of the designs.
    """
    from cycloid_mj.stress.loads import part_names, require_part

    for part in parts:
        if not any(part in part_names(reducer_of(design)) for design in designs):
            require_part(reducer_of(designs[0]), part)
    return [[part for part in part_names(reducer_of(design)) if part in parts or not parts] for design in designs]


class _TimeReporter:
    """Progress over parts, with the time left from the estimated cost of each part [s]."""

    def __init__(self, costs: Sequence[float], quiet: bool) -> None:
        self._costs = costs
        self._quiet = quiet
        self._started = 0
        self._start = monotonic()

    def report_part(self, design: str, part: str, index: int, total: int) -> None:
        """Print that the study of a part begins, with the estimated time left.

        `index` counts the parts of the design from 0, `total` is their number.
        """
        seconds_done = sum(self._costs[: self._started])
        seconds_left = (monotonic() - self._start) * (sum(self._costs) / seconds_done - 1.0) if seconds_done else None
        self._started += 1
        if not self._quiet:
            estimate_text = "" if seconds_left is None else f", about {seconds_left:.0f} s left"
            tell(f"{design}: {part} ({index + 1} of {total} parts){estimate_text}")
