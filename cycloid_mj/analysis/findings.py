"""The findings of a run: few numbers, each with its unit in its name, and their operating condition."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

from cycloid_mj.base.frame import Frame, framed
from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.base.result import Condition, plain
from cycloid_mj.reducer import Reducer

Phase = Literal["hold", "ramp"]


def condition(reducer: Reducer) -> Condition:
    """Return the condition that a design is run under."""
    return Condition(reducer.design.load.torque, reducer.design.drive.speed)


@dataclass(frozen=True)
class Crank:
    """Mean speed, and the largest deviation from the law of the drive, relative to its constant speed."""

    speed_rad_s: float
    max_relative_error: float | None


@dataclass(frozen=True)
class SpeedFindings:
    """Speed of the gear or the output against -omega_i/(N-1) (Eq. 12): the means, and the error at each sample."""

    theory_rad_s: float
    mean_rad_s: float
    rms_error_rad_s: float
    peak_error_rad_s: float


@dataclass(frozen=True)
class PathFindings:
    """Distance of the point q from its place by Eq. 16."""

    q_mm: tuple[float, float]
    rms_error_um: float
    max_error_um: float


@dataclass(frozen=True)
class VelocityFindings:
    """Size of the difference between the velocity of q and Eq. 17, or between its speed and Eq. 18."""

    rms_error_mm_s: float
    max_error_mm_s: float


@dataclass(frozen=True)
class AccelerationFindings:
    """Size of the difference between the mean acceleration of q from sample to sample and Eq. 19 half-way."""

    rms_error_m_s2: float
    max_error_m_s2: float


@dataclass(frozen=True)
class TransmissionError:
    """Angle of the gear or the output less -theta/(N-1) at the measured crank angle theta.

    The mean is no error of the run but a state of the drive: play that is taken up and, under load, elastic wind-up.
    """

    peak_to_peak_arcsec: float
    mean_arcsec: float


@dataclass(frozen=True)
class Disc:
    """One of several discs, by its name: its speed, its transmission error, and its point q."""

    name: str
    speed: SpeedFindings
    transmission_error: TransmissionError
    q_path: PathFindings
    q_speed: VelocityFindings


@dataclass(frozen=True)
class ContactSummary:
    """Contacts that carry a force, on average; the deepest penetration; the largest force of one contact."""

    mean_active: float
    max_penetration_um: float
    peak_force_n: float


@dataclass(frozen=True)
class Pin1:
    """Ring pin 1: how far its centre (its sleeve's) leaves its place, and its mean speed of rotation."""

    max_radial_um: float
    mean_spin_rad_s: float


@dataclass(frozen=True)
class Ramp:
    """The point q while the crank speeds up (Eqs 16-20 with their tangential terms)."""

    q_path: PathFindings
    q_speed: VelocityFindings
    q_acceleration: AccelerationFindings | None
    samples: int


@dataclass(frozen=True)
class Power:
    """Mean power into the crank and out at the load; mean torques, and the crank's without losses, T/(N-1)."""

    input_w: float
    output_w: float
    crank_torque_nm: float
    ideal_crank_torque_nm: float
    load_torque_nm: float


@dataclass(frozen=True)
class Loss:
    """Mean power that one kind of mating pair takes: by sliding, and by its normal forces (damping).

    Where pins rub alike on gear and seat, the time step decides which of them takes it: only their sum is determined.
    """

    pair: str
    friction_w: float
    normal_w: float


@dataclass(frozen=True)
class Window:
    """The part of the run that was judged: the settled part of the hold, or the ramp of a run that ended in it."""

    start_s: float
    end_s: float
    samples: int
    crank_turns: float
    phase: Phase


@dataclass(frozen=True, repr=False)
class Findings(Presented):
    """What a run says. None stands where a quantity does not exist or the run does not have it.

    All that is not of the `ramp` is of the `window`, under the `condition`. `transmission_error` is the output's, which
    a user of the drive feels; `output_transmission_error` is the same under its full name. `warnings` say what a reader
    should know before he trusts the figures. Of several discs, what is said of the gear and of q holds for the first;
    `discs` has each of them, and nothing where there is one. `timestep_for` says for which figures the step was chosen.
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
        """Every number of `as_json`, a row each, under its keys joined by dots."""
        return framed([{"key": key, "value": value} for key, value in _numbers(self.as_json())], ("key", "value"), {})

    @property
    def line(self) -> str:
        """Design, condition, efficiency and transmission error."""
        efficiency = "" if self.efficiency is None else f"efficiency {100 * self.efficiency:.2f} %, "
        error = self.transmission_error.peak_to_peak_arcsec
        return f"{self.design}, {self.condition_words}; {efficiency}transmission error {error:.3g} arcsec"

    @property
    def condition_words(self) -> str:
        """The condition, and whether the run came that far."""
        return str(self.condition) + ("" if self.window.phase == "hold" else " (not reached: in the ramp)")

    def as_json(self) -> dict[str, Any]:
        """Convert the findings to dicts, lists, numbers, text and None only."""
        return dict(plain(vars(self)))


def _numbers(of: Any, path: str = "") -> Iterator[tuple[str, float]]:
    """Yield the numbers within dicts and lists, each with its keys and places joined by dots."""
    if isinstance(of, dict | list):
        for key, inner in of.items() if isinstance(of, dict) else enumerate(of):
            yield from _numbers(inner, f"{path}.{key}".removeprefix("."))
    elif isinstance(of, int | float) and not isinstance(of, bool):
        yield path, float(of)
