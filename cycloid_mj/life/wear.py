"""Wear of sliding contacts: p v, sliding distance, and the largest depth of wear by Archard's law."""

import math
from collections.abc import Iterator, Sequence

from cycloid_mj.design.model import Service
from cycloid_mj.life.item import RatedItem
from cycloid_mj.life.loading import Loading
from cycloid_mj.reducer import Reducer

HOURS = 1000.0
"""Hours of running that depths and sliding distances are stated for."""

PLASTIC_WEAR = 1e-15
"""Coefficient of wear where one surface is a plastic and the design file leaves the default of metals [m3/(N m)].

1e-6 mm3/(N m): POM has 0.3 to 1.2, PA 66 2.7 to 4.6 times that against plastics in a thrust-washer test (RTP Company,
Wear factor and friction data, ASTM D3702).
"""

MM3 = 1e9
"""Cubic millimetres in a cubic metre."""

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
    """Rate wear at the place that wears fastest, and state p v and the sliding distance."""
    for kind in loadings[0].sliding:
        pair = "output" if kind == "output_roller" else kind
        coefficient, source = wear_coefficient(reducer, pair)
        density = sum(loading.sliding[kind].density * loading.point.share for loading in loadings)
        speed = sum(loading.sliding[kind].speed * loading.point.share for loading in loadings)
        largest = max(loading.sliding[kind].pressure_speed for loading in loadings)
        depth = coefficient * density / reducer.design.gear.face_width * 3600.0 * HOURS
        limit = getattr(reducer.design.clearance, pair)
        distance = speed * 3.6 * HOURS
        yield RatedItem(
            f"{kind}_wear",
            f"wear of {NAMES[kind]}, per {HOURS:.0f} h",
            1e6 * depth,
            1e6 * limit,
            "um",
            None,
            HOURS * limit / depth if depth else math.inf,
            "Archard, k F s at the place that wears fastest, running one way; until the clearance has doubled",
            f"k = {MM3 * coefficient:g} mm3/(N m), {source}; {MM3 * coefficient / 10.0:g} to "
            f"{MM3 * coefficient * 10.0:g} give ten times to a tenth of the life",
        )
        yield _figure(
            f"{kind}_way",
            f"sliding distance of {NAMES[kind]}, per {HOURS:.0f} h",
            distance,
            "km",
            "mean sliding speed of the loaded contacts",
        )
        yield _figure(
            f"{kind}_pv",
            f"p v of {NAMES[kind]}",
            1e-6 * largest,
            "MPa m/s",
            "largest F v/(2 r w), on the projected area of the pin",
            "no limit: see the data sheet of the material",
        )


def _figure(key: str, name: str, value: float, unit: str, source: str, note: str = "") -> RatedItem:
    """Return an item without a limit."""
    return RatedItem(key, name, value, math.nan, unit, None, None, source, note)


def wear_coefficient(reducer: Reducer, kind: str) -> tuple[float, str]:
    """Return the coefficient of wear of a kind of pair [m3/(N m)], and its source.

    It is that of the design file, or `PLASTIC_WEAR` if the file has the default for metals and a surface is a plastic.
    """
    stated = reducer.design.service.wear_coefficient
    if stated != Service.model_fields["wear_coefficient"].default:
        return stated, "service.wear_coefficient of the design file"
    if any(part.is_plastic for part in reducer.design.partners(kind)):
        return PLASTIC_WEAR, "plastics (assumed)"
    return stated, "metals in mixed lubrication (assumed)"
