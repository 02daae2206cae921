"""Parts within their tolerances: the samples of a tolerance study whose loads a rating uses."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Literal

import numpy as np

from cycloid_mj.base.array import Array, Integers, Mask
from cycloid_mj.base.errors import RunError, UsageError
from cycloid_mj.design import Design
from cycloid_mj.explore import rv_samples
from cycloid_mj.explore.jam import PRELOADS, find_jams
from cycloid_mj.explore.sampling import Batch, draw_samples, has_design_file, sample_design, tolerance_zones
from cycloid_mj.explore.tolerance_zones import has_tolerances
from cycloid_mj.figures import compute_sampled
from cycloid_mj.figures.sampled import solve_states
from cycloid_mj.reducer import Reducer, RvReducer, once, reducer_of
from cycloid_mj.statics.samples import Samples

Parts = Literal["perfect", "toleranced"]
"""Parts that are rated: as designed, or within the tolerances of the design."""

RANKED_LOADS = {"tooth_pressure": "tooth {:.4g} MPa", "output_pin": "output pin {:.4g} N", "cam": "cam {:.4g} N"}
"""Loads by which samples are selected, in words.

That of the teeth is their pressure, because lives of samples with equal tooth forces differ by a factor of two."""


@dataclass(frozen=True)
class SampleSettings:
    """Choice of the rated samples."""

    samples: int = 200
    """Number of samples, those of the first batch of a tolerance study."""
    percentile: float = 95.0
    """Percentile that no load of a rated sample exceeds, over the samples that turn."""
    seed: int = 0
    loaded_angles: int = 90
    """Crank angles under load: at 360, the percentiles of pressure and forces differ by less than 1 %."""
    ranking_angles: int = 30
    """Crank angles under load that find the critical sample of a candidate of a search."""
    likely_samples: int = 30
    """Samples among which that of a candidate is found: three times those with a larger force than it."""
    free_angles: int = 8
    """Crank angles without load, for backlash and jams: at 90, the percentiles of the backlash differ by 0.4 %."""
    rv_angles: int = 61
    """Crank angles of an RV reducer under load: at 720, forces differ by 0.2 %."""


SETTINGS = SampleSettings()


@dataclass(frozen=True)
class RatedSamples:
    """Samples of a design within its tolerances.

    Attributes
    ----------
    numbers, designs
        Numbers, from 0, and designs of the selected samples.
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


def default_parts(design: Design) -> Parts:
    """Return the parts that are rated unless others are chosen: toleranced if the design has tolerances."""
    return "toleranced" if has_tolerances(reducer_of(design)) else "perfect"


def find_likely_critical_samples(reducers: Iterable[Reducer]) -> tuple[int, ...]:
    """Return the numbers of those tolerance samples that probably have the largest tooth pressures.

    `reducers` are several similar reducers with tolerances. A sample is a random drive within the tolerances; its
    random numbers, and so roughly the rank of its pressure, are the same for all reducers. The
    `SETTINGS.likely_samples` samples with the largest mean logarithm of the pressure are returned, numbered from 0;
    none if the reducers have no tolerances or no sample has a static equilibrium.
    """
    sample_numbers = range(SETTINGS.samples)
    pressures = [array for reducer in reducers if (array := _tooth_pressures(reducer, sample_numbers)) is not None]
    log_ratios = [np.log(array / np.nanmedian(array)) for array in pressures if np.isfinite(array).any()]
    if not log_ratios:
        return ()
    mean_log_ratios = np.mean(log_ratios, axis=0)
    descending_order = np.argsort(-np.nan_to_num(mean_log_ratios, nan=-math.inf), kind="stable")
    return tuple(descending_order[: SETTINGS.likely_samples].tolist())


def find_critical_sample(reducer: Reducer, numbers: Sequence[int]) -> int | None:
    """Return the number of the tolerance sample whose tooth pressure is the 95th percentile of all samples.

    A sample is a random drive within the tolerances. Samples are numbered from 0 to `SETTINGS.samples` - 1. Only those
    in `numbers`, from `find_likely_critical_samples`, are computed; the others are assumed to have smaller pressures.
    The percentile is `SETTINGS.percentile`. None if the design has no tolerances; the first of `numbers` if no sample
    has a static equilibrium.
    """
    pressure = _tooth_pressures(reducer, numbers) if numbers else None
    if pressure is None:
        return None
    larger_count = min(SETTINGS.samples - 1 - _rank(SETTINGS.samples), int(np.isfinite(pressure).sum()) - 1)
    descending_order = np.argsort(-np.nan_to_num(pressure, nan=-math.inf), kind="stable")
    return numbers[int(descending_order[max(larger_count, 0)])]


def _tooth_pressures(reducer: Reducer, sample_numbers: Sequence[int]) -> Array | None:
    """Compute the largest tooth pressure over a turn at the nominal torque [Pa] of some tolerance samples.

    `sample_numbers` are their numbers, and the result has as many elements. The pressure is NaN for a sample without
    static equilibrium. Return None if the design has no tolerances.
    """
    if not (zones := tolerance_zones(reducer)):
        return None
    samples = draw_samples(reducer, zones, SETTINGS.seed, Batch(0, SETTINGS.samples))
    selected_samples = Samples(
        **{field.name: getattr(samples, field.name)[list(sample_numbers)] for field in fields(samples)}
    )
    return solve_states(reducer, selected_samples, ["loaded"], SETTINGS.ranking_angles)["loaded"].tooth_pressure


