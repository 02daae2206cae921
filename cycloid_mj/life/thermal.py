"""Steady temperatures of a drive, its warm-up, and the torque and speed that heat allows."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError, RunError
from cycloid_mj.base.frame import Frame
from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.base.result import Curve, Quantity, Table, quantity_frame, to_json_values
from cycloid_mj.base.units import RPM
from cycloid_mj.design import Design, Named, resolve
from cycloid_mj.design.model import HEATED
from cycloid_mj.geometry.expansion import jam_difference, tooth_play, warm_clearances
from cycloid_mj.life.duty import Duty, DutyPoint, constant_duty
from cycloid_mj.life.heat import heat_limits, mean_losses
from cycloid_mj.life.item import RatedItem
from cycloid_mj.life.loading import POSES, Loading, solve_loading
from cycloid_mj.life.thermal_network import Conductance, Network, build_network, heat_by_node
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
    samples
        Times of the warm-up, over four of the slowest time constant.
    """

    tolerance: float = 0.05
    rounds: int = 12
    hottest: float = 300.0
    largest: float = 100.0
    solved: float = 1.5
    corrections: int = 5
    resolution: float = 0.01
    samples: int = 121


SETTINGS = ThermalSettings()


@dataclass(frozen=True, eq=False)
class ThermalState(Presented):
    """Temperatures of a drive under a duty, and the limits by heat.

    Attributes
    ----------
    design, condition
        Name of the design, and torque, speed and surroundings.
    temperatures
        Steady temperature of each part [°C].
    losses
        Mean power lost by source [W].
    heat
        Power that heats each part [W].
    network
        Conductances and heat capacities.
    difference, jam_difference
        Disc over ring, and the difference that closes the clearance of the teeth [K].
    clearances, play
        Clearance of each mating pair, and radial play of the teeth, at these temperatures [m].
    torque, speed
        Largest output torque [N m] and crank speed [rad/s] that no limit forbids, the other being that of the duty;
        inf if none does within `ThermalSettings.largest` times the duty's.
    limited_by
        Limit of that torque, in words.
    times, warm_up
        Times [s] and temperature of each part [°C] after a start from the temperature of the air.
    converged
        Whether losses and temperatures agree; false if the parts jam on the way.
    assumptions
        Assumptions, a sentence each.
    """

    design: str
    condition: str
    temperatures: Mapping[str, float]
    losses: Mapping[str, float]
    heat: Mapping[str, float]
    network: Network
    difference: float
    jam_difference: float
    clearances: Mapping[str, float]
    play: float
    torque: float
    speed: float
    limited_by: str
    times: Array
    warm_up: Mapping[str, Array]
    converged: bool
    assumptions: tuple[str, ...]

    @property
    def jams(self) -> bool:
        """True if a clearance is lost in the steady state."""
        return self.play <= 0.0 or min(self.clearances.values()) <= 0.0

    @property
    def quantities(self) -> dict[str, Quantity]:
        """Return temperatures, differences, losses and thermal limits by key."""
        rows = [
            *(
                Quantity(f"temperature_{part}_c", f"temperature, {part}", value, "°C")
                for part, value in self.temperatures.items()
            ),
            Quantity("difference_k", "disc warmer than ring", self.difference, "K"),
            Quantity("jam_difference_k", "difference that closes the teeth", self.jam_difference, "K"),
            Quantity("tooth_play_um", "radial play of the teeth, warm", 1e6 * self.play, "um"),
            Quantity("loss_w", "power lost", sum(self.losses.values()), "W"),
            Quantity("thermal_torque_nm", f"thermal torque limit: {self.limited_by}", self.torque, "N m"),
            Quantity("thermal_speed_rpm", "thermal speed limit at the duty's torque", self.speed / RPM, "rpm"),
            Quantity("time_constant_s", "slowest time constant", self.network.time_constant, "s"),
        ]
        return {row.key: row for row in rows}

    @property
    def frame(self) -> Frame:
        """The quantities, one per row."""
        return quantity_frame(self.quantities)

    @property
    def line(self) -> str:
        """Design, condition and temperatures."""
        return f"{self.design}, {self.condition}; " + ", ".join(f"{k} {v:.3g} °C" for k, v in self.temperatures.items())

    @property
    def curves(self) -> tuple[Curve, ...]:
        """Return the temperature of each part over time in the warm-up."""
        title = "Warm-up from the temperature of the air"
        return tuple(
            Curve(title, part, self.times / 60.0, values, "time [min]", "temperature [°C]")
            for part, values in self.warm_up.items()
        )

    def tables(self) -> tuple[Table, ...]:
        """Return four tables: parts, losses, warm clearances and conductances."""
        parts = tuple(
            (part, value, self.heat[part], self.network.capacities[part]) for part, value in self.temperatures.items()
        )
        return (
            Table("Parts", ("part", "temperature [°C]", "heat [W]", "heat capacity [J/K]"), parts),
            Table("Losses", ("source", "power [W]"), tuple(self.losses.items())),
            Table(
                "Warm clearances",
                ("pair", "clearance [um]"),
                tuple((pair.replace("_", " "), 1e6 * value) for pair, value in self.clearances.items()),
            ),
            Table(
                "Conductances",
                ("between", "[W/K]", "source"),
                tuple((f"{item.first} - {item.second}", item.value, item.source) for item in self.network.conductances),
                words=(2,),
            ),
        )

    def as_json(self) -> dict[str, Any]:
        """Convert the state to JSON values; infinite limits become None."""
        return dict(
            to_json_values(
                {
                    "design": self.design,
                    "condition": self.condition,
                    "temperatures_c": dict(self.temperatures),
                    "difference_k": self.difference,
                    "jam_difference_k": self.jam_difference,
                    "jams": self.jams,
                    "clearances_um": {pair: 1e6 * value for pair, value in self.clearances.items()},
                    "tooth_play_um": 1e6 * self.play,
                    "losses_w": dict(self.losses),
                    "heat_w": dict(self.heat),
                    "thermal_torque_nm": self.torque,
                    "thermal_speed_rpm": self.speed / RPM,
                    "limited_by": self.limited_by,
                    "time_constant_s": self.network.time_constant,
                    "warm_up": {
                        "time_s": self.times.tolist(),
                        **{f"{part}_c": values.tolist() for part, values in self.warm_up.items()},
                    },
                    "conductances_w_k": [vars(item) for item in self.network.conductances],
                    "heat_capacities_j_k": dict(self.network.capacities),
                    "converged": self.converged,
                    "assumptions": list(self.assumptions),
                }
            )
        )


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
    times = np.linspace(0.0, 4.0 * steady_state.network.time_constant, settings.samples)
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
        times=times,
        warm_up={part: ambient + rise for part, rise in steady_state.network.warm_up(heat, times).items()},
        converged=steady_state.converged,
        assumptions=tuple(_assumptions(steady_state)),
    )


