"""Steady temperatures of a drive, its warm-up, and the torque and speed that heat allows."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cycloid_mj.base.errors import DesignError, RunError
from cycloid_mj.base.units import RPM
from cycloid_mj.design import Design, Named, resolve
from cycloid_mj.design.model import HEATED
from cycloid_mj.geometry.expansion import jam_difference, tooth_play, warm_clearances
from cycloid_mj.life.duty import Duty, DutyPoint, constant_duty
from cycloid_mj.life.heat import heat_limits, mean_losses
from cycloid_mj.life.item import RatedItem
from cycloid_mj.life.loading import POSES, Loading, solve_loading
from cycloid_mj.life.thermal_course import HeatingPoint, TemperatureCourse, solve_course
from cycloid_mj.life.thermal_network import Conductance, Network, build_network, heat_by_node, heat_capacities
from cycloid_mj.life.thermal_state import ThermalState
from cycloid_mj.reducer import Reducer


@dataclass(frozen=True)
class ThermalSettings:
    """Settings of the fixed point of losses and temperatures, and of the search for the limits.

    Attributes
    ----------
    tolerance
        Change of every temperature in a round at which it ends [K]; far below what the assumed conductances leave open.
    rounds
        Largest number of rounds.
    hottest
        Temperature at which the rounds end [°C], as the largest of a design file: no drive gets so hot.
    largest
        Largest multiple of torque or speed that is searched.
    solved, corrections, resolution
        Up to this multiple a limit is corrected by the steady state there, so many times at most, or until it changes
        by no more than the relative resolution.
    samples, time_constants
        Steps of the warm-up, and its duration over the slowest time constant.
    duty_shares
        Shares of the time of intermittent duties (S3) whose torque limit is reported: those of IEC 60034-1.
    light_load
        Load over that of the duty which, with the duty's own, determines how losses grow with the torque.
    """

    tolerance: float = 0.05
    rounds: int = 12
    hottest: float = 300.0
    largest: float = 100.0
    solved: float = 1.5
    corrections: int = 5
    resolution: float = 0.01
    samples: int = 120
    time_constants: float = 4.0
    duty_shares: tuple[float, ...] = (0.15, 0.25, 0.4, 0.6, 1.0)
    light_load: float = 0.25


SETTINGS = ThermalSettings()


def thermal(design: Named, duty: Duty | None = None, settings: ThermalSettings = SETTINGS) -> ThermalState:
    """Compute the steady temperatures of a drive, its warm-up and its thermal limits.

    Parameters
    ----------
    design
        A design, or the name of a preset or a file; its own ``[thermal]`` temperatures are not used.
    duty, settings
        Duty cycle, by default the nominal torque at the design's speed; and settings of the search.

    Returns
    -------
    ThermalState
        Temperatures of the parts, curves of the warm-up, and limits.

    Raises
    ------
    DesignError
        The crank does not turn.
    RunError
        No static equilibrium at 20 °C under a torque of the duty.
    """
    reducer = Reducer(resolve(design).at_reference)
    duty = duty or constant_duty(reducer.design.rated_torque, reducer.design.drive.speed)
    points = [point for point in duty.points if point.speed]
    if not points:
        raise DesignError(
            f"{reducer.design.name}: drive.speed_rpm is 0, but the drive heats up only while the crank turns: set a "
            "speed other than 0, such as 1640 rpm"
        )
    steady_state = _solve_steady_state(reducer, points, settings)
    temperatures, heat = steady_state.temperatures, heat_by_node(reducer, steady_state.losses)
    warm = _at(reducer.design, temperatures)
    by_torque, limited_by = _largest_duty_factor(
        reducer, lambda share: [replace(point, torque=share * point.torque) for point in points], steady_state, settings
    )
    by_speed, _ = _largest_duty_factor(
        reducer, lambda share: [replace(point, speed=share * point.speed) for point in points], steady_state, settings
    )
    ambient = reducer.design.service.ambient_temperature
    course = _solve_warm_up(reducer, duty, steady_state, settings)
    return ThermalState(
        design=reducer.design.name,
        condition=f"{duty.words}, ambient {ambient:g} °C",
        temperatures=temperatures,
        losses=steady_state.losses,
        heat=heat,
        network=steady_state.network,
        difference=temperatures["disc"] - temperatures["ring"],
        jam_difference=jam_difference(reducer.design),
        clearances=warm_clearances(warm),
        play=tooth_play(warm),
        torque=by_torque * max(abs(point.torque) for point in points),
        speed=by_speed * max(point.speed for point in points),
        limited_by=limited_by,
        duty_torques=_torques_by_duty(reducer, points, by_torque, steady_state, settings),
        times=course.times,
        warm_up={part: ambient + rise for part, rise in course.rises.items()},
        peaks={part: ambient + course.peak(part) for part in HEATED},
        largest_difference=float(np.max(course.rises["disc"] - course.rises["ring"])),
        converged=steady_state.converged,
        assumptions=tuple(_assumptions(reducer, steady_state)),
    )


@dataclass(frozen=True)
class _Steady:
    """Temperatures, losses and network of a steady state.

    Attributes
    ----------
    temperatures
        Temperature of each part [°C].
    losses
        Mean losses of the duty by source [W].
    network
        Conductances, and heat capacities of the parts at 20 °C.
    converged
        Whether losses and temperatures agree.
    cold, warm
        Losses by source while the drive is at each point of the duty [W], at 20 °C and at the temperatures of `losses`.
    warm_temperature
        Temperature of the disc of `warm` [°C].
    """

    temperatures: dict[str, float]
    losses: dict[str, float]
    network: Network
    converged: bool
    cold: tuple[dict[str, float], ...]
    warm: tuple[dict[str, float], ...]
    warm_temperature: float


def _solve_steady_state(
    reducer: Reducer, points: Sequence[DutyPoint], settings: ThermalSettings, start: _Steady | None = None
) -> _Steady:
    """Solve losses and temperatures that agree with each other, by successive substitution.

    It begins at the temperature of the air, or at the temperatures of a converged state `start` of a similar duty.
    Losses and conductances are those of the warm clearances. If the parts jam at the temperatures of a round, the
    losses of the round before it remain, and the state is not converged.
    """
    ambient = reducer.design.service.ambient_temperature
    temperatures, capacities = dict.fromkeys(HEATED, ambient), start.network.capacities if start else None
    warm, has_converged, cold = reducer, False, None
    if start and start.converged:
        temperatures = start.temperatures
        warm = Reducer(_at(reducer.design, temperatures))
    capacities = capacities or heat_capacities(reducer)
    for _ in range(settings.rounds):
        by_point, network = _solve_losses(warm, points, temperatures["housing"], capacities)
        losses, cold = _mean(points, by_point), cold or by_point
        warm_temperature = warm.design.thermal.disc
        rises = network.rises(heat_by_node(reducer, losses))
        previous, temperatures = temperatures, {part: ambient + rise for part, rise in rises.items()}
        if max(abs(temperatures[part] - previous[part]) for part in HEATED) < settings.tolerance:
            has_converged = True
            break
        hot_design = _at(reducer.design, temperatures)
        jams = tooth_play(hot_design) <= 0.0 or min(warm_clearances(hot_design).values()) <= 0.0
        if jams or max(temperatures.values()) > settings.hottest:
            break
        warm = Reducer(hot_design)
    return _Steady(temperatures, losses, network, has_converged, cold or by_point, by_point, warm_temperature)


def _solve_losses(
    reducer: Reducer, points: Sequence[DutyPoint], wall: float, capacities: Mapping[str, float]
) -> tuple[tuple[dict[str, float], ...], Network]:
    """Return the losses by source at each point of a duty [W], and the network under its largest torque."""
    loadings = [solve_loading(reducer, replace(point, share=1.0), POSES, with_wind_up=False) for point in points]
    worst = max(loadings, key=lambda loading: abs(loading.point.torque))
    by_point = tuple(mean_losses(reducer, [loading]) for loading in loadings)
    return by_point, build_network(reducer, worst, wall, capacities)


def _mean(points: Sequence[DutyPoint], by_point: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """Return the mean losses of a duty by source [W] from those at each of its points."""
    return {
        source: sum(point.share * losses[source] for point, losses in zip(points, by_point, strict=True))
        for source in by_point[0]
    }


def _solve_warm_up(reducer: Reducer, duty: Duty, steady_state: _Steady, settings: ThermalSettings) -> TemperatureCourse:
    """Solve the temperatures over time from a start at the temperature of the air.

    The losses of each point of the duty change linearly with the temperature of the disc, between their values at 20 °C
    and in the steady state.
    """
    design = reducer.design
    duration = settings.time_constants * steady_state.network.time_constant
    cycle = duty.period if len(duty.points) > 1 else duration
    reference = design.thermal.disc
    span = steady_state.warm_temperature - reference
    states = iter(zip(steady_state.cold, steady_state.warm, strict=True))
    heating = []
    for point in duty.points:
        cold, warm = (heat_by_node(reducer, losses) for losses in (next(states) if point.speed else ({}, {})))
        slope = {node: (warm[node] - heat) / span if span else 0.0 for node, heat in cold.items()}
        heating.append(HeatingPoint(point.share * cycle, cold, slope))
    heating = [point for point in heating if point.duration > 0.0]
    reference_rise = reference - design.service.ambient_temperature
    return solve_course(steady_state.network, heating, "disc", reference_rise, duration, settings.samples)


def _torques_by_duty(
    reducer: Reducer, points: Sequence[DutyPoint], factor: float, steady_state: _Steady, settings: ThermalSettings
) -> dict[float, float]:
    """Compute the torque limit by the share of the time that the drive runs, resting for the remaining time [N m].

    The mean losses are those at the limit of the duty, `factor` times its torques; losses are linear in the torque.
    """
    largest, warm = max(abs(point.torque) for point in points), reducer
    if steady_state.converged:
        warm = Reducer(_at(reducer.design, steady_state.temperatures))
    light = [replace(point, torque=settings.light_load * point.torque) for point in points]
    by_point, _ = _solve_losses(warm, light, steady_state.temperatures["housing"], steady_state.network.capacities)
    running = sum(point.share for point in points)
    loaded = steady_state.warm if steady_state.converged else steady_state.cold
    full_loss, light_loss = (sum(_mean(points, losses).values()) / running for losses in (loaded, by_point))
    loss_slope = (full_loss - light_loss) / (1.0 - settings.light_load)
    allowed_loss = running * (full_loss + loss_slope * (factor - 1.0))
    return {
        share: max(0.0, 1.0 + (allowed_loss / share - full_loss) / loss_slope) * largest
        for share in settings.duty_shares
    }


def _at(design: Design, temperatures: Mapping[str, float]) -> Design:
    """Return the design with the temperatures of its parts [°C], not yet expanded; they may exceed those of a file."""
    return design.model_copy(update={"thermal": design.thermal.model_copy(update=dict(temperatures))})


def _thermal_margins(reducer: Reducer, temperatures: Mapping[str, float]) -> Iterator[tuple[str, float]]:
    """Yield each thermal limit in words with its relative margin at part temperatures [°C]; negative: exceeded."""
    design = reducer.design
    hottest = max(temperatures.values())
    for limit in heat_limits(reducer):
        yield f"{limit.temperature:g} °C, {limit.name}", (limit.temperature - hottest) / max(limit.temperature, 1.0)
    warm = _at(design, temperatures)
    yield "thermal expansion closes the teeth", tooth_play(warm) / max(tooth_play(design), 1e-12)
    for pair, clearance in warm_clearances(warm).items():
        yield (
            f"thermal expansion closes the clearance of {pair.replace('_', ' ')}",
            clearance / getattr(design.clearance, pair),
        )


def _largest_duty_factor(
    reducer: Reducer,
    scale_duty: Callable[[float], Sequence[DutyPoint]],
    steady_state: _Steady,
    settings: ThermalSettings,
) -> tuple[float, str]:
    """Return the largest factor on a duty that keeps all thermal limits, and the limit that is then reached.

    Losses in proportion to the factor give the first estimate; the steady state at the estimate corrects it. Beyond
    `ThermalSettings.solved` times the duty, where statics would be extrapolated, the estimate is not corrected.
    `scale_duty` returns the points of the duty times a factor.
    """
    duty_factor, limit_text = _largest_loss_factor(reducer, steady_state, settings)
    for _ in range(settings.corrections):
        if not 0.0 < duty_factor < settings.solved:
            break
        try:
            correction, limit_text = _largest_loss_factor(
                reducer, _solve_steady_state(reducer, scale_duty(duty_factor), settings, steady_state), settings
            )
        except RunError:
            break
        duty_factor *= correction
        if abs(correction - 1.0) < settings.resolution:
            break
    return duty_factor, limit_text


def _largest_loss_factor(reducer: Reducer, steady_state: _Steady, settings: ThermalSettings) -> tuple[float, str]:
    """Return the factor on the losses of a steady state at which the first limit is reached, and that limit in words.

    Temperature rises are in proportion to the losses; the root is found by Brent's method.
    """
    from scipy.optimize import brentq

    ambient = reducer.design.service.ambient_temperature
    rises = steady_state.network.rises(heat_by_node(reducer, steady_state.losses))

    def tightest_margin(loss_factor: float) -> tuple[float, str]:
        """Return the smallest margin and its limit in words, for temperature rises times a factor."""
        margins = _thermal_margins(reducer, {part: ambient + loss_factor * rise for part, rise in rises.items()})
        return min((margin, limit) for limit, margin in margins)

    if tightest_margin(0.0)[0] <= 0.0:
        return 0.0, tightest_margin(0.0)[1]
    if tightest_margin(settings.largest)[0] > 0.0:
        return math.inf, "none"
    share = float(brentq(lambda share: tightest_margin(share)[0], 0.0, settings.largest, xtol=1e-6))
    return share, tightest_margin(share)[1]


def _assumptions(reducer: Reducer, steady_state: _Steady) -> Iterator[str]:
    """Yield the assumptions of a steady state, a sentence each."""
    yield _friction_text(reducer)
    yield "half of each loss heats each of the two parts that meet; motor and driven machine take no heat"
    yield "conductances of bearings assume 14 rollers, a third of them loaded; conductivities by the kind of material"
    yield "losses change linearly with the temperature of the disc during the warm-up, and with the torque by duty"
    if not steady_state.converged:
        yield "the parts jam at these temperatures: the losses are those before the clearance is lost"


def _friction_text(reducer: Reducer) -> str:
    """Describe the friction of contacts and bearings in a sentence."""
    design = reducer.design
    if not design.has_film:
        return "friction: the coefficients of the design at any temperature; bearings by mu F d/2"
    return (
        f"friction: film of {design.friction.lubricant} at the temperature of the parts in contact; bearings of shaft "
        "and output by mu F d/2"
    )


def rate_jam_difference(reducer: Reducer, loadings: Sequence[Loading]) -> Iterator[RatedItem]:
    """Rate how much warmer the disc gets than the ring against the temperature difference that closes the teeth [K].

    Losses and conductances are those at 20 °C, without the fixed point of `thermal`.
    """
    worst = max(loadings, key=lambda loading: abs(loading.point.torque))
    network = build_network(reducer, worst, reducer.design.service.ambient_temperature)
    rises = network.rises(heat_by_node(reducer, mean_losses(reducer, loadings)))
    difference, limit = rises["disc"] - rises["ring"], jam_difference(reducer.design)
    yield RatedItem(
        "jam_difference",
        "disc warmer than the ring",
        difference,
        limit,
        "K",
        limit / difference if difference > 0.0 else math.inf,
        None,
        "thermal network; limit: play/(alpha (E - rho)) of the teeth",
        "conductances of grease, bearings and joints are assumed ([thermal]); all temperatures: `cycloid-mj thermal`",
    )


def rate_thermal_torque(design: Named, duty: Duty) -> RatedItem:
    """Rate the largest torque of a duty against the torque that the steady temperatures of all parts allow.

    Raises as `thermal`.
    """
    state = thermal(design, duty)
    torque = max(abs(point.torque) for point in duty.points)
    return RatedItem(
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
    )


def conductance_between(network: Network, first: str, second: str) -> float:
    """Return the sum of the conductances between two nodes [W/K]."""
    links: Sequence[Conductance] = network.conductances
    return sum(item.value for item in links if {item.first, item.second} == {first, second})
