"""Signals of a run in the units of their axes, defined once for matplotlib and for the page."""

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
        Its name, with its unit.
    simulated, theory
        Give it of a run [unit], shape (n,) or (n, 2); `theory` is None where nothing is held against it.
    theory_name
        What the theory is.
    is_error
        Whether it is a difference from the closed form.
    """

    label: str
    simulated: Callable[[Series], Array]
    theory: Callable[[Series], Array] | None = None
    theory_name: str = "closed form"
    is_error: bool = False

    @property
    def unit(self) -> str:
        """What stands in the label's brackets; "" of a plain number."""
        return self.label.partition("[")[2].removesuffix("]")


def _beside_theory(label: str, part: Callable[[Series], Compared], factor: float = 1.0) -> Signal:
    return Signal(label, lambda m: factor * part(m).simulated, lambda m: factor * part(m).theory)


def _pin(motion: Series) -> PinPath:
    if motion.pin_1 is None:
        raise LogError(f"{motion.design.name} has no moving ring pins: there is no path of pin 1")
    return motion.pin_1


def _error(label: str, part: Callable[[Series], Compared], factor: float) -> Signal:
    return Signal(label, lambda m: factor * part(m).error, is_error=True)


SIGNALS = {
    "output_te": Signal("output [arcsec]", lambda m: ARCSECONDS * m.output_angle.error),
    "gear_te": Signal("gear [arcsec]", lambda m: ARCSECONDS * m.gear_angle.error),
    "output_speed": _beside_theory("output speed [rad/s]", lambda m: m.output_speed),
    "output_speed_error": _error("error [mrad/s]", lambda m: m.output_speed, 1e3),
    "gear_speed": _beside_theory("gear speed [rad/s]", lambda m: m.gear_speed),
    "gear_speed_error": _error("error [mrad/s]", lambda m: m.gear_speed, 1e3),
    "crank_speed": _beside_theory("crank speed [rad/s]", lambda m: m.crank_speed),
    "crank_speed_error": _error("error [mrad/s]", lambda m: m.crank_speed, 1e3),
    "q_path": _beside_theory("q [mm]", lambda m: m.q_position, 1e3),
    "q_error": Signal(f"distance from Eq. 16 [{MICROMETRE}]", lambda m: 1e6 * m.q_position.error_size, is_error=True),
    "q_speed": _beside_theory("speed of q [mm/s]", lambda m: m.q_velocity.size, 1e3),
    "q_speed_error": _error("error [mm/s]", lambda m: m.q_velocity.size, 1e3),
    "pin_path": Signal(f"centre of pin 1 [{MICROMETRE}]", lambda m: 1e6 * _pin(m).position),
    "pin_radial": Signal(f"distance from centre [{MICROMETRE}]", lambda m: 1e6 * _pin(m).radial),
    "pin_spin": Signal("spin [rad/s]", lambda m: _pin(m).spin),
    "contacts": Signal("contacts", lambda m: m.run["contacts"]),
    "peak_force": Signal("largest force [N]", lambda m: m.run["peak_force"]),
    "penetration": Signal(f"penetration [{MICROMETRE}]", lambda m: 1e6 * m.run["penetration"]),
    "crank_torque": Signal(
        "crank torque [N m]",
        lambda m: m.run["crank_torque"],
        lambda m: -m.run["load_torque"] / m.design.ratio,
        "without losses",
    ),
    "load_torque": Signal("load torque [N m]", lambda m: m.run["load_torque"]),
}
"""Key -> signal. Those of pin 1 exist where a ring has moving pins."""


@dataclass(frozen=True)
class SignalFigure:
    """A figure of a run over time: its `panels` are keys of `SIGNALS`, above each other; `path` is one beside them."""

    name: str
    title: str
    caption: str
    panels: tuple[str, ...]
    path: str | None = None

    def shows(self, motion: Series) -> bool:
        """Whether a run has something to show in it: pin 1 moves in some rings only."""
        return motion.pin_1 is not None or "pin_radial" not in self.panels


FIGURES = (
    SignalFigure(
        "transmission_error",
        "Transmission error",
        "Angle of output and gear less the ideal one at the measured crank angle: its swing is "
        "what the drive errs by, its mean is play that is taken up and, under load, wind-up.",
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
        "Speed of the cycloid gear",
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
        "Fig. 8 of the paper; closed form: Eq. 18 at the measured crank.",
        ("q_speed", "q_speed_error"),
    ),
    SignalFigure(
        "pin_1",
        "Pin 1 in its socket",
        "Fig. 9 of the paper: one crank turn of its centre; the circle is the clearance.",
        ("pin_radial", "pin_spin"),
        path="pin_path",
    ),
    SignalFigure(
        "contact",
        "Contacts",
        "Contacts that carry a force, the largest force of one, and the deepest approach.",
        ("contacts", "peak_force", "penetration"),
    ),
    SignalFigure(
        "torque",
        "Torques",
        "The crank torque that the load would take without losses is load/ratio.",
        ("crank_torque", "load_torque"),
    ),
    SignalFigure(
        "crank",
        "Speed of the crank",
        "Fig. 5 of the paper; closed form: the law of the drive.",
        ("crank_speed", "crank_speed_error"),
    ),
)
