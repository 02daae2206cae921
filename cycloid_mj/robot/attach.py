"""Attach a reducer to a joint of any model: crank, springs between crank and joint, and motors on the crank."""

from typing import Any

import mujoco
import numpy as np

from cycloid_mj.base.errors import UsageError
from cycloid_mj.robot.mjcf import MJCF, reducer_name, rotor_name, slip_inertias, slip_name
from cycloid_mj.robot.reducer import ReducedJoint


def attach_reducer(spec: Any, joint: str, reduced: ReducedJoint) -> None:
    """Attach a reducer to a hinge of an editable MuJoCo model: add a crank body, springs to the hinge, and friction.

    Armature, friction loss and damping of the hinge are replaced by those of the reducer. Its actuators are moved to
    the crank, with a gear that keeps the meaning of their controls: a torque at the joint, or the joint's angle as
    measured at the motor. Keyframes get the angle of the crank. At the level `rigid` there is no crank.

    Parameters
    ----------
    spec
        ``MjSpec``, changed in place.
    joint
        Name of a hinge.
    reduced
        Result of `reduce`, or of `ReducedJoint.read`.

    Raises
    ------
    UsageError
        The hinge does not exist, it has a reducer, or the model does not compile.
    """
    model = _compile_copy(spec)
    hinge = spec.joint(joint)
    if hinge is None:
        hinges = (element for element in spec.joints if element.type == mujoco.mjtJoint.mjJNT_HINGE)
        hinge_names = ", ".join(hinge.name for hinge in hinges if hinge.name)
        remedy = (
            f"choose one of {hinge_names}" if hinge_names else "give a hinge of the model a name, because none has one"
        )
        raise UsageError(f"the model has no joint {joint!r}: {remedy}")
    if model.joint(joint).type[0] != mujoco.mjtJoint.mjJNT_HINGE:
        raise UsageError(
            f"the joint {joint!r} is not a hinge: choose a hinge joint, because reducers can be attached to hinges only"
        )
    if any(element.name == reducer_name(joint) for element in spec.tuples):
        raise UsageError(
            f"the joint {joint!r} already has a reducer, and only one is allowed: choose another joint, or attach the "
            "reducer to the original model"
        )
    keyframes = [(list(keyframe.qpos), list(keyframe.qvel)) for keyframe in spec.keys]
    if reduced.level == "rigid":
        hinge.armature, hinge.frictionloss = reduced.reflected_inertia, reduced.no_load_torque_at_output
        hinge.solref_friction, hinge.solimp_friction = [MJCF.sticking_time, 1.0], MJCF.sticking_impedance
        hinge.damping = constant_polynomial(0.0)
        _add_tuple(spec, reduced, joint, [])
        return
    hinge.armature, hinge.frictionloss = reduced.output_inertia, 0.0
    hinge.damping = constant_polynomial(0.0)
    _add_crank_body(hinge, model, reduced)
    tendons = [_add_spring_tendon(spec, reduced, joint, index) for index in range(len(reduced.springs))]
    for index in range(len(reduced.slips)):
        _add_slip_element(spec, hinge, model, reduced, index)
    _add_tuple(spec, reduced, joint, tendons)
    _move_actuators_to_crank(spec, reduced, joint)
    if keyframes:
        _write_keyframes(spec, keyframes, model, reduced, joint)


def constant_polynomial(coefficient: float) -> list[float]:
    """Return the polynomial coefficients of a constant stiffness or damping."""
    return [coefficient, *[0.0] * mujoco.mjNPOLY]


def _compile_copy(spec: Any) -> Any:
    """Compile a copy of a robot's editable model (``MjSpec``); raise UsageError if MuJoCo refuses it."""
    try:
        return spec.copy().compile()
    except ValueError as problem:
        raise UsageError(
            f"MuJoCo cannot compile the robot's model, to which the reducer is to be attached: {problem}. Correct the "
            "model first"
        ) from problem


def _add_crank_body(joint: Any, model: Any, reduced: ReducedJoint) -> None:
    """Add a body for the crank to the parent of the hinge's link, with a joint on the same axis.

    `joint` is the hinge in the ``MjSpec``, which is changed in place; `model` is the compiled ``MjModel`` without the
    reducer. `reduced` has the inertia and the friction of the crank.
    """
    hinge, name = model.joint(joint.name), rotor_name(joint.name)
    body = _add_light_body(joint, model, name)
    rotor_joint = body.add_joint(
        name=name,
        type=mujoco.mjtJoint.mjJNT_HINGE,
        pos=hinge.pos,
        axis=hinge.axis,
        armature=reduced.rotor_inertia,
        frictionloss=reduced.no_load_torque,
        solref_friction=[MJCF.sticking_time, 1.0],
        solimp_friction=MJCF.sticking_impedance,
        limited=mujoco.mjtLimited.mjLIMITED_FALSE,
    )
    rotor_joint.damping = rotor_joint.stiffness = constant_polynomial(0.0)
    body.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=[*MJCF.rotor_size, 0.0],
        contype=0,
        conaffinity=0,
        mass=MJCF.mass,
        rgba=[0.93, 0.65, 0.49, 1.0],
    )


def _add_light_body(joint: Any, model: Any, name: str) -> Any:
    """Add a body of negligible mass next to the link of the hinge `joint`, in the link's frame, and return it.

    The ``MjSpec`` of `joint` is changed in place. `model` is the compiled ``MjModel`` without the reducer, and `name`
    is the name of the body.
    """
    link = model.body(int(model.joint(joint.name).bodyid[0]))
    body = joint.parent.parent.add_body(name=name, pos=link.pos, quat=link.quat)
    body.explicitinertial = True
    body.mass, body.inertia = MJCF.mass, [1e-12] * 3
    body.ipos = [0.0] * 3  # else MjSpec.to_xml leaves the inertia out
    return body


