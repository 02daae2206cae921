"""Touches of all mating pairs in a pose, each with its law and with how it moves with the unknowns.

A contact pushes one part away from another along its normal n; its tangent t is n turned counter-clockwise. It knows by
which arms a disc, a pin and a shaft move it: the speed of the part that is pushed past the other is the sum of theirs.
"""

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from cycloid_mj.base import compiling
from cycloid_mj.base.array import Array
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
from cycloid_mj.dynamics.planar.system import CAM, OUTPUT, SEAT, TEETH, System
from cycloid_mj.reducer import impact

OPEN, STICKS, SLIDES, SLIDES_BACK = range(4)
"""States of a contact; where it sticks it creeps, and where it slides it bears Coulomb's limit."""

CONTACT = np.dtype(
    [(name, np.int64) for name in ("pair", "disc", "pin", "shaft", "state")]
    + [(name, np.float64) for name in ("nx", "ny", "side")]
    + [(f"{part}_{arm}", np.float64) for part in ("disc", "pin", "shaft") for arm in ("normal", "tangent")]
    + [("disc_middle", np.float64), ("shaft_middle", np.float64)]
    + [(name, np.float64) for name in ("gap", "force", "slope", "friction", "creep", "bowl")]
    + [(name, np.float64) for name in ("speed", "slip", "pressing", "rubbing")]
)
"""A contact:

pair
    Number of its pair in the order of ``Mechanism.pairs``.
disc, pin, shaft
    First unknown of the disc, of the pin, and that of the shaft that take part, -1 where none does.
state
    One of `OPEN`, `STICKS`, `SLIDES`, `SLIDES_BACK`.
nx, ny
    Its normal.
side
    1 where the pin is pushed along it, -1 where that is a disc and the pin is pushed back.
disc_normal, disc_tangent, pin_normal, pin_tangent, shaft_normal, shaft_tangent
    By how much a turn moves the contact along normal and tangent [m]; of a shaft with the sign that it has in the speed
    of the part pushed past the other.
disc_middle, shaft_middle
    By how much a turn moves the middle of a round surface along the tangent [m], as above.
gap
    In the pose looked at [m].
force, slope
    Normal force at no speed [N], and by how much it falls with the speed along the normal [N s/m].
friction, creep
    Of its law [1], [N s/m].
bowl
    Force along the tangent per normal force and speed of the middles there [s/m]: a circle in another rolls up.
speed, slip, pressing, rubbing
    Along normal and tangent [m/s], and the forces there [N].
"""

Contact = Any
"""A record of `CONTACT` in compiled code."""

Contacts = npt.NDArray[np.void]
"""Room for contacts, shape (most,)."""

MOST_TOUCHES = 130
"""Of one pair: an internal gear's lobe may have as many as pieces that are searched apart, see ``touch``."""

_MARGIN = 1e-7
"""Gap [m] below which contacts are looked at: what closes within a step unforeseen."""

_ROUND = 1e-9
"""Share by which the normal of a contact may miss the middle of the arc around it."""

_SHALLOWEST = 1e-12
"""Least depth [m] that the law IMPACT is evaluated at."""

njit = compiling.njit(inner=True, allocates=False, error_model="numpy", forceinline=True)
"""Compile what the solver calls at every step."""

_spring, _damper = njit(impact.spring), njit(impact.damper)


def room_for_contacts(system: System) -> Contacts:
    """Make room for all contacts that a reducer may have."""
    discs, teeth = len(system.cams), len(system.place)
    of_lobe = MOST_TOUCHES if system.lobes else 1
    most = discs * teeth * of_lobe + 2 * teeth * system.free + discs * (1 + len(system.studs))
    return np.zeros(most, dtype=CONTACT)


class Meeting(NamedTuple):
    """Which surfaces meet: their pair and its law, and what takes part, as in `CONTACT`; poses and speeds there."""

    pair: int
    law: Any
    disc: int
    pin: int
    shaft: int


