"""Keyframes of a model: all parts in their closed-form positions, at rest or at full speed."""

import math
from typing import Any

from cycloid_mj.base import names
from cycloid_mj.geometry.kinematics import gear_centre
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.reducer.limits import Fit, best_fit, pressed_fit
from cycloid_mj.reducer.rv_bodies import rv_motion
from cycloid_mj.statics.balance import loads
from cycloid_mj.statics.springs import springs_of

QUARTERS = (0, 90, 180, 270)
"""Crank angles of the keyframes [deg]."""

HOME = "home"


def keyframe_name(angle: int, speed: float) -> str:
    """Name the keyframe at a crank angle [deg] and speed [rad/s]: ``home``, ``rest_90``, ``1640rpm_0``, ..."""
    if speed:
        return f"{speed * 30.0 / math.pi:.6g}rpm_{angle}"
    return f"rest_{angle}" if angle else HOME


def add_keyframes(spec: Any, reducer: Reducer) -> None:
    """Add keyframes at the four crank angles `QUARTERS` [deg] to the editable model `spec` (``MjSpec``), without load.

    Each angle has a keyframe at rest, and another at the design's speed if that is not 0.
    """
    model = spec.compile()
    for speed in dict.fromkeys((0.0, reducer.design.drive.speed)):
        for angle in QUARTERS:
            position_by_joint, velocity_by_joint = joint_state(reducer, math.radians(angle), speed)
            qpos, qvel = model.qpos0.copy(), [0.0] * model.nv
            for joint in position_by_joint:
                qpos[model.joint(joint).qposadr[0]] = position_by_joint[joint]
            for joint in velocity_by_joint:
                qvel[model.joint(joint).dofadr[0]] = velocity_by_joint[joint]
            ctrl = [speed if model.actuator(i).name == names.DRIVE else 0.0 for i in range(model.nu)]
            spec.add_key(name=keyframe_name(angle, speed), qpos=list(qpos), qvel=qvel, ctrl=ctrl)


def joint_state(reducer: Reducer, crank: float, speed: float) -> tuple[dict[str, float], dict[str, float]]:
    """Compute positions and velocities of all joints at a crank angle [rad] and speed [rad/s] of the ideal motion.

    By Hsieh 2014, Eqs 12 and 13 (corrected), the gear's centre runs on a circle, and gear and output rotate at
    -speed/(N-1), with N ring teeth. If the ring is the output, it rotates at speed/N, and the gear does not rotate. If
    parts have errors or modified flanks, they and moving pins are displaced to their `best_fit`. In an RV reducer,
    `crank` and `speed` are those of the sun, see `rv_motion`.

    Returns
    -------
    tuple of dict
        Positions [m] or [rad], and velocities [m/s] or [rad/s], by joint name.
    """
    if isinstance(reducer, RvReducer):
        return rv_motion(reducer, crank, speed)
    gear = reducer.tooth_profile
    disc_angle, disc_speed = float(reducer.member.gear_angle(crank)), float(reducer.member.gear_angle(speed))
    position_by_joint = {names.CRANK_JOINT: crank, names.OUTPUT_JOINT: float(reducer.member.output_angle(crank))}
    velocity_by_joint = {names.CRANK_JOINT: speed, names.OUTPUT_JOINT: float(reducer.member.output_angle(speed))}
    for disc, phase in zip(reducer.mechanism.discs, reducer.mechanism.phases, strict=True):
        x, y = (float(coordinate) for coordinate in gear_centre(gear, crank + phase))
        position_by_joint |= dict(zip(disc.joints, (x, y, disc_angle), strict=True))
        velocity_by_joint |= dict(zip(disc.joints, (-speed * y, speed * x, disc_speed), strict=True))
    if not reducer.is_ideal:
        for joint, shift in _best_fit_shifts(reducer, crank).items():
            position_by_joint[joint] = position_by_joint.get(joint, 0.0) + shift
    return position_by_joint, velocity_by_joint


IDLE = 1e-3
"""Share of the nominal torque under which a drive with a preload rests (heuristic): without any, its output has no
place."""


def _resting_fit(reducer: Reducer, crank: float) -> Fit:
    """Return the best fit of the parts at a crank angle [rad]: with the most clearance, or pressed by a preload."""
    if not reducer.design.ring.preload:
        return best_fit(reducer, crank)
    torque = math.copysign(IDLE * reducer.design.rated_torque, reducer.design.drive.speed)
    (pose,) = loads(reducer, springs_of(reducer, crank, friction=False), torque).departures
    return pressed_fit(reducer, crank, pose)


def _best_fit_shifts(reducer: Reducer, crank: float) -> dict[str, float]:
    """Compute the displacements of all joints from the ideal mesh to the best fit of parts with errors, by joint.

    The best fit is the pose with the largest minimum gap. The displacements are in [m] or [rad], along the axes of the
    frame that does not move, except that those of pins are in the frame of the ring. `crank` is the crank angle [rad].
    """
    resting_fit, angle = _resting_fit(reducer, crank), float(reducer.member.ring_angle(crank))
    cosine, sine = math.cos(angle), math.sin(angle)
    shifts: dict[str, float] = {}
    for disc, (x, y), rotation in zip(
        reducer.mechanism.discs, resting_fit.shift.tolist(), resting_fit.gear_turn.tolist(), strict=True
    ):
        shifts |= dict(zip(disc.joints, (x * cosine - y * sine, x * sine + y * cosine, rotation), strict=True))
    for pin, shift in zip(reducer.mechanism.pins, resting_fit.pin_shift, strict=False):
        shifts |= dict(zip(pin.joints[:2], shift.tolist(), strict=True))
    return shifts | {names.OUTPUT_JOINT: resting_fit.output_turn}
