"""``cycloid-mj thermal``: steady temperatures, warm-up and thermal limits of a drive."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from math import isinf
from typing import TYPE_CHECKING, Annotated

from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.outcome import Outcome
from cycloid_mj.cli.delivery import Destination, claim_destination, deliver
from cycloid_mj.cli.duty import DutyFlag, LoadFlag, SpeedFlag, duty_cycle
from cycloid_mj.cli.flags import DELIVERY, FLAT, PRESET, Delivery, PresetOptions, number_flag
from cycloid_mj.design import Design

if TYPE_CHECKING:
    from cycloid_mj.life.duty import Duty
    from cycloid_mj.life.thermal_state import ThermalState

CYCLES = (0.1, 1440.0)
"""Smallest and largest duration of a duty cycle [min]; shorter cycles heat as their mean."""

CycleFlag = Annotated[
    float | None,
    number_flag(
        f"Duration of one cycle of --duty [min], {CYCLES[0]:g} to {CYCLES[1]:g}. Its points follow in the order "
        "of the file. Default: 10, as for intermittent duty (S3, IEC 60034-1).",
        CYCLES,
        metavar="N",
    ),
]

EXAMPLES = """Examples:
  cycloid-mj thermal pin
  cycloid-mj thermal my.toml --load-nm 20 --speed-rpm 1000 --json
  cycloid-mj thermal my.toml --duty duty.csv --cycle-min 5 --html
  cycloid-mj thermal my.toml --duty duty.csv --set service.ambient_temperature_c=40 --html"""


def thermal(
    design_options: Annotated[PresetOptions, FLAT] = PRESET,
    *,
    load_nm: LoadFlag = None,
    speed_rpm: SpeedFlag = None,
    duty: DutyFlag = None,
    cycle_min: CycleFlag = None,
    output_flags: Annotated[Delivery, FLAT] = DELIVERY,
) -> int:
    """Compute temperatures, warm-up and thermal limits of a drive.

    A thermal network connects disc, ring, crank, output, housing and air. Losses heat the parts, temperatures change
    the clearances, and clearances change the losses; this is repeated until all three agree. Heat flows through line
    contacts, grease gaps, bearings and clamped faces. The housing is cooled by service.film_coefficient_w_m2_k; 0
    selects convection and radiation by ISO/TR 14179-2. The table [thermal] sets grease, gaps and joints.

    A disc that is warmer than its ring closes the clearance of the teeth. The command prints the temperature difference
    and the difference at which the teeth jam; the exit code is 0 even if they jam. The teeth of an RV reducer become
    preloaded instead of jamming. Temperatures that --at-c or the design set are not used.

    The warm-up starts at the temperature of the air. With --duty, the points of the file repeat in cycles. Without it,
    the drive runs for the share service.duty_share of each cycle and rests for the remaining time, as it does for
    the torque limits by duty. The JSON has temperatures_c, jam_difference_k, losses_w, thermal_torque_nm and
    time_constant_s; a limit that is never reached is null.
    """
    from cycloid_mj.life.heat_and_strength import thermal_of

    design = design_options.resolve_checked()
    cycle = duty_cycle(design, load_nm, speed_rpm, duty)
    if cycle_min is not None:
        if not duty and design.service.duty_share == 1.0:
            raise UsageError(
                "--cycle-min needs a duty cycle: add --duty, set service.duty_share below 1, or remove --cycle-min"
            )
        cycle = replace(cycle, period=60.0 * cycle_min)
    destination = claim_destination(output_flags, f"{design.name}-thermal")
    state = thermal_of(design, cycle)
    return deliver(_outcome(state, list(_warnings(state, design, cycle)), destination), destination, output_flags)


def _warnings(state: "ThermalState", design: Design, cycle: "Duty") -> Iterator[str]:
    """Yield warnings about a thermal state: a torque limit below the torque, preloaded teeth, ignored temperatures.

    The torque is the largest of the duty `cycle`.
    """
    torque = max(abs(point.torque) for point in cycle.points)
    if not state.jams and state.torque < torque:
        remedy = (
            f"reduce the torque to {state.torque:.3g} N m" if state.torque else "lower service.ambient_temperature_c"
        )
        yield f"{state.design}: too hot at {torque:.4g} N m (limit: {state.limited_by}): {remedy}, or cool the housing"
    if state.can_preload and state.play < 0.0:
        yield (
            f"{state.design}: warm discs expand by {-1e6 * state.play:.3g} um more than the ring and their clearance "
            "allow: the teeth are preloaded, and lose more power"
        )
    if words := design.thermal.words:
        yield f"{state.design}: the temperatures of the parts are computed; those of the design are not used ({words})"


def _outcome(state: "ThermalState", warnings: list[str], destination: Destination) -> Outcome:
    """Convert the thermal state of a drive to printable results: temperatures, limits, losses, warm-up curves.

    `destination` has the paths of the output files.
    """
    from cycloid_mj.base.result import quantity_table
    from cycloid_mj.design.model import PARTNERS
    from cycloid_mj.geometry.expansion import BODY_OF
    from cycloid_mj.plots.measure import curves_figure
    from cycloid_mj.plots.save import encode_figure

    failures, name = [], f"{state.design}-thermal"
    if state.jams_when_steady:
        pair, clearance = min(state.clearances.items(), key=lambda item: item[1])
        inner_body, outer_body = (BODY_OF[part] for part in PARTNERS[pair])
        cause = (
            f"the disc is {state.difference:.3g} K warmer than the ring, and {state.jam_difference:.3g} K close the "
            "teeth"
            if state.play <= min(0.0, clearance)
            else f"the clearance of {pair.replace('_', ' ')} changes to {1e6 * clearance:.3g} um, with the "
            f"{inner_body} at {state.temperatures[inner_body]:.3g} °C and the {outer_body} at "
            f"{state.temperatures[outer_body]:.3g} °C"
        )
        failures.append(
            f"the parts jam when warm: {cause}. Reduce the torque to {state.torque:.3g} N m, or increase the clearances"
        )
    elif state.jams:
        failures.append(
            f"the parts jam after {state.tightest.time / 60.0:.3g} min, although not at their mean temperatures: the "
            f"radial play of the teeth is then {1e6 * state.tightest.play:.3g} um, the clearance of "
            f"{state.tightest.pair.replace('_', ' ')} {1e6 * state.tightest.clearance:.3g} um. Reduce the torques to "
            f"{state.torque:.3g} N m at most, shorten the cycle (--cycle-min), or increase the clearances"
        )
    return Outcome(
        title=f"temperatures: {state.design}",
        condition=state.condition,
        headline={
            **{part: f"{value:.1f} °C" for part, value in state.temperatures.items()},
            "disc warmer than ring (jams at)": f"{state.difference:.3g} K ({state.jam_difference:.3g} K)",
            "thermal torque limit": "none" if isinf(state.torque) else f"{state.torque:.4g} N m: {state.torque_words}",
            "slowest time constant": f"{state.network.time_constant / 60.0:.3g} min",
        },
        failures=failures,
        warnings=warnings,
        tables=[quantity_table("Figures", list(state.quantities.values())), *state.tables()],
        notes=[f"assumed: {sentence}" for sentence in state.assumptions],
        pictures={name: partial(encode_figure, curves_figure(state.curves))}
        if destination.folder or destination.page
        else {},
        frame=state.frame,
        result=state.as_json(),
    )
