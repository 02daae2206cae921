"""What moves a part besides its contacts: gravity, inertia, and the moment that is carried elsewhere."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_mj import kinematics
from cycloid_mj.design import Design
from cycloid_mj.solid import MassProperties, mass_properties, parts
from cycloid_mj.solid.gear import tooth_profile
from cycloid_mj.stress.action import turned
from cycloid_mj.stress.contacts import Contact, frame, total
from cycloid_mj.stress.turn import Turn
from cycloid_mj.types import Array


@dataclass(frozen=True)
class Motion:
    """Inertia of a part along a turn of k samples, in its frame; see `PartLoads` for the four arrays.

    `vibration` [N], shape (k,): what the closed form of the acceleration would leave out of balance of a free part.
    """

    body_force: Array
    spin: Array
    spin_rate: Array
    torque: Array
    vibration: Array


def motion(turn: Turn, part: str, contacts: Sequence[Contact]) -> Motion:
    """Give gravity and inertia of a part, from its contacts' forces where it is free to move."""
    rest = np.zeros_like(turn.angle)
    gravity = _gravity(turn, part)
    if part == "gear":
        return _free(turn, part, contacts, gravity, turn["gear_speed"])
    if part == "pin_1":
        spin = turn["pin_1_speed"] if turn.design.ring.has_pin_bodies else rest
        return _free(turn, part, contacts, gravity, spin)
    if part == "ring":
        return Motion(gravity, rest, rest, rest, rest)
    if part == "shaft":
        rotor = turn.design.drive.rotor_inertia
        moment = total(contacts).moment + turn["crank_torque"]
        spin_rate = moment / (_inertia_about_axis(mass(turn.design, part)) + rotor)
        return Motion(gravity, turn["crank_speed"], spin_rate, turn["crank_torque"] - rotor * spin_rate, rest)
    spin_rate = (total(contacts).moment + turn["load_torque"]) / _inertia_about_axis(mass(turn.design, part))
    return Motion(gravity, turn["output_speed"], spin_rate, turn["load_torque"], rest)


def mass(design: Design, part: str) -> MassProperties:
    """Give the mass properties of a part in the frame of its solid."""
    name = {"ring": "housing", "pin_1": "pin"}.get(part, part)
    return mass_properties(parts(design)[name])


def _free(turn: Turn, part: str, contacts: Sequence[Contact], gravity: Array, spin: Array) -> Motion:
    """Let the forces and gravity accelerate a body whose centroid is the origin of its frame."""
    body, pushed = mass(turn.design, part), total(contacts)
    balance = -pushed.force / body.mass
    left = body.mass * (gravity - _closed_form(turn, part)) + pushed.force
    return Motion(
        body_force=balance,
        spin=spin,
        spin_rate=pushed.moment / float(body.inertia[2, 2]),
        torque=np.zeros_like(spin),
        vibration=np.linalg.norm(left, axis=-1),
    )


def _closed_form(turn: Turn, part: str) -> Array:
    """Acceleration of the origin by the closed form, in the part's frame [m/s2], (k, 2): a pin rests."""
    if part != "gear":
        return np.zeros((turn.angle.size, 2))
    gear = tooth_profile(turn.design)
    world = kinematics.gear_centre_acceleration(gear, turn["crank_angle"], turn["crank_speed"])
    return turned(world, -frame(turn, part).angle)


def _gravity(turn: Turn, part: str) -> Array:
    """Gravity in the part's frame [m/s2], shape (k, 2)."""
    environment = turn.design.environment
    world = np.array([environment.gravity_x, environment.gravity_y])
    return turned(np.broadcast_to(world, (turn.angle.size, 2)), -frame(turn, part).angle)


def _inertia_about_axis(body: MassProperties) -> float:
    """Moment of inertia about the reducer's axis [kg m2]."""
    return float(body.inertia[2, 2] + body.mass * np.sum(body.centroid[:2] ** 2))
