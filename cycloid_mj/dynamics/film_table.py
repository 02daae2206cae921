"""Friction coefficients of the law ``film`` over phase and normal force, for the solvers of motion.

The law is evaluated once for a drive at its speed; each contact then looks up its coefficient in every step, from the
phase of its pin against the eccentricity and its current normal force. Speeds other than the design's, as in a ramp,
have the same coefficients.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cycloid_mj.base import compiling
from cycloid_mj.base.array import Array
from cycloid_mj.base.names import CRANK_BEARING, PLANET_MESH
from cycloid_mj.dynamics.contact.memory import read_float
from cycloid_mj.geometry.envelope import arc_contacts
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.reducer.bodies import Pair
from cycloid_mj.statics.film import build_film_surfaces
from cycloid_mj.statics.rv_film import bearing_friction, planet_friction

TEETH, SEAT, CAM, OUTPUT = range(4)
"""Kinds of mating pairs by their function: rows of the table.

In an RV reducer, `CAM` are the bearings of the cranks and `OUTPUT` the meshes of the planets.
"""


@dataclass(frozen=True)
class TableSettings:
    """Size of the table: between its rows, coefficients are linear in the phase and in the logarithm of the force.

    Attributes
    ----------
    phases
        Phases from 0 to pi: half a degree resolves the peak of friction where the entrainment vanishes.
    forces
        Forces from `least` to `most` [N], at equal ratios.
    """

    phases: int = 361
    forces: int = 181
    least: float = 1e-3
    most: float = 1e6


TABLE = TableSettings()


@dataclass(frozen=True, eq=False)
class FilmRows:
    """Table of a drive, and the row and the ring pin of each mating pair, shape (pairs,).

    Attributes
    ----------
    table
        The `film_table`.
    kind, pin
        Row of each pair, and index of its ring pin or lobe; 0 where it has none. Teeth of a second disc that tilts
        the pins have the indices after those of the first disc.
    pins
        Number of ring pins or lobes, for each plane in which tilting pins are displaced.
    second_plane
        Number of pins before those in the second plane; 0 without tilting pins.
    """

    table: Array
    kind: npt.NDArray[np.int32]
    pin: npt.NDArray[np.int32]
    pins: int
    second_plane: int


def film_rows(reducer: Reducer, pairs: Sequence[Pair]) -> FilmRows | None:
    """Return the friction table of lubricated contacts, and for each mating pair its row there and its ring pin.

    The table is `film_table` with friction coefficients [1]. The pins are counted from 0; the index is 0 for pairs
    without a ring pin or lobe, too. The result is None with the law ``coulomb`` of constant coefficients.
    """
    design = reducer.design
    if not design.has_film:
        return None
    row_of_kind = {
        "cam": CAM,
        "output": OUTPUT,
        CRANK_BEARING: CAM,
        PLANET_MESH: OUTPUT,
        design.tooth_pair: TEETH,
        design.seat_pair: SEAT,
    }
    ring_kinds = (design.tooth_pair, design.seat_pair)
    second_plane = design.ring.mate_count if design.has_tilting_pins else 0
    pin_by_pair = [pair.owner + second_plane * pair.disc if pair.kind in ring_kinds else 0 for pair in pairs]
    return FilmRows(
        film_table(reducer),
        np.array([row_of_kind[pair.kind] for pair in pairs], dtype=np.int32),
        np.array(pin_by_pair, dtype=np.int32),
        max(pin_by_pair) + 1,
        second_plane,
    )


_LEAST = TABLE.least
_PHASES, _FORCES, _FIRST = TABLE.phases, TABLE.forces, math.log(TABLE.least)
_PHASE_STEP = math.pi / (_PHASES - 1)
_FORCE_STEP = (math.log(TABLE.most) - _FIRST) / (_FORCES - 1)
"""Steps of the table in the phase [rad] and in the logarithm of the force."""

NO_TABLE: Array = np.zeros((0, _PHASES, _FORCES))
"""Table of a drive with the law ``coulomb``."""


def film_table(reducer: Reducer) -> Array:
    """Compute the friction coefficients [1] of lubricated contacts (law ``film``), shape (4, phases, forces).

    The rows are the kinds of pairs: teeth, seats of ring pins, cams and output pins. `TABLE` has the numbers of phases
    of the pins, from 0 to pi, and of normal forces [N] on the other axes. With massless pins, the row of the teeth has
    the smaller of the coefficients of flank and seat. With the law ``coulomb``, the result is the empty `NO_TABLE`.
    """
    if not reducer.design.has_film:
        return NO_TABLE
    phases: Array = np.linspace(0.0, np.pi, _PHASES)
    # at the crank angle B the first pin, on +y, has the phase B
    curvature = arc_contacts(reducer.tooth_profile, phases[:, np.newaxis]).relative_curvature[:, 0]
    film = build_film_surfaces(reducer, phases, curvature)
    forces = np.exp(_FIRST + _FORCE_STEP * np.arange(_FORCES))
    tooth_forces = forces[:, np.newaxis]
    is_massless = not reducer.design.ring.has_pin_bodies
    tooth_coefficients = (
        film.smaller_friction(tooth_forces)[0] if is_massless else film.flank_friction(tooth_forces)
    ).coefficient
    seat_friction = film.seat_friction(tooth_forces)
    coefficients = np.zeros((4, _PHASES, _FORCES))
    coefficients[TEETH] = np.broadcast_to(tooth_coefficients, (_FORCES, _PHASES)).T
    if seat_friction is not None:
        coefficients[SEAT] = seat_friction.coefficient.T / film.seat_scale
    if isinstance(reducer, RvReducer):
        coefficients[CAM] = sum(bearing_friction(reducer)) / reducer.cranks.eccentric_radius
        coefficients[OUTPUT] = planet_friction(reducer, forces)
        return coefficients
    coefficients[CAM] = film.cam_friction(forces)
    output_friction = film.output_friction(forces)
    coefficients[OUTPUT] = (
        reducer.design.friction_of("output") if output_friction is None else output_friction.coefficient
    )
    return coefficients


@compiling.njit(inner=True)
def phase_cosine(px: float, py: float, x: float, y: float) -> float:
    """Compute the cosine of the phase of a pin at (px, py) against the eccentricity of a disc centred on (x, y)."""
    norms = math.sqrt((px * px + py * py) * (x * x + y * y))
    return (px * x + py * y) / norms if norms > 0.0 else 1.0


@compiling.njit(inner=True)
def look_up(table: int, kind: int, cosine: float, force: float) -> float:
    """Interpolate the friction coefficient [1] of a lubricated contact in a table, bilinearly in phase and log force.

    `table` is the memory address of the table (`film_table`), and `kind` the row of the contact. `cosine` is that of
    the phase of the contact's pin: the angle between the directions of the pin and of the disc's centre. `force` is the
    normal force [N]; outside of the table, the coefficient is that of the nearest force in it.
    """
    phase_index = math.acos(min(max(cosine, -1.0), 1.0)) / _PHASE_STEP
    force_index = (math.log(max(force, _LEAST)) - _FIRST) / _FORCE_STEP
    phase_row, force_column = min(int(phase_index), _PHASES - 2), min(int(force_index), _FORCES - 2)
    phase_share, force_share = phase_index - phase_row, min(force_index - force_column, 1.0)
    lower_entry = table + 8 * ((kind * _PHASES + phase_row) * _FORCES + force_column)
    upper_entry = lower_entry + 8 * _FORCES
    lower_coefficient = (1.0 - force_share) * read_float(lower_entry) + force_share * read_float(lower_entry + 8)
    upper_coefficient = (1.0 - force_share) * read_float(upper_entry) + force_share * read_float(upper_entry + 8)
    return (1.0 - phase_share) * lower_coefficient + phase_share * upper_coefficient
