"""Steady temperatures of a drive, its warm-up, and the torque and speed that heat allows."""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache

import numpy as np

from cycloid_mj.design import Design, Named, resolve
from cycloid_mj.design.model import HEATED
from cycloid_mj.geometry.expansion import at_temperatures, jam_difference, tooth_play, warm_clearances
from cycloid_mj.life.duty import Duty, DutyPoint, add_rests, constant_duty, describe_condition
from cycloid_mj.life.rv_thermal import RV_THERMAL_ASSUMPTIONS, describe_rv_friction
from cycloid_mj.life.steady_state import SETTINGS, SteadyState, ThermalSettings, solve_steady_state
from cycloid_mj.life.thermal_course import HeatingPoint, TemperatureCourse, solve_course
from cycloid_mj.life.thermal_limits import ScaleLimit, find_speed_factor, find_torque_factor, thermal_margins
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
    temperatures, heat = steady_state.temperatures, heat_by_node(reducer, steady_state.losses)
    warm_design = at_temperatures(reducer.design, temperatures)
    ambient = reducer.design.service.ambient_temperature
    course = _solve_warm_up(reducer, duty, steady_state, settings)
    moments = _follow_clearances(reducer.design, course)
    tightest_moment = min(moments, key=lambda moment: min(moment.play, moment.clearance))
    torque_factor, limited_by = _limit_in_cycles(
        cold,
        duty,
        find_torque_factor(cold, duty, settings),
        lambda point, factor: {"torque": factor * point.torque},
        settings,
    )
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
        torque=torque_factor * max(abs(point.torque) for point in duty.points if point.speed),
        speed=find_speed_limit(cold, duty, settings),
        limited_by=limited_by,
        times=course.times,
        warm_up={part: ambient + rise for part, rise in course.rises.items()},
        peaks={part: ambient + course.peak(part) for part in HEATED},
        largest_difference=max(
            float(np.max(rises["disc"] - rises["ring"])) for rises in (course.rises, course.periodic)
        ),
        tightest=tightest_moment,
        smallest_play=min(moment.play for moment in moments),
        converged=steady_state.converged,
        assumptions=tuple(_assumptions(reducer, steady_state)),
        reducer=cold,
        duty=duty,
        settings=settings,
        can_preload=isinstance(reducer, RvReducer),
    )


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
    those over a cycle of the duty in the periodic state; all items of this cycle have the time of the warm-up's end.
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


@once
def find_speed_limit(reducer: Reducer, duty: Duty, settings: ThermalSettings = SETTINGS) -> float:
    """Find the largest crank speed [rad/s] that heat allows, if all speeds of a duty are scaled by the same factor.

    The duty states its rests, and the reducer is at 20 °C. The result is inf if no speed is too large.

    Raises
    ------
    DesignError
        The crank does not turn.
    RunError
        No static equilibrium exists under a torque of the duty.
    """
    by_mean = find_speed_factor(reducer, duty, settings)
    factor, _ = _limit_in_cycles(
        reducer, duty, by_mean, lambda point, factor: {"speed": factor * point.speed}, settings
    )
    return factor * max(point.speed for point in duty.points)


def permissible_speed(design: Design, duty_share: float) -> float:
    """Find the largest crank speed [rad/s] that heat allows at the nominal torque for a share of the time [1].

    It is `ThermalState.speed` of this duty. Errors are those of `thermal`.
    """
    cold = reducer_of(design.at_reference.but(service={"duty_share": duty_share}))
    duty = constant_duty(cold.design.rated_torque, cold.design.drive.speed)
    return find_speed_limit(cold, add_rests(duty, duty_share))


def _limit_in_cycles(
    reducer: Reducer,
    duty: Duty,
    mean_limit: ScaleLimit,
    scale_point: Callable[[DutyPoint, float], dict[str, float]],
    settings: ThermalSettings,
) -> tuple[float, str]:
    """Find the largest factor on all torques or speeds of a duty that heat allows, and the limit in words.

    No thermal limit may be exceeded by the mean temperatures, nor at any time of the warm-up and of a cycle.
    `mean_limit` is the limit by the mean temperatures; `scale_point` is a function from a point of the duty and a
    factor to the changed values of the point. The reducer is at 20 °C.
    """
    from scipy.optimize import brentq

    if len(duty.points) == 1 or not 0.0 < mean_limit.factor < math.inf:
        return mean_limit.factor, mean_limit.limit.name

    @cache
    def tightest_margin(factor: float) -> tuple[float, str]:
        """Return the smallest margin [1] at any time and its limit in words, for the duty scaled by a factor."""
        points = tuple(replace(point, **scale_point(point, factor)) for point in duty.points)
        scaled_duty = replace(duty, points=points)
        steady_state = solve_steady_state(reducer, scaled_duty, settings)
        course = _solve_warm_up(state_seals(reducer), scaled_duty, steady_state, settings)
        moments = _follow_clearances(reducer.design, course)
        tightest_moment = min(moments, key=lambda moment: min(moment.play, moment.clearance))
        hottest_moment = max(moments, key=lambda moment: max(moment.rises.values()))
        ambient = reducer.design.service.ambient_temperature
        return min(
            (margin, limit)
            for rises in (tightest_moment.rises, hottest_moment.rises)
            for limit, margin in thermal_margins(reducer, {part: ambient + rise for part, rise in rises.items()})
        )

    upper_factor = settings.approach * mean_limit.factor
    if tightest_margin(upper_factor)[0] >= 0.0:
        return mean_limit.factor, mean_limit.limit.name
    lower_factor = 0.5 * upper_factor
    while tightest_margin(lower_factor)[0] < 0.0 and lower_factor > settings.smallest:
        lower_factor *= 0.5
    factor = brentq(
        lambda factor: tightest_margin(factor)[0], lower_factor, 2.0 * lower_factor, rtol=settings.resolution
    )
    return float(factor), f"{tightest_margin(2.0 * lower_factor)[1]}, at times of a cycle"


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
        "losses change linearly with the temperature of the disc during the warm-up; limits of torque and speed follow "
        "from the losses at these limits"
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
