"""Surfaces under Hertz pressure: first yield, shakedown and pitting of metals; plastics are in `plastic_set`."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from cycloid_mj.base.units import HOUR
from cycloid_mj.design import Material
from cycloid_mj.design.materials import SHAKEDOWN_PRESSURE, YIELD_PRESSURE
from cycloid_mj.life.duration import format_number
from cycloid_mj.life.item import RatedItem
from cycloid_mj.life.loading import Loading, relative_speed, speed_past_ring
from cycloid_mj.life.pitting_factors import PittingFactors, lubricated_cycles, pitting_factors
from cycloid_mj.life.plastic_set import rate_permanent_set
from cycloid_mj.reducer import Reducer

SOFTEST_STEEL = 1e11
"""Young's modulus from which a material counts as steel [Pa] (heuristic): pitting and endurance limits are for steel
only."""


@dataclass(frozen=True)
class Agma2001:
    """Pitting of steel gears by AGMA 2001-D04.

    Attributes
    ----------
    slope, base, max_pressure
        Allowable pressure at 10^7 loads, S_c = slope HB + base [Pa], of through-hardened steel of grade 1 (10.3), and
        that of carburised steel of grade 1, 55 to 64 HRC: harder steel is not credited more.
    factor, power
        Stress-cycle factor Z_N = factor n^-power (Fig. 17), for every number of loads n. Above 10^7 loads this is the
        lower branch of the figure, for smooth running with little pitting.
    upper_factor, upper_power, upper_from
        The same of the upper branch, for general use, from that number of loads on; stated as a spread.
    min_cycles
        Number of loads from which the curve is defined.
    brinell
        Tensile strength of steel per Brinell hardness [MPa] (ISO 18265).
    """

    slope: float = 2.22e6
    base: float = 200e6
    max_pressure: float = 1240e6
    factor: float = 2.466
    power: float = 0.056
    upper_factor: float = 1.4488
    upper_power: float = 0.023
    upper_from: float = 1e7
    min_cycles: float = 1e4
    brinell: float = 3.45


AGMA_2001 = Agma2001()

NAMES = {
    "pin_gear": "teeth on pins",
    "tooth": "disc on internal gear",
    "pin_socket": "pins in sockets",
    "pin_sleeve": "sleeves on their pins",
    "output": "output pins in holes",
}


def rate_surfaces(reducer: Reducer, loadings: Sequence[Loading]) -> Iterator[RatedItem]:
    """Yield safety factors against first yield and shakedown, and the pitting life, of teeth, holes and seats.

    `loadings` are the solved forces at each point of the duty. Safety factors compare the largest Hertz pressure with
    its limits; the life follows by Miner's sum, for steel only. If the weaker surface is a plastic, only the time until
    a permanent set is rated. Conformal contacts, for which Hertz's theory is not valid, are left out.
    """
    for kind, name in NAMES.items():
        if any(kind not in loading.pressures for loading in loadings):
            continue
        pressure = max(loading.pressures[kind] for loading in loadings)
        strength = reducer.contacts[kind].strength
        if reducer.contacts[kind].weaker_is_plastic:
            yield rate_permanent_set(loadings, kind, name)
            continue
        for key, limit_name, pressure_factor, source in (
            ("yield", "first yield", YIELD_PRESSURE, "p0 = 1.79 Y, below a line (Johnson 1985, 4.4)"),
            ("shakedown", "shakedown", SHAKEDOWN_PRESSURE, "p0 = 4 k = 2.31 Y, rolling line (Johnson 1985, 9.2)"),
        ):
            limit = pressure_factor * strength
            yield RatedItem(
                f"{kind}_{key}",
                f"{name}, {limit_name}",
                1e-6 * pressure,
                1e-6 * limit,
                "MPa",
                limit / pressure,
                None,
                source,
                f"Hertz p0; Y = {1e-6 * strength:.4g} MPa of the weaker material",
            )
        if all(part.youngs_modulus >= SOFTEST_STEEL for part in reducer.design.partners(kind)):
            pitting = _rate_pitting(reducer, loadings, kind, pressure)
            yield pitting
            factors = [item for loading in loadings if (item := pitting_factors(loading, kind, 1e6 * pitting.limit))]
            if len(factors) == len(loadings):
                load_rates = [
                    relative_speed(reducer, loading.point.speed) * loading.point.share for loading in loadings
                ]
                pressures = [loading.pressures[kind] for loading in loadings]
                yield rate_lubricated_pitting(pitting, factors, pressures, load_rates)


def _rate_pitting(reducer: Reducer, loadings: Sequence[Loading], kind: str, pressure: float) -> RatedItem:
    """Rate steel surfaces by the hours until they pit (AGMA 2001-D04), by Miner's sum over the duty cycle.

    `loadings` are the solved forces at the points of the duty, `kind` is the kind of mating pair, `pressure` its
    largest Hertz pressure over the duty [Pa], which is only reported.
    """
    allowed_pressure, source = min(map(pitting_limit, reducer.design.partners(kind)), key=lambda limit: limit[0])
    damage, least_damage, total_loads_per_hour, pin_loads_per_hour = 0.0, 0.0, 0.0, 0.0
    for loading in loadings:
        loads_per_hour = _turns_per_hour(relative_speed(reducer, loading.point.speed)) * loading.point.share
        total_loads_per_hour += loads_per_hour
        pin_loads_per_hour += _turns_per_hour(speed_past_ring(reducer, loading.point.speed)) * loading.point.share
        damage += loads_per_hour / pitting_cycles(loading.pressures[kind], allowed_pressure)
        least_damage += loads_per_hour / upper_pitting_cycles(loading.pressures[kind], allowed_pressure)
    life = 1.0 / damage
    note = (
        f"{total_loads_per_hour:.0f} loads per hour on each lobe and hole (one per turn of crank against disc), "
        f"{pin_loads_per_hour:.0f} on each tooth of the ring; {source}"
    )
    if damage > least_damage:
        note += f"; {format_number(1.0 / least_damage)} h by the upper branch of Z_N above 10^7 loads (general use)"
    if life * total_loads_per_hour < AGMA_2001.min_cycles:
        note += "; outside of AGMA's curve, which begins at 10^4 loads: the life is extrapolated"
    return RatedItem(
        f"{kind}_pitting",
        f"{NAMES[kind]}, pitting",
        1e-6 * pressure,
        1e-6 * allowed_pressure,
        "MPa",
        None,
        life,
        "Z_N = 2.466 n^-0.056, S_c by hardness, AGMA 2001-D04; Miner",
        note,
    )


def rate_lubricated_pitting(
    pitting: RatedItem, factors: Sequence[PittingFactors], pressures: Sequence[float], load_rates: Sequence[float]
) -> RatedItem:
    """Rate the life until steel surfaces pit with the lubricant factors of ISO 6336-2, by Miner's sum.

    Parameters
    ----------
    pitting
        Rated item of the pitting life without these factors.
    factors, pressures
        Factors, and largest Hertz pressure [Pa], at each point of the duty.
    load_rates
        Number of loads on a tooth per second at each point, times the point's share of time and 2 pi [rad/s].
    """
    allowed_pressure, damage = 1e6 * pitting.limit, 0.0
    for point_factors, pressure, load_rate in zip(factors, pressures, load_rates, strict=True):
        cycles = lubricated_cycles(pitting_cycles(pressure, allowed_pressure), point_factors.product, AGMA_2001.power)
        damage += _turns_per_hour(load_rate) / cycles
    smallest_factors = min(factors, key=lambda point_factors: point_factors.product)
    return RatedItem(
        f"{pitting.key}_lubricated",
        f"{pitting.name} with the lubricant",
        pitting.value,
        smallest_factors.product * pitting.limit,
        "MPa",
        None,
        1.0 / damage,
        "Z_L Z_v Z_R, ISO 6336-2:2006; Z_N and S_c as without lubricant, AGMA 2001-D04; Miner",
        f"Z_L {smallest_factors.lubricant:.3g} ({smallest_factors.viscosity_40:.3g} mm2/s at 40 °C), Z_v "
        f"{smallest_factors.speed:.3g} (v {smallest_factors.pitch_speed:.3g} m/s, same entrainment), Z_R "
        f"{smallest_factors.roughness:.3g} (Rz10 {smallest_factors.mean_roughness:.3g} um); the "
        "factors are for involute gears, and 1 up to 10^5 loads",
    )


def _turns_per_hour(speed: float) -> float:
    """Convert a speed [rad/s] to turns per hour."""
    return speed / (2.0 * math.pi) * HOUR


def pitting_limit(material: Material) -> tuple[float, str]:
    """Return the pressure [Pa] that a steel withstands for 10^7 cycles without pitting, and its source."""
    if material.endurance_pressure:
        return material.endurance_pressure, f"S_c of {material.name or 'the design file'}"
    hardness = 1e-6 * material.tensile_strength / AGMA_2001.brinell
    return pitting_pressure(material.tensile_strength), f"{hardness:.0f} HB by the tensile strength (assumed)"


def pitting_pressure(tensile: float) -> float:
    """Compute the pressure [Pa] that a steel of a tensile strength [Pa] withstands for 10^7 cycles without pitting."""
    agma = AGMA_2001
    return min(agma.slope * 1e-6 * tensile / agma.brinell + agma.base, agma.max_pressure)


def pitting_cycles(pressure: float, allowed: float) -> float:
    """Compute the number of load cycles until pitting at a pressure [Pa], by the pressure allowed for 10^7 [Pa]."""
    return float((AGMA_2001.factor * allowed / pressure) ** (1.0 / AGMA_2001.power))


def upper_pitting_cycles(pressure: float, allowed: float) -> float:
    """Compute the load cycles until pitting by the upper branch of AGMA's curve above 10^7; see `pitting_cycles`."""
    agma, cycles = AGMA_2001, pitting_cycles(pressure, allowed)
    if cycles <= agma.upper_from:
        return cycles
    return max(cycles, float((agma.upper_factor * allowed / pressure) ** (1.0 / agma.upper_power)))
