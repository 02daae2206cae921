"""Samples of a design within its tolerances: distributions, yield, jams, and an error budget by Sobol indices."""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from cycloid_mj import profile
from cycloid_mj.design import Design
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

BLOCK = 500
"""Samples between two reports of progress."""

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

Progress = Callable[[int, int], None]


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
    progress: Progress | None = None,
    threads: int | None = None,
) -> Tolerances:
    """Draw samples within the design's tolerances, balance them all round, and share out the variance.

    The same seed gives the same bits, whatever the threads.

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
    threads = threads or os.cpu_count() or 1
    report = progress or (lambda done, whole: None)
    whole = samples + (BUDGET_SAMPLES * (len(zones) + 2) if len(zones) > 1 else 0)
    done = [0]

    def told(count: int) -> None:
        done[0] += count
        report(done[0], whole)

    made = drawn(design, zones, samples, seed)
    figures = _figures(design, made, threads, told)
    of = limits[0].key if limits else "backlash_arcmin"
    budget = _budget(design, zones, seed, of, threads, told)
    bad = np.argsort(-figures[of] if not limits or limits[0].at_most else figures[of], kind="stable")[:5]
    worst = tuple(sample_design(design, made, int(row)) for row in bad)
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


def drawn(design: Design, zones: Mapping[str, Zone], count: int, seed: int, stream: int = 0) -> Samples:
    """Draw samples, each tolerance from a stream of random numbers of its own."""
    same = alike(design, count)
    changed = {key: _drawn(key, one, same, count, seed, stream) for key, one in zones.items()}
    return _put(design, same, changed)


def _drawn(key: str, one: Zone, same: Samples, count: int, seed: int, stream: int) -> Array:
    generator = np.random.default_rng([seed, stream, SOURCES.index(key)])
    shapes = {
        "pin_position": same.pin_place.shape,
        "pin_radius": same.pin_radius.shape,
        "hole_position": same.hole_place.shape,
    }
    return one.draws(generator, shapes.get(key, (count,)))


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


def _figures(design: Design, made: Samples, threads: int, told: Callable[[int], None]) -> dict[str, Array]:
    """Balance samples block by block: to both stops without weight or friction, and under the rated torque."""
    blocks = [_balanced(design, _rows(made, first), threads) for first in _told_blocks(len(made), told)]
    return {key: np.concatenate([block[key] for block in blocks]) for key in FIGURES}


def _told_blocks(count: int, told: Callable[[int], None]) -> Any:
    for first in range(0, count, BLOCK):
        yield slice(first, min(first + BLOCK, count))
        told(min(BLOCK, count - first))


def _rows(made: Samples, rows: slice) -> Samples:
    return Samples(**{name: np.asarray(getattr(made, name))[rows] for name in Samples.__dataclass_fields__})


def _balanced(design: Design, made: Samples, threads: int) -> dict[str, Array]:
    still = {"gravity_x": 0.0, "gravity_y": 0.0}
    bare = design.but(environment=still, drive={"speed": 1e-9 * design.drive.speed})
    touch, rated = TOUCH * design.rated_torque, design.rated_torque
    ahead, back, loaded = solve_samples(bare, made, [touch, -touch, rated], ANGLES, threads)
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


def _budget(
    design: Design, zones: Mapping[str, Zone], seed: int, of: str, threads: int, told: Callable[[int], None]
) -> tuple[Share, ...]:
    """Share out the variance of a figure: two sets of samples, and the first with one tolerance at a time of the other.

    Saltelli et al. 2010, Comput. Phys. Commun. 181, 259-270, as scipy computes it.
    """
    from scipy.stats import sobol_indices

    if len(zones) == 1:
        return tuple(Share(key, 1.0, 1.0, (1.0, 1.0)) for key in zones)
    same = alike(design, BUDGET_SAMPLES)
    one, other = (
        {key: _drawn(key, each, same, BUDGET_SAMPLES, seed, stream) for key, each in zones.items()} for stream in (1, 2)
    )

    def values(changed: Mapping[str, Array]) -> Array:
        return _figures(design, _put(design, same, changed), threads, told)[of]

    first, second = values(one), values(other)
    mixed = np.array([values({**one, key: other[key]}) for key in zones])
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


def sample_design(design: Design, made: Samples, row: int) -> Design:
    """Give one sample as a design: its errors listed part by part, its clearances as they came out."""
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
        name=f"{design.name}-{row + 1}"[:64],
        clearance={key: max(float(value), 1e-12) for key, value in clearance.items()},
        errors={**listed, "eccentricity": float(made.eccentricity[row])},
        tolerance=dict.fromkeys(type(design.tolerance).model_fields, ""),
    )


def _distribution(values: Array, unit: str) -> Distribution:
    if len(values) < 2:
        values = np.full(2, np.nan)
    low, middle, high = np.percentile(values, [5.0, 50.0, 95.0]).tolist()
    return Distribution(float(np.mean(values)), float(np.std(values, ddof=1)), low, middle, high, unit)
