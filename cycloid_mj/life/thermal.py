"""Steady temperatures of a drive, its warm-up, and the torque and speed that heat allows."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from cycloid_mj.base.errors import RunError
from cycloid_mj.design import Design, Named, resolve
from cycloid_mj.design.model import HEATED, REFERENCE_TEMPERATURE
from cycloid_mj.geometry.expansion import at_temperatures, jam_difference, tooth_play, warm_clearances
from cycloid_mj.life.duty import Duty, DutyPoint, add_rests, constant_duty, describe_condition, turning_points
from cycloid_mj.life.heat import heat_limits
from cycloid_mj.life.rv_thermal import RV_THERMAL_ASSUMPTIONS, describe_rv_friction
from cycloid_mj.life.steady_state import (
    SETTINGS,
    SteadyState,
    ThermalSettings,
    mean_of_points,
    solve_losses,
    solve_steady_state,
)
from cycloid_mj.life.thermal_course import HeatingPoint, TemperatureCourse, solve_course
from cycloid_mj.life.thermal_network import heat_by_node
from cycloid_mj.life.thermal_state import ThermalState, TightestTime
from cycloid_mj.reducer import Reducer, RvReducer, once, reducer_of
from cycloid_mj.statics.film import state_seals


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
    UsageError
        The crank turns without torque.
    """
    cold = reducer_of(resolve(design).at_reference)
    duty = duty or constant_duty(cold.design.rated_torque, cold.design.drive.speed)
    return _solve_thermal_state(cold, add_rests(duty, cold.design.service.duty_share), settings)


@once
def _solve_thermal_state(cold: Reducer, duty: Duty, settings: ThermalSettings) -> ThermalState:
    """Compute the `ThermalState` of a drive under a duty that states its rests.

    `cold` is the drive at 20 °C, `settings` are those of the search.
    """
    steady_state, reducer = solve_steady_state(cold, duty, settings), state_seals(cold)
    points = turning_points(duty, reducer.design, "the drive heats up")
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
        temperatures=dict(temperatures),
        losses=dict(steady_state.losses),
        heat=heat,
        network=steady_state.network,
        difference=steady_state.difference,
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
    reducer: Reducer, points: Sequence[DutyPoint], steady_state: SteadyState, settings: ThermalSettings
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


def _solve_warm_up(
    reducer: Reducer, duty: Duty, steady_state: SteadyState, settings: ThermalSettings
) -> TemperatureCourse:
    """Compute the temperature rises of the parts [K] over time [s] from a start at the temperature of the air.

    The losses at each point of the duty change linearly with the temperature of the disc, between their values at 20 °C
    and in the steady state. If the iteration for the steady state did not converge, the losses are constant and equal
    to the losses of its last round. `settings` are those of the thermal computation.
    """
    design = reducer.design
    duration = settings.time_constants * steady_state.network.time_constant
    cycle = duty.period if len(duty.points) > 1 else duration
    reference = design.thermal.disc
    disc_rise = steady_state.warm_temperatures["disc"] - reference
    cold_losses = steady_state.cold if steady_state.converged else steady_state.warm
    loss_pairs = iter(zip(cold_losses, steady_state.warm, strict=True))
    heating = []
    for point in duty.points:
        cold_heat, warm_heat = (
            heat_by_node(reducer, losses) for losses in (next(loss_pairs) if point.speed else ({}, {}))
        )
        slope = {node: (warm_heat[node] - heat) / disc_rise if disc_rise else 0.0 for node, heat in cold_heat.items()}
        heating.append(HeatingPoint(point.share * cycle, cold_heat, slope))
    heating = [point for point in heating if point.duration > 0.0]
    reference_rise = reference - design.service.ambient_temperature
    return solve_course(steady_state.network, heating, "disc", reference_rise, duration, settings.samples)


