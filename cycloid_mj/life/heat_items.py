"""Rated items of heat: losses, housing temperature, clearances, jam by heat, and the thermal torque limit."""

import math
from collections.abc import Iterator, Sequence

from cycloid_mj.base.units import RPM
from cycloid_mj.design import PARTNERS, Design
from cycloid_mj.design.model import REFERENCE_TEMPERATURE
from cycloid_mj.geometry.expansion import jam_difference
from cycloid_mj.life.duty import Duty
from cycloid_mj.life.heat import (
    STILL_AIR,
    clearance_growth,
    cooling_area,
    heat_limits,
    heat_transfer_coefficient,
    housing_temperature,
    mean_losses,
    running_share,
)
from cycloid_mj.life.item import ItemKind, RatedItem
from cycloid_mj.life.loading import Loading
from cycloid_mj.life.steady_state import SteadyState, estimate_rises
from cycloid_mj.life.thermal import thermal
from cycloid_mj.parts.export.drive import has_casing
from cycloid_mj.reducer import Reducer, RvReducer, reducer_of


def rate_heat(
    reducer: Reducer, loadings: Sequence[Loading], steady_state: SteadyState | None = None
) -> Iterator[RatedItem]:
    """Yield the rated items on heat: power lost [W], housing temperature [°C], loss of clearance by expansion [um].

    `loadings` are the solved forces at each point of the duty. Losses and housing temperature are those of
    `steady_state`, or without one those of the loadings. For the clearances of teeth, output pins and cam, all parts
    are assumed to have the temperature of the housing.
    """
    design = reducer.design
    service = design.service
    share = running_share(reducer, loadings)
    if steady_state is None:
        losses = mean_losses(reducer, loadings)
        temperature = housing_temperature(reducer, share * sum(losses.values()))
    else:
        losses = {part: power / share for part, power in steady_state.losses.items()}
        temperature = steady_state.temperatures["housing"]
    total_loss = sum(losses.values())
    area = cooling_area(reducer)
    film_coefficient = heat_transfer_coefficient(reducer, temperature)
    yield RatedItem(
        "power_lost",
        "power lost",
        total_loss,
        math.nan,
        "W",
        None,
        None,
        "friction of teeth, cam, output pins and seals, mu F d/2 of the bearings of shaft and output; mean of the duty",
        ", ".join(f"{part.replace('_', ' ')} {power:.3g} W" for part, power in losses.items())
        + ("" if has_casing(reducer) else "; without the output's bearing, as the drive has no covers")
        + (f"; {steady_state.words}" if steady_state else ""),
    )
    highest_temperature, lowest_temperature = (
        service.ambient_temperature + share * total_loss / (coefficient * area) for coefficient in STILL_AIR
    )
    yield rate_housing_temperature(
        reducer,
        temperature,
        "dT = losses/(h A)" if steady_state is None else "thermal network with the losses at its temperatures",
        f"{total_loss:.3g} W{'' if share == 1.0 else f' for {share:.0%} of the time'} "
        f"at h = {film_coefficient:.3g} W/(m2 K) (assumed; {highest_temperature:.3g} to {lowest_temperature:.3g} °C "
        f"at 8 to 15) on {1e4 * area:.3g} cm2, the outside of {_describe_cooled_outside(reducer)}; "
        f"ambient {service.ambient_temperature:g} °C",
    )
    yield from _rate_hot_clearances(reducer, temperature)


def _rate_hot_clearances(reducer: Reducer, temperature: float) -> Iterator[RatedItem]:
    """Rate the loss of clearance [um] of each kind of mating pair if all parts have a temperature [°C].

    The clearance of the teeth includes that of moving pins in their seats.
    """
    design = reducer.design
    for kind in design.pair_kinds:
        clearance, growth, note = getattr(design.clearance, kind), clearance_growth(reducer, kind), ""
        if kind == design.tooth_pair and design.seat_pair:  # pins recede within their seats
            clearance, growth = clearance + design.pin_play, growth + clearance_growth(reducer, design.seat_pair)
            note = f"; with the clearance of {design.seat_pair.replace('_', ' ')}"
        clearance_change = growth * (temperature - REFERENCE_TEMPERATURE)
        materials = " on ".join(design.material_of(part).name or "unnamed" for part in PARTNERS[kind])
        yield RatedItem(
            f"{kind}_hot_clearance",
            f"clearance of {kind.replace('_', ' ')} lost by heat",
            0.0 - 1e6 * clearance_change,
            1e6 * clearance,
            "um",
            clearance / -clearance_change if clearance_change < 0.0 else math.inf,
            None,
            "thermal expansion of both parts from 20 °C; safety factor of the clearance",
            f"all parts at the housing's {temperature:.3g} °C (assumed); {materials}{note}; "
            "negative: the clearance grows",
        )


