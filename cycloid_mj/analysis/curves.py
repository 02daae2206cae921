"""Signals of a run in the units of their axes, shared by plots and the page."""

from collections.abc import Callable
from dataclasses import dataclass

from cycloid_mj.analysis.series import Compared, PinPath, Series
from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import LogError
from cycloid_mj.base.units import ARCSECONDS

MICROMETRE = "\N{MICRO SIGN}m"


@dataclass(frozen=True)
class Signal:
    """A quantity over the samples of a run.

    Attributes
    ----------
    label
        Name, with the unit in brackets.
    simulated, theory
        Functions from a series to values [unit], shape (n,) or (n, 2); `theory` is None without a reference.
    theory_name
        Name of the reference.
    is_error
        Whether the signal is a difference from the closed form.
    """

    label: str
    simulated: Callable[[Series], Array]
    theory: Callable[[Series], Array] | None = None
    theory_name: str = "closed form"
    is_error: bool = False

    @property
    def unit(self) -> str:
        """Unit in the brackets of the label; "" if there is none."""
        return self.label.partition("[")[2].removesuffix("]")


def _with_theory(label: str, part: Callable[[Series], Compared], factor: float = 1.0) -> Signal:
    return Signal(label, lambda m: factor * part(m).simulated, lambda m: factor * part(m).theory)


def _pin(motion: Series) -> PinPath:
    if motion.pin_1 is None:
        raise LogError(
            f"{motion.design.name}: ring pin 1 has no path, because this design has no movable ring pins. Use a "
            'design with ring.kind = "pin" and ring.pins = "free" or "sleeved"'
        )
    return motion.pin_1


def _error(label: str, part: Callable[[Series], Compared], factor: float) -> Signal:
    return Signal(label, lambda m: factor * part(m).error, is_error=True)


SIGNALS = {
    "output_te": Signal("output [arcsec]", lambda m: ARCSECONDS * m.output_angle.error),
    "gear_te": Signal("gear [arcsec]", lambda m: ARCSECONDS * m.gear_angle.error),
    "output_speed": _with_theory("output speed [rad/s]", lambda m: m.output_speed),
    "output_speed_error": _error("error [mrad/s]", lambda m: m.output_speed, 1e3),
    "gear_speed": _with_theory("gear speed [rad/s]", lambda m: m.gear_speed),
    "gear_speed_error": _error("error [mrad/s]", lambda m: m.gear_speed, 1e3),
    "crank_speed": _with_theory("input speed [rad/s]", lambda m: m.crank_speed),
    "crank_speed_error": _error("error [mrad/s]", lambda m: m.crank_speed, 1e3),
    "q_path": _with_theory("q [mm]", lambda m: m.q_position, 1e3),
    "q_error": Signal(f"distance from Eq. 16 [{MICROMETRE}]", lambda m: 1e6 * m.q_position.error_size, is_error=True),
    "q_speed": _with_theory("speed of q [mm/s]", lambda m: m.q_velocity.size, 1e3),
    "q_speed_error": _error("error [mm/s]", lambda m: m.q_velocity.size, 1e3),
    "pin_path": Signal(f"centre of pin 1 [{MICROMETRE}]", lambda m: 1e6 * _pin(m).position),
    "pin_radial": Signal(f"distance from centre [{MICROMETRE}]", lambda m: 1e6 * _pin(m).radial),
    "pin_spin": Signal("spin [rad/s]", lambda m: _pin(m).spin),
    "contacts": Signal("contacts", lambda m: m.run["contacts"]),
    "peak_force": Signal("largest force [N]", lambda m: m.run["peak_force"]),
    "penetration": Signal(f"penetration [{MICROMETRE}]", lambda m: 1e6 * m.run["penetration"]),
    "crank_torque": Signal(
        "input torque [N m]",
        lambda m: m.run[f"{m.reducer.INPUT}_torque"],
        lambda m: -m.run["load_torque"] / m.design.ratio,
        "without losses",
    ),
    "load_torque": Signal("load torque [N m]", lambda m: m.run["load_torque"]),
}
"""Signals by key. Those of pin 1 exist only if the ring has moving pins."""


@dataclass(frozen=True)
class SignalFigure:
    """A figure of a run over time; `panels` are keys of `SIGNALS`, `path` that of a plot next to them."""

    name: str
    title: str
    caption: str
    panels: tuple[str, ...]
    path: str | None = None

    def shows(self, motion: Series) -> bool:
        """Return whether a run has the signals of the figure: pin 1 moves in some rings only."""
        return motion.pin_1 is not None or "pin_radial" not in self.panels


FIGURES = (
    SignalFigure(
        "transmission_error",
        "Transmission error",
        "Angles of output and disc minus their ideal values at the measured crank angle. The peak-to-peak value is the "
        "transmission error; the mean is backlash taken up and, under load, wind-up.",
        ("output_te", "gear_te"),
    ),
    SignalFigure(
        "output_speed",
        "Speed of the output",
        "Closed form: Eq. 12 at the measured crank speed.",
        ("output_speed", "output_speed_error"),
    ),
    SignalFigure(
        "gear_speed",
        "Speed of the cycloid disc",
        "Fig. 6 of the paper; closed form: Eq. 12 at the measured crank speed.",
        ("gear_speed", "gear_speed_error"),
    ),
    SignalFigure(
        "q_path",
        "Path of the point q",
        "Fig. 7 of the paper: one crank turn, and the distance from Eq. 16 at the measured crank angle.",
        ("q_error",),
        path="q_path",
    ),
    SignalFigure(
        "q_speed",
        "Speed of the point q",
        "Fig. 8 of the paper; closed form: Eq. 18 at the measured crank angle and speed.",
        ("q_speed", "q_speed_error"),
    ),
    SignalFigure(
        "pin_1",
        "Pin 1 in its socket",
        "Fig. 9 of the paper: path of the pin's centre over a crank turn; the circle is the clearance.",
        ("pin_radial", "pin_spin"),
        path="pin_path",
    ),
    SignalFigure(
        "contact",
        "Contacts",
        "Number of loaded contacts, largest contact force, and largest contact deflection.",
        ("contacts", "peak_force", "penetration"),
    ),
    SignalFigure(
        "torque",
        "Torques",
        "Without losses, the input torque, on the crank or the sun, is the load torque divided by the ratio.",
        ("crank_torque", "load_torque"),
    ),
    SignalFigure(
        "crank",
        "Speed of the input",
        "Fig. 5 of the paper; closed form: the prescribed ramp and hold.",
        ("crank_speed", "crank_speed_error"),
    ),
)
