"""Samples that jam, and the cause: parts that press against each other without a load."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.units import MICROMETRES
from cycloid_mj.design.zone import Zone
from cycloid_mj.explore.sampling import Batch, apply_deviations, draw_deviations, unchecked_design_of_sample
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.limits import find_tightest_pairs
from cycloid_mj.statics.samples import identical_samples


@dataclass(frozen=True)
class JamCriteria:
    """Criteria of a jammed sample, and extent of the search for its cause."""

    preload_share: float = 0.01
    """A sample jams where a preload is more than this share of the same pair's largest force under the nominal torque,
    or where it has no equilibrium at all."""
    max_examined: int = 6
    angles: int = 6
    """Jammed samples that are examined for the cause, and crank angles at which."""
    max_share: float = 0.99
    """Share of jammed samples at which a study stops after its first block: what is left has no distribution."""
    min_pair_share: float = 0.05
    """Share of the forces from which a pair counts among those that interfere."""


JAM = JamCriteria()


PRELOADS = {"preload_n": "tooth_force_n", "output_preload_n": "output_pin_force_n", "cam_preload_n": "cam_force_n"}
"""Figures that identify a jam: the force without a load -> the same force under load."""

PRELOADED_PARTS = {"preload_n": "a tooth", "output_preload_n": "an output pin", "cam_preload_n": "the cam"}


def find_jams(figures: Mapping[str, Array]) -> Mask:
    """Return which samples jam, shape (samples,), by the quantities of `PRELOADS` [N], shape (samples,) each.

    Samples without a static equilibrium have NaN as forces, and count as jammed.
    """
    is_free = [figures[preload] <= JAM.preload_share * figures[loaded] for preload, loaded in PRELOADS.items()]
    return np.asarray(~np.all(is_free, axis=0))


def compute_preload_shares(figures: Mapping[str, Array]) -> dict[str, float]:
    """Compute the fraction of samples [1] in which a kind of part is preloaded, by its name ("a tooth", "the cam").

    A part is preloaded if its largest contact force without a load exceeds `JAM.preload_share` times that under the
    nominal torque. The key "no balance" has the fraction of samples without a static equilibrium. Fractions of 0 are
    omitted. `figures` are the results of the samples by key, shape (samples,) each; without the forces in `PRELOADS`,
    such as ``preload_n`` and ``tooth_force_n``, the result is empty.
    """
    if not PRELOADS.keys() <= figures.keys():
        return {}
    shares = {
        PRELOADED_PARTS[preload_key]: float(np.mean(figures[preload_key] > JAM.preload_share * figures[loaded_key]))
        for preload_key, loaded_key in PRELOADS.items()
    }
    failed_share = float(np.mean(~np.isfinite(figures["preload_n"])))
    return {pair: fraction for pair, fraction in {**shares, "no balance": failed_share}.items() if fraction}


def stops_study(jams: Mask) -> bool:
    """Return whether so many samples of a first block, shape (samples,), jam that the study stops."""
    return bool(np.mean(jams) >= JAM.max_share)


def explain_jams(reducer: Reducer, zones: Mapping[str, Zone], seed: int, jams: Mask) -> str:
    """Return a sentence that names the contact pairs which interfere in jammed samples, and by how much.

    The first `JAM.max_examined` jammed samples are examined with rigid parts, at the crank angle of least interference.
    Each tolerance is left out in turn, to see whether the parts of all these samples then fit.

    Parameters
    ----------
    reducer
        Nominal reducer.
    zones
        Its tolerances by key.
    seed
        Random seed of the tolerance study.
    jams
        Which of the study's first samples jam, shape (samples,); at least one.
    """
    rows = np.flatnonzero(jams)[: JAM.max_examined]
    all_deviations = draw_deviations(reducer, zones, seed, Batch(0, int(rows[-1]) + 1))
    deviations = {key: values[rows] for key, values in all_deviations.items()}
    interferences, pair_shares = _minimize_interference(reducer, deviations)
    if max(interferences) <= 0.0:
        return (
            f"in the first {rows.size} of them rigid parts would fit, but contacts press without a load, or no static "
            "balance was found"
        )
    pair_names = sorted(
        (pair for pair, share in pair_shares.items() if share > JAM.min_pair_share), key=lambda pair: -pair_shares[pair]
    )
    removable_keys = [
        f"tolerance.{key}"
        for key in zones
        if max(
            _minimize_interference(reducer, {kept_key: deviations[kept_key] for kept_key in zones if kept_key != key})[
                0
            ]
        )
        <= 0.0
    ]
    cause_text = f"without {' or '.join(removable_keys)} the parts of these samples fit"
    cause_text = cause_text if removable_keys else "no single tolerance is the cause"
    return (
        f"in the first {rows.size} of them {' and '.join(pair_names)} interfere{'' if len(pair_names) > 1 else 's'} by "
        f"{MICROMETRES * max(min(interferences), 0.0):.3g} to {MICROMETRES * max(interferences):.3g} um (rigid parts, "
        f"in the position of least interference); {cause_text}"
    )


def _minimize_interference(reducer: Reducer, deviations: Mapping[str, Array]) -> tuple[list[float], dict[str, float]]:
    """Compute the smallest interference of rigid parts over all crank angles for each sample, and which pairs cause it.

    `deviations` are those from the nominal design [m], by tolerance, shape (samples, ...).

    Returns
    -------
    tuple
        Interference of each sample [m], negative if the parts fit. Contribution of each kind of contact pair to it, by
        name of the pair: its fraction [1] of the contact forces at the tightest crank angle, as a mean over the
        samples.
    """
    sample_count = len(next(iter(deviations.values()))) if deviations else 1
    samples = apply_deviations(reducer, identical_samples(reducer, sample_count), deviations)
    interferences, mean_shares = [], dict[str, float]()
    for row in range(sample_count):
        sample_design = unchecked_design_of_sample(reducer, samples, row)
        crank_angles = np.linspace(0.0, 2.0 * np.pi, JAM.angles, endpoint=False).tolist()
        gap, pair_shares = min(
            (find_tightest_pairs(Reducer(sample_design), angle) for angle in crank_angles),
            key=lambda contact: contact[0],
        )
        interferences.append(-gap)
        for pair, share in pair_shares.items():
            mean_shares[pair] = mean_shares.get(pair, 0.0) + share / sample_count
    return interferences, mean_shares
