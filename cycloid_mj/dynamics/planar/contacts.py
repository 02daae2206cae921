"""Contact search of the planar solver: contacts of all mating pairs at a pose, linearised in the speeds.

A contact pushes one body away from another along its normal. Its relative speed is the sum of the contributions of a
disc, a pin and a shaft, by their lever arms.
"""

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from cycloid_mj.base import compiling
from cycloid_mj.base.array import Array
from cycloid_mj.dynamics.contact.contact_search import SETTINGS as ROOT_SEARCH
from cycloid_mj.dynamics.contact.contact_search import (
    STRIDE,
    RingPin,
    Touch,
    inner_touches,
    lobe_touches,
    pin_touch,
    read_touch,
)
from cycloid_mj.dynamics.contact.gap import Flank, PartialCircle, Pose, outwards
from cycloid_mj.dynamics.contact.teeth import Teeth
from cycloid_mj.dynamics.film_table import CAM, OUTPUT, SEAT, TEETH, look_up, phase_cosine
from cycloid_mj.dynamics.planar.settings import CONTACT_SEARCH
from cycloid_mj.dynamics.planar.system import System
from cycloid_mj.reducer import impact, roller_needles

OPEN, STICKS, SLIDES, SLIDES_BACK = range(4)
"""States of a contact. A sticking contact creeps; a sliding one transmits the Coulomb limit."""

CONTACT = np.dtype(
    [(name, np.int64) for name in ("pair", "disc", "pin", "pin_shift", "shaft", "crank", "state")]
    + [(name, np.float64) for name in ("nx", "ny", "side")]
    + [(f"{part}_{arm}", np.float64) for part in ("disc", "pin", "shaft", "crank") for arm in ("normal", "tangent")]
    + [(f"{part}_centre", np.float64) for part in ("disc", "shaft", "crank")]
    + [(name, np.float64) for name in ("gap", "force", "slope", "friction", "creep", "geometric_stiffness", "cosine")]
    + [(name, np.float64) for name in ("speed", "slip", "normal_force", "friction_force")]
)
"""Fields of a contact:

pair
    Number of its pair in the order of ``Mechanism.pairs``.
disc, pin, shaft, crank
    Index of the first unknown of the disc (or sun) and of the pin, and of the unknowns of a shaft about the reducer's
    axis and of a crank of an RV reducer; -1 where there is none.
pin_shift
    Number of unknowns from those of the pin's position in the plane of disc 1 to those in the plane of the contact.
state
    One of `OPEN`, `STICKS`, `SLIDES`, `SLIDES_BACK`.
nx, ny
    Unit normal; the tangent is the normal rotated by 90 degrees counter-clockwise.
side
    Sign of the pin's motion in the relative speed: 1 where the pin is pushed along the normal, -1 where the disc is.
disc_normal, disc_tangent, pin_normal, pin_tangent, shaft_normal, shaft_tangent, crank_normal, crank_tangent
    Lever arms: motion of the contact point along normal and tangent per rotation [m], with the sign of the body in the
    relative speed.
disc_centre, shaft_centre, crank_centre
    Motion along the tangent of the centre of a round surface per rotation [m].
gap
    Gap at the pose of the contact search [m].
force, slope
    Normal force at zero speed [N], and its decrease with the speed along the normal [N s/m].
friction, creep
    Coefficient of friction [1] and viscosity of the regularised friction [N s/m].
geometric_stiffness
    Tangential force per normal force and speed of the centres [s/m], from the rotation of the normal as round surfaces
    roll in each other.
cosine
    Cosine of the phase of the pin against the eccentricity, for the friction law ``film``.
speed, slip, normal_force, friction_force
    Relative speeds along normal and tangent [m/s], and the forces [N].
"""

Contact = Any
"""A record of `CONTACT` in compiled code."""

Contacts = npt.NDArray[np.void]
"""Array of contacts, of the largest possible size."""

NONE: int = np.int64(0)  # type: ignore[assignment]
"""Zero without a literal type of numba, for each of which a function is compiled once more."""

_TEETH, _SEAT, _CAM, _OUTPUT = np.int64(TEETH), np.int64(SEAT), np.int64(CAM), np.int64(OUTPUT)

MAX_TOUCHES = ROOT_SEARCH.max_touches
"""Largest number of contacts of one pair."""

