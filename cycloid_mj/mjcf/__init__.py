"""The MuJoCo model of a design: its parts and its contact physics."""

from cycloid_mj.mjcf.model import ReducerModel, build, xml
from cycloid_mj.names import Pair, pairs, sensors

__all__ = ["Pair", "ReducerModel", "build", "pairs", "sensors", "xml"]
