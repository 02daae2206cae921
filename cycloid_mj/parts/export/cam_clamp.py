"""Clamped cams: each is slotted through its thick side, and screws across the slot clamp it on the plain shaft.

The screws are within the cam, whose bearing is put over them; so the bearing needs an inner ring. A cam that is not
tightened can be turned on the shaft, which sets its phase without keyways.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.units import in_mm
from cycloid_mj.design import stock
from cycloid_mj.parts.cam_bearing import cam_bearing, cam_radius
from cycloid_mj.parts.contour import TurnedContour
from cycloid_mj.parts.export.casing_rules import RULES, counterbore, min_grip
from cycloid_mj.parts.export.joint import BoughtPart, CrossHole, Point
from cycloid_mj.parts.export.keyway import KeyContour, SlottedContour
from cycloid_mj.parts.export.round_part import RoundPart
from cycloid_mj.parts.joint_strength import SlottedHub
from cycloid_mj.reducer import Reducer, once

CLAMPED_DISCS = 2
"""Number of discs of clamped cams: the screws of opposite cams have the same direction."""

CLAMP_FIT = "H7/h6, clamped"
"""Fit of clamped cams on the shaft."""


@dataclass(frozen=True)
class ClampSettings:
    """Proportions of clamped cams.

    Attributes
    ----------
    slot
        Width of the slot [m], that of a thin slitting saw (assumed).
    max_screws
        Largest number of screws side by side in a cam (assumed).
    slices
        Number of slices of a lying screw as it is drawn.
    """

    slot: float = 1e-3
    max_screws: int = 2
    slices: int = 12


CLAMP = ClampSettings()


@dataclass(frozen=True)
class CamClamp:
    """The clamping screws of each cam.

    Attributes
    ----------
    bolt, length, count
        Screw in stock, its length [m], and the number of screws side by side along the axis.
    distance
        Distance of the screws from the axis of the shaft [m].
    head_face
        Distance of the faces under the heads from the middle of the slot [m].
    hub
        The cam as a slotted hub.
    """

    bolt: stock.Bolt
    length: float
    count: int
    distance: float
    head_face: float
    hub: SlottedHub

    @property
    def engaged_length(self) -> float:
        """Length of the engaged thread [m]."""
        return self.length - self.head_face - 0.5 * CLAMP.slot

    @property
    def thread_depth(self) -> float:
        """Depth of the hole of the thread from the slot [m], with room beyond the tip of the screw."""
        return self.engaged_length + RULES.min_wall

    def removed_volume(self, reducer: Reducer) -> float:
        """Compute the volume [m3] of the holes of a clamping screw in its cam: counterbore, clearance hole, core."""
        thread, half_slot = self.bolt.thread, 0.5 * CLAMP.slot
        outward_distance = self.distance - reducer.design.gear.eccentricity
        edge_distance = math.sqrt(cam_radius(reducer) ** 2 - outward_distance**2)
        cylinders = (
            (counterbore(self.bolt), edge_distance - self.head_face),
            (0.5 * stock.bolt_hole(thread), self.head_face - half_slot),
            (0.5 * stock.thread_core(thread), self.thread_depth),
        )
        return math.pi * sum(radius**2 * length for radius, length in cylinders)

    def heights(self, width: float) -> tuple[float, ...]:
        """Return the heights of the screws along the axis [m] from the middle of a cam of a width [m]."""
        return tuple(width * ((number + 0.5) / self.count - 0.5) for number in range(self.count))


@once
def cam_clamp(reducer: Reducer) -> CamClamp | None:
    """Choose the screws that clamp slotted cams on the shaft, those that clamp hardest; None if cams are not clamped.

    Raises
    ------
    DesignError
        No screw in stock fits in the cams, or their bearings have no inner ring.
    """
    design = reducer.design
    if design.cam_joint != "clamp":
        return None
    problem = _describe_clamp_problem(reducer)
    clamps = [] if problem else [clamp for bolt in stock.bolts() if (clamp := _fit_screws(reducer, bolt))]
    if not clamps:
        problem = problem or (
            f"no screw of ISO 4762 fits across a slot of cams of {in_mm(2.0 * cam_radius(reducer))} x "
            f"{in_mm(design.gear.face_width)} mm on a shaft of {in_mm(2.0 * design.shaft.radius)} mm: choose a thinner "
            "shaft (shaft.radius_mm), a larger cam bearing (gear.bore_radius_mm), or another joint"
        )
        raise DesignError(f'shaft.cam_joint = "clamp" is not possible: {problem}')
    return max(clamps, key=lambda clamp: (clamp.count * clamp.bolt.thread**2, clamp.bolt.thread))


def slotted_contour(reducer: Reducer, phase: float) -> TurnedContour:
    """Return the outline of a slotted cam at a phase [rad], with its bore."""
    gear = reducer.design.gear
    outline = SlottedContour(cam_radius(reducer), gear.eccentricity, reducer.design.shaft.radius, CLAMP.slot)
    return TurnedContour(outline, phase)


def cam_screws(reducer: Reducer, clamp: CamClamp) -> BoughtPart:
    """Return one bought part with a position for each clamping screw of all cams.

    The heads of the screws point to +x at the crank angle 0.
    """
    design, origins = reducer.design, list[Point]()
    for plane, phase in zip(design.gear.disc_planes, reducer.phases, strict=True):
        for height in clamp.heights(design.gear.face_width):
            y = clamp.distance * math.cos(phase)
            origins.append((clamp.head_face, y, plane + height))
    return BoughtPart(
        names.CAM_SCREW,
        _crosswise_screw(clamp),
        names.SHAFT,
        tuple(origins),
        (("thread", clamp.bolt.thread), ("length", clamp.length)),
        "steel 8.8",
        f"{clamp.bolt.designation} x {1e3 * clamp.length:.5g}",
    )


def cross_holes(reducer: Reducer, clamp: CamClamp) -> Iterator[tuple[str, CrossHole]]:
    """Yield the holes of the clamping screws across each cam, with the name of the cam.

    They are counterbore, clearance hole and core of thread.
    """
    design, thread = reducer.design, clamp.bolt.thread
    core_radius, hole_radius, half_slot = (
        0.5 * stock.thread_core(thread),
        0.5 * stock.bolt_hole(thread),
        0.5 * CLAMP.slot,
    )
    length_outwards = 2.0 * cam_radius(reducer) - clamp.head_face  # beyond the outside of the cam
    for number, (plane, phase) in enumerate(zip(design.gear.disc_planes, reducer.phases, strict=True), start=1):
        name, y = names.numbered_name(names.CAM, number), clamp.distance * math.cos(phase)
        for height in clamp.heights(design.gear.face_width):
            head_point, slot_point = (clamp.head_face, y, plane + height), (-half_slot, y, plane + height)
            yield name, CrossHole(head_point, (1.0, 0.0, 0.0), counterbore(clamp.bolt), length_outwards)
            yield name, CrossHole(head_point, (-1.0, 0.0, 0.0), hole_radius, clamp.head_face)
            yield name, CrossHole(slot_point, (-1.0, 0.0, 0.0), core_radius, clamp.thread_depth)


def _describe_clamp_problem(reducer: Reducer) -> str:
    """Return why cams cannot be clamped on the shaft by any screws, with the remedy; empty if they can.

    They need two discs, a metal shaft, and bearings with an inner ring.
    """
    design, bearing = reducer.design, cam_bearing(reducer)
    if design.gear.discs != CLAMPED_DISCS:
        return f"the cams of {design.gear.discs} discs cannot be clamped: set gear.discs = 2, or choose another joint"
    if design.material_of(names.SHAFT).is_plastic:
        return "a plastic creeps under clamping screws: choose a metal (shaft_material.name)"
    if bearing is None:
        return (
            "a slotted cam needs a bearing with an inner ring, and no standard ball bearing fits: choose another "
            "gear.bore_radius_mm, or a thinner shaft (shaft.radius_mm)"
        )
    return ""


def _fit_screws(reducer: Reducer, bolt: stock.Bolt) -> CamClamp | None:
    """Return the clamp with screws of one size, as close to the shaft as they fit; None if they do not fit.

    `bolt` is the size of the screw in stock.
    """
    design, outer_radius, wall = reducer.design, cam_radius(reducer), RULES.min_wall
    gear, shaft_radius, head_radius = design.gear, design.shaft.radius, counterbore(bolt)
    hinge_wall = outer_radius - gear.eccentricity - shaft_radius
    count = min(int((gear.face_width - wall) / (2.0 * head_radius + wall) + 1e-9), CLAMP.max_screws)
    if count < 1 or hinge_wall < wall:
        return None
    distance = shaft_radius + 0.5 * stock.bolt_hole(bolt.thread) + wall
    min_head_face = math.sqrt(max((shaft_radius + wall) ** 2 - max(distance - head_radius, 0.0) ** 2, 0.0))
    head_face = max(0.5 * CLAMP.slot + min_grip(bolt, wall), min_head_face)
    min_length = head_face + 0.5 * CLAMP.slot + RULES.engagement * bolt.thread
    length = stock.bolt_length(bolt.thread, min_length)
    if length is None:
        return None
    outward_distance = distance - gear.eccentricity
    head_corner = math.hypot(abs(outward_distance) + 0.5 * bolt.head, head_face + bolt.head_height)
    tip_corner = math.hypot(abs(outward_distance) + 0.5 * bolt.thread, length - head_face + wall)
    if head_corner > outer_radius - wall or tip_corner > outer_radius - wall:
        return None
    lever_arm, modulus = shaft_radius + 0.5 * hinge_wall, design.material_of(names.SHAFT).youngs_modulus
    hub = SlottedHub(2.0 * shaft_radius, distance + lever_arm, lever_arm, hinge_wall, gear.face_width, modulus)
    return CamClamp(bolt, length, count, distance, head_face, hub)


def _crosswise_screw(clamp: CamClamp) -> RoundPart:
    """Return the shape of a clamping screw along x, as slices along the axis of the crank.

    Its head is on the side of +x, and the face under the head is at x = 0.
    """
    bolt, blocks = clamp.bolt, []
    core_radius = 0.5 * stock.thread_core(bolt.thread)
    for radius, start, end in ((core_radius, -clamp.length, 0.0), (0.5 * bolt.head, 0.0, bolt.head_height)):
        edges = -radius * np.cos(np.pi * np.arange(CLAMP.slices + 1) / CLAMP.slices)
        for slice_start, slice_end in pairwise(edges.tolist()):
            half_width = math.sqrt(radius**2 - (0.5 * (slice_start + slice_end)) ** 2)
            blocks.append((KeyContour(start, end, 2.0 * half_width, 0.0), slice_start, slice_end))
    return RoundPart(names.SHAFT, blocks=tuple(blocks), bought=True)
