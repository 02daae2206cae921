"""The charts of the documentation, drawn from the tables that its pages offer for download."""

import csv
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import docs_bench
import docs_results
import docs_validation
import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from cycloid_mj.plots.style import BLUE, GREEN, GREY, ORANGE, STYLE, VERMILION

DATA = Path(__file__).parent / "data"

WIDTH, FONT_SIZE = 6.5, 9.0
"""Width of a chart [in] and size of its text [pt]."""

ROW_HEIGHT = 0.27
"""Height of a bar with its label [in]."""

MIN_SHARE = 1e-3
"""Smallest share of the allowed error that a bar shows."""


def write(folder: Path) -> None:
    """Draw all charts into a folder, except those that are newer than their data."""
    folder.mkdir(exist_ok=True)
    for draw, data in CHARTS.items():
        path = folder / f"{draw.__name__}.svg"
        if not path.exists() or path.stat().st_mtime < data.stat().st_mtime:
            sizes = dict.fromkeys(("font.size", "axes.titlesize", "legend.fontsize"), FONT_SIZE)
            with rc_context(STYLE | sizes | {"svg.fonttype": "path"}):
                draw().savefig(path, metadata={"Date": None})


def validation() -> Figure:
    """Draw the worst error of each group of checks as a share of the allowed error."""
    groups = docs_validation.summaries(docs_validation.read_rows())[::-1]
    figure = Figure(figsize=(WIDTH, 0.6 + ROW_HEIGHT * len(groups)), layout="constrained")
    axes = figure.subplots()
    axes.barh(
        [f"{group.group.result}\n{group.group.reference}" for group in groups],
        [100.0 * max(group.share, MIN_SHARE) for group in groups],
        color=BLUE,
    )
    axes.tick_params(axis="y", labelsize=0.62 * FONT_SIZE)
    axes.set(xlabel="largest error, share of the allowed error [%]", xlim=(0.0, 100.0))
    axes.grid(False, axis="y")
    return figure


def solvers() -> Figure:
    """Draw the difference of the two solvers in the mean transmission error, by layout, speed and load."""
    rows = [row for row in _read("solvers") if row["settings"] == "chosen" and not row["stopped"]]
    layouts = list(dict.fromkeys(row["layout"] for row in rows))[::-1]
    figure = Figure(figsize=(WIDTH, 0.9 + ROW_HEIGHT * len(layouts)), layout="constrained")
    axes = figure.subplots()
    for speed, color in (("1640", BLUE), ("12000", VERMILION)):
        for light, marker in ((False, "o"), (True, "x")):
            chosen = [row for row in rows if row["speed_rpm"] == speed and (float(row["load_percent"]) < 10.0) == light]
            axes.plot(
                [abs(float(row["mean_error"])) for row in chosen],
                [layouts.index(row["layout"]) for row in chosen],
                marker,
                color=color,
                markersize=4.5,
                label=f"{speed} rpm, {'3 %' if light else '30 and 100 %'} load",
            )
    axes.set_yticks(range(len(layouts)), layouts)
    axes.set(xscale="log", xlabel="difference of the mean transmission error [%]", xlim=(1e-7, 10.0))
    axes.legend(loc="upper left", fontsize=0.8 * FONT_SIZE, ncols=2, bbox_to_anchor=(0.0, 1.0 + 2.2 / len(layouts)))
    return figure


def cost() -> Figure:
    """Draw the CPU time of a simulated second by both solvers."""
    rows = _read("cost")[::-1]
    place = np.arange(len(rows))
    figure = Figure(figsize=(WIDTH, 0.9 + 1.6 * ROW_HEIGHT * len(rows)), layout="constrained")
    axes = figure.subplots()
    for offset, key, label, color in (
        (0.2, "mujoco_cpu_s", "MuJoCo", GREY),
        (-0.2, "planar_cpu_s", "planar solver", BLUE),
    ):
        values = [float(row[key]) for row in rows]
        axes.barh(place + offset, values, 0.38, color=color, label=label)
        for at, value in zip(place + offset, values, strict=True):
            axes.text(1.08 * value, at, f"{value:.2g}", va="center", fontsize=0.8 * FONT_SIZE)
    axes.set_yticks(place, [row["run"] for row in rows])
    axes.set(xscale="log", xlabel="CPU time of a simulated second [s]", xlim=(0.05, 60.0))
    axes.grid(False, axis="y")
    axes.legend(loc="lower right")
    return figure


