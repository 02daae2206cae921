"""Findings of a stress study: for each part the maximum along a crank turn, its place and its error."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.statistics import rms
from cycloid_mj.base.units import MEGAPASCAL, MILLIMETRE
from cycloid_mj.stress.notch import Notch
from cycloid_mj.stress.stress_range import Swing

BOUND = 0.03
"""Largest change of a maximum under one more refinement for which it counts as found."""

ASSUMPTIONS = (
    "the turn is the last one of the run: where it begins the gear has turned on by one lobe, and the output with it; "
    "stress that goes with the output pins may step there",
    "linear elasticity; the shaft, and the output's disc and pins as one body, in 3-D; gear, ring and pin 1 in plane "
    "stress over the face width, or in 3-D where asked for, with their forces even over it; of several discs each is a "
    "part, ring and pin 1 are as wide as all of them, and on shaft and output each disc's forces act in its plane",
    "loads quasi-static: the logged contact forces of each instant, gravity, and inertia; no stress waves",
    "each force acts on an elliptical patch of Hertz's half width, at most 60 deg of the thinner cylinder: so wide is "
    "the cam in its bore (as in a roller bearing's loaded half); its contact stress is that of the most loaded roller",
    "the force of one lobe of the internal gear, a sum of up to three contact lines, acts as one",
    "the free parts, gear and pin 1, have the acceleration that their forces give them (d'Alembert)",
    "the housing is held at the circles that its bolts clamp, or all round outside (housing.support); the output disc "
    "at a hub of the shaft's radius; the shaft in two bearings that press and do not pull (shaft.mounting)",
    "fillets are not in the grids: their stress is the nominal one, of beam theory, times the notch factor of a "
    "shoulder by DIN 743-2; output rollers hand their force on to the core pins over 60 deg to each side",
    "bulk stress is the largest von Mises stress beyond a distance d from every narrow contact and sharp inner corner, "
    "where it stands on a plateau: the first d at which it falls by less than 5 % to the next, 1.41 d. Contact stress "
    "is the largest below a narrow contact by Hertz, whose strip is long; conformal contacts belong to the bulk",
)


@dataclass(frozen=True)
class Peak:
    """A maximum of the von Mises stress.

    Attributes
    ----------
    stress
        [Pa]; not a number where there is none to give.
    angle
        Crank angle [rad].
    place
        In the part's frame [m].
    contact
        Name of the contact that it sits below; empty in the bulk.
    safety
        Factor against yield.
    """

    stress: float
    angle: float
    place: Array
    contact: str
    safety: float

    def as_json(self) -> dict[str, Any]:
        """Convert the peak to JSON values in MPa, degrees and mm."""
        return {
            "stress_mpa": _finite(self.stress / MEGAPASCAL),
            "angle_deg": float(np.degrees(self.angle)),
            "place_mm": [_finite(value / MILLIMETRE) for value in self.place],
            "contact": self.contact,
            "safety_against_yield": _finite(self.safety),
        }


def _finite(value: float) -> float | None:
    """Return a number, or None for what JSON has no word for: the place of no force, the safety of no stress."""
    return float(value) if np.isfinite(value) else None


@dataclass(frozen=True)
class Refinement:
    """The grid of a study, and a finer one.

    Their `unknowns`, and their bulk `stress` [Pa] (2, a) at crank `angle` [rad] (a,).
    """

    unknowns: tuple[int, int]
    angle: Array
    stress: Array

    @property
    def change(self) -> float:
        """Change of the largest stress from the study's grid to the finer one, relative; 0 without stress."""
        coarse, finer = self.stress.max(axis=1)
        return float(abs(coarse / finer - 1.0)) if finer > 0.0 else 0.0

    @property
    def scatter(self) -> float:
        """Change of the stress at each of these angles, rms, relative to the largest."""
        change, largest = rms(self.stress[0] - self.stress[1]), float(self.stress[1].max())
        return change / largest if largest > 0.0 else 0.0

    @property
    def holds(self) -> bool:
        """Whether one more refinement changes the maxima by less than `BOUND`."""
        return self.change < BOUND

    def as_json(self) -> dict[str, Any]:
        """Convert the study of refinement to JSON values in MPa and degrees."""
        return {
            "unknowns": list(self.unknowns),
            "angle_deg": np.degrees(self.angle).tolist(),
            "bulk_mpa": (self.stress / MEGAPASCAL).tolist(),
            "change": self.change,
            "scatter_rms": self.scatter,
            "bound": BOUND,
            "holds": self.holds,
        }


