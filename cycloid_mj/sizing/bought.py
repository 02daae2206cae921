"""Sizes of a new drive that are bought: pins, bearings and screws from stock, nearest to what proportions ask for."""

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

FULLEST = 0.86
"""Most radius of a ring pin in its room between its neighbours."""

LARGER = 1.06
"""How much larger than asked for a bearing may be outside."""

CORE = 0.8
"""Most radius of a dowel in that of its roller: the rest is for needles and the roller's wall."""

THINNER = 1.5
"""How much thinner or thicker than usual an output disc may be, so that dowels in stock reach through both."""

OF_WALL = 0.8
"""Most diameter of a screw's head in the wall of the ring that it clamps."""


@dataclass(frozen=True)
class CamBearing:
    """Bearing of a cam: what is in stock, and the radius of the cam in it [m]."""

    bearing: StockBearing

    @property
    def bore_radius(self) -> float:
        """Radius of the gear's bore [m]."""
        return round(0.5 * self.bearing.outside, 9)

    @property
    def cam_radius(self) -> float:
        """Radius of the cam [m]."""
        return round(0.5 * self.bearing.bore, 9)


def ring_pin(radius: float, room: float) -> float | None:
    """Find the radius of the pin in stock nearest to one [m], in the room between its neighbours [m]; none if none."""
    radii = [0.5 * size for size in pin_diameters() if 0.5 * size <= FULLEST * room]
    nearest = min(radii, key=lambda one: abs(math.log(one / radius)), default=0.0)
    return round(nearest, 9) or None


def cam_bearing(radius: float, width: float) -> CamBearing | None:
    """Find the bearing for a gear's bore of about a radius [m] that is no wider than the disc [m]; none if none."""
    fitting = [one for one in needle_bearings() if one.outside <= 2.0 * LARGER * radius and one.width <= width]
    return CamBearing(max(fitting, key=lambda one: (one.outside, -one.bore))) if fitting else None


def shaft_bearing(radius: float, bar: bool) -> StockBearing | None:
    """Find the narrowest bearing for the thickest shaft of at most a radius [m], or ground `bar`; none if none."""
    bores = bar_diameters() if bar else [one.bore for one in needle_bearings()]
    fitting = [one for one in needle_bearings() if one.bore <= 2.0 * radius * (1.0 + 1e-9) and one.bore in bores]
    return max(fitting, key=lambda one: (one.bore, -one.width)) if fitting else None


def core(roller: float, between: float, usual: float) -> float | None:
    """Find the radius of the thickest dowel under a roller of a radius [m]; none if none.

    It reaches over what is between two discs [m] and through both, as thick as usual [m] or as thin as they may be.
    """
    length = between + 2.0 * usual / THINNER
    thin_enough = [size for size in dowel_diameters() if size <= 2.0 * CORE * roller and _in_one(size, length)]
    return round(0.5 * max(thin_enough), 9) if thin_enough else None


def disc_thickness(core_radius: float, between: float, usual: float) -> float:
    """Find the thickness of both output discs [m] near a usual one with which a dowel reaches from face to face.

    The dowel has the radius of the output pins' core and reaches over what is between the discs [m] as well.
    """
    reach = reach_of_pins(2.0 * core_radius, between + 2.0 * usual, most=1)
    thickness = round(0.5 * (reach - between), 9)
    return thickness if usual / THINNER <= thickness <= usual * THINNER else usual


def _in_one(size: float, length: float) -> bool:
    pin = pins(size, length)
    return pin is not None and pin[1] == 1


def clamping(wall: float) -> dict[str, object]:
    """Return what holds a ring with a wall behind its teeth [m]: screws, or where it is too thin a seat all round."""
    screw = bolt_under(OF_WALL * wall)
    return {"support": "bolts", "bolt_radius": round(0.5 * screw.head, 9)} if screw else {"support": "rim"}
