"""``cycloid-mj stress``: stress of every part by finite elements, under the forces of a run, over one crank turn."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from cycloid_mj.base.errors import UsageError, warn
from cycloid_mj.base.outcome import MOST_FIGURES, Outcome
from cycloid_mj.cli.delivery import Destination, claim_page, deliver
from cycloid_mj.cli.flags import (
    FLAT,
    LOAD,
    NAMES,
    RATED,
    Delivery,
    DesignNames,
    SetFlag,
    SeveralFlag,
    TemperatureFlag,
    load_design,
    require_distinct,
    within,
)
from cycloid_mj.cli.outfile import folder
from cycloid_mj.cli.simulate import logs_folder, require_possible
from cycloid_mj.cli.stressfiles import FIGURES, FILES, STEM, Drawn, outcome_of
from cycloid_mj.cli.terminal import tell
from cycloid_mj.design import Design
from cycloid_mj.papers import stress_references
from cycloid_mj.reducer import Reducer

if TYPE_CHECKING:
    from cycloid_mj.base.record import Run
    from cycloid_mj.stress.grid import Grid
    from cycloid_mj.stress.mounts import Mounts
    from cycloid_mj.stress.study import StressStudy, StudySettings

EXAMPLES = """Examples:
  cycloid-mj stress --design pin nonpin
  cycloid-mj stress --design pin --part gear pin_1 --quick --figure map
  cycloid-mj stress --log runs/pin.mcap --angle-deg 74 --out pin-stress
  cycloid-mj stress --design my.toml --load-nm 20 --json > stress.json
  cycloid-mj stress --design printed --springs --out parts"""

RUNS = "runs/stress"
GIGABYTE = 1e9

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
    LOAD.flag(
        "Load torque of the simulation, against the rotation of the output",
        f". Default: load.torque_nm of the design or, if that is 0, its {RATED}.",
    ),
]
AngleFlag = Annotated[
    float | None,
    Parameter(
        metavar="X",
        validator=within(0.0, 360.0),
        help="Crank angle of the stress maps and VTU files [deg]. Default: for each part, the angle of its "
        "largest bulk stress.",
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
class StressDelivery(Delivery):
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
        DesignNames,
        Parameter(
            help=f"Designs: presets ({NAMES}) or TOML files. Optional with --log, where they must match the logs."
        ),
    ],
    design: SeveralFlag = (),
    part: PartsFlag = (),
    log: LogsFlag = (),
    set_: SetFlag = (),
    at_c: TemperatureFlag = None,
    load_nm: LoadFlag = None,
    angle_deg: AngleFlag = None,
    quick: StressQuickFlag = False,
    solid: SolidFlag = False,
    springs: SpringsFlag = False,
    mounts: MountsFlag = None,
    figure: FiguresFlag = (),
    delivery: Annotated[StressDelivery, FLAT] = DELIVERED,
) -> int:
    """Compute the stress of the parts by finite elements.

    The loads are the contact forces of a logged run, with friction, applied as Hertz-wide patches, and inertia, at
    each degree of a crank turn. For each part, the tables list the largest von Mises stress away from the contacts
    (bulk) and below them (Hertz), its position and crank angle, the safety factor against yield, and its change under
    one more refinement of the grid; below, the stress at fillets and under other supports. A second table compares
    the designs of the paper without load with its figures (Hsieh 2014, Figs 10-16). stress.json, a VTU file of each
    part for ParaView, and the selected figures (png, svg) are written to --out.

    Bulk stress is the maximum beyond a distance d from narrow contacts and sharp inner corners, where it is on a
    plateau. The table lists d and the effect of its choice: the decrease of the stress to 2d, or its change for half
    or twice the distance from corners. Where the nominal stress times the notch factor of a fillet is larger, the
    safety factor is that of the fillet.

    Without --log, each design is simulated first: no ramp, and one turn after the load has settled. Requires the
    extra `fem`: gmsh, scikit-fem.
    """
    asked = (*designs, *design)
    if not asked and not log:
        raise UsageError("no design or log is given: name one, e.g. cycloid-mj stress --design pin")
    if log and (set_ or load_nm is not None):
        raise UsageError("--set and --load-nm have no effect on logs: remove them, or remove --log")
    if log and asked and len(log) != len(asked):
        raise UsageError(
            f"the number of designs ({len(asked)}) and of logs ({len(log)}) differ: name one design per --log, in the "
            "same order, or name no design"
        )
    from cycloid_mj.base.memory import keep_freed
    from cycloid_mj.stress.figures import for_one_turn
    from cycloid_mj.stress.packages import import_package
    from cycloid_mj.stress.study import QUICK, StudySettings

    for name in ("gmsh", "skfem"):
        import_package(name)
    keep_freed()
    if mounts is not None and not springs:
        raise UsageError("--mounts applies to --springs only: add --springs, or remove --mounts")
    if springs:
        if log or part or figure or solid or angle_deg is not None:
            raise UsageError(
                "--springs always covers all parts of the designs and cannot be combined with --log, --part, --figure, "
                "--solid or --angle-deg: remove those flags"
            )
        from cycloid_mj.stress.mounts import read_mounts

        told = None if mounts is None else read_mounts(Path(mounts))
        return _springs([Reducer(load_design(name, set_, (), at_c)) for name in asked], load_nm, told, delivery)
    settings = replace(
        QUICK if quick else StudySettings(),
        solid=solid,
        map_angle=None if angle_deg is None else math.radians(angle_deg),
    )
    if log:
        runs = _read(log, asked)
        planned = _plan_cost([ran for ran, _, _ in runs], part, settings, delivery.quiet)
        usual = f"{log[0].removesuffix('.mcap')}-stress"
        place = _place(folder(delivery.out or usual, "the figures", FILES, delivery.force), delivery)
    else:
        loaded = [for_one_turn(load_design(name, set_, (), at_c), load_nm) for name in asked]
        _require_apart(loaded)
        planned = _plan_cost(loaded, part, settings, delivery.quiet)
        names = (*(f"{item.name}.mcap" for item in loaded), *FILES)
        into = logs_folder(RUNS, delivery.out, names, delivery.force)
        place = _place(into, delivery)
        runs = _run(loaded, into, delivery)
    studies = _study_parts(runs, planned, settings, delivery.quiet)
    return deliver(outcome_of(studies, place, _figures(figure, place)), place, delivery)


def _springs(reducers: Sequence[Reducer], load: float | None, mounts: "Mounts | None", delivery: StressDelivery) -> int:
    """Write designs with the springs that their parts are, under a load [N m]."""
    from cycloid_mj.design import dump
    from cycloid_mj.stress.springs import part_springs

    designs = [item.design for item in reducers]
    _require_apart(designs)
    names = [f"{design.name}-springs.toml" for design in designs]
    place = _place(folder(delivery.out or RUNS, "the designs", [*names, *FILES], delivery.force), delivery)
    sprung = []
    for design in designs:
        if not delivery.quiet:
            tell(
                f"{design.name}: simulating without friction, then computing the compliance of its parts by finite "
                "elements at 12 crank angles"
            )
        torque = load if load is not None else design.load.torque or round(design.rated_torque, 9)
        sprung.append(part_springs(Reducer(design.but(load={"torque": torque})), mounts))
    outcome = Outcome(
        title="springs by finite elements",
        headline={item.design.name: item.text for item in sprung[:MOST_FIGURES]},
        tables=[item.table() for item in sprung],
        files={name: dump(item.design).encode() for name, item in zip(names, sprung, strict=True)},
        result={"designs": [item.as_json() for item in sprung]},
    )
    return deliver(outcome, place, delivery)


def _figures(asked: Sequence[str], place: Destination) -> tuple[Drawn, ...]:
    """Return the figures to draw: those requested, or those of the page."""
    if not asked:
        return ("map", "turn") if place.page else ()
    return tuple(name for name in FIGURES if name in asked or "all" in asked)


def _place(into: Path, wanted: Delivery) -> Destination:
    return Destination(STEM, into, claim_page(wanted, STEM, into))


def _run(designs: Sequence[Design], into: Path, wanted: Delivery) -> "list[Logged]":
    from cycloid_mj.cli.batch import run_all
    from cycloid_mj.log import read

    logs = {design: into / f"{design.name}.mcap" for design in designs}
    run_all(logs, wanted.force, wanted.quiet)
    return [(design, read(path), path) for design, path in logs.items()]


Logged = tuple[Design, "Run", Path]
Grids = dict[str, "Grid"]


def _require_apart(designs: Sequence[Design]) -> None:
    """Raise UsageError for designs of one name, or one that cannot run."""
    require_distinct(designs)
    for design in designs:
        require_possible(design)


def _plan_cost(designs: Sequence[Design], parts: Sequence[str], settings: "StudySettings", quiet: bool) -> list[Grids]:
    """Mesh the requested parts of every design, and print the time and memory that the study needs."""
    from cycloid_mj.stress.cost import add_costs, estimate_cost
    from cycloid_mj.stress.study import study_grids

    chosen = _parts_by_design(designs, parts)
    grids = [study_grids(Reducer(design), names, settings) for design, names in zip(designs, chosen, strict=True)]
    needed = add_costs(estimate_cost(grid, settings) for each in grids for grid in each.values())
    unknowns = sum(grid.unknowns for each in grids for grid in each.values())
    if not quiet:
        tell(
            f"finite elements: {unknowns:,} unknowns at {settings.angles} crank angles; about {needed.seconds:.0f} s "
            f"of CPU time and {needed.memory / GIGABYTE:.1f} GB of memory"
        )
    return grids


def _read(logs: Sequence[str], designs: Sequence[str]) -> list[Logged]:
    """Read the logs of designs."""
    from cycloid_mj.analysis.series import design_of
    from cycloid_mj.log import read
    from cycloid_mj.stress.turn import require_same

    logged: list[Logged] = []
    for number, name in enumerate(logs):
        run = read(Path(name))
        ran = design_of(run)
        warn(ran.name, run.warnings)
        if designs:
            require_same(Reducer(load_design(designs[number], (), ())), Reducer(ran))
        logged.append((ran, run, Path(name)))
    return logged


def _study_parts(
    runs: Sequence[Logged], planned: Sequence[Grids], settings: "StudySettings", quiet: bool
) -> "list[StressStudy]":
    """Compute the stress of the requested parts of every design, with progress."""
    from cycloid_mj.stress.cost import estimate_cost
    from cycloid_mj.stress.study import stress_study

    watch = _Watch([estimate_cost(grid, settings).seconds for grids in planned for grid in grids.values()], quiet)
    return [
        stress_study(
            run,
            Reducer(design),
            tuple(grids),
            settings,
            str(path),
            partial(watch.begins, design.name),
            grids,
            stress_references(Reducer(design)),
        )
        for (design, run, path), grids in zip(runs, planned, strict=True)
        if grids
    ]


def _parts_by_design(designs: Sequence[Design], parts: Sequence[str]) -> list[list[str]]:
    """Return the requested parts of each design; raise UsageError for a part that no design has."""
    from cycloid_mj.stress.loads import part_names, require_part

    for part in parts:
        if not any(part in part_names(Reducer(design)) for design in designs):
            require_part(Reducer(designs[0]), part)
    return [[part for part in part_names(Reducer(design)) if part in parts or not parts] for design in designs]


class _Watch:
    """Progress over parts, with the time left from the estimated cost of each part [s]."""

    def __init__(self, costs: Sequence[float], quiet: bool) -> None:
        self._costs = costs
        self._quiet = quiet
        self._begun = 0
        self._start = monotonic()

    def begins(self, design: str, part: str, number: int, of: int) -> None:
        done = sum(self._costs[: self._begun])
        left = (monotonic() - self._start) * (sum(self._costs) / done - 1.0) if done else None
        self._begun += 1
        if not self._quiet:
            estimate = "" if left is None else f", about {left:.0f} s left"
            tell(f"{design}: {part} ({number + 1} of {of} parts){estimate}")
