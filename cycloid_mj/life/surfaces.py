"""Surfaces under Hertz's pressure: of metals first yield, shakedown and pitting, of plastics a lasting set."""

import math
from collections.abc import Iterator, Sequence

from cycloid_mj.design import Material
from cycloid_mj.design.materials import SHAKEDOWN_PRESSURE, YIELD_PRESSURE
from cycloid_mj.life.duration import written
from cycloid_mj.life.item import RatedItem
from cycloid_mj.life.loading import Loading, relative_speed, speed_past_ring
from cycloid_mj.reducer import Reducer

SOFTEST_STEEL = 1e11
"""Young's modulus [Pa] of what counts as steel: curves of pitting and endurance limits are steel's alone."""

PITTING = 2.22e6, 200e6
"""Allowable pressure at 10^7 loads, S_c = 2.22 HB + 200 MPa: through-hardened steel, grade 1 (AGMA 2001-D04, 10.3)."""

HARDEST = 1240e6
"""The same of carburised steel, grade 1 [Pa], at 55 to 64 HRC: harder steel is not credited more."""

PITTING_LIFE = 2.466, 0.056
"""Stress-cycle factor Z_N = 2.466 n^-0.056 (AGMA 2001-D04, Fig. 17), for every number of loads.

Beyond 10^7 loads this is the lower branch of the figure: for drives that must run smoothly, with little pitting.
"""

UPPER_BRANCH = 1.4488, 0.023
"""Z_N = 1.4488 n^-0.023, the upper branch of that figure beyond 10^7 loads: for general use, as a spread."""

UPPER_FROM = 1e7
"""Loads from which on the branches part."""

BRINELL = 3.45
"""Tensile strength of steel per Brinell hardness [MPa] (ISO 18265)."""

SET_SHARE, SET_POWER = 2500.0 / 2850.0, math.log10(2500.0 / 1300.0) / 3.0
"""Share of a plastic's short strength that is left after 1 h of load, and the power of the hours by which it falls.

As its modulus does in creep: Hostaform C 9021 (POM) has 2850 MPa in a short test, 2500 after 1 h and 1300 after 1000 h
(ISO 527, ISO 899-1); other plastics are taken to creep alike. After 6000 h 39 % are left.
"""

FEWEST = 1e4
"""Loads from which on that curve is drawn."""

NAMES = {
    "pin_gear": "teeth on pins",
    "tooth": "gear on internal gear",
    "pin_socket": "pins in sockets",
    "pin_sleeve": "sleeves on their pins",
    "output": "output pins in holes",
}


def surfaces(reducer: Reducer, loadings: Sequence[Loading]) -> Iterator[RatedItem]:
    """Rate the pressures of teeth, holes and seats: yield and shakedown by the worst, pitting by Miner's sum.

    Where the weaker surface is a plastic, it is the hours until its pressure leaves a lasting set: a first yield inside
    ends nothing there.
    """
    for kind, name in NAMES.items():
        if any(kind not in loading.pressures for loading in loadings):
            continue
        pressure = max(loading.pressures[kind] for loading in loadings)
        strength = reducer.contacts[kind].strength
        if reducer.contacts[kind].weaker_is_plastic:
            yield _set(reducer, loadings, kind, strength)
            continue
        for key, what, factor, source in (
            ("yield", "first yield", YIELD_PRESSURE, "p0 = 1.79 Y, below a line (Johnson 1985, 4.4)"),
            ("shakedown", "shakedown", SHAKEDOWN_PRESSURE, "p0 = 4 k = 2.31 Y, rolling line (Johnson 1985, 9.2)"),
        ):
            limit = factor * strength
            yield RatedItem(
                f"{kind}_{key}",
                f"{name}, {what}",
                1e-6 * pressure,
                1e-6 * limit,
                "MPa",
                limit / pressure,
                None,
                source,
                f"Hertz's p0; Y {1e-6 * strength:.4g} MPa of the weaker partner",
            )
        if all(part.youngs_modulus >= SOFTEST_STEEL for part in reducer.design.partners(kind)):
            yield _pitting(reducer, loadings, kind, pressure)


