"""The assembly as triangles for the 3-D view of the page: position, colour and motion of each part."""

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
"""Body -> what it moves with. Discs orbit with a phase each; other bodies are fixed."""


def assembly(reducer: Reducer) -> dict[str, Any]:
    """Return the meshes of all bodies and the rates of their motion, in JSON values.

    Corners of triangles are float32 [mm] in base64, shape (triangles, 3, 3); ``gear_rate`` is in turns per crank turn.
    """
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
                    "corners": _base64(corners),
                    "places": np.round(MILLIMETRES * places, 4).tolist(),
                }
            )
    return {"bodies": bodies, "orbit": MILLIMETRES * design.gear.eccentricity, "gear_rate": -1.0 / design.lobes}


def _base64(corners: Array) -> str:
    """Encode corners [m] as float32 in millimetres."""
    return base64.b64encode((MILLIMETRES * corners).astype("<f4").tobytes()).decode()
