"""A reducer as a joint of a robot: identified from the full model, written as MJCF, attached to any model."""

from cycloid_mj.robot.attach import attach_reducer
from cycloid_mj.robot.identification import reduce
from cycloid_mj.robot.reducer import LEVELS, Level, ReducedJoint

__all__ = ["LEVELS", "Level", "ReducedJoint", "attach_reducer", "reduce"]
