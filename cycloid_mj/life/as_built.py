"""Parts within their tolerances: the samples of a tolerance study whose loads a rating uses."""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from cycloid_mj.base.errors import RunError, UsageError
from cycloid_mj.design import Design
from cycloid_mj.explore.jam import find_jams
from cycloid_mj.explore.sampling import Batch, draw_samples, has_design_file, sample_design, tolerance_zones
from cycloid_mj.figures import SAMPLED, compute_sampled
from cycloid_mj.figures.sampled import ANGLES
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


SETTINGS = SampleSettings()


@dataclass(frozen=True)
class RatedSamples:
    """The designs of the samples at the percentile of each force, and the study in words."""

    designs: tuple[Design, ...]
    words: str


def has_tolerances(design: Design) -> bool:
    """Return whether the table [tolerance] of a design varies anything that is rated by samples."""
    return design.layout == Reducer.LAYOUT and bool(tolerance_zones(Reducer(design)))


@once
def select_rated_samples(reducer: Reducer) -> RatedSamples:
    """Draw samples within the tolerances, and select those with the tooth, output pin or cam force at the percentile.

    Settings of the draw are in `SETTINGS`; samples that jam are left out. One sample may be selected for several
    forces.

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
    figures = compute_sampled(reducer, samples, SAMPLED, ANGLES)
    jams = find_jams(figures)
    usable = np.flatnonzero(~jams & has_design_file(reducer, samples))
    if not usable.size:
        raise RunError(
            f"{name}: all {SETTINGS.samples} samples within the tolerances jam (`cycloid-mj tolerance` shows why). "
            "Increase the clearances, reduce the tolerances, or rate perfect parts with `--parts perfect`"
        )
    rank = math.ceil(0.01 * SETTINGS.percentile * usable.size) - 1
    ordered = {key: usable[np.argsort(figures[key][usable], kind="stable")] for key in FORCES}
    chosen = {key: int(numbers[rank]) for key, numbers in ordered.items()}
    forces = ", ".join(f"{words} {figures[key][chosen[key]]:.4g} N" for key, words in FORCES.items())
    return RatedSamples(
        tuple(sample_design(reducer, zones, SETTINGS.seed, number) for number in dict.fromkeys(chosen.values())),
        "parts within the tolerances of the design: the weakest items of the samples at the "
        f"{SETTINGS.percentile:g} % percentile of the largest forces, {forces}, at the nominal torque without "
        f"friction; {SETTINGS.samples} samples, of which {int(jams.sum())} jam",
    )
