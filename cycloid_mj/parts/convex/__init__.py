"""Convex pieces for MuJoCo's collision: sliced working surfaces, CoACD for the rest, and their measured quality.

A concave flank cannot be represented exactly by a few convex bodies. The working surfaces are therefore sliced by
curvature; the material behind them carries no contact and is decomposed by CoACD.
"""

from cycloid_mj.parts.convex.bearing import gear_bore, gear_holes, pin_sockets
from cycloid_mj.parts.convex.decompose import coacd_pieces, require_convex_slices
from cycloid_mj.parts.convex.plain import Plain, plain_gear, plain_ring
from cycloid_mj.parts.convex.quality import Quality, hull_body, polygon_body, surface_quality, union_heights
from cycloid_mj.parts.convex.rest import Rest, Sector, decompose, sectors
from cycloid_mj.parts.convex.settings import CoacdSettings, ConvexSettings
from cycloid_mj.parts.convex.surface import ConvexSurface, Slice, SlicePlacement, placed_outline, prism
from cycloid_mj.parts.convex.teeth import gear_teeth, ring_lobes
from cycloid_mj.reducer import Reducer, RvReducer

__all__ = [
    "CoacdSettings",
    "ConvexSettings",
    "ConvexSurface",
    "Plain",
    "Quality",
    "Rest",
    "Sector",
    "Slice",
    "SlicePlacement",
    "coacd_pieces",
    "decompose",
    "gear_bore",
    "gear_holes",
    "gear_teeth",
    "hull_body",
    "pin_sockets",
    "placed_outline",
    "plain_gear",
    "plain_ring",
    "polygon_body",
    "prism",
    "require_convex_slices",
    "ring_lobes",
    "sectors",
    "surface_quality",
    "surfaces",
    "union_heights",
]


def surfaces(reducer: Reducer, settings: ConvexSettings) -> tuple[ConvexSurface, ...]:
    """Approximate all contact surfaces of a design by convex slices for MuJoCo: teeth, bore and holes of discs, ring.

    `settings` set the accuracy and the number of the slices. The surfaces of the ring are the lobes of an internal
    gear or the sockets of free pins; fixed pins have none. A disc whose radius deviates from that of the first disc has
    its own teeth. All discs share the bore and the holes of the first disc. Discs of an RV reducer have teeth only.

    Raises
    ------
    DesignError
        A disc is undercut, its flanks are rotated or have waves, or a slice is not convex.
    """
    ring_surfaces: tuple[ConvexSurface, ...] = ()
    if reducer.design.ring.kind == "nonpin":
        ring_surfaces = (ring_lobes(reducer, settings),)
    elif reducer.design.ring.has_sockets:
        ring_surfaces = (pin_sockets(reducer, settings),)
    errors = reducer.deviations.disc_radius
    tooth_surfaces = [
        gear_teeth(reducer, settings, disc) for disc, error in enumerate(errors) if disc == 0 or error != errors[0]
    ]
    if isinstance(reducer, RvReducer):
        return (*tooth_surfaces, *ring_surfaces)
    return (*tooth_surfaces, gear_bore(reducer, settings), gear_holes(reducer, settings), *ring_surfaces)
