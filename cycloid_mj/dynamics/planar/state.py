"""Initial positions and speeds of all unknowns, from the closed-form kinematics."""

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.dynamics.mjcf.keyframe import joint_state
from cycloid_mj.reducer import Reducer


def start(reducer: Reducer, crank: float, speed: float) -> tuple[Array, Array]:
    """Compute positions and speeds at a crank angle [rad] and crank speed [rad/s], in the order of a ``System``."""
    position, velocity = joint_state(reducer, crank, speed)
    order = [
        *(joint for disc in reducer.mechanism.discs for joint in disc.joints),
        names.OUTPUT_JOINT,
        names.CRANK_JOINT,
    ]
    places, speeds = ([joints.get(joint, 0.0) for joint in order] for joints in (position, velocity))
    turn, rate = (
        float(reducer.member.ring_and_carrier(joints[names.OUTPUT_JOINT])[0]) for joints in (position, velocity)
    )
    s, c = np.sin(turn), np.cos(turn)
    for pin in reducer.mechanism.pins:
        x, y = pin.place + [position.get(joint, 0.0) for joint in pin.joints[:2]]
        x, y = c * x - s * y, s * x + c * y
        places += [x, y, turn + position.get(pin.joints[2], 0.0)]
        speeds += [-rate * y, rate * x, rate]
    return np.array(places), np.array(speeds)