def rate_housing_temperature(reducer: Reducer, temperature: float, source: str, note: str) -> RatedItem:
    """Rate a temperature of the housing [°C] against the lowest temperature limit of grease, seals and materials.

    `source` is the formula of the temperature. `note` states its conditions, to which all limits are added.
    """
    limits = sorted(heat_limits(reducer), key=lambda limit: limit.temperature)
    lowest_limit, ambient = limits[0], reducer.design.service.ambient_temperature
    return RatedItem(
        "temperature",
        f"housing temperature, {lowest_limit.name}",
        temperature,
        lowest_limit.temperature,
        "°C",
        (lowest_limit.temperature - ambient) / (temperature - ambient) if temperature > ambient else math.inf,
        None,
        f"{source}; safety factor of the temperature rise",
        f"{note}; limits: {', '.join(f'{limit.temperature:g} °C {limit.name} ({limit.source})' for limit in limits)}",
        ItemKind.HEAT,
    )


def _describe_cooled_outside(reducer: Reducer) -> str:
    """Return the name of the body whose outside is `cooling_area`, for messages."""
    return "the covers, without their flanges" if has_casing(reducer) else "ring and output disc"


def rate_jam_difference(
    reducer: Reducer, loadings: Sequence[Loading], steady_state: SteadyState | None = None
) -> Iterator[RatedItem]:
    """Yield the rating of the temperature difference of disc and ring [K] against that at which the teeth jam.

    With rests (``service.duty_share``), the difference is the mean over running and rest. It is that of the steady
    state of the duty. If `steady_state` is None, it follows from the losses and conductances of the `loadings`, the
    solved forces at each point of the duty.
    """
    share, limit = running_share(reducer, loadings), jam_difference(reducer.design)
    if steady_state is not None:
        difference = steady_state.difference
    else:
        losses, ambient = mean_losses(reducer, loadings), reducer.design.service.ambient_temperature
        rises = estimate_rises(reducer, loadings, losses, ambient)
        difference = share * (rises["disc"] - rises["ring"])
    yield RatedItem(
        "jam_difference",
        "disc warmer than the ring",
        difference,
        limit,
        "K",
        limit / difference if difference > 0.0 else math.inf,
        None,
        "thermal network; limit: play/(alpha (E - rho)) of the teeth",
        f"{'' if share == 1.0 else f'running for {share:.0%} of the time, mean of the cycles; '}"
        "conductances of grease, bearings and joints are assumed ([thermal]); all temperatures: `cycloid-mj thermal`",
    )


def rate_thermal_limits(design: Design, duty: Duty) -> Iterator[RatedItem]:
    """Yield the rating of the largest torque of a duty [N m] against the torque that the steady temperatures allow.

    For an RV reducer, which `rate_heat` does not support, the housing temperature [°C] is rated too.

    Raises
    ------
    DesignError
        The crank does not turn.
    RunError
        No static equilibrium exists under a torque of the duty.
    """
    state = thermal(design, duty)
    torque = max(abs(point.torque) for point in duty.points)
    yield RatedItem(
        "thermal_torque",
        "thermal torque limit",
        torque,
        state.torque,
        "N m",
        state.torque / torque,
        None,
        f"steady state of the thermal network; limit: {state.limited_by}",
        f"disc {state.difference:.3g} K warmer than the ring, {state.jam_difference:.3g} K close the teeth; up to "
        f"{state.speed / RPM:.4g} rpm at this torque; conductances are assumed ([thermal]): see `cycloid-mj thermal`",
        ItemKind.HEAT,
    )
    if design.layout != RvReducer.LAYOUT:
        return
    reducer, max_housing_temperature = reducer_of(design), max(state.temperatures["housing"], state.peaks["housing"])
    yield rate_housing_temperature(
        reducer,
        max_housing_temperature,
        "thermal network with the losses of the duty",
        f"{sum(state.losses.values()):.3g} W at h = "
        f"{heat_transfer_coefficient(reducer, max_housing_temperature):.3g} W/(m2 K) (assumed); {state.condition}",
    )