def _add_spring_tendon(spec: Any, reduced: ReducedJoint, joint: str, index: int) -> str:
    """Add a spring between crank and hinge as a fixed tendon with a dead band, and return the tendon's name.

    `spec`, an ``MjSpec``, is changed in place. `reduced` has the springs, `joint` is the name of the hinge, and `index`
    is the index of the spring.
    """
    spring, name = reduced.springs[index], reducer_name(joint, index)
    tendon = spec.add_tendon(name=name, limited=mujoco.mjtLimited.mjLIMITED_FALSE)
    tendon.wrap_joint(rotor_name(joint), reduced.coefficient)
    tendon.wrap_joint(joint, 1.0)
    tendon.springlength = [reduced.stops[0] - spring.start, reduced.stops[1] + spring.start]
    tendon.stiffness, tendon.damping = (
        constant_polynomial(spring.stiffness),
        constant_polynomial(0.0 if index else reduced.damping),
    )
    tendon.frictionloss = tendon.armature = 0.0
    return name


def _add_slip_element(spec: Any, joint: Any, model: Any, reduced: ReducedJoint, index: int) -> None:
    """Add a slip element (Jenkin element) to a hinge: a spring in series with a constant friction torque.

    The friction acts on a body of negligible mass. The spring couples its angle to the wind-up between crank and hinge.
    `spec`, an ``MjSpec``, is changed in place, and `joint` is the hinge in it. `model` is the compiled ``MjModel``
    without the reducer, for the position of the hinge. `reduced` is the joint model with the parameters of all slip
    elements, and `index` that of this element.
    """
    slip, name = reduced.slips[index], slip_name(joint.name, index)
    armature, damping = slip_inertias(reduced)[index]
    body = _add_light_body(joint, model, name)
    slip_joint = body.add_joint(
        name=name,
        type=mujoco.mjtJoint.mjJNT_HINGE,
        axis=model.joint(joint.name).axis,
        armature=armature,
        frictionloss=slip.limit,
        solref_friction=[MJCF.sticking_time, 1.0],
        solimp_friction=MJCF.sticking_impedance,
        limited=mujoco.mjtLimited.mjLIMITED_FALSE,
    )
    slip_joint.damping = slip_joint.stiffness = constant_polynomial(0.0)
    tendon = spec.add_tendon(name=name, limited=mujoco.mjtLimited.mjLIMITED_FALSE)
    for joint_name, coefficient in ((rotor_name(joint.name), reduced.coefficient), (joint.name, 1.0), (name, -1.0)):
        tendon.wrap_joint(joint_name, coefficient)
    tendon.springlength = [0.0, 0.0]
    tendon.stiffness, tendon.damping = constant_polynomial(slip.stiffness), constant_polynomial(damping)
    tendon.frictionloss = tendon.armature = 0.0


def _add_tuple(spec: Any, reduced: ReducedJoint, joint: str, tendons: list[str]) -> None:
    """Add the tuple of the reducer's joints and tendons, with its fingerprint, for `ReducedJoint.places`."""
    joints = [joint, rotor_name(joint)] if tendons else [joint]
    kinds = [int(mujoco.mjtObj.mjOBJ_JOINT)] * len(joints) + [int(mujoco.mjtObj.mjOBJ_TENDON)] * len(tendons)
    numbers = [float(reduced.fingerprint)] + [0.0] * (len(kinds) - 1)
    spec.add_tuple(name=reducer_name(joint), objname=[*joints, *tendons], objtype=kinds, objprm=numbers)


def _move_actuators_to_crank(spec: Any, reduced: ReducedJoint, joint: str) -> None:
    """Move the actuators of a hinge to its crank, and change their gear so that the torque on the hinge is the same.

    The gear is multiplied by the speed of the hinge divided by that of the crank, which is ``-reduced.coefficient``.
    `spec`, an ``MjSpec``, is changed in place; `joint` is the name of the hinge.
    """
    joint_transmissions = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)
    for actuator in spec.actuators:
        if actuator.trntype in joint_transmissions and actuator.target == joint:
            gear = np.array(actuator.gear)
            gear[0] *= -reduced.coefficient
            actuator.trntype, actuator.target, actuator.gear = mujoco.mjtTrn.mjTRN_JOINT, rotor_name(joint), gear


def _write_keyframes(
    spec: Any, keyframes: list[tuple[list[float], list[float]]], model: Any, reduced: ReducedJoint, joint: str
) -> None:
    """Insert position and speed of the crank into all keyframes.

    The crank's angle is that in the middle of the play, and its speed is the ideal speed for that of the hinge.

    Parameters
    ----------
    spec
        Editable model with the crank, changed in place.
    keyframes
        Positions and speeds of each keyframe before the crank was added; an empty list stands for the default values.
    model
        Compiled ``MjModel`` without the reducer.
    reduced, joint
        The reducer's joint, and the name of the hinge.
    """
    attached_model = _compile_copy(spec)
    crank_joint, output_joint = attached_model.joint(rotor_name(joint)), model.joint(joint)
    qpos_address, dof_address = int(crank_joint.qposadr[0]), int(crank_joint.dofadr[0])
    for keyframe, (positions, speeds) in zip(spec.keys, keyframes, strict=True):
        positions, speeds = positions or model.qpos0.tolist(), speeds or [0.0] * model.nv
        angle = (reduced.middle - positions[int(output_joint.qposadr[0])]) / reduced.coefficient
        speed = -speeds[int(output_joint.dofadr[0])] / reduced.coefficient
        keyframe.qpos = [*positions[:qpos_address], angle, *positions[qpos_address:]]
        keyframe.qvel = [*speeds[:dof_address], speed, *speeds[dof_address:]]
