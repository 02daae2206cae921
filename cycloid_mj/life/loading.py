"""Loads on the parts over a turn at one point of a duty cycle: statics with friction and the disc's inertia force."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Literal

import numpy as np

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.errors import RunError
from cycloid_mj.base.units import RPM
from cycloid_mj.design import Design
from cycloid_mj.geometry import profile
from cycloid_mj.life.duty import DutyPoint
from cycloid_mj.life.rolling import magnitudes
from cycloid_mj.parts import crank_solid, mass_properties
from cycloid_mj.parts.crank import ShaftDimensions, shaft_dimensions
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics import Loads, Springs, loads, peak_pressure, powers, springs_of
from cycloid_mj.statics.bearings import Planes, output_forces
from cycloid_mj.statics.film import FilmFriction
from cycloid_mj.statics.peaks import is_hertzian
from cycloid_mj.statics.springs import POSES as POWER_POSES
from cycloid_mj.statics.springs import turn_evenly

POSES = 181
"""Default number of crank angles (heuristic); powers need no more than those of the statics."""

PRELOAD_SHARE = 0.01
"""Torque that closes the clearances, over the load: wind-up is measured from there."""

SECTORS = 72
"""Sectors of a turn into which a worn surface is divided, 5 deg each (heuristic)."""


@dataclass(frozen=True)
class Sliding:
    """Sliding of one kind of contact.

    Attributes
    ----------
    power
        Mean of the sum of F v over all contacts [W].
    pressure_speed
        Largest p v on the projected face [Pa m/s].
    speed
        Mean sliding speed of the loaded contacts [m/s].
    density
        Largest F v, averaged over time, at one place of the worn surface, per length along its section [W/m]: over its
        width, the rate at which that place wears.
    """

    power: float
    pressure_speed: float
    speed: float
    density: float


FAR, NEAR = -2, -1
"""Places of the two bearings among a shaft's forces: far from the discs, and next to them."""


@dataclass(frozen=True, eq=False)
class Loading:
    """Loads at m crank angles, evenly spaced over the N - 1 turns of the crank after which all repeats.

    Attributes
    ----------
    point
        Torque, speed and share of the time.
    reducer, springs
        The reducer at that speed, and its contact springs at the crank angles.
    contacts
        Contact forces and displacements.
    crank
        Crank angles [rad], shape (m,).
    cam
        Magnitude of each cam's force on its disc [N], shape (m, discs).
    shaft
        Forces on the shaft in its own frame [N], shape (m, s, 2), at `stations` along z [m], shape (s,): cams and
        counterweight, then the reactions of the two bearings, that of the far one first.
    output
        Force of each disc on each output pin [N], shape (m, discs, pins).
    teeth
        Largest force on a tooth [N].
    losses
        Power lost in teeth, cam, output pins and seals [W].
    crank_torque
        Torque on the crank [N m].
    wind_up
        Turn of the disc by the load, without clearances [rad]; NaN where it was not solved for.
    work
        Numerical work of the equilibria: mean number of assemblies of the equations per crank angle, as `Loads.work`.
    """

    point: DutyPoint
    reducer: Reducer
    springs: Springs
    contacts: Loads
    crank: Array
    cam: Array
    shaft: Array
    stations: Array
    output: Array
    teeth: float
    losses: dict[str, float]
    crank_torque: float
    wind_up: float
    work: float

    @cached_property
    def on_output(self) -> Array:
        """Force of each disc on all output pins together [N], shape (m, discs, 2)."""
        return output_forces(self.springs, self.contacts)

    @cached_property
    def pressures(self) -> dict[str, float]:
        """Largest Hertz pressure by kind of pair [Pa], without kinds that carry nothing or fit too closely."""
        return {
            kind: peak_pressure(self.reducer, self.springs, self.contacts, kind)
            for kind in self.reducer.design.pair_kinds
            if is_hertzian(self.reducer, self.springs, self.contacts, kind)
        }

    @cached_property
    def sliding(self) -> dict[str, Sliding]:
        """Sliding by kind of pair, of the contacts that slide."""
        return _sliding_loads(self.reducer, self.springs, self.contacts)