def _set(reducer: Reducer, loadings: Sequence[Loading], kind: str, strength: float) -> RatedItem:
    """Rate a plastic by the hours that its pressures may stand until they leave a set; Miner's sum over the duty."""
    limit = SHAKEDOWN_PRESSURE * strength
    damage = sum(loading.point.share / set_hours(loading.pressures[kind], limit) for loading in loadings)
    return RatedItem(
        f"{kind}_set",
        f"{NAMES[kind]}, lasting set of the plastic",
        1e-6 * max(loading.pressures[kind] for loading in loadings),
        1e-6 * limit,
        "MPa",
        None,
        1.0 / damage if damage else math.inf,
        "p0 = 4 k = 2.31 Y; Y falls with the hours under load as the creep modulus of POM does (ISO 899-1)",
        f"Y {1e-6 * strength:.4g} MPa of a short load at 23 °C; the load is taken to stand on one place all the time",
    )


def set_hours(pressure: float, limit: float) -> float:
    """Compute the hours after which a pressure [Pa] leaves a lasting set, by the limit of a short load [Pa]."""
    return float((SET_SHARE * limit / pressure) ** (1.0 / SET_POWER))


def _pitting(reducer: Reducer, loadings: Sequence[Loading], kind: str, pressure: float) -> RatedItem:
    allowed, source = min(map(pitting_limit, reducer.design.partners(kind)), key=lambda one: one[0])
    damage, least_damage, hourly, on_pins = 0.0, 0.0, 0.0, 0.0
    for loading in loadings:
        loads = _turns_an_hour(relative_speed(reducer, loading.point.speed)) * loading.point.share
        hourly += loads
        on_pins += _turns_an_hour(speed_past_ring(reducer, loading.point.speed)) * loading.point.share
        damage += loads / pitting_cycles(loading.pressures[kind], allowed)
        least_damage += loads / most_pitting_cycles(loading.pressures[kind], allowed)
    life = 1.0 / damage
    note = (
        f"{hourly:.0f} loads an hour on each lobe and hole, one a turn of the crank against the gear, {on_pins:.0f} "
        f"on each place of the ring; {source}"
    )
    if damage > least_damage:
        note += f"; {written(1.0 / least_damage)} h by the upper branch of Z_N beyond 10^7 loads (general use)"
    if life * hourly < FEWEST:
        note += "; below 10^4 loads the curve is drawn on"
    return RatedItem(
        f"{kind}_pitting",
        f"{NAMES[kind]}, pitting",
        1e-6 * pressure,
        1e-6 * allowed,
        "MPa",
        None,
        life,
        "Z_N = 2.466 n^-0.056, S_c by hardness, AGMA 2001-D04; Miner",
        note,
    )


def _turns_an_hour(speed: float) -> float:
    return speed / (2.0 * math.pi) * 3600.0


def pitting_limit(material: Material) -> tuple[float, str]:
    """Return the pressure [Pa] that a steel withstands for 10^7 cycles without pitting, and where it is from."""
    if material.endurance_pressure:
        return material.endurance_pressure, f"S_c of {material.name or 'the design file'}"
    hardness = 1e-6 * material.tensile_strength / BRINELL
    return pitting_pressure(material.tensile_strength), f"{hardness:.0f} HB by the tensile strength (assumed)"


def pitting_pressure(tensile: float) -> float:
    """Compute the pressure [Pa] that a steel of a tensile strength [Pa] withstands for 10^7 cycles without pitting."""
    slope, base = PITTING
    return min(slope * 1e-6 * tensile / BRINELL + base, HARDEST)


def pitting_cycles(pressure: float, allowed: float) -> float:
    """Compute the number of load cycles until pitting at a pressure [Pa], by what is allowed for 10^7 [Pa]."""
    factor, power = PITTING_LIFE
    return float((factor * allowed / pressure) ** (1.0 / power))


def most_pitting_cycles(pressure: float, allowed: float) -> float:
    """Compute the same by the upper branch of the figure beyond 10^7 cycles."""
    factor, power = UPPER_BRANCH
    cycles = pitting_cycles(pressure, allowed)
    return max(cycles, float((factor * allowed / pressure) ** (1.0 / power))) if cycles > UPPER_FROM else cycles
