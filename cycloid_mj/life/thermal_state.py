"""Temperatures of a drive under a duty, its warm-up and thermal limits: values, tables and curves."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from cycloid_mj.base.array import Array
from cycloid_mj.base.frame import Frame
from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.base.result import Curve, Quantity, Table, quantity_frame, to_json_values
from cycloid_mj.base.units import RPM
from cycloid_mj.life.duty import Duty
from cycloid_mj.life.steady_state import ThermalSettings
from cycloid_mj.life.thermal_limits import find_duty_torques
from cycloid_mj.life.thermal_network import Network
from cycloid_mj.reducer import Reducer


@dataclass(frozen=True)
class TightestTime:
    """Time of a warm-up [s] with the least play.

    `play` is the radial play of the teeth [m], `pair` the pair with the smallest `clearance` [m] at this time, and
    `rises` are the temperature rises of the parts over the air [K].
    """

    time: float
    play: float
    pair: str
    clearance: float
    rises: Mapping[str, float]

    @property
    def jams(self) -> bool:
        """True if a clearance is lost at this time."""
        return min(self.play, self.clearance) <= 0.0


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
        Largest output torque [N m] and crank speed [rad/s] that heat allows, the other being that of the duty; inf if
        none up to `ThermalSettings.largest` times the duty's or the nominal value is too large.
    limited_by
        Limit of that torque, in words.
    times, warm_up
        Times [s] and temperature of each part [°C] after a start from the temperature of the air.
    peaks
        Largest temperature of each part in a cycle of the periodic state [°C].
    largest_difference
        Largest difference of disc and ring in the warm-up [K].
    tightest
        Time of the warm-up and its cycles with the least play.
    smallest_play
        Least radial play of the teeth in the warm-up and its cycles [m].
    converged
        Whether losses and temperatures agree; false if the parts jam on the way.
    assumptions
        Assumptions, a sentence each.
    reducer, duty, settings
        The drive at 20 °C, its duty with rests, and the settings of the computation.
    can_preload
        Whether parts that lose their clearance are preloaded against springs instead of jamming.
    momentary_torque, bearing_speed
        Largest output torque of an emergency stop [N m] and largest crank speed [rad/s] of the greased bearings, which
        do not depend on heat; NaN if they are not known.
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
    peaks: Mapping[str, float]
    largest_difference: float
    tightest: TightestTime
    smallest_play: float
    converged: bool
    assumptions: tuple[str, ...]
    reducer: Reducer
    duty: Duty
    settings: ThermalSettings
    can_preload: bool = False
    momentary_torque: float = math.nan
    bearing_speed: float = math.nan

    @cached_property
    def duty_torques(self) -> Mapping[float, float]:
        """Torque limit [N m] if the drive rests for the remaining time, by share of the time."""
        return find_duty_torques(self.reducer, self.duty, self.settings)

    @property
    def torque_words(self) -> str:
        """What limits the torque by heat; if parts fail at a smaller torque, also that torque."""
        if self.torque > self.momentary_torque:
            return f"{self.limited_by}; by heat alone, the momentary torque is {self.momentary_torque:.4g} N m"
        return self.limited_by

    @property
    def jams_when_steady(self) -> bool:
        """True if a clearance is lost at the steady temperatures, those of the mean losses."""
        return not self.can_preload and (self.play <= 0.0 or min(self.clearances.values()) <= 0.0)

    @property
    def jams(self) -> bool:
        """True if a clearance is lost in the steady state, or at any time of the warm-up and its cycles."""
        return self.jams_when_steady or (not self.can_preload and self.tightest.jams)

    @property
    def quantities(self) -> dict[str, Quantity]:
        """Return temperatures [°C], their differences [K], tooth play [um], losses [W] and thermal limits.

        The keys are such as "temperature_disc_c" and "thermal_torque_nm". The limits by strength and bearings follow
        those by heat. Quantities that are not known are left out.
        """
        speed_note = ", by heat alone" if self.speed > self.bearing_speed else ""
        rows = [
            *(
                Quantity(f"temperature_{part}_c", f"temperature, {part}", value, "°C")
                for part, value in self.temperatures.items()
            ),
            Quantity("difference_k", "disc warmer than ring", self.difference, "K"),
            Quantity(
                "largest_difference_k", "disc warmer than ring, largest in the warm-up", self.largest_difference, "K"
            ),
            Quantity("jam_difference_k", "difference that closes the teeth", self.jam_difference, "K"),
            Quantity("tooth_play_um", "radial play of the teeth, warm", 1e6 * self.play, "um"),
            Quantity("smallest_tooth_play_um", "the same, smallest in the warm-up", 1e6 * self.smallest_play, "um"),
            Quantity("loss_w", "power lost", sum(self.losses.values()), "W"),
            Quantity("thermal_torque_nm", f"thermal torque limit: {self.torque_words}", self.torque, "N m"),
            Quantity(
                "thermal_speed_rpm", f"thermal speed limit at the duty's torque{speed_note}", self.speed / RPM, "rpm"
            ),
            Quantity("momentary_torque_nm", "momentary torque, by strength alone", self.momentary_torque, "N m"),
            Quantity("bearing_speed_rpm", "largest speed of the greased bearings", self.bearing_speed / RPM, "rpm"),
            Quantity("time_constant_s", "slowest time constant", self.network.time_constant, "s"),
        ]
        return {row.key: row for row in rows if not math.isnan(row.value)}

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
        """Return five tables on the heat of a drive: parts, losses, torque limits by duty, clearances, conductances."""
        is_usable = not max(self.duty_torques.values()) > self.momentary_torque
        strength_note = "" if is_usable else f", by heat alone: momentary torque {self.momentary_torque:.4g} N m"
        part_rows = tuple(
            (part, value, self.peaks[part], self.heat[part], self.network.capacities[part])
            for part, value in self.temperatures.items()
        )
        part_headings = ("part", "mean temperature [°C]", "largest in a cycle [°C]", "heat [W]", "heat capacity [J/K]")
        return (
            Table("Parts", part_headings, part_rows),
            Table("Losses", ("source", "power [W]"), tuple(self.losses.items())),
            Table(
                f"Thermal torque limit by duty (S3, rest without speed){strength_note}",
                ("share of the time [%]", "output torque [N m]"),
                tuple((f"{100.0 * share:g}", torque) for share, torque in self.duty_torques.items()),
            ),
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
        """Convert temperatures [°C], losses [W], torque limits [N m] and warm-up to JSON; infinite limits are None.

        ``losses_w`` are by source, ``heat_w`` is the heat into each part, and ``thermal_torque_by_duty`` lists the
        torque limit for several shares of the time.
        """
        content = {
            "design": self.design,
            "condition": self.condition,
            "temperatures_c": dict(self.temperatures),
            "peak_temperatures_c": dict(self.peaks),
            **{key: row.value for key, row in self.quantities.items() if not key.startswith("temperature_")},
            "jams": self.jams,
            "clearances_um": {pair: 1e6 * value for pair, value in self.clearances.items()},
            "tightest_time_s": self.tightest.time,
            "losses_w": dict(self.losses),
            "heat_w": dict(self.heat),
            "limited_by": self.limited_by,
            "thermal_torque_by_duty": [
                {"share": share, "torque_nm": torque} for share, torque in self.duty_torques.items()
            ],
            "warm_up": {
                "time_s": self.times.tolist(),
                **{f"{part}_c": values.tolist() for part, values in self.warm_up.items()},
            },
            "conductances_w_k": [vars(item) for item in self.network.conductances],
            "heat_capacities_j_k": dict(self.network.capacities),
            "converged": self.converged,
            "assumptions": list(self.assumptions),
        }
        return dict(to_json_values(content))
