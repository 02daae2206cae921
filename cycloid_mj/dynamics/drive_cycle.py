"""Drive cycle of a run: initial state, and commands of crank and output over time.

The *driven* shaft follows a position command by its servo; a torque acts on the other shaft.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import mujoco
import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array
from cycloid_mj.dynamics.mjcf import ReducerModel
from cycloid_mj.dynamics.mjcf.keyframe import joint_state
from cycloid_mj.geometry.kinematics import CrankLaw
from cycloid_mj.reducer import Reducer

Signal = Callable[[Array], Array]


class Held(Protocol):
    """Properties of a model that a drive cycle needs."""

    @property
    def servo_gains(self) -> tuple[float, float]:
        """Gains kp [N m/rad] and kv [N m s/rad]."""

    @property
    def crank_inertia(self) -> float:
        """Inertia of shaft and rotor about the crank axis [kg m2]."""


@dataclass(frozen=True)
class DriveCycle:
    """Drive cycle of one run.

    Attributes
    ----------
    angle, speed
        Angle and speed of the crank at t = 0 [rad, rad/s]; all other bodies start at their closed-form positions.
    drive, load
        Commands of crank and output at times [s], shape (n,): the position [rad] of the driven shaft, the torque about
        +z [N m] on the other one.
    """

    angle: float
    speed: float
    drive: Signal
    load: Signal

    def commands(self, time: Array) -> Array:
        """Return both commands at times [s], shape (n, 2)."""
        return np.stack([self.drive(time), self.load(time)], axis=1)


def ramp_and_hold(model: Held, reducer: Reducer) -> DriveCycle:
    """Return the drive cycle of a design: the crank speed ramps up and stays constant, the load rises.

    The load is a torque on the output, which rises to that of the design. The crank starts at the angle 0, at rest, or
    at full speed if there is no ramp. `model` provides the servo's gains and the inertia that it moves.
    """
    design = reducer.design
    crank_law = CrankLaw(design.drive.speed, design.drive.ramp)
    return DriveCycle(
        angle=0.0,
        speed=float(crank_law.speed_at(0.0)) if design.drive.ramp == 0.0 else 0.0,
        drive=lambda time: servo_target(model, crank_law, time),
        load=lambda time: load_torque(reducer, time),
    )


def locked_crank(compiled: Held, angle: float, torque: Signal) -> DriveCycle:
    """Return a cycle with the crank at rest at an angle [rad] and a torque on the output [N m] over time [s]."""
    law = CrankLaw(0.0, 0.0)
    return DriveCycle(angle, 0.0, lambda time: angle + servo_target(compiled, law, time), torque)


def braked_output(model: Held, reducer: Reducer, torque: Signal) -> DriveCycle:
    """Return a drive cycle with a torque on the crank, and the constant output speed at the design's crank speed.

    The servo of the `model` must be on the output: ``build(design, held="output")``. The crank starts at angle 0 and at
    full speed; `torque` is a function of the times (n,) [s], with values [N m].
    """
    design = reducer.design
    speed = design.drive.speed
    law = CrankLaw(speed / design.ratio, 0.0)
    return DriveCycle(0.0, speed, torque, lambda time: servo_target(model, law, time))


def rising(torque: float, rise: float) -> Signal:
    """Return a torque [N m] that rises as a half cosine over `rise` [s] and then stays constant."""
    return lambda time: torque * 0.5 * (1.0 - np.cos(np.pi * np.clip(time / rise, 0.0, 1.0)))


def initial_state(model: ReducerModel, reducer: Reducer, cycle: DriveCycle | None = None) -> Any:
    """Return a new ``MjData`` with the closed-form positions and speeds of all joints at the start of a drive cycle.

    `model` is the compiled MuJoCo model. The default is the cycle of the design, `ramp_and_hold`.
    """
    cycle = cycle or ramp_and_hold(model, reducer)
    data = mujoco.MjData(model.model)
    position_by_joint, velocity_by_joint = joint_state(reducer, cycle.angle, cycle.speed)
    for joint, position in position_by_joint.items():
        data.joint(joint).qpos[0] = position
    for joint, velocity in velocity_by_joint.items():
        data.joint(joint).qvel[0] = velocity
    return data


def load_torque(reducer: Reducer, time: npt.ArrayLike) -> Array:
    """Return the torque of the load on the output [N m], against its rotation; it rises as a half cosine from zero."""
    design = reducer.design
    return braking_sign(reducer) * rising(design.load.torque, design.load.rise)(np.asarray(time, dtype=np.float64))


def braking_sign(reducer: Reducer) -> float:
    """Compute the sign of a torque on the output that brakes the design's crank: 1 of a counter-clockwise one."""
    return math.copysign(1.0, reducer.design.drive.speed) * reducer.member.sense


def servo_target(compiled: Held, law: CrankLaw, time: Array) -> Array:
    """Return the position command [rad] with which the servo follows a law without lag in speed or acceleration."""
    kp, kv = compiled.servo_gains
    torque = compiled.crank_inertia * law.acceleration_at(time)
    return law.angle_at(time) + (kv * law.speed_at(time) + torque) / kp