def joint_losses() -> Figure:
    """Draw the efficiency of the reduced joint and of the full model over the load, in both directions."""
    rows = _read("joint_losses")
    figure = Figure(figsize=(WIDTH, 2.6), layout="constrained")
    axes = figure.subplots()
    for design, color in (("pin", BLUE), ("nonpin", VERMILION)):
        for direction, style in (("driving", "-"), ("back-driven", "--")):
            chosen = [row for row in rows if row["direction"] == direction]
            load = [float(row["load_percent"]) for row in chosen]
            axes.plot(load, [float(row[f"{design}_full"]) for row in chosen], style, color=color)
            label = f"{design}, {direction}"
            axes.plot(load, [float(row[f"{design}_joint"]) for row in chosen], "o", color=color, markersize=4.0,
                      label=label, fillstyle="full" if style == "-" else "none")  # fmt: skip
    axes.set(xlabel="load, share of the nominal torque [%]", ylabel="efficiency [%]", xlim=(0.0, 105.0))
    axes.set_title("dots: joint in MuJoCo; lines: full model")
    axes.legend(ncols=2, fontsize=0.8 * FONT_SIZE)
    return figure


def printed_drive() -> Figure:
    """Draw the measured loops of both printed drives, and their stiffness: measured, fitted and predicted."""
    content = json.loads(docs_bench.KEPT.read_text(encoding="utf-8"))
    figure = Figure(figsize=(WIDTH, 3.0), layout="constrained")
    loops, stiffness = figure.subplots(1, 2, width_ratios=(1.5, 1.0))
    drives = (("pin", "baseline", BLUE), ("nonpin", "twin", VERMILION))
    for kind, name, color in drives:
        torque, deflection = np.genfromtxt(
            docs_bench.BENCH / f"{docs_bench.LOOPS[kind][1]}.csv", delimiter=",", skip_header=1, unpack=True
        )
        loops.plot(torque, deflection, ".", color=color, markersize=1.5, label=name)
    loops.set(xlabel="torque on the output [N m]", ylabel="rotation of the output [deg]")
    loops.legend(markerscale=5.0)
    for place, (kind, _, color) in enumerate(drives):
        measured, fit = content[kind]["measured"]["stiffness_nm_per_rad"], content[kind]["parameters"]
        predicted = {"value": 1.0 / sum(content[kind]["parts"].values()), "ci95": content[kind]["interval"]}
        for row, figure_of in enumerate((measured, fit["structure_stiffness"], predicted)):
            low, high = figure_of["ci95"]
            stiffness.plot([low, high], [row + 0.2 * place] * 2, color=color, linewidth=1.2)
            stiffness.plot(figure_of["value"], row + 0.2 * place, "o", color=color, markersize=4.0)
    stiffness.set_yticks([0.1, 1.1, 2.1], ["measured", "fitted\nstructure", "predicted"])
    stiffness.set(xlabel="stiffness [N m/rad]", ylim=(2.6, -0.4), xlim=(0.0, 800.0))
    return figure


