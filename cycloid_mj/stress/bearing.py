"""Bearings that press and do not pull: radial springs under pads of a journal, of which open ones bear nothing."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from cycloid_mj.errors import CycloidError
from cycloid_mj.stress.grid import Grid
from cycloid_mj.stress.shaftgrid import Shaft
from cycloid_mj.stress.surface import surface, traction_loads
from cycloid_mj.types import Array, Mask

Flags = Mask

SECTORS, STRIPS = 16, 4
"""Pads of a bearing round the journal and along it."""

CHORD = 0.05
"""Share of the radius by which the middle of a face's corners may lie below its cylinder."""

ROUNDS = 60
"""Rounds of the active set; it takes about five."""


@dataclass(frozen=True)
class Pads:
    """The pads of all bearings, p of them.

    Attributes
    ----------
    press
        Sparse (n, p): what a push of 1 N outwards, even over a pad, puts on the unknowns; transposed, it gives the mean
        displacement of each pad along its normal.
    stiffness
        Of the spring under each pad (p,) [N/m].
    """

    press: Any
    stiffness: Array

    @property
    def springs(self) -> Any:
        """Sparse (n, n) [N/m] of all springs, as if they pulled as well."""
        return (self.press @ sparse.diags(self.stiffness) @ self.press.T).tocsr()


def bearing_pads(grid: Grid, shaft: Shaft, stiffness: float) -> Pads:
    """Give the pads under a shaft, whose bearings have a radial stiffness [N/m] each.

    Half of a bearing presses: a bed of k per area takes k R w pi/2 as its force per radial displacement.

    Raises
    ------
    CycloidError
        The grid has no face in a bearing: it is too coarse.
    """
    press, springs = [], []
    for z0, z1 in shaft.bearings:
        face = surface(grid, lambda x, z0=z0, z1=z1: on_cylinder(x, shaft.radius, 0.0) & (z0 < x[2]) & (x[2] < z1))  # type: ignore[misc]
        if not len(face.nodes):
            raise CycloidError("the shaft's grid has no face in one of its bearings: raise the refinement")
        bed = stiffness / (np.pi / 2 * shaft.radius * (z1 - z0))
        x, y, z = face.points[..., 0], face.points[..., 1], face.points[..., 2]
        sector = np.floor(np.arctan2(y, x) / (2 * np.pi) * SECTORS).astype(int) % SECTORS
        strip = np.clip(((z - z0) / (z1 - z0) * STRIPS).astype(int), 0, STRIPS - 1)
        outwards = face.points * np.array([1.0, 1.0, 0.0]) / np.hypot(x, y)[..., np.newaxis]  # no moment about the axis
        for pad in range(SECTORS * STRIPS):
            chosen = sector * STRIPS + strip == pad
            area = float(face.area[chosen].sum())
            if area > 0.0:
                push = traction_loads(face, outwards * chosen[..., np.newaxis] / area)
                press.append(sparse.csc_matrix(push[:, np.newaxis]))
                springs.append(bed * area)
    return Pads(sparse.hstack(press).tocsc(), np.array(springs))


def opened(pads: Pads, compliance: Array, pressed: Array) -> Array:
    """Give the forces (p,) [N] outwards on the pads that take back what springs that pull would do.

    An open pad, whose mean displacement d is inwards, is pulled out by its spring with -k d: the force k d undoes it.
    d depends on the forces on all open pads, so their set is corrected until it is that of the pads with d < 0.

    Parameters
    ----------
    pads
        The pads.
    compliance
        Displacement [m] of each pad under 1 N on each (p, p), with all springs.
    pressed
        Displacement of the pads [m] (p,) under the loads, with all springs.

    Raises
    ------
    CycloidError
        No set of open pads is right: the bearings do not hold the shaft.
    """
    freed, displaced = np.zeros_like(pressed), pressed
    is_open: Flags = np.zeros(len(pressed), bool)
    for _ in range(ROUNDS):
        now = displaced < 0.0
        if np.array_equal(now, is_open):
            return freed
        is_open = now
        at = np.flatnonzero(is_open)
        freed = np.zeros_like(pressed)
        freed[at] = np.linalg.solve(np.diag(1.0 / pads.stiffness[at]) - compliance[np.ix_(at, at)], pressed[at])
        displaced = pressed + compliance[:, at] @ freed[at]
    raise CycloidError(
        "the bearings do not hold the shaft: no pattern of pressed places is in balance; check the shaft"
    )


def on_cylinder(x: Array, radius: float, height: float) -> Flags:
    """Tell middles (3, f) [m] of faces on a cylinder, whose chords reach below it, from those on its end faces."""
    return np.abs(np.hypot(x[0], x[1] - height) - radius) < CHORD * radius
