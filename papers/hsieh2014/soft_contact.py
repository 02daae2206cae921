"""The mechanism without load, with the contact of a commercial motion solver: soft springs, on flanks of facets.

An independent planar computation without friction. It shares with the package only the distances to the trochoid and to
the half-open sockets. The crank turns at constant speed. Gear, free pins and output move by Newton's law under gravity
and the function IMPACT, F = k d^e + c step(d) d', with the depth d. The damping rises as a cubic step from zero at the
surface to its full value at a given depth.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit

from cycloid_mj.base.array import Array
from cycloid_mj.base.compiling import cacheable
from cycloid_mj.design import Design
from cycloid_mj.dynamics.contact.gap import (
    PartialCircle,
    Trochoid,
    circle_at_edge,
    circle_in_circle,
    nearest_on_arc,
    trochoid_curvature,
    trochoid_distance,
)
from cycloid_mj.parts import mass_properties, parts
from cycloid_mj.reducer import Reducer, impact
from cycloid_mj.reducer.sockets import socket_half_angle
from hsieh2014.peaks import BINS

TIMESTEP = 0.5e-6
"""Time step [s]."""


OTHERS = 8
"""Number of fields of `PeakForces` before its curve."""


_spring_at, _damper_at = njit(impact.spring), njit(impact.damper)


@dataclass(frozen=True)
class SoftContact:
    """Parameters of IMPACT."""

    name: str
    """Description of where these parameters are the default."""
    stiffness: float
    exponent: float
    """k [N/m^e] and e of the spring."""
    damping: float
    depth: float
    """Full damping c [N s/m], and the depth at which it is reached [m]."""


def in_millimetres(name: str, stiffness: float, exponent: float, damping: float, depth: float) -> SoftContact:
    """Return parameters from N/mm^e, N s/mm and mm."""
    return SoftContact(name, stiffness * 1e3**exponent, exponent, damping * 1e3, depth * 1e-3)


STEEL = in_millimetres("steel on steel, dry or greasy", 1e5, 1.5, 50.0, 0.1)
"""The material table of ADAMS, also in SolidWorks Motion (COSMOSMotion): stiffness 100 000,
damping 50, exponent 1.5, penetration 0.1 (N, mm, s), as listed at https://www.cnblogs.com/sxhui/p/14557852.html.
"""

GENERIC = in_millimetres("unnamed material", 1e5, 2.2, 10.0, 0.1)
"""The default without a material: stiffness 1e5 N/mm, exponent 2.2, damping 10 N s/mm ("Contact Parameters for
Parts with Small Mass", Adams View help, https://adams.thisaray.com/adams_view/building_models_contacts.11.10.html).

It detects 3-D contacts on polygons by default (RAPID; CONTACT statement, Adams Solver help,
https://adams.thisaray.com/adams_solver/state_contact.html).
"""


@dataclass(frozen=True)
class PeakForces:
    """Largest normal force of each kind of contact over the evaluated turns [N], and motion of gear and pins.

    `tooth`: gear on a pin or on the internal gear; `seat`: pin in its socket (the tooth if there is none); `cam`;
    `output`; `sampled`: the cam's largest force at one sample per degree. `rms` is the rms error of the gear's speed
    [rad/s], `q_rms` that of the speed of q, the centre of hole 1 [m/s], `reach` the largest displacement of a pin [m],
    `curve` the cam's largest force in each of `BINS` parts of a crank turn, from gravity's direction on [N].
    """

    tooth: float
    seat: float
    cam: float
    output: float
    sampled: float
    rms: float = math.nan
    q_rms: float = math.nan
    reach: float = math.nan
    curve: tuple[float, ...] = ()


def line_contacts(design: Design) -> SoftContact:
    """Return linear springs with the stiffness and damping of the design's line contacts."""
    reducer = Reducer(design)
    stiffness = reducer.contacts[design.tooth_pair].stiffness
    mass = mass_properties(parts(reducer)["gear"]).mass / design.ring.teeth
    return SoftContact("line contacts, as here", stiffness, 1.0, math.sqrt(stiffness * mass), 1e-15)


def soft_idle(
    design: Design, contact: SoftContact, chord_error: float, turns: int, seed: int, phase: float = 0.0
) -> PeakForces:
    """Simulate a reducer without load with soft contacts and return its largest forces.

    Parameters
    ----------
    design
        A reducer with free pins, or with an internal gear, of which only the arcs are included.
    contact
        Parameters of every contact.
    chord_error
        Mean distance [m] between the middle of a facet and the flank; 0 for exact flanks. A facet of a concave
        section protrudes from the flank, one of a convex section is behind it.
    turns
        Evaluated crank turns.
    seed
        Seed of the facets' heights, which are uniform between 0 and twice the mean.
    phase
        Crank angle at the start [rad].
    """
    body = {name: mass_properties(solid) for name, solid in parts(Reducer(design)).items()}
    ring, gear, output = design.ring, design.gear, design.output
    free = ring.has_sockets
    facets = _facets(design, chord_error, seed)
    pin = body["pin"].mass if free else 1.0
    values = np.array(
        [
            *(ring.pin_circle_radius, gear.eccentricity, ring.pin_radius, design.drive.speed),
            *(design.clearance.pin_gear if free else design.clearance.tooth, design.clearance.pin_socket),
            *(design.clearance.cam, output.pin_circle_radius),
            output.hole_radius + design.clearance.output - output.pin_radius,
            *(body["gear"].mass, float(body["gear"].inertia[2, 2]), pin, float(body["output"].inertia[2, 2])),
            *(design.environment.gravity_x, design.environment.gravity_y, phase),
            *(contact.stiffness, contact.exponent, contact.damping, contact.depth),
            socket_half_angle(design) if free else math.pi,
        ]
    )
    turn = 2.0 * math.pi / abs(design.drive.speed)
    steps = math.ceil((0.5 + turns) * turn / TIMESTEP)
    turned = _integrate(values, ring.teeth, output.pins, free, facets, steps, TIMESTEP, round(turn / TIMESTEP))
    tooth, seat, cam, output_force, sampled, rms, q_rms, reach = turned[:OTHERS].tolist()
    return PeakForces(tooth, seat, cam, output_force, sampled, rms, q_rms, reach, tuple(turned[OTHERS:].tolist()))


def _facets(design: Design, chord_error: float, seed: int) -> Array:
    """Return the chord error of each facet [m], shape (lobes, facets of a lobe).

    A chord of a circle of the valley's radius has this error at a length of sqrt(8 R error).
    """
    if chord_error == 0.0:
        return np.zeros((design.lobes, 1))
    length = 2.0 * math.pi * design.ring.pin_circle_radius / design.lobes
    count = max(round(length / math.sqrt(8.0 * design.ring.pin_radius * chord_error)), 2)
    return np.random.default_rng(seed).uniform(0.0, 2.0 * chord_error, (design.lobes, count))


@njit
def _facet_height(t: float, facets: Any, curve: Trochoid) -> float:
    """Return how far the facet at the parameter t [rad] of the trochoid `curve` protrudes from the flank [m].

    `facets` are chord errors [m], shape (lobes, facets of a lobe).
    """
    lobes, count = facets.shape
    if count == 1:
        return 0.0
    position = t * lobes / (2.0 * math.pi)
    lobe = math.floor(position)
    along = (position - lobe) * count
    facet = min(int(along), count - 1)
    share = along - facet
    side = 1.0 if trochoid_curvature(t, curve) < 0.0 else -1.0
    return side * facets[int(lobe) % lobes, facet] * 4.0 * share * (1.0 - share)


@njit
def _move_pin(pin: Any, home: float, tooth: Any, values: Any, timestep: float) -> Any:
    """Move a free pin by a time step; return the force of the gear and the larger force of socket or edge on it [N].

    `pin` has displacement [m] and velocity [m/s], shape (4,), and is modified; `home` is its angle on the ring [rad].
    `tooth` is the contact with the gear: normal (2), the gear's velocity there (2), spring force and damping. `values`
    are the parameters of `soft_idle`. Dampers act on the speed at the end of the step: a pin is too light for them
    otherwise.
    """
    rho, socket, pin_mass, half = values[2], values[5], values[11], values[20]
    gravity_x, gravity_y, k, e, damping, full = values[13], values[14], values[16], values[17], values[18], values[19]
    nx, ny, gx, gy, spring, damper = tooth
    arc = PartialCircle(rho + socket, math.sin(home), math.cos(home), math.cos(half), math.sin(half))
    side, on_arc, other = nearest_on_arc(pin[0], pin[1], arc)
    if on_arc:
        out, sx, sy = circle_in_circle(pin[0], pin[1], rho, rho + socket)
    else:
        out, sx, sy = circle_at_edge(pin[0], pin[1], rho, arc, side)
    seat, normal = _spring_at(-out, k, e), _damper_at(-out, damping, full)
    # the edge across the opening, between which and the first the pin may be caught
    out, ox, oy = circle_at_edge(pin[0], pin[1], rho, arc, -side)
    edge, against = _spring_at(-out, k, e), _damper_at(-out, damping, full)
    if half == math.pi or not other:
        edge, against = 0.0, 0.0
    axx = pin_mass + timestep * (damper * nx * nx + normal * sx * sx + against * ox * ox)
    ayy = pin_mass + timestep * (damper * ny * ny + normal * sy * sy + against * oy * oy)
    axy = timestep * (damper * nx * ny + normal * sx * sy + against * ox * oy)
    pushed = spring + damper * (gx * nx + gy * ny)
    bx, by = pushed * nx - seat * sx - edge * ox, pushed * ny - seat * sy - edge * oy
    bx = pin_mass * (pin[2] + timestep * gravity_x) + timestep * bx
    by = pin_mass * (pin[3] + timestep * gravity_y) + timestep * by
    determinant = axx * ayy - axy * axy
    wx, wy = (ayy * bx - axy * by) / determinant, (axx * by - axy * bx) / determinant
    pin[0] += timestep * wx
    pin[1] += timestep * wy
    pin[2], pin[3] = wx, wy
    force = max(spring - damper * ((wx - gx) * nx + (wy - gy) * ny), 0.0)
    return force, max(seat + normal * (wx * sx + wy * sy), edge + against * (wx * ox + wy * oy))


@njit
def _press_teeth(gear: Any, force: Any, pins: Any, free: bool, facets: Any, values: Any, timestep: float) -> Any:
    """Return the `force` (2) and torque on the gear with those of the teeth added; move free pins, in place.

    Also return the largest forces of teeth and sockets [N], and the largest displacement of a pin [m]. `gear` has
    position, angle and their rates; `values` are the parameters of `soft_idle`.
    """
    x, y, turned, vx, vy, spin = gear
    fx, fy, moment = force
    radius, c, rho, play = values[0], values[1], values[2], values[4]
    k, e, damping, full = values[16], values[17], values[18], values[19]
    teeth = pins.shape[0]
    curve = Trochoid(radius, c, float(teeth))
    sine, cosine = math.sin(turned), math.cos(turned)
    largest, largest_seat, reach = 0.0, 0.0, 0.0
    for i in range(teeth):
        home = 2.0 * math.pi * i / teeth
        dx, dy = radius * math.sin(home) + pins[i, 0] - x, radius * math.cos(home) + pins[i, 1] - y
        t, distance, bx, by = trochoid_distance(cosine * dx + sine * dy, cosine * dy - sine * dx, curve)
        nx, ny = cosine * bx - sine * by, sine * bx + cosine * by
        gap = distance + play - _facet_height(t, facets, curve)
        # the gear's speed where they touch
        rx, ry = dx - rho * nx, dy - rho * ny
        gx, gy = vx - spin * ry, vy + spin * rx
        spring, damper = _spring_at(-gap, k, e), _damper_at(-gap, damping, full)
        if free:
            pressed, seat = _move_pin(pins[i], home, (nx, ny, gx, gy, spring, damper), values, timestep)
            largest_seat = max(largest_seat, seat)
            reach = max(reach, math.sqrt(pins[i, 0] ** 2 + pins[i, 1] ** 2))
        else:
            pressed = max(spring + damper * (gx * nx + gy * ny), 0.0)
        if pressed > 0.0:
            fx -= pressed * nx
            fy -= pressed * ny
            moment -= pressed * (rx * ny - ry * nx)
            largest = max(largest, pressed)
    return (fx, fy, moment), largest, largest_seat, reach


@njit
def _press_output_pins(gear: Any, force: Any, output: Any, holes: int, values: Any) -> Any:
    """Return the `force` (2) and torque on the gear with those of the output pins added.

    Also return the torque on the output [N m] and the largest force [N]. `gear` has position, angle and their rates,
    `output` its angle and rate; `values` are the parameters of `soft_idle`.
    """
    x, y, turned, vx, vy, spin = gear
    fx, fy, moment = force
    angle, slow = output
    circle, room, k, e, damping, full = values[7], values[8], values[16], values[17], values[18], values[19]
    torque, largest = 0.0, 0.0
    sine, cosine, so, co = math.sin(turned), math.cos(turned), math.sin(angle), math.cos(angle)
    for j in range(holes):
        home = 2.0 * math.pi * j / holes
        sj, cj = circle * math.sin(home), circle * math.cos(home)
        qx, qy = co * sj - so * cj, so * sj + co * cj
        hx, hy = cosine * sj - sine * cj, sine * sj + cosine * cj
        gap, nx, ny = circle_in_circle(qx - x - hx, qy - y - hy, 0.0, room)
        closing = (-slow * qy - vx + spin * hy) * nx + (slow * qx - vy - spin * hx) * ny
        pressed = max(_spring_at(-gap, k, e) + _damper_at(-gap, damping, full) * closing, 0.0)
        if pressed > 0.0:
            fx += pressed * nx
            fy += pressed * ny
            moment += pressed * (hx * ny - hy * nx)
            torque -= pressed * (qx * ny - qy * nx)
            largest = max(largest, pressed)
    return (fx, fy, moment), torque, largest


@njit(cache=cacheable(), nogil=True)
def _integrate(
    values: Any, teeth: int, holes: int, free: bool, facets: Any, steps: int, timestep: float, per_turn: int
) -> Any:
    """Integrate the motion by semi-implicit Euler; return the first `OTHERS` fields of `PeakForces`, then its curve.

    `values` are the parameters of `soft_idle`; the last full turns, of `per_turn` steps each, are evaluated.
    """
    c, speed, cam_play, circle = values[1], values[3], values[6], values[7]
    gear_mass, gear_inertia, output_inertia = values[9], values[10], values[12]
    gravity_x, gravity_y, phase, k, e, damping, full = values[13:20]
    lobes = facets.shape[0]
    settled, stride = steps - (steps // per_turn) * per_turn, per_turn // 360
    x, y, turned = -c * math.sin(phase), c * math.cos(phase), -phase / lobes
    vx, vy, spin = -c * speed * math.cos(phase), -c * speed * math.sin(phase), -speed / lobes
    angle, slow = turned, spin
    pins = np.zeros((teeth, 4))
    largest, squares, of_q = np.zeros(OTHERS + BINS), 0.0, 0.0
    for number in range(steps):
        theta = phase + speed * number * timestep
        gear, force = (x, y, turned, vx, vy, spin), (gear_mass * gravity_x, gear_mass * gravity_y, 0.0)
        (fx, fy, moment), tooth, seat, reach = _press_teeth(gear, force, pins, free, facets, values, timestep)
        cx, cy = -c * math.sin(theta), c * math.cos(theta)
        gap, nx, ny = circle_in_circle(cx - x, cy - y, 0.0, cam_play)
        closing = (-speed * cy - vx) * nx + (speed * cx - vy) * ny
        cam = max(_spring_at(-gap, k, e) + _damper_at(-gap, damping, full) * closing, 0.0)
        force = fx + cam * nx, fy + cam * ny, moment
        (fx, fy, moment), torque, pressed = _press_output_pins(gear, force, (angle, slow), holes, values)
        if number >= settled:
            for field, value in ((0, tooth), (1, seat), (2, cam), (3, pressed), (7, reach)):
                largest[field] = max(largest[field], value)
            squares += (spin + speed / lobes) ** 2
            qx, qy = vx - spin * circle * math.cos(turned), vy - spin * circle * math.sin(turned)
            ideal = speed * (circle / lobes - c * math.cos(theta + theta / lobes))
            across = speed * c * math.sin(theta + theta / lobes)
            of_q += (math.sqrt(qx * qx + qy * qy) - math.sqrt(ideal * ideal + across * across)) ** 2
            part = OTHERS + int(theta * BINS / (2.0 * math.pi)) % BINS
            largest[part] = max(largest[part], cam)
            if number % stride == 0:
                largest[4] = max(largest[4], cam)
        vx += timestep * fx / gear_mass
        vy += timestep * fy / gear_mass
        spin += timestep * moment / gear_inertia
        slow += timestep * torque / output_inertia
        x += timestep * vx
        y += timestep * vy
        turned += timestep * spin
        angle += timestep * slow
    largest[5] = math.sqrt(squares / (steps - settled))
    largest[6] = math.sqrt(of_q / (steps - settled))
    if not free:
        largest[1] = largest[0]
    return largest
