"""``cycloid-mj rate``: life and safety of each part of a reducer, the weakest first."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.outcome import Outcome
from cycloid_mj.cli.delivery import Destination, claim_destination, deliver
from cycloid_mj.cli.duty import DutyFlag, LoadFlag, SpeedFlag, duty_cycle
from cycloid_mj.cli.flags import DELIVERY, FLAT, PRESET, Delivery, PresetOptions
from cycloid_mj.reducer import Reducer

if TYPE_CHECKING:
    from cycloid_mj.life import Rating

LifeFlag = Annotated[float | None, Parameter(metavar="X", help="Required life [h]. Default: service.life_h.")]
PeakFlag = Annotated[
    float | None,
    Parameter(
        metavar="X", help="Torque of an emergency stop [N m]. Default: twice the maximum torque of the duty cycle."
    ),
]
StressFlag = Annotated[
    Path | None,
    Parameter(
        metavar="DIR",
        help="Folder or stress.json of `cycloid-mj stress` for this design: disc and ring are rated by the "
        "stress range of each node instead of beam formulas.",
    ),
]
PartsFlag = Annotated[
    Literal["perfect", "toleranced"] | None,
    Parameter(
        help="Parts that are rated: perfect, or samples within [tolerance] (RV reducers: [crank_tolerance]) at the "
        "95th percentile of the forces. "
        "Default: toleranced if the design has tolerances.",
    ),
]
CheckFlag = Annotated[
    bool, Parameter(name="--check", negative="", help="Exit with code 1 if an item does not meet its requirement.")
]
EXAMPLES = """Examples:
  cycloid-mj rate --design pin
  cycloid-mj rate --design my.toml --parts perfect
  cycloid-mj rate --design my.toml --load-nm 20 --speed-rpm 1000 --life-h 6000
  cycloid-mj rate --design my.toml --duty duty.csv --json
  cycloid-mj rate --design my.toml --check
  cycloid-mj stress --design pin --out s && cycloid-mj rate --design pin --stress s --html"""


def rate(
    design_options: Annotated[PresetOptions, FLAT] = PRESET,
    *,
    load_nm: LoadFlag = None,
    speed_rpm: SpeedFlag = None,
    duty: DutyFlag = None,
    life_h: LifeFlag = None,
    peak_nm: PeakFlag = None,
    stress: StressFlag = None,
    parts: PartsFlag = None,
    check: CheckFlag = False,
    output_flags: Annotated[Delivery, FLAT] = DELIVERY,
) -> int:
    """Rate life, fatigue, wear and heat, the weakest item first.

    Loads are computed by statics with the real clearances and friction: at the nominal torque and speed, at other
    values, or over a duty cycle (Miner's rule; a rest has the speed 0).

    Bearings are rated by ISO 281 (life) and ISO 76 (static safety), surfaces by first yield, shakedown and pitting.
    Shaft, output pins, disc and ring are rated for fatigue (Goodman, with notch, surface, size and reliability),
    sliding surfaces for wear (Archard). The temperature of the housing in still air is compared with the lowest limit
    of grease, seals and materials. All parts and joints (screws, dowels, press fits, inserts) are rated for an
    emergency stop at the peak torque. The load of the cam is computed for several stiffnesses of its bearing, which are
    assumed. --parts chooses between perfect parts and random samples within the tolerances. --stress rates disc and
    ring by the results of `cycloid-mj stress` instead of beam formulas.

    Values that the design file does not state are assumed, and printed next to the result. Set them in [bearing] and
    [service]. The exit code is 0 for any safety factor, unless --check is set.
    """
    from cycloid_mj.life.as_built import default_parts
    from cycloid_mj.life.items import rate as compute_rating
    from cycloid_mj.life.ranges import read_ranges

    for flag, value in (("--life-h", life_h), ("--peak-nm", peak_nm)):
        if value is not None and not 0.0 < value < float("inf"):
            raise UsageError(f"{flag} {value:g} is out of range: give a finite number greater than 0")
    design = design_options.resolve_checked()
    cycle = duty_cycle(design, load_nm, speed_rpm, duty, peak_nm)
    ranges = read_ranges(stress, Reducer(design)) if stress else None
    destination = claim_destination(output_flags, f"{design.name}-rating")
    rating = compute_rating(design, cycle, life_h or 0.0, ranges, compliance=True, parts=parts or default_parts(design))
    outcome = _outcome(rating, destination)
    return deliver(replace(outcome, code=1) if check and rating.failing else outcome, destination, output_flags)


def _outcome(rating: "Rating", destination: Destination) -> Outcome:
    """Convert a rating to printable results: parts with their kinds of failure, the weakest first, and assumptions.

    `destination` has the path of the page, if one is written; the summary names it.
    """
    from cycloid_mj.report.rating import rating_page

    weakest, failing_items = rating.weakest, rating.failing
    return Outcome(
        title=f"rating: {rating.design}",
        condition=f"{rating.duty}, for {rating.life:g} h, parts {rating.parts}",
        headline={
            "weakest item": weakest.name,
            "its life" if weakest.safety is None else "its safety": weakest.verdict,
            "items that do not meet the requirement": f"{len(failing_items)} of {len(rating.items)}",
        },
        failures=[rating.line_of(item) for item in failing_items],
        warnings=[rating.line_of(item) for item in rating.warnings],
        summary=[f"weakest: {rating.weakest_line()}", *([str(destination.page)] if destination.page else [])],
        tables=[rating.table(), *([rating.cam_compliance.table()] if rating.cam_compliance else [])],
        notes=[f"assumed: {sentence}" for sentence in rating.assumptions],
        frame=rating.frame,
        result=rating.as_json(),
        page=lambda: rating_page(rating),
    )
