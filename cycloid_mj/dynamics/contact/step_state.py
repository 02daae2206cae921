"""State of a run for its compiled steps: one record of addresses, numbers and counters."""

from typing import Any

import numpy as np
from numba import carray, from_dtype, njit

from cycloid_mj.dynamics.contact.memory import make_pointer_cast

StepState = Any
"""A record of `STEP_STATE` in compiled code."""

POINTERS = ("contact", "ncon", "efc_force", "efc_vel", "efc_pos", "efc_R", "efc_D", "efc_KBIP")
"""Addresses of pointers, and of the number of contacts, in ``mjData``."""

FIELDS = ("stride", "pos", "frame", "dim", "geom", "efc_address", "friction", "mu")
"""Size of an ``mjContact`` [bytes], and offsets of fields in it; its distance comes first."""

ARRAYS = ("xpos", "geom_xpos", "geom_xmat", "qpos", "qvel", "qacc", "ctrl", "solver_niter")
"""Addresses of arrays of ``mjData``."""

INDEX = ("surface", "pair", "origin", "reach", "teeth")
"""Addresses of the arrays of a ``PairIndex``."""

_OWN = ("warning_number", "saved_qvel", "timestep", "half_timestep", "orbits", "circling", "impact", "sources", "drags")
_FILM = ("film", "film_kind", "film_pin", "pin_force", "pin_cosine", "pins", "second_plane")
_SIZES = ("nv", "nu", "nuser_geom", "surfaces", "pairs", "source_count", "drag_count", "discs", "islands")
_WARNINGS = ("warning_kinds", "warning_stride")
_STEPS = ("sum", "peak", "command", "last", "left", "due", "every", "rows", "width")

STEP_STATE = np.dtype(
    [(name, np.int64) for name in POINTERS + FIELDS + ARRAYS + INDEX + _OWN + _FILM + _SIZES + _WARNINGS + _STEPS]
)
"""State of a run: `POINTERS`, `FIELDS`, `ARRAYS`, `INDEX`, and

saved_qvel, timestep, half_timestep
    Addresses of memory for the joint speeds, of the time step and of half of it [s].
orbits, circling
    Addresses of the index of each disc's degree of freedom along x, and of memory for the accelerations of all joints
    when the discs circle.
impact
    Address of the parameters k, e, c and D of each pair, see ``impact``; 0 where contacts follow the model's law.
film, film_kind, film_pin
    Addresses of the `film_table`, and of row and ring pin of each pair; 0 with the friction law ``coulomb``.
pin_force, pin_cosine, pins
    Addresses of the force of a disc on each ring pin and the cosine of its phase there, and the number of pins.
second_plane
    Index of the first pin in the plane of the second disc if pins tilt, else 0.
sources, drags
    Addresses of the addresses of sampled values, and of the constraint rows of drags.
nv, nu, nuser_geom, surfaces, pairs, source_count, drag_count, discs, islands, warning_kinds
    Numbers of degrees of freedom, commands, values in each ``geom user``, surfaces, mating pairs, sources, drags,
    discs, solver statistics, and kinds of warnings.
warning_number, warning_stride
    Address of the number of the first warning, and bytes to the next.
sum, peak
    Addresses of the forces of the pairs while they are added up, and of the largest since the last sample.
command, last
    Addresses of the commands of the next step, and of the end of all commands.
left, due, every
    Steps that the callback has to take itself; the next step that is sampled, counted from 1; steps between samples.
rows, width
    Address of the next sample's row, and bytes of a row.
"""

_to_state = make_pointer_cast(from_dtype(STEP_STATE))


@njit(inline="always")
def step_state_at(address: int) -> StepState:
    """Return the record at an address."""
    return carray(_to_state(address), 1)[0]
