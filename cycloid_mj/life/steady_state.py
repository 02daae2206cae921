"""Steady temperatures of the parts of a drive under a duty, where losses, temperatures and clearances agree."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import CycloidError
from cycloid_mj.design import Design
from cycloid_mj.design.model import HEATED, REFERENCE_TEMPERATURE
from cycloid_mj.geometry.expansion import at_temperatures, tooth_play, warm_clearances
from cycloid_mj.life.duty import Duty, DutyPoint, add_rests, constant_duty, turning_points
from cycloid_mj.life.heat import heat_limits, housing_temperature, mean_losses, running_share
from cycloid_mj.life.loading import Loading, solve_loading
from cycloid_mj.life.rv_thermal import solve_rv_losses
from cycloid_mj.life.thermal_network import Conductance, Network, build_network, heat_by_node, heat_capacities
from cycloid_mj.reducer import Reducer, RvReducer, once
from cycloid_mj.reducer.reducer import Drive
from cycloid_mj.statics.film import state_seals
from cycloid_mj.statics.springs import POSES


@dataclass(frozen=True)
class ThermalSettings:
    """Settings of the fixed point of losses and temperatures, and of the search for the limits.

    Attributes
    ----------
    tolerance
        The iteration has converged if no temperature changes by more than this in a step [K]; far below the error due
        to the assumed conductances.
    rounds
        Largest number of iterations.
    film_step, largest_relaxation
        First step of the iteration with film friction, as a share of the full step, and largest relaxation factor of
        the next steps. The losses of cold oil are too large: a full step may pass over the state that a warm-up
        reaches, to a hotter one.
    hottest
        Temperature at which the iteration ends [°C], the largest that a design file allows: no drive gets so hot.
    smallest, largest
        Range of the factor on the speed, and on the larger of the duty's and the nominal torque, that is searched for a
        limit.
    corrections, resolution
        Largest number of solutions of the losses in the search for a limit, and the relative change of losses and
        limit at which it ends.
    slopes, largest_step
        Range of the slope of rises over factor, both logarithmic, and largest step of the logarithm in this search.
    runaway_level, levels, level_resolution
        Level of the temperature rises, relative to those at the limit, at which a steady state below the limit is
        searched for; range and resolution of the levels if there is such a state.
    approach
        Share of the temperature rises at a limit at which these losses are computed, so that the parts do not yet jam.
    smallest_step
        Smallest relaxation factor of the iteration, and smallest share to which a step is shortened if the parts would
        jam.
    crank_angles
        Number of crank angles at which losses and conductances are computed.
    samples, time_constants
        Number of time steps of the warm-up, and its duration divided by the slowest time constant.
    duty_shares
        Shares of the time under load in intermittent duties (S3, IEC 60034-1) whose torque limits are reported.
    """

    tolerance: float = 0.05
    rounds: int = 40
    film_step: float = 0.5
    largest_relaxation: float = 4.0
    hottest: float = 300.0
    smallest: float = 1e-3
    largest: float = 100.0
    corrections: int = 20
    resolution: float = 0.01
    slopes: tuple[float, float] = (1.0 / 3.0, 3.0)
    largest_step: float = math.log(4.0)
    runaway_level: float = 0.9
    levels: tuple[float, float] = (0.05, 1.0)
    level_resolution: float = 0.02
    approach: float = 0.99
    smallest_step: float = 0.125
    crank_angles: int = POSES
    samples: int = 120
    time_constants: float = 4.0
    duty_shares: tuple[float, ...] = (0.15, 0.25, 0.4, 0.6, 1.0)


SETTINGS = ThermalSettings()

JAM, NO_EQUILIBRIUM = "the parts jam", "no static equilibrium exists"
NO_AGREEMENT = "losses and temperatures do not agree"
"""Obstacles to a steady state, in words."""


@dataclass(frozen=True)
class SteadyState:
    """Temperatures, losses and network of a steady state.

    Attributes
    ----------
    temperatures
        Temperature of each part [°C].
    losses
        Mean losses of the duty by source [W], with its rests.
    conductances
        Conductances of the thermal network.
    obstacle
        What prevents that losses and temperatures agree, in words; "" if they agree.
    cold, warm
        Losses by source while the drive is at each point of the duty [W], at 20 °C and at the temperatures of `losses`.
    warm_temperatures
        Temperature of each part at which `losses` were computed [°C]; those of the last round without a jam if the
        result is not converged.
    reducer
        The drive at 20 °C.
    """

    temperatures: Mapping[str, float]
    losses: Mapping[str, float]
    conductances: tuple[Conductance, ...]
    obstacle: str
    cold: tuple[dict[str, float], ...]
    warm: tuple[dict[str, float], ...]
    warm_temperatures: Mapping[str, float]
    reducer: Reducer

    @cached_property
    def network(self) -> Network:
        """The thermal network, with the heat capacities of the parts at 20 °C."""
        return Network(self.conductances, heat_capacities(self.reducer))

    @property
    def converged(self) -> bool:
        """Whether losses and temperatures agree."""
        return not self.obstacle

    @property
    def difference(self) -> float:
        """Difference of the temperatures of disc and ring [K]."""
        return self.temperatures["disc"] - self.temperatures["ring"]

    @property
    def words(self) -> str:
        """Temperatures at which the losses were computed, as a condition of results."""
        temperature_text = ", ".join(
            f"{part} {temperature:.3g}" for part, temperature in self.warm_temperatures.items() if part != "housing"
        )
        beyond = {"": "", NO_AGREEMENT: ", not converged"}.get(self.obstacle, f", beyond which {self.obstacle}")
        return f"steady temperatures: {temperature_text} °C{beyond}"


def solve_steady_state(reducer: Reducer, duty: Duty, settings: ThermalSettings = SETTINGS) -> SteadyState:
    """Solve for the steady losses and temperatures of the parts of a drive at 20 °C under a duty cycle.

    A constant duty has rests if ``service.duty_share`` is below 1. The result is cached, so that all commands have the
    same temperatures of a drive.

    Raises
    ------
    DesignError
        The crank does not turn.
    RunError
        No static equilibrium exists at 20 °C.
    """
    duty = add_rests(duty, reducer.design.service.duty_share)
    points = turning_points(duty, reducer.design, "the drive heats up")
    return _iterate_temperatures(state_seals(reducer), points, settings)


def film_steady_state(reducer: Reducer, duty: Duty) -> SteadyState | None:
    """Return the steady state whose temperatures determine the losses that `rate` and the data sheet state.

    None stands for the temperatures of the design: with the friction law ``coulomb``, whose coefficients do not depend
    on them; if ``[thermal]`` sets other temperatures than 20 °C; and if the sizes are those of warm parts.
    """
    return solve_steady_state(reducer, duty) if warms_up(reducer.design) else None


def warms_up(design: Design) -> bool:
    """Return whether results with film friction use the steady temperatures, because the design sets none."""
    return design.has_film and not (design.thermal.applied or design.thermal.words)


def oil_temperatures(reducer: Reducer, temperatures: Mapping[str, float]) -> dict[str, float]:
    """Return the temperatures of the parts [°C] at which the viscosity of the oil in bearings is computed, by part.

    They are the given `temperatures`, but at most the permissible temperature of the drive (`heat_limits`): a hotter
    drive fails by heat, not by the life of its bearings.
    """
    max_temperature = min(limit.temperature for limit in heat_limits(reducer))
    return {part: min(temperature, max_temperature) for part, temperature in temperatures.items()}


def estimate_temperatures(reducer: Reducer, loadings: Sequence[Loading]) -> dict[str, float]:
    """Estimate the steady temperatures [°C], by part, from the losses at 20 °C, without iteration.

    `loadings` are the solved forces at each point of a duty, at 20 °C.
    """
    losses, share = mean_losses(reducer, loadings), running_share(reducer, loadings)
    rises = estimate_rises(reducer, loadings, losses, housing_temperature(reducer, share * sum(losses.values())))
    return {part: reducer.design.service.ambient_temperature + share * rise for part, rise in rises.items()}


def estimate_rises(
    reducer: Reducer, loadings: Sequence[Loading], losses: Mapping[str, float], wall_temperature: float
) -> dict[str, float]:
    """Estimate the steady temperature rises over the air [K], by part, from the losses of a duty without rests.

    `loadings` are the solved forces at each point of the duty, and `losses` its mean losses by source [W]
    (`mean_losses`). `wall_temperature` [°C] is that of the housing's wall, on which its heat transfer coefficient
    depends.
    """
    worst_loading = max(loadings, key=lambda loading: abs(loading.point.torque))
    network = build_network(reducer, worst_loading, wall_temperature)
    return network.rises(heat_by_node(reducer, losses))


def at_steady_temperatures(reducer: Drive) -> Drive:
    """Return a reducer at its steady temperatures under the nominal torque at the design's speed.

    They are the temperatures at which the losses were computed (`SteadyState.warm_temperatures`): if the parts would
    jam in the steady state, the last temperatures of the iteration at which none jams. The reducer is returned
    unchanged with the friction law ``coulomb``, or if its design sets other temperatures than 20 °C
    (`film_steady_state`).
    """
    design = reducer.design
    state = film_steady_state(reducer, constant_duty(design.rated_torque, design.drive.speed))
    if state is None:
        return reducer
    return state_seals(reducer).at_temperatures(state.warm_temperatures)


@once
def _iterate_temperatures(reducer: Reducer, points: Sequence[DutyPoint], settings: ThermalSettings) -> SteadyState:
    """Solve for the steady state by fixed-point iteration from 20 °C, at the points of a duty at which the crank turns.

    Losses and conductances depend on the temperatures, also through the clearances. Steps have Aitken's relaxation
    factor (`_relaxation`). If the parts jam at the next temperatures, have no equilibrium there or are too hot, the
    step is shortened. If this is so after the shortest step as well, the result has the losses before that step and
    states the obstacle. `settings` has the number of rounds and the tolerances.
    """
    ambient = reducer.design.service.ambient_temperature
    temperatures: Mapping[str, float] = dict.fromkeys(HEATED, REFERENCE_TEMPERATURE)
    point_losses, network = solve_losses(reducer, points, temperatures, settings)
    cold_losses, obstacle = point_losses, NO_AGREEMENT
    last_residual: Array | None = None
    last_step = settings.film_step if reducer.design.has_film else 1.0
    for rounds_left in range(settings.rounds, 0, -1):
        losses = mean_of_points(points, point_losses)
        target_temperatures = {
            part: ambient + rise for part, rise in network.rises(heat_by_node(reducer, losses)).items()
        }
        residual = np.array([target_temperatures[part] - temperatures[part] for part in HEATED])
        if np.max(np.abs(residual)) < settings.tolerance:
            obstacle = ""
            break
        step_share = full_step = _relaxation(last_step, last_residual, residual, settings)
        while step_share >= settings.smallest_step * full_step and rounds_left > 1:
            next_temperatures = {
                part: temperature + step_share * (target_temperatures[part] - temperature)
                for part, temperature in temperatures.items()
            }
            obstacle = _find_obstacle(reducer.design, next_temperatures, settings)
            if not obstacle:
                try:
                    point_losses, network = solve_losses(reducer, points, next_temperatures, settings)
                    break
                except CycloidError:
                    obstacle = NO_EQUILIBRIUM if reducer.design.layout == RvReducer.LAYOUT else JAM
            step_share *= 0.5
        else:
            break
        temperatures, obstacle, last_residual, last_step = next_temperatures, NO_AGREEMENT, residual, step_share
    links = network.conductances
    return SteadyState(target_temperatures, losses, links, obstacle, cold_losses, point_losses, temperatures, reducer)


def _relaxation(last_step: float, last_residual: Array | None, residual: Array, settings: ThermalSettings) -> float:
    """Return Aitken's relaxation factor [1] of a fixed-point iteration of vectors (Irons and Tuck 1969).

    `last_step` is the previous factor; `last_residual` and `residual` are the differences of the previous and the
    present temperatures to those of their losses [K], shape (parts,). The factor is in the range of the `settings`. The
    first step has no previous residual: `last_step` is returned.
    """
    if last_residual is None:
        return last_step
    change = residual - last_residual
    square = float(change @ change)
    factor = -last_step * float(last_residual @ change) / square if square else 1.0
    return min(max(factor, settings.smallest_step), settings.largest_relaxation)


def _find_obstacle(design: Design, temperatures: Mapping[str, float], settings: ThermalSettings) -> str:
    """Return why a drive cannot run with its parts at these temperatures [°C]; "" if it can.

    Either a part is hotter than the maximum that the `settings` permit, or thermal expansion closes a clearance. The
    parts of an RV reducer may lose their clearance, because they are then preloaded.
    """
    if max(temperatures.values()) > settings.hottest:
        return f"a part is hotter than {settings.hottest:g} °C"
    if design.layout == RvReducer.LAYOUT:
        return ""
    warm_design = at_temperatures(design, temperatures)
    return "" if min(tooth_play(warm_design), *warm_clearances(warm_design).values()) > 0.0 else JAM


def solve_losses(
    reducer: Reducer,
    points: Sequence[DutyPoint],
    temperatures: Mapping[str, float],
    settings: ThermalSettings,
) -> tuple[tuple[dict[str, float], ...], Network]:
    """Return the losses [W] by source at each point of a duty cycle, and the thermal network at the largest torque.

    Parameters
    ----------
    points
        Points of the duty; their shares of time are not used.
    temperatures
        Temperature of each part [°C].
    settings
        Settings of the thermal computation, of which only the number of crank angles is used.
    """
    if isinstance(reducer, RvReducer):
        return solve_rv_losses(reducer, points, temperatures, settings.crank_angles)
    loadings = [
        solve_loading(reducer, replace(point, share=1.0), settings.crank_angles, False, temperatures)
        for point in points
    ]
    worst_loading = max(loadings, key=lambda loading: abs(loading.point.torque))
    point_losses = tuple(mean_losses(reducer, [loading]) for loading in loadings)
    return point_losses, build_network(reducer, worst_loading, temperatures["housing"])


def mean_of_points(points: Sequence[DutyPoint], point_losses: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """Return the mean losses of a duty by source [W] from those at each of its points."""
    return {
        source: sum(point.share * losses[source] for point, losses in zip(points, point_losses, strict=True))
        for source in point_losses[0]
    }
