"""A reducer's planar equations of motion, apart from MuJoCo: exact gaps, Coulomb friction with creep, explicit steps.

The crank's motion is given. Unknown are x, y and turn of each disc, the turn of the output, and x, y and turn of each
pin that is free. A contact of gap g < 0 bears N = max(0, -(K f g + C g')), f following the relative curvature of teeth,
and rubs by -creep v up to Coulomb's limit mu N, v the speed along it. Nothing else acts but gravity and the load: no
added mass, no cone, no constraint solver. Classic Runge-Kutta steps, which must resolve every contact.

It takes ideal pinwheels, with pins fixed or in closed sockets, and a turning carrier. Frames and signs as in
``docs/conventions.md``.
"""

import math
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.compiling import cacheable, digest, njit
from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.types import Array
from cycloid_mj.design import Design
from cycloid_mj.dynamics.contact import gap
from cycloid_mj.dynamics.contact.gap import Trochoid, trochoid_curvature, trochoid_distance
from cycloid_mj.dynamics.course import braking
from cycloid_mj.dynamics.mjcf.laws import contact_laws
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.modification import gear_profile, profile_offset
from cycloid_mj.parts import MassProperties, moving_masses, output_inertia
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bodies import Mechanism, mechanism
from cycloid_mj.statics.law import curvature_law, pair_stiffness

COLUMNS = ("time", "crank", "gear", "gear_speed", "output", "output_speed", "load", "crank_torque", "cam_x", "cam_y")
"""Of a history: angles [rad] and speeds [rad/s] of crank, first gear and output; torques [N m] of the load on the
output and of the drive on the crank; force of the first cam on its gear [N]."""


class Law(NamedTuple):
    """Stiffness K [N/m], damping C [N s/m], friction [1] and creep [N s/m] of a kind of contact."""

    stiffness: float
    damping: float
    friction: float
    creep: float


class Teeth(NamedTuple):
    """Flanks and what meets them.

    Attributes
    ----------
    curve, offset
        Trochoid of the gear, and how far its flanks stand outside of it [m].
    turned
        Angle by which each disc's teeth are turned on it, clockwise [rad], shape (discs,).
    radius, play, yielding
        Of a pin [m]; what a massless one gives way by [m], and a pin on a flat's stiffness over that of its seat [1].
    reference, constant
        Compliance of a pin on a flat, and how it follows the relative curvature (``law.CurvatureLaw``).
    """

    curve: Trochoid
    offset: float
    turned: Array
    radius: float
    play: float
    yielding: float
    reference: float
    constant: float


class Planar(NamedTuple):
    """A reducer in the plane, with n output pins, N ring pins and D discs.

    Attributes
    ----------
    teeth
        Of all discs.
    pins
        Places of the ring pins [m], shape (N, 2).
    free
        Whether they move in sockets.
    socket
        Radius of those [m].
    holes, studs, cams
        Places [m] of holes in their discs, shape (D, n, 2), of output pins on the carrier, (n, 2), and of cams on the
        shaft, (D, 2).
    hole, stud, bore, cam
        Radii [m].
    mesh, seat, rim, bearing
        Laws of pins on teeth, of pins in sockets, of output pins in holes, and of cams in bores.
    inertia
        Mass or inertia of each unknown [kg, kg m2], shape (unknowns,).
    gravity
        On each of them [N], shape (unknowns,).
    speed, load, rise
        Of the crank [rad/s]; torque on the output [N m], and the time that it rises in [s].
    """

    teeth: Teeth
    pins: Array
    free: bool
    socket: float
    holes: Array
    studs: Array
    cams: Array
    hole: float
    stud: float
    bore: float
    cam: float
    mesh: Law
    seat: Law
    rim: Law
    bearing: Law
    inertia: Array
    gravity: Array
    speed: float
    load: float
    rise: float


@dataclass(frozen=True)
class History:
    """Samples of a run, shape (samples, columns): `COLUMNS`."""

    values: Array

    def __getitem__(self, name: str) -> Array:
        return np.asarray(self.values[:, COLUMNS.index(name)])