@njit
def find(
    system: System,
    lobes: Array | None,
    q: Array,
    v: Array,
    half: float,
    scratch: Array,
    contacts: Contacts,
) -> int:
    """Find the contacts of a pose q at speeds v, for other speeds that lead there within `half` a step [s].

    `lobes` are the radii of an internal gear's [m]; None, and nothing compiled for them, where there are pins. In
    `scratch` there is room for the touches of one pair. Returns the number of contacts.
    """
    discs, teeth, studs = len(system.cams), len(system.place), len(system.studs)
    crank, first_pin = 3 * discs + 1, 3 * discs + 2
    ring_shaft, stud_shaft = system.ring_shaft, system.stud_shaft
    ring, carrier, shaft = _about_axis(q, ring_shaft), _about_axis(q, stud_shaft), _about_axis(q, crank)
    out = scratch.ctypes.data
    count, pair = 0, 0
    for disc in range(discs):
        gear = _pose(q, 3 * disc, system.turned[disc])
        on_disc = _teeth(system, disc)
        for i in range(teeth):
            meeting = Meeting(pair, system.laws[disc, TEETH], 3 * disc, -1, ring_shaft)
            pair += 1
            px, py = outwards(ring, system.place[i, 0], system.place[i, 1])
            if lobes is not None:
                cosine, sine = outwards(ring, system.home[i, 1], -system.home[i, 0])
                for k in range(lobe_touches(out, on_disc, lobes[i], Pose(px, py, cosine, sine), gear, _MARGIN)):
                    touch = read_touch(out + STRIDE * k)
                    _fill(contacts[count], meeting, touch, -1.0, q, v, half)
                    count += 1
                continue
            pin = RingPin(
                system.ring[i, 0],
                system.ring[i, 1],
                system.ring[i, 2],
                system.ring[i, 3],
                system.ring[i, 4],
                system.ring[i, 5],
            )
            own = first_pin + 3 * i
            if system.free:
                px, py = q[own], q[own + 1]
                meeting = Meeting(meeting.pair, meeting.law, meeting.disc, own, -1)
            met = pin_touch(on_disc, pin, gear, px, py, _MARGIN)
            if not met.touches:
                continue
            contact = contacts[count]
            _fill(contact, meeting, Touch(met.gap, met.x, met.y, met.factor, met.nx, met.ny), -1.0, q, v, half)
            count += 1
            if system.free:
                contact.disc_middle = -(px - gear.x) * met.nx - (py - gear.y) * met.ny
                # The distance of a point beyond a curve of curvature k bends by k/(1 + k distance).
                beyond = pin.radius + met.gap - on_disc.flank.offset
                contact.bowl = -half * met.curvature / (1.0 + met.curvature * beyond)
    for i in range(teeth * system.free):
        own = first_pin + 3 * i
        meeting = Meeting(pair, system.laws[0, SEAT], -1, own, ring_shaft)
        pair += 1
        sx, sy = outwards(ring, system.place[i, 0], system.place[i, 1])
        if system.sleeved:
            around = PartialCircle(system.outer[i], 0.0, 1.0, -1.0, 0.0)
            round_in = Round(sx, sy, q[own], q[own + 1], system.inner[i], 1.0)
        else:
            ax, ay = outwards(ring, system.home[i, 0], system.home[i, 1])
            around = PartialCircle(system.outer[i], ax, ay, system.arc[0], system.arc[1])
            round_in = Round(q[own], q[own + 1], sx, sy, system.inner[i], -1.0)
        count += _find_round(contacts, count, meeting, round_in, around, out, q, v, half)
    whole = PartialCircle(system.bore, 0.0, 1.0, -1.0, 0.0)
    for disc in range(discs):
        meeting = Meeting(pair, system.laws[disc, CAM], 3 * disc, -1, crank)
        pair += 1
        cx, cy = outwards(shaft, system.cams[disc, 0], system.cams[disc, 1])
        round_in = Round(cx, cy, q[3 * disc], q[3 * disc + 1], system.cam, 1.0)
        count += _find_round(contacts, count, meeting, round_in, whole, out, q, v, half)
    whole = PartialCircle(system.hole, 0.0, 1.0, -1.0, 0.0)
    for disc in range(discs):
        gear = _pose(q, 3 * disc, 0.0)
        for stud in range(studs):
            meeting = Meeting(pair, system.laws[disc, OUTPUT], 3 * disc, -1, stud_shaft)
            pair += 1
            sx, sy = outwards(carrier, system.studs[stud, 0], system.studs[stud, 1])
            hx, hy = outwards(gear, system.holes[disc, stud, 0], system.holes[disc, stud, 1])
            round_in = Round(sx, sy, gear.x + hx, gear.y + hy, system.stud, 1.0)
            count += _find_round(contacts, count, meeting, round_in, whole, out, q, v, half)
    return count


