"""The record of a run: the output of a simulation and the input of an analysis.

This module owns `Run`, time with named columns, their units and where they come from. It knows neither how a run is
computed nor how it is stored.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from functools import cache
from html import escape
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.errors import LogError
from cycloid_mj.base.frame import Frame
from cycloid_mj.base.names import CRANK, FORCE_X, FORCE_Y, REDUCER, SUN, column, kind_of
from cycloid_mj.base.notebook_display import Presented

LARGEST = 1e30
"""No quantity of a reducer comes near, in SI units; double precision still holds its square, and single itself."""


class Deferred(Mapping[str, bytes]):
    """Files by name whose contents are computed when they are first read."""

    def __init__(self, makers: Mapping[str, Callable[[], bytes]]) -> None:
        self._made = {name: cache(content) for name, content in makers.items()}

    def __getitem__(self, name: str) -> bytes:
        """Return the content of a file."""
        return self._made[name]()

    def __iter__(self) -> Iterator[str]:
        """Go through the names."""
        return iter(self._made)

    def __len__(self) -> int:
        """Count the files."""
        return len(self._made)


@dataclass(frozen=True, eq=False)
class Run(Presented):
    """Samples of a simulated reducer.

    Arrays are locked: they are copied unless they are locked already and own their memory.

    Attributes
    ----------
    time
        Shape (n,), [s], finite and strictly increasing.
    columns
        Name -> values, shape (n,), in the unit given in `units`. Any float is allowed, NaN included.
    units
        Name -> unit: "rad", "rad/s", "N", "N m", "m", "1", ...; one for every column.
    provenance
        Flat text about the run: versions, seed, solver; ``warnings``, a line each.
    attachments
        File name -> content, such as ``design.toml`` and ``model.xml``.
    complete
        Whether the run reached its end.
    note
        Why it did not; "" if it did.
    topics
        Topic -> names of its columns, as a log has them in groups; every column is in one of them. Columns that are in
        none, as of a run without topics, join the first, or ``/reducer``.
    source
        Path of the log that the run was read from; "" for a run in memory.

    Raises
    ------
    LogError
        Lengths differ, time does not increase, or columns, units and topics do not have the same names.
    """

    time: Array
    columns: Mapping[str, Array]
    units: Mapping[str, str]
    provenance: Mapping[str, str] = field(default_factory=dict)
    attachments: Mapping[str, bytes] = field(default_factory=dict)
    complete: bool = True
    note: str = ""
    topics: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    source: str = ""

    def __post_init__(self) -> None:
        """Make arrays and mappings read-only; raise LogError for invalid times, columns, units or topics."""
        columns = {name: _lock_array(values) for name, values in self.columns.items()}
        object.__setattr__(self, "time", _lock_array(self.time))
        object.__setattr__(self, "columns", MappingProxyType(columns))
        for name in ("units", "provenance", "attachments"):
            value = getattr(self, name)
            object.__setattr__(self, name, value if isinstance(value, Deferred) else MappingProxyType(dict(value)))
        _check_time(self.time)
        _check_columns(self.time.size, self.columns, self.units)
        object.__setattr__(self, "topics", MappingProxyType(_complete_topics(self.topics, self.columns)))

    @property
    def driven_shaft(self) -> str:
        """Stem of the columns of the driven shaft: the crank, or the sun of an RV reducer."""
        return SUN if column(SUN, "torque") in self.columns else CRANK

    @property
    def frame(self) -> Frame:
        """Its samples, a row each, the time first."""
        return Frame({"time": self.time, **self.columns}, {"time": "s", **self.units})

    @property
    def label(self) -> str:
        """The run in a message: its log, if it was read from one."""
        return f"log {self.source}" if self.source else "the run"

    @property
    def warnings(self) -> tuple[str, ...]:
        """Why the quantities of this run may not be those of its design, as far as was known before it began."""
        return tuple(self.provenance.get("warnings", "").splitlines())

    def __len__(self) -> int:
        """Return the number of samples n."""
        return self.time.size

    def __getitem__(self, name: str) -> Array:
        """Return the column `name`, shape (n,); raise LogError if there is none."""
        if name not in self.columns:
            raise LogError(f"{self.label} has no column {name!r}; {_nearest_columns(name, list(self.columns))}")
        return self.columns[name]

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle a run with dicts: a mapping proxy cannot be pickled."""
        mappings = (dict(m) for m in (self.columns, self.units, self.provenance, self.attachments))
        return Run, (self.time, *mappings, self.complete, self.note, dict(self.topics), self.source)

    def __repr__(self) -> str:
        """Describe the run in one line."""
        return f"Run({', '.join(f'{key} {value}' for key, value in self._key_facts())})"

    def _repr_html_(self) -> str:
        """Describe the run in a table, for a notebook."""
        rows = "".join(f"<tr><th>{escape(key)}</th><td>{escape(value)}</td></tr>" for key, value in self._key_facts())
        return f"<table>{rows}</table>"

    def _key_facts(self) -> tuple[tuple[str, str], ...]:
        """Return name and text of the main properties of a run: such as "samples" and the number of samples."""
        completeness = "yes" if self.complete else f"no: {self.note or 'no reason given'}"
        time_range = f"{self.time[0]:g} to {self.time[-1]:g} s" if len(self) else "none"
        return (
            ("samples", str(len(self))),
            ("columns", str(len(self.columns))),
            ("time", time_range),
            ("attachments", ", ".join(self.attachments) or "none"),
            ("complete", completeness),
        )

    @property
    def groups(self) -> dict[str, dict[str, str]]:
        """Topic -> its columns with their units, as a log is written."""
        return {topic: {name: self.units[name] for name in names} for topic, names in self.topics.items()}

    def block(self, names: Sequence[str]) -> Array:
        """Stack the k columns `names` side by side, shape (n, k); raise LogError if one is unknown."""
        block = np.empty((len(self), len(names)))
        for k, name in enumerate(names):
            block[:, k] = self[name]
        return block

    def by_stem(self, quantity: str) -> dict[str, Array]:
        """Return a quantity of `names.column` by the parts or pairs that have it, e.g. `names.PEAK_FORCE` by pair."""
        end = column("", quantity)
        return {name.removesuffix(end): values for name, values in self.columns.items() if name.endswith(end)}

    def pairs(self, kind: str) -> tuple[str, ...]:
        """Name the mating pairs of a kind that the run has forces of, in their order."""
        return tuple(pair for pair in self.by_stem(FORCE_X) if kind_of(pair) == kind)

    def forces(self, kind: str) -> Array:
        """Return the contact forces [N], x and y, of the k mating pairs of a kind at n samples, shape (n, k, 2).

        They act on the disc; for a pin and its seat on the pin, for a planet and the sun on the sun.

        Raises
        ------
        LogError
            The run has no forces of this kind.
        """
        pairs = self.pairs(kind)
        if not pairs:
            logged_kinds = sorted({str(kind_of(pair)) for pair in self.by_stem(FORCE_X)})
            raise LogError(
                f"{self.label} has no contact forces of kind {kind!r}; the kinds in this log are: "
                f"{', '.join(logged_kinds) or 'none'}. Run `cycloid-mj simulate` again with the same design: it logs "
                "all contact forces"
            )
        force_columns = [column(pair, force_stem) for pair in pairs for force_stem in (FORCE_X, FORCE_Y)]
        return self.block(force_columns).reshape(len(self), len(pairs), 2)

    def usable(self) -> "Run":
        """Return the run with NaN for every value that no reducer can have; see `usable`."""
        return replace(self, columns={name: usable(values) for name, values in self.columns.items()})

    def of_topic(self, topic: str) -> "Run":
        """Return a run with the columns of one topic only, a group of columns in the log; raise LogError without it."""
        if topic not in self.topics:
            remedy = f"choose one of {', '.join(self.topics)}" if self.topics else "simulate the design again"
            raise LogError(f"{self.label} has no {'' if self.topics else 'columns, and no '}topic {topic!r}: {remedy}")
        column_names = self.topics[topic]
        columns = {name: self.columns[name] for name in column_names}
        return replace(
            self, columns=columns, units={name: self.units[name] for name in column_names}, topics={topic: column_names}
        )

    def select(self, rows: Mask | slice) -> "Run":
        """Return a run with only some of its samples.

        `rows` is a mask of the n samples, shape (n,), or a slice with a positive step. Raise LogError for another
        array.
        """
        if not isinstance(rows, slice) and (rows.dtype != np.bool_ or rows.shape != self.time.shape):
            raise LogError(
                f"cannot select samples of {self.label} by an array of type {rows.dtype} and shape {rows.shape}: use a "
                f"slice, or a mask of type bool and shape {self.time.shape}"
            )
        columns = {name: own(column[rows]) for name, column in self.columns.items()}
        return replace(self, time=own(self.time[rows]), columns=columns)


