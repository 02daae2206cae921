"""What a reducer's parts carry over a turn at one point of its duty: statics with friction and the gear's inertia."""

import math
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import RunError
from cycloid_mj.base.units import RPM
from cycloid_mj.life.duty import DutyPoint
from cycloid_mj.life.rolling import magnitudes
from cycloid_mj.parts import crank_solid, mass_properties
from cycloid_mj.parts.crank import ShaftDimensions, shaft_measures
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics import Loads, Springs, loads, peak_pressure, powers, springs_of
from cycloid_mj.statics.bearings import reactions
from cycloid_mj.statics.springs import POSES as ALL_ROUND
from cycloid_mj.statics.springs import turn_evenly

POSES = 181
"""Crank angles of a loading; its powers need no more than the usual ones."""

UNWOUND = 0.01
"""Torque that takes up the play, as a share of the load: the wind-up is counted from there."""


@dataclass(frozen=True)
class Rub:
    """How one kind of contact slides: mean of the sum F v [W], largest p v on the projected face [Pa m/s], mean v."""

    power: float
    pressure_speed: float
    speed: float


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
        Largest Hertz pressure by kind of pair [Pa].
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


def relative_speed(reducer: Reducer, speed: float) -> float:
    """Compute the speed of crank and gear against each other [rad/s]: the gear turns back by one in N - 1, or not."""
    return abs(float(speed - reducer.member.gear_angle(speed)))


def speed_past_ring(reducer: Reducer, speed: float) -> float:
    """Compute the speed of the crank against the ring [rad/s], whose pins see a lobe each turn of it."""
    return abs(float(reducer.member.against_ring(speed)))


def loading(reducer: Reducer, point: DutyPoint, poses: int = POSES) -> Loading:
    """Solve one point of a duty at some crank angles; the signs of torque and speed do not matter: the load brakes.

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
        unwound = loads(at, springs, UNWOUND * torque)
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
        pressures={kind: peak_pressure(at, springs, contact_loads, kind) for kind in design.pair_kinds},
        rubs=_rubs(at, springs, contact_loads),
        losses=dict(power.friction),
        crank_torque=power.crank / abs(speed),
        wind_up=abs(float((contact_loads.departures - unwound.departures)[:, 2].mean()))
        / (design.output.pin_circle_radius * (1.0 - UNWOUND)),
        work=contact_loads.work,
    )


def _rubs(reducer: Reducer, springs: Springs, contact_loads: Loads) -> dict[str, Rub]:
    """Collect how teeth, output pins or plain rollers and a plain cam slide; a pin slips where it is the easier."""
    design, output = reducer.design, reducer.design.output
    slip, count = np.abs(springs.slip), springs.teeth
    seat = design.seat_pair
    in_seat = seat and design.mesh_friction < design.friction_of(design.tooth_pair)
    kind, radius = (seat, design.ring.pin_radius) if in_seat else (design.tooth_pair, design.ring.pin_radius)
    rubs = {kind: _rub(reducer, kind, contact_loads.teeth, slip[:, :count], radius)}
    if not output.rollers:
        rubs["output"] = _rub(reducer, "output", contact_loads.output, slip[:, count:], output.pin_radius)
    elif not output.has_needles:
        on_core = slip[:, count:] * output.root_radius / output.pin_radius
        rubs["output_roller"] = _rub(reducer, "output", contact_loads.output, on_core, output.root_radius)
    if design.gear.bearing == "plain":
        force = magnitudes(contact_loads.cam).reshape(len(slip), -1)
        speed = np.full_like(force, design.gear.bore_radius * relative_speed(reducer, design.drive.speed))
        rubs["cam"] = _rub(reducer, "cam", force, speed, design.gear.bore_radius)
    return rubs


def _rub(reducer: Reducer, kind: str, force: Array, speed: Array, radius: float) -> Rub:
    """Return how contacts of a kind under forces [N] slide at speeds [m/s], shapes (m, n), on pins of a radius [m]."""
    rubbed, carries = force * speed, force > 0.0
    return Rub(
        power=float(rubbed.sum(axis=1).mean()),
        pressure_speed=float(rubbed.max()) / (2.0 * radius * reducer.design.line_length(kind)),
        speed=float(speed[carries].mean()) if carries.any() else 0.0,
    )


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
