"""Cranks, planets, sun and posts in the animation of an RV reducer."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import PathPatch
from matplotlib.path import Path

from cycloid_mj.base.array import Array, rotate
from cycloid_mj.base.names import CRANK, PLANET, SUN
from cycloid_mj.parts.accuracy import SCREEN_CHORD_ERROR
from cycloid_mj.parts.rv import planet_angle, rv_parts
from cycloid_mj.plots.mechanism import PART_STYLES
from cycloid_mj.reducer import RvReducer
from cycloid_mj.scene import RvDrawing

ECCENTRIC, POST = "eccentric", "post"
"""Names of drawn parts."""


def draw_rv_parts(axes: Axes, reducer: RvReducer, poses: RvDrawing) -> dict[str, list[Any]]:
    """Draw posts, eccentrics, crank journals, planets and sun, each in its own coordinates, and return their artists.

    Needles are a ring between eccentric and bore. Planets and sun, which are beside the discs, are dashed outlines.
    `poses` is the drawing of the whole animation, of which only the radii are used. The result has for each name of a
    part a list with the artists of each copy, which move together.
    """
    cranks, solids = reducer.cranks, rv_parts(reducer)
    sun, planet = (solids[name].solid(SCREEN_CHORD_ERROR).prisms[0].outline for name in (SUN, PLANET))
    planet = rotate(planet, planet_angle(reducer))
    edge_colour = PART_STYLES["shaft"]["edgecolor"]
    crank_dot = (0.0, 0.7 * reducer.journal_radius, 0.12 * reducer.journal_radius)
    return {
        POST: [
            [draw_circle(axes, (0.0, 0.0, cranks.post_radius), PART_STYLES["output"], 3.0)] for _ in range(cranks.count)
        ],
        ECCENTRIC: [
            [
                draw_circle(axes, (0.0, 0.0, poses.eccentric_radius), PART_STYLES["pins"], 3.0),
                draw_circle(axes, (0.0, 0.0, cranks.eccentric_radius), PART_STYLES["cam"], 3.1),
            ]
            for _ in range(cranks.count)
        ],
        CRANK: [
            [
                draw_circle(axes, (0.0, 0.0, reducer.journal_radius), PART_STYLES["shaft"], 3.2),
                draw_circle(axes, crank_dot, {"color": edge_colour}, 3.3),
                draw_dashed(axes, planet, edge_colour, 3.4),
            ]
            for _ in range(cranks.count)
        ],
        SUN: [[draw_dashed(axes, sun, edge_colour, 3.4)]],
    }


def move_rv_parts(move_part: Callable[[str, Any], None], poses: RvDrawing, row: int) -> None:
    """Move the parts of `draw_rv_parts` to picture `row`; `move_part` moves the copies of a part, by name, to poses."""
    move_part(POST, poses.posts[row])
    move_part(ECCENTRIC, poses.eccentrics[row])
    move_part(CRANK, poses.cranks[row])
    move_part(SUN, [poses.sun[row]])


def draw_dashed(axes: Axes, outline: Array, colour: str, order: float = 1.6) -> Any:
    """Draw an outline [m], shape (n, 2), as a dashed line at a drawing order, and return its patch."""
    style = {"facecolor": "none", "edgecolor": colour, "linestyle": (0, (4, 2)), "zorder": order}
    return axes.add_patch(PathPatch(closed_path([outline]), linewidth=0.5, **style))


def closed_path(rings: Sequence[Array]) -> Path:
    """Return closed rings of points [m], shape (n, 2) each, as a path in mm."""
    return Path.make_compound_path(*(Path(1e3 * np.vstack([ring, ring[:1]]), closed=True) for ring in rings))


def draw_circle(axes: Axes, circle: tuple[float, float, float], patch_style: Mapping[str, Any], order: float) -> Any:
    """Draw a filled circle of x, y and radius [m] at a drawing order, and return its patch."""
    x, y, radius = (1e3 * length for length in circle)
    return axes.add_patch(PathPatch(Path.circle((x, y), radius), linewidth=0.6, zorder=order, **patch_style))