def usable(values: Array) -> Array:
    """Replace values that are infinite or beyond `LARGEST` by NaN, with which one can compute; any shape."""
    is_usable = np.abs(values) <= LARGEST
    return values if is_usable.all() else np.where(is_usable, values, np.nan)


def _lock_array(values: npt.ArrayLike) -> Array:
    array = np.asarray(values, dtype=np.float64)
    return own(array.copy()) if array.flags.writeable or array.base is not None else array


def own(array: Array) -> Array:
    """Make an array read-only that nothing else writes to, so that a `Run` uses it without a copy."""
    array.flags.writeable = False
    return array


def _check_time(time: Array) -> None:
    """Raise LogError unless the n sample times of a run [s] are finite, strictly increasing and of shape (n,)."""
    if time.ndim != 1:
        raise LogError(
            f"the times of the run have shape {time.shape}: pass a 1-D array of shape (n,) with one time per sample"
        )
    if not np.isfinite(time).all():
        sample = int(np.argmin(np.isfinite(time)))
        raise LogError(
            f"array of times: sample {sample} (counting from 0) is {time[sample]} s, but all times must be finite. "
            "Correct or remove this sample"
        )
    backward_steps = np.flatnonzero(np.diff(time) <= 0.0)
    if backward_steps.size:
        previous_sample = int(backward_steps[0])
        raise LogError(
            f"the times of the run do not increase at sample {previous_sample + 1}: {time[previous_sample]!s} s is "
            f"followed by {time[previous_sample + 1]!s} s. Times must be strictly increasing; sort the samples and "
            "remove repeated times"
        )


