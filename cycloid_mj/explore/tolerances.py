"""Samples of a design within its tolerances: distributions, yield, jams, and an error budget by Sobol indices."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal

import numpy as np

from cycloid_mj import profile
from cycloid_mj.design import Design
from cycloid_mj.engine import Engine, Progress, silent
from cycloid_mj.errors import UsageError
from cycloid_mj.explore.limit import FigureLimit
from cycloid_mj.explore.zone import Zone, zone
from cycloid_mj.loaded.samples import Samples, alike, backlash, solve_samples
from cycloid_mj.modification import tooth_profile
from cycloid_mj.result import Table
from cycloid_mj.types import Array, Integers, Mask
from cycloid_mj.units import ARCMINUTE, ARCSECONDS

ANGLES = 360
"""Crank angles at which every sample is balanced."""

TOUCH = 1e-4
"""Torque that brings the parts to a stop, as a share of the rated one: it winds up 0.2 % of the backlash at most."""

BUDGET_SAMPLES = 512
"""Samples of each of the two sets that the indices compare; a power of two."""

RESAMPLES = 200
"""Of the budget's samples, for the confidence of its shares."""

BLOCK = 512
"""Samples that are drawn and balanced together: a piece of work. The draws are those of a block of this size."""

FIGURES = {
    "backlash_arcmin": "arcmin",
    "te_loaded_arcsec": "arcsec",
    "te_unloaded_arcsec": "arcsec",
    "wind_up_arcmin": "arcmin",
    "tooth_force_n": "N",
    "output_pin_force_n": "N",
    "cam_force_n": "N",
    "loaded_teeth": "1",
    "preload_n": "N",
}
"""Key of each figure -> its unit. Transmission errors are from peak to peak, of the output; the preload is the largest
tooth force where nothing but `TOUCH` loads the drive."""

FIRST, SECOND = "first set", "second set"
"""Names of the sets of samples that the indices compare; others are named by the tolerance that is swapped."""

THREADS = Engine(kind="threads")
"""Samples are balanced by compiled code that releases Python's lock."""

JAM_SHARE = 0.01
"""A sample jams where its preload is more than this share of its largest tooth force under the rated torque."""

SOURCES = (
    "mesh",
    "seat",
    "cam",
    "output",
    "pin_position",
    "pin_radius",
    "pin_circle",
    "hole_position",
    "eccentricity",
)
"""Tolerances, as in the design file; the place of each is that of its stream of random numbers."""


@dataclass(frozen=True)
class Distribution:
    """The distribution of one figure: mean, standard deviation, percentiles, and unit."""

    mean: float
    std: float
    p05: float
    p50: float
    p95: float
    unit: str


@dataclass(frozen=True)
class Share:
    """What one tolerance does to the variance of a figure.

    Attributes
    ----------
    source
        Its key in the design file's table.
    first_order, total
        Share of the variance that it has alone, and with all it acts together with (Sobol).
    ci95
        Lowest and highest of `total`, 95 % confidence.
    """

    source: str
    first_order: float
    total: float
    ci95: tuple[float, float]


