"""Findings of a stress study: the maximum of each part over a crank turn, with its position and its error."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.statistics import rms
from cycloid_mj.base.units import MEGAPASCAL, MILLIMETRE
from cycloid_mj.stress.notch import Notch
from cycloid_mj.stress.stress_range import StressRange

if TYPE_CHECKING:
    from cycloid_mj.stress.rv_strength import RvStrength

MAX_CHANGE = 0.03
"""Largest relative change of a maximum with a finer grid for which it counts as converged."""

_LOBES = "the force of one lobe of the internal gear, a sum of up to three contact lines, acts as a single force"

_FREE_PARTS = "the free parts (disc and pin 1) accelerate under their forces (d'Alembert)"

_BULK = (
    "bulk stress is the largest von Mises stress beyond a distance d from all narrow contacts and sharp inner "
    "corners, where it is on a plateau: the smallest d from which it falls by less than 5 % to the next distance, "
    "1.41 d. Contact stress is the largest stress below a narrow contact by Hertz theory of a long strip; conformal "
    "contacts belong to the bulk"
)

ASSUMPTIONS = (
    "the crank turn is the last of the run; between its beginning and end, disc and output turn on by one lobe, so "
    "stress caused by the output pins may jump there",
    "linear elasticity; the shaft, and the output disc with its pins as one body, in 3-D; disc, ring and pin 1 in "
    "plane stress over the face width, or in 3-D if requested, with forces uniform over the width; each of several "
    "discs is a part of its own, ring and pin 1 are as wide as all discs, and on shaft and output the forces of "
    "each disc act in its plane",
    "quasi-static loads: the logged contact forces at each time, gravity and inertia; no stress waves",
    "each force acts on an elliptical patch of the Hertz half-width, at most 60 deg of the thinner cylinder; the "
    "force of the cam acts on 60 deg of its bore (as in the loaded half of a roller bearing), with the contact "
    "stress of the most loaded roller",
    _LOBES,
    _FREE_PARTS,
    "the housing is fixed at the circles that its bolts clamp, or all around its outside (housing.support); the "
    "output disc at a hub with the radius of the shaft; the shaft in two bearings that transmit pressure only "
    "(shaft.mounting)",
    "fillets are not meshed: their stress is the nominal stress of beam theory times the notch factor of a shoulder, "
    "or of the seat of a keyed, shrunk, clamped or splined cam, by DIN 743-2; output rollers distribute their force on "
    "the core pins over 60 deg to each side",
    _BULK,
)

RV_ASSUMPTIONS = (
    "the forces are those of the static balance with friction over a turn of the cranks relative to the carrier, after "
    "which all loads repeat; weight and inertia are left out",
    "linear elasticity; discs, ring and pin 1 in plane stress over the face width, or in 3-D if requested, with forces "
    "uniform over the width; ring and pin 1 are as wide as all discs",
    "each force acts on an elliptical patch of the Hertz half-width, at most 60 deg of the thinner cylinder; the "
    "force of a crank acts on 60 deg of its bore (as in the loaded half of a roller bearing), with the contact "
    "stress of the most loaded needle",
    "the housing is fixed at the circles that its bolts clamp, or all around its outside (housing.support)",
    "cranks are beams on two bearings in the middles of the flanges, under the forces of each disc, uniform over its "
    "width, and of the planet; their stress is the nominal one at the ends of the eccentrics times the notch factor of "
    "a shoulder by DIN 743-2",
    "teeth of sun and planets: nominal stress by ISO 6336-3, method B, under the largest force on a planet, without "
    "factors for application, dynamics and uneven load",
    _LOBES,
    _FREE_PARTS,
    _BULK,
)


@dataclass(frozen=True)
class Peak:
    """Maximum of the von Mises stress.

    Attributes
    ----------
    stress
        Stress [Pa]; NaN where there is none.
    angle
        Crank angle [rad].
    position
        Position in the part's frame [m].
    contact
        Name of the contact above it; empty in the bulk.
    safety
        Safety factor against yield.
    """

    stress: float
    angle: float
    position: Array
    contact: str
    safety: float

    def as_json(self) -> dict[str, Any]:
        """Convert the largest stress, with angle and position, to JSON values; keys end in their units.

        The keys are ``stress_mpa``, ``angle_deg``, ``place_mm`` (the position), ``contact`` (its name, or "") and
        ``safety_against_yield``. Values that are not finite become None.
        """
        return {
            "stress_mpa": _finite(self.stress / MEGAPASCAL),
            "angle_deg": float(np.degrees(self.angle)),
            "place_mm": [_finite(coordinate / MILLIMETRE) for coordinate in self.position],
            "contact": self.contact,
            "safety_against_yield": _finite(self.safety),
        }


def _finite(value: float) -> float | None:
    """Return a number, or None for NaN and infinity, which JSON lacks: position and safety without a force."""
    return float(value) if np.isfinite(value) else None


@dataclass(frozen=True)
class Refinement:
    """Bulk stress of a part on the grid of a study, and on a finer grid.

    `unknowns` are the numbers of unknowns of both grids. `stress` (2, a) [Pa] is the largest bulk stress on each of
    them at the crank angles `angle` (a,) [rad]. Bulk stress is the stress away from the contact areas.
    """

    unknowns: tuple[int, int]
    angle: Array
    stress: Array

    @property
    def change(self) -> float:
        """Relative change of the largest stress from the study's grid to the finer one [1]; 0 without stress."""
        coarse_peak, fine_peak = self.stress.max(axis=1)
        return float(abs(coarse_peak / fine_peak - 1.0)) if fine_peak > 0.0 else 0.0

    @property
    def scatter(self) -> float:
        """Rms over the crank angles of the change from grid to grid, relative to the largest stress [1]."""
        rms_change, largest_stress = rms(self.stress[0] - self.stress[1]), float(self.stress[1].max())
        return rms_change / largest_stress if largest_stress > 0.0 else 0.0

    @property
    def is_converged(self) -> bool:
        """True if the refinement changes the maxima by less than `MAX_CHANGE`."""
        return self.change < MAX_CHANGE

    def as_json(self) -> dict[str, Any]:
        """Convert the stresses on two finite-element meshes, one finer, to JSON values; keys end in their units.

        ``unknowns`` has a number for each mesh, ``bulk_mpa`` the largest bulk stress on each mesh by ``angle_deg``, the
        crank angles. ``change`` [1] is the relative change of the largest stress by the refinement, and ``scatter_rms``
        [1] the rms change over the angles relative to the largest stress. ``holds`` is whether ``change`` is below
        ``bound``.
        """
        return {
            "unknowns": list(self.unknowns),
            "angle_deg": np.degrees(self.angle).tolist(),
            "bulk_mpa": (self.stress / MEGAPASCAL).tolist(),
            "change": self.change,
            "scatter_rms": self.scatter,
            "bound": MAX_CHANGE,
            "holds": self.is_converged,
        }


