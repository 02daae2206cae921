"""Torque on the crank without load, with grease, bearings and seals, over speed and temperature.

Bearings: Palmgren's load-independent friction torque M0, as in Harris, Rolling Bearing Analysis. Seals: power of radial
shaft seals, ISO/TR 14179-2. Viscosity: Walther, lg lg (nu + 0.7) = A - B lg T.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cycloid_mj.design import Design
from cycloid_mj.design.lubricants import lubricant, walther
from cycloid_mj.design.stock import has_inner_ring
from cycloid_mj.life.bearings import Bearing, bearings_of, friction_torque
from cycloid_mj.life.loading import relative_speed
from cycloid_mj.life.output_loads import equivalent_load
from cycloid_mj.lubrication.bearings import idle_torque
from cycloid_mj.parts.cam_bearing import cam_bearing
from cycloid_mj.parts.export.bearings import shaft_bearing
from cycloid_mj.parts.export.casing import bearing_width_of, casing, seat_radius
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.statics.film import seal_torques


@dataclass(frozen=True)
class Grease:
    """A grease: its name, and the viscosity of its base oil at 40 and 100 °C [mm2/s]."""

    name: str = "lithium-soap grease, NLGI 2, base oil of ISO VG 100, PAO for plastic parts (assumed)"
    viscosity_40: float = 100.0
    viscosity_100: float = 11.2
    coldest: float = -20.0
    """Lowest temperature in service [°C] (assumed, as of usual multi-purpose greases; DIN 51825, K2K-20)."""

    def viscosity(self, temperature: float) -> float:
        """Compute the viscosity of the base oil [mm2/s] at a temperature [°C] (Walther)."""
        return walther(self.viscosity_40, self.viscosity_100, temperature)


GREASE = Grease()


def grease_of(design: Design) -> Grease:
    """Return the lubricant of a design with the friction law ``film``, else the assumed grease."""
    if not design.has_film:
        return GREASE
    oil = lubricant(design.friction.lubricant)
    return Grease(f"{oil.name} (friction.lubricant)", oil.viscosity_40, oil.viscosity_100, oil.coldest)


BEARING_FACTORS = {"needle": (5.0, 12.0), "ball": (1.0, 2.0), "tapered": (3.0, 6.0), "crossed roller": (3.0, 6.0)}
"""Palmgren's factor f0 of bearings with little grease or oil, lower and upper value by kind (Harris; SKF).

