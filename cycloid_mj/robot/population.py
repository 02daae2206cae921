"""What a joint's parameters are over many drives of one design: distributions for training robots on all of them.

A drive departs from its drawing by the design's tolerances, and its friction and the stiffness of its cam are somewhere
in the ranges that `measure efficiency` states for them. Both are drawn, and the full model tells what comes of it.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.engine import Engine, Progress, silent
from cycloid_mj.base.errors import CycloidError, RunError
from cycloid_mj.base.frame import Frame, Tabular
from cycloid_mj.base.result import Table
from cycloid_mj.explore.sampling import (
    BLOCK_SAMPLES,
    Batch,
    departure_columns,
    design_of_sample,
    draw_departures,
    draw_samples,
    tolerance_zones,
)
from cycloid_mj.figures import figure
from cycloid_mj.measure.spread import Input, inputs
from cycloid_mj.reducer import Reducer
from cycloid_mj.robot.standalone import PARAMETERS as KEYS

PLAY, _, FRICTION, LOSS, _ = KEYS
PARAMETERS = dict(zip(KEYS, ("arcmin", "N m/arcmin", "N m", "%", "arcsec"), strict=True))
"""Parameters of a joint with their units: play, stiffness, friction on the crank, loss, transmission error.

All but the loss are figures of the catalogue by that key, at the rated torque. The loss is the torque of friction on
the crank under the rated torque beyond that of no load, as a share of the rated torque over the ratio.
"""

VARIED = ("friction", "stiffness")
"""Tables of the design whose values are drawn from the ranges stated for them."""

QUANTILES = (5.0, 25.0, 50.0, 75.0, 95.0)
"""Percentiles that are told."""

STREAM = 10_000
"""First of the streams of random numbers of ranges: those of tolerances come before."""


@dataclass(frozen=True, eq=False, repr=False)
class Population(Tabular):
    """Drives of one design, those whose parts go together.

    Attributes
    ----------
    design
        Its name.
    asked, seed
        How many drives were drawn, and from which seed.
    nominal
        Parameters of the design as drawn on paper, by the keys of `PARAMETERS`.
    values
        Of the drives, shape (samples,) each.
    departures
        What was drawn for them by name, shape (samples,) each: tolerances [um], friction [1], stiffness [N/m].
    ranges
        Inputs that were drawn from their stated ranges.
    has_tolerances
        Whether the design states any.
    """

    design: str
    asked: int
    seed: int
    nominal: Mapping[str, float]
    values: Mapping[str, Array]
    departures: Mapping[str, Array]
    ranges: tuple[Input, ...]
    has_tolerances: bool

    @property
    def samples(self) -> int:
        """How many drives go together."""
        return len(self.values[PLAY])

    @property
    def frame(self) -> Frame:
        """The drives, a row each."""
        number = np.arange(1, self.samples + 1)
        return Frame({"sample": number, **self.values, **self.departures}, dict(PARAMETERS))

    @property
    def correlation(self) -> Array:
        """Pearson's correlation of the parameters, shape (parameters, parameters); NaN of one that does not vary."""
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.corrcoef([self.values[key] for key in PARAMETERS])

    @property
    def notes(self) -> tuple[str, ...]:
        """What the distributions stand on, a sentence each."""
        ranges = "; ".join(f"{one.name} {one.low:.4g} to {one.high:.4g} {one.unit}" for one in self.ranges)
        lost = self.asked - self.samples
        return (
            f"drawn evenly over the logarithm: {ranges}",
            *([] if self.has_tolerances else ["the design states no tolerances, so that its play does not vary"]),
            *(
                [f"{lost} of {self.asked} drives are left out: parts that press each other, or a clearance below 0"]
                if lost
                else []
            ),
        )

    def tables(self) -> tuple[Table, Table]:
        """Tabulate distributions and correlations."""
        title = f"{self.design}: joints of {self.samples} drives, seed {self.seed}"
        rows = tuple(
            (key, unit, *(f"{one:.5g}" for one in (self.nominal[key], *self._summary(key).values())))
            for key, unit in PARAMETERS.items()
        )
        header = ("parameter", "unit", "as drawn", "mean", "std", *(f"{one:g} %" for one in QUANTILES))
        matrix = tuple(
            (key, *("-" if np.isnan(one) else f"{one:+.2f}" for one in row))
            for key, row in zip(PARAMETERS, self.correlation.tolist(), strict=True)
        )
        return Table(title, header, rows), Table("their correlation", ("", *PARAMETERS), matrix)

    def as_json(self) -> dict[str, Any]:
        """Convert the distributions and their correlation to JSON values."""
        return {
            "samples": self.samples,
            "asked": self.asked,
            "seed": self.seed,
            "parameters": {
                key: {"unit": unit, "nominal": self.nominal[key], **self._summary(key)}
                for key, unit in PARAMETERS.items()
            },
            "correlation": {"parameters": list(PARAMETERS), "matrix": self.correlation.tolist()},
            "ranges": [{"input": one.name, "unit": one.unit, "low": one.low, "high": one.high} for one in self.ranges],
        }

    def _summary(self, key: str) -> dict[str, float]:
        values = self.values[key]
        quantiles = np.percentile(values, QUANTILES).tolist()
        return {
            "mean": float(np.mean(values)),
            "std": float(np.std(values, ddof=1)),
            **{f"p{round(share):02d}": one for share, one in zip(QUANTILES, quantiles, strict=True)},
        }


