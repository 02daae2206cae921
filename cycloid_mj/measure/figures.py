"""Figures of the catalogue that a measure has: its runs are made once for all of them."""

from collections.abc import Mapping

from cycloid_mj.base.result import Quantity
from cycloid_mj.measure import MEASURES
from cycloid_mj.reducer import Reducer, once


@once
def _quantities(reducer: Reducer, measure: str) -> Mapping[str, Quantity]:
    return MEASURES[measure](reducer.design).quantities


def measured(reducer: Reducer, measure: str, quantity: str) -> float:
    """Measure a quantity of a design at the usual conditions of its measure, in the quantity's unit.

    Errors are those of the measure.
    """
    return _quantities(reducer, measure)[quantity].value
