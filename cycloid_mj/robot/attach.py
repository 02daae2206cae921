"""The reducer on a joint of any model: its crank beside it, springs between both, the joint's motors on the crank."""

from typing import Any

import mujoco
import numpy as np

from cycloid_mj.base.errors import UsageError
from cycloid_mj.robot.mjcf import (
    NEXT_TO_NOTHING,
    ROTOR_SIZE,
    STICKING_IMPEDANCE,
    STICKING_TIME,
    reducer_name,
    rotor_name,
    slip_inertias,
    slip_name,
)
from cycloid_mj.robot.reducer import ReducedJoint


def attach_reducer(spec: Any, joint: str, reduced: ReducedJoint) -> None:
    """Put a reducer on a hinge of an editable model, at the reducer's level.

    The joint's own armature, friction loss and damping stand for the drive that it had: those of the reducer take their
    place. Its actuators move to the crank, geared so that their controls mean what they did: a torque of the joint, or
    its angle as the motor sees it. Keyframes get the crank's angle. At the level `rigid` nothing moves.

    Parameters
    ----------
    spec
        ``MjSpec``, changed in place.
    joint
        Name of a hinge.
    reduced
        What `reduce` found, or `ReducedJoint.read` read.

    Raises
    ------
    UsageError
        There is no such hinge, it has a reducer, or the model does not compile.
    """
    model = _compiled(spec)
    hinge = spec.joint(joint)
    if hinge is None:
        names = ", ".join(each.name for each in spec.joints if each.name) or "none has a name"
        raise UsageError(f"the model has no joint {joint!r}; its joints: {names}")
    if model.joint(joint).type[0] != mujoco.mjtJoint.mjJNT_HINGE:
        raise UsageError(f"the joint {joint!r} is no hinge: a reducer turns one")
    if any(each.name == reducer_name(joint) for each in spec.tuples):
        raise UsageError(f"the joint {joint!r} has a reducer already: attach one to each joint")
    before = [(list(key.qpos), list(key.qvel)) for key in spec.keys]
    if reduced.level == "rigid":
        hinge.armature, hinge.frictionloss = reduced.reflected_inertia, reduced.no_load_torque_at_output
        hinge.solref_friction, hinge.solimp_friction = [STICKING_TIME, 1.0], STICKING_IMPEDANCE
        hinge.damping = first(0.0)
        _hold_together(spec, reduced, joint, [])
        return
    hinge.armature, hinge.frictionloss = reduced.output_inertia, 0.0
    hinge.damping = first(0.0)
    _add_rotor(hinge, model, reduced)
    tendons = [_add_spring(spec, reduced, joint, number) for number in range(len(reduced.springs))]
    for number in range(len(reduced.slips)):
        _add_slip(spec, hinge, model, reduced, number)
    _hold_together(spec, reduced, joint, tendons)
    _move_actuators(spec, reduced, joint)
    if before:
        _write_keys(spec, before, model, reduced, joint)


def first(coefficient: float) -> list[float]:
    """Compute the coefficients of a stiffness or damping that is a constant: MuJoCo's polynomials have more."""
    return [coefficient, *[0.0] * mujoco.mjNPOLY]


def _compiled(spec: Any) -> Any:
    try:
        return spec.copy().compile()
    except ValueError as problem:
        raise UsageError(f"the model does not compile: {problem}") from problem


def _add_rotor(joint: Any, model: Any, reduced: ReducedJoint) -> None:
    """Add the crank's body where that of the joint is, with the joint's axis."""
    hinge, name = model.joint(joint.name), rotor_name(joint.name)
    carried = model.body(int(hinge.bodyid[0]))
    body = joint.parent.parent.add_body(name=name, pos=carried.pos, quat=carried.quat)
    body.explicitinertial = True
    body.mass, body.inertia = NEXT_TO_NOTHING, [1e-12] * 3
    rotor_joint = body.add_joint(
        name=name,
        type=mujoco.mjtJoint.mjJNT_HINGE,
        pos=hinge.pos,
        axis=hinge.axis,
        armature=reduced.rotor_inertia,
        frictionloss=reduced.no_load_torque,
        solref_friction=[STICKING_TIME, 1.0],
        solimp_friction=STICKING_IMPEDANCE,
        limited=mujoco.mjtLimited.mjLIMITED_FALSE,
    )
    rotor_joint.damping = rotor_joint.stiffness = first(0.0)
    body.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=[*ROTOR_SIZE, 0.0],
        contype=0,
        conaffinity=0,
        mass=NEXT_TO_NOTHING,
        rgba=[0.93, 0.65, 0.49, 1.0],
    )


