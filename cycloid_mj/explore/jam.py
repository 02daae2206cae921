"""Which samples jam, and why: parts that are pressed into each other before there is a load."""

from collections.abc import Mapping

import numpy as np

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.units import MICROMETRES
from cycloid_mj.explore.draw import Batch, departures, put, unchecked_design
from cycloid_mj.explore.zone import Zone
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.limits import tightest
from cycloid_mj.statics.samples import alike

JAM_SHARE = 0.01
"""A sample jams where a preload is more than this share of the same pair's largest force under the rated torque, or
where it has no balance at all."""

PRELOADS = {"preload_n": "tooth_force_n", "output_preload_n": "output_pin_force_n", "cam_preload_n": "cam_force_n"}
"""Figures that tell a jam: those unloaded, by the same under load."""

PRESSED = {"preload_n": "a tooth", "output_preload_n": "an output pin", "cam_preload_n": "the cam"}

SEEN, ANGLES = 6, 6
"""Samples whose jam is looked into, and crank angles at which."""

ACTIVE = 0.05
"""Least share in the forces of a pair that counts among those that interfere."""


def jams_of(figures: Mapping[str, Array]) -> Mask:
    """Tell which samples jam, by `PRELOADS`, shape (samples,)."""
    fits = [figures[free] <= JAM_SHARE * figures[loaded] for free, loaded in PRELOADS.items()]
    return np.asarray(~np.all(fits, axis=0))


def pressed_pairs(figures: Mapping[str, Array]) -> dict[str, float]:
    """Compute, by pair in words, the share of samples in which it presses without a load; those without a balance."""
    counts = {
        PRESSED[free]: float(np.mean(figures[free] > JAM_SHARE * figures[loaded])) for free, loaded in PRELOADS.items()
    }
    lost = float(np.mean(~np.isfinite(figures["preload_n"])))
    return {pair: share for pair, share in {**counts, "no balance": lost}.items() if share}


def cause(reducer: Reducer, zones: Mapping[str, Zone], seed: int, samples: int) -> str:
    """Say why the first samples of a study that all jam do, in a sentence: which pair interferes by how much.

    Parts are rigid there, and lie where the least is pressed. Each tolerance is taken away alone, to see whether all of
    these samples then go together.
    """
    seen = min(samples, SEEN)
    drawn = departures(reducer, zones, seed, Batch(0, seen))
    depths, shares = _interference(reducer, drawn)
    if max(depths) <= 0.0:
        return "rigid parts go together in the first of them: contacts press without a load, or find no balance"
    pairs = sorted((pair for pair, share in shares.items() if share > ACTIVE), key=lambda pair: -shares[pair])
    alone = [
        f"tolerance.{key}"
        for key in zones
        if max(_interference(reducer, {other: drawn[other] for other in zones if other != key})[0]) <= 0.0
    ]
    cured = f"without {' or '.join(alone)} alone they go together" if alone else "no one tolerance is the cause alone"
    return (
        f"in the first {seen} of them {' and '.join(pairs)} interfere{'' if len(pairs) > 1 else 's'} by "
        f"{MICROMETRES * min(depths):.3g} to {MICROMETRES * max(depths):.3g} um, parts rigid and where they have the "
        f"most room; {cured}"
    )


def _interference(reducer: Reducer, drawn: Mapping[str, Array]) -> tuple[list[float], dict[str, float]]:
    """Return how deep the parts of each sample are in each other at least [m], and each pair's mean share in that."""
    seen = len(next(iter(drawn.values()))) if drawn else 1
    samples = put(reducer, alike(reducer, seen), drawn)
    depths, shares = [], dict[str, float]()
    for row in range(seen):
        drive = unchecked_design(reducer, samples, row)
        turn = np.linspace(0.0, 2.0 * np.pi, ANGLES, endpoint=False).tolist()
        room, pairs = min((tightest(Reducer(drive), angle) for angle in turn), key=lambda one: one[0])
        depths.append(-room)
        for pair, share in pairs.items():
            shares[pair] = shares.get(pair, 0.0) + share / seen
    return depths, shares
