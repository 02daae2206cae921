"""What a reducer's parts carry over a turn at one point of its duty: statics with friction and the gear's inertia."""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import RunError
from cycloid_mj.base.units import RPM
from cycloid_mj.geometry import profile
from cycloid_mj.life.duty import DutyPoint
from cycloid_mj.life.rolling import magnitudes
from cycloid_mj.parts import crank_solid, mass_properties
from cycloid_mj.parts.crank import ShaftDimensions, shaft_measures
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics import Loads, Springs, loads, peak_pressure, powers, springs_of
from cycloid_mj.statics.bearings import reactions
from cycloid_mj.statics.peaks import is_narrow
from cycloid_mj.statics.springs import POSES as ALL_ROUND
from cycloid_mj.statics.springs import turn_evenly

POSES = 181
"""Crank angles of a loading; its powers need no more than the usual ones."""

UNWOUND = 0.01
"""Torque that takes up the play, as a share of the load: the wind-up is counted from there."""


SECTORS = 72
"""Parts of a turn into which a worn surface is divided: 5 deg each, an eighth of what a pin's contact passes over."""


@dataclass(frozen=True)
class Rub:
    """How one kind of contact slides.

    Attributes
    ----------
    power
        Mean of the sum of F v over all contacts [W].
    pressure_speed
        Largest p v on the projected face [Pa m/s].
    speed
        Mean sliding speed of the contacts that carry [m/s].
    density
        Largest F v, averaged over time, at one place of the worn surface, per length along its section [W/m]: over its
        width, the rate at which that place wears.
    """

    power: float
    pressure_speed: float
    speed: float
    density: float


FAR, NEAR = -2, -1
"""Of a shaft's forces: those of the bearing far from the gear, and next to it."""


@dataclass(frozen=True, eq=False)
class Loading:
    """Loads at m crank angles that cover N - 1 turns of the crank evenly: one of the output, after which all repeats.

    Attributes
    ----------
    point
        Torque, speed and share of the time.
    reducer, springs
        The reducer at that speed, and its springs at the crank angles.
    crank
        Angles [rad], shape (m,).
    cam
        Size of each cam's force on its disc [N], shape (m, discs).
    shaft
        Forces on the shaft in its own frame [N], shape (m, places, 2), at `places` along z [m]: cams and counterweight,
        then what the two bearings answer with, the one far from the gear first.
    output
        Force of each disc on each output pin [N], shape (m, discs, pins).
    on_output
        Force of each disc on all output pins together [N], shape (m, discs, 2).
    teeth
        Largest force on a tooth [N].
    pressures
        Largest Hertz pressure by kind of pair [Pa]; none of a kind that fits too closely for Hertz, or carries nothing.
    rubs
        How the contacts that slide do so, by kind of pair.
    losses
        Friction of teeth, cam, output pins and seals [W].
    crank_torque
        On the crank [N m].
    wind_up
        Turn of the gear by the load, without the play [rad].
    work
        Of the balances at the load, see `Loads`.
    """

    point: DutyPoint
    reducer: Reducer
    springs: Springs
    crank: Array
    cam: Array
    shaft: Array
    places: Array
    output: Array
    on_output: Array
    teeth: float
    pressures: dict[str, float]
    rubs: dict[str, Rub]
    losses: dict[str, float]
    crank_torque: float
    wind_up: float
    work: float


Body = Literal["shaft", "disc", "output", "housing"]
"""A body that turns: crank, disc, carrier of the output pins, or the ring with its covers."""

CAM: tuple[Body, Body] = ("shaft", "disc")


def relative_speed(reducer: Reducer, speed: float, bodies: tuple[Body, Body] = CAM) -> float:
    """Compute the speed of two bodies against each other [rad/s] at a speed of the crank [rad/s].

    With the ring held, disc and output turn by -w/(N - 1); with the carrier held the ring turns by w/N.
    """
    member = reducer.member
    turning = float(member.gear_angle(speed))
    speeds = {"shaft": speed, "disc": turning, "output": turning, "housing": float(member.ring_angle(speed))}
    first, second = bodies
    return abs(speeds[first] - speeds[second])


def speed_past_ring(reducer: Reducer, speed: float) -> float:
    """Compute the speed of the crank against the ring [rad/s], whose pins see a lobe each turn of it."""
    return relative_speed(reducer, speed, ("shaft", "housing"))


