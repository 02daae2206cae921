"""Figures of a tolerance study: a panel for each figure and no others, and words where there is nothing to draw."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cycloid_mj.figures import SAMPLED
from cycloid_mj.plots.tolerance import distributions_figure


def study(**changed: Any) -> Any:
    rng = np.random.default_rng(3)
    figures = {key: rng.normal(10.0, 1.0, 64) for key in SAMPLED} | changed
    return SimpleNamespace(design="pin", samples=64, seed=0, limits=(), jams=np.zeros(64, bool), figures=figures)


@pytest.mark.parametrize("count", [1, 2, 3, 11])
def test_every_panel_of_the_distributions_shows_a_figure(count: int) -> None:
    few = study()
    few.figures = dict(list(few.figures.items())[:count])
    panels = distributions_figure(few).axes
    assert len(panels) == count
    assert all(axes.patches for axes in panels)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        (np.full(64, 2.5), "constant: 2.5"),
        (2.5 + 1e-13 * np.arange(64), "constant: 2.5"),
        (np.zeros(64), "constant: 0"),
        (np.full(64, np.nan), "no value"),
    ],
)
def test_a_figure_that_does_not_vary_is_stated_in_words(values: np.ndarray, words: str) -> None:
    figure = distributions_figure(study(backlash_arcmin=values))
    axes = figure.axes[list(SAMPLED).index("backlash_arcmin")]
    assert not axes.patches
    assert [text.get_text() for text in axes.texts] == [words]


def test_values_that_are_not_numbers_are_left_out() -> None:
    values = np.linspace(1.0, 2.0, 64)
    values[::2] = np.nan
    figure = distributions_figure(study(backlash_arcmin=values))
    counted = sum(patch.get_height() for patch in figure.axes[0].patches)
    assert counted >= 30
