"""Wear of what slides: p v, the way that is slid, and how deep it wears by Archard's law."""

import math
from collections.abc import Iterator, Sequence

from cycloid_mj.geometry import profile
from cycloid_mj.life.item import RatedItem
from cycloid_mj.life.loading import Loading
from cycloid_mj.reducer import Reducer

HOURS = 1000.0
"""Of running that depths and ways are told for."""

NAMES = {
    "pin_gear": "gear on pins",
    "tooth": "gear on internal gear",
    "pin_socket": "sockets by pins",
    "pin_sleeve": "sleeves by pins",
    "output": "gear's holes by output pins",
    "output_roller": "rollers of the output pins by their cores",
    "cam": "gear's bore by the cam",
}


def wear(reducer: Reducer, loadings: Sequence[Loading]) -> Iterator[RatedItem]:
    """Rate wear by Archard, k F s spread over the whole surface that slides, and give p v and the way slid."""
    coefficient = reducer.design.service.wear_coefficient
    for kind in loadings[0].rubs:
        power = sum(loading.rubs[kind].power * loading.point.share for loading in loadings)
        speed = sum(loading.rubs[kind].speed * loading.point.share for loading in loadings)
        largest = max(loading.rubs[kind].pressure_speed for loading in loadings)
        depth = coefficient * power * 3600.0 * HOURS / _face(reducer, kind)
        limit = getattr(reducer.design.clearance, "output" if kind == "output_roller" else kind)
        way = speed * 3.6 * HOURS
        yield RatedItem(
            f"{kind}_wear",
            f"wear of {NAMES[kind]}, per {HOURS:.0f} h",
            1e6 * depth,
            1e6 * limit,
            "um",
            None,
            HOURS * limit / depth if depth else math.inf,
            "Archard, k F s over the whole surface; until the clearance has doubled",
            f"k = {1e9 * coefficient:g} mm3/(N m), mixed lubrication (assumed; {1e8 * coefficient:g} to "
            f"{1e10 * coefficient:g}: ten times the life to a tenth)",
        )
        yield _figure(
            f"{kind}_way",
            f"way that {NAMES[kind]} slides, per {HOURS:.0f} h",
            way,
            "km",
            "mean sliding speed of the contacts that carry",
        )
        yield _figure(
            f"{kind}_pv",
            f"p v of {NAMES[kind]}",
            1e-6 * largest,
            "MPa m/s",
            "largest F v/(2 r w), on the pin's projected face",
            "no limit: it is the bearing material maker's to give",
        )


def _figure(key: str, name: str, value: float, unit: str, source: str, note: str = "") -> RatedItem:
    return RatedItem(key, name, value, math.nan, unit, None, None, source, note)


def _face(reducer: Reducer, kind: str) -> float:
    """Compute the area of the surface that wears [m2], of one disc, or of all sockets or sleeves."""
    design = reducer.design
    width, ring = design.gear.face_width, design.ring
    if kind in ("pin_gear", "tooth"):
        gear = reducer.gear_profile
        return float(profile.arc_length(gear, 2.0 * math.pi, reducer.profile_offset)) * width * design.gear.discs
    around = {
        "output": design.output.hole_radius * design.output.pins,
        "output_roller": design.output.root_radius * design.output.pins,
        "cam": design.gear.bore_radius,
        "pin_socket": ring.pin_radius * ring.teeth / 2.0,
        "pin_sleeve": ring.sleeve_bore_radius * ring.teeth,
    }
    return 2.0 * math.pi * around[kind] * width * design.gear.discs