Body = Literal["shaft", "disc", "output", "housing"]
"""A body that turns: crank, disc, carrier of the output pins, or the ring with its covers."""

CAM: tuple[Body, Body] = ("shaft", "disc")


def relative_speed(reducer: Reducer, speed: float, bodies: tuple[Body, Body] = CAM) -> float:
    """Compute the magnitude of the relative angular speed of two `bodies` [rad/s] at a `speed` of the crank [rad/s].

    The default bodies are crank shaft and disc, between which the cam runs. The speed follows from the ideal kinematics
    of a design with a fixed ring or a fixed carrier.
    """
    member = reducer.member
    gear_speed = float(member.gear_angle(speed))
    speeds = {"shaft": speed, "disc": gear_speed, "output": gear_speed, "housing": float(member.ring_angle(speed))}
    first_body, second_body = bodies
    return abs(speeds[first_body] - speeds[second_body])


def speed_past_ring(reducer: Reducer, speed: float) -> float:
    """Compute the speed of the crank against the ring [rad/s], whose pins see a lobe each turn of it."""
    return relative_speed(reducer, speed, ("shaft", "housing"))


def solve_loading(
    reducer: Reducer,
    point: DutyPoint,
    crank_angles: int = POSES,
    with_wind_up: bool = True,
    temperatures: Mapping[str, float] | None = None,
) -> Loading:
    """Solve contact forces, shaft forces, sliding and losses over a turn at one `point` of a duty cycle.

    Friction is included. The load always opposes the rotation, whatever the signs of torque and speed. `crank_angles`
    is the number of crank angles. The wind-up, which only emergency stops need, is NaN unless `with_wind_up` is set.
    `temperatures` [°C] of the parts apply to clearances, moduli and lubricant, but not to the sizes of shaft and
    covers; the default are the temperatures of the reducer.

    Raises
    ------
    RunError
        No static equilibrium exists.
    """
    design = reducer.design
    cold_reducer = turning_reducer = reducer.turning_at(point.speed)
    speed = cold_reducer.design.drive.speed
    if temperatures is not None:
        turning_reducer = cold_reducer.at_temperatures(temperatures)
    evaluated_angles = design.lobes * turn_evenly(reducer, crank_angles)
    springs, torque = springs_of(turning_reducer, evaluated_angles), math.copysign(abs(point.torque), speed)
    try:
        contact_loads = loads(turning_reducer, springs, torque)
        power = powers(turning_reducer, abs(point.torque), turn_evenly(reducer, min(crank_angles, POWER_POSES)))
        wind_up = _solve_wind_up(turning_reducer, springs, torque, contact_loads) if with_wind_up else math.nan
    except RunError as error:
        condition = f"{abs(point.torque):.4g} N m at {point.speed / RPM:.4g} rpm"
        raise RunError(
            f"{design.name}: no static equilibrium at {condition}: {error}. Choose a lower torque with --load-nm"
        ) from error
    cam_forces = contact_loads.cam.reshape(crank_angles, -1, 2)
    shaft_geometry = shaft_dimensions(reducer)
    stations, forces = _shaft_forces(cold_reducer, shaft_geometry, springs.crank, cam_forces)
    return Loading(
        point=point,
        reducer=turning_reducer,
        springs=springs,
        contacts=contact_loads,
        crank=springs.crank,
        cam=magnitudes(cam_forces),
        shaft=forces,
        stations=stations,
        output=contact_loads.output.reshape(crank_angles, cam_forces.shape[1], -1),
        teeth=float(contact_loads.teeth.max()),
        losses=dict(power.friction),
        crank_torque=power.crank / abs(speed),
        wind_up=wind_up,
        work=contact_loads.work,
    )


