"""Parts of coaxial cylinders with round holes: covers, screws, dowels, bearings, and holes added to other parts."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.design import stock
from cycloid_mj.parts import Stretch
from cycloid_mj.parts.accuracy import SAME_LENGTH
from cycloid_mj.parts.contour import CircleContour, Contour, circles_at

Round = tuple[float, float, float]
"""Radius about the axis of the part, lower and upper end along z [m]."""

Hole = tuple[Array, float, float, float]
"""Centres (n, 2), radius, lower and upper end along z [m]."""

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


def tube(bore: float, outside: float, width: float) -> RoundPart:
    """Return a bearing, drawn as one ring of two radii and a width [m], centred at z = 0."""
    half = 0.5 * width
    return RoundPart(names.SHAFT, ((outside, -half, half),), ((AXIS, bore, -half, half),), bought=True)


def screw_body(bolt: stock.Bolt, length: float) -> RoundPart:
    """Return a screw of a length [m] that points along -z, with its head above z = 0, and its thread as its core."""
    rounds = (0.5 * (bolt.thread - stock.pitch(bolt.thread)), -length, 0.0), (0.5 * bolt.head, 0.0, bolt.head_height)
    return RoundPart(names.SHAFT, rounds, bought=True)


def dowel_body(dowel: stock.Dowel) -> RoundPart:
    """Return a dowel, centred at z = 0."""
    half = 0.5 * dowel.length
    return RoundPart(names.PIN, ((0.5 * dowel.diameter, -half, half),), bought=True)


def with_holes(name: str, part: RoundPart, base: Sequence[Stretch] = ()) -> tuple[Stretch, ...]:
    """Return the stretches of a round part, after those of a `base` part; its holes are cut into both.

    The stretches end at all faces of the part and of its holes.
    """
    rounds = ((CircleContour(radius), z0, z1) for radius, z0, z1 in part.rounds)
    shells = [*base, *(Stretch(name, contour, (), z0, z1) for contour, z0, z1 in (*rounds, *part.blocks))]
    ends = [(shell.z0, shell.z1) for shell in shells] + [(start, end) for _, _, start, end in part.holes]
    faces = sorted({z for pair in ends for z in pair})
    stretches = []
    for shell in shells:
        inner_faces = [z for z in faces if shell.z0 + SAME_LENGTH < z < shell.z1 - SAME_LENGTH]
        for low, high in pairwise([shell.z0, *inner_faces, shell.z1]):
            if high - low < SAME_LENGTH:
                continue
            through = [
                hole
                for centres, radius, start, end in part.holes
                if start < 0.5 * (low + high) < end
                for hole in circles_at(radius, centres)
            ]
            stretches.append(Stretch(shell.name, shell.outline, (*shell.holes, *through), low, high))
    return tuple(stretches)
