"""How the parts look: the pieces of each, with their colours."""

from dataclasses import dataclass

import numpy as np

from cycloid_mj.design import Design
from cycloid_mj.names import OUTPUT, SHAFT, family, gears
from cycloid_mj.solid import Mesh, Solid, carried, mesh, parts
from cycloid_mj.solid.tint import Colour, tinted

CHORD_ERROR = 1e-5
"""Largest distance of a drawn chord from its curve [m]."""

COLOURS: dict[str, Colour] = {
    "housing": (0.68, 0.71, 0.75, 1.0),
    "shaft": (0.80, 0.62, 0.25, 1.0),
    "gear": (0.25, 0.47, 0.70, 1.0),
    "pin": (0.83, 0.84, 0.86, 1.0),
    "output": (0.36, 0.62, 0.42, 1.0),
    "cam": (0.90, 0.72, 0.36, 1.0),
    "spacer": (0.62, 0.52, 0.34, 1.0),
    "disc": (0.36, 0.62, 0.42, 0.25),
}


@dataclass(frozen=True)
class Piece:
    """A piece of a part that has one colour."""

    name: str
    mesh: Mesh
    colour: Colour


def shapes(design: Design) -> dict[str, tuple[Piece, ...]]:
    """Give housing, shaft, gears, pin (where the ring has pins) and output, each in the frame of its pose in the plane.

    The disc of the output is a piece of its own that can be seen through: the mechanism is looked at from its side,
    where x points right and y up. A built-up crank is the shaft with its cams and spacers; several discs stand in their
    planes.

    Raises
    ------
    DesignError
        A part of the design cannot be made.
    """
    found, on_crank = parts(design, CHORD_ERROR), carried(design)
    planes = dict(zip(gears(design.gear.discs), design.gear.disc_planes, strict=True))
    seen = {name: _pieces(name, solid, planes.get(name, 0.0), design) for name, solid in found.items()}
    for part in {part for part, _ in on_crank.values()}:
        del seen[part]
    crank = [_piece(name, found[part], z) for name, (part, z) in on_crank.items()]
    return seen | {SHAFT: (*seen[SHAFT], *crank)}


def _pieces(name: str, solid: Solid, z: float, design: Design) -> tuple[Piece, ...]:
    if name != OUTPUT:
        return (_piece(name, solid, z),)
    disc, *others = solid.prisms
    pins, second = others[: design.output.pins], others[design.output.pins :]
    discs = [
        Piece("disc", mesh(disc), COLOURS["disc"]),
        *(Piece("second_disc", mesh(one), COLOURS["disc"]) for one in second),
    ]
    return Piece("pins", mesh(Solid("output", tuple(pins), solid.density)), COLOURS[OUTPUT]), *discs


def _piece(name: str, solid: Solid, z: float) -> Piece:
    """Give a solid as a piece, up z by some metres."""
    shape = mesh(solid)
    raised = Mesh(shape.vertices + np.array([0.0, 0.0, z]), shape.faces) if z else shape
    return Piece(name, raised, tinted(COLOURS[family(name)], name))