def verdicts() -> Figure:
    """Draw the number of claims with each verdict, by section of the page on the paper."""
    claims = _claims()
    colors = {"agrees": GREEN, "depends": ORANGE, "disagrees": VERMILION, "not determined": "#C8CDD2"}
    names = {
        **{"speed": "Fig. 6: speed", "path": "Fig. 7: path", "velocity": "Fig. 8: velocity, vibration"},
        **{"pin": "Figs 9, 16: pin 1", "height": "Figs 12-15: stress", "order": "Figs 12-15: ranking, curves"},
        **{"torque": "Fig. 19: torque", "lines": "section 2: contact lines", "steel": "Table 1: steel"},
    }
    keys_by_section = {**docs_results.SECTIONS, "order": docs_results.DOWNLOAD_ONLY}
    figure = Figure(figsize=(WIDTH, 0.9 + ROW_HEIGHT * len(names)), layout="constrained")
    axes = figure.subplots()
    for row, section in enumerate(reversed(names)):
        left = 0
        for verdict, color in colors.items():
            number = sum(claims[key]["verdict"] == verdict for key in keys_by_section[section])
            axes.barh(row, number, left=left, color=color, label=verdict if row == 0 else None)
            left += number
    axes.set_yticks(range(len(names)), list(names.values())[::-1])
    axes.set(xlabel="number of claims")
    axes.grid(False, axis="y")
    axes.legend(loc="lower right")
    return figure


def stress_heights() -> Figure:
    """Draw the stresses without load of the paper and of this model, by part and design."""
    claims = _claims()
    keys = docs_results.SECTIONS["height"][::-1]
    figure = Figure(figsize=(WIDTH, 0.9 + ROW_HEIGHT * len(keys)), layout="constrained")
    axes = figure.subplots()
    for row, key in enumerate(keys):
        low, high = claims[key]["ours"]["spread"]
        axes.plot([low, high], [row, row], color=BLUE, linewidth=4.0, label="this model, 12 runs" if not row else None)
        axes.plot(claims[key]["paper"]["value"], row, "D", color=VERMILION, label="paper" if not row else None)
    axes.set_yticks(range(len(keys)), [key.removeprefix("stress_height_").replace("_", ", ") for key in keys])
    axes.set(xscale="log", xlabel="largest stress away from contacts, no load [MPa]", xlim=(0.1, 1000.0))
    axes.legend(loc="lower right")
    return figure


def _claims() -> dict[str, Any]:
    content = json.loads(docs_results.KEPT.read_text(encoding="utf-8"))
    return {claim["key"]: claim for claim in content["claims"]}


def wear() -> Figure:
    """Draw the growth of the lost motion of each preset over the hours, with its 5 to 95 % interval."""
    rows = _read("wear")
    presets = list(dict.fromkeys(row["preset"] for row in rows))
    figure = Figure(figsize=(WIDTH, 4.2), layout="constrained")
    for axes, preset in zip(figure.subplots(2, 2, sharex=True).flat, presets, strict=True):
        courses = {}
        for case in ("low", "typical", "high"):
            of_case = [row for row in rows if (row["preset"], row["case"]) == (preset, case)]
            hours, motion = (np.array([float(row[key]) for row in of_case]) for key in ("hours", "lost_motion_arcmin"))
            courses[case] = hours, 100.0 * (motion / motion[0] - 1.0)
        hours, high = courses["high"]
        axes.fill_between(hours, np.interp(hours, *courses["low"]), high, color=BLUE, alpha=0.15, linewidth=0.0)
        for case, (colour, width) in {"low": (GREY, 0.9), "high": (GREY, 0.9), "typical": (BLUE, 1.5)}.items():
            axes.plot(*courses[case], color=colour, linewidth=width)
        axes.axhline(100.0, color=VERMILION, linewidth=0.9, linestyle="--")
        axes.set(title=preset, xlim=(0.0, 1000.0), ylim=(0.0, 120.0))
    figure.supxlabel("time [h]", fontsize=FONT_SIZE)
    figure.supylabel("growth of the lost motion [%]", fontsize=FONT_SIZE)
    return figure


def _read(name: str) -> list[dict[str, str]]:
    with (DATA / f"{name}.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


CHARTS: dict[Callable[[], Figure], Path] = {
    validation: docs_validation.KEPT,
    solvers: DATA / "solvers.csv",
    cost: DATA / "cost.csv",
    wear: DATA / "wear.csv",
    joint_losses: DATA / "joint_losses.csv",
    printed_drive: docs_bench.KEPT,
    verdicts: docs_results.KEPT,
    stress_heights: docs_results.KEPT,
}
"""Charts with the files of their data."""