njit = compiling.njit(inner=True, allocates=False, error_model="numpy", forceinline=True)
"""Compile a function that the solver calls in every step."""

_spring, _damper = njit(impact.spring), njit(impact.damper)
_onset, _roller_contact = njit(roller_needles.onset), njit(roller_needles.roller_contact)


def allocate_contacts(system: System) -> Contacts:
    """Return an array for the largest possible number of contacts of a reducer."""
    disc_count, tooth_count = len(system.offset), len(system.ring_centres)
    per_tooth = MAX_TOUCHES if system.lobes else 1
    max_contacts = disc_count * tooth_count * per_tooth + 2 * tooth_count * len(system.pin_mass)
    max_contacts += len(system.cams) * (1 + len(system.studs)) + system.bearing_contacts + 2 * system.cranks
    return np.zeros(max_contacts, dtype=CONTACT)


class MatingSurfaces(NamedTuple):
    """A pair of mating surfaces: number and law of the pair, and the unknowns of its bodies as in `CONTACT`."""

    pair: int
    law: Any
    disc: int
    pin: int
    shaft: int
    pin_shift: int


@njit
def find_contacts(
    system: System, lobes: Array | None, q: Array, v: Array, half_step: float, scratch: Array, contacts: Contacts
) -> int:
    """Find and write the contacts of all mating pairs but cranks (see ``crank_train``); return their number.

    Parameters
    ----------
    system
        The reducer as arrays for the planar solver.
    lobes
        Radii of the lobes of an internal gear [m], shape (N,); None for ring pins (nothing is compiled for lobes then).
    q, v
        Coordinates of all bodies [m], [rad] and their speeds [m/s], [rad/s], in the order of `System`, shape
        (unknowns,).
    half_step
        Half of the time step [s]: the time from the start of the step to this pose.
    scratch, contacts
        Working memory for contacts of a pair, shape (``MAX_TOUCHES``, ``STRIDE`` / 8); array of `allocate_contacts`.
    """
    disc_count, tooth_count, crank_unknown = len(system.offset), len(system.ring_centres), system.shafts[1]
    ring_pose, carrier_pose = shaft_pose(q, system.ring_shaft), shaft_pose(q, system.stud_shaft)
    crank_pose, scratch_address = shaft_pose(q, crank_unknown), np.int64(scratch.ctypes.data)
    count, pair = NONE, NONE
    for disc in range(disc_count):
        mating = MatingSurfaces(pair, system.laws[disc, TEETH], 3 * disc, -1, system.ring_shaft, NONE)
        if lobes is not None:
            count = _find_lobe_contacts(
                system, lobes, contacts, count, mating, ring_pose, scratch_address, q, v, half_step
            )
        else:
            count = _find_pin_contacts(system, contacts, count, mating, ring_pose, q, v, half_step)
        pair += tooth_count
    if system.free:
        for plane in range(len(system.pin_mass)):
            count = _find_seat_contacts(
                system, contacts, count, pair, plane, ring_pose, scratch_address, q, v, half_step
            )
        pair += tooth_count
    bore = PartialCircle(system.bore, 0.0, 1.0, -1.0, 0.0)
    for disc in range(len(system.cams)):
        mating = MatingSurfaces(pair, system.laws[disc, CAM], 3 * disc, -1, crank_unknown, NONE)
        pair += 1
        cam_x, cam_y = outwards(crank_pose, system.cams[disc, 0], system.cams[disc, 1])
        if system.needles:
            count = _find_needle_contacts(system, contacts, count, mating, cam_x, cam_y, q, v, half_step)
            continue
        cam = Round(cam_x, cam_y, q[3 * disc], q[3 * disc + 1], system.cam, 1.0)
        count += _find_round_contacts(
            system, contacts, count, mating, cam, bore, _CAM, 1.0, scratch_address, q, v, half_step
        )
    hole = PartialCircle(system.hole, 0.0, 1.0, -1.0, 0.0)
    for disc in range(len(system.cams)):
        pose_of_disc = disc_pose(q, 3 * disc, 0.0)
        for stud_index in range(len(system.studs)):
            mating = MatingSurfaces(pair, system.laws[disc, OUTPUT], 3 * disc, -1, system.stud_shaft, NONE)
            pair += 1
            stud_x, stud_y = outwards(carrier_pose, system.studs[stud_index, 0], system.studs[stud_index, 1])
            hole_x, hole_y = outwards(
                pose_of_disc, system.holes[disc, stud_index, 0], system.holes[disc, stud_index, 1]
            )
            pin = Round(stud_x, stud_y, pose_of_disc.x + hole_x, pose_of_disc.y + hole_y, system.stud, 1.0)
            new_contacts = _find_round_contacts(
                system, contacts, count, mating, pin, hole, _OUTPUT, 1.0, scratch_address, q, v, half_step
            )
            for i in range(new_contacts if system.roller_needles.needles else 0):
                _add_needle_compliance(system, contacts[count + i], mating.law, q, v, half_step)
            count += new_contacts
    return count


