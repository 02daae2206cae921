"""Parts within their tolerances: the samples of a tolerance study whose loads a rating uses."""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.errors import RunError, UsageError
from cycloid_mj.design import Design
from cycloid_mj.explore.jam import PRELOADS, find_jams
from cycloid_mj.explore.sampling import Batch, draw_samples, has_design_file, sample_design, tolerance_zones
from cycloid_mj.figures import compute_sampled
from cycloid_mj.reducer import Reducer, once

Parts = Literal["perfect", "toleranced"]
"""Parts that are rated: as designed, or within the tolerances of the design."""

FORCES = {"tooth_force_n": "tooth", "output_pin_force_n": "output pin", "cam_force_n": "cam"}
"""Figures that rank the samples, in words."""


@dataclass(frozen=True)
class SampleSettings:
    """Choice of the rated samples."""

    samples: int = 200
    """Number of samples, those of the first batch of a tolerance study."""
    percentile: float = 95.0
    """Percentile of each force over the samples that turn."""
    seed: int = 0
    loaded_angles: int = 90
    """Crank angles under load: at 360, the percentiles of the forces differ by less than 1 %."""
    free_angles: int = 8
    """Crank angles without load, for backlash and jams: at 90, the percentiles of the backlash differ by 0.4 %."""


SETTINGS = SampleSettings()


@dataclass(frozen=True)
class RatedSamples:
    """Samples of a design within its tolerances.

    Attributes
    ----------
    numbers, designs
        Numbers, from 0, and designs of the samples at the percentile of each force of `FORCES`.
    words
        The study in words.
    jams, backlash
        Which samples jam, and their backlash [arcmin], shape (samples,).
    """

    numbers: tuple[int, ...]
    designs: tuple[Design, ...]
    words: str
    jams: Mask
    backlash: Array


def has_tolerances(design: Design) -> bool:
    """Return whether the table [tolerance] of a design varies anything that is rated by samples."""
    return design.layout == Reducer.LAYOUT and bool(tolerance_zones(Reducer(design)))


def default_parts(design: Design) -> Parts:
    """Return the parts that are rated unless others are chosen: toleranced if the design has tolerances."""
    return "toleranced" if has_tolerances(design) else "perfect"


def find_critical_sample(reducer: Reducer) -> int | None:
    """Return the number (from 0) of the sample whose largest tooth force is at `SETTINGS.percentile` of all samples.

    Samples without a static equilibrium are left out. None if the design has no tolerances; 0 if no sample has an
    equilibrium.
    """
    zones = tolerance_zones(reducer)
    if not zones:
        return None
    samples = draw_samples(reducer, zones, SETTINGS.seed, Batch(0, SETTINGS.samples))
    force = compute_sampled(reducer, samples, ["tooth_force_n"], SETTINGS.loaded_angles)["tooth_force_n"]
    count = int(np.isfinite(force).sum())  # the others are sorted last
    return int(np.argsort(force, kind="stable")[_rank(count)]) if count else 0


def _rank(count: int) -> int:
    """Return the index of the percentile among so many sorted samples."""
    return math.ceil(0.01 * SETTINGS.percentile * count) - 1


@once
def select_rated_samples(reducer: Reducer) -> RatedSamples:
    """Draw random designs within the tolerances, and select those whose tooth, output pin and cam forces are critical.

    For each kind of force, the sample at `SETTINGS.percentile` of all samples that do not jam is selected. The result
    has these designs; for all samples, it has whether they jam, and their backlash [arcmin].

    Raises
    ------
    UsageError
        The design has no tolerances.
    RunError
        No sample turns and can be written as a design.
    """
    zones = tolerance_zones(reducer)
    name = reducer.design.name
    if not zones:
        raise UsageError(
            f"the design {name!r} has no tolerances: set at least one in the table [tolerance], or use `--parts "
            "perfect`"
        )
    samples = draw_samples(reducer, zones, SETTINGS.seed, Batch(0, SETTINGS.samples))
    figures = compute_sampled(reducer, samples, [*FORCES], SETTINGS.loaded_angles)
    figures |= compute_sampled(reducer, samples, [*PRELOADS, "backlash_arcmin"], SETTINGS.free_angles)
    jams = find_jams(figures)
    usable = np.flatnonzero(~jams & has_design_file(reducer, samples))
    if not usable.size:
        raise RunError(
            f"{name}: all {SETTINGS.samples} samples within the tolerances jam (`cycloid-mj tolerance` shows why). "
            "Increase the clearances, reduce the tolerances, or rate perfect parts with `--parts perfect`"
        )
    rank = _rank(usable.size)
    sorted_samples = {key: usable[np.argsort(figures[key][usable], kind="stable")] for key in FORCES}
    sample_by_force = {key: int(numbers[rank]) for key, numbers in sorted_samples.items()}
    forces = ", ".join(f"{force_name} {figures[key][sample_by_force[key]]:.4g} N" for key, force_name in FORCES.items())
    numbers = tuple(dict.fromkeys(sample_by_force.values()))
    return RatedSamples(
        numbers,
        tuple(sample_design(reducer, zones, SETTINGS.seed, number) for number in numbers),
        "parts within the tolerances of the design: the weakest items of the samples at the "
        f"{SETTINGS.percentile:g} % percentile of the largest forces, {forces}, at the nominal torque without "
        f"friction; {SETTINGS.samples} samples, of which {int(jams.sum())} jam",
        jams,
        figures["backlash_arcmin"],
    )