def _solve_wind_up(reducer: Reducer, springs: Springs, torque: float, contact_loads: Loads) -> float:
    """Compute the elastic rotation of the discs against the crank under the full torque [rad], a mean over the turn.

    To exclude clearances, the rotation between `PRELOAD_SHARE` of the `torque` [N m] and the full torque is
    extrapolated linearly to zero torque. `springs` are the contact springs, `contact_loads` the equilibria under the
    full torque.
    """
    preload_loads = loads(reducer, springs, PRELOAD_SHARE * torque)
    arc_length = abs(float((contact_loads.departures - preload_loads.departures)[:, 2].mean()))
    return arc_length / (reducer.design.output.pin_circle_radius * (1.0 - PRELOAD_SHARE))


def _sliding_loads(reducer: Reducer, springs: Springs, contact_loads: Loads) -> dict[str, Sliding]:
    """Compute the `Sliding` over a turn of each kind of mating pair whose contacts slide.

    The keys are kinds of pair: that of the teeth, such as "pin_gear", that of their seats, such as "pin_socket",
    "output" or "output_roller" (bore of a plain roller), and "cam" (plain cams). A ring pin that can turn slides where
    its friction is lower (`slides_in_seat`): on the flank or in its seat. F v is averaged over the bores of sleeves and
    rollers, which wear evenly; elsewhere it is that at the most worn point. `springs` and `contact_loads` are the
    contact springs and the forces at the crank angles of a turn.
    """
    design, output, ring = reducer.design, reducer.design.output, reducer.design.ring
    summarize = partial(_summarize_sliding, reducer)
    slip_speeds, tooth_count = np.abs(springs.slip), springs.teeth
    disc_count, directions = contact_loads.discs, springs.directions
    force_angles = np.arctan2(directions[..., 1], directions[..., 0])
    disc_turn = springs.crank[:, np.newaxis] / design.lobes
    tooth_forces, tooth_speed, seat_kind = contact_loads.teeth, slip_speeds[:, :tooth_count], design.seat_pair
    in_seat = slides_in_seat(design, contact_loads.friction, tooth_forces.shape)
    slides_in_both = bool(seat_kind) and design.has_film
    sliding: dict[str, Sliding] = {}
    if slides_in_both or not in_seat.any():
        pair, flank_forces = design.tooth_pair, np.where(in_seat, 0.0, tooth_forces)
        phases, lengths = tooth_phases(reducer, springs.crank), _flank_lengths(reducer)
        sliding[pair] = summarize(pair, flank_forces, tooth_speed, ring.pin_radius, phases, lengths)
    if slides_in_both or in_seat.any():
        seat_forces = np.where(in_seat, tooth_forces, 0.0)
        radius = ring.sleeve_bore_radius if seat_kind == "pin_sleeve" else ring.pin_radius
        seat_speed = tooth_speed * radius / ring.pin_radius
        if seat_kind == "pin_sleeve":
            sliding[seat_kind] = summarize(seat_kind, seat_forces, seat_speed, radius)
        else:
            azimuth = np.tile(profile.pin_angles(reducer.tooth_profile), disc_count * ring.halves)
            angle, lengths = force_angles[:, :tooth_count] + azimuth, _circle_lengths(radius, tooth_count)
            sliding[seat_kind] = summarize(
                seat_kind, seat_forces, seat_speed, radius, angle, lengths, passes_evenly=False
            )
    pin_forces, pin_speed = contact_loads.output, slip_speeds[:, tooth_count:]
    if not output.rollers:
        azimuth = np.tile(2.0 * math.pi * np.arange(output.pins) / output.pins, disc_count)
        angle = force_angles[:, tooth_count:] + disc_turn + azimuth
        lengths = _circle_lengths(output.hole_radius, pin_forces.shape[1])
        sliding["output"] = summarize("output", pin_forces, pin_speed, output.pin_radius, angle, lengths)
    elif not output.has_needles:
        core_speed = pin_speed * output.root_radius / output.pin_radius
        sliding["output_roller"] = summarize("output", pin_forces, core_speed, output.root_radius)
    if design.gear.bearing == "plain":
        cam_forces, radius = contact_loads.cam, design.gear.bore_radius
        force = magnitudes(cam_forces)
        speed = np.full_like(force, radius * relative_speed(reducer, design.drive.speed))
        angle = np.arctan2(cam_forces[..., 1], cam_forces[..., 0]) + disc_turn
        sliding["cam"] = summarize("cam", force, speed, radius, angle, _circle_lengths(radius, disc_count))
    return sliding


