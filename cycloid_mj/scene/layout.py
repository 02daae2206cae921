"""A layout for Foxglove and Lichtblick: their own 3-D view starts 20 m away and cuts off what is nearer than 0.5 m."""

from collections.abc import Iterable
from typing import Any

from cycloid_mj.design import Design
from cycloid_mj.names import GEAR, HOUSING, OUTPUT, SHAFT, pin
from cycloid_mj.scene.messages import FORCES, PARTS, ROOT

MECHANISM = "3D!mechanism"
SLOW = 0.01
"""Playback speed: a crank at 1640 rpm then turns once in 4 s."""

PLOTS = (
    ("speed", ("/reducer.gear_speed", "/reducer.output_speed")),
    ("torque", ("/reducer.crank_torque", "/reducer.load_torque")),
    ("force", ("/reducer.peak_force",)),
)


def layout(design: Design) -> dict[str, Any]:
    """Give the layout that these viewers import as JSON: the mechanism from the output side, and three plots."""
    plots = {f"Plot!{name}": _plot(paths) for name, paths in PLOTS}
    return {
        "configById": {MECHANISM: _mechanism(design), **plots},
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": SLOW},
        "layout": {"direction": "row", "first": MECHANISM, "second": _column(list(plots)), "splitPercentage": 55},
    }


def _mechanism(design: Design) -> dict[str, Any]:
    reach = design.housing.outer_radius
    pins = [pin(number + 1) for number in range(design.ring.teeth)] if design.ring.kind == "pin" else []
    camera = {
        "perspective": True,
        "distance": 4.0 * reach,
        "phi": 25.0,
        "thetaOffset": 0.0,
        "target": [0.0, 0.0, 0.0],
        "targetOffset": [0.0, 0.0, 0.0],
        "targetOrientation": [0.0, 0.0, 0.0, 1.0],
        "fovy": 45.0,
        "near": 0.02 * reach,
        "far": 100.0 * reach,
    }
    return {
        "cameraState": camera,
        "followTf": ROOT,
        "followMode": "follow-pose",
        "scene": {"backgroundColor": "#ffffff", "transforms": {"showLabel": False, "axisScale": 0.0, "lineWidth": 0.0}},
        "transforms": _hidden([ROOT, HOUSING, SHAFT, GEAR, OUTPUT, *pins]),
        "topics": {topic: {"visible": True} for topic in (PARTS, FORCES)},
        "layers": {},
        "imageMode": {},
    }


def _hidden(frames: Iterable[str]) -> dict[str, Any]:
    return {f"frame:{frame}": {"visible": False} for frame in frames}


def _plot(paths: Iterable[str]) -> dict[str, Any]:
    return {
        "paths": [{"value": path, "enabled": True, "timestampMethod": "receiveTime"} for path in paths],
        "showXAxisLabels": True,
        "showYAxisLabels": True,
        "showLegend": True,
        "legendDisplay": "floating",
        "showPlotValuesInLegend": True,
        "isSynced": True,
        "xAxisVal": "timestamp",
        "sidebarDimension": 240,
    }


def _column(panels: list[str]) -> Any:
    """Stack panels of equal height."""
    first, *others = panels
    if not others:
        return first
    return {
        "direction": "column",
        "first": first,
        "second": _column(others),
        "splitPercentage": 100 / len(panels),
    }
