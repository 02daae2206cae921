"""Compare the planar solver with MuJoCo over layouts, loads, friction coefficients and speeds; write docs/solvers.md.

    python scripts/docs_solvers.py                          # the page, from docs/data/solvers.csv
    python scripts/docs_solvers.py --run                    # all 108 conditions, about 10 minutes of CPU
    python scripts/docs_solvers.py --run "fixed pins" ...   # these layouts, the other rows as they are

Both solvers use the same contact laws and the same drive cycle: the crank turns at constant speed, without gravity.
Where a figure differs by more than its bound, both run once more with a time step of 1 us and an impratio of 100, which
nearly removes the lift that MuJoCo's friction cone adds to sliding contacts.
"""

import argparse
import itertools
import sys
import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from unittest.mock import patch

import numpy as np
from docs_page import DATA, DOCS, csv_text, markdown_table, read_csv, replace_sections

from cycloid_mj.base.array import Array
from cycloid_mj.base.atomic_write import write_files
from cycloid_mj.base.errors import RunError
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.planar.model import planar_model
from cycloid_mj.dynamics.run import Model, simulate
from cycloid_mj.reducer import Reducer
from cycloid_mj.validate import witness
from cycloid_mj.validate.rig import SETTLED, vector_lengths, without_gravity

PAGE, KEPT = DOCS / "solvers.md", DATA / "solvers.csv"
SCRIPT = "scripts/docs_solvers.py"

LAYOUTS = {
    "free pins": ("pin",),
    "sleeved pins": ("pin", 'ring.pins="sleeved"'),
    "fixed pins": ("pin", 'ring.pins="fixed"'),
    "ring output": ("pin", 'ring.pins="fixed"', 'output.member="ring"'),
    "internal gear": ("nonpin",),
    "internal gear, two discs": ("nonpin", "gear.discs=2"),
    "two discs": ("twodisc",),
    "three discs": ("pin", 'ring.pins="fixed"', "gear.discs=3", "output.pins=9"),
    "printed": ("printed",),
}
"""Preset of each layout, with the changes of its design."""

MOVING_PINS = {"free pins", "sleeved pins"}
"""Layouts whose ring pins are bodies of their own."""


@dataclass(frozen=True)
class SolverComparison:
    """Conditions of the comparison of both solvers."""

    loads: tuple[float, ...] = (0.03, 0.3, 1.0)
    frictions: tuple[float, float] = (0.05, 0.3)
    speeds: tuple[float, float] = (1640.0, 12000.0)
    """Shares of the rated torque, tooth frictions, and crank speeds [rpm]."""
    turns: float = 2.0
    min_time: float = 0.02
    """Crank turns of a run that are evaluated, and the minimum time [s]."""
    planar_step: float = 2e-6
    fine_step: float = 1e-6
    """Time steps [s] of the planar solver, and of both solvers in the repeated comparison."""
    fine_impratio: float = 100.0
    """Value of MuJoCo's ``impratio`` at which its cone hardly lifts sliding contacts."""
    low_load: float = 10.0
    """Below this share of the rated torque the page reports the differences in rows of their own [%]."""


SOLVERS = SolverComparison()


FIGURES = ("mean_error", "peak_to_peak", "cam", "efficiency", "rms_speed", "teeth", "output_pins")
BOUNDS = np.array([0.1, 1.0, 0.1, 0.1, 5.0, 0.1, 0.1])
"""Differences of `FIGURES` that need no second comparison [%]; efficiency in points."""

CONDITION = ("layout", "load_percent", "friction", "speed_rpm", "settings")
COLUMNS = (*CONDITION, *FIGURES, "stopped")
"""Columns of the table for download; ``settings`` is ``chosen`` or ``fine``, ``stopped`` why a run ended early."""

Row = Mapping[str, str]


def design_of(layout: str, load_share: float, friction: float, speed: float) -> Design:
    """Return the design of a layout under a share of its rated torque, with tooth friction and crank speed [rpm]."""
    preset, *changes = LAYOUTS[layout]
    design = override(
        PRESETS[preset], [*witness.CONDITIONS, *without_gravity(), f"drive.speed_rpm={speed!r}", *changes]
    )
    hold = SETTLED + max(60.0 * SOLVERS.turns / speed, SOLVERS.min_time)
    load = f"load.torque_nm={load_share * design.rated_torque!r}"
    return override(
        design, [load, "friction.law=coulomb", f"friction.{design.tooth_pair}={friction!r}", f"drive.hold_s={hold!r}"]
    )


def run_figures(reducer: Reducer, model: Model) -> Array:
    """Run a model and return its figures, in the order of `FIGURES`."""
    run = simulate(reducer.design, model)
    late = run.select(run.time >= SETTLED)
    force_sums = (
        vector_lengths(late.forces(kind)).sum(axis=1).mean() for kind in (reducer.design.tooth_pair, "output")
    )
    return np.array([*witness.figures(reducer, run), *force_sums])