@dataclass(frozen=True, eq=False)
class Tolerances:
    """What came of the samples of one design.

    Attributes
    ----------
    design
        Its name.
    samples, seed
        How many, and from which seed.
    figures
        Values by key, shape (samples,) each.
    jams
        Which samples go together under force only, shape (samples,).
    limits
        What was asked for.
    budget
        Of the figure `budget_of`, the largest share first.
    worst
        Designs of the samples that are furthest out in `budget_of`, the worst first.
    """

    design: str
    samples: int
    seed: int
    figures: Mapping[str, Array]
    jams: Mask
    limits: tuple[FigureLimit, ...]
    budget_of: str
    budget: tuple[Share, ...]
    worst: tuple[Design, ...]

    @property
    def good(self) -> Mask:
        """Which samples keep every limit and do not jam."""
        kept = [limit.holds(self.figures[limit.key]) for limit in self.limits]
        return np.asarray(np.all([~self.jams, *kept], axis=0))

    @property
    def yield_interval(self) -> tuple[float, float]:
        """The yield with 95 % confidence (Wilson)."""
        from scipy.stats import binomtest

        interval = binomtest(int(self.good.sum()), self.samples).proportion_ci(method="wilson")
        return float(interval.low), float(interval.high)

    @property
    def distributions(self) -> dict[str, Distribution]:
        """The distribution of every figure over the samples that do not jam; no number where all do."""
        return {key: _distribution(values[~self.jams], FIGURES[key]) for key, values in self.figures.items()}

    def tables(self) -> tuple[Table, ...]:
        """Give distributions and budget as tables of text."""
        header = ("figure", "mean", "std", "5 %", "median", "95 %", "unit")
        rows = tuple(
            (key, *(f"{value:.5g}" for value in (one.mean, one.std, one.p05, one.p50, one.p95)), one.unit)
            for key, one in self.distributions.items()
        )
        shares = tuple(
            (one.source, f"{one.first_order:.3f}", f"{one.total:.3f}", f"{one.ci95[0]:.3f} to {one.ci95[1]:.3f}")
            for one in self.budget
        )
        return (
            Table(f"{self.design}: {self.samples} samples", header, rows),
            Table(f"variance of {self.budget_of}", ("tolerance", "first order", "total", "95 %"), shares),
        )

    def as_json(self) -> dict[str, Any]:
        """Give all of it for a program."""
        return {
            "design": self.design,
            "samples": self.samples,
            "seed": self.seed,
            "limits": [str(limit) for limit in self.limits],
            "yield": float(self.good.mean()),
            "yield_ci95": list(self.yield_interval),
            "jam_probability": float(self.jams.mean()),
            "quantities": {key: vars(one) for key, one in self.distributions.items()},
            "budget_of": self.budget_of,
            "budget": [{**vars(one), "ci95": list(one.ci95)} for one in self.budget],
        }


def tolerance(
    design: Design,
    samples: int,
    seed: int,
    limits: Sequence[FigureLimit] = (),
    progress: Progress = silent,
    engine: Engine = THREADS,
) -> Tolerances:
    """Draw samples within the design's tolerances, balance them all round, and share out the variance.

    The same seed gives the same bits, wherever and by however many workers.

    Raises
    ------
    UsageError
        The design has no tolerances.
    DesignError
        A tolerance is not of a known form.
    RunError
        A sample has no static balance.
    """
    zones = tolerances(design)
    if not zones:
        raise UsageError(
            f"the design {design.name!r} has no tolerances: give some in its table [tolerance], "
            "e.g. --set 'tolerance.cam=\"uniform 2\"'"
        )
    sets = {"": blocks(0, samples), **(_budget_blocks(zones) if len(zones) > 1 else {})}
    found = _balanced_sets(design, zones, seed, sets, progress, engine)
    figures = found.pop("")
    of = limits[0].key if limits else "backlash_arcmin"
    budget = _budget(zones, {name: values[of] for name, values in found.items()}, seed)
    bad = np.argsort(-figures[of] if not limits or limits[0].at_most else figures[of], kind="stable")[:5]
    worst = tuple(_sample(design, zones, seed, int(number)) for number in bad)
    jams = figures["preload_n"] > JAM_SHARE * figures["tooth_force_n"]
    return Tolerances(design.name, samples, seed, figures, jams, tuple(limits), of, budget, worst)


def tolerances(design: Design) -> dict[str, Zone]:
    """Give the zones of a design's tolerances, by their keys; those of 0 are left out."""
    given, clearance, ring = design.tolerance, design.clearance, design.ring
    fits = {
        "cam": (2.0 * design.gear.bore_radius, clearance.cam),
        "output": (2.0 * design.output.pin_radius, clearance.output),
        "seat": (2.0 * ring.pin_radius, design.pin_play),
        "mesh": (2.0 * ring.pin_circle_radius, getattr(clearance, design.tooth_pair)),
    }
    sizes = {
        "pin_position": 2.0 * ring.pin_circle_radius,
        "pin_radius": 2.0 * ring.pin_radius,
        "pin_circle": 2.0 * ring.pin_circle_radius,
        "hole_position": 2.0 * design.output.pin_circle_radius,
        "eccentricity": 2.0 * design.gear.eccentricity,
    }
    found = {key: zone(getattr(given, key), key, size, own) for key, (size, own) in fits.items()}
    found |= {key: zone(getattr(given, key), key, size) for key, size in sizes.items()}
    if not design.pin_play:
        found["seat"] = None
    return {key: one for key, one in found.items() if one is not None and (one.width or one.middle)}


