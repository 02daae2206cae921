"""Round holes around round parts as flat facets: bore and holes of the disc, and the sockets of free pins.

The motion of the part in the hole depends on the radial play R - r. Facets at the distance R from the axis bound it by
a polygon that differs from the circle by (R - r)(1/cos(pi/n) - 1), which is negligible for a play of the size of a
clearance, even with few facets. The error is balanced to both sides.
"""

import math
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.geometry.profile import unit
from cycloid_mj.parts.convex.settings import METHOD, ConvexSettings
from cycloid_mj.parts.convex.surface import ConvexSurface, SlicePlacement, convex_slice
from cycloid_mj.parts.convex.walls import gear_depth, housing_depth
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.sockets import socket_half_angle


@dataclass(frozen=True)
class Hole:
    """A group of equal holes: radii of hole and of the part in it [m], half the opening angle [rad].

    `turns` are the clockwise angles [rad] of the holes, `centres` (n, 2) [m] their axes.
    """

    name: str
    radius: float
    inner_radius: float
    half_angle: float
    turns: Array
    centres: Array


def gear_bore(reducer: Reducer, settings: ConvexSettings) -> ConvexSurface:
    """Return the bore of the disc in the frame of the disc; `member` is 1."""
    cam_radius = reducer.design.gear.bore_radius
    hole = Hole("bore", cam_radius + reducer.design.clearance.cam, cam_radius, math.pi, np.zeros(1), np.zeros((1, 2)))
    return _facet_walls(hole, gear_depth(reducer, settings), reducer, settings)


def gear_holes(reducer: Reducer, settings: ConvexSettings, disc: int = 0) -> ConvexSurface:
    """Approximate the output holes of a disc by flat convex slices with the clearances of the design.

    The slices are in the frame of the disc, and `disc` is its index. They are placed hole by hole: hole 1 is on +y, the
    others follow clockwise. `settings` set the accuracy and the number of the slices.
    """
    output = reducer.design.output
    angles = 2.0 * math.pi * np.arange(output.pins) / output.pins
    radius = output.hole_radius + reducer.design.clearance.output
    centres = output.pin_circle_radius * unit(angles) + reducer.deviations.hole_displacement[disc]
    hole = Hole("hole", radius, output.pin_radius, math.pi, angles, centres)
    return _facet_walls(hole, gear_depth(reducer, settings), reducer, settings)


def pin_sockets(reducer: Reducer, settings: ConvexSettings) -> ConvexSurface:
    """Approximate the sockets of free ring pins by flat convex slices with the clearances of the design.

    The slices are in the frame of the reducer. They are placed pin by pin: pin 1 is on +y, the others follow clockwise.
    `settings` set the accuracy and the number of the slices.
    """
    design = reducer.design
    ring = design.ring
    angles = 2.0 * math.pi * np.arange(ring.teeth) / ring.teeth
    radius = ring.pin_radius + design.clearance.pin_socket
    centres = ring.pin_circle_radius * unit(angles) + reducer.deviations.pin_displacement
    hole = Hole("socket", radius, ring.pin_radius, socket_half_angle(design), angles, centres)
    return _facet_walls(hole, housing_depth(reducer, settings), reducer, settings)


def facet_count(hole: Hole, settings: ConvexSettings) -> int:
    """Return the number of facets per turn that keeps the error of the play within the settings."""
    play = hole.radius - hole.inner_radius
    min_count = math.pi / math.acos(1.0 / (1.0 + 2.0 * settings.play_error / play))
    return max(settings.fewest_facets, math.ceil(min_count))


def _facet_walls(hole: Hole, depth: float, reducer: Reducer, settings: ConvexSettings) -> ConvexSurface:
    """Approximate the walls of equal round holes by flat convex slices.

    `hole` has the radius and the positions of the holes. The result has one slice, and its position on each facet of
    each hole. The slices are `depth` [m] thick. The middle and the corners of a facet deviate equally from the circle.
    `settings` set the accuracy and the number of the slices.
    """
    play, is_full_circle = hole.radius - hole.inner_radius, hole.half_angle == math.pi
    count = math.ceil(facet_count(hole, settings) * hole.half_angle / math.pi)
    facet_angle = 2.0 * hole.half_angle / count
    facet_error = 0.5 * play * (1.0 / math.cos(0.5 * facet_angle) - 1.0)
    facet_radius, outer_radius = hole.radius - facet_error, hole.radius + depth
    width = 2.0 * facet_radius * math.tan(0.5 * facet_angle)
    edges = np.array([-0.5, 0.5]) * facet_angle
    overlap_offset = 0.5 * METHOD.overlap * settings.chord_error * np.array([[-1.0, 0.0], [1.0, 0.0]])
    face, outer_edge = (
        facet_radius / math.cos(0.5 * facet_angle) * unit(edges) + overlap_offset,
        outer_radius * unit(edges) + overlap_offset,
    )
    outline = np.concatenate([face, outer_edge[::-1]])
    curvature = 1.0 / hole.inner_radius - 1.0 / hole.radius
    facet = convex_slice(hole.name, outline, width, curvature, hole.radius, play)
    angles = (np.arange(count) + 0.5) * facet_angle - hole.half_angle
    placements = [
        SlicePlacement(0, member, float(axis_angle + angle), (float(centre[0]), float(centre[1])))
        for member, (axis_angle, centre) in enumerate(zip(hole.turns, hole.centres, strict=True), start=1)
        for angle in angles
    ]
    sample_directions = unit(
        hole.turns[0] + np.linspace(-1.0, 1.0, METHOD.samples, endpoint=not is_full_circle) * hole.half_angle
    )
    corner_excess = facet_radius / math.cos(0.5 * facet_angle) - hole.radius
    base_area = 0.5 * count * outer_radius**2 * math.sin(facet_angle)
    return ConvexSurface(
        name=hole.name,
        slices=(facet,),
        places=tuple(placements),
        half_width=0.5 * (reducer.design.gear.stack_width if hole.name == "socket" else reducer.design.gear.face_width),
        points=hole.centres[0] + hole.radius * sample_directions,
        normals=-sample_directions,
        strip_area=len(hole.turns) * (base_area - hole.half_angle * hole.radius**2),
        depth=depth * math.cos(0.5 * facet_angle),
        overfill_bound=METHOD.tolerance * max(facet_error, settings.play_error),
        underfill_bound=METHOD.tolerance * corner_excess,
    )
