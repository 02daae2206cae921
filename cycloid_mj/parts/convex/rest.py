"""The material behind the working surfaces, by sectors: CoACD decomposes one sector, which is repeated."""

import math
from dataclasses import dataclass, replace

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.names import SPACER, family
from cycloid_mj.geometry.profile import unit
from cycloid_mj.parts import Mesh, Prism, circle, mesh, output_solid, shaft_segments
from cycloid_mj.parts.convex.decompose import coacd_pieces
from cycloid_mj.parts.convex.measure import pieces_quality, wall_samples
from cycloid_mj.parts.convex.quality import Quality, require_within
from cycloid_mj.parts.convex.settings import METHOD, ConvexSettings
from cycloid_mj.parts.convex.teeth import gear_base, ring_base
from cycloid_mj.parts.convex.walls import gear_depth, housing_depth
from cycloid_mj.parts.polygon import arc
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.sockets import arc_half_angle, wall_radius


@dataclass(frozen=True)
class Sector:
    """The sector on +y of `count` equal sectors of a part about z, in the frame of the part.

    Its pieces may deviate by `bound` [m], the depth of the slices before it, so that they do not protrude. All discs
    have the sectors of the first disc; those `of_teeth` rotate with their teeth.
    """

    part: str
    region: Prism
    bound: float
    count: int = 1
    of_teeth: bool = False


@dataclass(frozen=True)
class Rest:
    """A sector as convex pieces, with their quality."""

    sector: Sector
    pieces: tuple[Mesh, ...]
    quality: Quality


def sectors(reducer: Reducer, settings: ConvexSettings) -> tuple[Sector, ...]:
    """Return sectors of disc, housing, shaft and output that represent the material behind their contact surfaces.

    A sector, repeated around the axis, fills a part up to the convex slices of its contact surfaces (`surfaces`).
    `settings` are the settings of these slices. Spacers and output pins have no sectors. A bore through the shaft is
    filled, because nothing touches it.
    """
    chord_error = settings.rest_chord_error
    max_deviation = settings.depth * reducer.design.ring.pin_radius
    segments = [segment for name, segment in shaft_segments(reducer, chord_error).items() if family(name) != SPACER]
    shaft_sectors = [
        Sector("shaft", replace(segment, holes=()).prism(chord_error), max_deviation) for segment in segments
    ]
    disc, *other_prisms = output_solid(reducer, chord_error).prisms
    output_sectors = [Sector("output", disc, max_deviation)]
    for plate in other_prisms[reducer.design.output.pins :]:
        inner_radius, outer_radius = (
            float(np.linalg.norm(polygon, axis=1).max()) for polygon in (plate.holes[0], plate.outline)
        )
        # so narrow that its inner arc is as good as straight
        count = math.ceil(math.pi / math.acos(max(1.0 - 0.5 * max_deviation / inner_radius, 0.0)))
        wedge = Prism(_ring_sector(inner_radius, outer_radius, math.pi / count, chord_error), (), plate.z0, plate.z1)
        output_sectors.append(Sector("output", wedge, max_deviation, count))
    return (*_gear_sectors(reducer, settings), _housing_sector(reducer, settings), *shaft_sectors, *output_sectors)


def decompose(sector: Sector, settings: ConvexSettings) -> Rest:
    """Decompose a sector of a part into convex pieces by CoACD; return the pieces and their deviations.

    CoACD's threshold is halved as long as the pieces protrude by more than the bound of the sector, at most
    `METHOD.decompositions` - 1 times. `settings` include the parameters of CoACD.

    Raises
    ------
    DesignError
        The pieces deviate by more than the bound of the sector.
    """
    shape, walls, coacd = mesh(sector.region), wall_samples(sector.region), settings.coacd
    for _ in range(METHOD.decompositions):
        pieces = coacd_pieces(shape, coacd)
        quality = pieces_quality(sector.region, pieces, *walls)
        if quality.max_overfill <= sector.bound:
            break
        coacd = replace(coacd, threshold=0.5 * coacd.threshold)
    require_within(sector.part, quality, sector.bound, sector.bound)
    return Rest(sector, pieces, quality)


