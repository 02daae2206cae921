"""The retainer that clamps the outer ring of a crossed roller bearing against its shoulder in the output cover."""

from dataclasses import dataclass

from cycloid_mj.design import stock
from cycloid_mj.parts.export.casing_rules import (
    RULES,
    counterbore,
    stock_screw_length,
    thread_radius,
)
from cycloid_mj.reducer import Reducer

_SCREWS = ((100e-3, 3e-3, 8), (200e-3, 4e-3, 12), (500e-3, 5e-3, 16))
"""Outside diameter of a bearing up to which [m], thread [m] and number of screws (THK, No. 382-3E, table 23)."""

THICKNESS_SHARE = 0.5
"""Least thickness of a retainer relative to the width of its bearing (THK, No. 382-3E: 0.5 to 1.2)."""


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
        None for ball bearings, which are mounted in pairs and need no retainer.
    """
    if not bearing.has_crossed_rollers:
        return None
    thread, count = next((size, number) for max_diameter, size, number in _SCREWS if bearing.outside <= max_diameter)
    bolt = next(bolt for bolt in stock.bolts() if bolt.thread == thread)
    hole, thickness = thread_radius(reducer, thread), max(thread, THICKNESS_SHARE * bearing.width)
    circle = 0.5 * bearing.outside + wall + hole
    length = stock_screw_length(bolt, thickness + RULES.engagement * thread)
    radius = circle + max(counterbore(bolt), 0.5 * stock.bolt_hole(thread) + wall)
    return Retainer(bolt, length, count, circle, radius, thickness, max(circle + hole + wall, radius))
