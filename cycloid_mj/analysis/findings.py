"""Results of a run: numbers with their units in their names, and the operating condition."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

from cycloid_mj.base.frame import Frame, make_frame
from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.base.result import Condition, to_json_values
from cycloid_mj.reducer import Reducer

Phase = Literal["hold", "ramp"]


def condition(reducer: Reducer) -> Condition:
    """Return the operating condition of a design: load, speed, temperature, friction law, and lubricant of ``film``."""
    design = reducer.design
    return Condition(
        design.load.torque,
        design.drive.speed,
        temperature=design.thermal.words,
        friction_law=design.friction.law,
        lubricant=design.friction.lubricant if design.has_film else "",
    )


@dataclass(frozen=True)
class Crank:
    """Mean speed of the driven shaft, and its largest deviation from the law of the drive, relative to the speed."""

    speed_rad_s: float
    max_relative_error: float | None


@dataclass(frozen=True)
class SpeedFindings:
    """Speed of disc or output compared with -omega_i/(N-1) (Eq. 12): mean values, and the error of the samples."""

    theory_rad_s: float
    mean_rad_s: float
    rms_error_rad_s: float
    peak_error_rad_s: float


@dataclass(frozen=True)
class PathFindings:
    """Distance of the point q from its position by Eq. 16."""

    q_mm: tuple[float, float]
    rms_error_um: float
    max_error_um: float


@dataclass(frozen=True)
class VelocityFindings:
    """Magnitude of the difference between the velocity of q and Eq. 17, or between its speed and Eq. 18."""

    rms_error_mm_s: float
    max_error_mm_s: float


@dataclass(frozen=True)
class AccelerationFindings:
    """Magnitude of the difference between the acceleration of q from sample to sample and Eq. 19 at the midpoint."""

    rms_error_m_s2: float
    max_error_m_s2: float


@dataclass(frozen=True)
class TransmissionError:
    """Angle of disc or output minus -theta/(N-1) at the measured crank angle theta.

    The mean is not an error of the run but a state of the drive: backlash taken up and, under load, elastic wind-up.
    """

    peak_to_peak_arcsec: float
    mean_arcsec: float


@dataclass(frozen=True)
class Disc:
    """Name, speed, transmission error and point q of a disc, if there are several."""

    name: str
    speed: SpeedFindings
    transmission_error: TransmissionError
    q_path: PathFindings
    q_speed: VelocityFindings


@dataclass(frozen=True)
class ContactSummary:
    """Mean number of loaded contacts, largest contact deflection, and largest contact force."""

    mean_active: float
    max_penetration_um: float
    peak_force_n: float


@dataclass(frozen=True)
class CrankBearings:
    """Forces of the cranks of an RV reducer on its discs.

    The largest force, and the largest of the bearings' means by the exponent of roller bearings, 10/3. The direction of
    the load turns with the carrier, so that only a window of a carrier turn has the values of a lifetime.
    """

    max_force_n: float
    mean_force_n: float


@dataclass(frozen=True)
class Pin1:
    """Largest radial displacement of ring pin 1 (or its sleeve), and its mean speed of rotation."""

    max_radial_um: float
    mean_spin_rad_s: float


@dataclass(frozen=True)
class Ramp:
    """The point q during the ramp (Eqs 16-20 with their tangential terms)."""

    q_path: PathFindings
    q_speed: VelocityFindings
    q_acceleration: AccelerationFindings | None
    samples: int


@dataclass(frozen=True)
class Power:
    """Mean input and output power, mean torques, and the crank torque without losses: load over ratio.

    The crank is the driven shaft: the sun of an RV reducer.
    """

    input_w: float
    output_w: float
    crank_torque_nm: float
    ideal_crank_torque_nm: float
    load_torque_nm: float


@dataclass(frozen=True)
class Loss:
    """Mean power lost in a kind of mating pair: by friction, and by normal forces (damping).

    Where pins slide equally on disc and seat, the split between the two depends on the time step; the sum does not.
    """

    pair: str
    friction_w: float
    normal_w: float


@dataclass(frozen=True)
class Window:
    """The evaluated part of the run: the settled part of the hold, or the ramp of a run that ended there."""

    start_s: float
    end_s: float
    samples: int
    crank_turns: float
    phase: Phase


@dataclass(frozen=True, repr=False)
class Findings(Presented):
    """Results of a run; None for quantities that do not exist or that the run lacks.

    All results except those of the `ramp` are for the `window`, under the `condition`. `transmission_error` is that of
    the output, and so is `output_transmission_error`. `warnings` limit the validity of the results. With several discs,
    the results of the disc and of q are those of the first; `discs` has all of them, and is empty for a single disc.
    `driven_shaft` is "crank", or "sun" of an RV reducer; the findings of the `crank` are those of this shaft.
    `timestep_for` states how accurate the results are at the time step.
    """

    design: str
    contact: str | None
    log: str | None
    timestep_s: float
    timestep: str | None
    steps: int | None
    wall_s: float | None
    crank: Crank
    gear_speed: SpeedFindings
    q_path: PathFindings
    q_speed: VelocityFindings
    transmission_error: TransmissionError
    contact_summary: ContactSummary
    pin1: Pin1 | None
    q_speed_magnitude: VelocityFindings
    q_acceleration: AccelerationFindings | None
    ramp: Ramp | None
    output_speed: SpeedFindings
    output_transmission_error: TransmissionError
    gear_transmission_error: TransmissionError
    discs: tuple[Disc, ...]
    driven_shaft: str
    crank_bearings: CrankBearings | None
    efficiency: float | None
    power: Power
    losses: tuple[Loss, ...]
    window: Window
    complete: bool
    note: str
    condition: Condition
    solver: str
    timestep_for: str | None
    warnings: tuple[str, ...]

    @property
    def frame(self) -> Frame:
        """The numbers of `as_json`, one per row, named by their keys joined by dots."""
        return make_frame(
            [{"key": key, "value": value} for key, value in _numbers(self.as_json())], ("key", "value"), {}
        )

    @property
    def line(self) -> str:
        """Design, condition, efficiency and transmission error."""
        efficiency = "" if self.efficiency is None else f"efficiency {100 * self.efficiency:.2f} %, "
        error = self.transmission_error.peak_to_peak_arcsec
        return f"{self.design}, {self.condition_words}; {efficiency}transmission error {error:.3g} arcsec"

    @property
    def condition_words(self) -> str:
        """The condition, and whether the run reached it."""
        return str(self.condition) + ("" if self.window.phase == "hold" else " (not reached: in the ramp)")

    def as_json(self) -> dict[str, Any]:
        """Convert the findings to JSON values, by the names of the attributes; NaN and infinities become None."""
        return dict(to_json_values(vars(self)))


def _numbers(nested: Any, key_path: str = "") -> Iterator[tuple[str, float]]:
    """Yield every number in nested dicts and lists with its path: keys and indices joined by dots."""
    if isinstance(nested, dict | list):
        for key, inner in nested.items() if isinstance(nested, dict) else enumerate(nested):
            yield from _numbers(inner, f"{key_path}.{key}".removeprefix("."))
    elif isinstance(nested, int | float) and not isinstance(nested, bool):
        yield key_path, float(nested)