@njit
def _add_needle_compliance(system: System, contact: Contact, law: Any, q: Array, v: Array, half_step: float) -> None:
    """Add the compliance of a roller's needles to its contact with a hole: both act as springs in series.

    The total force is nonlinear; gap and stiffness of `contact` become those of its tangent, a linear spring. `system`
    is the reducer as arrays, `law` is the law of the contact with the hole (`LAW`), `q` and `v` are the coordinates of
    all bodies and their speeds, shape (unknowns,) [m, rad, m/s, rad/s], and `half_step` is half of the time step [s].
    """
    needles = system.roller_needles
    carrier_angle = q[system.stud_shaft] if system.stud_shaft >= 0 else 0.0
    cage_angle = carrier_angle + needles.cage_ratio * (q[system.shafts[1]] - carrier_angle)
    angle = math.atan2(-contact.nx, contact.ny) - cage_angle
    onset_approach, approach, factor = _onset(needles, angle), needles.clearance - contact.gap, 1.0
    contact.gap = onset_approach - approach
    if approach > onset_approach:
        force, slope = _roller_contact(
            approach, angle, law.stiffness, needles.needles, needles.stiffness, needles.clearance
        )
        contact.gap, factor = -force / slope, slope / law.stiffness
    chord_excess = _chord_excess(q, v, contact.disc, contact.nx, contact.ny, half_step)
    linearise_law(contact, law, factor, chord_excess, v, half_step)
    set_film_friction(system, contact, _OUTPUT, 1.0, v)


@njit
def _find_needle_contacts(
    system: System,
    contacts: Contacts,
    count: int,
    mating: MatingSurfaces,
    cam_x: float,
    cam_y: float,
    q: Array,
    v: Array,
    half_step: float,
) -> int:
    """Write a contact for each roller of a cam to `contacts` after `count` others; return the new number of contacts.

    `system` is the reducer as arrays, with the ratio of the cage. `mating` is the pair of bore and cam, (`cam_x`,
    `cam_y`) [m] is the centre of the cam, `q` and `v` are the coordinates of all bodies and their speeds, shape
    (unknowns,) [m, rad, m/s, rad/s], and `half_step` is half of the time step [s].
    """
    dx, dy, clearance = cam_x - q[mating.disc], cam_y - q[mating.disc + 1], system.bore - system.cam
    disc_rotation = q[mating.disc + 2]
    cage_angle, spacing = (
        disc_rotation + system.cage_ratio * (q[mating.shaft] - disc_rotation),
        2.0 * math.pi / system.needles,
    )
    friction_share = resultant_share(dx, dy, clearance, cage_angle, system.needles)
    for needle in range(system.needles):
        nx, ny = -math.sin(cage_angle + needle * spacing), math.cos(cage_angle + needle * spacing)
        gap, contact = clearance - dx * nx - dy * ny, contacts[count]
        contact_radius = system.cam + 0.5 * gap
        _fill_contact(
            contact,
            mating,
            Touch(gap, cam_x + contact_radius * nx, cam_y + contact_radius * ny, 1.0, nx, ny),
            1.0,
            q,
            v,
            half_step,
        )
        set_film_friction(system, contact, _CAM, 1.0, v)
        scale_friction(contact, friction_share, v)
        count += 1
    return count


