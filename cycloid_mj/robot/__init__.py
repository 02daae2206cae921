"""A reducer as one joint of a robot: measured on the full model, written in stock MJCF, put on a joint of any model."""

from cycloid_mj.robot.attach import attach_reducer
from cycloid_mj.robot.identification import reduce
from cycloid_mj.robot.reducer import LEVELS, Level, ReducedJoint

__all__ = ["LEVELS", "Level", "ReducedJoint", "attach_reducer", "reduce"]
