"""Regions of planar parts for meshing: outlines, their contacts, and their supports."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import repeat
from typing import Literal

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.deprecated import deprecated_attribute
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.names import GEAR, family, gears
from cycloid_mj.design import Material
from cycloid_mj.parts import circle, output_centres, parts
from cycloid_mj.reducer import Reducer, RvReducer

CHORD_ERROR = 1e-9
"""Distance of the polygons from the exact outlines [m]."""

MATERIAL_PART = {"ring": "housing", "pin_1": "pin"}
"""Name in the design of a part that has another name there."""

PLANAR_PARTS = ("gear", "ring", "output", "pin_1")
"""Parts with a planar grid; gear is any of several discs."""


ContactWidth = Literal["", "line", "wide"]
"""Kind of contacts of a boundary with other parts."""


@dataclass(frozen=True)
class Boundary:
    """Closed outline, a counter-clockwise polygon (n, 2) [m], with its role.

    `role` is "outline", "hole", or "inset" (a closed curve within the material, where a pin is attached). `contact`
    states whether other parts have line or wide contacts with it. If `is_fixed`, it is fixed.
    """

    polygon: Array
    role: str
    contact: ContactWidth = ""
    is_fixed: bool = False

    touched = deprecated_attribute("Boundary", "touched", "contact")


@dataclass(frozen=True)
class Region:
    """A planar part: its boundaries, outline first, and its thickness [m]."""

    part: str
    boundaries: tuple[Boundary, ...]
    thickness: float


def material_of(reducer: Reducer, part: str) -> Material:
    """Return the material of a part."""
    return reducer.design.material_of(MATERIAL_PART.get(part, GEAR if family(part) == GEAR else part))


def part_region(reducer: Reducer, part: str) -> Region:
    """Return outlines [m], contacts, supports and thickness [m] of a planar part, in the frame of its solid.

    `part` is one of `PLANAR_PARTS`, or one of several discs ("gear_2"). The ring is the housing. It is fixed as the
    design states: at the circles that its bolts clamp, or at its rim. The output disc is fixed at its hub, a circle of
    the shaft's radius (an assumption), and forces act on its pins, or on their cores under rollers. Disc and pin have
    no supports. Ring and pin are as thick as the stack of discs with its gaps.

    Raises
    ------
    UsageError
        The design has no such part, or its pins leave no space for a hub.
    """
    design = reducer.design
    width = design.gear.stack_width
    solids = parts(reducer, CHORD_ERROR)
    match family(part) if part in gears(design.gear.discs) else part:
        case "gear":
            prism = solids[part].prisms[0]
            outline = Boundary(prism.outline, "outline", contact="line")
            contact_widths = _hole_contacts(reducer, len(prism.holes))
            hole_boundaries = (
                Boundary(hole_outline, "hole", kind)
                for hole_outline, kind in zip(prism.holes, contact_widths, strict=True)
            )
            return Region(part, (outline, *hole_boundaries), design.gear.face_width)
        case "ring":
            prism = solids["housing"].prisms[0]
            rim = Boundary(prism.outline, "outline", is_fixed=design.housing.support == "rim")
            return Region(part, (rim, Boundary(prism.holes[0], "hole", contact="line"), *_bolt_circles(reducer)), width)
        case "pin_1" if design.ring.kind == "pin":
            return Region(part, (Boundary(solids["pin"].prisms[0].outline, "outline", contact="line"),), width)
        case "output":
            return _output_region(reducer, solids["output"].prisms[0].outline)
    available_parts = [name for name in PLANAR_PARTS if name != "pin_1" or design.ring.kind == "pin"]
    raise UsageError(
        f"the design {design.name!r} has no planar part {part!r}: choose one of {', '.join(available_parts)}"
    )


def _hole_contacts(reducer: Reducer, hole_count: int) -> Iterator[ContactWidth]:
    """Yield the kind of contact (wide, line or none) of `hole_count` holes of a disc, in the order of its solid.

    The bore has a wide contact, the holes of output pins have line contacts. In the disc of an RV reducer, the bores of
    the cranks have wide contacts; its middle hole, if any, and the windows for the posts have none.
    """
    if not isinstance(reducer, RvReducer):
        yield "wide"
        yield from repeat("line", hole_count - 1)
        return
    cranks = reducer.cranks.count
    yield from repeat("", hole_count - 2 * cranks)
    yield from repeat("wide", cranks)
    yield from repeat("", cranks)


def _bolt_circles(reducer: Reducer) -> tuple[Boundary, ...]:
    """Return the circles at which the bolts of the housing clamp it, as fixed boundaries; none if its rim is fixed."""
    design = reducer.design
    housing = design.housing
    if housing.support == "rim":
        return ()
    bolt_angles = 2.0 * np.pi * np.arange(housing.bolts) / housing.bolts
    centres = design.bolt_circle_radius * np.stack([np.sin(bolt_angles), np.cos(bolt_angles)], axis=1)
    clamped_circle = circle(design.bolt_radius, CHORD_ERROR)
    return tuple(Boundary(clamped_circle + centre, "inset", is_fixed=True) for centre in centres)


def _output_region(reducer: Reducer, rim: Array) -> Region:
    """Return the region of the output disc, for meshing: rim, fixed hub and circles of the pins.

    `rim` are the n points of its outline (n, 2) [m].

    Raises
    ------
    UsageError
        The pins leave no space for a hub.
    """
    output, hub_radius = reducer.design.output, reducer.design.shaft.radius
    if not hub_radius < output.pin_circle_radius - output.pin_radius:
        raise UsageError(
            f"the output of {reducer.design.name} has no space for its hub, because shaft.radius_mm must be smaller "
            "than output.pin_circle_radius_mm minus the radius of the output pins: reduce shaft.radius_mm"
        )
    pin_outline = circle(output.root_radius, CHORD_ERROR)
    pin_boundaries = tuple(
        Boundary(pin_outline + centre, "inset", contact="line") for centre in output_centres(reducer)
    )
    hub_boundary = Boundary(circle(hub_radius, CHORD_ERROR), "hole", is_fixed=True)
    return Region("output", (Boundary(rim, "outline"), hub_boundary, *pin_boundaries), output.disc_thickness)
