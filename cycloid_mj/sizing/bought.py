"""Pins, bearings and screws in stock, nearest to the proportions of a new drive."""

import math
from dataclasses import dataclass

from cycloid_mj.design.stock import (
    StockBearing,
    bar_diameters,
    bolt_under,
    dowel_diameters,
    needle_bearings,
    pin_diameters,
    pins,
    reach_of_pins,
)

MAX_PIN_FILL = 0.86
"""Largest radius of a ring pin, over half of the distance between neighbours (assumed)."""

MAX_BEARING_SHARE = 1.06
"""Largest outer diameter of a cam bearing, over the proportional bore of the disc (assumed)."""

MAX_CORE_SHARE = 0.8
"""Largest radius of a dowel over that of its roller, which leaves space for needles and the roller's wall (assumed)."""

DISC_THICKNESS_FACTOR = 1.5
"""Largest ratio of the usual thickness of an output disc to that with dowels in stock, and its inverse (assumed)."""

MAX_HEAD_SHARE = 0.8
"""Largest diameter of a screw head, over the wall of the ring that it clamps (assumed)."""


@dataclass(frozen=True)
class CamBearing:
    """Bearing of a cam in stock, and the radii of its seats [m]."""

    bearing: StockBearing

    @property
    def bore_radius(self) -> float:
        """Radius of the disc's bore [m]."""
        return round(0.5 * self.bearing.outside, 9)

    @property
    def cam_radius(self) -> float:
        """Radius of the cam [m]."""
        return round(0.5 * self.bearing.bore, 9)


def ring_pin(radius: float, room: float) -> float | None:
    """Find the radius of the ring pin in stock nearest to a radius; None if none fits.

    `room` is half of the distance between neighbouring pins; all in [m].
    """
    radii = [0.5 * size for size in pin_diameters() if 0.5 * size <= MAX_PIN_FILL * room]
    nearest = min(radii, key=lambda one: abs(math.log(one / radius)), default=0.0)
    return round(nearest, 9) or None


def cam_bearing(radius: float, width: float) -> CamBearing | None:
    """Find the largest bearing for a bore of about a radius [m] and a disc of a width [m]; None if none fits."""
    largest = 2.0 * MAX_BEARING_SHARE * radius
    fitting = [one for one in needle_bearings() if one.outside <= largest and one.width <= width]
    return CamBearing(max(fitting, key=lambda one: (one.outside, -one.bore))) if fitting else None


def shaft_bearing(radius: float, bar: bool) -> StockBearing | None:
    """Find the narrowest bearing for the thickest shaft up to a radius [m]; None if none fits.

    With `bar`, only shafts of ground bar in stock count.
    """
    bores = bar_diameters() if bar else [one.bore for one in needle_bearings()]
    fitting = [one for one in needle_bearings() if one.bore <= 2.0 * radius * (1.0 + 1e-9) and one.bore in bores]
    return max(fitting, key=lambda one: (one.bore, -one.width)) if fitting else None


def core(roller: float, between: float, usual: float) -> float | None:
    """Find the radius of the thickest dowel for a roller of a radius [m]; None if there is none.

    It spans the distance `between` two output discs [m], and both discs, which may be thinner than `usual` [m].
    """
    length = between + 2.0 * usual / DISC_THICKNESS_FACTOR
    thickest = 2.0 * MAX_CORE_SHARE * roller
    thin_enough = [size for size in dowel_diameters() if size <= thickest and _in_one(size, length)]
    return round(0.5 * max(thin_enough), 9) if thin_enough else None


def disc_thickness(core_radius: float, between: float, usual: float) -> float:
    """Find the thickness of both output discs [m], near the `usual`, with which a dowel reaches from face to face.

    The dowel has the radius of the output pins' core, and spans the distance `between` the discs [m] as well.
    """
    reach = reach_of_pins(2.0 * core_radius, between + 2.0 * usual, most=1)
    thickness = round(0.5 * (reach - between), 9)
    return thickness if usual / DISC_THICKNESS_FACTOR <= thickness <= usual * DISC_THICKNESS_FACTOR else usual


def _in_one(size: float, length: float) -> bool:
    """Return whether a single dowel in stock of a diameter [m] reaches over a length [m]."""
    pin = pins(size, length)
    return pin is not None and pin[1] == 1


def clamping(wall: float) -> dict[str, object]:
    """Return the support of a ring by its wall behind the teeth [m]: screws, or its rim if the wall is too thin."""
    screw = bolt_under(MAX_HEAD_SHARE * wall)
    return {"support": "bolts", "bolt_radius": round(0.5 * screw.head, 9)} if screw else {"support": "rim"}
