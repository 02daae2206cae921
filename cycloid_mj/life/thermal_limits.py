"""Largest torques and speeds that heat allows, by the losses, temperatures and clearances of the full solution."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from cycloid_mj.base.errors import RunError
from cycloid_mj.design.model import HEATED
from cycloid_mj.geometry.expansion import at_temperatures, tooth_play, warm_clearances
from cycloid_mj.life.duty import Duty, DutyPoint, add_rests, turning_points
from cycloid_mj.life.heat import heat_limits
from cycloid_mj.life.steady_state import (
    NO_EQUILIBRIUM,
    SETTINGS,
    SteadyState,
    ThermalSettings,
    mean_of_points,
    solve_losses,
    solve_steady_state,
)
from cycloid_mj.life.thermal_network import heat_by_node
from cycloid_mj.reducer import Reducer, RvReducer, once
from cycloid_mj.statics.film import state_seals

NO_LIMIT = "none"
"""Name of a limit that is not reached."""


def thermal_margins(reducer: Reducer, temperatures: Mapping[str, float]) -> Iterator[tuple[str, float]]:
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


@dataclass(frozen=True)
class RiseLimit:
    """First thermal limit that is reached if temperature rises over the air are multiplied by a factor.

    Attributes
    ----------
    factor
        The factor [1]: inf if no limit is reached up to `ThermalSettings.largest`, 0 if one is exceeded without losses.
    name
        The limit in words.
    rises
        Temperature rise of each part at the limit [K]; without a limit, the rises themselves.
    """

    factor: float
    name: str
    rises: dict[str, float]


def find_rise_limit(reducer: Reducer, rises: Mapping[str, float], settings: ThermalSettings = SETTINGS) -> RiseLimit:
    """Find the factor on temperature rises of the parts over the air [K] at which the first thermal limit is reached.

    The result also has this limit in words, and the rises there. `settings` are those of the thermal computation.
    """
    from scipy.optimize import brentq

    ambient = reducer.design.service.ambient_temperature

    def tightest_margin(factor: float) -> tuple[float, str]:
        """Return the smallest margin and its limit in words, for temperature rises times a factor."""
        temperatures = {part: ambient + factor * rise for part, rise in rises.items()}
        return min((margin, limit) for limit, margin in thermal_margins(reducer, temperatures))

    if tightest_margin(0.0)[0] <= 0.0:
        return RiseLimit(0.0, tightest_margin(0.0)[1], dict.fromkeys(rises, 0.0))
    if tightest_margin(settings.largest)[0] > 0.0:
        return RiseLimit(math.inf, NO_LIMIT, dict(rises))
    factor = float(brentq(lambda factor: tightest_margin(factor)[0], 0.0, settings.largest, xtol=1e-6))
    return RiseLimit(factor, tightest_margin(factor)[1], {part: factor * rise for part, rise in rises.items()})


@dataclass(frozen=True)
class ScaleLimit:
    """Largest factor on the torques or speeds of a duty [1], and the thermal limit that is then reached.

    The factor is inf if no limit is reached, and 0 if heat allows no factor.
    """

    factor: float
    limit: RiseLimit


@dataclass(frozen=True)
class ScaleSearch:
    """Search for the largest factor on torques or speeds of a duty at which no thermal limit is exceeded.

    Losses and conductances are those of the full statics at each factor and at the temperatures of the parts there. At
    a level q of the temperatures, which are q times the rises at the limit, the factor s(q) is that whose losses cause
    these temperatures. A drive that warms up from the temperature of the air remains at the lowest level at which
    losses and temperatures agree. The largest factor is therefore the maximum of s(q) for q up to 1. It is s(1), at the
    limit itself, unless losses grow faster than the temperatures shortly before: then no steady state exists above the
    maximum (thermal runaway).

    Attributes
    ----------
    reducer, settings
        The drive at 20 °C, and the settings of the thermal computation.
    scale_duty
        Function from a factor to the points of the duty with their torque or speed times that factor.
    largest
        Largest factor of the search.
    """

    reducer: Reducer
    settings: ThermalSettings
    scale_duty: Callable[[float], Sequence[DutyPoint]]
    largest: float

    def solve(self, start: ScaleLimit) -> ScaleLimit:
        """Find the largest factor and the thermal limit that is then reached, from `start`, an estimate of both."""
        from scipy.optimize import minimize_scalar

        at_limit = self._solve_level(1.0, start)
        if not 0.0 < at_limit.factor < math.inf or at_limit.limit.name == NO_EQUILIBRIUM:
            return at_limit
        level = self.settings.runaway_level
        try:
            cooler_limit = self._find_limit(at_limit.factor, level, at_limit.limit.rises)
        except RunError:
            return at_limit
        if level * cooler_limit.factor <= 1.0:  # the drive heats beyond this level, up to the limit
            return at_limit
        maximum = minimize_scalar(
            lambda level: -self._solve_level(level, at_limit).factor,
            bounds=self.settings.levels,
            method="bounded",
            options={"xatol": self.settings.level_resolution},
        )
        return ScaleLimit(max(-float(maximum.fun), at_limit.factor), at_limit.limit)

    def _find_limit(self, scale: float, level: float, limit_rises: Mapping[str, float]) -> RiseLimit:
        """Return the thermal limit of the temperature rises that the losses cause at a factor `scale` on the duty.

        The losses are computed at `level` [1] times `limit_rises`, the temperature rises at the limit [K]. The factor
        of the result is that on the rises which these losses cause.
        """
        ambient, share = self.reducer.design.service.ambient_temperature, min(level, self.settings.approach)
        points = self.scale_duty(scale)
        temperatures = {part: ambient + share * limit_rises[part] for part in HEATED}
        point_losses, network = solve_losses(self.reducer, points, temperatures, self.settings)
        heat = heat_by_node(self.reducer, mean_of_points(points, point_losses))
        return find_rise_limit(self.reducer, network.rises(heat), self.settings)

    def _solve_level(self, level: float, start: ScaleLimit) -> ScaleLimit:
        """Solve for the factor on the duty whose losses cause `level` [1] times the temperature rises at the limit.

        The secant method in the logarithms of factor and rises is combined with the fixed point of the temperatures at
        the limit, whose distribution over the parts depends on the factor. `start` is the first estimate.

        If no equilibrium exists at a factor, it is reduced towards the last one at which one did.
        """
        settings, limit, slope = self.settings, start.limit, 1.0
        min_log, max_log = math.log(settings.smallest), math.log(self.largest)
        log_factor = math.log(min(max(start.factor, settings.smallest), self.largest))
        last_point: tuple[float, float] | None = None
        for _ in range(settings.corrections):
            try:
                rise_limit = self._find_limit(math.exp(log_factor), level, limit.rises)
            except RunError:
                limit = replace(limit, name=NO_EQUILIBRIUM)
                reduced_log = 0.5 * (log_factor + last_point[0]) if last_point else log_factor - math.log(2.0)
                if reduced_log < min_log or log_factor - reduced_log < settings.resolution:
                    break
                log_factor = reduced_log
                continue
            if not rise_limit.factor:
                return ScaleLimit(0.0, rise_limit)
            log_excess = -math.log(level * min(rise_limit.factor, settings.largest))
            if last_point and abs(log_factor - last_point[0]) > 1e-6:
                slope = min(
                    max((log_excess - last_point[1]) / (log_factor - last_point[0]), settings.slopes[0]),
                    settings.slopes[1],
                )
            rise_change = max(abs(rise - limit.rises[part]) for part, rise in rise_limit.rises.items())
            alternates = last_point is not None and log_excess * last_point[1] < 0.0
            rises = {part: 0.5 * (rise + limit.rises[part]) for part, rise in rise_limit.rises.items()}
            limit = replace(rise_limit, rises=rises) if alternates else rise_limit
            log_step = min(max(-log_excess / slope, -settings.largest_step), settings.largest_step)
            next_log = min(max(log_factor + log_step, min_log), max_log)
            if next_log == log_factor and log_excess > 0.0:
                return ScaleLimit(0.0, limit)
            if next_log == log_factor and log_excess < 0.0:
                return ScaleLimit(math.inf, replace(limit, name=NO_LIMIT))
            relative_change = max(
                abs(log_excess), abs(next_log - log_factor), rise_change / max(rise_limit.rises.values())
            )
            is_converged = last_point is not None and relative_change < settings.resolution
            last_point, log_factor = (log_factor, log_excess), next_log
            if is_converged:
                break
        return ScaleLimit(math.exp(log_factor), limit)


def _start_search(reducer: Reducer, steady_state: SteadyState, settings: ThermalSettings) -> ScaleLimit:
    """Return the first estimate of a search: losses that are in proportion to the factor."""
    ambient = reducer.design.service.ambient_temperature
    rises = {part: temperature - ambient for part, temperature in steady_state.temperatures.items()}
    limit = find_rise_limit(reducer, rises, settings)
    return ScaleLimit(limit.factor, limit)


@once
def find_speed_factor(reducer: Reducer, duty: Duty, settings: ThermalSettings = SETTINGS) -> ScaleLimit:
    """Find the largest factor on all speeds of a duty at which the steady temperatures exceed no thermal limit.

    Temperatures are those of the mean losses. The result also has the limit that is then reached. The reducer is at 20
    °C; errors as `solve_steady_state`.
    """
    steady_state, reducer = solve_steady_state(reducer, duty, settings), state_seals(reducer)
    points = _running_points(reducer, duty)
    search = ScaleSearch(
        reducer,
        settings,
        lambda factor: [replace(point, speed=factor * point.speed) for point in points],
        settings.largest,
    )
    return search.solve(_start_search(reducer, steady_state, settings))


def _running_points(reducer: Reducer, duty: Duty) -> tuple[DutyPoint, ...]:
    """Return the points at which the crank turns, with the rests of the design; errors as `turning_points`."""
    return turning_points(add_rests(duty, reducer.design.service.duty_share), reducer.design, "the drive heats up")


@once
def find_torque_factor(reducer: Reducer, duty: Duty, settings: ThermalSettings = SETTINGS) -> ScaleLimit:
    """Find the largest factor on all torques of a duty at which the steady temperatures exceed no thermal limit.

    Temperatures are those of the mean losses. The result also has the limit that is then reached. The reducer is at 20
    °C; errors as `solve_steady_state`.
    """
    steady_state, reducer = solve_steady_state(reducer, duty, settings), state_seals(reducer)
    search = _torque_search(reducer, _running_points(reducer, duty), settings)
    return search.solve(_start_search(reducer, steady_state, settings))


def find_duty_torques(reducer: Reducer, duty: Duty, settings: ThermalSettings = SETTINGS) -> dict[float, float]:
    """Find the largest torque [N m] that heat allows in short cycles with rests (S3), by share of the running time [1].

    The keys are the shares `ThermalSettings.duty_shares`. The running time has the points of the duty, and the cycles
    are so short that they heat as their mean. The reducer is at 20 °C; errors as `solve_steady_state`.
    """
    duty_limit, reducer = find_torque_factor(reducer, duty, settings), state_seals(reducer)
    points = _running_points(reducer, duty)
    max_torque, running_share = max(abs(point.torque) for point in points), sum(point.share for point in points)
    limits, last_share = {}, running_share
    start_limit = duty_limit if 0.0 < duty_limit.factor < math.inf else replace(duty_limit, factor=1.0)
    for share in reversed(settings.duty_shares):
        limit = duty_limit
        if not math.isclose(share, running_share):
            points_with_rests = [replace(point, share=share / running_share * point.share) for point in points]
            estimate = replace(start_limit, factor=start_limit.factor * last_share / share)
            limit = _torque_search(reducer, points_with_rests, settings).solve(estimate)
        limits[share] = limit.factor * max_torque
        if 0.0 < limit.factor < math.inf:
            start_limit, last_share = limit, share
    return dict(sorted(limits.items()))


def _torque_search(reducer: Reducer, points: Sequence[DutyPoint], settings: ThermalSettings) -> ScaleSearch:
    """Return the search for the largest factor on the torques of a duty, whose mean losses set the temperatures."""
    nominal_factor = max(1.0, reducer.design.rated_torque / max(abs(point.torque) for point in points))
    running_share = sum(point.share for point in points)
    return ScaleSearch(
        reducer,
        settings,
        lambda factor: [replace(point, torque=factor * point.torque) for point in points],
        settings.largest * nominal_factor / running_share,
    )
