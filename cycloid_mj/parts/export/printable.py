"""Printability: warnings of thin walls, small holes and overhangs, and a test coupon for the printer offset."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.parts import Prism, Solid, circle
from cycloid_mj.parts.accuracy import SAME_LENGTH
from cycloid_mj.parts.export.casing import (
    Casing,
)
from cycloid_mj.parts.export.casing_rules import (
    RULES,
    is_printed,
)
from cycloid_mj.parts.export.printing import material_part, printed_parts
from cycloid_mj.reducer import Reducer

MIN_HOLE = 2.0e-3
"""Diameter below which printed holes close (assumed) [m]."""


@dataclass(frozen=True)
class Coupon:
    """Test print of the clearance of a pin in a socket; lengths in metres."""

    clearances: tuple[float, ...] = (50e-6, 100e-6, 200e-6)  # clearances of the sockets around the pin
    pin_radius: float = 4e-3  # radius of the pin
    height: float = 8e-3  # height of the block; the pin has twice that
    wall: float = 4e-3  # wall around the sockets
    mark_radius: float = 0.8e-3  # radius of the holes that mark the sockets


COUPON = Coupon()


def coupon_solids(chord_error: float) -> dict[str, Solid]:
    """Return the test print of clearances: a block with a socket for each of `COUPON.clearances`, and its pin.

    The number of small holes next to a socket is its number from 1. The keys are ``coupon_block`` and ``coupon_pin``.
    `chord_error` [m] is the largest distance of a chord from its circle.
    """
    pitch = 2.0 * (COUPON.pin_radius + COUPON.wall)
    length, depth = pitch * len(COUPON.clearances), pitch + 4.0 * COUPON.mark_radius
    corners = np.array([[0.0, 0.0], [length, 0.0], [length, depth], [0.0, depth]])
    holes: list[Array] = []
    for socket_index, clearance in enumerate(COUPON.clearances):
        x, y = (socket_index + 0.5) * pitch, 0.5 * pitch
        holes.append(circle(COUPON.pin_radius + clearance, chord_error, (x, y)))
        for mark_index in range(socket_index + 1):
            holes.append(
                circle(
                    COUPON.mark_radius,
                    chord_error,
                    (x + 4.0 * COUPON.mark_radius * (mark_index - 0.5 * socket_index), pitch),
                )
            )
    block = Prism(corners, tuple(holes), 0.0, COUPON.height)
    pin = Prism(circle(COUPON.pin_radius, chord_error), (), 0.0, 2.0 * COUPON.height)
    return {name: Solid(name, (item,), 1.0) for name, item in (("coupon_block", block), ("coupon_pin", pin))}


def coupon_words() -> str:
    """Return instructions for using the fit of the coupon in an export."""
    sizes = ", ".join(f"{number} {1e6 * clearance:g}" for number, clearance in enumerate(COUPON.clearances, start=1))
    return (
        "coupon: print coupon_block and coupon_pin; the number of marks at the first socket in which the pin turns "
        f"determines --offset-um: {sizes}"
    )


def print_warnings(
    reducer: Reducer, unsupported_areas: Mapping[str, Mapping[float, float]], chord_error: float, casing: Casing | None
) -> Iterator[str]:
    """Yield a warning for each plastic part with thin walls, small holes, or faces without a support, as printed.

    The limits are `RULES.min_printed_wall` and `MIN_HOLE`. `unsupported_areas` are the areas of faces that cannot have
    a support [m2], as a mapping from part to a mapping from the height [m] of the faces to their area. `chord_error`
    [m] is the largest distance of a chord from its curve. The printed parts of the `casing` are included; None: the
    mechanism only.
    """
    for name, part in printed_parts(reducer, chord_error, 0.0, casing).items():
        if not is_printed(reducer, material_part(reducer, name)):
            continue
        wall_thickness = min(map(thinnest_wall, part.solid.prisms))
        if wall_thickness < RULES.min_printed_wall - SAME_LENGTH:
            min_wall = MILLIMETRES * RULES.min_printed_wall
            yield f"{name} has a wall of {MILLIMETRES * wall_thickness:.2g} mm; one prints from {min_wall:g} mm on"
        holes = (hole for prism in part.solid.prisms for hole in prism.holes)
        hole_diameter = min((float(np.ptp(hole, axis=0).min()) for hole in holes), default=np.inf)
        if hole_diameter < MIN_HOLE:
            yield (
                f"{name} has a hole of {MILLIMETRES * hole_diameter:.3g} mm; drill those below "
                f"{MILLIMETRES * MIN_HOLE:g} mm"
            )
        if faces := unsupported_areas.get(name):
            areas = ", ".join(f"{1e6 * area:.0f} mm2 at {MILLIMETRES * z:.3g} mm" for z, area in faces.items())
            yield f"{name} needs the slicer's supports, as it lies: {areas}"


def thinnest_wall(prism: Prism) -> float:
    """Measure the smallest distance between outline and holes of a prism, on their points [m]; inf without holes."""
    from scipy.spatial import cKDTree

    pairs = combinations((prism.outline, *prism.holes), 2)
    return min((float(np.min(cKDTree(loop).query(other_loop)[0])) for loop, other_loop in pairs), default=np.inf)