def _gear_sectors(reducer: Reducer, settings: ConvexSettings) -> tuple[Sector, Sector]:
    """Return two sectors that fill a disc between the slices of its surfaces if they are repeated around the axis.

    `settings` set the accuracy and the number of the slices.

    Returns
    -------
    tuple of Sector
        The hub sector with one output hole, and the sector of the outer band below one valley of the teeth.

    Raises
    ------
    DesignError
        The slices of the teeth reach into the material around the output holes.
    """
    design = reducer.design
    depth, chord_error, output = gear_depth(reducer, settings), settings.rest_chord_error, design.output
    half_width = design.gear.face_width / 2.0
    hole_radius = output.hole_radius + design.clearance.output + depth
    base_outline = gear_base(reducer, depth, chord_error)
    mid_radius = 0.5 * (output.pin_circle_radius + hole_radius + float(np.linalg.norm(base_outline, axis=1).min()))
    inner_radius = design.gear.bore_radius + design.clearance.cam + depth
    hole_outline = circle(hole_radius, chord_error, (0.0, output.pin_circle_radius))
    hub = Prism(
        _ring_sector(inner_radius, mid_radius, math.pi / output.pins, chord_error),
        (hole_outline,),
        -half_width,
        half_width,
    )
    half_pitch = math.pi / design.lobes
    edge_radius = float(np.sum(base_outline[-1] * unit(half_pitch)))
    if edge_radius <= mid_radius:
        raise DesignError(
            f"the convex pieces of the disc cannot be generated: with ring.teeth = {design.ring.teeth}, the pieces of "
            f"the teeth reach inwards to a radius of {1e3 * edge_radius:.4g} mm, but the material around the output "
            f"holes reaches outwards to {1e3 * mid_radius:.4g} mm. Increase ring.teeth, or reduce "
            "output.pin_circle_radius_mm or output.hole_radius_mm"
        )
    outer_outline = np.concatenate([edge_radius * unit([-half_pitch]), base_outline, edge_radius * unit([half_pitch])])
    inner_arc = _arc(mid_radius, -half_pitch, half_pitch, chord_error)
    band = Prism(np.concatenate([outer_outline, inner_arc[::-1]])[::-1], (), -half_width, half_width)
    return Sector("gear", hub, depth, output.pins), Sector("gear", band, depth, design.lobes, of_teeth=True)


def _housing_sector(reducer: Reducer, settings: ConvexSettings) -> Sector:
    """Return the sector of the housing that is behind the convex slices of one lobe, or around one pin.

    `settings` set the accuracy and the number of the slices.
    """
    design = reducer.design
    ring, chord_error, half_width = design.ring, settings.rest_chord_error, design.gear.stack_width / 2.0
    half_pitch = math.pi / ring.teeth
    depth = housing_depth(reducer, settings)
    if ring.kind == "nonpin":
        bore = ring_base(reducer, depth, chord_error=chord_error)
    else:
        socket_radius = ring.pin_radius + design.socket_play + (depth if ring.has_sockets else 0.0)
        half_opening = arc_half_angle(design, socket_radius)
        socket = np.array([0.0, ring.pin_circle_radius]) + _arc(socket_radius, -half_opening, half_opening, chord_error)
        edge_angle = math.atan2(socket[-1, 0], socket[-1, 1])
        land_arc = _arc(wall_radius(design), edge_angle, half_pitch, chord_error)[1:]
        bore = np.concatenate([land_arc[::-1] * [-1.0, 1.0], socket, land_arc])
    outer_arc = _arc(design.housing.outer_radius, -half_pitch, half_pitch, chord_error)
    region = Prism(np.concatenate([outer_arc, bore[::-1]])[::-1], (), -half_width, half_width)
    return Sector("housing", region, depth, ring.teeth)


def _ring_sector(inner_radius: float, outer_radius: float, half_angle: float, chord_error: float) -> Array:
    """Compute a sector of a ring about +y, counter-clockwise."""
    outer_arc, inner_arc = (
        _arc(radius, -half_angle, half_angle, chord_error) for radius in (outer_radius, inner_radius)
    )
    return np.concatenate([outer_arc[::-1], inner_arc])


def _arc(radius: float, start: float, end: float, chord_error: float) -> Array:
    """Compute points of an arc between clockwise angles from +y."""
    return arc(radius, math.pi / 2 - start, math.pi / 2 - end, chord_error)