@dataclass(frozen=True)
class Block:
    """Samples that are drawn and balanced together.

    Attributes
    ----------
    stream, number
        Which stream of random numbers they are from, and which block of it.
    count
        How many they are.
    swapped
        The tolerance that is drawn from the next stream instead, if any.
    """

    stream: int
    number: int
    count: int
    swapped: str = ""


def blocks(stream: int, samples: int, swapped: str = "") -> list[Block]:
    """Give the blocks of so many samples."""
    return [
        Block(stream, number, min(BLOCK, samples - first), swapped)
        for number, first in enumerate(range(0, samples, BLOCK))
    ]


def drawn(design: Design, zones: Mapping[str, Zone], seed: int, block: Block) -> Samples:
    """Draw the samples of a block, each tolerance from random numbers of its own."""
    same = alike(design, block.count)
    shapes = {
        "pin_position": same.pin_place.shape,
        "pin_radius": same.pin_radius.shape,
        "hole_position": same.hole_place.shape,
    }
    changed = {}
    for key, one in zones.items():
        stream = block.stream + (key == block.swapped)
        generator = np.random.default_rng([seed, stream, SOURCES.index(key), block.number])
        changed[key] = one.draws(generator, shapes.get(key, (block.count,)))
    return _put(design, same, changed)


def _sample(design: Design, zones: Mapping[str, Zone], seed: int, number: int) -> Design:
    """Give a sample, counted from 0, as a design."""
    block, row = divmod(number, BLOCK)
    made = drawn(design, zones, seed, Block(0, block, BLOCK))
    return sample_design(design, made, row, number)


def _put(design: Design, same: Samples, changed: Mapping[str, Array]) -> Samples:
    """Add deviations to samples that are all alike."""
    place, outwards = same.pin_place, profile.unit(profile.pin_angles(tooth_profile(design)))
    if "pin_position" in changed:
        place = place + changed["pin_position"]
    if "pin_circle" in changed:
        place = place + changed["pin_circle"][:, np.newaxis, np.newaxis] * outwards
    parts = {
        key: getattr(same, key) + changed[key]
        for key in ("cam", "output", "mesh", "seat", "pin_radius", "eccentricity")
        if key in changed
    }
    if "hole_position" in changed:
        parts["hole_place"] = same.hole_place + changed["hole_position"]
    return replace(same, pin_place=place, **parts)


def _balanced_sets(
    design: Design,
    zones: Mapping[str, Zone],
    seed: int,
    sets: Mapping[str, Sequence[Block]],
    progress: Progress,
    engine: Engine,
) -> dict[str, dict[str, Array]]:
    """Balance sets of blocks, one after the other; give the figures of each set."""
    all_blocks = [block for of_set in sets.values() for block in of_set]
    whole, done = sum(block.count for block in all_blocks), 0
    rows: dict[int, dict[str, Array]] = {}
    for place, figures in engine.stream(partial(balanced, design, zones, seed, ANGLES), all_blocks):
        rows[place] = figures
        done += all_blocks[place].count
        progress(done, whole)
    in_order = iter([rows[place] for place in range(len(all_blocks))])
    found = {}
    for name, of_set in sets.items():
        parts = [next(in_order) for _ in of_set]
        found[name] = {key: np.concatenate([part[key] for part in parts]) for key in FIGURES}
    return found


def balanced(design: Design, zones: Mapping[str, Zone], seed: int, angles: int, block: Block) -> dict[str, Array]:
    """Balance a block: to both stops without weight or friction, and under the rated torque; give its figures."""
    made = drawn(design, zones, seed, block)
    still = {"gravity_x": 0.0, "gravity_y": 0.0}
    bare = design.but(environment=still, drive={"speed": 1e-9 * design.drive.speed})
    touch, rated = TOUCH * design.rated_torque, design.rated_torque
    ahead, back, loaded = solve_samples(bare, made, [touch, -touch, rated], angles)
    return {
        "backlash_arcmin": backlash(ahead, back) / ARCMINUTE,
        "te_loaded_arcsec": ARCSECONDS * loaded.output_range,
        "te_unloaded_arcsec": ARCSECONDS * ahead.output_range,
        "wind_up_arcmin": (loaded.output_mean - ahead.output_mean) / ARCMINUTE,
        "tooth_force_n": loaded.tooth,
        "output_pin_force_n": loaded.output_pin,
        "cam_force_n": loaded.cam,
        "loaded_teeth": loaded.carrying,
        "preload_n": np.maximum(ahead.tooth, back.tooth),
    }


