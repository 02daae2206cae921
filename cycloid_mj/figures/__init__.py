"""The catalogue of figures: every number of a reducer that commands print, optimize or limit, by its key.

A row (`Figure`) has key, name, unit, definition, what it needs, and a function of a `Reducer`; a new figure is a
function and a row, and every command has it. The figures of upper layers are in `cycloid_mj.upper_figures`.
"""

from cycloid_mj.figures.catalogue import (
    CHEAP,
    COMPUTED,
    FIGURES,
    SAMPLED,
    compute,
    compute_sampled,
    figure,
    figures_of,
    find_figure,
    of_measure,
    quantities,
    quantity,
    values_json,
)
from cycloid_mj.figures.figure import Figure, Need

__all__ = [
    "CHEAP",
    "COMPUTED",
    "FIGURES",
    "SAMPLED",
    "Figure",
    "Need",
    "compute",
    "compute_sampled",
    "figure",
    "figures_of",
    "find_figure",
    "of_measure",
    "quantities",
    "quantity",
    "values_json",
]
