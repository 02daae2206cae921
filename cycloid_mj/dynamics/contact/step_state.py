"""State of a run for its compiled steps: one record of addresses, numbers and counters."""

from typing import Any

import numpy as np
from numba import carray, from_dtype, njit

from cycloid_mj.dynamics.contact.memory import pointer_to

StepState = Any
"""A record of `STEP_STATE` in compiled code."""

_STEP = ("contacts", "count", "forces", "speeds", "xpos", "geom_xpos", "geom_xmat")
_MOTION = ("accelerations", "moving", "before", "half", "freedoms")
_CIRCLING = ("positions", "orbits", "discs", "circling")
_IMPACT = ("impact", "step", "places", "weights", "inverse", "constants")
_CONTACT = ("stride", "pos", "frame", "dim", "geom", "row")
_PAIRS = ("surface", "pair", "surfaces", "mating", "origin", "reach", "teeth", "numbers", "sum", "peak")
_COMMANDS = ("ctrl", "actuators", "command", "last")
_SOLVER = ("iterations", "islands", "warnings", "kinds", "apart")
_SAMPLES = ("sources", "copied", "drags", "braked", "left", "due", "every", "rows", "width")

STEP_STATE = np.dtype(
    [
        (name, np.int64)
        for name in _STEP + _MOTION + _CIRCLING + _IMPACT + _CONTACT + _PAIRS + _COMMANDS + _SOLVER + _SAMPLES
    ]
)
"""Addresses of arrays of these names in ``MjData``, in the ``PairIndex`` and in the run's own; and:

contacts, forces, speeds
    Addresses of the pointers to the contacts, and to forces and speeds of the rows of constraints.
count
    Address of the number of contacts.
moving, before, half
    Addresses of the joints' speeds, of room to keep them, and of half a step [s].
positions, orbits, discs, circling
    Addresses of the joints' positions and of the index of each disc's degree of freedom along x; how many discs there
    are; and the address of room for the accelerations of all joints when the discs circle.
freedoms, surfaces, mating, actuators, islands, kinds, copied, braked
    How many accelerations, surfaces, mating pairs, commands, iterations, warnings, sources and drags there are.
impact, step
    Addresses of k, e, c and D of each pair, see ``impact``, 0 where contacts follow the model's law; and of the time
    step [s].
places, weights, inverse, constants
    Addresses of the pointers to place, R, 1/R and (stiffness, damping, impedance and its slope) of each row.
stride, pos, frame, dim, geom, row
    Bytes of an ``mjContact``, and where in it these stand; its distance comes first.
numbers
    How many numbers each ``geom user`` has.
sum, peak
    Addresses of the forces of the pairs while they are added up, and of the largest since the sample before.
command, last
    Addresses of the commands of the next step, and of the end of all commands.
apart
    Bytes from one warning's number to the next.
left, due, every
    Steps that the callback is to take itself; the next step that is sampled, counted from 1; steps between samples.
rows, width
    Address of the next sample's row, and bytes of a row.
"""


_to_state = pointer_to(from_dtype(STEP_STATE))


@njit(inline="always")
def step_state_at(address: int) -> StepState:
    """Return the record at an address."""
    return carray(_to_state(address), 1)[0]