def _budget_blocks(zones: Mapping[str, Zone]) -> dict[str, list[Block]]:
    """Give the sets that the indices compare: two, and the first with one tolerance at a time of the other."""
    swapped = {key: blocks(1, BUDGET_SAMPLES, key) for key in zones}
    return {FIRST: blocks(1, BUDGET_SAMPLES), SECOND: blocks(2, BUDGET_SAMPLES), **swapped}


def _budget(zones: Mapping[str, Zone], values: Mapping[str, Array], seed: int) -> tuple[Share, ...]:
    """Share out the variance of a figure, given its values in the sets of `_budget_blocks`.

    Saltelli et al. 2010, Comput. Phys. Commun. 181, 259-270, as scipy computes it.
    """
    from scipy.stats import sobol_indices

    if len(zones) == 1:
        return tuple(Share(key, 1.0, 1.0, (1.0, 1.0)) for key in zones)
    first, second = values[FIRST], values[SECOND]
    mixed = np.array([values[key] for key in zones])
    if np.ptp(first) == 0.0:
        return tuple(Share(key, 0.0, 0.0, (0.0, 0.0)) for key in zones)

    def indices(rows: Integers) -> Any:
        chosen: dict[Literal["f_A", "f_B", "f_AB"], Array]
        chosen = {"f_A": first[None, rows], "f_B": second[None, rows], "f_AB": mixed[:, None, rows]}
        return sobol_indices(func=chosen, n=len(rows))

    generator = np.random.default_rng([seed, 3])
    resampled = [generator.integers(0, BUDGET_SAMPLES, BUDGET_SAMPLES) for _ in range(RESAMPLES)]
    spread = np.array([np.ravel(indices(rows).total_order) for rows in resampled])
    ends = np.percentile(spread, [2.5, 97.5], axis=0).T.tolist()
    found = indices(np.arange(BUDGET_SAMPLES))
    first_order, total = np.ravel(found.first_order).tolist(), np.ravel(found.total_order).tolist()
    shares = [Share(key, first_order[i], total[i], (ends[i][0], ends[i][1])) for i, key in enumerate(zones)]
    return tuple(sorted(shares, key=lambda share: -share.total))


def sample_design(design: Design, made: Samples, row: int, number: int) -> Design:
    """Give a sample as a design, with its number in its name.

    Its errors are listed part by part, its clearances are as they came out.
    """
    place, holes = made.pin_place[row], made.hole_place[row].reshape(-1, 2)
    clearance = {design.tooth_pair: made.mesh[row], "cam": made.cam[row], "output": made.output[row]}
    if design.seat_pair:
        clearance[design.seat_pair] = made.seat[row]
    pins = (
        {"pin_x": place[:, 0], "pin_y": place[:, 1], "pin_dr": made.pin_radius[row]}
        if design.ring.kind == "pin"
        else {}
    )
    cams = made.cam_place[row]
    discs = {"disc_dr": made.disc_radius[row], "cam_x": cams[:, 0], "cam_y": cams[:, 1]}
    errors = {**pins, **discs, "hole_x": holes[:, 0], "hole_y": holes[:, 1]}
    listed = {key: tuple(map(float, values)) if np.any(values) else () for key, values in errors.items()}
    return design.but(
        name=f"{design.name}-{number + 1}"[:64],
        clearance={key: max(float(value), 1e-12) for key, value in clearance.items()},
        errors={**listed, "eccentricity": float(made.eccentricity[row])},
        tolerance=dict.fromkeys(type(design.tolerance).model_fields, ""),
    )


def _distribution(values: Array, unit: str) -> Distribution:
    if len(values) < 2:
        values = np.full(2, np.nan)
    low, middle, high = np.percentile(values, [5.0, 50.0, 95.0]).tolist()
    return Distribution(float(np.mean(values)), float(np.std(values, ddof=1)), low, middle, high, unit)