@njit
def resultant_share(dx: float, dy: float, clearance: float, cage: float, needles: int) -> float:
    """Return the resultant of the forces of the needles of a bearing over their sum [1]; 1 without forces.

    The forces are in proportion to the penetrations. The inner part is displaced by (`dx`, `dy`) in its bore [m],
    `clearance` is radial [m], and the first needle is at the angle `cage` [rad] from +y. The friction of a bearing acts
    on the resultant, which reduces the coefficient of each needle by this share.
    """
    spacing, force_sum, resultant_x, resultant_y = 2.0 * math.pi / needles, 0.0, 0.0, 0.0
    for needle in range(needles):
        nx, ny = -math.sin(cage + needle * spacing), math.cos(cage + needle * spacing)
        depth = max(dx * nx + dy * ny - clearance, 0.0)
        force_sum, resultant_x, resultant_y = force_sum + depth, resultant_x + depth * nx, resultant_y + depth * ny
    return math.sqrt(resultant_x**2 + resultant_y**2) / force_sum if force_sum > 0.0 else 1.0


@njit
def scale_friction(contact: Contact, share: float, v: Array) -> None:
    """Multiply the friction coefficient of a contact by `share`; update its state at the speeds `v` of all unknowns."""
    contact.friction *= share
    if contact.normal_force > 0.0:
        contact.state = friction_state(contact, relative_speeds(contact, v)[1])


@njit
def _find_lobe_contacts(
    system: System,
    lobes: Array,
    contacts: Contacts,
    count: int,
    mating: MatingSurfaces,
    ring_pose: Pose,
    scratch_address: int,
    q: Array,
    v: Array,
    half_step: float,
) -> int:
    """Write the contacts of a disc and all lobes to `contacts` after `count` others; return the new number of contacts.

    `system` is the reducer as arrays, `lobes` are the radii of the lobes [m]. `mating` is the pair of the disc and the
    first lobe, `ring_pose` the pose of the ring, `scratch_address` the memory address of the `scratch` of
    `find_contacts`. `q` and `v` are the coordinates of all bodies and their speeds, shape (unknowns,) [m, rad, m/s,
    rad/s], `half_step` is half of the time step [s].
    """
    disc = mating.disc // 3
    gear, teeth = disc_pose(q, mating.disc, system.tooth_rotation[disc]), _disc_teeth(system, disc)
    for lobe in range(len(lobes)):
        lobe_pair = MatingSurfaces(mating.pair + lobe, mating.law, mating.disc, -1, mating.shaft, NONE)
        lobe_x, lobe_y = outwards(ring_pose, system.ring_centres[lobe, 0], system.ring_centres[lobe, 1])
        cosine, sine = outwards(ring_pose, system.outward[lobe, 1], -system.outward[lobe, 0])
        for touch in range(
            lobe_touches(
                scratch_address, teeth, lobes[lobe], Pose(lobe_x, lobe_y, cosine, sine), gear, CONTACT_SEARCH.margin
            )
        ):
            _fill_contact(
                contacts[count], lobe_pair, read_touch(scratch_address + STRIDE * touch), -1.0, q, v, half_step
            )
            set_film_friction(system, contacts[count], _TEETH, phase_cosine(lobe_x, lobe_y, gear.x, gear.y), v)
            count += 1
    return count


@njit
def _find_pin_contacts(
    system: System,
    contacts: Contacts,
    count: int,
    mating: MatingSurfaces,
    ring_pose: Pose,
    q: Array,
    v: Array,
    half_step: float,
) -> int:
    """Write the contacts of a disc and all ring pins to `contacts` after `count` others; return the new number.

    `system` is the reducer as arrays. `mating` is the pair of the disc and the first pin, `ring_pose` the pose of the
    ring. `q` and `v` are the coordinates of all bodies and their speeds, shape (unknowns,) [m, rad, m/s, rad/s],
    `half_step` is half of the time step [s].
    """
    disc, first_pin = mating.disc // 3, len(system.inertia)
    gear, teeth, pin_values = (
        disc_pose(q, mating.disc, system.tooth_rotation[disc]),
        _disc_teeth(system, disc),
        system.ring,
    )
    plane_count = len(system.pin_mass)
    shift = plane_shift(disc) if plane_count > 1 else NONE
    for pin_index in range(len(system.ring_centres)):
        pin_unknown, shaft = -1, mating.shaft
        if system.free:
            pin_unknown, shaft = first_pin + (2 * plane_count + 1) * pin_index, -1
            pin_x, pin_y = q[pin_unknown + shift], q[pin_unknown + shift + 1]
        else:
            pin_x, pin_y = outwards(ring_pose, system.ring_centres[pin_index, 0], system.ring_centres[pin_index, 1])
        pin = RingPin(
            pin_values[pin_index, 0],
            pin_values[pin_index, 1],
            pin_values[pin_index, 2],
            pin_values[pin_index, 3],
            pin_values[pin_index, 4],
            pin_values[pin_index, 5],
        )
        pin_contact = pin_touch(teeth, pin, gear, pin_x, pin_y, CONTACT_SEARCH.margin)
        if not pin_contact.exists:
            continue
        contact, touch = contacts[count], pin_contact.touch
        pin_pair = MatingSurfaces(mating.pair + pin_index, mating.law, mating.disc, pin_unknown, shaft, shift)
        _fill_contact(contact, pin_pair, touch, -1.0, q, v, half_step)
        set_film_friction(system, contact, _TEETH, phase_cosine(pin_x, pin_y, gear.x, gear.y), v)
        count += 1
        if system.free:
            contact.disc_centre = -(pin_x - gear.x) * touch.nx - (pin_y - gear.y) * touch.ny
            # The distance of a point beyond a curve of curvature k bends by k/(1 + k distance).
            offset = pin.radius + touch.gap - teeth.flank.offset
            contact.geometric_stiffness = -half_step * pin_contact.curvature / (1.0 + pin_contact.curvature * offset)
    return count


