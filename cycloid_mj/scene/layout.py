"""A layout for Foxglove and Lichtblick: their own 3-D view starts 20 m away and cuts off what is nearer than 0.5 m."""

import json
from importlib.resources import files
from typing import Any

from cycloid_mj.base.names import HOUSING, OUTPUT, PIN, SHAFT, all_numbered, gears, planar_speeds
from cycloid_mj.reducer import Reducer
from cycloid_mj.scene.messages import ROOT

DISTANCE, NEAREST, FARTHEST = 4.0, 0.02, 100.0
"""Of the camera, and of what it sees, as multiples of the housing's radius."""


def layout(reducer: Reducer) -> dict[str, Any]:
    """Collect the layout that these viewers import as JSON: the mechanism from the output side, and three plots.

    ``assets/layout.json`` has what all designs share. A crank at 1640 rpm turns once in 4 s at its playback speed.
    """
    design = reducer.design
    content: dict[str, Any] = json.loads(files("cycloid_mj.scene").joinpath("assets", "layout.json").read_text("utf-8"))
    view, reach = content["configById"]["3D!mechanism"], design.housing.outer_radius
    view["cameraState"] |= {"distance": DISTANCE * reach, "near": NEAREST * reach, "far": FARTHEST * reach}
    pins = all_numbered(PIN, design.ring.mates) if design.ring.kind == "pin" else ()
    frames = (ROOT, HOUSING, SHAFT, *gears(design.gear.discs), OUTPUT, *pins)
    plot = content["configById"]["Plot!speed"]
    of_gear, *others = plot["paths"]
    discs = [of_gear | {"value": f"/reducer.{planar_speeds(gear)[2]}"} for gear in gears(design.gear.discs)]
    plot["paths"] = [*discs, *others]
    view["transforms"] = {f"frame:{frame}": {"visible": False} for frame in frames}
    return content
