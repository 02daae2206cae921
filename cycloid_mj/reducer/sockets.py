"""Sockets of the ring pins in the pinwheel: one definition for parts, contact, meshes and drawings.

The wall between neighbouring sockets is a circle about the reducer's axis. Sockets end there in an
edge, beyond which a pin can be in contact with the disc only.
"""

import math
from typing import TYPE_CHECKING

from cycloid_mj.base.errors import DesignError
from cycloid_mj.design import Design

if TYPE_CHECKING:
    from cycloid_mj.reducer.reducer import Reducer

WALL_GAP = 0.1
"""Smallest gap between the lobe tips and the wall, as a share of rho - c (heuristic)."""


def wall_radius(design: Design) -> float:
    """Compute the inner radius [m] of the wall between sockets, at least the radius of the pin circle.

    With the pin circle radius E, pin radius rho and eccentricity c, the tips of the disc's lobes reach E - rho + 2c
    from the reducer's axis, and the sockets reach E + rho. So there is room for a wall if c is less than rho. The gap
    between wall and tips is at least `WALL_GAP` times rho - c.
    """
    pin_circle_radius, pin_radius, eccentricity = (
        design.ring.pin_circle_radius,
        design.ring.pin_radius,
        design.gear.eccentricity,
    )
    return max(
        pin_circle_radius, pin_circle_radius - pin_radius + 2.0 * eccentricity + WALL_GAP * (pin_radius - eccentricity)
    )


def arc_half_angle(design: Design, radius: float) -> float:
    """Compute half the angle [rad] of the arc of a pin-centred circle that lies in the wall between sockets.

    The arc is symmetric to the direction away from the reducer's axis. `radius` [m] is that of the circle. The result
    is 0 if the entire circle is inside the wall's inner radius.
    """
    pin_circle_radius, inner_radius = design.ring.pin_circle_radius, wall_radius(design)
    cosine = (inner_radius**2 - pin_circle_radius**2 - radius**2) / (2.0 * pin_circle_radius * radius)
    return math.acos(min(1.0, max(-1.0, cosine)))


def socket_half_angle(design: Design) -> float:
    """Return half of the angle [rad] over which the socket supports a free pin: pi for closed sockets."""
    if design.ring.socket == "closed":
        return math.pi
    return arc_half_angle(design, design.ring.pin_radius + design.clearance.pin_socket)


def is_drawn(design: Design) -> bool:
    """Return whether the design has solids of its parts: not with closed sockets, or with a ring in two halves."""
    return design.ring.halves == 1 and not (design.ring.has_sockets and design.ring.socket == "closed")


def require_open_sockets(design: Design, feature: str) -> None:
    """Raise DesignError if free ring pins sit in closed sockets: their parts have no solids.

    Open sockets are half-round grooves in the wall of the ring. Closed sockets are bores in end plates, which the tool
    cannot generate as solids. `feature` is the name of the feature that needs the solids, for the message.

    Raises
    ------
    DesignError
        The design has closed sockets.
    """
    if design.ring.has_sockets and design.ring.socket == "closed":
        raise DesignError(
            f'{design.name}: ring.socket = "closed" cannot be combined with {feature}, because closed sockets are '
            'bores in end plates, whose solids cannot be generated. Set ring.socket = "half_open"'
        )


def require_one_ring(reducer: "Reducer", feature: str) -> None:
    """Raise DesignError if the ring of a design is in two halves, for a `feature` that supports an undivided ring only.

    `feature` is its name in the message.
    """
    design = reducer.design
    if design.ring.halves > 1:
        raise DesignError(
            f"{design.name}: a split ring (ring.halves = {design.ring.halves}) cannot be combined with {feature}. Set "
            "ring.halves = 1 and ring.preload_arcmin = 0"
        )
