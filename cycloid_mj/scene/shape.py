"""How the parts look: the pieces of each, with their colours."""

from dataclasses import dataclass

from cycloid_mj.design import Design
from cycloid_mj.names import OUTPUT
from cycloid_mj.solid import Mesh, Solid, mesh, parts

Colour = tuple[float, float, float, float]
"""Red, green, blue and opacity from 0 to 1, as a screen shows them (sRGB)."""

CHORD_ERROR = 1e-5
"""Largest distance of a drawn chord from its curve [m]."""

COLOURS: dict[str, Colour] = {
    "housing": (0.68, 0.71, 0.75, 1.0),
    "shaft": (0.80, 0.62, 0.25, 1.0),
    "gear": (0.25, 0.47, 0.70, 1.0),
    "pin": (0.83, 0.84, 0.86, 1.0),
    "output": (0.36, 0.62, 0.42, 1.0),
    "disc": (0.36, 0.62, 0.42, 0.25),
}


@dataclass(frozen=True)
class Piece:
    """A piece of a part that has one colour."""

    name: str
    mesh: Mesh
    colour: Colour


def shapes(design: Design) -> dict[str, tuple[Piece, ...]]:
    """Give housing, shaft, gear, pin (where the ring has pins) and output, each in its own frame.

    The disc of the output is a piece of its own that can be seen through: the mechanism is looked at from its side,
    where x points right and y up.

    Raises
    ------
    DesignError
        A part of the design cannot be made.
    """
    return {name: _pieces(name, solid) for name, solid in parts(design, CHORD_ERROR).items()}


def _pieces(name: str, solid: Solid) -> tuple[Piece, ...]:
    if name != OUTPUT:
        return (Piece(name, mesh(solid), COLOURS[name]),)
    disc, *pins = solid.prisms
    return (
        Piece("pins", mesh(Solid("output", tuple(pins), solid.density)), COLOURS[OUTPUT]),
        Piece("disc", mesh(disc), COLOURS["disc"]),
    )
