"""What the cross-section of an RV reducer has in addition: cranks with their eccentrics and planets, posts, and sun."""

import math
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array, rotate
from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.names import PLANET, SUN
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.geometry.profile import unit
from cycloid_mj.parts.rv import planet_angle, post_centres, rv_parts
from cycloid_mj.reducer import RvReducer


def rv_section(reducer: RvReducer, chord_error: float) -> dict[str, Any]:
    """Return the parts of an RV reducer that the page draws next to ring and discs, as JSON values; y is upward.

    `chord_error` is the largest distance of a drawn chord from the outline [m].

    Returns
    -------
    dict
        ``cranks``, ``posts``: centres in the carrier at the crank angle 0 [mm]; ``eccentric_radius``, ``bore_radius``,
        ``journal_radius``, ``post_radius`` [mm]; ``sun``, ``planet``: outlines about their axes at the crank angle 0
        [mm], shape (n, 2), empty for teeth that cannot be cut; ``sun_rate``: turns of the sun per turn of the cranks,
        both against the ring.
    """
    cranks = reducer.cranks
    try:
        parts = rv_parts(reducer)
        sun, planet = (parts[name].solid(chord_error).prisms[0].outline for name in (SUN, PLANET))
        outlines = {"sun": _points(sun), "planet": _points(rotate(planet, planet_angle(reducer)))}
    except CycloidError:
        outlines = {"sun": [], "planet": []}
    return {
        "cranks": _points(_crank_centres(reducer)),
        "posts": _points(post_centres(reducer)),
        "eccentric_radius": MILLIMETRES * cranks.eccentric_radius,
        "bore_radius": MILLIMETRES * reducer.bore_radius,
        "journal_radius": MILLIMETRES * max(reducer.journal_radius, 0.0),
        "post_radius": MILLIMETRES * cranks.post_radius,
        "sun_rate": float(1 / reducer.kinematics.crank_per_sun),
        **outlines,
    }


def rv_dimensions(reducer: RvReducer) -> dict[str, float]:
    """Return the radii [m] of further circles with a dimension line, by name."""
    return {"crank circle": reducer.crank_radius, "middle hole": reducer.cranks.middle_hole_radius}


def rv_holes(reducer: RvReducer) -> list[tuple[float, Array]]:
    """Return radius [m] and centres [m], shape (n, 2), of the bores and windows of a disc."""
    return [(reducer.bore_radius, _crank_centres(reducer)), (reducer.window_radius, post_centres(reducer))]


def _crank_centres(reducer: RvReducer) -> Array:
    """Return the crank axes in the carrier [m], shape (n, 2), also for a profile that cannot be manufactured."""
    count = reducer.cranks.count
    return np.asarray(reducer.crank_radius * unit(2.0 * np.pi * np.arange(count) / count))


def _points(positions: Array) -> list[list[float]]:
    return [[x, y] for x, y in (MILLIMETRES * positions).round(5).tolist() if math.isfinite(x) and math.isfinite(y)]
