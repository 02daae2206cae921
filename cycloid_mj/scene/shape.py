"""Meshes and colours of the parts for viewers."""

from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.names import HOUSING, OUTPUT, SHAFT, family, gears
from cycloid_mj.parts import Mesh, Solid, attached_parts, mesh, parts
from cycloid_mj.parts.parts import COLOURS as SOLID
from cycloid_mj.parts.parts import Colour, tint
from cycloid_mj.reducer import Reducer, RvReducer

CHORD_ERROR = 1e-5
"""Chord error of the meshes [m]."""

COLOURS: dict[str, Colour] = {**SOLID, HOUSING: (0.68, 0.71, 0.75, 1.0), "disc": (0.36, 0.62, 0.42, 0.25)}
"""Colours of the parts; the ring is lighter, as it is seen from inside, and the output disc is transparent."""


@dataclass(frozen=True)
class Piece:
    """A piece of a part with a single colour."""

    name: str
    mesh: Mesh
    colour: Colour


def shapes(reducer: Reducer) -> dict[str, tuple[Piece, ...]]:
    """Return the coloured meshes of all parts by name, each in the frame of the part's planar pose (x, y, angle).

    Parts are housing, shaft, cycloid discs (``gear``), output and, if the ring has pins, ``pin``. The shaft includes
    cams and spacers of a built-up crank, the output includes its rollers. If there are several cycloid discs, each is
    at its own height z. Instead of the shaft, an RV reducer has sun and crank; the crank includes its planet. The
    output disc is a transparent piece of its own, because the mechanism is seen from its side, where x points right and
    y up.
    """
    solids = parts(reducer, CHORD_ERROR)
    attached_by_body = {body: attached_parts(reducer, body) for body in (SHAFT, OUTPUT)}
    positions = {
        name: np.array([0.0, 0.0, plane])
        for name, plane in zip(gears(reducer.design.gear.discs), reducer.design.gear.disc_planes, strict=True)
    }
    pieces_by_part = {
        name: _coloured_pieces(name, solid, positions.get(name, np.zeros(3)), reducer) for name, solid in solids.items()
    }
    for body, attached_by_name in attached_by_body.items():
        pieces_by_part[body] = pieces_by_part.get(body, ()) + tuple(
            _piece(name, solids[part], position) for name, (part, position) in attached_by_name.items()
        )
    attached_names = {part for attached_by_name in attached_by_body.values() for part, _ in attached_by_name.values()}
    return {name: pieces for name, pieces in pieces_by_part.items() if pieces and name not in attached_names}


def _coloured_pieces(name: str, solid: Solid, position: Array, reducer: Reducer) -> tuple[Piece, ...]:
    """Return the coloured pieces of the `solid` of a part at a `position` [m], shape (3,).

    `name` is the name of the part. The discs and the pins of the output are separate pieces.
    """
    if name == OUTPUT and isinstance(reducer, RvReducer):
        return (Piece("carrier", mesh(solid), COLOURS["disc"]),)
    if name != OUTPUT:
        return (_piece(name, solid, position),)
    disc_prism, *other_prisms = solid.prisms
    pin_prisms, second_disc_prisms = (
        other_prisms[: reducer.design.output.pins],
        other_prisms[reducer.design.output.pins :],
    )
    disc_pieces = [
        Piece("disc", mesh(disc_prism), COLOURS["disc"]),
        *(Piece("second_disc", mesh(prism), COLOURS["disc"]) for prism in second_disc_prisms),
    ]
    return Piece("pins", mesh(Solid("output", tuple(pin_prisms), solid.density)), COLOURS[OUTPUT]), *disc_pieces


def _piece(name: str, solid: Solid, position: Array) -> Piece:
    """Return a solid as a piece at a position, shape (3,) [m]."""
    solid_mesh = mesh(solid)
    moved_mesh = Mesh(solid_mesh.vertices + position, solid_mesh.faces) if position.any() else solid_mesh
    return Piece(name, moved_mesh, tint(COLOURS[family(name)], name))
