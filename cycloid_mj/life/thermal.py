"""Steady temperatures of a drive, its warm-up, and the torque and speed that heat allows."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cycloid_mj.base.errors import DesignError, RunError
from cycloid_mj.base.units import RPM
from cycloid_mj.design import Design, Named, resolve
from cycloid_mj.design.model import HEATED, REFERENCE_TEMPERATURE
from cycloid_mj.geometry.expansion import at_temperatures, jam_difference, tooth_play, warm_clearances
from cycloid_mj.life.duty import Duty, DutyPoint, add_rests, constant_duty, describe_condition
from cycloid_mj.life.heat import (
    heat_limits,
    heat_transfer_coefficient,
    mean_losses,
    rate_housing_temperature,
    running_share,
)
from cycloid_mj.life.item import ItemKind, RatedItem
from cycloid_mj.life.loading import Loading, solve_loading
from cycloid_mj.life.rv_thermal import RV_THERMAL_ASSUMPTIONS, describe_rv_friction, solve_rv_losses
from cycloid_mj.life.thermal_course import HeatingPoint, TemperatureCourse, solve_course
from cycloid_mj.life.thermal_network import Network, build_network, heat_by_node, heat_capacities
from cycloid_mj.life.thermal_state import ThermalState, TightestTime
from cycloid_mj.reducer import Reducer, RvReducer, reducer_of
from cycloid_mj.statics.film import state_seals
from cycloid_mj.statics.springs import POSES


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
        Up to this multiple of the duty or of the nominal torque, a limit is corrected by the losses there, so many
        times at most, or until the losses and the limit change by no more than the relative resolution.
    approach
        Share of the temperature rises at a limit at which these losses are computed: the parts do not yet jam.
    smallest_step
        Smallest share of the way to the temperatures of the next round if the parts would jam there.
    crank_angles
        Number of crank angles of the losses and conductances.
    samples, time_constants
        Steps of the warm-up, and its duration over the slowest time constant.
    duty_shares
        Shares of the time of intermittent duties (S3) whose torque limit is reported: those of IEC 60034-1.
    light_load
        Load over that of the duty which, with the duty's own, determines how losses grow with the torque. The nominal
        torque is used instead if it is less than half or more than twice the torque of the duty.
    """

    tolerance: float = 0.05
    rounds: int = 12
    hottest: float = 300.0
    largest: float = 100.0
    solved: float = 3.0
    corrections: int = 8
    resolution: float = 0.01
    approach: float = 0.99
    smallest_step: float = 0.125
    crank_angles: int = POSES
    samples: int = 120
    time_constants: float = 4.0
    duty_shares: tuple[float, ...] = (0.15, 0.25, 0.4, 0.6, 1.0)
    light_load: float = 0.25


SETTINGS = ThermalSettings()


def _running_points(design: Design, duty: Duty) -> list[DutyPoint]:
    """Return the points of a duty cycle at which the crank turns; raise DesignError if there are none."""
    points = [point for point in duty.points if point.speed]
    if not points:
        raise DesignError(
            f"{design.name}: drive.speed_rpm is 0, but the drive heats up only while the crank turns: set a speed "
            "other than 0, such as 1640 rpm"
        )
    return points


