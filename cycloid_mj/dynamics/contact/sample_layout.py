"""Layout of the samples that both steppers write, one row each: sampled values, solver statistics, pairs, drags."""

import numpy as np

PAIR_COLUMNS = ("force_x", "force_y", "moment", "peak_force", "friction_power", "normal_power")
"""Columns of a pair: force on its ``on`` body [N], moment about that body's origin [N m], largest normal force since
the last sample [N], and the powers of friction and normal force [W]. Friction power is never negative except for
rounding; that of the normal force is damping and stored elastic energy."""

OF_PAIR = len(PAIR_COLUMNS)
FORCE_X, FORCE_Y, MOMENT, PEAK_FORCE, FRICTION_POWER, NORMAL_POWER = range(OF_PAIR)

SOLVER_COLUMNS = ("active", "penetration", "largest_force", "iterations", "acceleration_sum", "warnings")
"""Columns on all contacts and the solver: contacts that carry a force, deepest geometric penetration [m], largest force
of one contact [N], largest number of solver iterations in an island; the sum of all accelerations (of the planar
solver, of all speeds), which is finite if each of them is; and the number of warnings that MuJoCo has issued, or, of
the planar solver, of the steps since the last sample whose contact geometry did not converge."""

OF_SOLVER = len(SOLVER_COLUMNS)
ACTIVE, PENETRATION, LARGEST_FORCE, ITERATIONS, ACCELERATION_SUM, WARNINGS = range(OF_SOLVER)


def sample_slices(copied: int, pairs: int, drags: int) -> tuple[slice, slice, slice, slice, int]:
    """Return the slices of a sample, an array row, for its four groups of values, and the total number of values.

    The groups are, in this order: values copied from MuJoCo, statistics of the solver, forces and powers of the mating
    pairs, and losses by drags (seals and lubricant). `copied` is the number of copied values, `pairs` and `drags` are
    the numbers of mating pairs and of drags.
    """
    edges = np.cumsum([0, copied, OF_SOLVER, OF_PAIR * pairs, drags]).tolist()
    values, solver, forces, losses = map(slice, edges[:-1], edges[1:])
    return values, solver, forces, losses, edges[-1]
