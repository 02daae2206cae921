"""The record of a run: what a simulation gives and an analysis takes.

This module owns `Run`, time with named columns, their units and where they come from. It knows neither how a run is
computed nor how it is stored.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from html import escape
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from cycloid_mj.errors import LogError
from cycloid_mj.types import Array, Mask

LARGEST = 1e30
"""No quantity of a reducer comes near, in SI units; double precision still holds its square, and single itself."""


@dataclass(frozen=True, eq=False)
class Run:
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

    Raises
    ------
    LogError
        Lengths differ, time does not increase, or columns and units do not have the same names.
    """

    time: Array
    columns: Mapping[str, Array]
    units: Mapping[str, str]
    provenance: Mapping[str, str] = field(default_factory=dict)
    attachments: Mapping[str, bytes] = field(default_factory=dict)
    complete: bool = True
    note: str = ""

    def __post_init__(self) -> None:
        columns = {name: _locked(values) for name, values in self.columns.items()}
        object.__setattr__(self, "time", _locked(self.time))
        object.__setattr__(self, "columns", MappingProxyType(columns))
        for name in ("units", "provenance", "attachments"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))
        _check_time(self.time)
        _check_columns(self.time.size, self.columns, self.units)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Why the figures of this run may not be those of its design, as far as was known before it began."""
        return tuple(self.provenance.get("warnings", "").splitlines())

    def __len__(self) -> int:
        """Give the number of samples n."""
        return self.time.size

    def __getitem__(self, name: str) -> Array:
        """Give the column `name`, shape (n,); raise LogError if there is none."""
        if name not in self.columns:
            raise LogError(_unknown(name, list(self.columns)))
        return self.columns[name]

    def __reduce__(self) -> tuple[Any, ...]:
        """Let a run travel to other processes: a mapping proxy cannot be pickled, a dict can."""
        mappings = (dict(m) for m in (self.columns, self.units, self.provenance, self.attachments))
        return Run, (self.time, *mappings, self.complete, self.note)

    def __repr__(self) -> str:
        """Tell the run in one line; columns, units and attachments have their names in mappings."""
        return f"Run({', '.join(f'{key} {value}' for key, value in self._facts())})"

    def _repr_html_(self) -> str:
        """Tell the run as a table of a notebook."""
        rows = "".join(f"<tr><th>{escape(key)}</th><td>{escape(value)}</td></tr>" for key, value in self._facts())
        return f"<table>{rows}</table>"

    def _facts(self) -> tuple[tuple[str, str], ...]:
        end = "yes" if self.complete else f"no: {self.note or 'no reason given'}"
        time = f"{self.time[0]:g} to {self.time[-1]:g} s" if len(self) else "none"
        return (
            ("samples", str(len(self))),
            ("columns", str(len(self.columns))),
            ("time", time),
            ("attachments", ", ".join(self.attachments) or "none"),
            ("complete", end),
        )

    def block(self, names: Sequence[str]) -> Array:
        """Give the k columns `names` side by side, shape (n, k); raise LogError if one is unknown."""
        block = np.empty((len(self), len(names)))
        for k, name in enumerate(names):
            block[:, k] = self[name]
        return block

    def usable(self) -> "Run":
        """Give the run with NaN for every value that no reducer can have; see `usable`."""
        columns = {name: usable(values) for name, values in self.columns.items()}
        return Run(self.time, columns, self.units, self.provenance, self.attachments, self.complete, self.note)

    def select(self, rows: Mask | slice) -> "Run":
        """Give the run with only the samples `rows`: a mask of shape (n,) or a forward slice."""
        if not isinstance(rows, slice) and (rows.dtype != np.bool_ or rows.shape != self.time.shape):
            raise LogError(
                f"cannot select samples by an array of {rows.dtype}, shape {rows.shape}: "
                f"give a slice or a mask of bool, shape {self.time.shape}"
            )
        columns = {name: values[rows] for name, values in self.columns.items()}
        return Run(self.time[rows], columns, self.units, self.provenance, self.attachments, self.complete, self.note)


def usable(values: Array) -> Array:
    """Give values of any shape with NaN for those that are infinite or beyond `LARGEST`: one can compute with them."""
    sound = np.abs(values) <= LARGEST
    return values if sound.all() else np.where(sound, values, np.nan)


def _locked(values: npt.ArrayLike) -> Array:
    array = np.asarray(values, dtype=np.float64)
    if array.flags.writeable or array.base is not None:
        array = array.copy()
        array.flags.writeable = False
    return array


def _check_time(time: Array) -> None:
    if time.ndim != 1:
        raise LogError(f"time of a run has shape {time.shape}: give shape (n,)")
    if not np.isfinite(time).all():
        sample = int(np.argmin(np.isfinite(time)))
        raise LogError(f"time of a run is {time[sample]} s at sample {sample}: give finite times")
    backward = np.flatnonzero(np.diff(time) <= 0.0)
    if backward.size:
        before = int(backward[0])
        raise LogError(
            f"time of a run goes from {time[before]!s} s to {time[before + 1]!s} s "
            f"at sample {before + 1}: give strictly increasing times"
        )


def _check_columns(samples: int, columns: Mapping[str, Array], units: Mapping[str, str]) -> None:
    for name, values in columns.items():
        if values.shape != (samples,):
            raise LogError(
                f"column {name!r} has shape {values.shape}: give shape ({samples},), one value for each time"
            )
        if name not in units:
            raise LogError(f"column {name!r} has no unit: add it to units ('1' for a plain number)")
    if surplus := [name for name in units if name not in columns]:
        raise LogError(f"units has {surplus[0]!r}, which is no column: {_unknown(surplus[0], list(columns))}")


def _unknown(name: str, names: list[str]) -> str:
    nearest = get_close_matches(name, names, n=3) or names[:3]
    listed = ", ".join(nearest) if nearest else "none, the run has no columns"
    return f"no column {name!r} in this run of {len(names)}; nearest: {listed}"
