"""Thickness of the slices, limited by the walls of the parts."""

import math

from cycloid_mj.geometry import profile
from cycloid_mj.parts.convex.settings import METHOD, ConvexSettings
from cycloid_mj.reducer import Reducer, RvReducer


def gear_depth(reducer: Reducer, settings: ConvexSettings) -> float:
    """Compute how deep [m] the convex slices of a disc extend from its flanks, bore and holes into the material.

    The depth is in the plane of the disc. It is the pin radius times `settings.depth`, or the thinnest wall of the disc
    times `METHOD.wall_share` if that is less.
    """
    design = reducer.design
    valley_radius = reducer.gear_profile.pin_circle_radius - design.gear.eccentricity - reducer.profile_offset
    if isinstance(reducer, RvReducer):
        max_hole_reach = max(
            reducer.crank_radius + reducer.bore_radius, reducer.post_circle_radius + reducer.window_radius
        )
        min_wall = min(valley_radius - max_hole_reach, _lobe_width(reducer))
        return min(settings.depth * design.ring.pin_radius, METHOD.wall_share * min_wall)
    output, clearance = design.output, design.clearance
    hole_radius = output.hole_radius + clearance.output
    walls = (
        output.pin_circle_radius - hole_radius - design.gear.bore_radius - clearance.cam,
        2.0 * (output.pin_circle_radius * math.sin(math.pi / output.pins) - hole_radius),
        valley_radius - output.pin_circle_radius - hole_radius,
        _lobe_width(reducer),
    )
    return min(settings.depth * design.ring.pin_radius, METHOD.wall_share * min(walls))


def housing_depth(reducer: Reducer, settings: ConvexSettings) -> float:
    """Compute how deep [m] the convex slices of the ring extend from its flanks or sockets into the material.

    The depth is in the plane of the ring. It is the pin radius times `settings.depth`, or the thinnest wall of the ring
    times `METHOD.wall_share` if that is less.
    """
    design = reducer.design
    ring = design.ring
    if ring.kind == "nonpin":
        root_radius = ring.pin_circle_radius + 2.0 * design.gear.eccentricity - ring.pin_radius
        walls = [design.housing.outer_radius - root_radius]
    else:
        socket_radius = ring.pin_radius + design.socket_play
        pin_wall = 2.0 * (ring.pin_circle_radius * math.sin(math.pi / ring.teeth) - socket_radius)
        walls = [design.housing.outer_radius - ring.pin_circle_radius - socket_radius, pin_wall]
    return min(settings.depth * ring.pin_radius, METHOD.wall_share * min(walls))


def _lobe_width(reducer: Reducer) -> float:
    """Compute the width of a lobe between its inflections [m]."""
    gear = reducer.gear_profile
    tip_angle = math.pi / gear.lobes
    inflection = profile.outline(gear, profile.inflection_phase(gear) / gear.lobes, reducer.profile_offset)
    return 2.0 * abs(float(inflection @ profile.unit(tip_angle + math.pi / 2.0)))
