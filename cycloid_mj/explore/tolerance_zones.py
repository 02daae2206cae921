"""Tolerances of a reducer of any layout that a study can vary."""

from collections.abc import Callable, Mapping
from typing import cast

from cycloid_mj.design.layouts import Layout
from cycloid_mj.design.zone import Zone
from cycloid_mj.explore.rv_samples import crank_zones
from cycloid_mj.explore.sampling import tolerance_zones
from cycloid_mj.reducer import Reducer, RvReducer

ZONES: Mapping[Layout, Callable[[Reducer], Mapping[str, Zone]]] = {
    "central": tolerance_zones,
    "rv": lambda reducer: crank_zones(cast(RvReducer, reducer)),
}
"""Function of each layout that returns the nonzero tolerances of a reducer, by key."""


def has_tolerances(reducer: Reducer) -> bool:
    """Return whether a design has tolerances that a study can vary."""
    return bool(ZONES[reducer.LAYOUT](reducer))
