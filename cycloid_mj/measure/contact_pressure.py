"""Contacts under load: their forces over a run, and their Hertz pressures."""

import math
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.record import Run
from cycloid_mj.geometry import envelope
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.kernel import CARRYING_SHARE


@dataclass(frozen=True, eq=False)
class ContactPressures:
    """The contacts of one kind over the samples of a run."""

    kind: str
    """As in ``names.Pair``."""
    angle: Array
    """Crank angle [rad], shape (n,), increasing or decreasing; its first is within a turn of 0."""
    vector: Array
    """Forces on the gear (on the pin, in its socket) [N], shape (n, contacts, 2)."""
    pressure: Array
    """Hertz's peak pressure [Pa], shape (n, contacts), computed for conformal contacts as well."""
    holds: Mask
    """Whether Hertz's theory applies, shape (n, contacts): not to conformal contacts."""

    @property
    def force(self) -> Array:
        """Magnitudes of the forces [N], shape (n, contacts)."""
        return np.hypot(self.vector[..., 0], self.vector[..., 1])

    @property
    def peak_force(self) -> float:
        """The largest force [N]."""
        return float(self.force.max())

    @property
    def peak_angle(self) -> float:
        """Crank angle of the largest force [rad], within a turn."""
        row = int(np.argmax(self.force.max(axis=1)))
        return float(np.mod(self.angle[row], 2.0 * math.pi))

    @property
    def carries(self) -> Mask:
        """Mask of the loaded contacts, shape (n, contacts)."""
        return np.asarray(self.force > CARRYING_SHARE * self.peak_force)

    @property
    def mean_force(self) -> float:
        """Mean force of the loaded contacts [N]; 0 where there is none."""
        loaded_forces = self.force[self.carries]
        return float(loaded_forces.mean()) if loaded_forces.size else 0.0

    @property
    def carrying(self) -> float:
        """Mean number of loaded contacts [1]."""
        return float(self.carries.sum(axis=1).mean())

    @property
    def halves(self) -> tuple["ContactPressures", "ContactPressures"]:
        """The first and the second half of the samples."""
        middle = max(1, len(self.angle) // 2)
        return self._part(slice(0, middle)), self._part(slice(len(self.angle) - middle, None))

    def _part(self, rows: slice) -> "ContactPressures":
        return ContactPressures(self.kind, self.angle[rows], self.vector[rows], self.pressure[rows], self.holds[rows])

    @property
    def peak_pressure(self) -> float:
        """The largest Hertz pressure [Pa]; NaN where its contact is conformal."""
        peak_index = int(np.argmax(self.pressure))
        return float(self.pressure.flat[peak_index]) if self.holds.flat[peak_index] else math.nan


def contact_pressures(run: Run, reducer: Reducer) -> dict[str, ContactPressures]:
    """Compute forces [N] and Hertz pressures [Pa] of all contacts in the samples of a run, by kind of mating pair.

    The arrays have a row for each sample and a column for each mating pair, such as pin 3 and the disc. The crank
    angles are shifted by full turns, so that the first is between 0 and 2 pi. Forces are the total forces of the mating
    pairs. Pressures occur at the most loaded contact line of each pair; in a rolling cam bearing this is the line of
    one roller. Crank bearings and planets of an RV reducer have no pressure: the attribute `holds` is false for them.
    """
    driven_angle = run[f"{run.driven_shaft}_angle"]
    crank_angle = reducer.member.crank_angle(driven_angle)
    shifted_angle = crank_angle - 2.0 * math.pi * np.floor(crank_angle[0] / (2.0 * math.pi))
    contacts = {}
    for kind in reducer.mechanism.kinds:
        force_vectors, contact = run.forces(kind), reducer.contacts[kind]
        if not contact.HAS_PRESSURE:
            no_pressure = np.zeros(force_vectors.shape[:2])
            contacts[kind] = ContactPressures(kind, shifted_angle, force_vectors, no_pressure, no_pressure > 0.0)
            continue
        curvature = relative_curvature(reducer, kind, reducer.member.against_ring(driven_angle))
        force = np.hypot(force_vectors[..., 0], force_vectors[..., 1]) * contact.line_share
        pressure, is_hertzian = contact.pressure(force, curvature), contact.hertz_holds(force, curvature)
        contacts[kind] = ContactPressures(kind, shifted_angle, force_vectors, pressure, is_hertzian)
    return contacts


def relative_curvature(reducer: Reducer, kind: str, crank_angle: Array) -> Array:
    """Compute the relative curvature [1/m] of the contacts of one kind at n crank angles, (n, contacts) or (1,).

    The latter is for a constant curvature. `crank_angle` [rad], shape (n,), is relative to the ring. Teeth have the
    relative curvature of the ideal mesh. `kind` is the kind of contact, such as "pin_gear".
    """
    if kind == reducer.design.tooth_pair:
        profile = reducer.tooth_profile
        tooth_curvatures = [
            [envelope.arc_contacts(profile, float(angle)).relative_curvature for angle in crank_angle + phase]
            for phase in reducer.phases
        ]
        halves = reducer.design.ring.halves
        return np.concatenate(
            [np.stack(disc_curvatures) for disc_curvatures in tooth_curvatures for _ in range(halves)], axis=1
        )
    return np.array([reducer.contacts[kind].relative_curvature])
