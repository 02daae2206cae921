"""Maps with the friction law ``film``: efficiency over torque, speed and temperature, and the torques without load."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from cycloid_mj.base.errors import DesignError, UsageError, warn
from cycloid_mj.base.result import Table
from cycloid_mj.base.units import RPM
from cycloid_mj.design.model import HEATED
from cycloid_mj.figures.catalogue import figure
from cycloid_mj.figures.statics import back_driving_spread, no_load_spread, starting_spread
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.film import state_seals
from cycloid_mj.statics.film_spread import Spread
from cycloid_mj.statics.sheet import sampled_efficiency


@dataclass(frozen=True)
class MapSettings:
    """Points of the map.

    Attributes
    ----------
    shares
        Torques over the nominal torque, and speeds over the design's speed.
    temperatures
        Temperatures of all parts [°C].
    samples
        Samples of each interval: their ends are within 0.3 points of those of 128 samples.
    """

    shares: tuple[float, ...] = (0.25, 0.5, 1.0)
    temperatures: tuple[float, ...] = (0.0, 20.0, 40.0, 60.0)
    samples: int = 64


MAP = MapSettings()


@dataclass(frozen=True)
class MapPoint:
    """A value of a map with its interval.

    Attributes
    ----------
    quantity, unit
        Name and unit of the value.
    torque, speed
        Output torque [N m] and crank speed [rad/s]; None where the value does not depend on them.
    temperature
        Temperature of all parts [°C].
    spread
        Value and interval [`unit`].
    """

    quantity: str
    unit: str
    torque: float | None
    speed: float | None
    temperature: float
    spread: Spread

    def as_json(self) -> dict[str, Any]:
        """Convert a point of an efficiency map to JSON values: ``quantity``, ``value``, its condition and its interval.

        ``value`` and the ends of its interval, ``low`` and ``high``, are in ``unit``. The condition is ``torque_nm``,
        ``speed_rpm`` and ``temperature_c``; torque or speed is None if the value does not depend on it.
        """
        return {
            "quantity": self.quantity,
            "unit": self.unit,
            "torque_nm": self.torque,
            "speed_rpm": None if self.speed is None else round(self.speed / RPM, 9),
            "temperature_c": self.temperature,
            "value": self.spread.value,
            "low": self.spread.low,
            "high": self.spread.high,
        }


def compute_film_map(
    reducer: Reducer, shares: Sequence[float] = MAP.shares, temperatures: Sequence[float] = MAP.temperatures
) -> tuple[MapPoint, ...]:
    """Compute efficiency over torque, speed and temperature, and the starting, no-load and back-driving torques.

    Parameters
    ----------
    reducer
        A drive at 20 °C with the friction law ``film``.
    shares
        Torques as shares of the nominal torque, and also speeds as shares of the design's speed; each torque is
        combined with each speed.
    temperatures
        Temperatures of all parts [°C].

    Returns
    -------
    tuple
        Points in the order of the temperatures. At each temperature they are the starting torque, the back-driving
        torque (except of RV reducers), and for each speed the no-load torque and the efficiency at each torque.

    Raises
    ------
    UsageError
        The drive has the law ``coulomb``, whose friction depends on neither speed nor temperature.
    DesignError
        The parts jam at all temperatures.
    RunError
        There is no equilibrium.

    Warns
    -----
    CycloidWarning
        The parts jam at some of the temperatures, which the map therefore does not have.
    """
    design = reducer.design
    if not design.has_film:
        raise UsageError(
            f'--map needs friction.law = "film", but {design.name} has friction.law = "{design.friction.law}", which '
            "does not depend on speed or temperature: add --set friction.law=film, or remove --map"
        )
    points, sealed_reducer, errors = list[MapPoint](), state_seals(reducer), dict[float, DesignError]()
    for temperature in temperatures:
        try:
            points += _compute_map_points(
                sealed_reducer.but(thermal=dict.fromkeys(HEATED, temperature)), temperature, shares
            )
        except DesignError as error:
            errors[temperature] = error
    if not points:
        raise next(iter(errors.values()))
    warn(design.name, tuple(f"--map has no values at {t:g} °C, because {error}" for t, error in errors.items()))
    return tuple(points)


def _compute_map_points(warm_reducer: Reducer, temperature: float, shares: Sequence[float]) -> list[MapPoint]:
    """Compute the points of an efficiency map at one temperature [°C], that of all parts of `warm_reducer`.

    The map is a grid: each torque is combined with each speed. `shares` are the torques relative to the nominal torque,
    and also the speeds relative to the design's speed.
    """
    design = warm_reducer.design
    points = [MapPoint("starting torque", "N m", None, None, temperature, starting_spread(warm_reducer, MAP.samples))]
    if figure("back_driving_torque_free_nm").applies_to(warm_reducer):
        back_driving = back_driving_spread(warm_reducer, MAP.samples)
        points.append(MapPoint("back-driving torque", "N m", None, None, temperature, back_driving))
    for speed in (share * design.drive.speed for share in shares):
        turning_reducer = warm_reducer.but(drive={"speed": speed})
        no_load = no_load_spread(turning_reducer, MAP.samples)
        points.append(MapPoint("no-load torque", "N m", None, speed, temperature, no_load))
        for torque in (share * design.rated_torque for share in shares):
            loaded_reducer = turning_reducer.but(load={"torque": torque})
            spread = sampled_efficiency(loaded_reducer, torque, MAP.samples)
            points.append(MapPoint("efficiency", "%", torque, speed, temperature, spread))
    return points


def map_tables(points: Sequence[MapPoint]) -> tuple[Table, ...]:
    """Return two tables, of the efficiency and of the torques without load, each value with its interval.

    `points` are the result of `compute_film_map`.
    """

    def format_row(point: MapPoint) -> tuple[str, ...]:
        """Format a point of an efficiency map as text: quantity, torque, speed, temperature, value, interval, unit."""
        spread = point.spread
        return (
            point.quantity,
            "" if point.torque is None else f"{point.torque:.4g}",
            "" if point.speed is None else f"{point.speed / RPM:.4g}",
            f"{point.temperature:g}",
            f"{spread.value:.3g} ({spread.low:.3g} to {spread.high:.3g})",
            point.unit,
        )

    header = ("quantity", "output torque [N m]", "crank speed [rpm]", "temperature [°C]", "value (5 to 95 %)", "unit")
    efficiencies = [point for point in points if point.quantity == "efficiency"]
    torque_points = [point for point in points if point.quantity != "efficiency"]
    return (
        Table("efficiency map", header, tuple(map(format_row, efficiencies))),
        Table("torques on crank and output without load", header, tuple(map(format_row, torque_points))),
    )