def planar(design: Design) -> Planar:
    """Describe a design in the plane.

    Raises
    ------
    DesignError
        It is of a kind that is not covered here.
    """
    reducer = Reducer(design)
    ring, clearance = design.ring, design.clearance
    closed = ring.pins == "fixed" or (ring.pins in ("free", "massless") and ring.socket == "closed")
    covered = ring.kind == "pin" and closed and not design.output.turns_ring
    if not covered or design.drag.crank or design.drag.output or design.drive.ramp:
        raise DesignError(
            f"{design.name}: the planar witness takes pins that are fixed or in closed sockets, a turning carrier, no "
            "drag and no ramp"
        )
    mechanism, law, gear = reducer.mechanism, curvature_law(reducer), gear_profile(design)
    discs = [mechanism.mating("pin_gear", disc) for disc in range(design.gear.discs)]
    holes = [mechanism.mating("output", disc).on.place for disc in range(design.gear.discs)]
    cams = [mechanism.mating("cam", disc).by.place[0] for disc in range(design.gear.discs)]
    laws = {
        kind: Law(one.stiffness, one.damping, one.friction, one.creep) for kind, one in contact_laws(reducer).items()
    }
    massless, free = ring.has_massless_pins, ring.has_pin_bodies
    inertia, gravity = _inertias(design, mechanism)
    teeth = Teeth(
        curve=Trochoid(gear.pin_circle_radius, gear.eccentricity, float(gear.ring_teeth)),
        offset=profile_offset(design),
        turned=np.array([mating.on.angle[0] for mating in discs]),
        radius=ring.pin_radius,
        play=design.pin_play if massless else 0.0,
        yielding=pair_stiffness(reducer, "pin_gear") / pair_stiffness(reducer, design.seat_pair) if massless else 0.0,
        reference=law.reference,
        constant=law.constant,
    )
    return Planar(
        teeth=teeth,
        pins=ring.pin_circle_radius * profile.unit(profile.pin_angles(gear)),
        free=free,
        socket=ring.pin_radius + clearance.pin_socket,
        holes=np.array(holes),
        studs=mechanism.mating("output").by.place,
        cams=np.array(cams),
        hole=design.output.hole_radius + clearance.output,
        stud=design.output.pin_radius,
        bore=design.gear.bore_radius + clearance.cam,
        cam=design.gear.bore_radius,
        mesh=laws["pin_gear"],
        seat=laws.get("pin_socket", laws["pin_gear"]),
        rim=laws["output"],
        bearing=laws["cam"],
        inertia=inertia,
        gravity=gravity,
        speed=design.drive.speed,
        load=braking(reducer) * design.load.torque,
        rise=design.load.rise,
    )


def _inertias(design: Design, mechanism: Mechanism) -> tuple[Array, Array]:
    """Give mass or inertia of each unknown, and gravity on it."""
    reducer = Reducer(design)
    masses, discs = moving_masses(reducer), [body.name for body in mechanism.discs]
    moving = [masses[name] for name in discs]
    after = [masses[names.PIN]] * design.ring.teeth if design.ring.has_pin_bodies else []
    pull = (design.environment.gravity_x, design.environment.gravity_y, 0.0)

    def of(parts: list[MassProperties]) -> list[float]:
        return [value for part in parts for value in (part.mass, part.mass, float(part.inertia[2, 2]))]

    inertia = np.array([*of(moving), output_inertia(reducer), *of(after)])
    pulled = np.array([*pull * len(moving), 0.0, *pull * len(after)])
    return inertia, inertia * pulled


def start(design: Design, compiled: Planar) -> tuple[Array, Array]:
    """Give places and speeds at the crank angle 0: those of the ideal mechanism at full speed."""
    discs = mechanism(design).discs
    lobes, speed = design.lobes, compiled.speed
    places = [value for disc in discs for value in (*disc.place, 0.0)]
    speeds = [value for disc in discs for value in (-speed * disc.place[1], speed * disc.place[0], -speed / lobes)]
    still = np.zeros((len(compiled.pins) if compiled.free else 0, 3))
    pins = np.column_stack([compiled.pins, np.zeros(len(compiled.pins))])[: len(still)]
    return np.array([*places, 0.0, *pins.ravel()]), np.array([*speeds, -speed / lobes, *still.ravel()])


def run(design: Design, duration: float, step: float, every: int) -> History:
    """Integrate a design over a `duration` [s] by steps [s]; sample one step in `every`.

    Raises
    ------
    DesignError
        As `planar`.
    """
    compiled = planar(design)
    places, speeds = start(design, compiled)
    return History(_compiled()(compiled, places, speeds, step, round(duration / step), every))


@njit()
def _turned(angle: float, place: Array) -> tuple[float, float]:
    s, c = math.sin(angle), math.cos(angle)
    return c * place[0] - s * place[1], s * place[0] + c * place[1]