Crossed rollers have that of tapered rollers, which also slide at their ends.
"""


@dataclass(frozen=True)
class NoLoadTorque:
    """Torque of bearings and seals on the crank [N m], and its range over the factors of the bearings."""

    bearings: float
    seals: float
    low: float
    high: float

    @property
    def total(self) -> float:
        """Torque of bearings and seals together [N m]."""
        return self.bearings + self.seals


def no_load_torque(reducer: Reducer, speed: float, temperature: float) -> NoLoadTorque:
    """Compute the no-load torque of bearings and seals, referred to the crank [N m], with its range.

    `speed` is the crank speed [rad/s]; at 0 the result is the torque that starts the drive. `temperature` [°C] is the
    temperature of the grease. Bearings have Palmgren's load-independent torque M0, and a preloaded pair also the
    friction torque of its preload. Seals follow ISO/TR 14179-2.

    Friction that statics includes is left out: contacts of teeth and pins; seals, if the design sets a torque in
    ``[drag]``; and with the friction law ``film`` cam bearings and seals. Of an RV reducer, statics includes all
    bearings and the seal.
    """
    if isinstance(reducer, RvReducer):
        return NoLoadTorque(0.0, 0.0, 0.0, 0.0)
    viscosity = grease_of(reducer.design).viscosity(temperature)
    crank_speed = abs(speed) or abs(reducer.design.drive.speed)
    torques = []
    for factors, bearing_count, diameter, speed_ratio in _bearing_torque_terms(reducer):
        torque_per_factor = (
            bearing_count * speed_ratio * idle_torque(1.0, diameter, speed_ratio * abs(speed), viscosity)
        )
        torques.append([factor * torque_per_factor for factor in (0.5 * sum(factors), *factors)])  # mean, low, high
    preload_torque = _preload_torque(reducer, crank_speed)
    bearing_torque, low, high = (preload_torque + sum(column) for column in zip(*torques, strict=True))
    seal_torque = _seal_torque(reducer, crank_speed)
    return NoLoadTorque(bearing_torque, seal_torque, low + seal_torque, high + seal_torque)


def _bearing_torque_terms(reducer: Reducer) -> Iterator[tuple[tuple[float, float], int, float, float]]:
    """Yield the inputs of Palmgren's formula of the no-load torque for each kind of bearing of the drive.

    With the friction law ``film``, the cam bearings are left out, because statics includes their torque.

    Yields
    ------
    tuple
        Lower and upper value of Palmgren's factor f0, number of bearings, mean diameter [m], and ratio of the bearing's
        speed to the crank's [1].
    """
    design = reducer.design
    for bearing in bearings_of(reducer):
        if design.has_film and bearing.key == "cam_bearing":
            continue
        kind, count, diameter = _bearing_size(reducer, bearing)
        speed_ratio = bearing.speed(reducer, design.drive.speed) / abs(design.drive.speed)
        yield BEARING_FACTORS[kind], count, diameter, speed_ratio


def _bearing_size(reducer: Reducer, bearing: Bearing) -> tuple[str, int, float]:
    """Return type of a bearing (key of `BEARING_FACTORS`), number of equal bearings, and mean diameter [m]."""
    design = reducer.design
    if bearing.key == "cam_bearing":
        stock_bearing = cam_bearing(reducer)
        bore = (
            stock_bearing[0].bore
            if stock_bearing
            else 2.0 * (design.gear.bore_radius - 2.0 * reducer.contacts.roller_radius)
        )
        is_ball = stock_bearing is not None and has_inner_ring(stock_bearing[0])
        return "ball" if is_ball else "needle", design.gear.discs, 0.5 * bore + design.gear.bore_radius
    if bearing.key == "output_rollers":
        return "needle", design.output.pins * design.gear.discs, design.output.root_radius + design.output.pin_radius
    if bearing.key.startswith("output"):
        hub = casing(reducer).hub
        kind = "ball" if hub.has_balls else "tapered" if hub.has_tapered_rollers else "crossed roller"
        return kind, 1, 0.5 * (hub.bore + hub.outside)
    shaft_stock_bearing = shaft_bearing(reducer)
    is_ball = shaft_stock_bearing is not None and has_inner_ring(shaft_stock_bearing)
    return "ball" if is_ball else "needle", 1, design.shaft.radius + seat_radius(reducer, bearing_width_of(reducer))


def _preload_torque(reducer: Reducer, crank_speed: float) -> float:
    """Return the friction torque by the preload of the output's bearings, referred to the crank [N m].

    `crank_speed` [rad/s] serves to compute ratios of speeds, which do not depend on it; it must not be 0.
    """
    return sum(
        friction_torque(reducer, bearing, float(equivalent_load(casing(reducer).hub, np.zeros(1))[0]))
        * bearing.speed(reducer, crank_speed)
        / crank_speed
        for bearing in bearings_of(reducer)
        if bearing.key.startswith("output_bearing")
    )


def _seal_torque(reducer: Reducer, crank_speed: float) -> float:
    """Return the torque of the seals referred to the crank [N m]; 0 if statics includes it.

    `crank_speed` [rad/s] serves to compute ratios of speeds, which do not depend on it; it must not be 0.
    """
    design = reducer.design
    if design.drag.crank or design.drag.output or design.has_film:
        return 0.0
    shaft_torque, hub_torque = seal_torques(reducer)
    seal_speeds = (
        relative_speed(reducer, crank_speed, ("shaft", "housing")),
        relative_speed(reducer, crank_speed, ("output", "housing")),
    )
    return seal_speeds[0] / crank_speed * shaft_torque + seal_speeds[1] / crank_speed * hub_torque