@njit
def _about_axis(q: Array, shaft: int) -> Pose:
    """Compute the pose of what turns about the reducer's axis by an unknown; -1 is held."""
    turn = q[shaft] if shaft >= 0 else 0.0
    return Pose(0.0, 0.0, math.cos(turn), math.sin(turn))


@njit
def _pose(q: Array, body: int, turned: float) -> Pose:
    """Compute the pose of what is turned clockwise on a disc."""
    turn = q[body + 2] - turned
    return Pose(q[body], q[body + 1], math.cos(turn), math.sin(turn))


@njit
def _teeth(system: System, disc: int) -> Teeth:
    """Take the teeth of a disc: those of all, with an offset of their own."""
    of_all, flank = system.teeth, system.teeth.flank
    ends = flank.tip, flank.tip_radius, flank.valley, flank.valley_radius
    own = Flank(flank.curve, system.offset[disc], flank.rotation, ends[0], ends[1], ends[2], ends[3], flank.waves)
    return Teeth(own, of_all.reference, of_all.constant, of_all.deflection, of_all.ring)


class Round(NamedTuple):
    """A circle at (x, y) in one around (around_x, around_y) [m]; `sign` is 1 where the outer one is pushed, else -1."""

    x: float
    y: float
    around_x: float
    around_y: float
    radius: float
    sign: float


@njit
def _find_round(
    contacts: Contacts,
    first: int,
    meeting: Meeting,
    inner: Round,
    outer: PartialCircle,
    out: int,
    q: Array,
    v: Array,
    half: float,
) -> int:
    """Find the contacts of a circle in another, write them from the number `first` on, and return how many they are."""
    dx, dy = inner.x - inner.around_x, inner.y - inner.around_y
    count = inner_touches(out, dx, dy, inner.x, inner.y, inner.radius, outer, _MARGIN)
    for k in range(count):
        touch, contact = read_touch(out + STRIDE * k), contacts[first + k]
        _fill(contact, meeting, touch, inner.sign, q, v, half)
        away = math.sqrt(dx * dx + dy * dy)
        if dx * touch.nx + dy * touch.ny < (1.0 - _ROUND) * away or away == 0.0:
            continue  # at an edge
        nx, ny = contact.nx, contact.ny
        if meeting.disc >= 0:
            contact.disc_middle = (inner.around_x - q[meeting.disc]) * nx + (inner.around_y - q[meeting.disc + 1]) * ny
        if meeting.shaft >= 0 and inner.sign > 0.0:
            contact.shaft_middle = -inner.x * nx - inner.y * ny
        elif meeting.shaft >= 0:
            contact.shaft_middle = -inner.around_x * nx - inner.around_y * ny
        contact.bowl = half / away
    return count


