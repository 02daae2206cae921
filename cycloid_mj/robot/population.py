"""Distributions of a joint's parameters over many drives of one design, for the training of robots.

A drive deviates from its drawing by the design's tolerances, and its friction and cam stiffness are within the ranges
that `measure efficiency` states. Both are drawn at random, and the parameters follow from the full model.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.engine import Engine, Progress, silent
from cycloid_mj.base.errors import CycloidError, RunError
from cycloid_mj.base.frame import Frame, Tabular
from cycloid_mj.base.result import Table
from cycloid_mj.design import Design
from cycloid_mj.design.layouts import Layout
from cycloid_mj.design.zone import Zone
from cycloid_mj.explore import sampling
from cycloid_mj.explore.rv_samples import crank_zones, draw_rv_drive
from cycloid_mj.figures import figure
from cycloid_mj.measure.spread import Input, assumed_inputs
from cycloid_mj.reducer import Reducer
from cycloid_mj.robot.standalone import PARAMETERS as KEYS

PLAY, _, FRICTION, LOSS, _ = KEYS
PARAMETERS = dict(zip(KEYS, ("arcmin", "N m/arcmin", "N m", "%", "arcsec"), strict=True))
"""Parameters of a joint with their units: play, stiffness, friction on the crank, loss, transmission error.

