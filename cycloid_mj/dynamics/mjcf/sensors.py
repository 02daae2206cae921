"""Sensors of a model, named as the columns of the log."""

from collections.abc import Iterator
from typing import Any, Literal, NamedTuple

import mujoco

from cycloid_mj.base import names
from cycloid_mj.base.names import PINS, REDUCER
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bodies import Body

_KINDS = {
    "position": (mujoco.mjtSensor.mjSENS_JOINTPOS, mujoco.mjtObj.mjOBJ_JOINT),
    "speed": (mujoco.mjtSensor.mjSENS_JOINTVEL, mujoco.mjtObj.mjOBJ_JOINT),
    "torque": (mujoco.mjtSensor.mjSENS_ACTUATORFRC, mujoco.mjtObj.mjOBJ_ACTUATOR),
}


class _Sensor(NamedTuple):
    """A sensor: topic, column and unit, and the quantity of a joint or an actuator that it reads."""

    topic: str
    column: str
    unit: str
    reads: Literal["position", "speed", "torque"]
    of: str


def sensors(reducer: Reducer) -> dict[str, dict[str, str]]:
    """Return column names and units by topic, in the order of the model."""
    groups: dict[str, dict[str, str]] = {}
    for sensor in _sensors(reducer):
        groups.setdefault(sensor.topic, {})[sensor.column] = sensor.unit
    return groups


def add_sensors(spec: Any, reducer: Reducer) -> None:
    """Add the sensors to an editable model."""
    for sensor in _sensors(reducer):
        kind, what = _KINDS[sensor.reads]
        spec.add_sensor(name=sensor.column, type=kind, objtype=what, objname=sensor.of)


def sensor_addresses(data: Any, reducer: Reducer) -> list[int]:
    """Return the addresses in ``MjData`` of the values that the sensors read, in the order of the log's columns."""
    getters = {
        "position": lambda of: data.joint(of).qpos,
        "speed": lambda of: data.joint(of).qvel,
        "torque": lambda of: data.actuator(of).force,
    }
    return [getters[sensor.reads](sensor.of).ctypes.data for sensor in _sensors(reducer)]


def _sensors(reducer: Reducer) -> Iterator[_Sensor]:
    """Yield the sensors of all bodies that move: positions and speeds of joints, torques of actuators."""
    for body in reducer.mechanism.bodies:
        if body.part == names.SHAFT:
            yield from _shaft_sensors("crank", names.CRANK_JOINT, "crank_torque", names.DRIVE)
        elif names.OUTPUT_JOINT in body.joints:
            yield from _shaft_sensors("output", names.OUTPUT_JOINT, "load_torque", names.LOAD)
        elif body.joints:
            yield from _planar_sensors(body)


def _shaft_sensors(stem: str, joint: str, torque: str, actuator: str) -> Iterator[_Sensor]:
    yield _Sensor(REDUCER, f"{stem}_angle", "rad", "position", joint)
    yield _Sensor(REDUCER, f"{stem}_speed", "rad/s", "speed", joint)
    yield _Sensor(REDUCER, torque, "N m", "torque", actuator)


def _planar_sensors(body: Body) -> Iterator[_Sensor]:
    """Yield the sensors of a disc, or those of a pin, which has no speed columns but its spin."""
    topic, first = (PINS, 2) if body.part == names.PIN else (REDUCER, 0)
    for joint, unit in zip(body.joints, ("m", "m", "rad"), strict=True):
        yield _Sensor(topic, joint, unit, "position", joint)
    speeds = zip(body.joints, names.planar_speeds(body.name), ("m/s", "m/s", "rad/s"), strict=True)
    for joint, column, unit in list(speeds)[first:]:
        yield _Sensor(topic, column, unit, "speed", joint)
