"""Layout for Foxglove and Lichtblick, whose default 3-D view is 20 m away and hides everything nearer than 0.5 m."""

import json
from importlib.resources import files
from typing import Any

from cycloid_mj.base.names import HOUSING, OUTPUT, PIN, SHAFT, SUN, all_numbered, column, gears, planar_speeds
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.reducer.rv_bodies import crank_names
from cycloid_mj.scene.messages import ROOT

DISTANCE, NEAREST, FARTHEST = 4.0, 0.02, 100.0
"""Distances of the camera and of its clipping planes, as multiples of the housing's radius."""


def viewer_layout(reducer: Reducer) -> dict[str, Any]:
    """Return the layout that Foxglove and Lichtblick import from JSON: a view of the mechanism, and three plots.

    The result is a dict of JSON values. It is made from ``assets/layout.json``. At its playback speed, a crank at 1640
    rpm turns once in 4 s.
    """
    design = reducer.design
    content: dict[str, Any] = json.loads(files("cycloid_mj.scene").joinpath("assets", "layout.json").read_text("utf-8"))
    view, housing_radius = content["configById"]["3D!mechanism"], design.housing.outer_radius
    view["cameraState"] |= {
        "distance": DISTANCE * housing_radius,
        "near": NEAREST * housing_radius,
        "far": FARTHEST * housing_radius,
    }
    pin_names = all_numbered(PIN, design.ring.mate_count) if design.ring.kind == "pin" else ()
    shaft_names = (SUN, *crank_names(reducer)) if isinstance(reducer, RvReducer) else (SHAFT,)
    frames = (ROOT, HOUSING, *shaft_names, *gears(design.gear.discs), OUTPUT, *pin_names)
    plot = content["configById"]["Plot!speed"]
    disc_path, *other_paths = plot["paths"]  # one path is repeated for each disc
    disc_paths = [disc_path | {"value": f"/reducer.{planar_speeds(gear)[2]}"} for gear in gears(design.gear.discs)]
    plot["paths"] = [*disc_paths, *other_paths]
    torque_path, *_ = content["configById"]["Plot!torque"]["paths"]
    torque_path["value"] = f"/reducer.{column(reducer.INPUT, 'torque')}"
    view["transforms"] = {f"frame:{frame}": {"visible": False} for frame in frames}
    return content
