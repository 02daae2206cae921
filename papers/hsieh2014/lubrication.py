"""The mean friction coefficient that the paper's measured output torques leave for teeth and output pins."""

import numpy as np

from cycloid_mj.base.result import Table
from cycloid_mj.design import PRESETS
from cycloid_mj.geometry import ideal_loads, profile
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.sheet import sampled_efficiency
from hsieh2014.stated import IDEAL, TORQUES

TEMPERATURES = (20.0, 60.0)
"""Temperatures of all parts in the table [°C]."""


def largest_mean_friction(reducer: Reducer, rate: float) -> float:
    """Compute the largest mean friction coefficient of teeth and output pins [1] from the output rate.

    `rate` is the rated output torque over that without losses [1]. All lost power is that of teeth and output pins,
    which slide under ideal load sharing: nothing is left for cam, seals and grease.
    """
    design, gear = reducer.design, reducer.tooth_profile
    speed, torque, output = design.drive.speed, design.rated_torque, design.output
    crank = np.linspace(0.0, 2.0 * np.pi / gear.ring_teeth, 64, endpoint=False)
    reach = profile.pitch_distance(gear, profile.pin_angles(gear) + crank[:, np.newaxis]) - gear.pin_radius
    teeth = ideal_loads.ideal_load_sharing(gear, torque, crank).forces * reach * speed / gear.lobes
    turn = np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)
    pins = ideal_loads.ideal_output_forces(gear, output.pins, output.pin_circle_radius, torque, turn)
    circling = gear.eccentricity * speed * gear.ring_teeth / gear.lobes
    sliding = float(np.mean(np.sum(teeth, axis=1)) + circling * np.mean(np.sum(pins, axis=1)))
    return (1.0 - rate) * design.drive.torque * speed / sliding


def lubrication_table() -> Table:
    """Tabulate the measured output rates next to the efficiency by the friction law ``film``, 5 to 95 % interval.

    The ``pin`` design has a second row, with fixed pins, whose rate was not measured. It shows how much of the
    efficiency is due to pins that turn in their sockets.
    """
    rows = []
    for name, kind, fixed in (
        ("pin", "free pins, roll in their sockets", False),
        ("pin, fixed pins", "pins slide", True),
        ("nonpin", "lobes, slide", False),
    ):
        design = PRESETS[name.split(",")[0]]
        rate, bound = "not measured", "-"
        if fixed:
            design = design.but(ring={"pins": "fixed"})
        else:
            measured_rate = TORQUES[name]["measured"] / IDEAL
            rate, bound = f"{100.0 * measured_rate:.1f}", f"{largest_mean_friction(Reducer(design), measured_rate):.4f}"
        for temperature in TEMPERATURES:
            parts = dict.fromkeys(("disc", "ring", "crank", "output"), temperature)
            film = Reducer(design.but(friction={"law": "film"}, thermal=parts, load={"torque": IDEAL}))
            spread = sampled_efficiency(film, IDEAL)
            rows.append((name, kind, rate, bound, f"{temperature:g}", f"{spread.low:.1f} to {spread.high:.1f}"))
    head = (
        *("", "ring", "measured rate [%]", "mean friction of teeth and output pins, at most"),
        *("temperature [°C]", "film law, lithium grease 100: 5 to 95 % [%]"),
    )
    return Table("lubrication that the measured output rates require", head, tuple(rows))
