"""Permanent set of plastic surfaces under Hertz pressure: short loads add up while the strength decreases by creep.

While a drive turns, a place of a surface is loaded only as long as the contact strip needs to pass it, once per turn of
the crank against that part. Recovery between the loads is neglected, so the life is a lower bound.
"""

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array
from cycloid_mj.design.materials import SHAKEDOWN_PRESSURE
from cycloid_mj.design.model import PARTNERS
from cycloid_mj.geometry.surface_speeds import tooth_speeds
from cycloid_mj.life.item import RatedItem
from cycloid_mj.life.loading import Loading, relative_speed, sector_means, speed_past_ring, tooth_phases
from cycloid_mj.statics.peaks import line_loads

SET_SHARE, SET_POWER = 2500.0 / 2850.0, math.log10(2500.0 / 1300.0) / 3.0
"""Strength of a plastic after 1 h of load over its short-term strength, and the power by which it decreases.

It follows the creep modulus: Hostaform C 9021 (POM) has 2850 MPa in a short test, 2500 after 1 h and 1300 after 1000 h
(ISO 527, ISO 899-1); other plastics are assumed to creep alike. After 6000 h 39 % remain.
"""


def rate_permanent_set(loadings: Sequence[Loading], kind: str, name: str) -> RatedItem:
    """Rate a plastic surface by the hours until it has a permanent set, by Miner's sum over the duty cycle.

    `loadings` are the solved forces at the points of the duty, `kind` is the kind of mating pair, and `name` its name
    in the result.
    """
    strength = loadings[0].reducer.contacts[kind].strength
    limit = SHAKEDOWN_PRESSURE * strength
    pressure = max(loading.pressures[kind] for loading in loadings)
    damage = sum(loading.point.share * damage_rate(loading, kind, limit) for loading in loadings)
    standstill_life = 1.0 / float(creep_damage(pressure, limit))
    return RatedItem(
        f"{kind}_set",
        f"{name}, permanent set of the plastic",
        1e-6 * pressure,
        1e-6 * limit,
        "MPa",
        None,
        1.0 / damage if damage else math.inf,
        "p0 = 4 k = 2.31 Y; Y decreases with the time under load as the creep modulus of POM (ISO 899-1)",
        f"Y = {1e-6 * strength:.4g} MPa under a short load; each point is loaded while the contact passes it; at "
        f"standstill under the largest load the life is {standstill_life:.3g} h",
    )


def creep_damage(pressure: npt.ArrayLike, limit: float) -> Array:
    """Compute the damage per hour under a constant pressure [1/h], in the shape of `pressure` [Pa]; 1 is a set.

    `limit` [Pa] is the pressure that leaves a permanent set within a short test.
    """
    return np.asarray((np.asarray(pressure) / (SET_SHARE * limit)) ** (1.0 / SET_POWER))


def damage_rate(loading: Loading, kind: str, limit: float) -> float:
    """Compute the damage per hour of rotation [1/h] at the most loaded point of a plastic surface, by Miner's rule.

    `loading` has the solved forces. At a damage of 1 the surface has a permanent set. A lobe of the disc meets all ring
    pins in turn, so its damage is the mean over them; for pins and holes it is the largest of their damages. `kind` is
    the kind of mating pair, and `limit` the pressure that leaves a permanent set within a short test [Pa].
    """
    design = loading.reducer.design
    force, curvature = line_loads(loading.reducer, loading.springs, loading.contacts, kind)
    contact = loading.reducer.contacts[kind]
    standstill_rate = creep_damage(contact.pressure(force, curvature), limit)
    rates = []
    for part, material in zip(PARTNERS[kind], design.partners(kind), strict=True):
        if material.is_plastic:
            time_shares = load_shares(loading, kind, part, contact.half_width(force, curvature))
            damage = time_shares * standstill_rate
            is_disc_flank = part == "gear" and kind == design.tooth_pair
            rates.append(_mean_over_passes(loading, damage) if is_disc_flank else float(damage.max()))
    return max(rates)


def load_shares(loading: Loading, kind: str, part: str, half_width: Array) -> Array:
    """Compute the share of the time during which a point of a part's surface is inside the contact strip [1].

    Parameters
    ----------
    loading
        Solved forces at a point of the duty.
    kind, part
        Kind of mating pair, and one of its two parts (`PARTNERS`). Contacts in seats do not move along the surface:
        their share is 1.
    half_width
        Half widths of the strips of n contacts at m crank angles [m], shape (m, n).

    Returns
    -------
    Array
        Shares [1], shape (m, n). A strip passes each point once per turn of the crank relative to the part.
    """
    reducer, design = loading.reducer, loading.reducer.design
    if kind == "output":
        radius = design.output.hole_radius if part == "gear" else design.output.pin_radius
        time_shares = half_width / (math.pi * radius)
    elif kind == design.tooth_pair:
        phases = tooth_phases(reducer, loading.springs.crank)
        speeds = tooth_speeds(reducer.tooth_profile, phases, reducer.speed_against_ring)
        crank = design.drive.speed
        turning_speed = relative_speed(reducer, crank) if part == "gear" else speed_past_ring(reducer, crank)
        passing_speed = np.abs(speeds.moving if part == "gear" else speeds.fixed)
        time_shares = half_width * turning_speed / (math.pi * np.maximum(passing_speed, np.finfo(float).tiny))
    else:
        time_shares = np.ones_like(half_width)
    return np.asarray(np.minimum(time_shares, 1.0))


def _mean_over_passes(loading: Loading, damage: Array) -> float:
    """Return the damage per hour at the most damaged point of the lobes [1/h], the mean over all pins that pass it.

    Contacts of a disc with the ring (with each half of a split ring) are sorted into sectors of their phases; in each
    of them, `damage` of n contacts at m crank angles, (m, n), is averaged over the pins and turns of the crank.
    `loading` has the static forces at a point of the duty cycle.
    """
    tooth_count, phases = loading.reducer.design.ring.teeth, tooth_phases(loading.reducer, loading.springs.crank)
    contacts_by_ring = (
        slice(first_contact, first_contact + tooth_count) for first_contact in range(0, damage.shape[1], tooth_count)
    )
    return max(
        float(sector_means(damage[:, ring_contacts], phases[:, ring_contacts])[0].max())
        for ring_contacts in contacts_by_ring
    )
