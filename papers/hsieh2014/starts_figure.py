"""Figure of independent starts without load: one mark per start, pin next to nonpin, for varied parameters."""

from collections.abc import Mapping, Sequence

from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

from cycloid_mj.comparison import StartSpread
from cycloid_mj.plots.comparison import COLORS
from cycloid_mj.plots.style import WIDTH, NotebookFigure, legend_handles, with_style
from hsieh2014.ranking import Ranked

TICKS = 6
"""Maximum number of ticks on an axis."""


@with_style
def starts_figure(cases: Mapping[str, Mapping[str, Mapping[str, StartSpread]]], quantities: Sequence[Ranked]) -> Figure:
    """Draw each quantity in a panel, from the top: cases side by side, one mark per start and design.

    `cases` are the starts by the name of the case, the key of the quantity and the name of the design.
    """
    figure = NotebookFigure(figsize=(WIDTH, 1.3 * len(quantities) + 1.4), layout="constrained")
    panels = figure.subplots(len(quantities), 1, sharex=True, squeeze=False)[:, 0]
    names = list(next(iter(next(iter(cases.values())).values())))
    for panel, quantity in zip(panels, quantities, strict=True):
        for place, case in enumerate(cases.values()):
            for number, name in enumerate(names):
                values = case[quantity.key][name].values
                x = place + 0.15 * (2 * number - len(names) + 1)
                look = {"color": COLORS[number], "markersize": 3.0, "alpha": 0.7, "linestyle": ""}
                panel.plot([x] * len(values), values, marker="o", **look)
        if any(
            value > 0.0 for each in cases.values() for start in each[quantity.key].values() for value in start.values
        ):
            panel.set_yscale("log")
            panel.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0), numticks=TICKS))
            panel.yaxis.set_minor_locator(NullLocator())
            panel.yaxis.set_major_formatter("{x:g}")
        panel.set_title(quantity.name)
        panel.set_ylabel(f"rms [{quantity.unit}]")
    panels[-1].set_xlim(-0.5, len(cases) - 0.5)
    panels[-1].set_xticks(range(len(cases)), list(cases), rotation=45, ha="right")
    looks = [(name, {"color": COLORS[number], "marker": "o", "linestyle": ""}) for number, name in enumerate(names)]
    figure.legend(handles=legend_handles(*looks), loc="outside lower center", ncols=len(names))
    return figure