@dataclass(frozen=True)
class _Steady:
    """Temperatures [°C], losses by source [W] and network of a steady state, and whether they agree."""

    temperatures: dict[str, float]
    losses: dict[str, float]
    network: Network
    converged: bool


def _solve_steady_state(reducer: Reducer, points: Sequence[DutyPoint], settings: ThermalSettings) -> _Steady:
    """Solve losses and temperatures that agree with each other, by successive substitution from the air's temperature.

    Losses and conductances are those of the warm clearances. If the parts jam at the temperatures of a round, the
    losses of the round before it remain, and the state is not converged.
    """
    ambient = reducer.design.service.ambient_temperature
    temperatures = dict.fromkeys(HEATED, ambient)
    warm, has_converged = reducer, False
    for _ in range(settings.rounds):
        losses, network = _solve_losses(warm, points, temperatures["housing"])
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
    return _Steady(temperatures, losses, network, has_converged)


def _solve_losses(reducer: Reducer, points: Sequence[DutyPoint], wall: float) -> tuple[dict[str, float], Network]:
    """Return the mean losses of a duty by source [W], and the network under its largest torque."""
    loadings = [solve_loading(reducer, point, POSES, with_wind_up=False) for point in points]
    worst = max(loadings, key=lambda loading: abs(loading.point.torque))
    return mean_losses(reducer, loadings), build_network(reducer, worst, wall)


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
                reducer, _solve_steady_state(reducer, scale_duty(duty_factor), settings), settings
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


def _assumptions(steady: _Steady) -> Iterator[str]:
    """Yield the assumptions of a steady state, a sentence each."""
    yield "friction: the coefficients of the design at any temperature; bearings by mu F d/2"
    yield "half of each loss heats each of the two parts that meet; motor and driven machine take no heat"
    yield "conductances of bearings assume 14 rollers, a third of them loaded; conductivities by the kind of material"
    if not steady.converged:
        yield "the parts jam at these temperatures: the losses are those before the clearance is lost"


def rate_jam_difference(reducer: Reducer, loadings: Sequence[Loading]) -> Iterator[RatedItem]:
    """Rate how much warmer the disc gets than the ring against the temperature difference that closes the teeth [K].

    Losses and conductances are those at 20 °C, without the fixed point of `thermal`.
    """
    worst = max(loadings, key=lambda loading: abs(loading.point.torque))
    network = build_network(reducer, worst, reducer.design.service.ambient_temperature, without_capacities=True)
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
