"""The reduced joint on its own bench in MuJoCo: crank held or turned, a torque on the output, L read off."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, get_args

import mujoco
import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.robot.mjcf import joint_xml, scene_xml
from cycloid_mj.robot.reducer import JointAddresses, ReducedJoint

Integrator = Literal["implicitfast", "discrete"]

INTEGRATORS: tuple[Integrator, ...] = get_args(Integrator)

FLYWHEEL = 1e9
"""Inertia that holds a crank, or its speed, over the crank's own [1]."""

RUNAWAY = 100.0
"""A joint that leaves its stops by this many rated wind-ups is unstable; MuJoCo's own warnings come much later."""


@dataclass(frozen=True)
class TrialScene:
    """A scene that is ready to step.

    Attributes
    ----------
    reducer
        What is on it, at its level.
    model, data
        MuJoCo's own.
    place
        Where the reducer is in them.
    """

    reduced: ReducedJoint
    model: Any
    data: Any
    place: JointAddresses

    @property
    def length(self) -> float:
        """L [rad]."""
        angles = self.data.qpos
        return float(angles[self.place.output_angle] + self.reduced.coefficient * angles[self.place.crank_angle])

    def hold(self, speed: float = 0.0) -> None:
        """Let the crank turn at a speed [rad/s] whatever the torque on it, the output along with it."""
        self.model.dof_armature[self.place.crank_speed] = FLYWHEEL * self.reduced.rotor_inertia
        mujoco.mj_setConst(self.model, self.data)
        self.data.qvel[self.place.crank_speed] = speed
        self.data.qvel[self.place.output_speed] = -self.reduced.coefficient * speed

    def push(self, torque: float) -> None:
        """Put a torque on the output [N m], counter-clockwise."""
        self.data.qfrc_applied[self.place.output_speed] = torque

    def press(self, torque: float) -> None:
        """Put a torque on the output [N m] that is wound up by it already."""
        reduced, angle = self.reduced, float(self.data.qpos[self.place.crank_angle])
        side, size = int(torque > 0.0), abs(torque)
        length = reduced.stops[side] + reduced.wind_up(size) * (1.0 if side else -1.0)
        if reduced.level == "full":
            length += reduced.ripple.errors(angle, size / reduced.rated_torque)[side]
        self.data.qpos[self.place.output_angle] = length - reduced.coefficient * angle
        self.push(torque)

    def step(self) -> None:
        """Take one step, at the level `full` with what MJCF cannot say."""
        if self.reduced.level == "full":
            self.reduced.step(self.model, self.data)
        mujoco.mj_step(self.model, self.data)

    def rest(self, torque: float) -> float:
        """Find L [rad] at which MuJoCo lets the output rest under a torque on it [N m], the crank held.

        There its acceleration is zero: the springs alone say where, and neither the way across the play nor damping or
        a time of waiting has a part in it. The torque must not be 0: within the play the output rests anywhere.
        """
        from scipy.optimize import brentq

        reduced, data = self.reduced, self.data

        def pull(length: float) -> float:
            data.qpos[self.place.output_angle] = length - reduced.coefficient * data.qpos[self.place.crank_angle]
            mujoco.mj_forward(self.model, data)
            return float(data.qacc[self.place.output_speed])

        self.push(torque)
        reach = reduced.wind_up(torque)
        while pull(reduced.stops[0] - reach) <= 0.0 or pull(reduced.stops[1] + reach) >= 0.0:
            reach *= 2.0
        return float(brentq(pull, reduced.stops[0] - reach, reduced.stops[1] + reach, xtol=1e-15, rtol=1e-14))

    def lengths(self, torque: Callable[[float], float], steps: int) -> Array | None:
        """Compute L after each step under a torque on the output by time; None where it runs away."""
        reduced, lengths = self.reduced, np.empty(steps)
        most = RUNAWAY * (reduced.backlash + reduced.wind_up(reduced.rated_torque))
        for i in range(steps):
            self.push(torque(float(self.data.time)))
            self.step()
            lengths[i] = self.length
            if not abs(lengths[i] - reduced.middle) < most:
                return None
        return lengths

    def friction_torque(self) -> float:
        """Compute the torque of friction on the crank in the step just taken [N m], against its way."""
        efc = (self.data.efc_type == int(mujoco.mjtConstraint.mjCNSTR_FRICTION_DOF)) & (
            self.data.efc_id == self.place.crank_speed
        )
        return float(-self.data.efc_force[efc].sum() * np.sign(self.data.qvel[self.place.crank_speed]))


def bench(
    reduced: ReducedJoint, load_inertia: float, timestep: float, integrator: Integrator = "discrete"
) -> TrialScene:
    """Build the scene of a reducer at its level with an inertia [kg m2] on the output; `timestep` in seconds."""
    scene = scene_xml(reduced, load_inertia, timestep, integrator)
    model = mujoco.MjModel.from_xml_string(scene, {"joint.xml": joint_xml(reduced).encode()})
    # what runs away is told by its values, not by a file of warnings in the user's folder
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
    return TrialScene(reduced, model, mujoco.MjData(model), next(reduced.places(model)))