@njit
def _find_seat_contacts(
    system: System,
    contacts: Contacts,
    count: int,
    first_pair: int,
    plane: int,
    ring_pose: Pose,
    scratch_address: int,
    q: Array,
    v: Array,
    half_step: float,
) -> int:
    """Write the contacts of moving pins with their seats to `contacts` after `count` others; return the new number.

    `system` is the reducer as arrays. `first_pair` is the index of the first pin's pair, `plane` that of the disc in
    whose plane the contacts are, `ring_pose` the pose of the ring, `scratch_address` the memory address of the
    `scratch` of `find_contacts`. `q` and `v` are the coordinates of all bodies and their speeds, shape (unknowns,) [m,
    rad, m/s, rad/s], `half_step` is half of the time step [s].
    """
    first_pin, shift = len(system.inertia), plane_shift(plane)
    for seat in range(len(system.ring_centres)):
        pin_unknown = first_pin + (2 * len(system.pin_mass) + 1) * seat
        pin_x, pin_y = q[pin_unknown + shift], q[pin_unknown + shift + 1]
        mating = MatingSurfaces(first_pair + seat, system.laws[0, SEAT], -1, pin_unknown, system.ring_shaft, shift)
        seat_x, seat_y = outwards(ring_pose, system.ring_centres[seat, 0], system.ring_centres[seat, 1])
        if system.sleeved:
            outer = PartialCircle(system.outer[seat], 0.0, 1.0, -1.0, 0.0)
            inner = Round(seat_x, seat_y, pin_x, pin_y, system.inner[seat], 1.0)
        else:
            outward_x, outward_y = outwards(ring_pose, system.outward[seat, 0], system.outward[seat, 1])
            outer = PartialCircle(system.outer[seat], outward_x, outward_y, system.arc[0], system.arc[1])
            inner = Round(pin_x, pin_y, seat_x, seat_y, system.inner[seat], -1.0)
        cosine = _largest_force_phase_cosine(contacts, count, pin_unknown, shift) if system.film.size else 1.0
        count += _find_round_contacts(
            system, contacts, count, mating, inner, outer, _SEAT, cosine, scratch_address, q, v, half_step
        )
    return count


@njit
def _largest_force_phase_cosine(contacts: Contacts, count: int, pin_unknown: int, shift: int) -> float:
    """Return the cosine of the phase [1] of a moving pin relative to the disc that presses on it most; 1 without force.

    The phase is the angle between the directions of pin and disc from the axis. The pin is that whose first unknown has
    the index `pin_unknown`. Of the first `count` contacts, those with a disc in the plane of the seat are considered,
    whose x follows the first unknown of the pin by `shift` (`plane_shift`).
    """
    largest_force, cosine = -1.0, 1.0
    for contact_index in range(count):
        contact = contacts[contact_index]
        is_of_seat = contact.pin == pin_unknown and contact.pin_shift == shift
        if is_of_seat and contact.disc >= 0 and contact.normal_force > largest_force:
            largest_force, cosine = contact.normal_force, contact.cosine
    return cosine