@njit()
def _press(law: Law, factor: float, gap: float, nx: float, ny: float, vx: float, vy: float) -> tuple[float, float]:
    """Compute the force [N] on a part that a mate pushes along n, from the speed (vx, vy) of the part past the mate."""
    normal = -(law.stiffness * factor * gap + law.damping * (vx * nx + vy * ny))
    if gap >= 0.0 or normal <= 0.0:
        return 0.0, 0.0
    slip = vy * nx - vx * ny
    limit = law.friction * normal
    rub = -min(limit, max(-limit, law.creep * slip))
    return normal * nx - rub * ny, normal * ny + rub * nx


@njit()
def _act(force: Array, body: int, ax: float, ay: float, fx: float, fy: float) -> None:
    """Add a force at the arm (ax, ay) from the middle of a body whose x, y and turn begin at `body`."""
    force[body] += fx
    force[body + 1] += fy
    force[body + 2] += ax * fy - ay * fx


@njit()
def _on_teeth(compiled: Planar, disc: int, pin: int, q: Array, v: Array, force: Array, of_pin: int) -> None:
    """Add the force of a ring pin on a disc's teeth, and on the pin if it is free, from `of_pin` on."""
    teeth, body = compiled.teeth, 3 * disc
    px, py = compiled.pins[pin, 0], compiled.pins[pin, 1]
    if compiled.free:
        px, py = q[of_pin], q[of_pin + 1]
    turned = q[body + 2] - teeth.turned[disc]
    s, c = math.sin(turned), math.cos(turned)
    dx, dy = px - q[body], py - q[body + 1]
    t, distance, ox, oy = trochoid_distance(c * dx + s * dy, c * dy - s * dx, teeth.curve)
    reach = teeth.radius - teeth.play
    gap = distance + teeth.offset - reach
    if gap >= 0.0:
        return
    factor = 1.0
    if teeth.reference > 0.0:
        bend = trochoid_curvature(t, teeth.curve)
        relative = bend / (1.0 - teeth.offset * bend) + 1.0 / teeth.radius
        factor = teeth.reference / max(0.5 * teeth.reference, teeth.constant + math.log(max(relative, 1e-300)))
    factor *= (1.0 + teeth.yielding) / (1.0 + teeth.yielding * factor)
    nx, ny = -(c * ox - s * oy), -(s * ox + c * oy)
    depth = reach + 0.5 * gap
    ax, ay = dx + depth * nx, dy + depth * ny
    vx, vy = v[body] - v[body + 2] * ay, v[body + 1] + v[body + 2] * ax
    if compiled.free:
        vx -= v[of_pin] - v[of_pin + 2] * depth * ny
        vy -= v[of_pin + 1] + v[of_pin + 2] * depth * nx
    fx, fy = _press(compiled.mesh, factor, gap, nx, ny, vx, vy)
    _act(force, body, ax, ay, fx, fy)
    if compiled.free:
        _act(force, of_pin, depth * nx, depth * ny, -fx, -fy)


@njit()
def _in_socket(compiled: Planar, pin: int, q: Array, v: Array, force: Array, body: int) -> None:
    """Add the force of its socket on a free pin."""
    dx, dy = q[body] - compiled.pins[pin, 0], q[body + 1] - compiled.pins[pin, 1]
    aside = math.sqrt(dx * dx + dy * dy)
    gap = compiled.socket - compiled.teeth.radius - aside
    if gap >= 0.0:
        return
    nx, ny = -dx / aside, -dy / aside
    arm = -(compiled.teeth.radius + 0.5 * gap)
    vx, vy = v[body] - v[body + 2] * arm * ny, v[body + 1] + v[body + 2] * arm * nx
    fx, fy = _press(compiled.seat, 1.0, gap, nx, ny, vx, vy)
    _act(force, body, arm * nx, arm * ny, fx, fy)


@njit()
def _in_hole(compiled: Planar, disc: int, pin: int, q: Array, v: Array, force: Array, output: int) -> None:
    """Add the force of an output pin on a disc's hole, and its moment on the output."""
    body = 3 * disc
    hx, hy = _turned(q[body + 2], compiled.holes[disc, pin])
    sx, sy = _turned(q[output], compiled.studs[pin])
    dx, dy = sx - q[body] - hx, sy - q[body + 1] - hy
    aside = math.sqrt(dx * dx + dy * dy)
    gap = compiled.hole - compiled.stud - aside
    if gap >= 0.0:
        return
    nx, ny = dx / aside, dy / aside
    arm = compiled.stud + 0.5 * gap
    px, py = sx + arm * nx, sy + arm * ny
    ax, ay = px - q[body], py - q[body + 1]
    vx = v[body] - v[body + 2] * ay + v[output] * py
    vy = v[body + 1] + v[body + 2] * ax - v[output] * px
    fx, fy = _press(compiled.rim, 1.0, gap, nx, ny, vx, vy)
    _act(force, body, ax, ay, fx, fy)
    force[output] -= px * fy - py * fx