All but the loss are figures of the catalogue by that key, at the nominal torque. The loss is the torque of friction on
the crank under the nominal torque beyond that of no load, as a share of the nominal torque over the ratio.
"""

VARIED: Mapping[Layout, tuple[str, ...]] = {
    "central": ("friction", "stiffness"),
    "rv": ("friction", "planet", "clearance"),
}
"""Tables of each layout whose values are drawn from their stated ranges; tolerances of RV reducers include no play."""

INPUT_STREAM = 10_000
"""Number of the random stream of the inputs; tolerances use lower numbers."""

QUANTILES = (5.0, 25.0, 50.0, 75.0, 95.0)
"""Percentiles that are reported."""


@dataclass(frozen=True, eq=False, repr=False)
class Population(Tabular):
    """Drives of one design that can be assembled.

    Attributes
    ----------
    design
        Name of the design.
    requested, seed
        Number of drives that were drawn, and the seed.
    nominal
        Parameters of the nominal design, by the keys of `PARAMETERS`.
    values
        Parameters of the drives, shape (samples,) each.
    deviations
        Values that were drawn for them, by name, shape (samples,): tolerances [um], friction [1], stiffness [N/m].
    ranges
        Inputs that were drawn from their stated ranges.
    has_tolerances
        Whether the design states tolerances.
    """

    design: str
    requested: int
    seed: int
    nominal: Mapping[str, float]
    values: Mapping[str, Array]
    deviations: Mapping[str, Array]
    ranges: tuple[Input, ...]
    has_tolerances: bool

    @property
    def samples(self) -> int:
        """Number of drives that can be assembled."""
        return len(self.values[PLAY])

    @property
    def frame(self) -> Frame:
        """Drives, one row each."""
        drive_numbers = np.arange(1, self.samples + 1)
        return Frame({"sample": drive_numbers, **self.values, **self.deviations}, dict(PARAMETERS))

    @property
    def correlation(self) -> Array:
        """Pearson correlation of the parameters, shape (p, p); NaN for a parameter that does not vary."""
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.corrcoef([self.values[key] for key in PARAMETERS])

    @property
    def notes(self) -> tuple[str, ...]:
        """Return sentences on random drives: ranges of drawn inputs, missing tolerances, drives that are left out."""
        ranges = "; ".join(
            f"{input_range.name} {input_range.low:.4g} to {input_range.high:.4g} {input_range.unit}"
            for input_range in self.ranges
        )
        excluded_count = self.requested - self.samples
        drives = f"{excluded_count} of {self.requested} drives"
        return (
            f"drawn with a log-uniform distribution: {ranges}",
            *([] if self.has_tolerances else ["the design states no tolerances, so its play does not vary"]),
            *([f"{drives} are left out: they cannot be assembled (interference of parts)"] if excluded_count else []),
        )

    def tables(self) -> tuple[Table, Table]:
        """Tabulate the distribution of each joint parameter over random drives, and their correlations."""
        title = f"{self.design}: joints of {self.samples} drives, seed {self.seed}"
        rows = tuple(
            (key, unit, *(f"{value:.5g}" for value in (self.nominal[key], *self._summarize_parameter(key).values())))
            for key, unit in PARAMETERS.items()
        )
        header = ("parameter", "unit", "nominal", "mean", "std", *(f"{value:g} %" for value in QUANTILES))
        matrix = tuple(
            (key, *("-" if np.isnan(value) else f"{value:+.2f}" for value in row))
            for key, row in zip(PARAMETERS, self.correlation.tolist(), strict=True)
        )
        return Table(title, header, rows), Table("correlation of the parameters", ("", *PARAMETERS), matrix)

    def as_json(self) -> dict[str, Any]:
        """Convert the distribution of joint parameters over random drives to JSON values.

        ``parameters`` has unit, nominal value, mean, standard deviation and percentiles of each parameter.
        ``correlation`` has their correlation matrix, ``ranges`` the ranges from which inputs were drawn. ``samples`` of
        ``asked`` drives can be assembled.
        """
        return {
            "samples": self.samples,
            "asked": self.requested,
            "seed": self.seed,
            "parameters": {
                key: {"unit": unit, "nominal": self.nominal[key], **self._summarize_parameter(key)}
                for key, unit in PARAMETERS.items()
            },
            "correlation": {"parameters": list(PARAMETERS), "matrix": self.correlation.tolist()},
            "ranges": [
                {"input": input_range.name, "unit": input_range.unit, "low": input_range.low, "high": input_range.high}
                for input_range in self.ranges
            ],
        }

    def _summarize_parameter(self, key: str) -> dict[str, float]:
        """Return mean, standard deviation and percentiles of the parameter `key` over random drives: name -> value.

        The names are ``mean``, ``std``, and those of the percentiles, such as ``p05``.
        """
        values = self.values[key]
        quantiles = np.percentile(values, QUANTILES).tolist()
        return {
            "mean": float(np.mean(values)),
            "std": float(np.std(values, ddof=1)),
            **{f"p{round(percent):02d}": value for percent, value in zip(QUANTILES, quantiles, strict=True)},
        }


def draw_population(reducer: Reducer, samples: int, seed: int = 0, progress: Progress = silent) -> Population:
    """Draw random drives of a design, and compute the parameters of their joints; equal seeds draw equal drives.

    Parameters
    ----------
    reducer
        Nominal reducer, whose design has the tolerances.
    samples, seed
        Number of drives, and random seed.
    progress
        Called with the number of finished drives and the number of all drives.

    Raises
    ------
    DesignError
        A tolerance has an unknown form.
    RunError
        Fewer than two drives can be assembled, or the design has no static equilibrium.
    """
    varied_tables = VARIED[reducer.LAYOUT]
    ranges = tuple(_centred_range(reducer, item) for item in assumed_inputs(reducer) if item.table in varied_tables)
    draw_drive = partial(_draw_drive, reducer, ranges, seed)
    drives = Engine(kind="threads").each(draw_drive, range(samples), progress)
    assembled_drives = [drive for drive in drives if drive is not None]
    if len(assembled_drives) < 2:
        raise RunError(
            f"{reducer.design.name}: only {len(assembled_drives)} of {samples} randomly sampled drives can be "
            "assembled, but at least 2 are needed. Reduce the tolerances, or increase the clearances (clearance.*)"
        )
    values, drawn_values = (
        {key: np.array([drive[index][key] for drive in assembled_drives]) for key in assembled_drives[0][index]}
        for index in (0, 1)
    )
    return Population(
        design=reducer.design.name,
        requested=samples,
        seed=seed,
        nominal=compute_parameters(reducer),
        values=values,
        deviations=drawn_values,
        ranges=ranges,
        has_tolerances=bool(DRAWS[reducer.LAYOUT].zones(reducer)),
    )


def _centred_range(reducer: Reducer, input_range: Input) -> Input:
    """Shift the range of an assumed input so that it includes the design's own value; its ends keep their ratio.

    The ranges are those of lubricated steel. A value outside its range was chosen for other conditions; the range is
    then shifted so that the value is the geometric mean of its ends. Ranges of stiffness are not shifted.
    """
    table = getattr(reducer.design, input_range.table)
    shift_factors = {}
    for key, low_value in input_range.low_values.items():
        high_value, design_value = input_range.high_values[key], getattr(table, key)
        shift_factors[key] = (
            1.0
            if low_value <= design_value <= high_value or input_range.table == "stiffness"
            else design_value / math.sqrt(low_value * high_value)
        )
    if all(shift_factor == 1.0 for shift_factor in shift_factors.values()):
        return input_range
    low_values, high_values = (
        {key: shift_factors[key] * value for key, value in end_values.items()}
        for end_values in (input_range.low_values, input_range.high_values)
    )
    low_value, high_value = min(low_values.values()), max(high_values.values())
    return replace(input_range, low=low_value, high=high_value, low_values=low_values, high_values=high_values)


def compute_parameters(reducer: Reducer) -> dict[str, float]:
    """Compute the parameters of one drive's joint, with the keys and units of `PARAMETERS`, e.g. ``backlash_arcmin``.

    They are backlash, no-load friction on the crank and, at nominal torque, torsional stiffness at the output,
    load-dependent loss and peak-to-peak transmission error. The no-load friction of an RV reducer with Coulomb friction
    is the drag of its seals, as statics does not include the weight of its parts.

    Raises
    ------
    RunError
        There is no static equilibrium.
    """
    rated_torque = reducer.design.rated_torque
    loaded_reducer = reducer.but(load={"torque": rated_torque}).working_at(rated_torque)
    values = {
        key: row.value(loaded_reducer) if row.applies_to(loaded_reducer) else _drag_of_seals(loaded_reducer)
        for key, row in ((key, figure(key)) for key in PARAMETERS if key != LOSS)
    }
    # as a share of the ideal torque on the crank; no-load friction is a separate parameter
    no_load_share = values[FRICTION] * reducer.design.reduction / rated_torque
    loss = 100.0 / figure("efficiency").value(loaded_reducer) - 1.0 - no_load_share
    return {key: 100.0 * loss if key == LOSS else values[key] for key in PARAMETERS}


def _drag_of_seals(reducer: Reducer) -> float:
    """Return the drag of the seals of both shafts, seen from the driven shaft [N m]."""
    drag = reducer.design.drag
    return drag.crank + drag.output / reducer.design.reduction


def _draw_drive(
    reducer: Reducer, ranges: tuple[Input, ...], seed: int, number: int
) -> tuple[dict[str, float], dict[str, float]] | None:
    """Draw a drive of a population: random errors within the tolerances, and inputs within their ranges.

    Inputs have a log-uniform distribution within their ranges.

    Parameters
    ----------
    reducer, ranges
        Nominal reducer, and ranges of its assumed inputs.
    seed, number
        Random seed, and number of the drive.

    Returns
    -------
    tuple of dict or None
        Parameters of the joint (`PARAMETERS`), and drawn values, each by key; None if the drive cannot be assembled or
        has no equilibrium.
    """
    uniform_numbers = np.random.default_rng([seed, INPUT_STREAM, number]).random(len(ranges)).tolist()
    changes: dict[str, dict[str, float]] = {}
    for input_range, position in zip(ranges, uniform_numbers, strict=True):
        changes.setdefault(input_range.table, {}).update(input_range.between(position))
    try:
        design, drawn_deviations = DRAWS[reducer.LAYOUT].draw(reducer, seed, number)
        values = compute_parameters(type(reducer)(design).but(**changes))
    except CycloidError:
        return None
    drawn_inputs = {
        f"drawn_{table}_{key}": value for table, table_values in changes.items() for key, value in table_values.items()
    }
    return values, {**drawn_inputs, **drawn_deviations}


def _draw_central_drive(reducer: Reducer, seed: int, number: int) -> tuple[Design, dict[str, float]]:
    """Draw a random drive with a central crank within its tolerances: its design, and the errors of its parts by name.

    Equal seeds and numbers draw equal drives; the errors are in the unit that ends their names.
    """
    zones, (block, row) = sampling.tolerance_zones(reducer), divmod(number, sampling.SAMPLING.block)
    batch = sampling.Batch(block, 1, row)
    samples = sampling.draw_samples(reducer, zones, seed, batch)
    deviations = sampling.deviation_columns(sampling.draw_deviations(reducer, zones, seed, batch))
    design = sampling.design_of_sample(reducer, samples, 0, reducer.design.name)
    return design, {key: float(values[0]) for key, values in deviations.items()}


class Draw(NamedTuple):
    """Functions of a layout: its nonzero tolerances by key, and a drive drawn with a seed and its number."""

    zones: Callable[[Any], Mapping[str, Zone]]
    draw: Callable[[Any, int, int], tuple[Design, dict[str, float]]]


DRAWS: Mapping[Layout, Draw] = {
    "central": Draw(sampling.tolerance_zones, _draw_central_drive),
    "rv": Draw(crank_zones, draw_rv_drive),
}
"""Random drives of each layout."""