@njit
def set_film_friction(system: System, contact: Contact, kind: int, cosine: float, v: Array) -> None:
    """Set friction coefficient and state (sticking, sliding) of a contact by the friction law ``film`` (lubricated).

    Nothing is changed with the law ``coulomb``. `system` is the reducer as arrays. `kind` is the row of the contact in
    the film table, `cosine` the cosine of the angle between the directions of its pin and of the disc's centre, and `v`
    are the speeds of all coordinates, shape (unknowns,).
    """
    if system.film.size == 0:
        return
    contact.cosine = cosine
    contact.friction = look_up(np.int64(system.film.ctypes.data), kind, cosine, contact.normal_force)
    if contact.normal_force > 0.0:
        contact.state = friction_state(contact, relative_speeds(contact, v)[1])


@njit
def plane_shift(plane: int) -> int:
    """Return the number of unknowns of a pin before x and y in a plane of contact.

    The unknowns are x and y in the first plane, the rotation, then x and y in the second plane.
    """
    return 2 * plane + 1 if plane > 0 else NONE


@njit
def shaft_pose(q: Array, shaft: int) -> Pose:
    """Return the pose of a body that rotates about the axis of the reducer by an unknown; -1 stands for no rotation."""
    rotation = q[shaft] if shaft >= 0 else 0.0
    return Pose(0.0, 0.0, math.cos(rotation), math.sin(rotation))


@njit
def disc_pose(q: Array, body: int, angle: float) -> Pose:
    """Return the pose of a disc, rotated clockwise by an angle [rad]."""
    rotation = q[body + 2] - angle
    return Pose(q[body], q[body + 1], math.cos(rotation), math.sin(rotation))


@njit
def _disc_teeth(system: System, disc: int) -> Teeth:
    """Return the tooth geometry of a disc: that of all discs in `system`, with the flank offset of this disc.

    `disc` is the index of the disc.
    """
    shared_teeth, flank = system.teeth, system.teeth.flank
    ends = flank.tip, flank.tip_radius, flank.valley, flank.valley_radius
    flank_of_disc = Flank(
        flank.curve, system.offset[disc], flank.rotation, ends[0], ends[1], ends[2], ends[3], flank.waves
    )
    return Teeth(
        flank_of_disc, shared_teeth.reference, shared_teeth.constant, shared_teeth.deflection, shared_teeth.ring
    )


class Round(NamedTuple):
    """A circle with centre (x, y) within a circle with centre (around_x, around_y) [m].

    `sign` is 1 if the outer circle is the body that is pushed, else -1.
    """

    x: float
    y: float
    around_x: float
    around_y: float
    radius: float
    sign: float


@njit
def _find_round_contacts(
    system: System,
    contacts: Contacts,
    first_contact: int,
    mating: MatingSurfaces,
    inner: Round,
    outer: PartialCircle,
    film_row: int,
    pin_cosine: float,
    scratch_address: int,
    q: Array,
    v: Array,
    half_step: float,
) -> int:
    """Write the contacts of a circle within another circle or arc, and return their number.

    Parameters
    ----------
    system, contacts, half_step
        The reducer, the array that is filled, and half of the time step [s].
    q, v
        Coordinates of all bodies [m], [rad] and their speeds [m/s], [rad/s], shape (unknowns,).
    first_contact
        Index of the first contact to be written.
    mating
        The mating pair.
    inner, outer
        The inner circle and the outer circle or arc.
    film_row, pin_cosine
        Row of the pair in the table of lubricated friction, and cosine of the angle between the directions of its ring
        pin and of the disc's centre, 1 for other pairs.
    scratch_address
        Memory address of the `scratch` of `find_contacts`.
    """
    dx, dy = inner.x - inner.around_x, inner.y - inner.around_y
    count = inner_touches(scratch_address, dx, dy, inner.x, inner.y, inner.radius, outer, CONTACT_SEARCH.margin)
    for contact_index in range(count):
        touch, contact = read_touch(scratch_address + STRIDE * contact_index), contacts[first_contact + contact_index]
        _fill_contact(contact, mating, touch, inner.sign, q, v, half_step)
        set_film_friction(system, contact, film_row, pin_cosine, v)
        distance = math.sqrt(dx * dx + dy * dy)
        if dx * touch.nx + dy * touch.ny < (1.0 - CONTACT_SEARCH.edge_tolerance) * distance or distance == 0.0:
            continue  # a contact at an edge
        nx, ny = contact.nx, contact.ny
        if mating.disc >= 0:
            contact.disc_centre = (inner.around_x - q[mating.disc]) * nx + (inner.around_y - q[mating.disc + 1]) * ny
        if mating.shaft >= 0 and inner.sign > 0.0:
            contact.shaft_centre = -inner.x * nx - inner.y * ny
        elif mating.shaft >= 0:
            contact.shaft_centre = -inner.around_x * nx - inner.around_y * ny
        contact.geometric_stiffness = half_step / distance
    return count