def loading(reducer: Reducer, point: DutyPoint, poses: int = POSES, stops: bool = True) -> Loading:
    """Solve one point of a duty at some crank angles; the signs of torque and speed do not matter: the load brakes.

    Without `stops`, the wind-up is not solved for, and is NaN: emergency stops alone need it.

    Raises
    ------
    RunError
        There is no balance: the drive cannot hold that torque.
    """
    design = reducer.design
    speed = math.copysign(point.speed, design.drive.speed)
    at = reducer.but(drive={"speed": speed})
    crank = design.lobes * turn_evenly(reducer, poses)
    springs, torque = springs_of(at, crank), math.copysign(abs(point.torque), speed)
    try:
        contact_loads = loads(at, springs, torque)
        power = powers(at, abs(point.torque), turn_evenly(reducer, min(poses, ALL_ROUND)))
        unwound = loads(at, springs, UNWOUND * torque) if stops else None
    except RunError as error:
        condition = f"{abs(point.torque):.4g} N m at {point.speed / RPM:.4g} rpm"
        raise RunError(f"{design.name} does not hold {condition}: {error}; rate it at another torque") from error
    cam = contact_loads.cam.reshape(poses, -1, 2)
    shaft = shaft_measures(reducer)
    places, forces = _shaft_forces(at, shaft, springs.crank, cam)
    return Loading(
        point=point,
        reducer=at,
        springs=springs,
        crank=springs.crank,
        cam=magnitudes(cam),
        shaft=forces,
        places=places,
        output=contact_loads.output.reshape(poses, cam.shape[1], -1),
        on_output=reactions(at, springs, contact_loads).output.force,
        teeth=float(contact_loads.teeth.max()),
        pressures={
            kind: peak_pressure(at, springs, contact_loads, kind)
            for kind in design.pair_kinds
            if is_narrow(at, springs, contact_loads, kind)
        },
        rubs=_rubs(at, springs, contact_loads),
        losses=dict(power.friction),
        crank_torque=power.crank / abs(speed),
        wind_up=abs(float((contact_loads.departures - unwound.departures)[:, 2].mean()))
        / (design.output.pin_circle_radius * (1.0 - UNWOUND))
        if unwound
        else math.nan,
        work=contact_loads.work,
    )


def _rubs(reducer: Reducer, springs: Springs, contact_loads: Loads) -> dict[str, Rub]:
    """Collect how teeth, output pins or plain rollers and a plain cam slide; a pin slips where it is the easier.

    Sleeves and rollers turn on their pins, and their bores wear alike all round. Flanks of the disc, sockets, holes and
    the disc's bore wear where the load presses.
    """
    design, output, ring = reducer.design, reducer.design.output, reducer.design.ring
    slip, count = np.abs(springs.slip), springs.teeth
    slope, discs = springs.contacts.slope, contact_loads.discs
    push = slope[..., :-1].reshape(*slope.shape[:2], discs, 3)[..., :2].sum(axis=2)
    towards = np.arctan2(push[..., 1], push[..., 0])
    teeth, on_teeth = contact_loads.teeth, slip[:, :count]
    seat = design.seat_pair
    rubs: dict[str, Rub] = {}
    if not (seat and design.mesh_friction < design.friction_of(design.tooth_pair)):
        at_pin = np.tile(profile.pin_angles(reducer.tooth_profile), ring.halves)
        along = springs.crank[:, None, None] + np.array(reducer.phases)[:, None] + at_pin
        density = _densest(teeth * on_teeth, along.reshape(teeth.shape), _flank_lengths(reducer))
        rubs[design.tooth_pair] = _rub(reducer, design.tooth_pair, teeth, on_teeth, ring.pin_radius, density)
    elif seat == "pin_sleeve":
        in_bore = on_teeth * ring.sleeve_bore_radius / ring.pin_radius
        around = 2.0 * math.pi * ring.sleeve_bore_radius * teeth.shape[1]
        density = float((teeth * in_bore).sum(axis=1).mean()) / around
        rubs[seat] = _rub(reducer, seat, teeth, in_bore, ring.sleeve_bore_radius, density)
    else:
        around = 2.0 * math.pi * ring.pin_radius * teeth.shape[1]
        azimuth = np.tile(profile.pin_angles(reducer.tooth_profile), discs * ring.halves)
        density = _densest(teeth * on_teeth, towards[:, :count] + azimuth, _evenly(around), steady=False)
        rubs[seat] = _rub(reducer, seat, teeth, on_teeth, ring.pin_radius, density)
    pressed, on_pins = contact_loads.output, slip[:, count:]
    if not output.rollers:
        around = 2.0 * math.pi * output.hole_radius * pressed.shape[1]
        azimuth = np.tile(2.0 * math.pi * np.arange(output.pins) / output.pins, discs)
        in_disc = towards[:, count:] + springs.crank[:, np.newaxis] / design.lobes
        density = _densest(pressed * on_pins, in_disc + azimuth, _evenly(around))
        rubs["output"] = _rub(reducer, "output", pressed, on_pins, output.pin_radius, density)
    elif not output.has_needles:
        on_core = on_pins * output.root_radius / output.pin_radius
        around = 2.0 * math.pi * output.root_radius * pressed.shape[1]
        density = float((pressed * on_core).sum(axis=1).mean()) / around
        rubs["output_roller"] = _rub(reducer, "output", pressed, on_core, output.root_radius, density)
    if design.gear.bearing == "plain":
        cam = contact_loads.cam
        force = magnitudes(cam)
        speed = np.full_like(force, design.gear.bore_radius * relative_speed(reducer, design.drive.speed))
        around = 2.0 * math.pi * design.gear.bore_radius * discs
        at = np.arctan2(cam[..., 1], cam[..., 0]) + springs.crank[:, np.newaxis] / design.lobes
        density = _densest(force * speed, at, _evenly(around))
        rubs["cam"] = _rub(reducer, "cam", force, speed, design.gear.bore_radius, density)
    return rubs