def difference(planar: Array, mujoco: Array) -> Array:
    """Return by how much the planar figures exceed MuJoCo's [%]; efficiency in points."""
    excess = 100.0 * (planar / mujoco - 1.0)
    excess[3] = planar[3] - mujoco[3]
    return excess


def fine_difference(design: Design) -> Array:
    """Return the differences at `SOLVERS.fine_step`, with MuJoCo at `SOLVERS.fine_impratio`."""
    reducer = Reducer(override(design, [f"settings.timestep_us={1e6 * SOLVERS.fine_step!r}"]))
    with patch("cycloid_mj.dynamics.mjcf.model.impratio", lambda *_: SOLVERS.fine_impratio):
        model = build(reducer.design)
    return difference(run_figures(reducer, planar_model(reducer)), run_figures(reducer, model))


def compare_layout(layout: str) -> list[dict[str, str]]:
    """Simulate a layout with both solvers under all conditions, and return the rows of the table."""
    rows = []
    for share, friction, speed in itertools.product(SOLVERS.loads, SOLVERS.frictions, SOLVERS.speeds):
        design = design_of(layout, share, friction, speed)
        reducer, stopped = Reducer(design), []
        models: dict[str, Model] = {
            "planar": planar_model(reducer, timestep=SOLVERS.planar_step),
            "MuJoCo": build(design),
        }
        figures = {}
        for solver, model in models.items():
            try:
                figures[solver] = run_figures(reducer, model)
            except RunError as error:
                stopped.append(f"{solver}: {str(error).partition(' s ')[2].partition(';')[0].partition(':')[0]}")
        words = (layout, f"{100.0 * share:g}", f"{friction:g}", f"{speed:g}")
        condition = dict(zip(CONDITION, (*words, "chosen"), strict=True))
        if stopped:
            rows.append(condition | {"stopped": "; ".join(stopped)})
            continue
        excess = difference(figures["planar"], figures["MuJoCo"])
        rows.append(condition | _cells(excess))
        if (np.abs(excess) > BOUNDS).any():
            rows.append(condition | {"settings": "fine"} | _cells(fine_difference(design)))
    return rows


def _cells(excess: Array) -> dict[str, str]:
    return {name: f"{value:.2g}" for name, value in zip(FIGURES, excess, strict=True)}


def summary(rows: Iterable[Row]) -> str:
    """Tabulate the largest differences of the solvers in Markdown, by kind of ring pins, load and speed."""
    rows = [row for row in rows if not row["stopped"]]
    head = ("Ring", "Load", "Speed [rpm]", "Mean TE", "Peak-to-peak TE", "Cam force", "Efficiency", "Rms speed")
    lines = []
    for moving, low_load, speed in itertools.product((False, True), (False, True), SOLVERS.speeds):
        chosen = [
            row
            for row in rows
            if (row["layout"] in MOVING_PINS) == moving
            and (float(row["load_percent"]) < SOLVERS.low_load) == low_load
            and float(row["speed_rpm"]) == speed
            and row["settings"] == "chosen"
        ]
        ring = "free or sleeved pins" if moving else "fixed pins or internal gear"
        largest = (max(abs(float(row[name])) for row in chosen) for name in FIGURES[:5])
        units = ("%", "%", "%", "points", "%")
        cells = (f"{value:.2g} {unit}" for value, unit in zip(largest, units, strict=True))
        lines.append((ring, "3 %" if low_load else "30 and 100 %", f"{speed:g}", *cells))
    return markdown_table(head, lines)


def read_rows() -> list[dict[str, str]]:
    """Read the kept rows; none where there is no file."""
    return read_csv(KEPT) if KEPT.exists() else []


def write_rows(rows: Iterable[Row]) -> None:
    """Write the table for download."""
    lines = ([row.get(name, "") for name in COLUMNS] for row in rows)
    write_files({KEPT: csv_text([COLUMNS, *lines]).encode()})


def run_layouts(chosen: Sequence[str]) -> None:
    """Compare the solvers on some layouts, and save their rows with the kept rows of the others."""
    rows = read_rows()
    for layout in chosen:
        print(layout, file=sys.stderr)
        fresh = {layout: compare_layout(layout)}
        rows = [row for name in LAYOUTS for row in fresh.get(name, [kept for kept in rows if kept["layout"] == name])]
        write_rows(rows)


def main() -> None:
    """Compare the solvers on the requested layouts, and write the page."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("--run", nargs="*", metavar="LAYOUT", help=f"of {', '.join(LAYOUTS)}; all by default")
    chosen = parser.parse_args().run
    if chosen is not None:
        if unknown := set(chosen) - set(LAYOUTS):
            parser.error(f"unknown layout {', '.join(sorted(unknown))}; available: {', '.join(LAYOUTS)}")
        warnings.simplefilter("ignore")
        run_layouts(chosen or list(LAYOUTS))
    text = replace_sections(PAGE.read_text(encoding="utf-8"), {"summary": summary(read_rows())}, SCRIPT)
    write_files({PAGE: text.encode()})


if __name__ == "__main__":
    main()
