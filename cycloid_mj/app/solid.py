"""The reducer put together as triangles, for the page to turn: each part where it stands, with its colour."""

import base64
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.names import OUTPUT, PIN, SHAFT, gears
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.reducer import Reducer
from cycloid_mj.scene import ring_places
from cycloid_mj.scene.shape import shapes

MOVES = {SHAFT: "crank", OUTPUT: "output"}
"""Body -> what it moves with; discs move each with its own phase, others stand."""


def assembly(reducer: Reducer) -> dict[str, Any]:
    """Build the meshes of all bodies: float32 corners of triangles [mm] in base64, colour, how the body moves."""
    design, bodies = reducer.design, list[dict[str, Any]]()
    phases = dict(zip(gears(design.gear.discs), map(float, reducer.phases), strict=True))
    for name, pieces in shapes(reducer).items():
        places = ring_places(reducer) if name == PIN else np.zeros((1, 2))
        for piece in pieces:
            corners = piece.mesh.vertices[piece.mesh.faces].reshape(-1, 3)
            bodies.append(
                {
                    "name": name,
                    "moves": "disc" if name in phases else MOVES.get(name, ""),
                    "phase": phases.get(name, 0.0),
                    "colour": list(piece.colour),
                    "corners": _packed(corners),
                    "places": np.round(MILLIMETRES * places, 4).tolist(),
                }
            )
    return {"bodies": bodies, "orbit": MILLIMETRES * design.gear.eccentricity, "gear_rate": -1.0 / design.lobes}


def _packed(corners: Array) -> str:
    return base64.b64encode((MILLIMETRES * corners).astype("<f4").tobytes()).decode()