def _rub(reducer: Reducer, kind: str, force: Array, speed: Array, radius: float, density: float) -> Rub:
    """Return how contacts of a kind under forces [N] slide at speeds [m/s], shapes (m, n), on pins of a radius [m]."""
    rubbed, carries = force * speed, force > 0.0
    return Rub(
        power=float(rubbed.sum(axis=1).mean()),
        pressure_speed=float(rubbed.max()) / (2.0 * radius * reducer.design.line_length(kind)),
        speed=float(speed[carries].mean()) if carries.any() else 0.0,
        density=density,
    )


def _densest(power: Array, angle: Array, lengths: Array, steady: bool = True) -> float:
    """Compute the largest mean power per length [W/m] on a surface that is divided by an angle.

    Parameters
    ----------
    power
        F v of each contact at each crank angle [W], shape (m, n).
    angle
        Where each is on the surface [rad], shape (m, n); surfaces alike that repeat are laid on each other.
    lengths
        Of all these surfaces together in each of `SECTORS` of a turn [m], shape (SECTORS,).
    steady
        Whether each contact passes through all angles at one speed: then each sector has its share of the time, and not
        as much as the crank angles happen to give it.
    """
    sector = (np.floor(angle / (2.0 * math.pi) * SECTORS).astype(int) % SECTORS).ravel()
    total = np.bincount(sector, weights=power.ravel(), minlength=SECTORS)
    if steady:
        mean = total / np.maximum(np.bincount(sector, minlength=SECTORS), 1) * power.shape[1] / SECTORS
    else:
        mean = total / len(power)
    return float((mean / lengths).max())


def _evenly(length: float) -> Array:
    """Divide a length [m] into `SECTORS`."""
    return np.full(SECTORS, length / SECTORS)


def _flank_lengths(reducer: Reducer) -> Array:
    """Compute the arc of all discs' outlines [m] in each of `SECTORS` of the phase of a pin, shape (SECTORS,).

    A lobe is passed as the phase B = zeta + crank of a pin makes a turn: t = -B/(N - 1) on the outline.
    """
    gear, lobes = reducer.gear_profile, reducer.design.lobes
    ends = -np.linspace(0.0, 2.0 * math.pi, SECTORS + 1) / lobes
    lengths = -np.diff(profile.arc_length(gear, ends, reducer.profile_offset))
    return np.asarray(reducer.design.gear.discs * lobes * lengths)


def _shaft_forces(reducer: Reducer, shaft: ShaftDimensions, crank: Array, cam: Array) -> tuple[Array, Array]:
    """Compute places along the shaft (p,) [m] and the forces there in its frame, shape (m, p, 2) [N].

    The loads are each disc on its cam (m, discs, 2) and the unbalance of the shaft itself; two bearings hold it as a
    beam.
    """
    cosine, sine = np.cos(crank)[:, np.newaxis], np.sin(crank)[:, np.newaxis]
    x, y = cam[..., 0], cam[..., 1]
    turned = np.stack([-(cosine * x + sine * y), -(cosine * y - sine * x)], axis=-1)
    properties = mass_properties(crank_solid(reducer))
    flung = np.broadcast_to(
        properties.mass * properties.centroid[:2] * reducer.design.drive.speed**2, (len(crank), 1, 2)
    )
    far, near = (0.5 * sum(ends) for ends in shaft.bearings)
    acting = np.array([*reducer.design.gear.disc_planes, 0.5 * sum(shaft.counterweight)])
    applied = np.concatenate([turned, flung], axis=1)
    at_near = -np.einsum("p,mpx->mx", (acting - far) / (near - far), applied)
    at_far = -applied.sum(axis=1) - at_near
    return np.array([*acting, far, near]), np.concatenate([applied, at_far[:, None], at_near[:, None]], axis=1)


def bending(loading: Loading, place: float) -> Array:
    """Compute the bending moment [N m] at a place along the shaft [m], in its frame, shape (m, 2)."""
    arm = np.maximum(loading.places - place, 0.0)
    return np.asarray(np.einsum("p,mpx->mx", arm, loading.shaft))
