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
    addresses: JointAddresses
    """Addresses of the joint in them."""

    @property
    def length(self) -> float:
        """Deviation L of the output from the ideal angle at the crank's angle [rad]."""
        angles = self.data.qpos
        return float(
            angles[self.addresses.output_angle] + self.reduced.coefficient * angles[self.addresses.crank_angle]
        )

    def hold(self, speed: float = 0.0) -> None:
        """Force the crank to turn at a constant speed [rad/s], or lock it at 0.

        The crank gets an armature so large that no torque changes its speed. The output starts at the ideal speed, the
        crank speed divided by the ratio.
        """
        self.model.dof_armature[self.addresses.crank_speed] = 1e9 * self.reduced.rotor_inertia
        mujoco.mj_setConst(self.model, self.data)
        self.data.qvel[self.addresses.crank_speed] = speed
        self.data.qvel[self.addresses.output_speed] = -self.reduced.coefficient * speed

    def push(self, torque: float) -> None:
        """Apply a torque to the output [N m], counter-clockwise."""
        self.data.qfrc_applied[self.addresses.output_speed] = torque

    def press_to_stop(self, torque: float) -> None:
        """Apply a torque to the output [N m], and set its angle to that of equilibrium with the springs."""
        reduced, crank_angle = self.reduced, float(self.data.qpos[self.addresses.crank_angle])
        stop_index, magnitude = int(torque > 0.0), abs(torque)
        deviation = reduced.stops[stop_index] + reduced.wind_up(magnitude) * (1.0 if stop_index else -1.0)
        if reduced.level == "full":
            deviation += reduced.ripple.errors(crank_angle, magnitude / reduced.rated_torque)[stop_index]
        self.data.qpos[self.addresses.output_angle] = deviation - reduced.coefficient * crank_angle
        self.push(torque)

    def step(self) -> None:
        """Take one time step, at the level `full` with `ReducedJoint.step`."""
        if self.reduced.level == "full":
            self.reduced.step(self.model, self.data)
        mujoco.mj_step(self.model, self.data)

    def find_rest(self, torque: float) -> float:
        """Find the deviation L [rad] at which the output rests in MuJoCo under a torque [N m], with a locked crank.

        L is the output's angle minus its ideal angle. It is the root of the acceleration, found by Brent's method
        without simulating the motion, and depends on the springs only. The torque must not be 0, because the output
        then rests anywhere within the play.
        """
        from scipy.optimize import brentq

        reduced, data = self.reduced, self.data

        def acceleration(deviation: float) -> float:
            data.qpos[self.addresses.output_angle] = (
                deviation - reduced.coefficient * data.qpos[self.addresses.crank_angle]
            )
            mujoco.mj_forward(self.model, data)
            return float(data.qacc[self.addresses.output_speed])

        self.push(torque)
        bracket = reduced.wind_up(torque)
        while acceleration(reduced.stops[0] - bracket) <= 0.0 or acceleration(reduced.stops[1] + bracket) >= 0.0:
            bracket *= 2.0
        return float(
            brentq(acceleration, reduced.stops[0] - bracket, reduced.stops[1] + bracket, xtol=1e-15, rtol=1e-14)
        )

    def simulate_deviation(self, torque: Callable[[float], float], steps: int) -> Array | None:
        """Simulate a number of time steps under an output torque [N m] that is a function of time [s].

        It starts from the present state. Return the output's angle minus its ideal angle after each step [rad], shape
        (steps,), or None if the simulation diverges.
        """
        reduced, deviations = self.reduced, np.empty(steps)
        # MuJoCo warns much later
        divergence_limit = 100.0 * (reduced.backlash + reduced.wind_up(reduced.rated_torque))
        for step in range(steps):
            self.push(torque(float(self.data.time)))
            self.step()
            deviations[step] = self.length
            if not abs(deviations[step] - reduced.middle) < divergence_limit:
                return None
        return deviations

    def friction_torque(self) -> float:
        """Compute the friction torque on the crank in the last time step [N m], against its motion."""
        efc = (self.data.efc_type == int(mujoco.mjtConstraint.mjCNSTR_FRICTION_DOF)) & (
            self.data.efc_id == self.addresses.crank_speed
        )
        return float(-self.data.efc_force[efc].sum() * np.sign(self.data.qvel[self.addresses.crank_speed]))


def create_trial_scene(
    reduced: ReducedJoint, load_inertia: float, timestep: float, integrator: Integrator = "discrete"
) -> TrialScene:
    """Create a MuJoCo scene for tests of a reduced joint, with an inertia on its output [kg m2] and a time step [s].

    `integrator` is the value of MuJoCo's option. The joint is `reduced`, at its own level of detail ("rigid",
    "backlash" or "full").
    """
    scene = scene_xml(reduced, load_inertia, timestep, integrator)
    model = mujoco.MjModel.from_xml_string(scene, {"joint.xml": joint_xml(reduced).encode()})
    # instability is detected by its values, not by a log of warnings in the user's folder
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
    return TrialScene(reduced, model, mujoco.MjData(model), next(reduced.places(model)))