def population(
    reducer: Reducer, samples: int, seed: int = 0, progress: Progress = silent, engine: Engine | None = None
) -> Population:
    """Draw drives of a design and find the parameters of their joints; the same seed gives the same drives.

    Parameters
    ----------
    reducer
        Made as drawn; its tolerances are those of its design.
    samples, seed
        How many are drawn, and from which seed.
    progress
        Called with how many are done, and how many there are.
    engine
        Where the work is done; by default in threads here.

    Raises
    ------
    DesignError
        A tolerance is not of a known form.
    RunError
        Fewer than two drives go together, or the design itself does not balance.
    """
    ranges = tuple(_about(reducer, one) for one in inputs(reducer) if one.table in VARIED)
    work = partial(_drive, reducer, ranges, seed)
    drives = (engine or Engine(kind="threads")).each(work, range(samples), progress)
    good = [one for one in drives if one is not None]
    if len(good) < 2:
        raise RunError(
            f"{samples - len(good)} of {samples} drives of {reducer.design.name!r} do not go together: "
            "tighten the table [tolerance], or enlarge clearances"
        )
    values, drawn_values = (
        {key: np.array([one[part][key] for one in good]) for key in good[0][part]} for part in (0, 1)
    )
    return Population(
        design=reducer.design.name,
        asked=samples,
        seed=seed,
        nominal=parameters(reducer),
        values=values,
        departures=drawn_values,
        ranges=ranges,
        has_tolerances=bool(tolerance_zones(reducer)),
    )


def _about(reducer: Reducer, one: Input) -> Input:
    """Shift a range in which the design's own value does not lie until that is its middle; ends keep their ratio.

    Ranges are of lubricated steel; a value that is further off was chosen for something else.
    """
    table = getattr(reducer.design, one.table)
    shifts = {}
    for key, low in one.low_values.items():
        high, own = one.high_values[key], getattr(table, key)
        shifts[key] = 1.0 if low <= own <= high or one.table == "stiffness" else own / math.sqrt(low * high)
    low_values, high_values = (
        {key: shifts[key] * value for key, value in end.items()} for end in (one.low_values, one.high_values)
    )
    return replace(
        one,
        low=min(low_values.values()),
        high=max(high_values.values()),
        low_values=low_values,
        high_values=high_values,
    )


def parameters(reducer: Reducer) -> dict[str, float]:
    """Compute the parameters of one drive's joint, by the keys of `PARAMETERS`; errors as `statics.loads`."""
    rated = reducer.design.rated_torque
    loaded = reducer.but(load={"torque": rated}).working_at(rated)
    values = {key: figure(key).value(loaded) for key in PARAMETERS if key != LOSS}
    share = reducer.design.reduction / rated
    # of the crank's torque; friction without a load is a parameter of its own
    lost = 100.0 / figure("efficiency").value(loaded) - 1.0 - share * values[FRICTION]
    return {key: 100.0 * lost if key == LOSS else values[key] for key in PARAMETERS}


def _drive(
    reducer: Reducer, ranges: tuple[Input, ...], seed: int, number: int
) -> tuple[dict[str, float], dict[str, float]] | None:
    """Draw a drive by its number; return its parameters and what was drawn, or None where it does not go together."""
    zones, (block, row) = tolerance_zones(reducer), divmod(number, BLOCK_SAMPLES)
    place = Batch(block, 1, row)
    shares = np.random.default_rng([seed, STREAM, number]).random(len(ranges)).tolist()
    changes: dict[str, dict[str, float]] = {}
    for one, share in zip(ranges, shares, strict=True):
        changes.setdefault(one.table, {}).update(one.between(share))
    try:
        made = Reducer(
            design_of_sample(reducer, draw_samples(reducer, zones, seed, place), 0, reducer.design.name)
        ).but(**changes)
        values = parameters(made)
    except CycloidError:
        return None
    of_parts = {
        key: float(values[0]) for key, values in departure_columns(draw_departures(reducer, zones, seed, place)).items()
    }
    of_ranges = {f"drawn_{table}_{key}": value for table, of in changes.items() for key, value in of.items()}
    return values, {**of_ranges, **of_parts}