@njit
def _fill_contact(
    contact: Contact, mating: MatingSurfaces, touch: Touch, sign: float, q: Array, v: Array, half_step: float
) -> None:
    """Fill a contact with normal, lever arms, linearised force and friction state at coordinates `q` and speeds `v`.

    `q` and `v` have the shape (unknowns,). `mating` is its mating pair, `touch` the result of the contact search,
    `half_step` half of the time step [s]. `sign` is 1 if the contact pushes its first body along the normal of the
    touch, and -1 if it pushes it in the opposite direction.
    """
    contact.pair = mating.pair
    contact.disc, contact.pin, contact.shaft, contact.crank = mating.disc, mating.pin, mating.shaft, -1
    contact.pin_shift = mating.pin_shift
    nx, ny = sign * touch.nx, sign * touch.ny
    contact.gap, contact.nx, contact.ny = touch.gap, nx, ny
    contact.side = 1.0 if mating.disc < 0 else -1.0
    contact.disc_centre, contact.shaft_centre, contact.geometric_stiffness = 0.0, 0.0, 0.0
    if mating.disc >= 0:
        arm_x, arm_y = touch.x - q[mating.disc], touch.y - q[mating.disc + 1]
        contact.disc_normal, contact.disc_tangent = arm_x * ny - arm_y * nx, arm_x * nx + arm_y * ny
    if mating.pin >= 0:
        x_unknown, y_unknown = mating.pin + mating.pin_shift, mating.pin + mating.pin_shift + 1
        arm_x, arm_y = touch.x - q[x_unknown], touch.y - q[y_unknown]
        contact.pin_normal, contact.pin_tangent = arm_x * ny - arm_y * nx, arm_x * nx + arm_y * ny
    if mating.shaft >= 0:
        contact.shaft_normal = touch.y * nx - touch.x * ny
        contact.shaft_tangent = -touch.x * nx - touch.y * ny
    chord_excess = _chord_excess(q, v, mating.disc, nx, ny, half_step) if mating.disc >= 0 else 0.0
    linearise_law(contact, mating.law, touch.factor, chord_excess, v, half_step)


@njit
def linearise_law(contact: Contact, law: Any, factor: float, chord_excess: float, v: Array, half_step: float) -> None:
    """Linearise the force of a contact with known gap and lever arms at speeds `v`: set force, slope, friction, state.

    The normal force is force minus slope times the speed along the normal. `v` are the speeds of all coordinates, shape
    (unknowns,), `law` is the contact law (`LAW`), `factor` multiplies its stiffness, `chord_excess` [m/s] is the error
    of the normal speed by the chord of a disc's orbit, and `half_step` is half of the time step [s].
    """
    contact.friction, contact.creep = law.friction, law.creep
    speed, slip = relative_speeds(contact, v)
    force, slope, damping = _normal_force(law, contact.gap, factor, speed, half_step)
    force += damping * chord_excess
    contact.force, contact.slope = force + slope * speed, slope
    contact.normal_force = max(force, 0.0) if contact.gap < 0.0 else 0.0
    contact.state = friction_state(contact, slip) if contact.normal_force > 0.0 else OPEN


@njit
def _chord_excess(q: Array, v: Array, disc: int, nx: float, ny: float, half_step: float) -> float:
    """Compute the error of the normal speed [m/s] of a disc that circles about the axis.

    A step moves a disc, which circles with the angular speed w, along a chord of its path. The speed of the step,
    length of the chord over time, is v tan(w h)/(w h), with half a time step h and the speed v of circling in the
    middle of the chord. It is too large by (w h)^2/3 v, the result. `q` and `v` are all coordinates and speeds, `disc`
    is the index of the disc's x there. (`nx`, `ny`) is the normal of the contact, `half_step` is h [s].
    """
    x, y, vx, vy = q[disc], q[disc + 1], v[disc], v[disc + 1]
    angle = half_step * (x * vy - y * vx) / (x * x + y * y)
    return angle * angle / 3.0 * (nx * vx + ny * vy)


