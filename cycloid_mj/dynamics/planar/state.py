"""Initial positions and speeds of all unknowns, from the closed-form kinematics."""

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.dynamics.mjcf.keyframe import joint_state
from cycloid_mj.parts import pin_mass_matrix
from cycloid_mj.reducer import Reducer, RvReducer


def start_state(reducer: Reducer, crank: float, speed: float) -> tuple[Array, Array]:
    """Compute positions and speeds of all unknowns at a crank angle [rad] and speed [rad/s], by closed-form kinematics.

    In an RV reducer, angle and speed are those of the sun. Parts with errors have the pose with the largest minimum
    gap.

    Returns
    -------
    tuple of Array
        Positions [m], [rad] and speeds [m/s], [rad/s] in the order of the unknowns of a ``System``, shape (unknowns,).
    """
    position_by_joint, velocity_by_joint = joint_state(reducer, crank, speed)
    disc_joints = [joint for disc in reducer.mechanism.discs for joint in disc.joints]
    if isinstance(reducer, RvReducer):
        joint_names, crank_count = (
            [*disc_joints, *names.planar_joints(names.SUN), names.OUTPUT_JOINT],
            reducer.cranks.count,
        )
    else:
        joint_names, crank_count = [*disc_joints, names.OUTPUT_JOINT, names.CRANK_JOINT], 0
    positions, speeds = (
        [
            *(joints.get(joint, 0.0) for joint in joint_names),
            *[float(reducer.member.crank_angle(driven_value))] * crank_count,
        ]
        for joints, driven_value in ((position_by_joint, crank), (velocity_by_joint, speed))
    )
    ring_angle, ring_speed = (
        float(reducer.member.ring_and_carrier(joints[names.OUTPUT_JOINT])[0])
        for joints in (position_by_joint, velocity_by_joint)
    )
    sine, cosine = np.sin(ring_angle), np.cos(ring_angle)
    other_planes = len(pin_mass_matrix(reducer)) - 1 if reducer.mechanism.pins else 0
    for pin in reducer.mechanism.pins:
        x, y = pin.position + [position_by_joint.get(joint, 0.0) for joint in pin.joints[:2]]
        x, y = cosine * x - sine * y, sine * x + cosine * y
        positions += [x, y, ring_angle + position_by_joint.get(pin.joints[2], 0.0), *[x, y] * other_planes]
        speeds += [-ring_speed * y, ring_speed * x, ring_speed, *[-ring_speed * y, ring_speed * x] * other_planes]
    return np.array(positions), np.array(speeds)