def slides_in_seat(design: Design, friction: FilmFriction | None, shape: tuple[int, ...]) -> Mask:
    """Return a mask that is true for each tooth contact whose ring pin slides in its seat, not on the disc's flank.

    A pin slides where friction is lower. With the law ``coulomb`` (`friction` is None), this is the same for all pins,
    and the mask has the shape `shape`. With the law ``film``, the mask is ``friction.rolls``.
    """
    if friction is not None:
        return friction.rolls
    return np.full(shape, bool(design.seat_pair) and design.mesh_friction < design.friction_of(design.tooth_pair))


def _summarize_sliding(
    reducer: Reducer,
    kind: str,
    force: Array,
    speed: Array,
    radius: float,
    angle: Array | None = None,
    lengths: Array | None = None,
    passes_evenly: bool = True,
) -> Sliding:
    """Summarize sliding over a turn: power F v [W], largest pressure times speed p v [Pa m/s] and mean speed [m/s].

    F v is normal force times sliding speed of all contacts of a `kind` of pair. p is the pressure on the projected
    area, which follows from the `radius` of the pins [m] and the length of the contacts of the kind. `force` [N] and
    `speed` [m/s] have the shape (m, n) for n contacts at m crank angles. `angle`, `lengths` and `passes_evenly` are
    those of `_largest_line_power`; without them, each contact wears its own circle of the `radius` evenly.
    """
    power, is_loaded = force * speed, force > 0.0
    mean_power = float(power.sum(axis=1).mean())
    return Sliding(
        power=mean_power,
        pressure_speed=float(power.max()) / (2.0 * radius * reducer.design.line_length(kind)),
        speed=float(speed[is_loaded].mean()) if is_loaded.any() else 0.0,
        density=mean_power / (2.0 * math.pi * radius * power.shape[1])
        if angle is None or lengths is None
        else _largest_line_power(power, angle, lengths, passes_evenly),
    )


def _largest_line_power(power: Array, angle: Array, lengths: Array, passes_evenly: bool = True) -> float:
    """Compute the time average of force times sliding speed per length of a surface [W/m], in its most loaded sector.

    A surface has `SECTORS` equal sectors in a turn; `lengths` (SECTORS,) [m] is the length of each sector, summed over
    all equal surfaces, such as all holes. `power` [W] is force times sliding speed of n contacts at m crank angles, and
    `angle` [rad] the position of each contact on its surface, both of shape (m, n). With `passes_evenly`, a contact
    spends equal times in all sectors, and the mean power in a sector counts; otherwise its share of the crank angles is
    the time that it spends there.
    """
    sector_mean, sector_sum = sector_means(power, angle)
    sector_power = sector_mean * power.shape[1] / SECTORS if passes_evenly else sector_sum / len(power)
    return float((sector_power / lengths).max())


def sector_means(values: Array, angle: Array) -> tuple[Array, Array]:
    """Return mean and sum of values in each of the equal `SECTORS` of a turn, shape (SECTORS,); 0 in empty sectors.

    `values` and the angles [rad] that assign them to sectors have the same shape.
    """
    sector_indices = (np.floor(angle / (2.0 * math.pi) * SECTORS).astype(int) % SECTORS).ravel()
    sector_sum = np.asarray(np.bincount(sector_indices, weights=values.ravel(), minlength=SECTORS), float)
    return sector_sum / np.maximum(np.bincount(sector_indices, minlength=SECTORS), 1), sector_sum


