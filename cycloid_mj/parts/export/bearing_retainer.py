"""Rings that retain outer rings of the output's bearings: the retainer of crossed rollers, and a stop ring.

The retainer clamps the outer ring of a crossed roller bearing against its shoulder in the output cover. The stop ring
lies on the ring of the drive and supports the outer ring of the bearing around the second output disc.
"""

from dataclasses import dataclass

from cycloid_mj.design import stock
from cycloid_mj.parts.export.casing_rules import (
    RULES,
    counterbore,
    stock_screw_length,
    thread_radius,
)
from cycloid_mj.parts.export.cover_screws import Screws
from cycloid_mj.reducer import Reducer

_SCREWS = ((100e-3, 3e-3, 8), (200e-3, 4e-3, 12), (500e-3, 5e-3, 16))
"""Outside diameter of a bearing up to which [m], thread [m] and number of screws (THK, No. 382-3E, table 23)."""

THICKNESS_SHARE = 0.5
"""Least thickness of a retainer or stop ring relative to the width of its bearing (THK, No. 382-3E: 0.5 to 1.2)."""


@dataclass(frozen=True)
class StopRing:
    """A stop ring: outer radius, radius of its bore and thickness [m]."""

    radius: float
    bore: float
    thickness: float


@dataclass(frozen=True)
class Retainer:
    """A retainer ring: its screws, their length, number and circle radius, outer radius and thickness of the ring [m].

    `cover_radius` is the radius of the cover that has walls around the threads [m].
    """

    bolt: stock.Bolt
    length: float
    count: int
    circle: float
    radius: float
    thickness: float
    cover_radius: float

    @property
    def height(self) -> float:
        """Height of ring and screw heads on the cover [m]."""
        return self.thickness + self.bolt.head_height


def retainer_of(reducer: Reducer, bearing: stock.StockBearing, wall: float) -> Retainer | None:
    """Size the ring screwed to the output cover that clamps the outer ring of a crossed roller bearing (its retainer).

    Parameters
    ----------
    reducer
        The reducer, whose material decides about threaded inserts.
    bearing
        Bearing of the output.
    wall
        Minimum wall around holes [m].

    Returns
    -------
    Retainer or None
        Screws of the ring with their length, number and circle, outer radius and thickness of the ring, and the radius
        that the cover needs; None for ball bearings, which are mounted in pairs and need no retainer.
    """
    if not bearing.has_crossed_rollers:
        return None
    thread, count = next((size, number) for max_diameter, size, number in _SCREWS if bearing.outside <= max_diameter)
    bolt = next(bolt for bolt in stock.bolts() if bolt.thread == thread)
    hole_radius, thickness = thread_radius(reducer, thread), max(thread, THICKNESS_SHARE * bearing.width)
    circle = 0.5 * bearing.outside + wall + hole_radius
    length = stock_screw_length(bolt, thickness + RULES.engagement * thread)
    radius = circle + max(counterbore(bolt), 0.5 * stock.bolt_hole(thread) + wall)
    return Retainer(bolt, length, count, circle, radius, thickness, max(circle + hole_radius + wall, radius))


def max_stop_ring_radius(
    reducer: Reducer, screws: Screws, dowel: stock.Dowel | None, dowel_circle: float, wall: float
) -> float:
    """Compute the largest radius [m] of a stop ring in the motor cover, inside of screws and dowels.

    Parameters
    ----------
    reducer, screws
        The reducer, and the screws of its covers.
    dowel, dowel_circle
        Dowels between covers and ring (None: no dowels), and the radius of their circle [m].
    wall
        Minimum wall around holes [m].
    """
    max_radius = reducer.design.housing.outer_radius
    if not screws.outside:
        max_radius = screws.circle - max(screws.hole, thread_radius(reducer, screws.bolt.thread))
    if dowel and dowel_circle < reducer.design.housing.outer_radius:
        max_radius = min(max_radius, dowel_circle - 0.5 * dowel.diameter)
    return max_radius - wall


def stop_ring_of(bearing: stock.StockBearing, radius: float, wall: float) -> StopRing:
    """Size the stop ring of `bearing` with an outer radius [m]; `wall` is the minimum wall of the covers [m]."""
    return StopRing(radius, bearing.shoulders[1], max(2.0 * wall, THICKNESS_SHARE * bearing.width))