@njit()
def _on_cam(compiled: Planar, disc: int, crank: float, q: Array, v: Array, force: Array) -> tuple[float, float, float]:
    """Add the force of a cam on its disc; give it, and the torque on the crank that it asks for."""
    body = 3 * disc
    cx, cy = _turned(crank, compiled.cams[disc])
    dx, dy = cx - q[body], cy - q[body + 1]
    aside = math.sqrt(dx * dx + dy * dy)
    gap = compiled.bore - compiled.cam - aside
    if gap >= 0.0:
        return 0.0, 0.0, 0.0
    nx, ny = dx / aside, dy / aside
    arm = compiled.cam + 0.5 * gap
    px, py = cx + arm * nx, cy + arm * ny
    ax, ay = px - q[body], py - q[body + 1]
    vx = v[body] - v[body + 2] * ay + compiled.speed * py
    vy = v[body + 1] + v[body + 2] * ax - compiled.speed * px
    fx, fy = _press(compiled.bearing, 1.0, gap, nx, ny, vx, vy)
    _act(force, body, ax, ay, fx, fy)
    return fx, fy, px * fy - py * fx


@njit()
def _forces(compiled: Planar, time: float, q: Array, v: Array, force: Array, seen: Array) -> None:
    """Compute the force on each unknown; of what is seen: load, torque of the crank, force of the first cam."""
    force[:] = compiled.gravity
    discs = len(compiled.cams)
    output = 3 * discs
    seen[0] = compiled.load
    if time < compiled.rise:
        seen[0] *= 0.5 - 0.5 * math.cos(math.pi * time / compiled.rise)
    force[output] += seen[0]
    seen[1] = 0.0
    for disc in range(discs):
        for pin in range(len(compiled.pins)):
            _on_teeth(compiled, disc, pin, q, v, force, output + 1 + 3 * pin)
        for pin in range(len(compiled.studs)):
            _in_hole(compiled, disc, pin, q, v, force, output)
        fx, fy, torque = _on_cam(compiled, disc, compiled.speed * time, q, v, force)
        seen[1] += torque
        if disc == 0:
            seen[2], seen[3] = fx, fy
    if compiled.free:
        for pin in range(len(compiled.pins)):
            _in_socket(compiled, pin, q, v, force, output + 1 + 3 * pin)


@cache
def _compiled() -> Any:
    """Compile `_integrate`, or load it: what it closes over changes with the gaps that are compiled into it."""
    sources = digest(gap)

    @njit(cache=cacheable())
    def integrate(compiled: Planar, q: Array, v: Array, step: float, steps: int, every: int) -> Array:
        assert sources
        return _integrate(compiled, q, v, step, steps, every)

    return integrate


@njit()
def _integrate(compiled: Planar, q: Array, v: Array, step: float, steps: int, every: int) -> Array:
    """Take steps of the classic Runge-Kutta method; give the samples, shape (samples, columns)."""
    size, output = len(q), 3 * len(compiled.cams)
    samples = np.zeros((steps // every, 10))
    seen, ignored = np.zeros(4), np.zeros(4)
    rates = np.zeros((4, size))
    half = 0.5 * step
    for k in range(steps):
        time = k * step
        _forces(compiled, time, q, v, rates[0], seen)
        if k % every == 0 and k // every < len(samples):
            row = samples[k // every]
            row[0], row[1] = time, compiled.speed * time
            row[2], row[3], row[4], row[5] = q[2], v[2], q[output], v[output]
            row[6:] = seen
        rates[0] /= compiled.inertia
        v1 = v + half * rates[0]
        _forces(compiled, time + half, q + half * v, v1, rates[1], ignored)
        rates[1] /= compiled.inertia
        v2 = v + half * rates[1]
        _forces(compiled, time + half, q + half * v1, v2, rates[2], ignored)
        rates[2] /= compiled.inertia
        v3 = v + step * rates[2]
        _forces(compiled, time + step, q + step * v2, v3, rates[3], ignored)
        rates[3] /= compiled.inertia
        q = q + step / 6.0 * (v + 2.0 * v1 + 2.0 * v2 + v3)
        v = v + step / 6.0 * (rates[0] + 2.0 * rates[1] + 2.0 * rates[2] + rates[3])
    return samples
