"""Transmission error of a run: angles of output and disc minus their ideal values at the measured crank angle."""

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.base.record import Run
from cycloid_mj.reducer import Reducer


def output_error(run: Run, reducer: Reducer) -> Array:
    """Compute the transmission error of the output [rad], shape (n,), counter-clockwise.

    It is phi - theta/i of the output's angle phi, at the crank's own angle theta and the ratio i, -(N-1) or N.
    """
    return run["output_angle"] - reducer.member.output_angle(run[f"{run.driven_shaft}_angle"])


def gear_error(run: Run, reducer: Reducer) -> Array:
    """Compute the transmission error of the disc [rad], shape (n,), counter-clockwise; the mean of several discs.

    It is phi + theta/(N-1) of the disc's angle phi, or phi if the ring is the output, as the disc does not rotate.
    """
    turned = [run[names.planar_joints(gear)[2]] for gear in reducer.gears]
    return np.mean(turned, axis=0) - reducer.member.gear_angle(run[f"{run.driven_shaft}_angle"])
