"""``cycloid-mj protocol``: standard test figures of a reducer, from the model and from a test bench."""

from functools import partial
from math import isfinite, isnan
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.outcome import Outcome
from cycloid_mj.cli.delivery import claim_destination, deliver
from cycloid_mj.cli.flags import DELIVERY, FLAT, PRESET, Delivery, PresetOptions, integer_flag
from cycloid_mj.cli.ranges import RANGES
from cycloid_mj.reducer import reducer_of

if TYPE_CHECKING:
    from cycloid_mj.bench.protocol import Protocol


LoopFlag = Annotated[
    tuple[Path, ...],
    Parameter(
        name="--loop",
        metavar="LOOP.csv",
        help="CSV file of a loop measured with the crank locked: columns torque_output_Nm, deflection_deg, "
        "in chronological order. Repeatable, one file for each crank angle.",
    ),
]
TeFlag = Annotated[
    Path | None,
    Parameter(
        name="--te", metavar="TE.csv", help="CSV file of the measured transmission error: columns crank_deg, te_arcsec."
    ),
]
StartingFlag = Annotated[
    Path | None,
    Parameter(
        metavar="START.csv",
        help="CSV file of a starting test: crank torque increased until the crank turns, no load; columns "
        "crank_deg, torque_crank_Nm.",
    ),
]
RunningFlag = Annotated[
    Path | None,
    Parameter(
        metavar="RUN.csv", help="CSV file of a no-load running test at constant crank speed: column torque_crank_Nm."
    ),
]
BackDrivingFlag = Annotated[
    Path | None,
    Parameter(
        metavar="BACK.csv",
        help="CSV file of a back-driving test: output torque increased until the crank turns; columns "
        "crank_deg, torque_output_Nm.",
    ),
]
RatedFlag = Annotated[
    float | None,
    Parameter(
        metavar="X",
        help="Rated output torque [N m]; the test figures are defined by shares of it. Default: that of the design.",
    ),
]
AnglesFlag = Annotated[
    int,
    integer_flag("Number of crank angles at which the model is evaluated, 1 to 360. Default: 6."),
]
EXAMPLES = """Examples:
  cycloid-mj protocol --design pin
  cycloid-mj protocol --design printed --rated-nm 24 --loop stiffness_loop.csv --html
  cycloid-mj protocol --design my.toml --loop at_0.csv --loop at_60.csv --te te.csv --running run.csv --out tests"""


def protocol(
    design_options: Annotated[PresetOptions, FLAT] = PRESET,
    *,
    loop: LoopFlag = (),
    te: TeFlag = None,
    starting: StartingFlag = None,
    running: RunningFlag = None,
    back_driving: BackDrivingFlag = None,
    rated_nm: RatedFlag = None,
    angles: AnglesFlag = 6,
    output_flags: Annotated[Delivery, FLAT] = DELIVERY,
) -> int:
    """Evaluate standard test figures of the model and of measurements.

    The figures are lost motion at 3 % of the rated torque, hysteresis loss, torsional stiffness in three intervals,
    transmission error, and no-load starting, running and back-driving torque. Each figure follows the definition of a
    manufacturer or standard, which is printed next to it. Loops of the model and of the bench are evaluated by the same
    functions. A figure without a bench file is printed for the model only. docs/protocol.md describes the measurements.
    """
    from cycloid_mj.bench import read_loop, read_te
    from cycloid_mj.bench.protocol import BenchFiles
    from cycloid_mj.bench.protocol import protocol as compute_protocol
    from cycloid_mj.cli.progress import count_progress

    if rated_nm is not None and not (rated_nm > 0.0 and isfinite(rated_nm)):
        raise UsageError(f"--rated-nm {rated_nm:g} is out of range: give a finite torque greater than 0 N m")
    low, high = RANGES.angles
    if not low <= angles <= high:
        raise UsageError(f"--angles {angles} is out of range: give a number from {low} to {high}")
    files = BenchFiles(
        tuple(read_loop(path) for path in loop), read_te(te) if te else None, starting, running, back_driving
    )
    design = design_options.resolve_checked()
    destination = claim_destination(
        output_flags, f"{design.name}-protocol", [f"{design.name}-protocol{ending}" for ending in (".png", ".svg")]
    )
    sheet = compute_protocol(
        reducer_of(design),
        files,
        rated_nm or design.rated_torque,
        angles,
        count_progress("protocol", output_flags.quiet),
    )
    return deliver(_outcome(sheet), destination, output_flags)


def _outcome(test_protocol: "Protocol") -> Outcome:
    """Convert a test protocol to printable results: quantities of model and bench, their definitions, diagram.

    Each quantity in the headline is that of the bench if it was measured, else that of the model.
    """
    from cycloid_mj.base.result import to_json_values
    from cycloid_mj.bench.protocol import LINES
    from cycloid_mj.plots.bench import protocol_figure
    from cycloid_mj.plots.save import encode_figure

    measured_keys = {key for key, figure in test_protocol.bench.items() if not isnan(figure.value)}
    headline_figures = {
        key: test_protocol.bench[key] if key in measured_keys else figure for key, figure in test_protocol.model.items()
    }
    return Outcome(
        title=f"protocol of {test_protocol.design}",
        condition=f"rated torque {test_protocol.rated:.4g} N m",
        headline={
            f"{LINES[key].name}{', bench' if key in measured_keys else ''}": f"{figure.value:.4g} {LINES[key].unit}"
            for key, figure in headline_figures.items()
        },
        tables=[test_protocol.table()],
        frame=test_protocol.frame,
        notes=[*test_protocol.notes, *(f"{line.name}: {line.definition} ({line.source})" for line in LINES.values())],
        pictures={f"{test_protocol.design}-protocol": partial(encode_figure, protocol_figure(test_protocol))},
        result=to_json_values(test_protocol.as_json()),
    )
