"""What the page draws over time: the curves of a run in the units of its figures, and which figure shows which."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cycloid_mj.analysis import Series
from cycloid_mj.types import Array

ARCSEC = 3600 * 180 / np.pi


@dataclass(frozen=True)
class Panel:
    """Axes of a figure: its label with the unit, the curve it shows, and perhaps a curve of theory and its name.

    `is_error` marks a difference from the closed form.
    """

    label: str
    curve: str
    theory: str | None = None
    is_error: bool = False
    theory_name: str = "closed form"


@dataclass(frozen=True)
class Figure:
    """A figure of the page: panels above each other, and perhaps a path beside them."""

    name: str
    title: str
    caption: str
    panels: tuple[Panel, ...]
    path: str | None = None


FIGURES = (
    Figure(
        "transmission_error",
        "Transmission error",
        "Angle of output and gear less \N{MINUS SIGN}θ/(N\N{MINUS SIGN}1) at the measured crank angle θ: its swing is "
        "what the drive errs by, its mean is play that is taken up and, under load, wind-up.",
        (Panel("output [arcsec]", "output_te"), Panel("gear [arcsec]", "gear_te")),
    ),
    Figure(
        "output_speed",
        "Speed of the output",
        "Closed form: Eq. 12 at the measured crank speed.",
        (
            Panel("output speed [rad/s]", "output_speed", "output_speed_theory"),
            Panel("error [mrad/s]", "output_speed_error", is_error=True),
        ),
    ),
    Figure(
        "gear_speed",
        "Speed of the cycloid gear",
        "Fig. 6 of the paper; closed form: Eq. 12 at the measured crank speed.",
        (
            Panel("gear speed [rad/s]", "gear_speed", "gear_speed_theory"),
            Panel("error [mrad/s]", "gear_speed_error", is_error=True),
        ),
    ),
    Figure(
        "q_path",
        "Path of the point q",
        "Fig. 7 of the paper: one crank turn, and the distance from Eq. 16 at the measured crank angle.",
        (Panel("distance from Eq. 16 [µm]", "q_error", is_error=True),),
        path="q",
    ),
    Figure(
        "q_speed",
        "Speed of the point q",
        "Fig. 8 of the paper; closed form: Eq. 18 at the measured crank.",
        (
            Panel("speed of q [mm/s]", "q_speed", "q_speed_theory"),
            Panel("error [mm/s]", "q_speed_error", is_error=True),
        ),
    ),
    Figure(
        "pin_1",
        "Pin 1 in its socket",
        "Fig. 9 of the paper: one crank turn of its centre; the circle is the clearance.",
        (Panel("distance from centre [µm]", "pin_radial"), Panel("spin [rad/s]", "pin_spin")),
        path="pin_1",
    ),
    Figure(
        "contact",
        "Contacts",
        "Contacts that carry a force, the largest force of one, and the deepest approach.",
        (
            Panel("contacts", "contacts"),
            Panel("largest force [N]", "peak_force"),
            Panel("penetration [µm]", "penetration"),
        ),
    ),
    Figure(
        "torque",
        "Torques",
        "The crank torque that the load would take without losses is load/(N\N{MINUS SIGN}1).",
        (
            Panel("crank torque [N m]", "crank_torque", "crank_torque_ideal", theory_name="without losses"),
            Panel("load torque [N m]", "load_torque"),
        ),
    ),
    Figure(
        "crank",
        "Speed of the crank",
        "Fig. 5 of the paper; closed form: the law of the drive.",
        (
            Panel("crank speed [rad/s]", "crank_speed", "crank_speed_theory"),
            Panel("error [mrad/s]", "crank_speed_error", is_error=True),
        ),
    ),
)


def curves(motion: Series) -> dict[str, Array]:
    """Give name -> values over the whole run, shape (n,), in the units of the panels."""
    run, speed = motion.run, motion.q_velocity.size
    found = {
        "crank_speed": motion.crank_speed.simulated,
        "crank_speed_theory": motion.crank_speed.theory,
        "crank_speed_error": 1e3 * motion.crank_speed.error,
        "output_speed": motion.output_speed.simulated,
        "output_speed_theory": motion.output_speed.theory,
        "output_speed_error": 1e3 * motion.output_speed.error,
        "gear_speed": motion.gear_speed.simulated,
        "gear_speed_theory": motion.gear_speed.theory,
        "gear_speed_error": 1e3 * motion.gear_speed.error,
        "q_error": 1e6 * motion.q_position.error_size,
        "q_speed": 1e3 * speed.simulated,
        "q_speed_theory": 1e3 * speed.theory,
        "q_speed_error": 1e3 * speed.error,
        "output_te": ARCSEC * motion.output_angle.error,
        "gear_te": ARCSEC * motion.gear_angle.error,
        "crank_torque": run["crank_torque"],
        "crank_torque_ideal": run["load_torque"] / motion.design.lobes,
        "load_torque": run["load_torque"],
        "contacts": run["contacts"],
        "peak_force": run["peak_force"],
        "penetration": 1e6 * run["penetration"],
    }
    if motion.pin_1:
        found |= {"pin_radial": 1e6 * motion.pin_1.radial, "pin_spin": motion.pin_1.spin}
    return found


def paths(motion: Series) -> dict[str, Mapping[str, object]]:
    """Give name -> a path over one crank turn: its curves, shape (m, 2), and the unit of both axes."""
    turn = motion.one_turn
    found: dict[str, Mapping[str, object]] = {
        "q": {
            "unit": "mm",
            "simulated": 1e3 * motion.q_position.simulated[turn],
            "theory": 1e3 * motion.q_position.theory[turn],
        }
    }
    if motion.pin_1:
        position, clearance = motion.pin_1.position[turn], motion.pin_1.clearance
        found["pin_1"] = {"unit": "µm", "simulated": 1e6 * position, "circle": 1e6 * clearance}
    return found
