"""Samples that jam, and why: parts that press into each other without a load."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.units import MICROMETRES
from cycloid_mj.explore.sampling import Batch, apply_departures, draw_departures, unchecked_design_of_sample
from cycloid_mj.explore.zone import Zone
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.limits import tightest
from cycloid_mj.statics.samples import identical_samples


@dataclass(frozen=True)
class JamSettings:
    """Criteria of a jammed sample, and extent of the search for its cause."""

    share: float = 0.01
    """A sample jams where a preload is more than this share of the same pair's largest force under the nominal torque,
    or where it has no balance at all."""
    max_examined: int = 6
    angles: int = 6
    """Jammed samples that are examined for the cause, and crank angles at which."""
    max_share: float = 0.99
    """Share of jammed samples at which a study stops after its first block: what is left has no distribution."""
    min_pair_share: float = 0.05
    """Share of the forces from which a pair counts among those that interfere."""


JAM = JamSettings()


PRELOADS = {"preload_n": "tooth_force_n", "output_preload_n": "output_pin_force_n", "cam_preload_n": "cam_force_n"}
"""Figures that identify a jam: the force without a load -> the same force under load."""

PRELOADED_PARTS = {"preload_n": "a tooth", "output_preload_n": "an output pin", "cam_preload_n": "the cam"}


def find_jams(figures: Mapping[str, Array]) -> Mask:
    """Return which samples jam, by the figures of `PRELOADS`, shape (samples,)."""
    fits = [figures[free] <= JAM.share * figures[loaded] for free, loaded in PRELOADS.items()]
    return np.asarray(~np.all(fits, axis=0))


def preloaded_pairs(figures: Mapping[str, Array]) -> dict[str, float]:
    """Compute the share of samples in which each part presses without a load, and of those without a balance.

    Empty for samples that were not balanced.
    """
    if not PRELOADS.keys() <= figures.keys():
        return {}
    counts = {
        PRELOADED_PARTS[free]: float(np.mean(figures[free] > JAM.share * figures[loaded]))
        for free, loaded in PRELOADS.items()
    }
    lost = float(np.mean(~np.isfinite(figures["preload_n"])))
    return {pair: share for pair, share in {**counts, "no balance": lost}.items() if share}


def jams_too_often(jams: Mask) -> bool:
    """Return whether so many samples of a first block, shape (samples,), jam that the study stops."""
    return bool(np.mean(jams) >= JAM.max_share)


def explain_jams(reducer: Reducer, zones: Mapping[str, Zone], seed: int, jams: Mask) -> str:
    """Explain in a sentence why samples of the first block jam: which pairs interfere, and by how much.

    The first `JAM.max_examined` jammed samples are examined with rigid parts, in the position of least interference.
    Each tolerance is left out on its own, to see whether the parts of all these samples then fit.

    Parameters
    ----------
    reducer, zones, seed
        The study.
    jams
        Which samples of its first block jam, shape (samples,); one at least.
    """
    rows = np.flatnonzero(jams)[: JAM.max_examined]
    first = draw_departures(reducer, zones, seed, Batch(0, int(rows[-1]) + 1))
    drawn = {key: values[rows] for key, values in first.items()}
    depths, shares = _interference(reducer, drawn)
    if max(depths) <= 0.0:
        return (
            f"in the first {rows.size} of them rigid parts would fit, but contacts press without a load, or no static "
            "balance was found"
        )
    pairs = sorted(
        (pair for pair, share in shares.items() if share > JAM.min_pair_share), key=lambda pair: -shares[pair]
    )
    sufficient = [
        f"tolerance.{key}"
        for key in zones
        if max(_interference(reducer, {other: drawn[other] for other in zones if other != key})[0]) <= 0.0
    ]
    remedy = f"without {' or '.join(sufficient)} the parts of these samples fit"
    remedy = remedy if sufficient else "no single tolerance is the cause"
    return (
        f"in the first {rows.size} of them {' and '.join(pairs)} interfere{'' if len(pairs) > 1 else 's'} by "
        f"{MICROMETRES * max(min(depths), 0.0):.3g} to {MICROMETRES * max(depths):.3g} um (rigid parts, in the "
        f"position of least interference); {remedy}"
    )


def _interference(reducer: Reducer, drawn: Mapping[str, Array]) -> tuple[list[float], dict[str, float]]:
    """Return the smallest interference of each sample over its positions [m], and the mean share of each pair in it."""
    count = len(next(iter(drawn.values()))) if drawn else 1
    samples = apply_departures(reducer, identical_samples(reducer, count), drawn)
    depths, shares = [], dict[str, float]()
    for row in range(count):
        drive = unchecked_design_of_sample(reducer, samples, row)
        turn = np.linspace(0.0, 2.0 * np.pi, JAM.angles, endpoint=False).tolist()
        gap, pairs = min((tightest(Reducer(drive), angle) for angle in turn), key=lambda found: found[0])
        depths.append(-gap)
        for pair, share in pairs.items():
            shares[pair] = shares.get(pair, 0.0) + share / count
    return depths, shares