def tooth_phases(reducer: Reducer, crank: Array) -> Array:
    """Return the phase of the ring pin of each of n contacts [rad], (m, n): its angle from the disc's eccentric.

    `crank` are m crank angles [rad], shape (m,). The contacts are those of the ring: all pins for each disc and each
    half of the ring.
    """
    pin_angles = np.tile(profile.pin_angles(reducer.tooth_profile), reducer.design.ring.halves)
    phases = crank[:, np.newaxis, np.newaxis] + np.array(reducer.phases)[:, np.newaxis] + pin_angles
    return np.asarray(phases.reshape(len(crank), -1))


def _circle_lengths(radius: float, circle_count: int) -> Array:
    """Compute the arc of several circles of a radius [m] in each of the equal `SECTORS` [m], shape (SECTORS,)."""
    return np.full(SECTORS, 2.0 * math.pi * radius * circle_count / SECTORS)


def _flank_lengths(reducer: Reducer) -> Array:
    """Compute the arc length of the lobes in each sector of a pin's phase [m], summed over all lobes, (SECTORS,).

    The phase is the angle of a pin from the eccentric. It makes a turn, which has `SECTORS` equal sectors, while the
    contact moves over one lobe. The sum includes all discs.
    """
    gear_profile, lobes = reducer.gear_profile, reducer.design.lobes
    sector_ends = -np.linspace(0.0, 2.0 * math.pi, SECTORS + 1) / lobes
    lengths = -np.diff(profile.arc_length(gear_profile, sector_ends, reducer.profile_offset))
    return np.asarray(reducer.design.gear.discs * lobes * lengths)


def _shaft_forces(
    reducer: Reducer, dimensions: ShaftDimensions, crank: Array, cam_forces: Array
) -> tuple[Array, Array]:
    """Compute the forces on the shaft [N] in its rotating frame, and their positions along it [m], at m crank angles.

    Loads are the forces of the discs on the cams and the unbalance of the shaft; two bearings support it as a beam.

    Parameters
    ----------
    dimensions
        Dimensions of the crank.
    crank
        The m crank angles [rad], shape (m,).
    cam_forces
        Forces of the cams on the discs [N], shape (m, discs, 2).

    Returns
    -------
    stations, forces
        The p positions along the shaft [m], shape (p,), and forces there [N], shape (m, p, 2): cams, counterweight, the
        bearing far from the discs or beyond them, and the near bearing.
    """
    cosine, sine = np.cos(crank)[:, np.newaxis], np.sin(crank)[:, np.newaxis]
    force_x, force_y = cam_forces[..., 0], cam_forces[..., 1]
    cam_force = np.stack([-(cosine * force_x + sine * force_y), -(cosine * force_y - sine * force_x)], axis=-1)
    properties = mass_properties(crank_solid(reducer))
    unbalance = np.broadcast_to(
        properties.mass * properties.centroid[:2] * reducer.design.drive.speed**2, (len(crank), 1, 2)
    )
    far_bearing, near_bearing = (0.5 * sum(ends) for ends in dimensions.bearings)
    loaded_stations = np.array([*reducer.design.gear.disc_planes, 0.5 * sum(dimensions.counterweight)])
    applied_forces = np.concatenate([cam_force, unbalance], axis=1)
    far_reaction, near_reaction = Planes(applied_forces, loaded_stations).reactions_at(far_bearing, near_bearing)
    return np.array([*loaded_stations, far_bearing, near_bearing]), np.concatenate(
        [applied_forces, far_reaction[:, None], near_reaction[:, None]], axis=1
    )


def bending_moment(loading: Loading, station: float) -> Array:
    """Compute the bending moment of the shaft [N m], shape (m, 2), in its frame at a station along its axis [m]."""
    arm = np.maximum(loading.stations - station, 0.0)
    return np.asarray(np.einsum("p,mpx->mx", arm, loading.shaft))