@njit
def _fill(contact: Contact, meeting: Meeting, touch: Touch, sign: float, q: Array, v: Array, half: float) -> None:
    """Fill in a contact that pushes along the normal of a touch, or with a `sign` of -1 against it."""
    contact.pair = meeting.pair
    contact.disc, contact.pin, contact.shaft = meeting.disc, meeting.pin, meeting.shaft
    nx, ny = sign * touch.nx, sign * touch.ny
    contact.gap, contact.nx, contact.ny = touch.gap, nx, ny
    contact.side = 1.0 if meeting.disc < 0 else -1.0
    contact.disc_middle, contact.shaft_middle, contact.bowl = 0.0, 0.0, 0.0
    if meeting.disc >= 0:
        ax, ay = touch.x - q[meeting.disc], touch.y - q[meeting.disc + 1]
        contact.disc_normal, contact.disc_tangent = ax * ny - ay * nx, ax * nx + ay * ny
    if meeting.pin >= 0:
        ax, ay = touch.x - q[meeting.pin], touch.y - q[meeting.pin + 1]
        contact.pin_normal, contact.pin_tangent = ax * ny - ay * nx, ax * nx + ay * ny
    if meeting.shaft >= 0:
        contact.shaft_normal = touch.y * nx - touch.x * ny
        contact.shaft_tangent = -touch.x * nx - touch.y * ny
    contact.friction, contact.creep = meeting.law.friction, meeting.law.creep
    speed, slip = speeds(contact, v)
    force, slope, damping = _law(meeting.law, touch.gap, touch.factor, speed, half)
    if meeting.disc >= 0:
        force += damping * _chord_excess(q, v, meeting.disc, nx, ny, half)
    contact.force, contact.slope = force + slope * speed, slope
    contact.pressing = max(force, 0.0) if touch.gap < 0.0 else 0.0
    contact.state = rubbing_state(contact, slip) if contact.pressing > 0.0 else OPEN


@njit
def _chord_excess(q: Array, v: Array, disc: int, nx: float, ny: float, half: float) -> float:
    """Compute by how much a step overestimates the normal speed of a disc that circles about the axis [m/s].

    In the middle of a step the disc is on a chord of its circle, where it circles with the speed v. The step's own
    speed, chord over time, is v tan(w h)/(w h), h half a step: (w h)^2/3 v too much against a gap that stays constant.
    """
    x, y, vx, vy = q[disc], q[disc + 1], v[disc], v[disc + 1]
    turned = half * (x * vy - y * vx) / (x * x + y * y)
    return turned * turned / 3.0 * (nx * vx + ny * vy)


@njit
def _law(law: Any, gap: float, factor: float, speed: float, half: float) -> tuple[float, float, float]:
    """Compute the normal force [N], which may pull, how much a speed over half a step lowers it, and the damping."""
    if law.impact == 0.0:
        stiffness = law.stiffness * factor
        return -stiffness * gap - law.damping * speed, stiffness * half + law.damping, law.damping
    depth = max(-gap, _SHALLOWEST)
    spring = _spring(depth, law.impact, law.exponent)
    damping = _damper(depth, law.impact_damping, law.impact_depth)
    return spring - damping * speed, law.exponent * spring / depth * half + damping, damping


@njit
def speeds(contact: Contact, v: Array) -> tuple[float, float]:
    """Compute the speeds along normal and tangent of the part pushed past the other [m/s]."""
    body, own, shaft, nx, ny = contact.disc, contact.pin, contact.shaft, contact.nx, contact.ny
    normal, tangent = 0.0, 0.0
    if body >= 0:
        normal += nx * v[body] + ny * v[body + 1] + contact.disc_normal * v[body + 2]
        tangent += nx * v[body + 1] - ny * v[body] + contact.disc_tangent * v[body + 2]
    if own >= 0:
        normal += contact.side * (nx * v[own] + ny * v[own + 1] + contact.pin_normal * v[own + 2])
        tangent += contact.side * (nx * v[own + 1] - ny * v[own] + contact.pin_tangent * v[own + 2])
    if shaft >= 0:
        normal += contact.shaft_normal * v[shaft]
        tangent += contact.shaft_tangent * v[shaft]
    return normal, tangent


@njit
def rolling(contact: Contact, v: Array) -> float:
    """Compute the speed along the tangent of the middles of its surfaces, past each other [m/s]."""
    body, own, shaft, speed = contact.disc, contact.pin, contact.shaft, 0.0
    if body >= 0:
        speed += contact.nx * v[body + 1] - contact.ny * v[body] + contact.disc_middle * v[body + 2]
    if own >= 0:
        speed += contact.side * (contact.nx * v[own + 1] - contact.ny * v[own])
    if shaft >= 0:
        speed += contact.shaft_middle * v[shaft]
    return speed


@njit
def rubbing_state(contact: Contact, slip: float) -> int:
    """Tell whether a contact that presses creeps at a slip [m/s], or slides, and which way."""
    if contact.creep * abs(slip) <= contact.friction * contact.pressing:
        return STICKS
    return SLIDES if slip > 0.0 else SLIDES_BACK
