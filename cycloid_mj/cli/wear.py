"""``cycloid-mj wear``: wear of a drive over its hours, and its accuracy life."""

from functools import partial
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.outcome import Outcome
from cycloid_mj.cli.delivery import Destination, claim_destination, deliver
from cycloid_mj.cli.duty import DutyFlag, LoadFlag, SpeedFlag, duty_cycle
from cycloid_mj.cli.flags import DELIVERY, FLAT, PRESET, Delivery, PresetOptions
from cycloid_mj.cli.progress import count_progress
from cycloid_mj.cli.terminal import tell

if TYPE_CHECKING:
    from cycloid_mj.life.accuracy_life import WearLife

HoursFlag = Annotated[float, Parameter(metavar="H", help="Hours of running. Default: 1000.")]
GrowthFlag = Annotated[
    float,
    Parameter(
        metavar="X",
        help="Growth of the lost motion at which the accuracy life ends [%]. Default: 100 (twice the initial lost "
        "motion), as `rate` limits wear to twice the initial clearance.",
    ),
]
EXAMPLES = """Examples:
  cycloid-mj wear pin --hours 1000
  cycloid-mj wear my.toml --hours 6000 --growth-percent 30 --json
  cycloid-mj wear my.toml --hours 1000 --duty duty.csv --out worn --html"""


def wear(
    design_options: Annotated[PresetOptions, FLAT] = PRESET,
    *,
    hours: HoursFlag = 1000.0,
    growth_percent: GrowthFlag = 100.0,
    load_nm: LoadFlag = None,
    speed_rpm: SpeedFlag = None,
    duty: DutyFlag = None,
    output_flags: Annotated[Delivery, FLAT] = DELIVERY,
) -> int:
    """Compute the wear of a drive over its running hours, and its accuracy life.

    Flanks, pins, holes and plain bearings wear at each point by Archard's law: wear coefficient times pressure times
    sliding distance over a turn. After each step, statics is solved again with the worn parts. New surfaces run in:
    their coefficient starts at 30 times its final value and falls while the roughness is worn off. The drive turns half
    of the time in each direction.

    Wear coefficients follow from the materials, or are set by service.wear_coefficient_mm3_nm and
    service.run_in_depth_um. They are known only within a factor of ten. Wear is therefore computed three times: with
    the typical coefficients, and with all coefficients at their 5 and 95 % percentiles.

    The accuracy life is the time until the lost motion has grown by --growth-percent, or a part is worn through. If it
    exceeds --hours, it is extrapolated by the law of wear and run-in with the last contact forces. The JSON has
    accuracy_life_h, accuracy_life_interval_h, accuracy_life_extrapolated, records (accuracy, forces and wear depths at
    several times) and the depths of all surfaces. Ctrl-C keeps the finished steps.
    """
    from cycloid_mj.life.accuracy_life import wear as compute
    from cycloid_mj.life.wear_course import CASES

    for flag, value in (("--hours", hours), ("--growth-percent", growth_percent)):
        if not 0.0 < value < float("inf"):
            raise UsageError(f"{flag} {value:g} is out of range: give a finite number greater than 0")
    design = design_options.resolve_checked()
    cycle = duty_cycle(design, load_nm, speed_rpm, duty)
    destination = claim_destination(output_flags, f"{design.name}-wear")
    print_progress = count_progress("wear, percent", output_flags.quiet)

    def report_progress(case: str, share: float) -> None:
        print_progress(round(100 * (CASES.index(case) + share) / len(CASES)), 100)

    wear_life = compute(design, hours, growth_percent / 100.0, cycle, on_progress=report_progress)
    if wear_life.interrupted:
        tell("stopped by Ctrl-C: the result contains only the completed steps")
    return deliver(_outcome(wear_life, destination), destination, output_flags)


def _outcome(result: "WearLife", destination: Destination) -> Outcome:
    """Convert the `result` of a wear computation to printable output: headline, tables and diagram.

    The headline has the accuracy life: the time until the lost motion has grown by `WearLife.growth`. The tables have
    accuracy, forces and wear depths at several times, and the worn surfaces. `destination` has the paths of the output
    files; the diagram is drawn only if there is one.
    """
    from cycloid_mj.base.units import ARCMINUTE
    from cycloid_mj.plots.save import encode_figure
    from cycloid_mj.plots.wear import wear_figure

    typical_course, picture_name = result.courses["typical"], f"{result.design}-wear"
    initial_lost_motion, final_lost_motion = (
        typical_course.lost_motion[0] / ARCMINUTE,
        typical_course.lost_motion[-1] / ARCMINUTE,
    )
    return Outcome(
        title=f"wear: {result.design}",
        condition=result.condition,
        headline={
            f"accuracy life (lost motion {result.growth:+.0%})": result.life_text(),
            "its 5 to 95 % interval": result.interval_text,
            "lost motion, new": f"{initial_lost_motion:.4g} arcmin",
            f"lost motion after {typical_course.hours[-1]:.4g} h": f"{final_lost_motion:.4g} arcmin",
            "worn volume by run-in": f"{result.run_in_share:.0%}",
        },
        warnings=["stopped before all courses were finished"] if result.interrupted else [],
        summary=[f"{case}: {course.end}" for case, course in result.courses.items()],
        tables=result.tables(),
        notes=[f"assumed: {sentence}" for sentence in result.assumptions],
        pictures={picture_name: partial(encode_figure, wear_figure(result))}
        if destination.folder or destination.page
        else {},
        captions={picture_name: "Lost motion over the hours with its interval, and depths of wear."},
        frame=result.frame,
        result=result.as_json(),
        code=130 if result.interrupted else 0,
    )
