"""Settling time of a drive and the largest plausible depth of its contacts, from its stiffness and mass.

A transient decays as the loaded member oscillates on the stiffness of all contacts. A soft or heavy drive takes longer
than the reference design, whose period is 0.2 ms; one with large clearance longer still, because the load has to cross
the clearance first.
"""

import math
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.errors import RunError
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.rv_loads import closed_form_stiffness
from cycloid_mj.parts import moving_masses, play_inertia, turning_inertia
from cycloid_mj.reducer import Reducer, RvReducer, once
from cycloid_mj.statics.structure import wind_up


@dataclass(frozen=True)
class SettlingSettings:
    """Settling time of a run, and largest plausible depth of its contacts."""

    min_time: float = 0.005
    """Smallest settling time after a start, the ramp or the rise of the load [s]; contacts need 1 to 3 ms."""
    periods: float = 6.0
    """Number of oscillation periods to wait: each leaves 4 % of the amplitude at half of critical damping, 53 % at a
    tenth."""
    crossings: float = 4.0
    """Number of times to wait that the load needs to carry the output across its backlash: with a restitution of 0.3
    the output has come to rest on the far flank after two of them, and the transient decays in another two."""
    min_depth_limit: float = 50e-6
    """Depth of a contact [m] that no valid run reaches: a hundred times that of the reference design."""
    depth_over_deflection: float = 10.0
    """Depth that no valid run reaches, over the deflection under the working forces; the halves of a preloaded ring
    penetrate by their rotation in addition, preloaded crank bearings by their preload."""
    depth_over_eccentricity: float = 0.25
    """Largest depth of a contact as a share of the eccentricity, beyond which teeth lose their shape."""


SETTLING = SettlingSettings()


def closed_stiffness(reducer: Reducer) -> float:
    """Estimate the torsional stiffness of a drive [N m/rad] with half of its teeth and output pins in (closed) contact.

    Three stiffnesses are in series, each multiplied by the number of discs. That of the teeth is k sum l^2, with their
    lever arms l and the stiffness k of tooth and seat in series; that of the cam, with its own k, is k (c (N-1))^2,
    with the eccentricity c and N ring teeth; and that of n output pins with theirs, on the radius R, is k n R^2/4. The
    compliance of carrier, shaft and housing in torsion is added. The stiffness of an RV reducer is
    `closed_form_stiffness`.
    """
    design = reducer.design
    if isinstance(reducer, RvReducer):
        tooth_stiffness = reducer.contacts.mesh_stiffness
        return closed_form_stiffness(reducer.stage, reducer.bearing_stiffness, tooth_stiffness) / reducer.share**2
    stiffness_by_kind = {kind: design.gear.discs * reducer.contacts[kind].stiffness for kind in design.pair_kinds}
    stiffness_by_kind |= {"output": design.gear.discs * reducer.contacts["output"].stiffness_by_disc[0]}
    gear, output = reducer.tooth_profile, design.output
    moment_arms = profile.moment_arm(gear, profile.pin_angles(gear))
    mesh_compliance = sum(1.0 / stiffness_by_kind[kind] for kind in stiffness_by_kind if kind not in ("cam", "output"))
    mesh_stiffness = np.sum(moment_arms[moment_arms > 0.0] ** 2) / mesh_compliance
    cam_stiffness = stiffness_by_kind["cam"] * (gear.eccentricity * gear.lobes) ** 2
    pin_stiffness = stiffness_by_kind["output"] * output.pins * output.pin_circle_radius**2 / 4.0
    return float(
        1.0 / (reducer.share**2 * (1.0 / mesh_stiffness + 1.0 / cam_stiffness + 1.0 / pin_stiffness) + wind_up(reducer))
    )


def output_period(reducer: Reducer) -> float:
    """Compute the oscillation period [s] of output and discs at a locked crank, at the stiffness under rated load.

    With wide clearances fewer teeth carry load, and the real period is 1.5 times as long.
    """
    return 2.0 * math.pi * math.sqrt(turning_inertia(reducer) / closed_stiffness(reducer.at_rated_load))


def swing_period(reducer: Reducer) -> float:
    """Compute the longest oscillation period of output and load at a locked driven shaft [s].

    The stiffness is that under rated load. The cranks of an RV reducer with a floating sun may oscillate against each
    other on their bearings; their period counts if it is longer.
    """
    period = output_period(reducer)
    if isinstance(reducer, RvReducer) and reducer.planet.sun_support == "floating":
        stiffness = reducer.design.gear.discs * reducer.bearing_stiffness * reducer.design.gear.eccentricity**2
        crank_inertia = float(moving_masses(reducer)[names.CRANK].inertia[2, 2])
        period = max(period, 2.0 * math.pi * math.sqrt(crank_inertia / stiffness))
    return period


def crossing_time(reducer: Reducer) -> float:
    """Compute the time [s] in which the load carries the output across its backlash; 0 without load or backlash.

    The output starts at rest (`rotation_time`). The settling time contains `SETTLING.crossings` times this result. As a
    rotating crank crosses the backlash within one turn at any load, the product is limited to the time of one crank
    turn.
    """
    drive, load = reducer.design.drive, abs(reducer.design.load.torque)
    if not load:
        return 0.0
    try:
        backlash = reducer.play
    except RunError:  # manufacturing errors leave no backlash
        return 0.0
    turn_time = 2.0 * math.pi / abs(drive.speed) if drive.speed else math.inf
    return min(rotation_time(reducer, backlash, load), turn_time / SETTLING.crossings)


def rotation_time(reducer: Reducer, angle: float, torque: float) -> float:
    """Compute the time [s] in which a torque [N m] rotates the output from rest by an angle [rad] of its backlash."""
    return math.sqrt(2.0 * play_inertia(reducer) * angle / torque)


@once
def slowness(reducer: Reducer) -> float:
    """Compute the settling time of a drive, divided by `SETTLING.min_time` [1]; it is at least 1."""
    return max(
        1.0,
        SETTLING.periods * swing_period(reducer) / SETTLING.min_time,
        SETTLING.crossings * crossing_time(reducer) / SETTLING.min_time,
    )


def penetration_limit(reducer: Reducer) -> float:
    """Return the depth [m] of a contact at which a run ends: ``contact.max_penetration``, or by default an estimate.

    The estimate is `SETTLING.depth_over_deflection` times the deflection under working forces, but at least
    `SETTLING.min_depth_limit`, plus the depth by preload. It is limited to `SETTLING.depth_over_eccentricity` times the
    eccentricity.
    """
    design = reducer.design
    if design.contact.max_penetration:
        return design.contact.max_penetration
    contacts = [reducer.contacts[kind] for kind in reducer.mechanism.kinds]
    deflection = max(contact.force / contact.stiffness_by_disc[0] for contact in contacts)
    preload_depth = 0.5 * design.ring.preload * design.ring.pin_circle_radius
    if isinstance(reducer, RvReducer):
        preload_depth += max(-reducer.bearing_clearance, 0.0)
    return min(
        max(SETTLING.min_depth_limit, SETTLING.depth_over_deflection * deflection) + preload_depth,
        SETTLING.depth_over_eccentricity * design.gear.eccentricity,
    )