def _add_spring(spec: Any, reduced: ReducedJoint, joint: str, number: int) -> str:
    spring, name = reduced.springs[number], reducer_name(joint, number)
    tendon = spec.add_tendon(name=name, limited=mujoco.mjtLimited.mjLIMITED_FALSE)
    tendon.wrap_joint(rotor_name(joint), reduced.coefficient)
    tendon.wrap_joint(joint, 1.0)
    tendon.springlength = [reduced.stops[0] - spring.start, reduced.stops[1] + spring.start]
    tendon.stiffness, tendon.damping = first(spring.stiffness), first(0.0 if number else reduced.damping)
    tendon.frictionloss = tendon.armature = 0.0
    return name


def _add_slip(spec: Any, joint: Any, model: Any, reduced: ReducedJoint, number: int) -> None:
    """Add what slips, a body where that of the joint is, and the spring between it and the wind-up."""
    slip, name = reduced.slips[number], slip_name(joint.name, number)
    armature, damping = slip_inertias(reduced)[number]
    carried = model.body(int(model.joint(joint.name).bodyid[0]))
    body = joint.parent.parent.add_body(name=name, pos=carried.pos, quat=carried.quat)
    body.explicitinertial = True
    body.mass, body.inertia = NEXT_TO_NOTHING, [1e-12] * 3
    slipping = body.add_joint(
        name=name,
        type=mujoco.mjtJoint.mjJNT_HINGE,
        axis=model.joint(joint.name).axis,
        armature=armature,
        frictionloss=slip.limit,
        solref_friction=[STICKING_TIME, 1.0],
        solimp_friction=STICKING_IMPEDANCE,
        limited=mujoco.mjtLimited.mjLIMITED_FALSE,
    )
    slipping.damping = slipping.stiffness = first(0.0)
    tendon = spec.add_tendon(name=name, limited=mujoco.mjtLimited.mjLIMITED_FALSE)
    for wrapped, share in ((rotor_name(joint.name), reduced.coefficient), (joint.name, 1.0), (name, -1.0)):
        tendon.wrap_joint(wrapped, share)
    tendon.springlength = [0.0, 0.0]
    tendon.stiffness, tendon.damping = first(slip.stiffness), first(damping)
    tendon.frictionloss = tendon.armature = 0.0


def _hold_together(spec: Any, reduced: ReducedJoint, joint: str, tendons: list[str]) -> None:
    """Note what belongs to the reducer, with its number, for `ReducedJoint.places`."""
    joints = [joint, rotor_name(joint)] if tendons else [joint]
    kinds = [int(mujoco.mjtObj.mjOBJ_JOINT)] * len(joints) + [int(mujoco.mjtObj.mjOBJ_TENDON)] * len(tendons)
    numbers = [float(reduced.fingerprint)] + [0.0] * (len(kinds) - 1)
    spec.add_tuple(name=reducer_name(joint), objname=[*joints, *tendons], objtype=kinds, objprm=numbers)


def _move_actuators(spec: Any, reduced: ReducedJoint, joint: str) -> None:
    """Let the joint's motors turn its crank: 1/coefficient of the joint's turn, the other way."""
    kinds = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)
    for actuator in spec.actuators:
        if actuator.trntype in kinds and actuator.target == joint:
            gear = np.array(actuator.gear)
            gear[0] *= -reduced.coefficient
            actuator.trntype, actuator.target, actuator.gear = mujoco.mjtTrn.mjTRN_JOINT, rotor_name(joint), gear


def _write_keys(
    spec: Any, before: list[tuple[list[float], list[float]]], model: Any, reduced: ReducedJoint, joint: str
) -> None:
    """Set the crank's angle and speed in every keyframe of the model: in the middle of the play, turning along.

    An empty list is a keyframe's default.
    """
    after = _compiled(spec)
    crank, output = after.joint(rotor_name(joint)), model.joint(joint)
    at, along = int(crank.qposadr[0]), int(crank.dofadr[0])
    for key, (positions, speeds) in zip(spec.keys, before, strict=True):
        positions, speeds = positions or model.qpos0.tolist(), speeds or [0.0] * model.nv
        angle = (reduced.middle - positions[int(output.qposadr[0])]) / reduced.coefficient
        speed = -speeds[int(output.dofadr[0])] / reduced.coefficient
        key.qpos = [*positions[:at], angle, *positions[at:]]
        key.qvel = [*speeds[:along], speed, *speeds[along:]]
