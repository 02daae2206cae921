"""Figures to lay beside the paper's: nothing is cut at a frame, axes can be read, parts stand one by one."""

import numpy as np
import pytest
from hsieh2014.paper_figures import cam_figure, heights_figure, picture_figure, torques_figure
from hsieh2014.ranking import RANKED
from hsieh2014.starts_figure import TICKS, starts_figure

from cycloid_mj.comparison import StartSpread


def drawn(figure):
    """The figure as it is saved: its layout and ticks are done."""
    figure.canvas.draw()
    return figure


@pytest.mark.parametrize("first", [0.0, 2.0])
def test_the_stress_curve_covers_a_turn_within_its_frame(first):
    degrees = first + np.arange(0.0, 360.0, 9.0)
    curves = {
        f"{design}, {law}": (degrees, size * (2.0 + np.cos(np.radians(degrees))))
        for design, size in (("pin", 0.1), ("nonpin", 0.05))
        for law in ("line contacts", "IMPACT")
    }
    figure = drawn(heights_figure(curves, {"pin": 160.0, "nonpin": 60.0}, (75.0, 255.0)))
    (axes,) = figure.axes
    low, high = axes.get_ylim()
    assert axes.get_xlim() == (0.0, 360.0)
    for line in axes.lines[: len(curves)]:
        x, y = line.get_data()
        begin, end = np.interp([0.0, 360.0], x, y)
        assert x[0] <= 0.0
        assert x[-1] >= 360.0
        assert begin == pytest.approx(end)
        assert low < y.min() < y.max() < high
    # a column for each design, with both laws, and one for the paper
    (legend,) = figure.legends
    assert legend._ncols == 3


@pytest.mark.parametrize("size", [1e-3, 70.0])
def test_the_spread_of_starts_fits_on_axes_with_few_numbers(size):
    values = StartSpread.of(size * np.geomspace(1.0, 30.0, 12))
    cases = {
        name: {one.key: {"pin": values, "nonpin": values} for one in RANKED} for name in ("as it is", "pins fixed")
    }
    figure = drawn(starts_figure(cases, RANKED))
    for panel in figure.axes:
        low, high = panel.get_ylim()
        numbers = [tick.get_text() for tick in panel.get_yticklabels() if low <= tick.get_position()[1] <= high]
        assert 2 <= len(numbers) <= TICKS
        assert len(set(numbers)) == len(numbers)
        assert not [tick.get_text() for tick in panel.get_yticklabels(minor=True) if tick.get_text()]
        for line in panel.lines:
            assert all(low < value < high for value in line.get_ydata())


def test_the_cam_force_fits_in_both_panels():
    curves = {"pin, neither": np.full(36, 4.0), "nonpin, neither": np.full(36, 9.0), "nonpin, soft": np.full(36, 3.0)}
    curves["pin, soft"] = np.full(36, 2.0)
    panels = drawn(cam_figure(curves, (75.0, 255.0))).axes
    for panel in panels:
        low, high = panel.get_ylim()
        assert all(low <= line.get_ydata().min() < line.get_ydata().max() + 0.1 < high for line in panel.lines[:2])
    assert panels[0].get_ylim() == panels[1].get_ylim()


def test_our_and_the_papers_torques_share_a_panel():
    ours = {"pin": {"line contacts": 32.4, "IMPACT": 30.6}, "nonpin": {"line contacts": 31.7, "IMPACT": 30.2}}
    stated = {"pin": {"the paper": 34.7}, "nonpin": {"the paper": 35.8}}
    panels = drawn(torques_figure(ours, stated, 36.68)).axes
    assert [panel.get_title(loc="left") for panel in panels] == ["pin", "nonpin"]
    for panel, torques, paper in zip(panels, ours.values(), stated.values(), strict=True):
        bars = panel.patches
        assert [bar.get_width() for bar in bars] == [*torques.values(), *paper.values()]
        assert bars[0].get_facecolor() == bars[1].get_facecolor() != bars[2].get_facecolor()
        assert panel.get_xlim()[1] > 36.68


def test_pictures_are_shown_three_to_a_row_under_their_names():
    picture = np.zeros((8, 8, 3), dtype=np.uint8)
    names = ("shaft", "gear", "ring", "pins", "output")
    figure = drawn(picture_figure(dict.fromkeys(names, picture)))
    shown = [panel for panel in figure.axes if panel.images]
    assert [panel.get_title(loc="left") or panel.get_title() for panel in shown] == list(names)
    assert len({round(panel.get_position().y0, 3) for panel in shown}) == 2
