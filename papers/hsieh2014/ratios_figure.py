"""Figure of the ratio of pin to nonpin, with parameters varied one at a time."""

import math
from collections.abc import Mapping, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from cycloid_mj.plots import style
from hsieh2014.decisions import Varied
from hsieh2014.ranking import Ranking

MARKS = ((style.BLUE, "o"), (style.VERMILION, "s"), (style.GREEN, "D"), (style.PURPLE, "^"), (style.ORANGE, "v"))


@style.with_style
def ratios_figure(conditions: Mapping[float, str], ranked: Sequence[Ranking], sweep: Sequence[Varied]) -> Figure:
    """Draw the ratio of the first pin design's fluctuations to the first nonpin design's, for each variation.

    `conditions` maps each load [N m] to the title of its panel.
    """
    figure = style.create_figure(3.6)
    loads = sorted(conditions)
    panels = figure.subplots(1, len(loads), sharey=True, squeeze=False)[0]
    first = ranked[0]
    points: list[tuple[str, Sequence[Ranking]]] = [("as it is", ranked)]
    points += [(f"{point.parameter} {point.value}", point.rankings) for point in sweep]
    names = list(dict.fromkeys(ranking.quantity for ranking in ranked))
    for panel, load in zip(panels, loads, strict=True):
        for column, (_, rankings) in enumerate(points):
            chosen = [r for r in rankings if (r.pin, r.nonpin, r.load_nm) == (first.pin, first.nonpin, load)]
            _mark(panel, column, chosen, names)
        panel.axhline(1.0, color=style.BLACK, linewidth=0.6)
        panel.axvline(0.5, color=style.GREY, linewidth=0.6, linestyle=":")
        panel.set_yscale("log")
        panel.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        panel.yaxis.set_minor_formatter(FuncFormatter(_few))
        panel.set_xlim(-0.6, len(points) - 0.4)
        panel.set_xticks(range(len(points)), [words for words, _ in points], rotation=60, ha="right")
        panel.set_title(conditions[load])
    panels[0].set_ylabel(f"rms of {first.pin} / rms of {first.nonpin}")
    looks = [
        (name, {"color": color, "marker": mark, "linestyle": "none", "markersize": 4.5})
        for name, (color, mark) in zip(names, MARKS, strict=False)
    ]
    figure.legend(handles=style.legend_handles(*looks), loc="outside lower center", ncols=3, handlelength=1.0)
    return figure


def _mark(panel: Axes, column: int, rankings: Sequence[Ranking], names: Sequence[str]) -> None:
    for ranking in rankings:
        color, mark = MARKS[names.index(ranking.quantity)]
        beside = 0.1 * (names.index(ranking.quantity) - 2)
        if math.isfinite(ranking.ratio):
            panel.plot(column + beside, ranking.ratio, marker=mark, color=color, markersize=4.0)


def _few(value: float, _: object) -> str:
    """Label the 2 and the 5 of each decade."""
    digit = round(value / 10 ** math.floor(math.log10(value)))
    return f"{value:g}" if digit in (2, 5) else ""
