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
    for sensor in _list_sensors(reducer):
        groups.setdefault(sensor.topic, {})[sensor.column] = sensor.unit
    return groups


def add_sensors(spec: Any, reducer: Reducer) -> None:
    """Add the sensors to the editable model `spec` (``MjSpec``)."""
    for sensor in _list_sensors(reducer):
        sensor_type, object_type = _KINDS[sensor.reads]
        spec.add_sensor(name=sensor.column, type=sensor_type, objtype=object_type, objname=sensor.of)


def sensor_addresses(data: Any, reducer: Reducer) -> list[int]:
    """Return the memory addresses in ``MjData`` of all sensor values, in the order of `sensors`."""
    getters = {
        "position": lambda name: data.joint(name).qpos,
        "speed": lambda name: data.joint(name).qvel,
        "torque": lambda name: data.actuator(name).force,
    }
    return [getters[sensor.reads](sensor.of).ctypes.data for sensor in _list_sensors(reducer)]


def _list_sensors(reducer: Reducer) -> Iterator[_Sensor]:
    """Yield the sensors of all bodies that move in MuJoCo: positions and speeds of joints, torques of actuators.

    The driven shaft, if it is a floating sun, also has sensors along x and y. A crank of an RV reducer only rotates;
    its angle is relative to the carrier.
    """
    for body in reducer.mechanism.bodies:
        if reducer.INPUT_JOINT in body.joints:
            yield from _shaft_sensors(reducer.INPUT, reducer.INPUT_JOINT, f"{reducer.INPUT}_torque", names.DRIVE)
            yield from _planar_sensors(body, slice(0, len(body.joints) - 1))
        elif names.OUTPUT_JOINT in body.joints:
            yield from _shaft_sensors("output", names.OUTPUT_JOINT, "load_torque", names.LOAD)
        elif body.part == names.CRANK:
            yield from _planar_sensors(body, slice(2, 3))
        elif body.joints:
            yield from _planar_sensors(body)


def _shaft_sensors(stem: str, joint: str, torque: str, actuator: str) -> Iterator[_Sensor]:
    yield _Sensor(REDUCER, f"{stem}_angle", "rad", "position", joint)
    yield _Sensor(REDUCER, f"{stem}_speed", "rad/s", "speed", joint)
    yield _Sensor(REDUCER, torque, "N m", "torque", actuator)


def _planar_sensors(body: Body, selected: slice = slice(0, 3)) -> Iterator[_Sensor]:
    """Yield the sensors of a `body` in the plane for `selected` components of (x, y, rotation), named after the body.

    Positions come first, then speeds; pins have only the speed of their rotation.
    """
    topic, first_speed = (PINS, 2) if body.part == names.PIN else (REDUCER, 0)
    units, speed_units = ("m", "m", "rad")[selected], ("m/s", "m/s", "rad/s")[selected]
    joints = names.planar_joints(body.name)[selected]
    for joint, unit in zip(joints, units, strict=True):
        yield _Sensor(topic, joint, unit, "position", joint)
    speed_columns = zip(joints, names.planar_speeds(body.name)[selected], speed_units, strict=True)
    for joint, column, unit in list(speed_columns)[first_speed:]:
        yield _Sensor(topic, column, unit, "speed", joint)