@dataclass(frozen=True, eq=False)
class PartFindings:
    """Stress of one part along a crank turn.

    Attributes
    ----------
    part
        Name of the part.
    unknowns, dimension
        Number of unknowns and dimension of its grid: 2 for plane stress, 3 for a solid body.
    teeth
        Teeth of the ring, which are the mesh periods per turn.
    angle
        Crank angle [rad], shape (k,).
    bulk, contact
        Largest von Mises stress away from the contact patches, and below them by Hertz [Pa], shape (k,).
    bulk_peak, contact_peak
        Maxima of these.
    bulk_distance
        Distance from narrow patches or sharp inner corners at which the largest stress reaches its plateau [m].
    sensitivity
        Other start distances of the search for the plateau [m], and the bulk stress [Pa] of each.
    choice
        Relative uncertainty by the definition of bulk: drop of the largest stress from the plateau to twice its
        distance, or its change with half or twice the distance from sharp corners, whichever is larger.
    by_distance
        Distances [m] (s,), and the largest stress of the turn beyond each [Pa] (s,).
    largest_pressure
        Hertz's peak pressure [Pa], as of ``measure loads``; NaN where all contacts are conformal.
    shakedown
        Safety factor of that pressure against shakedown, 4 k (Johnson 1985, 9.2) of the part's surface, beyond which
        rolling yields at every pass; NaN where all contacts are conformal.
    largest_force
        Largest force of a contact [N].
    near_field
        Stress of a half plane at the bulk distance from the largest force on a narrow patch [Pa].
    imbalance
        Imbalance of a free part's loads, relative to the largest force, or its moment at the part's radius; it is
        distributed over the mass.
    notches
        Stress at the fillets of shaft and output.
    variants
        Other supports of the part, and the largest bulk stress [Pa] with them at some crank angles.
    yield_strength
        Yield strength [Pa].
    refinement
        Maxima on a finer grid.
    wall
        Wall time [s].
    stress_range
        Stress range over the turn at the critical node for fatigue; None for parts with fillets instead.
    by_corner
        Distances from sharp corners [m], and the largest stress beyond each [Pa], at the crank angle of the bulk's
        maximum; empty where the part has no such corners.
    """

    part: str
    unknowns: int
    dimension: int
    teeth: int
    angle: Array
    bulk: Array
    bulk_peak: Peak
    bulk_distance: float
    sensitivity: tuple[tuple[float, float], ...]
    choice: float
    by_distance: tuple[Array, Array]
    contact: Array
    contact_peak: Peak
    largest_pressure: float
    shakedown: float
    largest_force: float
    near_field: float
    imbalance: float
    notches: tuple[Notch, ...]
    variants: tuple[tuple[str, float], ...]
    yield_strength: float
    refinement: Refinement
    wall: float
    stress_range: StressRange | None = None
    by_corner: tuple[tuple[float, float], ...] = ()

    @property
    def fillet(self) -> Notch | None:
        """Notch with the largest stress; None without notches."""
        return max(self.notches, key=lambda notch: notch.stress, default=None)

    @property
    def governing(self) -> float:
        """Governing stress [Pa]: the larger of bulk stress and fillet stress (nominal stress times notch factor)."""
        return max(self.bulk_peak.stress, self.fillet.stress if self.fillet else 0.0)

    @property
    def safety(self) -> float:
        """Safety factor of the governing stress against yield."""
        return self.yield_strength / self.governing if self.governing else math.inf

    def orders(self, orders: tuple[int, ...]) -> Array:
        """Compute the amplitudes [Pa] of orders of the crank in the bulk stress."""
        waves = np.exp(-1j * np.outer(orders, self.angle))
        return 2.0 * np.abs(waves @ (self.bulk - self.bulk.mean())) / self.bulk.size

    def as_json(self) -> dict[str, Any]:
        """Convert the stresses of a part to JSON values; keys end in their units, infinite and missing values are None.

        ``bulk_mpa`` and ``contact_mpa`` are the largest stresses by crank angle ``angle_deg``. Lists of pairs, such as
        ``sensitivity``, become lists of dicts. ``range`` is the stress range for fatigue, or None. The other keys are
        names of attributes, such as ``governing_mpa``.
        """
        return {
            "part": self.part,
            "unknowns": self.unknowns,
            "dimension": self.dimension,
            "bulk_peak": self.bulk_peak.as_json(),
            "bulk_distance_mm": self.bulk_distance / MILLIMETRE,
            "sensitivity": [
                {"distance_mm": distance / MILLIMETRE, "bulk_mpa": _finite(bulk / MEGAPASCAL)}
                for distance, bulk in self.sensitivity
            ],
            "choice": self.choice,
            "by_distance": {
                "distance_mm": (self.by_distance[0] / MILLIMETRE).tolist(),
                "bulk_mpa": (self.by_distance[1] / MEGAPASCAL).tolist(),
            },
            "contact_peak": self.contact_peak.as_json(),
            "largest_pressure_mpa": _finite(self.largest_pressure / MEGAPASCAL),
            "safety_against_shakedown": _finite(self.shakedown),
            "largest_force_n": self.largest_force,
            "near_field_mpa": self.near_field / MEGAPASCAL,
            "imbalance": self.imbalance,
            "by_corner": [
                {"distance_mm": distance / MILLIMETRE, "bulk_mpa": bulk / MEGAPASCAL}
                for distance, bulk in self.by_corner
            ],
            "governing_mpa": _finite(self.governing / MEGAPASCAL),
            "safety_against_yield": _finite(self.safety),
            "notches": [notch.as_json(self.yield_strength) for notch in self.notches],
            "range": None if self.stress_range is None else self.stress_range.as_json(),
            "variants": [{"change": change, "bulk_mpa": bulk / MEGAPASCAL} for change, bulk in self.variants],
            "refinement": self.refinement.as_json(),
            "angle_deg": np.degrees(self.angle).tolist(),
            "bulk_mpa": (self.bulk / MEGAPASCAL).tolist(),
            "contact_mpa": [_finite(stress / MEGAPASCAL) for stress in self.contact],
            "wall_s": self.wall,
        }