def thermal(design: Named, duty: Duty | None = None, settings: ThermalSettings = SETTINGS) -> ThermalState:
    """Compute the steady temperatures of a drive under a duty, its warm-up, and the torque and speed that heat allows.

    Parameters
    ----------
    design, duty, settings
        A design, or the name of a preset or a file, whose temperatures in ``[thermal]`` are not used; duty cycle, by
        default the nominal torque at the design's speed; and settings of the search. A constant duty has rests if
        ``service.duty_share`` is below 1.

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
    reducer = state_seals(reducer_of(resolve(design).at_reference))
    duty = duty or constant_duty(reducer.design.rated_torque, reducer.design.drive.speed)
    duty = add_rests(duty, reducer.design.service.duty_share)
    points = _running_points(reducer.design, duty)
    steady_state = _solve_steady_state(reducer, points, settings)
    temperatures, heat = steady_state.temperatures, heat_by_node(reducer, steady_state.losses)
    warm_design = at_temperatures(reducer.design, temperatures)
    ambient = reducer.design.service.ambient_temperature
    course = _solve_warm_up(reducer, duty, steady_state, settings)
    moments = _follow_clearances(reducer.design, course)
    tightest = min(moments, key=lambda moment: min(moment.play, moment.clearance))
    tightest_of_cycle = tightest if len(duty.points) > 1 else None
    torque_limit = _find_torque_limit(reducer, points, steady_state, tightest_of_cycle, settings)
    return ThermalState(
        design=reducer.design.name,
        condition=f"{describe_condition(reducer.design, duty)}, ambient {ambient:g} °C",
        temperatures=temperatures,
        losses=steady_state.losses,
        heat=heat,
        network=steady_state.network,
        difference=temperatures["disc"] - temperatures["ring"],
        jam_difference=jam_difference(reducer.design),
        clearances=warm_clearances(warm_design),
        play=tooth_play(warm_design),
        torque=torque_limit.torque,
        speed=_find_speed_limit(reducer, points, steady_state, settings),
        limited_by=torque_limit.name,
        duty_torques=torque_limit.by_duty,
        times=course.times,
        warm_up={part: ambient + rise for part, rise in course.rises.items()},
        peaks={part: ambient + course.peak(part) for part in HEATED},
        largest_difference=max(
            float(np.max(rises["disc"] - rises["ring"])) for rises in (course.rises, course.periodic)
        ),
        tightest=tightest,
        smallest_play=min(moment.play for moment in moments),
        converged=steady_state.converged,
        assumptions=tuple(_assumptions(reducer, steady_state)),
        can_preload=isinstance(reducer, RvReducer),
    )


def _find_speed_limit(
    reducer: Reducer, points: Sequence[DutyPoint], steady_state: "_Steady", settings: ThermalSettings
) -> float:
    """Return the largest crank speed [rad/s] that heat allows, if all speeds of a duty cycle are scaled equally.

    `points` are those of the duty cycle, `steady_state` their losses and temperatures, and `settings` those of the
    search.
    """
    speed_factor, _ = _find_scale_limit(
        reducer,
        lambda speed_factor: [replace(point, speed=speed_factor * point.speed) for point in points],
        steady_state.losses,
        steady_state,
        settings.solved,
        settings,
    )
    return speed_factor * max(point.speed for point in points)


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


def _solve_steady_state(reducer: Reducer, points: Sequence[DutyPoint], settings: ThermalSettings) -> _Steady:
    """Solve for the steady losses and temperatures of the parts under a duty cycle, by fixed-point iteration.

    It starts at 20 °C. `settings` are those of the iteration. `points` are the points of the duty cycle. Losses and
    conductances depend on the temperatures, also through the clearances. If the parts would jam at the next
    temperatures, the step is shortened. If they jam after the shortest step as well, the result has the losses before
    that step and is not converged.
    """
    ambient, capacities = reducer.design.service.ambient_temperature, heat_capacities(reducer)
    temperatures, has_converged, cold = dict.fromkeys(HEATED, REFERENCE_TEMPERATURE), False, None
    for _ in range(settings.rounds):
        point_losses, network = _solve_losses(reducer, points, temperatures, capacities, settings)
        losses, cold, previous = (_mean(points, point_losses), cold or point_losses, temperatures)
        rises = network.rises(heat_by_node(reducer, losses))
        temperatures = {part: ambient + rise for part, rise in rises.items()}
        if max(abs(temperatures[part] - previous[part]) for part in HEATED) < settings.tolerance:
            has_converged = True
            break
        step_size = 1.0
        while step_size >= settings.smallest_step and _is_inadmissible(reducer.design, temperatures, settings):
            step_size *= 0.5
            temperatures = {part: 0.5 * (previous[part] + value) for part, value in temperatures.items()}
        if step_size < settings.smallest_step:
            break
    final = {part: ambient + rise for part, rise in rises.items()}
    return _Steady(final, losses, network, has_converged, cold or point_losses, point_losses, previous["disc"])


def _is_inadmissible(design: Design, temperatures: Mapping[str, float], settings: ThermalSettings) -> bool:
    """Return whether the parts jam at temperatures [°C], or are hotter than the rounds allow."""
    if max(temperatures.values()) > settings.hottest or design.layout == RvReducer.LAYOUT:
        return max(temperatures.values()) > settings.hottest
    hot_design = at_temperatures(design, temperatures)
    return tooth_play(hot_design) <= 0.0 or min(warm_clearances(hot_design).values()) <= 0.0


def _solve_losses(
    reducer: Reducer,
    points: Sequence[DutyPoint],
    temperatures: Mapping[str, float],
    capacities: Mapping[str, float],
    settings: ThermalSettings,
) -> tuple[tuple[dict[str, float], ...], Network]:
    """Return the losses [W] by source at each point of a duty cycle, and the thermal network at the largest torque.

    Parameters
    ----------
    points
        Points of the duty; their shares of time are not used.
    temperatures
        Temperature of each part [°C].
    capacities
        Heat capacity of each node of the network [J/K].
    settings
        Number of crank angles.
    """
    if isinstance(reducer, RvReducer):
        return solve_rv_losses(reducer, points, temperatures, capacities, settings.crank_angles)
    loadings = [
        solve_loading(reducer, replace(point, share=1.0), settings.crank_angles, False, temperatures)
        for point in points
    ]
    worst = max(loadings, key=lambda loading: abs(loading.point.torque))
    point_losses = tuple(mean_losses(reducer, [loading]) for loading in loadings)
    return point_losses, build_network(reducer, worst, temperatures["housing"], capacities)


def _mean(points: Sequence[DutyPoint], by_point: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """Return the mean losses of a duty by source [W] from those at each of its points."""
    return {
        source: sum(point.share * losses[source] for point, losses in zip(points, by_point, strict=True))
        for source in by_point[0]
    }


def _solve_warm_up(reducer: Reducer, duty: Duty, steady_state: _Steady, settings: ThermalSettings) -> TemperatureCourse:
    """Compute the temperature rises of the parts [K] over time [s] from a start at the temperature of the air.

    The losses at each point of the duty change linearly with the temperature of the disc, between their values at 20 °C
    and in the steady state. If the iteration for the steady state did not converge, the losses are constant and equal
    to the losses of its last round. `settings` are those of the thermal computation.
    """
    design = reducer.design
    duration = settings.time_constants * steady_state.network.time_constant
    cycle = duty.period if len(duty.points) > 1 else duration
    reference = design.thermal.disc
    span = steady_state.warm_temperature - reference
    cold_losses = steady_state.cold if steady_state.converged else steady_state.warm
    loss_pairs = iter(zip(cold_losses, steady_state.warm, strict=True))
    heating = []
    for point in duty.points:
        cold_heat, warm_heat = (
            heat_by_node(reducer, losses) for losses in (next(loss_pairs) if point.speed else ({}, {}))
        )
        slope = {node: (warm_heat[node] - heat) / span if span else 0.0 for node, heat in cold_heat.items()}
        heating.append(HeatingPoint(point.share * cycle, cold_heat, slope))
    heating = [point for point in heating if point.duration > 0.0]
    reference_rise = reference - design.service.ambient_temperature
    return solve_course(steady_state.network, heating, "disc", reference_rise, duration, settings.samples)


def _follow_clearances(design: Design, course: TemperatureCourse) -> list[TightestTime]:
    """Compute tooth play [m], tightest pair and temperature rises [K] at the times of a warm-up and a steady cycle.

    `course` has the temperature rises over time, and those over a cycle of the duty in the periodic state. The times
    of this cycle are stated as the end of the warm-up.
    """
    ambient = design.service.ambient_temperature
    moments = []
    all_times = [*course.times, *[course.times[-1]] * len(course.periodic["disc"])]
    all_rises = {part: np.append(rise, course.periodic[part]) for part, rise in course.rises.items()}
    for index, time in enumerate(all_times):
        rises = {part: float(rise[index]) for part, rise in all_rises.items()}
        warm_design = at_temperatures(design, {part: ambient + rise for part, rise in rises.items()})
        clearances = warm_clearances(warm_design)
        pair = min(clearances, key=clearances.__getitem__)
        moments.append(TightestTime(float(time), tooth_play(warm_design), pair, clearances[pair], rises))
    return moments


@dataclass(frozen=True)
class _TorqueLimit:
    """Largest torque of a duty that heat allows [N m], its limit in words, and torques [N m] by share of the time."""

    torque: float
    name: str
    by_duty: dict[float, float]


def _find_torque_limit(
    reducer: Reducer,
    points: Sequence[DutyPoint],
    steady_state: _Steady,
    tightest: TightestTime | None,
    settings: ThermalSettings,
) -> _TorqueLimit:
    """Return the largest torque of a duty cycle that heat allows [N m], what limits it, and limits by duty factor.

    The first torque is valid for the duty as it is, with all its torques scaled by the same factor. The other torque
    limits are for a drive that runs for a share of the time, the duty factor, and rests otherwise (S3). For these, and
    for the limit at the tightest time, losses are assumed to be linear in the torque.

    Parameters
    ----------
    points
        Points of the duty.
    steady_state
        Steady losses and temperatures of the duty.
    tightest
        Time of a cycle with the least play, at which no thermal limit may be exceeded either. If it is None, only the
        steady state with the mean losses counts.
    settings
        Settings of the search.
    """
    max_torque, running = max(abs(point.torque) for point in points), sum(point.share for point in points)
    loaded_losses = _mean(points, steady_state.warm if steady_state.converged else steady_state.cold)
    growth_by_source = _loss_growth(reducer, points, steady_state, loaded_losses, settings)
    factor, name = _find_scale_limit(
        reducer,
        lambda share: [replace(point, torque=share * point.torque) for point in points],
        growth_by_source,
        steady_state,
        settings.solved * max(1.0, reducer.design.rated_torque / max_torque),
        settings,
    )
    full_loss, loss_growth = (sum(losses.values()) / running for losses in (loaded_losses, growth_by_source))

    def factor_at(losses: float) -> float:
        """Return the factor [1] on the torques at which the running drive loses a power [W], at least 0."""
        return max(0.0, 1.0 + (losses - full_loss) / loss_growth)

    allowed_loss = running * (full_loss + loss_growth * (factor - 1.0))
    by_duty = {share: factor_at(allowed_loss / share) * max_torque for share in settings.duty_shares}
    if tightest is not None and math.isfinite(factor):
        limit = _find_loss_factor_limit(reducer, tightest.rises, settings)
        cycle_factor = factor_at(limit.factor * full_loss)
        if cycle_factor < factor:
            factor, name = cycle_factor, f"{limit.name}, at times of a cycle"
    return _TorqueLimit(factor * max_torque, name, by_duty)


def _loss_growth(
    reducer: Reducer,
    points: Sequence[DutyPoint],
    steady_state: _Steady,
    losses: Mapping[str, float],
    settings: ThermalSettings,
) -> dict[str, float]:
    """Return the increase of the losses by source [W] if all torques of a duty are doubled, by linear extrapolation.

    It is the slope between the mean `losses` [W] of the duty and those at the nominal torque, or at a quarter of the
    duty's torques (`ThermalSettings.light_load`), at the steady temperatures, or at 20 °C if there is no steady state.
    `points` are those of the duty, `settings` those of the thermal computation.
    """
    temperatures = dict.fromkeys(HEATED, REFERENCE_TEMPERATURE)
    if steady_state.converged:
        temperatures = steady_state.temperatures
    nominal_ratio = reducer.design.rated_torque / max(abs(point.torque) for point in points)
    factors = [settings.light_load] if 0.5 <= nominal_ratio <= 2.0 else [nominal_ratio, settings.light_load]
    for factor in factors:
        scaled_points = [replace(point, torque=factor * point.torque) for point in points]
        try:
            point_losses, _ = _solve_losses(
                reducer, scaled_points, temperatures, steady_state.network.capacities, settings
            )
        except RunError:
            if factor == factors[-1]:
                raise
            continue  # no equilibrium at the nominal torque
        break
    return {
        source: (changed_loss - losses[source]) / (factor - 1.0)
        for source, changed_loss in _mean(points, point_losses).items()
    }


def _thermal_margins(reducer: Reducer, temperatures: Mapping[str, float]) -> Iterator[tuple[str, float]]:
    """Yield each thermal limit with its margin at the temperatures of the parts [°C].

    Yields
    ------
    tuple
        The limit in words, and its relative margin [1], negative if it is exceeded.
    """
    design = reducer.design
    hottest = max(temperatures.values())
    for limit in heat_limits(reducer):
        yield f"{limit.temperature:g} °C, {limit.name}", (limit.temperature - hottest) / max(limit.temperature, 1.0)
    if isinstance(reducer, RvReducer):
        return
    warm_design = at_temperatures(design, temperatures)
    yield "thermal expansion closes the teeth", tooth_play(warm_design) / max(tooth_play(design), 1e-12)
    for pair, clearance in warm_clearances(warm_design).items():
        yield (
            f"thermal expansion closes the clearance of {pair.replace('_', ' ')}",
            clearance / getattr(design.clearance, pair),
        )


def _find_scale_limit(
    reducer: Reducer,
    scale_duty: Callable[[float], Sequence[DutyPoint]],
    growth: Mapping[str, float],
    steady_state: _Steady,
    largest_corrected: float,
    settings: ThermalSettings,
) -> tuple[float, str]:
    """Return the largest factor on torque or speed of a duty cycle at which no thermal limit is exceeded.

    The first estimate assumes losses that are linear in the factor. The secant method corrects it with the losses at
    that factor and the temperatures of the limit. An estimate above `largest_corrected` is not corrected.

    Parameters
    ----------
    scale_duty
        Function from a factor to the points of the duty with their torque or speed times that factor.
    growth
        Increase of the losses by source [W] when the factor increases by 1.
    steady_state
        Steady losses and temperatures of the duty.
    largest_corrected
        Largest factor that is corrected [1].
    settings
        Settings of the search.

    Returns
    -------
    tuple
        The factor [1], and the limit that is then reached, in words.
    """
    network, last_point = steady_state.network, None
    limit = _estimate_scale_limit(reducer, steady_state, growth, settings)
    scale, loss_slope = limit.factor, sum(growth.values())
    for _ in range(settings.corrections):
        if not 0.0 < scale < largest_corrected:
            break
        points = scale_duty(scale)
        try:
            point_losses, network = _solve_losses(reducer, points, limit.temperatures, network.capacities, settings)
        except RunError:
            break
        losses = _mean(points, point_losses)
        limit = _find_loss_factor_limit(reducer, network.rises(heat_by_node(reducer, losses)), settings)
        excess = 1.0 / limit.factor - 1.0  # relative; linear in the factor where losses are
        scale_step = (limit.factor - 1.0) * (sum(losses.values()) / loss_slope if loss_slope > 0.0 else scale)
        if last_point is not None and excess != last_point[1]:
            secant_step = -excess * (scale - last_point[0]) / (excess - last_point[1])
            scale_step = secant_step if secant_step * scale_step > 0.0 else scale_step
        next_scale = min(max(scale + scale_step, 0.5 * scale), 2.0 * scale)
        error = max(abs(excess), abs(next_scale / scale - 1.0))
        has_converged = last_point is not None and error < settings.resolution
        last_point, scale = (scale, excess), next_scale
        if has_converged:
            break
    return scale, limit.name


def _estimate_scale_limit(
    reducer: Reducer, steady_state: _Steady, growth: Mapping[str, float], settings: ThermalSettings
) -> "_LossLimit":
    """Return the factor on torque or speed at which a thermal limit is reached, for losses linear in the factor.

    The result also has the limit in words, and the temperatures of the parts there. `growth` is the increase of the
    losses by source [W] when the factor increases by 1. If the part of the losses without torque alone exceeds a limit,
    all losses are assumed to be in proportion to the factor. `steady_state` has the steady temperatures, `settings` are
    those of the thermal computation.
    """
    idle_losses = {source: losses - growth[source] for source, losses in steady_state.losses.items()}
    rises, idle_rises = (
        steady_state.network.rises(heat_by_node(reducer, losses)) for losses in (steady_state.losses, idle_losses)
    )
    limit = _find_loss_factor_limit(reducer, rises, settings, idle_rises)
    return limit if limit.factor > 0.0 else _find_loss_factor_limit(reducer, rises, settings)


@dataclass(frozen=True)
class _LossLimit:
    """Factor on losses at which the first thermal limit is reached, its name, and temperatures [°C] close to it.

    `factor` is inf if no limit is reached; the temperatures are then those of the losses themselves.
    """

    factor: float
    name: str
    temperatures: dict[str, float]


def _find_loss_factor_limit(
    reducer: Reducer,
    rises: Mapping[str, float],
    settings: ThermalSettings,
    idle_rises: Mapping[str, float] | None = None,
) -> _LossLimit:
    """Return the factor on temperature rises over the air at which the first thermal limit is reached.

    The result also has the limit in words, and the temperatures of the parts there [°C]. `rises` [K] are the
    temperature rises of the parts. The factor does not apply to their part `idle_rises` [K], by default none. It is inf
    if no limit is reached up to `settings.largest`, and 0 if a limit is already exceeded with the factor 0.
    """
    from scipy.optimize import brentq

    ambient = reducer.design.service.ambient_temperature

    def temperatures_at(loss_factor: float) -> dict[str, float]:
        """Return the temperatures [°C] for rises times a factor."""
        constant = idle_rises or dict.fromkeys(rises, 0.0)
        return {part: ambient + constant[part] + loss_factor * (rise - constant[part]) for part, rise in rises.items()}

    def tightest_margin(loss_factor: float) -> tuple[float, str]:
        """Return the smallest margin and its limit in words, for temperature rises times a factor."""
        return min((margin, limit) for limit, margin in _thermal_margins(reducer, temperatures_at(loss_factor)))

    if tightest_margin(0.0)[0] <= 0.0:
        return _LossLimit(0.0, tightest_margin(0.0)[1], temperatures_at(0.0))
    if tightest_margin(settings.largest)[0] > 0.0:
        return _LossLimit(math.inf, "none", temperatures_at(1.0))
    factor = float(brentq(lambda factor: tightest_margin(factor)[0], 0.0, settings.largest, xtol=1e-6))
    return _LossLimit(factor, tightest_margin(factor)[1], temperatures_at(settings.approach * factor))


def _assumptions(reducer: Reducer, steady_state: _Steady) -> Iterator[str]:
    """Yield the assumptions of a computation of steady temperatures, a sentence each.

    `steady_state` is its result.
    """
    if isinstance(reducer, RvReducer):
        yield describe_rv_friction(reducer)
        yield from RV_THERMAL_ASSUMPTIONS
    else:
        yield _friction_text(reducer)
        yield "half of each loss heats each of the two parts that meet; motor and driven machine take no heat"
        yield "conductances of bearings assume 14 rollers, a third of them loaded"
        yield "conductivities by the kind of material"
    yield (
        "losses change linearly with the temperature of the disc during the warm-up, with the torque by duty, and "
        f"beyond {SETTINGS.solved:g} times the nominal torque or the speed of the duty: such limits are extrapolated"
    )
    if not steady_state.converged:
        reason = "losses and temperatures do not agree" if isinstance(reducer, RvReducer) else "the parts jam"
        yield f"{reason} at these temperatures: the losses are those before the clearance is lost"


def _friction_text(reducer: Reducer) -> str:
    """Return a sentence that states how the friction of contacts and bearings depends on temperature."""
    design = reducer.design
    if not design.has_film:
        return "friction: the coefficients of the design at any temperature; bearings by mu F d/2"
    return (
        f"friction: film of {design.friction.lubricant} at the temperature of the parts in contact; bearings of shaft "
        "and output by mu F d/2"
    )


def rate_jam_difference(reducer: Reducer, loadings: Sequence[Loading]) -> Iterator[RatedItem]:
    """Rate the temperature difference of disc and ring [K] against that at which the teeth jam.

    `loadings` are the solved forces at each point of the duty; with rests (``service.duty_share``), the difference is
    the mean over running and rest. Losses and conductances are computed at 20 °C, without the iteration of `thermal`.
    """
    worst = max(loadings, key=lambda loading: abs(loading.point.torque))
    network = build_network(reducer, worst, reducer.design.service.ambient_temperature)
    rises = network.rises(heat_by_node(reducer, mean_losses(reducer, loadings)))
    running_part = running_share(reducer, loadings)
    difference, limit = running_part * (rises["disc"] - rises["ring"]), jam_difference(reducer.design)
    yield RatedItem(
        "jam_difference",
        "disc warmer than the ring",
        difference,
        limit,
        "K",
        limit / difference if difference > 0.0 else math.inf,
        None,
        "thermal network; limit: play/(alpha (E - rho)) of the teeth",
        f"{'' if running_part == 1.0 else f'running for {running_part:.0%} of the time, mean of the cycles; '}"
        "conductances of grease, bearings and joints are assumed ([thermal]); all temperatures: `cycloid-mj thermal`",
    )


def rate_thermal_limits(design: Design, duty: Duty) -> Iterator[RatedItem]:
    """Rate heat: the largest torque of a duty [N m] against the torque that the steady temperatures allow.

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
    reducer, housing = reducer_of(design), max(state.temperatures["housing"], state.peaks["housing"])
    yield rate_housing_temperature(
        reducer,
        housing,
        "thermal network with the losses of the duty",
        f"{sum(state.losses.values()):.3g} W at h = {heat_transfer_coefficient(reducer, housing):.3g} W/(m2 K) "
        f"(assumed); {state.condition}",
    )
