"""Loads on a part, in the part's own frame, at crank angles of one revolution."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.names import GEAR, family, gears
from cycloid_mj.base.record import Run
from cycloid_mj.parts import MassProperties, body_solids, mass_properties
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.stress.contacts import Action, list_contacts, part_frame, rotate_vectors, total
from cycloid_mj.stress.turn import DEGREES, Turn, select_turn

PARTS = ("shaft", "gear", "ring", "output", "pin_1")
"""Parts in their order; each of several discs is a part: gear_1, gear_2, ..."""


@dataclass(frozen=True)
class PartLoads:
    """Loads on one part in its own frame (the frame of its solid: see `cycloid_mj.parts`), at k crank angles.

    The body force at r (from the origin of the part's frame) is rho (body_force + spin^2 r - spin_rate z x r).
    """

    part: str
    """"shaft", "gear" (of several "gear_1"), "ring" (pinwheel or internal gear), "output", or "pin_1"."""
    angle: Array
    """Crank angle [rad], shape (k,)."""
    position: Array
    """Centre of each contact patch [m], shape (k, m, 2); nan where there is none."""
    force: Array
    """Force on the part, normal and friction [N], shape (k, m, 2); zero where there is none."""
    half_width: Array
    """Half width of each patch on the part [m], shape (k, m): Hertz's, or that of a conformal contact."""
    pressure: Array
    """Hertz's peak pressure of the most loaded line contact in each patch [Pa], shape (k, m)."""
    strip: Array
    """Half width of that line contact [m], shape (k, m)."""
    hertz: Mask
    """Whether Hertz holds for that line contact, shape (k, m): not where it is conformal."""
    labels: tuple[str, ...]
    """Name of each of the m contacts, e.g. "pin_3", "cam", "output_pin_2", of several discs "gear_2_cam"."""
    body_force: Array
    """Gravity minus the acceleration of the frame's origin [m/s2], shape (k, 2)."""
    spin: Array
    """Angular velocity [rad/s], shape (k,)."""
    spin_rate: Array
    """Angular acceleration [rad/s2], shape (k,)."""
    torque: Array
    """Moment about z that is carried elsewhere (crank torque, load) [N m], shape (k,)."""

    @property
    def narrow(self) -> Mask:
        """True if each patch is Hertz's strip itself, shape (k, m): no conformal one, and no row of rollers."""
        return np.asarray(self.hertz & (self.half_width < 2.0 * self.strip))


def part_names(reducer: Reducer) -> tuple[str, ...]:
    """Return the names of the parts of a design whose stress can be computed by finite elements, in order of `PARTS`.

    With sleeves on the ring pins, ring and pin are left out, because the housing supports such pins next to the disc,
    out of its plane. For an RV reducer, shaft and output are left out.
    """
    design = reducer.design
    omitted_parts = (
        {"ring", "pin_1"} if design.ring.has_sleeves else {"pin_1"} if design.ring.kind == "nonpin" else set()
    )
    discs = gears(design.gear.discs)
    if isinstance(reducer, RvReducer):
        omitted_parts |= {"shaft", "output"}
    return tuple(name for part in PARTS if part not in omitted_parts for name in (discs if part == GEAR else (part,)))


def part_loads(run: Run, reducer: Reducer, part: str, angles: npt.ArrayLike = DEGREES) -> PartLoads:
    """Compute contact forces, weight and inertia of a part in its own frame at crank angles, from a logged run.

    The samples nearest to the angles in the last turn at constant speed and load are used. Each force, including
    friction, acts where its line of action intersects the surface on which it presses. On a wide patch, it acts where
    the tractions have the logged moment. Free parts (disc and pin 1) have the acceleration that their contact forces
    cause (d'Alembert), so that loads and inertia are in equilibrium at each sample.

    Parameters
    ----------
    run, reducer
        A logged run, and the reducer that ran.
    part
        ``gear`` (with several discs ``gear_1``, ...), ``ring``, ``output``, ``shaft`` or ``pin_1``.
    angles
        The k crank angles [rad], shape (k,); by default every degree.

    Raises
    ------
    UsageError
        The design has no such part, or is not the design that ran.
    LogError
        The run contains no design or no forces, or too few samples at constant speed and load.
    """
    require_part(reducer, part)
    return loads_in_turn(select_turn(run, reducer, angles), part)


def loads_in_turn(sampled: Turn, part: str) -> PartLoads:
    """Compute contact forces, weight and inertia of a part in its own frame at each angle of a turn.

    `sampled` is a turn of a run or of a static equilibrium, `part` the name of the part.
    """
    contacts = list_contacts(sampled, part)
    return PartLoads(
        part=part,
        angle=sampled.angle,
        position=np.stack([contact.position for contact in contacts], axis=1),
        force=np.stack([contact.action.force for contact in contacts], axis=1),
        half_width=np.stack([contact.half_width for contact in contacts], axis=1),
        pressure=np.stack([contact.line.pressure for contact in contacts], axis=1),
        strip=np.stack([contact.line.half_width for contact in contacts], axis=1),
        hertz=np.stack([contact.line.valid for contact in contacts], axis=1),
        labels=tuple(contact.name for contact in contacts),
        **_motion_loads(sampled, part, total(contacts)),
    )


def turn_of(run: Run | None, reducer: Reducer, angles: npt.ArrayLike) -> Turn:
    """Return positions and contact forces of a run at k crank angles [rad] of a turn, shape (k,).

    For an RV reducer, which has no run (None), positions and forces follow from the static equilibrium.

    Raises
    ------
    UsageError
        There is no run and the reducer is no RV reducer, or the run is of another reducer.
    LogError
        The run contains no design or no forces, or too few samples at constant speed and load.
    """
    if run is not None:
        return select_turn(run, reducer, angles)
    if not isinstance(reducer, RvReducer):
        raise UsageError(f"the stress of {reducer.design.name!r} is computed from a run: simulate the design first")
    from cycloid_mj.stress.static_turn import static_turn

    return static_turn(reducer, angles)


def select_contacts(loads: PartLoads, chosen: Mask) -> PartLoads:
    """Return the loads with the forces of the m contacts set to zero where a mask of shape (m,) is false."""
    return replace(loads, force=np.where(chosen[:, np.newaxis], loads.force, 0.0))


def _motion_loads(turn: Turn, part: str, contact_sum: Action) -> dict[str, Array]:
    """Compute the loads of a part other than its contact forces at k crank angles, as fields of `PartLoads`.

    By name, they are "body_force" (gravity minus acceleration) [m/s2] (k, 2), "spin" [rad/s], "spin_rate" [rad/s2] and
    "torque" (torque of crank, load or fixation) [N m], (k,) each. `turn` has positions and speeds, and `contact_sum` is
    the resultant of the contact forces on the part.
    """
    zeros = np.zeros_like(turn.angle)
    environment = turn.reducer.design.environment
    gravity = np.broadcast_to([environment.gravity_x, environment.gravity_y], (turn.angle.size, 2))
    # in the frame of the ring, gravity rotates backwards
    gravity, frame_speed = rotate_vectors(gravity, -turn.ring_angle), -turn.ring_speed
    loads = {
        "body_force": rotate_vectors(gravity, -part_frame(turn, part).angle),
        "spin": zeros,
        "spin_rate": zeros,
        "torque": zeros,
    }
    if part == "ring":
        return loads
    properties = mass_properties(body_solids(turn.reducer)[{"pin_1": "pin"}.get(part, part)])
    if part == "pin_1" or family(part) == GEAR:  # their centroid is the origin of their frame
        is_moving = part != "pin_1" or turn.reducer.design.ring.has_pin_bodies
        spin = turn[f"{part}_speed"] - frame_speed * (part != "pin_1") if is_moving else zeros
        spin_rate = contact_sum.moment / float(properties.inertia[2, 2])
        return loads | {"body_force": -contact_sum.force / properties.mass, "spin": spin, "spin_rate": spin_rate}
    if part == "shaft":
        motor_inertia = turn.reducer.design.drive.rotor_inertia
        spin_rate = (contact_sum.moment + turn["crank_torque"]) / (_inertia_about_axis(properties) + motor_inertia)
        torque = turn["crank_torque"] - motor_inertia * spin_rate
        return loads | {"spin": turn["crank_speed"] - frame_speed, "spin_rate": spin_rate, "torque": torque}
    if not turn.reducer.mechanism.body(part).joints:  # it is fixed
        return loads | {"torque": -contact_sum.moment}
    spin_rate = (contact_sum.moment + turn["load_torque"]) / _inertia_about_axis(properties)
    return loads | {"spin": turn["output_speed"], "spin_rate": spin_rate, "torque": turn["load_torque"]}


def _inertia_about_axis(body: MassProperties) -> float:
    """Compute the moment of inertia about the reducer's axis [kg m2]."""
    return float(body.inertia[2, 2] + body.mass * np.sum(body.centroid[:2] ** 2))


def require_part(reducer: Reducer, part: str) -> None:
    """Raise UsageError unless a design has a part whose stress can be computed."""
    if part not in part_names(reducer):
        reason = ""
        if reducer.design.ring.has_sleeves and part in ("ring", "pin_1"):
            reason = " whose stress can be computed (sleeved pins are supported next to the disc, out of its plane)"
        choices = ", ".join(part_names(reducer))
        raise UsageError(f"the design {reducer.design.name!r} has no part {part!r}{reason}: choose one of {choices}")
