"""Trial scene of a reduced joint in MuJoCo: locked or turning crank, torque on the output, measured L."""

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


@dataclass(frozen=True)
class TrialScene:
    """Scene that is ready to step."""

    reduced: ReducedJoint
    """The joint, at its level."""
    model: Any
    data: Any
    """``MjModel`` and ``MjData``."""
    place: JointAddresses
    """Addresses of the joint in them."""

    @property
    def length(self) -> float:
        """L [rad]."""
        angles = self.data.qpos
        return float(angles[self.place.output_angle] + self.reduced.coefficient * angles[self.place.crank_angle])

    def hold(self, speed: float = 0.0) -> None:
        """Set the speed of the crank [rad/s] independent of the torque on it, with the output at the same ratio."""
        self.model.dof_armature[self.place.crank_speed] = 1e9 * self.reduced.rotor_inertia
        mujoco.mj_setConst(self.model, self.data)
        self.data.qvel[self.place.crank_speed] = speed
        self.data.qvel[self.place.output_speed] = -self.reduced.coefficient * speed

    def push(self, torque: float) -> None:
        """Apply a torque to the output [N m], counter-clockwise."""
        self.data.qfrc_applied[self.place.output_speed] = torque

    def press(self, torque: float) -> None:
        """Apply a torque to the output [N m], and set the wind-up that it causes."""
        reduced, angle = self.reduced, float(self.data.qpos[self.place.crank_angle])
        side, size = int(torque > 0.0), abs(torque)
        length = reduced.stops[side] + reduced.wind_up(size) * (1.0 if side else -1.0)
        if reduced.level == "full":
            length += reduced.ripple.errors(angle, size / reduced.rated_torque)[side]
        self.data.qpos[self.place.output_angle] = length - reduced.coefficient * angle
        self.push(torque)

    def step(self) -> None:
        """Take one time step, at the level `full` with `ReducedJoint.step`."""
        if self.reduced.level == "full":
            self.reduced.step(self.model, self.data)
        mujoco.mj_step(self.model, self.data)

    def rest(self, torque: float) -> float:
        """Compute L [rad] at which the output rests in MuJoCo under a torque on it [N m], with a locked crank.

        It is the root of the acceleration: the springs alone determine it, without damping or time to settle. The
        torque must not be 0, because the output rests anywhere within the play.
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
        """Compute L after each time step under a torque on the output as a function of time; None if it runs away."""
        reduced, lengths = self.reduced, np.empty(steps)
        # MuJoCo warns much later
        most = 100.0 * (reduced.backlash + reduced.wind_up(reduced.rated_torque))
        for i in range(steps):
            self.push(torque(float(self.data.time)))
            self.step()
            lengths[i] = self.length
            if not abs(lengths[i] - reduced.middle) < most:
                return None
        return lengths

    def friction_torque(self) -> float:
        """Compute the friction torque on the crank in the last time step [N m], against its motion."""
        efc = (self.data.efc_type == int(mujoco.mjtConstraint.mjCNSTR_FRICTION_DOF)) & (
            self.data.efc_id == self.place.crank_speed
        )
        return float(-self.data.efc_force[efc].sum() * np.sign(self.data.qvel[self.place.crank_speed]))


def trial_scene(
    reduced: ReducedJoint, load_inertia: float, timestep: float, integrator: Integrator = "discrete"
) -> TrialScene:
    """Create the scene of a joint at its level with an inertia on the output [kg m2] and a time step [s]."""
    scene = scene_xml(reduced, load_inertia, timestep, integrator)
    model = mujoco.MjModel.from_xml_string(scene, {"joint.xml": joint_xml(reduced).encode()})
    # instability is detected by its values, not by a log of warnings in the user's folder
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
    return TrialScene(reduced, model, mujoco.MjData(model), next(reduced.places(model)))