@dataclass(frozen=True, eq=False)
class PartFindings:
    """Stress of one part along a crank turn.

    Attributes
    ----------
    part
        Its name.
    unknowns, dimension
        Of its grid; 2 for plane stress, 3 for a solid body.
    teeth
        Of the ring: the mesh repeats so many times a turn.
    angle
        Crank angle [rad], shape (k,).
    bulk, contact
        Largest von Mises stress away from the contact patches, and below them by Hertz [Pa], shape (k,).
    bulk_peak, contact_peak
        The maxima of the two.
    bulk_distance
        From narrow patches, or from sharp inner corners, where the largest stress stands on its plateau [m].
    sensitivity
        Other distances at which the search for the plateau might begin [m], and the bulk stress [Pa] that it finds.
    choice
        What the choice of where bulk begins may change, as a share: how far the largest stress falls from the plateau
        to twice its distance, or changes from it to half or twice the distance from sharp corners, if that is more.
    by_distance
        Distances [m] (s,), and the largest stress of the turn beyond each [Pa] (s,).
    largest_pressure
        Hertz's peak pressure [Pa], not a number where every contact is conformal; the same as ``measure loads`` gives.
    shakedown
        Safety factor of that pressure against shakedown, 4 k (Johnson 1985, 9.2) of the part's surface, beyond which
        rolling yields at every pass; not a number where every contact is conformal.
    largest_force
        Of one contact [N].
    near_field
        Stress that a half plane has at the bulk distance from the largest force on a narrow patch [Pa].
    imbalance
        What a free part's loads leave on its grid, as a share of the largest force, or of its moment at the part's
        radius; it is spread over the mass.
    notches
        Stress at fillets, of shaft and output.
    variants
        Other supports of the part, and the largest bulk stress [Pa] under them at some crank angles.
    yield_strength
        [Pa].
    refinement
        The maxima on other grids.
    wall
        Time that it took [s].
    swing
        Stress over the turn at the node that fatigue finds worst; None of parts that have fillets instead.
    by_corner
        Distances from sharp corners [m], and the largest stress beyond each [Pa], at the crank angle of the bulk's
        maximum; none where the part has no such corners.
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
    swing: Swing | None = None
    by_corner: tuple[tuple[float, float], ...] = ()

    @property
    def fillet(self) -> Notch | None:
        """The most stressed of its notches; None where the part has none."""
        return max(self.notches, key=lambda notch: notch.stress, default=None)

    @property
    def governing(self) -> float:
        """What its safety is of [Pa]: the largest stress of the bulk, or nominal times notch at a fillet."""
        return max(self.bulk_peak.stress, self.fillet.stress if self.fillet else 0.0)

    @property
    def safety(self) -> float:
        """Against yield of the governing stress."""
        return self.yield_strength / self.governing if self.governing else math.inf

    def orders(self, orders: tuple[int, ...]) -> Array:
        """Compute the amplitudes [Pa] of orders of the crank in the bulk stress."""
        waves = np.exp(-1j * np.outer(orders, self.angle))
        return 2.0 * np.abs(waves @ (self.bulk - self.bulk.mean())) / self.bulk.size

    def as_json(self) -> dict[str, Any]:
        """Convert the findings to dicts, lists, numbers and text."""
        return {
            "part": self.part,
            "unknowns": self.unknowns,
            "dimension": self.dimension,
            "bulk_peak": self.bulk_peak.as_json(),
            "bulk_distance_mm": self.bulk_distance / MILLIMETRE,
            "sensitivity": [
                {"distance_mm": distance / MILLIMETRE, "bulk_mpa": _finite(size / MEGAPASCAL)}
                for distance, size in self.sensitivity
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
                {"distance_mm": distance / MILLIMETRE, "bulk_mpa": size / MEGAPASCAL}
                for distance, size in self.by_corner
            ],
            "governing_mpa": _finite(self.governing / MEGAPASCAL),
            "safety_against_yield": _finite(self.safety),
            "notches": [notch.as_json(self.yield_strength) for notch in self.notches],
            "range": None if self.swing is None else self.swing.as_json(),
            "variants": [{"change": change, "bulk_mpa": size / MEGAPASCAL} for change, size in self.variants],
            "refinement": self.refinement.as_json(),
            "angle_deg": np.degrees(self.angle).tolist(),
            "bulk_mpa": (self.bulk / MEGAPASCAL).tolist(),
            "contact_mpa": [_finite(stress / MEGAPASCAL) for stress in self.contact],
            "wall_s": self.wall,
        }


@dataclass(frozen=True)
class Reference:
    """What a paper has on the stress of a part.

    `source` paper and figure, `below` the stress that it stays below [Pa], None where none is given, under a `load`
    [N m].
    """

    source: str
    below: float | None
    load: float

    def as_json(self) -> dict[str, Any]:
        """Convert the reference to JSON values."""
        below = None if self.below is None else self.below / MEGAPASCAL
        return {"source": self.source, "below_mpa": below, "load_nm": self.load}


@dataclass(frozen=True, eq=False)
class StressFindings:
    """Stress of the parts of one design under one load.

    `design` its name, `ring` its kind, `load` torque [N m], `log` the run's file, `yield_strength` [Pa], `parts`, the
    `wall` time [s], and `references`, what a paper has on this design by part, under whichever load.
    """

    design: str
    ring: str
    load: float
    log: str | None
    yield_strength: float
    parts: tuple[PartFindings, ...]
    wall: float
    references: Mapping[str, Reference] = field(default_factory=dict)

    def __getitem__(self, part: str) -> PartFindings:
        """Return the findings of a part."""
        return next(each for each in self.parts if each.part == part)

    def published(self, part: str) -> float | None:
        """Compute the stress that a paper's figure of this part stays below [Pa], if this is its load."""
        reference = self.references.get(part)
        return reference.below if reference and reference.load == self.load else None

    def __contains__(self, part: str) -> bool:
        """Tell whether a part was studied."""
        return any(each.part == part for each in self.parts)

    def as_json(self) -> dict[str, Any]:
        """Convert the findings to dicts, lists, numbers, text and None only."""
        references = {part: reference.as_json() for part, reference in self.references.items()}
        return {
            "design": self.design,
            "ring": self.ring,
            "load_nm": self.load,
            "log": self.log,
            "yield_strength_mpa": self.yield_strength / MEGAPASCAL,
            "parts": [each.as_json() | {"reference": references.get(each.part)} for each in self.parts],
            "assumptions": list(ASSUMPTIONS),
            "wall_s": self.wall,
        }
