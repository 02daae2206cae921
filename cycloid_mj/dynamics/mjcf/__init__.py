"""The MuJoCo model of a design: its parts, its sensors and its contact physics."""

from cycloid_mj.dynamics.mjcf.model import Held, ReducerModel, build, xml
from cycloid_mj.dynamics.mjcf.sensors import sensor_addresses, sensors

__all__ = ["Held", "ReducerModel", "build", "sensor_addresses", "sensors", "xml"]