def _check_columns(samples: int, columns: Mapping[str, Array], units: Mapping[str, str]) -> None:
    """Raise LogError unless every column of a run has shape (samples,) and a unit."""
    for name, values in columns.items():
        if values.shape != (samples,):
            raise LogError(
                f"column {name!r} has shape {values.shape}: pass an array of shape ({samples},), one value per time"
            )
        if name not in units:
            raise LogError(
                f"column {name!r} has no unit: add its unit to the argument `units` ('1' for a dimensionless column)"
            )
    if unused_units := [name for name in units if name not in columns]:
        raise LogError(
            f"the argument `units` has the key {unused_units[0]!r}, but the log has no such column. Remove the key or "
            f"correct its name; {_nearest_columns(unused_units[0], list(columns))}"
        )


def _complete_topics(topics: Mapping[str, Sequence[str]], columns: Mapping[str, Array]) -> dict[str, tuple[str, ...]]:
    """Return the column names of each topic, a group of columns; columns without a topic are added to the first.

    Raise LogError for a name that is no column, or that is listed twice.
    """
    names_by_topic = {topic: tuple(names) for topic, names in topics.items()}
    listed_columns = [name for names in names_by_topic.values() for name in names]
    if unknown_columns := [name for name in listed_columns if name not in columns]:
        raise LogError(
            f"the argument `topics` lists {unknown_columns[0]!r}, but the log has no such column. Remove it or correct "
            f"its name; {_nearest_columns(unknown_columns[0], list(columns))}"
        )
    if len(set(listed_columns)) < len(listed_columns):
        repeated_column = next(name for name in listed_columns if listed_columns.count(name) > 1)
        raise LogError(
            f"the argument `topics` lists the column {repeated_column!r} twice: list each column under one topic only"
        )
    if unlisted_columns := tuple(name for name in columns if name not in set(listed_columns)):
        first_topic = next(iter(names_by_topic), REDUCER)
        names_by_topic[first_topic] = (*names_by_topic.get(first_topic, ()), *unlisted_columns)
    return names_by_topic


def _nearest_columns(name: str, column_names: list[str]) -> str:
    """Return up to three columns with similar names, else the first columns, in words, for an error message."""
    if similar := get_close_matches(name, column_names, n=3):
        return f"columns with similar names: {', '.join(similar)}"
    ellipsis = ", ..." if len(column_names) > 3 else ""
    return f"its columns are {', '.join(column_names[:3])}{ellipsis}" if column_names else "the run has no columns"
