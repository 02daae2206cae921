"""Surfaces that wear, and the dose of pressure times sliding distance that each of their points gets over a turn.

All parts of a kind wear equally: doses are means over all lobes, pins or holes. A dose is spread over the width of the
Hertzian strip, which matters where a contact dwells: at the tips of the lobes, and where it turns back on a pin.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from functools import partial
from typing import Any, Literal

import numpy as np

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.deprecated import deprecated_attribute
from cycloid_mj.checks.strength import list_walls
from cycloid_mj.geometry import profile
from cycloid_mj.life.loading import relative_speed, slides_in_seat
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.reducer.contact import CONTACT
from cycloid_mj.reducer.worn import WornGaps, table_angles
from cycloid_mj.statics import Loads, Springs
from cycloid_mj.statics.rv import compute_rv_springs, solve_rv_loads
from cycloid_mj.statics.rv_film import RvFilm, running_friction
from cycloid_mj.statics.rv_sheet import torque_on_carrier

Gap = Literal["teeth", "output", "cam"]
"""A gap that a worn surface opens."""

Contacts = Literal["teeth", "flank", "seat", "output", "cam"]
"""Contacts that slide on a surface: all teeth, only those that slide on the flank or in the seat of a pin, and others.
"""

TABLE = 2048
"""Angles of the tables of openings: 0.2 deg, or at most 50 um of the flank of `pin`, less than its Hertzian strips."""

CELLS = 1024
"""Cells of a section: 7 to 14 um on the flanks and pins of `pin`."""


@dataclass(frozen=True, eq=False)
class WearingSurface:
    """A surface that slides, as `count` equal sections.

    Attributes
    ----------
    key, name
        Key of the surface in results, and its name in words.
    part
        Part of `design.PARTS`, which determines the material.
    contacts
        The contacts that slide on it.
    count
        Number of equal sections on all parts.
    section
        Length of each section along the sliding [m]; it is closed, or repeats.
    contact_coordinate
        Coordinate of the contact along the section [m], from -section/2, at the angles of `table_angles` and at pi,
        shape (`TABLE` + 1,); None for a surface that turns and so wears evenly.
    lever
        Sliding speed of this surface over that of the contact [1].
    opening
        Opening of the gap per depth of wear.
    gap
        The gap that it opens.
    length
        Length of a contact line across it [m].
    thickness
        Depth at which the part is worn through [m]: the height of a lobe, the radius of a pin, or the thinnest wall.
    """

    key: str
    name: str
    part: str
    contacts: Contacts
    count: int
    section: float
    contact_coordinate: Array | None = None
    lever: float = 1.0
    opening: float = 1.0
    _: KW_ONLY
    gap: Gap
    length: float
    thickness: float

    place = deprecated_attribute("WearingSurface", "place", "contact_coordinate")

    @property
    def cells(self) -> int:
        """Number of cells of a section."""
        return 1 if self.contact_coordinate is None else CELLS

    @property
    def coordinates(self) -> Array:
        """Middle of each cell along the section [m], shape (cells,)."""
        return ((np.arange(self.cells) + 0.5) / self.cells - 0.5) * self.section

    def interpolate_depth(self, depth: Array) -> Array:
        """Interpolate the depth of the cells [m], shape (cells,), at the angles of `table_angles`, shape (`TABLE`,)."""
        if self.contact_coordinate is None:
            return np.full(TABLE, depth[0])
        return np.interp(self.contact_coordinate[:-1], self.coordinates, depth, period=self.section)


@dataclass(frozen=True, eq=False)
class SlidingContacts:
    """Contacts of a sliding pair at m crank angles of a turn: arrays of shape (m, n).

    Attributes
    ----------
    angle
        Position of the contact on the worn surface [rad], at which the wear is tabulated: of a tooth its phase, of an
        output hole the direction about its centre, of a cam the direction of the force from that of the eccentricity.
    force, speed, half_width
        Normal force [N], sliding speed [m/s] and half width by Hertz [m].
    """

    angle: Array
    force: Array
    speed: Array
    half_width: Array


def wearing_surfaces(reducer: Reducer) -> tuple[WearingSurface, ...]:
    """Return the surfaces of a reducer that slide; rolling bearings, rollers and planets are not among them."""
    if isinstance(reducer, RvReducer):
        return tuple(_tooth_surfaces(reducer))
    return (*_tooth_surfaces(reducer), *_output_surfaces(reducer), *_cam_surfaces(reducer))


def _tooth_surfaces(reducer: Reducer) -> Iterator[WearingSurface]:
    """Yield the wearing surfaces of the mesh: flanks and pins (or lobes), and both surfaces of the seats of pins.

    If the friction in the seat of a pin is lower than at the flank, the pin turns in its seat, and the seat wears. With
    film friction this differs between contacts, so flanks and seats wear.
    """
    design, ring = reducer.design, reducer.design.ring
    length, lobe_height = design.line_length(design.tooth_pair), 2.0 * design.gear.eccentricity
    round_surface = partial(_round_surface, gap="teeth", count=ring.mate_count * design.gear.discs, length=length)
    pin = partial(round_surface, ring.pin_radius, key="pin", name="pins", part="pin")
    phase = np.append(table_angles(TABLE), math.pi)
    angle = profile.conjugate_alpha(reducer.tooth_profile, phase)
    seat, bore_radius = design.seat_pair, ring.sleeve_bore_radius
    seats_wear = bool(seat) and (design.has_film or design.mesh_friction < design.friction_of(design.tooth_pair))
    flanks_wear = not seats_wear or design.has_film
    if flanks_wear:
        yield WearingSurface(
            *("flank", "flanks of the discs", "gear", "flank"),
            count=design.lobes * design.gear.discs * ring.halves,
            section=profile.length(reducer.gear_profile, reducer.profile_offset) / design.lobes,
            contact_coordinate=-profile.arc_length(reducer.gear_profile, -phase / design.lobes, reducer.profile_offset),
            gap="teeth",
            length=length,
            thickness=lobe_height,
        )
    if seat == "pin_socket":
        # a smaller pin also widens the clearance of its socket
        yield pin(contacts="teeth", opening=2.0, thickness=ring.pin_radius)
    elif seat and flanks_wear:
        yield pin(contacts="flank", thickness=ring.pin_radius - bore_radius)
    elif not seat and ring.kind == "pin":
        yield pin(angle, contacts="flank", thickness=ring.pin_radius)
    elif not seat:
        lobe = partial(round_surface, key="lobe", name="lobes of the ring", part="housing", contacts="flank")
        yield lobe(ring.pin_radius, angle, thickness=lobe_height)
    seat_surface = partial(round_surface, contacts="seat")
    if seats_wear and seat == "pin_socket":
        socket = partial(seat_surface, key="socket", name="sockets of the pins", part="housing")
        yield socket(ring.pin_radius, angle, thickness=_walls(reducer)["housing_ligament"])
    elif seats_wear:
        in_sleeve = partial(seat_surface, bore_radius, part="pin", lever=bore_radius / ring.pin_radius)
        yield in_sleeve(key="sleeve", name="bores of the sleeves", thickness=ring.pin_radius - bore_radius)
        yield in_sleeve(angle, key="core", name="pins in sleeves", thickness=bore_radius)


def _output_surfaces(reducer: Reducer) -> Iterator[WearingSurface]:
    """Yield the wearing surfaces of the output: holes and pins, or bores and cores of plain rollers.

    There are none with needle rollers.
    """
    design, output = reducer.design, reducer.design.output
    angle = np.append(table_angles(TABLE), math.pi)
    count, length = output.pins * design.gear.discs, design.line_length("output")
    surface = partial(_round_surface, contacts="output", gap="output", count=count, length=length)
    if not output.rollers:
        walls = _walls(reducer)
        # two holes wear the wall between them
        hole_wall = min(0.5 * walls["hole_to_hole"], walls["hole_to_root"], walls["bore_to_hole"])
        hole = partial(surface, key="hole", name="holes of the discs", part="gear")
        yield hole(output.hole_radius, angle, thickness=hole_wall)
        pin = partial(surface, key="output_pin", name="output pins", part="output")
        yield pin(output.pin_radius, angle, thickness=output.pin_radius)
    elif not output.has_needles:
        radius = output.root_radius
        roller = partial(surface, radius, part="output", lever=radius / output.pin_radius)
        yield roller(key="roller", name="bores of the rollers", thickness=output.pin_radius - radius)
        yield roller(angle, key="roller_core", name="cores of the rollers", thickness=radius)


def _cam_surfaces(reducer: Reducer) -> Iterator[WearingSurface]:
    """Yield the bores of the discs and the plain cams as wearing surfaces; none with rolling bearings.

    The cam wears where the load presses, the bore evenly.
    """
    gear = reducer.design.gear
    if gear.bearing == "plain":
        angle = np.append(table_angles(TABLE), math.pi)
        surface = partial(_round_surface, gear.bore_radius, contacts="cam", gap="cam")
        surface = partial(surface, count=gear.discs, length=gear.face_width)
        yield surface(key="bore", name="bores of the discs", part="gear", thickness=_walls(reducer)["bore_to_hole"])
        yield surface(angle, key="cam", name="cams", part="shaft", thickness=gear.bore_radius)


def _round_surface(radius: float, angle: Array | None = None, **fields: Any) -> WearingSurface:
    """Return a wearing surface with a circular section of some radius [m].

    `angle` [rad] is that of the contact on the circle at the angles of the table, shape (`TABLE` + 1,). Without it, the
    surface wears evenly. `fields` are the other attributes of the surface.
    """
    coordinate = None if angle is None else radius * angle
    return WearingSurface(section=2.0 * math.pi * radius, contact_coordinate=coordinate, **fields)


def _walls(reducer: Reducer) -> dict[str, float]:
    """Return the thickness of the walls of disc and housing [m], by the name of the wall."""
    return {wall.name: wall.thickness for wall in list_walls(reducer)}


def sliding_contacts(reducer: Reducer, springs: Springs, contact_loads: Loads) -> dict[Contacts, SlidingContacts]:
    """Return the sliding contacts over a turn at the crank speed of the design, by kind.

    The keys are "teeth" (all contacts), "flank" and "seat", see `_split_teeth`, "output" (output pins) and "cam" (plain
    cams). `springs` and `contact_loads` are the contact springs and the forces at the m crank angles of the turn. All
    arrays have the shape (m, contacts).
    """
    design, teeth = reducer.design, springs.teeth
    slip_speeds = np.abs(springs.slip)
    contacts = springs.contacts
    hole_direction = (
        contacts.slope[:, teeth:, 2:-1:3].sum(axis=-1),
        -contacts.shift_slope[:, teeth:, 2:-1:3].sum(axis=-1),
    )
    cam_forces = contact_loads.cam
    # direction of the force from the middle of the crank to that of the disc
    cam_direction = springs.crank[:, np.newaxis] + np.array(reducer.phases) + 0.5 * math.pi
    cam_force = np.linalg.norm(cam_forces, axis=-1)
    cam_speed = design.gear.bore_radius * relative_speed(reducer, design.drive.speed)
    tooth_pair = design.tooth_pair
    tooth_contacts = SlidingContacts(
        _wrap(-contacts.phase[:, :teeth]),
        contact_loads.teeth,
        slip_speeds[:, :teeth],
        _half_width(reducer, tooth_pair, contact_loads.teeth, springs.curvature, design.ring.pin_radius),
    )
    return {
        **_split_teeth(tooth_contacts, slides_in_seat(design, contact_loads.friction, tooth_contacts.force.shape)),
        "output": SlidingContacts(
            np.arctan2(*hole_direction),
            contact_loads.output,
            slip_speeds[:, teeth:],
            _half_width(reducer, "output", contact_loads.output, None, design.output.pin_radius),
        ),
        "cam": SlidingContacts(
            _wrap(np.arctan2(cam_forces[..., 1], cam_forces[..., 0]) - cam_direction),
            cam_force,
            np.full_like(cam_force, cam_speed),
            _half_width(reducer, "cam", cam_force, None, design.gear.bore_radius),
        ),
    }


def rv_sliding_contacts(reducer: RvReducer, crank: Array, torque: float) -> dict[Contacts, SlidingContacts]:
    """Solve for forces and sliding speeds of the tooth contacts of an RV reducer, at the crank speed of the design.

    `torque` acts on the output [N m]. `crank` [rad] are m crank angles relative to the ring, shape (m,). The result has
    the keys "teeth" (all contacts), "flank" and "seat", see `_split_teeth`. All arrays, which are angles, forces,
    speeds and half widths, have the shape (m, contacts).

    Raises
    ------
    RunError
        No static equilibrium exists.
    """
    springs, carrier_torque = compute_rv_springs(reducer, crank), torque_on_carrier(reducer, torque)
    friction = running_friction(reducer, crank, np.sign(carrier_torque))
    solution = solve_rv_loads(springs, carrier_torque, friction)
    force = solution.pins
    speed = np.abs(springs.slip) * abs(reducer.speed_against_ring)
    tooth_pair, pin_radius = reducer.design.tooth_pair, reducer.design.ring.pin_radius
    half_width = _half_width(reducer, tooth_pair, force, springs.curvature, pin_radius)
    if isinstance(friction, RvFilm):
        _, is_in_seat = friction.surfaces(solution).smaller_friction(force)
    else:
        is_in_seat = slides_in_seat(reducer.design, None, force.shape)
    return _split_teeth(SlidingContacts(_wrap(-springs.phase), force, speed, half_width), is_in_seat)


def _split_teeth(teeth: SlidingContacts, is_in_seat: Mask) -> dict[Contacts, SlidingContacts]:
    """Return all contacts of the teeth ("teeth"), those that slide on the flank ("flank") or in a pin's seat ("seat").

    Each value has all contacts; those that do not slide on this surface have no force. `is_in_seat` (m, contacts) is
    true for contacts that slide in the seat.
    """
    return {
        "teeth": teeth,
        "flank": replace(teeth, force=np.where(is_in_seat, 0.0, teeth.force)),
        "seat": replace(teeth, force=np.where(is_in_seat, teeth.force, 0.0)),
    }


def _wrap(angle: Array) -> Array:
    """Return angles [rad] in the turn from -pi."""
    return np.mod(angle + math.pi, 2.0 * math.pi) - math.pi


def _half_width(reducer: Reducer, kind: str, force: Array, curvature: Array | None, radius: float) -> Array:
    """Compute the half width of Hertzian line contacts [m] under forces [N], in the shape of `force`.

    `kind` is the kind of mating pair, `curvature` the relative curvature [1/m]; None: the constant curvature of the
    pair. The result is limited to `hertz_reach` times `radius` [m], that of the pin or of the bore on a cam.
    """
    contact = reducer.contacts[kind]
    width = contact.half_width(force, contact.relative_curvature if curvature is None else curvature)
    return np.minimum(width, CONTACT.hertz_reach * radius)


def dose_rate(surface: WearingSurface, sliding: SlidingContacts) -> Array:
    """Compute the mean rate of pressure times sliding distance [Pa m/s] in each cell of a surface, shape (cells,).

    A cell is a small interval along the surface. `sliding` are the contacts on this surface over a turn in one
    direction. The drive turns in each direction for half of the time, under a load that always opposes the rotation.
    """
    power = sliding.force * sliding.speed * surface.lever
    area = surface.count * surface.length * surface.section / surface.cells
    if surface.contact_coordinate is None:
        return np.array([power.sum() / len(power) / area])
    is_loaded = power > 0.0
    angles = np.append(table_angles(TABLE), math.pi)
    coordinates = np.interp(sliding.angle[is_loaded], angles, surface.contact_coordinate)
    cell_sums = sum_over_cells(
        coordinates, sliding.half_width[is_loaded], power[is_loaded], surface.section, surface.cells
    )
    forward_rate = cell_sums / len(power) / area
    return 0.5 * (forward_rate + forward_rate[::-1])


def sum_over_cells(centres: Array, half_widths: Array, weights: Array, period: float, cells: int) -> Array:
    """Distribute weights over equal cells (intervals) of a periodic section; return their sum in each cell, (cells,).

    Each of n weights is distributed uniformly from centre - half width to centre + half width [m], shape (n,) each. The
    section has the length `period` [m], from -period/2 on. The sums are exact.
    """
    min_half_width = 1e-6 * period / cells  # a contact without width counts as a very narrow one
    clipped_half_widths = np.maximum(half_widths, min_half_width)
    shifts = np.array([-period, 0.0, period])[:, np.newaxis]
    ends = np.concatenate(
        [(centres - clipped_half_widths + shifts).ravel(), (centres + clipped_half_widths + shifts).ravel()]
    )
    slopes = np.tile(weights / (2.0 * clipped_half_widths), 3)
    slopes = np.concatenate([slopes, -slopes])
    order = np.argsort(ends)
    ends, slopes = ends[order], slopes[order]
    edges = (np.arange(cells + 1) / cells - 0.5) * period
    cell_before = np.searchsorted(ends, edges)
    level, moment = (np.concatenate([[0.0], np.cumsum(values)])[cell_before] for values in (slopes, slopes * ends))
    return np.asarray(np.diff(edges * level - moment))


def worn_gaps(surfaces: Sequence[WearingSurface], depths: Mapping[str, Array], rates: Mapping[str, Array]) -> WornGaps:
    """Compute by how much wear widens the gaps of teeth, output pins and cam [m].

    The result has a value per angle of `table_angles`, shape (`TABLE`,), for teeth and output pins, and one value for
    the cam.

    Parameters
    ----------
    surfaces
        The surfaces that wear.
    depths
        Depth of wear in each cell of the surfaces [m], shape (cells,), by key of the surface.
    rates
        Pressure times sliding distance per time in the same cells [Pa m/s], shape (cells,), by key. These are the
        weights of the mean depth of a plain cam, because only its loaded side determines the clearance.
    """
    gaps_by_angle = {"teeth": np.zeros(TABLE), "output": np.zeros(TABLE)}
    cam_gap = 0.0
    for surface in surfaces:
        depth = depths[surface.key]
        if surface.gap == "cam":
            cam_gap += float(np.average(depth, weights=rates[surface.key]))
        else:
            gaps_by_angle[surface.gap] += surface.opening * surface.interpolate_depth(depth)
    return WornGaps(gaps_by_angle["teeth"], gaps_by_angle["output"], cam_gap)