def _rank(sample_count: int) -> int:
    """Return the index of the percentile among so many sorted samples."""
    return math.ceil(0.01 * SETTINGS.percentile * sample_count) - 1


@once
def select_rated_samples(reducer: Reducer) -> RatedSamples:
    """Draw random designs within the tolerances, and select those with the largest loads up to the 95th percentile.

    The loads are the pressure of a tooth and the forces on output pin and cam, or the forces on tooth, crank bearing
    and planet in an RV reducer, at the nominal torque without friction. Samples that jam, or in which a load exceeds
    its percentile (`SETTINGS.percentile`), are left out. Of the others, the sample with the largest load of each kind
    is selected. The result has these designs; for all samples, it has whether they jam, and their backlash [arcmin]
    (NaN for RV reducers).

    Raises
    ------
    UsageError
        The design has no tolerances.
    RunError
        No sample turns and can be written as a design.
    """
    name = reducer.design.name
    if not has_tolerances(reducer):
        table = "crank_tolerance" if isinstance(reducer, RvReducer) else "tolerance"
        raise UsageError(
            f"the design {name!r} has no tolerances: set at least one in the table [{table}], or use `--parts perfect`"
        )
    if isinstance(reducer, RvReducer):
        return _select_rv_samples(reducer)
    zones = tolerance_zones(reducer)
    samples = draw_samples(reducer, zones, SETTINGS.seed, Batch(0, SETTINGS.samples))
    loaded = solve_states(reducer, samples, ["loaded"], SETTINGS.loaded_angles)["loaded"]
    values_by_figure = {
        "tooth_force_n": loaded.tooth,
        "output_pin_force_n": loaded.output_pin,
        "cam_force_n": loaded.cam,
    }
    values_by_figure |= compute_sampled(reducer, samples, [*PRELOADS, "backlash_arcmin"], SETTINGS.free_angles)
    jams = find_jams(values_by_figure)
    usable_numbers = np.flatnonzero(~jams & has_design_file(reducer, samples))
    if not usable_numbers.size:
        raise RunError(
            f"{name}: all {SETTINGS.samples} samples within the tolerances jam (`cycloid-mj tolerance` shows why). "
            "Increase the clearances, reduce the tolerances, or rate perfect parts with `--parts perfect`"
        )
    loads = {"tooth_pressure": 1e-6 * loaded.tooth_pressure, "output_pin": loaded.output_pin, "cam": loaded.cam}
    sample_numbers, selection_text = _select_critical_samples(loads, RANKED_LOADS, usable_numbers)
    return RatedSamples(
        sample_numbers,
        tuple(sample_design(reducer, zones, SETTINGS.seed, sample_number) for sample_number in sample_numbers),
        f"{selection_text}, of which {int(jams.sum())} jam",
        jams,
        values_by_figure["backlash_arcmin"],
    )


def _select_rv_samples(reducer: RvReducer) -> RatedSamples:
    """Return `select_rated_samples` of an RV reducer with tolerances; none of its samples jams."""
    sample_count = SETTINGS.samples
    forces = rv_samples.compute_rv_forces(reducer, sample_count, SETTINGS.seed, SETTINGS.rv_angles)
    words = {key: f"{name} {{:.4g}} N" for key, name in rv_samples.RATED_FORCES.items()}
    sample_numbers, selection_text = _select_critical_samples(forces, words, np.arange(sample_count))
    designs = tuple(
        rv_samples.draw_rv_drive(reducer, SETTINGS.seed, sample_number)[0] for sample_number in sample_numbers
    )
    return RatedSamples(
        sample_numbers, designs, selection_text, np.zeros(sample_count, dtype=bool), np.full(sample_count, math.nan)
    )


def _select_critical_samples(
    loads: Mapping[str, Array], words: Mapping[str, str], usable_numbers: Integers
) -> tuple[tuple[int, ...], str]:
    """Select the samples for `select_rated_samples`; return their numbers, and a sentence on the selection.

    If each load were selected by itself, a sample with the 95th percentile of the force of its output pins could have a
    tooth pressure far beyond that percentile. The numbers have no duplicates.

    Parameters
    ----------
    loads
        Forces [N] or pressures [MPa] of all samples by key, shape (samples,) each.
    words
        Keys of the loads that rank the samples -> their words in the sentence, with a place for the value.
    usable_numbers
        Numbers of the samples that may be selected: those that turn and can be written as a design.
    """
    usable_loads = np.array([loads[key][usable_numbers] for key in words])
    percentiles = np.sort(usable_loads, axis=1)[:, [_rank(usable_numbers.size)]]
    is_within = np.all(usable_loads <= percentiles, axis=0)
    largest = np.argmax(np.where(is_within, usable_loads, -np.inf), axis=1)
    numbers = dict(zip(words, usable_numbers[largest].tolist(), strict=True))
    load_text = ", ".join(text.format(loads[key][numbers[key]]) for key, text in words.items())
    return tuple(dict.fromkeys(numbers.values())), (
        "parts within the tolerances of the design: the weakest items of the samples at the "
        f"{SETTINGS.percentile:g} % percentile of the largest loads, {load_text}, at the nominal torque without "
        f"friction; {SETTINGS.samples} samples"
    )
