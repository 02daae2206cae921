"""The figures of the measures: nothing hidden, nothing made to look more than it is."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from cycloid_mj.base.result import Curve
from cycloid_mj.design import PRESETS
from cycloid_mj.measure import Measurement
from cycloid_mj.plots.measure import PANEL, measurement_figure

X = np.linspace(0.0, 360.0, 37)


def drawn(*curves: Curve, condition: str = "") -> Figure:
    return measurement_figure(Measurement("te", PRESETS["pin"], {}, curves, condition=condition))


def curve(y, name="one", style="line", x=X, of="") -> Curve:
    return Curve("panel", name, np.asarray(x, float), np.asarray(y, float), "crank angle [deg]", "y [N]", style, of)


def test_a_ripple_of_a_percent_looks_like_one():
    for style in ("line", "points"):
        axes = drawn(curve(100.0 + 0.3 * np.sin(X), style=style)).axes[0]
        low, high = axes.get_ylim()
        assert high - low >= PANEL.min_span * 100.0
        assert low < 99.0 < 101.0 < high


def test_positive_curves_start_at_zero_and_signed_curves_are_shown_completely():
    low, high = drawn(curve(np.linspace(1.0, 10.0, 37))).axes[0].get_ylim()
    assert low == 0.0
    assert high > 10.0
    low, high = drawn(curve(3.0 * np.sin(np.radians(X)))).axes[0].get_ylim()
    assert low < -3.0
    assert high > 3.0


def test_an_axis_of_zeros_or_of_no_numbers_is_drawn():
    drawn(curve(np.zeros(37)), curve(np.full(37, np.nan), "two")).canvas.draw()


def test_bars_of_two_cases_are_side_by_side_within_the_panel():
    figure = drawn(curve([5.0, 4.0], "a", "bars", [1.0, 2.0]), curve([3.0, 4.0], "b", "bars", [1.0, 2.0]))
    figure.canvas.draw()
    axes = figure.axes[0]
    places = []
    for bars in axes.collections:
        x = bars.get_segments()[0][0][0]
        left = bars.get_transform().transform((x, 0.0))[0]
        places.append((left, bars.get_linewidth()[0] * figure.dpi / 72.0))
    (one, width), (other, _) = places
    assert abs(other - one) >= width
    assert axes.get_xlim()[1] > 2.0
    assert axes.get_ylim()[1] > 5.0


def test_many_bars_are_drawn_thinner():
    few, many = (
        drawn(curve(np.ones(n), "a", "bars", np.arange(1.0, n + 1.0))).axes[0].collections[0].get_linewidth()[0]
        for n in (10, 400)
    )
    assert many < 0.6 * few


def test_each_theory_has_the_colour_of_its_own_curve_and_all_have_one_key():
    curves = [curve(np.sin(X + k), "statics", "theory", of=name) for k, name in enumerate("abcd")]
    curves += [curve(np.sin(X + k), name) for k, name in enumerate("abcd")]
    axes = drawn(*curves).axes[0]
    broad = [line for line in axes.lines if line.get_linewidth() > 2.0 and len(line.get_xdata())]
    thin = {line.get_label(): to_hex(line.get_color()) for line in axes.lines if line.get_linewidth() < 2.0}
    assert [to_hex(line.get_color()) for line in broad] == [thin[name] for name in "abcd"]
    assert len({to_hex(line.get_color()) for line in broad}) == 4
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["statics", *"abcd"]


def test_points_that_coincide_show_round_each_other():
    axes = drawn(*(curve([1.0, 2.0], name, "points", [0.0, 90.0]) for name in "abc")).axes[0]
    sizes = [line.get_markersize() for line in axes.lines]
    assert sizes == sorted(sizes, reverse=True)
    assert min(-np.diff(sizes)) > 1.0


def test_points_at_one_place_are_shown_from_zero():
    axes = drawn(curve([1.0], x=[1640.0], style="points")).axes[0]
    assert axes.get_xlim()[0] == 0.0
    assert axes.get_xlim()[1] > 1640.0


@pytest.mark.parametrize("count", [2, 36, 100])
def test_contacts_round_a_ring_are_marked_where_they_can_be_distinguished(count):
    about = 360.0 / count * np.arange(count + 1)
    axes = drawn(replace(curve(np.ones(count + 1), "simulated", "polar", about), x_label="")).axes[0]
    assert (axes.lines[0].get_marker() == "o") == (count < PANEL.max_markers)
    assert (axes.lines[0].get_linestyle() == "None") == (count < PANEL.max_markers)
    assert axes.get_rmin() == 0.0


def test_the_condition_is_the_title_of_the_figure():
    assert drawn(curve(X), condition="36.7 N m, 1640 rpm").get_suptitle() == "te: pin, 36.7 N m, 1640 rpm"