@njit
def _normal_force(law: Any, gap: float, factor: float, speed: float, half_step: float) -> tuple[float, float, float]:
    """Compute the normal force of a contact law at a gap and a speed, with its slope; the force may be negative.

    `law` is a record of `LAW`. `gap` [m] is negative in contact, `factor` [1] multiplies the stiffness of a line
    contact, and `speed` [m/s] along the normal is positive where the gap opens.

    Returns
    -------
    tuple of float
        Force [N]; its decrease per increase of the speed [N s/m], if that also opens the gap for the time `half_step`
        [s]; and damping [N s/m].
    """
    if law.impact == 0.0:
        stiffness = law.stiffness * factor
        return -stiffness * gap - law.damping * speed, stiffness * half_step + law.damping, law.damping
    depth = max(-gap, impact.MIN_DEPTH)
    spring_force = _spring(depth, law.impact, law.exponent)
    damping = _damper(depth, law.impact_damping, law.impact_depth)
    return spring_force - damping * speed, law.exponent * spring_force / depth * half_step + damping, damping


@njit
def relative_speeds(contact: Contact, v: Array) -> tuple[float, float]:
    """Compute the relative speed of a contact's surfaces at the speeds `v` of all bodies.

    `v` are the speeds of all coordinates, shape (unknowns,) [m/s, rad/s].

    Returns
    -------
    tuple of float
        Speed along the normal, positive where the gap opens, and along the tangent [m/s], both of the body that is
        pushed along the normal. The tangent is the normal rotated by 90 degrees counter-clockwise.
    """
    disc, pin, shaft, crank = contact.disc, contact.pin, contact.shaft, contact.crank
    nx, ny = contact.nx, contact.ny
    normal_speed, tangential_speed = 0.0, 0.0
    if disc >= 0:
        normal_speed += nx * v[disc] + ny * v[disc + 1] + contact.disc_normal * v[disc + 2]
        tangential_speed += nx * v[disc + 1] - ny * v[disc] + contact.disc_tangent * v[disc + 2]
    if pin >= 0:
        vx, vy = v[pin + contact.pin_shift], v[pin + contact.pin_shift + 1]
        normal_speed += contact.side * (nx * vx + ny * vy + contact.pin_normal * v[pin + 2])
        tangential_speed += contact.side * (nx * vy - ny * vx + contact.pin_tangent * v[pin + 2])
    if shaft >= 0:
        normal_speed += contact.shaft_normal * v[shaft]
        tangential_speed += contact.shaft_tangent * v[shaft]
    if crank >= 0:
        normal_speed += contact.crank_normal * v[crank]
        tangential_speed += contact.crank_tangent * v[crank]
    return normal_speed, tangential_speed


@njit
def rolling_speed(contact: Contact, v: Array) -> float:
    """Compute the speed [m/s] of the centre of a round surface, such as a pin, past its mate along the tangent.

    This motion, as a pin rolls or slides along its mate, rotates the contact normal (`geometric_stiffness`). `v` are
    the speeds of all coordinates, shape (unknowns,).
    """
    disc, pin, shaft, speed = contact.disc, contact.pin, contact.shaft, 0.0
    if disc >= 0:
        speed += contact.nx * v[disc + 1] - contact.ny * v[disc] + contact.disc_centre * v[disc + 2]
    if pin >= 0:
        vx, vy = v[pin + contact.pin_shift], v[pin + contact.pin_shift + 1]
        speed += contact.side * (contact.nx * vy - contact.ny * vx)
    if shaft >= 0:
        speed += contact.shaft_centre * v[shaft]
    if contact.crank >= 0:
        speed += contact.crank_centre * v[contact.crank]
    return speed


@njit
def friction_state(contact: Contact, slip: float) -> int:
    """Return the state of a closed contact at a slip [m/s]: sticking, or sliding in one of both directions."""
    if contact.creep * abs(slip) <= contact.friction * contact.normal_force:
        return STICKS
    return SLIDES if slip > 0.0 else SLIDES_BACK
