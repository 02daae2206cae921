"""Wear of sliding contacts: p v, sliding distance, and the largest depth of wear by Archard's law."""

import math
from collections.abc import Iterator, Sequence

from cycloid_mj.base.units import HOUR
from cycloid_mj.life.item import RatedItem
from cycloid_mj.life.loading import Loading
from cycloid_mj.life.wear_data import MM3, Interval, wear_coefficient
from cycloid_mj.life.wearing_surfaces import wearing_surfaces
from cycloid_mj.reducer import Reducer

WEAR_HOURS = 1000.0
"""Hours of running that depths and sliding distances are stated for."""

NAMES = {
    "pin_gear": "disc on pins",
    "tooth": "disc on internal gear",
    "pin_socket": "sockets by pins",
    "pin_sleeve": "sleeves by pins",
    "output": "output holes by output pins",
    "output_roller": "rollers of the output pins by their cores",
    "cam": "disc's bore by the cam",
}


def rate_wear(reducer: Reducer, loadings: Sequence[Loading]) -> Iterator[RatedItem]:
    """Yield wear depth in 1000 h [um] (Archard), sliding distance [km] and largest p v of each kind of contact.

    p is the pressure [MPa] and v the sliding speed [m/s]. `loadings` are the solved forces at each point of the duty.
    The depth is the largest on the surface, at most the thickness at which a part is worn through. Its limit is the
    clearance. The distance and the product p v [MPa m/s] have no limit.
    """
    for kind in loadings[0].sliding:
        pair = "output" if kind == "output_roller" else kind
        coefficient = pair_wear_coefficient(reducer, pair)
        mean_line_power = sum(loading.sliding[kind].density * loading.point.share for loading in loadings)
        speed = sum(loading.sliding[kind].speed * loading.point.share for loading in loadings)
        max_pressure_speed = max(loading.sliding[kind].pressure_speed for loading in loadings)
        depth = coefficient.typical * mean_line_power / reducer.design.gear.face_width * HOUR * WEAR_HOURS
        life_of_depth = WEAR_HOURS / depth if depth else math.inf
        limit = getattr(reducer.design.clearance, pair)
        thickness = worn_through_depth(reducer, kind) if depth > limit else math.inf
        distance = speed * 3.6 * WEAR_HOURS
        yield RatedItem(
            f"{kind}_wear",
            f"wear of {NAMES[kind]}, per {WEAR_HOURS:.0f} h",
            1e6 * min(depth, thickness),
            1e6 * limit,
            "um",
            None,
            limit * life_of_depth,
            "Archard, k F s at the point with the fastest wear, for one direction of rotation; until the clearance has "
            "doubled",
            f"k = {MM3 * coefficient.typical:g} mm3/(N m), 5 to 95 %: {MM3 * coefficient.low:g} to "
            f"{MM3 * coefficient.high:g}; {coefficient.source}; steady wear without run-in: see `cycloid-mj wear`"
            + (f"; worn through after {thickness * life_of_depth:.3g} h" if depth > thickness else ""),
        )
        yield _item_without_limit(
            f"{kind}_way",
            f"sliding distance of {NAMES[kind]}, per {WEAR_HOURS:.0f} h",
            distance,
            "km",
            "mean sliding speed of the loaded contacts",
        )
        yield _item_without_limit(
            f"{kind}_pv",
            f"p v of {NAMES[kind]}",
            1e-6 * max_pressure_speed,
            "MPa m/s",
            "largest F v/(2 r w), on the projected area of the pin",
            "no limit: see the data sheet of the material",
        )


def _item_without_limit(key: str, name: str, value: float, unit: str, source: str, note: str = "") -> RatedItem:
    """Return an item without a limit."""
    return RatedItem(key, name, value, math.nan, unit, None, None, source, note)


def worn_through_depth(reducer: Reducer, kind: str) -> float:
    """Return the depth at which the thinner part of a kind of contact in `NAMES` is worn through [m]."""
    contacts = {"pin_gear": "flank", "tooth": "flank", "output": "output", "output_roller": "output", "cam": "cam"}
    return min(
        surface.thickness for surface in wearing_surfaces(reducer) if surface.contacts == contacts.get(kind, "seat")
    )


def pair_wear_coefficient(reducer: Reducer, kind: str) -> Interval:
    """Return the larger of the coefficients of wear of a pair's two surfaces [m3/(N m)]."""
    design = reducer.design
    return max(
        (wear_coefficient(design.service, part) for part in design.partners(kind)), key=lambda item: item.typical
    )
