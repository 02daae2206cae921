"""A comparison as rows of text, for people: one table for each load, one column for each design."""

from cycloid_mj.comparison.comparison import Comparison
from cycloid_mj.comparison.rows import ROWS
from cycloid_mj.comparison.starts import Spread


def table(comparison: Comparison, load: float) -> tuple[list[str], list[list[str]]]:
    """Give header and rows: quantity, one column for each design, unit; a row without any value is left out.

    A figure of several starts is given as least to largest, and the mean.
    """
    trials = comparison.at(load)
    rows = []
    for words, unit, measured in ROWS:
        found = [trial.over_starts(measured) for trial in trials]
        if any(spread is not None for spread in found):
            rows.append([words, *("" if spread is None else _words(spread) for spread in found), unit])
    return ["quantity", *(trial.name for trial in trials), "unit"], rows


def _words(found: Spread) -> str:
    return f"{found.mean:.4g}" if len(found.values) == 1 else f"{found.words} ({found.mean:.3g})"