@dataclass(frozen=True)
class Reference:
    """Published stress of a part.

    `source` is paper and figure, `below` the upper limit of the stress [Pa], or None, under a `load` [N m].
    """

    source: str
    below: float | None
    load: float

    def as_json(self) -> dict[str, Any]:
        """Convert the reference to JSON values: ``source``, ``below_mpa`` (upper limit, or None) and ``load_nm``."""
        below = None if self.below is None else self.below / MEGAPASCAL
        return {"source": self.source, "below_mpa": below, "load_nm": self.load}


@dataclass(frozen=True, eq=False)
class StressFindings:
    """Stress of the parts of one design under one load.

    `design` is its name, `ring` the kind of its ring, `load` the torque [N m], `log` the run's file, `yield_strength`
    in [Pa], `parts` their findings, `wall` the wall time [s], and `references` published stresses by part, at any load.
    `strength` is the stress of cranks and gears of an RV reducer, which has no log.
    """

    design: str
    ring: str
    load: float
    log: str | None
    yield_strength: float
    parts: tuple[PartFindings, ...]
    wall: float
    references: Mapping[str, Reference] = field(default_factory=dict)
    strength: "RvStrength | None" = None

    @property
    def assumptions(self) -> tuple[str, ...]:
        """Assumptions of the study, a sentence each."""
        return RV_ASSUMPTIONS if self.strength else ASSUMPTIONS

    def __getitem__(self, part: str) -> PartFindings:
        """Return the findings of a part."""
        return next(each for each in self.parts if each.part == part)

    def published_limit(self, part: str) -> float | None:
        """Compute the stress that a paper's figure of this part stays below [Pa], if this is its load."""
        reference = self.references.get(part)
        return reference.below if reference and reference.load == self.load else None

    def __contains__(self, part: str) -> bool:
        """Return whether a part was studied."""
        return any(each.part == part for each in self.parts)

    def as_json(self) -> dict[str, Any]:
        """Convert the stresses of all parts to JSON values; keys end in their units.

        ``parts`` has the findings of each part and its published stress (``reference``, or None). ``cranks_and_gears``
        is None except for an RV reducer.
        """
        references = {part: reference.as_json() for part, reference in self.references.items()}
        return {
            "design": self.design,
            "ring": self.ring,
            "load_nm": self.load,
            "log": self.log,
            "yield_strength_mpa": self.yield_strength / MEGAPASCAL,
            "parts": [findings.as_json() | {"reference": references.get(findings.part)} for findings in self.parts],
            "cranks_and_gears": self.strength and self.strength.as_json(),
            "assumptions": list(self.assumptions),
            "wall_s": self.wall,
        }
