"""How long a drive takes to settle, and how deep its contacts may go: by its own stiffness and mass, not the paper's.

A jolt rings out as what the load is on swings on the stiffness of all contacts; a soft or heavy drive takes longer than
the paper's, whose period is 0.2 ms. One of wide play takes longer still: the load has to cross it first.
"""

import math

import numpy as np

from cycloid_mj.base.errors import RunError
from cycloid_mj.geometry import profile
from cycloid_mj.parts import turning_inertia
from cycloid_mj.reducer import Reducer, once
from cycloid_mj.statics.structure import wind_up

SETTLING = 0.005
"""Least time that a start, the end of the ramp or the load's rise takes to ring out [s]; contacts need 1 to 3 ms."""

SWINGS = 6.0
"""Periods of the swing that are waited for: each leaves 4 % of it at half of critical damping, 53 % at a tenth."""

CROSSINGS = 4.0
"""Times that the load takes to carry the output across its play that are waited for: with a restitution of 0.3 it has
come to rest on the far flank after two of them, and the jolt rings out in as many."""

DEEPEST = 50e-6
"""Depth of a contact [m] that no drive of this size reaches in a run that goes right: a hundred times the paper's."""

DEEPER = 10.0
"""Depth, in those that working forces press contacts in, that a run which goes right does not reach either; halves of
a ring press as deep as they are turned."""

OF_ECCENTRICITY = 0.25
"""Share of the eccentricity that a contact may never be deep: the teeth would no longer be the teeth."""


def closed_stiffness(reducer: Reducer) -> float:
    """Compute the torsional stiffness [N m/rad] with half of the teeth and half of the output pins closed: an estimate.

    In series: k sum l^2 of the teeth (with the sockets or sleeves behind them), k (c (N-1))^2 of the cam, and
    k n R^2/4 of n output pins on the radius R, of each disc as much; then what carrier, shaft and housing twist by.
    """
    design = reducer.design
    k = {kind: design.gear.discs * reducer.contacts[kind].stiffness for kind in design.pair_kinds}
    k |= {"output": design.gear.discs * reducer.contacts["output"].series[0]}
    gear, output = reducer.tooth_profile, design.output
    arms = profile.moment_arm(gear, profile.pin_angles(gear))
    per_arm = sum(1.0 / k[kind] for kind in k if kind not in ("cam", "output"))
    mesh = np.sum(arms[arms > 0.0] ** 2) / per_arm
    cam = k["cam"] * (gear.eccentricity * gear.lobes) ** 2
    pins = k["output"] * output.pins * output.pin_circle_radius**2 / 4.0
    return float(1.0 / (reducer.share**2 * (1.0 / mesh + 1.0 / cam + 1.0 / pins) + wind_up(reducer)))


def swing_period(reducer: Reducer) -> float:
    """Find the period [s] with which what turns at a locked crank swings on the contacts, as stiff as under the load.

    With wide clearances, of which fewer teeth carry, it is longer by half.
    """
    return 2.0 * math.pi * math.sqrt(turning_inertia(reducer) / closed_stiffness(reducer.at_rated_load))


def crossing_time(reducer: Reducer) -> float:
    """Compute the time [s] in which the load carries the output from one end of its play to the other.

    A turning crank carries it there within a turn, however light the load; 0 without a load or without play.
    """
    drive, load = reducer.design.drive, abs(reducer.design.load.torque)
    if not load:
        return 0.0
    try:
        play = reducer.play
    except RunError:  # errors leave none
        return 0.0
    turn = 2.0 * math.pi / abs(drive.speed) if drive.speed else math.inf
    return min(way_time(reducer, play, load), turn / CROSSINGS)


def way_time(reducer: Reducer, way: float, torque: float) -> float:
    """Compute the time [s] in which a torque [N m] carries output and gear over a way [rad] from rest."""
    return math.sqrt(2.0 * turning_inertia(reducer) * way / torque)


@once
def slowness(reducer: Reducer) -> float:
    """Tell how many times as long as the paper's a drive takes to settle [1]: 1 where `SETTLING` is enough."""
    return max(1.0, SWINGS * swing_period(reducer) / SETTLING, CROSSINGS * crossing_time(reducer) / SETTLING)


def deepest(reducer: Reducer) -> float:
    """Find the depth [m] beyond which a contact ends a run: ``contact.max_penetration``, or what the design allows."""
    design = reducer.design
    if design.contact.max_penetration:
        return design.contact.max_penetration
    contacts = [reducer.contacts[kind] for kind in design.pair_kinds]
    pressed = max(contact.force / contact.series[0] for contact in contacts)
    turned = 0.5 * design.ring.preload * design.ring.pin_circle_radius
    return min(max(DEEPEST, DEEPER * pressed) + turned, OF_ECCENTRICITY * design.gear.eccentricity)