def _follow_clearances(design: Design, course: TemperatureCourse) -> list[TightestTime]:
    """Compute tooth play [m], tightest pair and temperature rises [K] at each time of a warm-up and a steady cycle.

    The result has an item for each time, not only for the tightest. `course` has the temperature rises over time, and
    those over a cycle of the duty in the periodic state. The times of this cycle are stated as the end of the warm-up.
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
    steady_state: SteadyState,
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
    loaded_losses = mean_of_points(points, steady_state.warm if steady_state.converged else steady_state.cold)
    growth_by_source = _loss_growth(reducer, points, steady_state, loaded_losses, settings)
    nominal_factor = max(1.0, reducer.design.rated_torque / max_torque)
    factor, name = _find_scale_limit(
        reducer,
        lambda share: [replace(point, torque=share * point.torque) for point in points],
        growth_by_source,
        steady_state,
        settings.solved * nominal_factor,
        replace(settings, largest=settings.largest * nominal_factor),
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
    steady_state: SteadyState,
    losses: Mapping[str, float],
    settings: ThermalSettings,
) -> dict[str, float]:
    """Return the increase of the losses by source [W] if all torques of a duty are doubled, by linear extrapolation.

    It is the slope between the mean `losses` [W] of the duty and those with all torques scaled by a common factor. The
    largest torque is scaled to the nominal torque. If both differ by at most a factor of 2, or there is no equilibrium
    at the nominal torque, all are scaled by `ThermalSettings.light_load` (a quarter) instead. Losses are those at the
    steady temperatures, or at 20 °C if there is no steady state. `points` are those of the duty, `settings` those of
    the thermal computation.
    """
    temperatures = dict.fromkeys(HEATED, REFERENCE_TEMPERATURE)
    if steady_state.converged:
        temperatures = dict(steady_state.temperatures)
    nominal_ratio = reducer.design.rated_torque / max(abs(point.torque) for point in points)
    factors = [settings.light_load] if 0.5 <= nominal_ratio <= 2.0 else [nominal_ratio, settings.light_load]
    for factor in factors:
        scaled_points = [replace(point, torque=factor * point.torque) for point in points]
        try:
            point_losses, _ = solve_losses(reducer, scaled_points, temperatures, settings)
        except RunError:
            if factor == factors[-1]:
                raise
            continue  # no equilibrium at the nominal torque
        break
    return {
        source: (changed_loss - losses[source]) / (factor - 1.0)
        for source, changed_loss in mean_of_points(points, point_losses).items()
    }


def _thermal_margins(reducer: Reducer, temperatures: Mapping[str, float]) -> Iterator[tuple[str, float]]:
    """Yield each thermal limit with its margin at the temperatures of the parts [°C].

    Yields
    ------
    tuple
        The limit in words, and its relative margin [1], negative if it is exceeded: the difference of limit and
        temperature over the limit in °C, or the clearance over that at the design's own temperatures.
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
    steady_state: SteadyState,
    largest_corrected: float,
    settings: ThermalSettings,
) -> tuple[float, str]:
    """Return the largest factor on torque or speed of a duty cycle at which no thermal limit is exceeded.

    The first estimate assumes losses that are linear in the factor. The secant method corrects it with the losses at
    that factor and the temperatures of the limit. An estimate above `largest_corrected` is replaced by a linear
    extrapolation from there, so that it does not depend on the torque of a light duty.

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
    if largest_corrected <= scale < math.inf:
        with suppress(RunError):
            limit = _extrapolate_scale_limit(
                reducer, scale_duty, largest_corrected, steady_state, limit.temperatures, settings
            )
            scale = limit.factor
    for _ in range(settings.corrections):
        if not 0.0 < scale < largest_corrected:
            break
        points = scale_duty(scale)
        try:
            point_losses, network = solve_losses(reducer, points, limit.temperatures, settings)
        except RunError:
            break
        losses = mean_of_points(points, point_losses)
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
    reducer: Reducer, steady_state: SteadyState, growth: Mapping[str, float], settings: ThermalSettings
) -> "_LossLimit":
    """Return the factor [1] on torque or speed at which a thermal limit is reached, for losses linear in the factor.

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


def _extrapolate_scale_limit(
    reducer: Reducer,
    scale_duty: Callable[[float], Sequence[DutyPoint]],
    largest: float,
    steady_state: SteadyState,
    temperatures: Mapping[str, float],
    settings: ThermalSettings,
) -> "_LossLimit":
    """Return the factor [1] on torque or speed at which a thermal limit is reached, extrapolated from large factors.

    Losses are linear between those at half of the factor `largest` and at `largest`, with conductances at the latter.
    All are computed at the `temperatures` of the parts [°C]. Other parameters and the result are those of
    `_estimate_scale_limit` and `_find_scale_limit`.

    Raises
    ------
    RunError
        No static equilibrium exists at one of both factors.
    """
    losses = []
    for factor in (0.5 * largest, largest):
        points = scale_duty(factor)
        point_losses, network = solve_losses(reducer, points, temperatures, settings)
        losses.append(mean_of_points(points, point_losses))
    half_losses, full_losses = losses
    growth = {source: 2.0 * (loss - half_losses[source]) for source, loss in full_losses.items()}
    state = replace(steady_state, losses=full_losses, conductances=network.conductances)
    limit = _estimate_scale_limit(reducer, state, growth, settings)
    return replace(limit, factor=largest * limit.factor)


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
    """Return the factor [1] on temperature rises over the air at which the first thermal limit is reached.

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


def _assumptions(reducer: Reducer, steady_state: SteadyState) -> Iterator[str]:
    """Yield the assumptions of a computation of steady temperatures, a sentence each.

    `steady_state` is its result.
    """
    if isinstance(reducer, RvReducer):
        yield describe_rv_friction(reducer)
        yield from RV_THERMAL_ASSUMPTIONS
    else:
        yield _friction_text(reducer)
        yield "each of the two parts in contact receives half of their loss; motor and driven machine receive no heat"
        yield "conductances of bearings assume 14 rollers, a third of them loaded"
        yield "conductivities by the kind of material"
    yield (
        "losses change linearly with the temperature of the disc during the warm-up, with the torque by duty, and "
        f"beyond {SETTINGS.solved:g} times the nominal torque or the speed of the duty: such limits are extrapolated"
    )
    if not steady_state.converged:
        yield f"{steady_state.obstacle} at these temperatures: the losses are those of lower temperatures"


def _friction_text(reducer: Reducer) -> str:
    """Return a sentence that states how the friction of contacts and bearings depends on temperature."""
    design = reducer.design
    if not design.has_film:
        return "friction: the coefficients of the design at any temperature; bearings by mu F d/2"
    return (
        f"friction: film of {design.friction.lubricant} at the temperature of the parts in contact; bearings of shaft "
        "and output by mu F d/2"
    )
