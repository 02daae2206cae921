"""Numbers that the paper states (Hsieh 2014, Figs 12-19), and the identification of its designs."""

import math
from typing import TYPE_CHECKING

from cycloid_mj.design import PRESETS, Design
from cycloid_mj.reducer import Reducer, reducer_of

if TYPE_CHECKING:
    from cycloid_mj.measure.published import Published
    from cycloid_mj.stress.findings import Reference

IDEAL = 36.68
"""Output torque without losses [N m]: 1.048 x 35."""

TORQUES = {"pin": {"simulated": 34.7, "measured": 34.335}, "nonpin": {"simulated": 35.8, "measured": 35.08}}
"""Output torque of each kind of ring [N m] at 1.048 N m on the crank (section 3.4 and Fig. 19)."""

GEAR_SPEED = 4.907
"""Speed of the gear at 1640 rpm of the crank [rad/s] (Eq. 12, Fig. 6)."""

FLUCTUATIONS = {"disc speed": "Fig. 6", "path of q": "Fig. 7", "velocity of q": "Fig. 8"}
"""Figure in which the paper states that the pin design fluctuates more, by quantity."""

FIGURES = {"shaft": "Fig. 12", "gear": "Fig. 13", "ring": "Fig. 14", "output": "Fig. 15", "pin_1": "Fig. 16"}

HEIGHTS = {
    ("shaft", "pin"): 160.0,
    ("shaft", "nonpin"): 60.0,
    ("ring", "pin"): 65.0,
    ("ring", "nonpin"): 50.0,
    ("gear", "pin"): 20.0,
    ("gear", "nonpin"): 10.0,
}
"""Approximate maximum of a part's curve in a design [MPa]."""

ORDER = ("shaft", "ring", "gear")
"""Parts by decreasing stress, in both designs."""

SHAFT_PEAKS = (75.0, 255.0)
"""Crank angles of the shaft's two peaks in the pin design [deg]; the maximum is at 74."""

PIN_1_LOADED = (350.0, 10.0)
"""Crank angles between which pin 1 is loaded, through 0 [deg]."""

SHOWN = (0.0, 120.0, 240.0, 360.0)
"""Crank angles at which Fig. 9(a) shows the pins [deg]."""

LEAST, MOST = 0.5, 1.1
"""A height agrees between these multiples of the paper's."""

NEAR = 10.0
"""Tolerance of crank angles [deg]: a mesh period."""


OURS = ("pin", "nonpin")
"""Presets of the paper's two designs, named by their kind of ring."""


def is_ours(design: Design) -> bool:
    """Return whether a design is one of the paper's two, apart from load, speed, environment and settings."""
    from cycloid_mj.stress.turn import list_differences

    return not all(list_differences(reducer_of(design), Reducer(PRESETS[kind])) for kind in OURS)


def stress_references(design: Design) -> "dict[str, Reference]":
    """Return number of the paper's figure and its upper bound of the stress by part; empty for other designs."""
    from cycloid_mj.base.units import MEGAPASCAL
    from cycloid_mj.stress.findings import Reference

    if not is_ours(design):
        return {}
    heights = {part: HEIGHTS.get((part, design.ring.kind)) for part in FIGURES}
    return {
        part: Reference(f"Hsieh 2014, {FIGURES[part]}", None if height is None else height * MEGAPASCAL, 0.0)
        for part, height in heights.items()
    }


def torques(design: Design) -> "list[Published]":
    """Return the torques [N m] of the paper for this kind of ring; empty for other teeth or another input torque."""
    from cycloid_mj.measure.published import Published

    preset = PRESETS[design.ring.kind]
    cut = [(torque.ring.teeth, torque.gear.eccentricity, torque.ring.pin_circle_radius) for torque in (design, preset)]
    if cut[0] != cut[1] or not math.isclose(design.rated_torque, IDEAL, rel_tol=1e-3):
        return []
    kinds = TORQUES[design.ring.kind]
    return [Published(kind, "Hsieh 2014, Fig. 19", torque, IDEAL) for kind, torque in kinds.items()]
