"""Parts next to the bearings of the crank in the motor cover: retaining rings and a seal ring.

Two retaining rings locate the crank along its axis, in both directions. One is on the crank, on the motor side of its
bearings; the other is in the cover, on the side of the discs. Ball bearings take the axial load. Drawn cups take none,
and have no seal: a seal ring is pressed into their bore on the motor side.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.units import in_mm
from cycloid_mj.design import stock
from cycloid_mj.parts.cam_bearing import needs_rings
from cycloid_mj.parts.export.casing_rules import RULES, shoulder_radius
from cycloid_mj.reducer import Reducer


@dataclass(frozen=True)
class CrankEnd:
    """Parts next to the bearings of the crank: both retaining rings or a seal ring; None: without."""

    shaft_ring: stock.RetainingRing | None = None
    bore_ring: stock.RetainingRing | None = None
    seal: stock.SealRing | None = None

    @property
    def seal_width(self) -> float:
        """Width of the seal ring on the motor side of the bearing [m]."""
        return self.seal.width if self.seal else 0.0

    @property
    def journal(self) -> float:
        """Length that the journal needs beyond its bearings on the motor side [m]."""
        return max(self.seal_width, self.shaft_ring.room if self.shaft_ring else 0.0)

    @property
    def max_collar(self) -> float:
        """Largest radius of a collar of the crank inside of the eyes of the ring in the cover [m]; else infinite."""
        return self.bore_ring.eye_radius if self.bore_ring else math.inf


def choose_crank_end(reducer: Reducer, bearing: stock.StockBearing | None, seat: float, bore_room: float) -> CrankEnd:
    """Choose the retaining rings or the seal ring that a design requests for its crank.

    Parameters
    ----------
    bearing
        Bearing in stock on the crank; None if none has the size of its seats.
    seat
        Radius of the seats of the bearings in the motor cover [m].
    bore_room
        Length of the motor cover beyond the bearing next to the discs [m].

    Returns
    -------
    CrankEnd
        Retaining rings of crank and cover, and seal ring; None for those that the design does not request.

    Raises
    ------
    DesignError
        The requested parts do not fit: no ring is in stock, there is no room for it, or the bearings are of a kind that
        does not allow it.
    """
    shaft = reducer.design.shaft
    is_ringed = bearing is not None and stock.has_inner_ring(bearing)
    shaft_ring = bore_ring = seal = None
    if shaft.seal_ring:
        seal = None if is_ringed else stock.seal_ring(2.0 * shaft.radius, 2.0 * seat)
        if seal is None or shaft.bore_radius:
            raise DesignError(f"shaft.seal_ring = true is not possible: {_describe_seal_problem(reducer, is_ringed)}")
    if shaft.retaining_rings:
        shaft_ring, bore_ring = stock.shaft_ring(2.0 * shaft.radius), stock.bore_ring(2.0 * seat)
        problems = tuple(_describe_ring_problems(reducer, is_ringed, seat, (shaft_ring, bore_ring), bore_room))
        if problems:
            raise DesignError(f"shaft.retaining_rings = true is not possible: {'; '.join(problems)}")
    return CrankEnd(shaft_ring, bore_ring, seal)


def _describe_seal_problem(reducer: Reducer, is_ringed: bool) -> str:
    """Return the reason why a requested seal ring does not fit, with the remedy, as a clause.

    `is_ringed` is whether the bearings of the crank are in stock and have inner rings.
    """
    if is_ringed:
        return "the crank has ball bearings, which are sealed themselves: remove the key"
    if reducer.design.shaft.bore_radius:
        return "a hollow crank needs a seal at both ends: choose ball bearings (shaft.bearing_width_mm), and remove it"
    diameter_mm = in_mm(2.0 * reducer.design.shaft.radius)
    return f"no standard seal ring fits a drawn cup on a shaft of {diameter_mm} mm: choose another shaft.radius_mm"


def _describe_ring_problems(
    reducer: Reducer,
    is_ringed: bool,
    seat: float,
    rings: tuple[stock.RetainingRing | None, stock.RetainingRing | None],
    bore_room: float,
) -> Iterator[str]:
    """Yield a clause with the remedy for each reason why retaining rings do not fit.

    Parameters
    ----------
    reducer, is_ringed
        The reducer, and whether the bearings of its crank are in stock and have inner rings.
    seat
        Radius of the seat of these bearings [m].
    rings
        Retaining rings in stock for crank and cover; None if there is none of this size.
    bore_room
        Length of the cover beyond the bearing [m].
    """
    shaft, (shaft_ring, bore_ring) = reducer.design.shaft, rings
    if needs_rings(reducer):
        yield "the groove of a plastic crank is too weak: choose a metal (shaft_material.name)"
    if not is_ringed:
        yield (
            "it needs standard ball bearings on the crank, which take axial loads: choose shaft.radius_mm and "
            "shaft.bearing_width_mm of one, such as 6 and 6 for 61901"
        )
        return
    if shaft_ring is None or bore_ring is None:
        yield f"no standard ring fits {in_mm(2.0 * shaft.radius)} mm and {in_mm(2.0 * seat)} mm: choose another bearing"
        return
    if bore_ring.room > bore_room + stock.ROUNDING:
        min_offset = shaft.bearing_offset + bore_ring.room - bore_room - stock.ROUNDING
        yield f"the ring in the cover needs shaft.bearing_offset_mm = {math.ceil(1e5 * min_offset) / 100:.2f} or more"
    eye_radius, max_radius = shaft_ring.eye_radius, shoulder_radius(seat, shaft.radius)
    if eye_radius > max_radius:
        yield (
            f"the eyes of the ring on the crank need an opening of {in_mm(2.0 * eye_radius)} mm, but the shoulder of "
            f"the bearing leaves {in_mm(2.0 * max_radius)} mm: choose a bearing with a larger section"
        )
    if bore_ring.eye_radius < shaft.radius + RULES.min_wall:
        yield "the eyes of the ring in the cover leave no room for a collar of the crank: choose a larger bearing"
