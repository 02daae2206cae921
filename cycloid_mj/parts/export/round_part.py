"""Parts of coaxial cylinders with round holes: covers, screws, dowels, bearings, and holes added to other parts."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.design import stock
from cycloid_mj.parts import Segment
from cycloid_mj.parts.accuracy import SAME_LENGTH
from cycloid_mj.parts.contour import CircleContour, Contour, circle_of, circles_at
from cycloid_mj.parts.curve import Circle

Round = tuple[float, float, float]
"""Radius about the axis of the part, lower and upper end along z [m]."""

Hole = tuple[Array, float, float, float]
"""Centres (n, 2), radius, lower and upper end along z [m]."""

Pocket = tuple[float, float, float, float]
"""An annular pocket about the axis: outer and inner radius, lower and upper end along z [m]."""

AXIS = np.zeros((1, 2))
"""Centre of a hole on the axis [m]."""


@dataclass(frozen=True, eq=False)
class RoundPart:
    """A part of cylinders with round holes, or the holes that a part of the mechanism has in addition.

    Attributes
    ----------
    material
        Part of the mechanism whose material it has.
    rounds
        Its cylinders about its axis.
    holes
        Its holes, with axes along z.
    pockets
        Its annular pockets, around a boss; a hole is in the boss or in the wall.
    blocks
        Its sections of other outlines: contour, lower and upper end along z [m].
    bought
        True for a bought part; it is drawn in a frame of its own.
    """

    material: str
    rounds: tuple[Round, ...] = ()
    holes: tuple[Hole, ...] = ()
    blocks: tuple[tuple[Contour, float, float], ...] = ()
    bought: bool = False
    pockets: tuple[Pocket, ...] = ()


def tube(bore: float, outside: float, width: float) -> RoundPart:
    """Return a bought ring (bearing, roller, washer or insert) of two radii and a width [m], centred at z = 0."""
    half_width = 0.5 * width
    return RoundPart(
        names.SHAFT, ((outside, -half_width, half_width),), ((AXIS, bore, -half_width, half_width),), bought=True
    )


def screw_body(bolt: stock.Bolt, length: float) -> RoundPart:
    """Return a screw of a length [m] that points along -z, with its head above z = 0, and its thread as its core."""
    rounds = (0.5 * stock.thread_core(bolt.thread), -length, 0.0), (0.5 * bolt.head, 0.0, bolt.head_height)
    return RoundPart(names.SHAFT, rounds, bought=True)


def dowel_body(dowel: stock.Dowel) -> RoundPart:
    """Return a dowel, centred at z = 0."""
    half_length = 0.5 * dowel.length
    return RoundPart(names.PIN, ((0.5 * dowel.diameter, -half_length, half_length),), bought=True)


def cut_holes(name: str, part: RoundPart, base_segments: Sequence[Segment] = ()) -> tuple[Segment, ...]:
    """Join the cylinders and blocks of `part` to `base_segments`, and cut its holes and pockets into all of them.

    The result has the segments of both, divided along z at each face of the part, of its holes and of its pockets; new
    segments have the name `name`.
    """
    rounds = ((CircleContour(radius), z0, z1) for radius, z0, z1 in part.rounds)
    shells = [*base_segments, *(Segment(name, contour, (), z0, z1) for contour, z0, z1 in (*rounds, *part.blocks))]
    ends = [(shell.z0, shell.z1) for shell in shells]
    ends += [(start, end) for *_, start, end in (*part.holes, *part.pockets)]
    faces = sorted({z for pair in ends for z in pair})
    segments: list[Segment] = []
    for shell in shells:
        inner_faces = [z for z in faces if shell.z0 + SAME_LENGTH < z < shell.z1 - SAME_LENGTH]
        for z_start, z_end in pairwise([shell.z0, *inner_faces, shell.z1]):
            if z_end - z_start < SAME_LENGTH:
                continue
            through_holes = [
                hole
                for centres, radius, start, end in part.holes
                if start < 0.5 * (z_start + z_end) < end
                for hole in circles_at(radius, centres)
            ]
            piece = Segment(shell.name, shell.outline, (*shell.holes, *through_holes), z_start, z_end)
            pocket = next(
                (candidate for candidate in part.pockets if candidate[2] < 0.5 * (z_start + z_end) < candidate[3]), None
            )
            segments += _split_pocket(piece, pocket) if pocket else [piece]
    return tuple(segments)


def _split_pocket(segment: Segment, pocket: Pocket) -> Iterator[Segment]:
    """Yield the segments that remain after an annular pocket is cut: the wall outside and the boss inside of it."""
    outer_radius, inner_radius, *_ = pocket
    circles = [hole for contour in segment.holes if (hole := circle_of(contour))]
    wall_holes = [hole for hole in circles if math.hypot(*hole.centre) - hole.radius > outer_radius]
    boss_holes = [hole for hole in circles if math.hypot(*hole.centre) + hole.radius < inner_radius]
    yield replace(segment, holes=(*_contours(wall_holes), CircleContour(outer_radius)))
    yield replace(segment, outline=CircleContour(inner_radius), holes=_contours(boss_holes))


def _contours(circles: Iterable[Circle]) -> tuple[CircleContour, ...]:
    return tuple(CircleContour(circle.radius, circle.centre) for circle in circles)
