"""Dimensions of the crank: segments along z, shoulders and bearings."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.parts.parts import crank_segments
from cycloid_mj.parts.shaft import COUNTERWEIGHT, FAR, JOURNAL, bearing_seats
from cycloid_mj.reducer import Reducer, once

STATIONS = 41
"""Number of sections of each journal at which nominal stress is evaluated (heuristic)."""


@dataclass(frozen=True)
class Shoulder:
    """A step of the shaft: its name, its position `z` and the `outer` radius of its larger side [m]."""

    name: str
    z: float
    outer: float


@dataclass(frozen=True)
class ShaftDimensions:
    """Dimensions of the shaft [m]: radii, eccentricity, and positions along z of ends, counterweight, cams, bearings.

    The crank of several discs has no counterweight (of length 0). `phases` are those of the cams [rad]. The
    `bore_radius` is 0 for a solid shaft.
    """

    radius: float
    cam_radius: float
    eccentricity: float
    counterweight_radius: float
    end: float
    far_end: float
    counterweight: tuple[float, float]
    cams: tuple[tuple[float, float], ...]
    phases: tuple[float, ...]
    bearings: tuple[tuple[float, float], tuple[float, float]]
    bore_radius: float = 0.0

    @property
    def weighted(self) -> bool:
        """True if the crank has a counterweight."""
        return self.counterweight[1] > self.counterweight[0]

    @property
    def straddles(self) -> bool:
        """True if it continues beyond its last cam."""
        return self.far_end > self.cams[-1][1]

    @property
    def nominal_bending(self) -> float:
        """Bending stress on the surface of a journal per moment [Pa/(N m)], 4/(pi R^3) if solid; of torsion, half."""
        remaining_share = 1.0 - (self.bore_radius / self.radius) ** 4
        return 4.0 / (np.pi * self.radius**3 * remaining_share)

    @property
    def cam_centres(self) -> Array:
        """Centres of the cams in the frame of the shaft [m], shape (D, 2)."""
        phases = np.array(self.phases)
        return self.eccentricity * np.stack([-np.sin(phases), np.cos(phases)], axis=1) + 0.0

    @property
    def shoulders(self) -> tuple[Shoulder, ...]:
        """List the steps in the radius of the crank (shoulders), where stress concentrates: at counterweight and cams.

        Each has its name, its position along z and the radius of its larger side (`Shoulder`). The counterweight counts
        as a full disc. At a cam, the step is that from the journal to the point of the cam nearest to the axis.
        """
        near_radius, last_number = self.cam_radius - self.eccentricity, len(self.cams) - 1
        shoulders = [Shoulder("journal at the counterweight", self.counterweight[0], self.counterweight_radius)]
        shoulders = shoulders if self.weighted else []
        for number, (start, end) in enumerate(self.cams):
            cam_text = f"cam {number + 1}" if last_number else "the cam"
            shoulders.append(Shoulder(f"{'neck' if number else 'journal'} at {cam_text}", start, near_radius))
            if number < last_number or self.straddles:
                shoulders.append(
                    Shoulder(f"{'neck' if number < last_number else 'far journal'} at {cam_text}", end, near_radius)
                )
        return tuple(shoulders)

    @property
    def stations(self) -> Array:
        """Positions (s,) [m] along the journals at which nominal stress is evaluated, shoulders first."""
        segments = [(self.end, self.counterweight[0] if self.weighted else self.cams[0][0])]
        segments += [(before[1], after[0]) for before, after in pairwise(self.cams)]
        segments += [(self.cams[-1][1], self.far_end)] if self.straddles else []
        journal_positions = [np.linspace(z0, z1, STATIONS) for z0, z1 in segments]
        return np.concatenate([[shoulder.z for shoulder in self.shoulders], *journal_positions])


@once
def shaft_dimensions(reducer: Reducer) -> ShaftDimensions:
    """Return the dimensions that determine the strength of the balanced crank: radii [m], and positions along z [m].

    Spacers between discs are left out.
    """
    design = reducer.design
    segments_by_name = crank_segments(reducer)
    journal, counterweight = segments_by_name[JOURNAL], segments_by_name.get(COUNTERWEIGHT)
    cams = [(segment.z0, segment.z1) for name, segment in segments_by_name.items() if names.family(name) == names.CAM]
    journal_end = min(journal.z1, reducer.near_face)
    return ShaftDimensions(
        radius=design.shaft.radius,
        cam_radius=design.gear.bore_radius,
        eccentricity=design.gear.eccentricity,
        counterweight_radius=design.shaft.counterweight_radius,
        end=journal.z0,
        far_end=segments_by_name[FAR].z1 if FAR in segments_by_name else cams[-1][1],
        counterweight=(counterweight.z0, counterweight.z1) if counterweight else (journal_end, journal_end),
        cams=tuple(cams),
        phases=reducer.phases,
        bearings=bearing_seats(reducer, segments_by_name),
        bore_radius=design.shaft.bore_radius,
    )
