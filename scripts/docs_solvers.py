"""Write docs/solvers.md: the planar solver against MuJoCo, over layouts, loads, friction of the teeth and speeds.

    python scripts/docs_solvers.py                   # the whole grid, some 10 minutes of CPU
    python scripts/docs_solvers.py "fixed pins" ...  # these layouts' rows anew, the others as they are

Both take the same laws over the same course: the crank turns evenly and nothing weighs. Where a figure differs by more
than its bound, MuJoCo runs once more at 1 us with an impratio of 100, which all but takes its cone of friction away,
against planar steps of 1 us.
"""

import argparse
import itertools
import sys
import warnings
from pathlib import Path
from unittest.mock import patch

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.atomic_write import write_whole
from cycloid_mj.base.errors import RunError
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.planar.model import planar_model
from cycloid_mj.dynamics.run import Model, simulate
from cycloid_mj.reducer import Reducer
from cycloid_mj.validate import witness
from cycloid_mj.validate.rig import SETTLED, sizes, without_gravity

PAGE = Path(__file__).resolve().parent.parent / "docs" / "solvers.md"

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
SHARES, FRICTIONS, SPEEDS = (0.03, 0.3, 1.0), (0.05, 0.3), (1640.0, 12000.0)
"""Of the rated torque; of the teeth; of the crank [rpm]."""

TURNS, LEAST = 2.0, 0.02
"""Turns of the crank that count, and the least time [s]."""

STEP, FINE = 2e-6, 1e-6
"""Steps of the planar solver [s], and of both where the cone is taken away."""

NO_CONE = 100.0
"""An ``impratio`` that all but takes the lift of MuJoCo's cone away."""

COLUMNS = ("mean error", "peak to peak", "cam", "efficiency", "rms speed", "teeth", "output pins")
BOUNDS = np.array([0.1, 1.0, 0.1, 0.1, 5.0, 0.1, 0.1])
"""Of the planar solver's figures less MuJoCo's [%], of the efficiency in points."""

HEAD = """# Two solvers

The planar solver against MuJoCo ([physics](physics.md#the-planar-solver)): by how much its figures are larger, in
percent of MuJoCo's, the efficiency in points. Mean and peak to peak of the output's transmission error, mean force of
the cam, efficiency, rms of the gear's speed about its mean, mean sums of the forces of teeth and of output pins.

The friction is that of the teeth alone. MuJoCo takes the steps that it chooses, the planar solver 2 us. The first
{turns:g} turns after {settled:g} ms count, at least {least:g} ms; the crank turns evenly, and nothing weighs. Where a
figure is beyond its bound (0.1 %, 1 % of peaks to peak, 5 % of the rms, bold), a second row takes MuJoCo's cone away:
both at 1 us, `impratio` 100.
{read}
`scripts/docs_solvers.py` writes this page.
"""

READ = """
- At 1640 rpm, without moving pins, means agree within 0.1 %, from 30 % of the load on within 0.01 %; peaks to peak
  within 1 % and rms within 5 %, but of three discs and `printed` under 3 % of the load at a friction of 0.3, where
  they do without the cone.
- At 12 000 rpm MuJoCo takes 25 steps from tooth to tooth. From 30 % of the load on means differ by up to 0.5 %, peaks
  to peak by 3 %, the rms by 6 %; at 1 us and without the cone by 0.07, 0.3 and 1 %. Under 3 % of the load means
  differ by up to 2.5 %; at 1 us and an `impratio` of 100 up to 0.4 % of means and 6 % of the peak to peak are left,
  of three discs more. What is left of mean errors is MuJoCo's step, of which its error is a multiple: at 1, 0.5 and
  0.25 us and a friction of 0.3 it is 0.09, 0.05 and 0.02 % of fixed pins, 0.12, 0.06 and 0.03 % of the internal gear,
  0.14, 0.07 and 0.03 % of two discs, at an `impratio` of 400 as well, while the planar solver's move by 0.01 % at
  most. The internal gear's peak to peak, at 0.05, differs by 5.6, 0.3 and 0.2 %. `printed` sticks and slides by
  chance: forces of its teeth, at 0.3, differ by 2.2 % among six stretches of 20 ms of one planar run, more than the
  solvers do. Three discs sway in another way at 0.5 us than at 1 us, by either solver: means agree within 0.3 and
  0.1 %.
- Moving pins chatter. From 30 % of the load on means agree within 0.1 %, the forces of the teeth within 0.2 %, but
  rms and peaks to peak differ by up to 7 %, as they do between settings of MuJoCo's. Under 3 % of the load at 12 000
  rpm means differ by up to 0.2 %, forces of the teeth by 0.9 %. Sleeves at a friction of 0.3 and the rated load come
  to slide in another way in MuJoCo at an `impratio` of 100, and agree within 0.003 % under the one that is chosen.
"""


def design_of(layout: str, share: float, friction: float, speed: float) -> Design:
    """Return a layout at a share of its rated torque, with a friction of its teeth, at a speed [rpm]."""
    preset, *changes = LAYOUTS[layout]
    design = override(PRESETS[preset], [*witness.HELD, *without_gravity(), f"drive.speed_rpm={speed!r}", *changes])
    hold = SETTLED + max(60.0 * TURNS / speed, LEAST)
    load = f"load.torque_nm={share * design.rated_torque!r}"
    return override(design, [load, f"friction.{design.tooth_pair}={friction!r}", f"drive.hold_s={hold!r}"])


def figures(reducer: Reducer, model: Model) -> Array:
    """Compute the figures of a run: those of `COLUMNS`."""
    run = simulate(reducer.design, model)
    late = run.select(run.time >= SETTLED)
    borne = (sizes(late.forces(kind)).sum(axis=1).mean() for kind in (reducer.design.tooth_pair, "output"))
    return np.array([*witness.figures(reducer, run), *borne])


def difference(ours: Array, theirs: Array) -> Array:
    """Compute by how much figures are larger than others [%], the efficiency in points."""
    larger = 100.0 * (ours / theirs - 1.0)
    larger[3] = ours[3] - theirs[3]
    return larger


def rows_of(layout: str) -> list[str]:
    """Run a layout under all conditions."""
    rows = []
    for share, friction, speed in itertools.product(SHARES, FRICTIONS, SPEEDS):
        design, name = design_of(layout, share, friction, speed), f"{layout} | {share:.0%} | {friction:g} | {speed:g}"
        reducer, jams = Reducer(design), []
        models: dict[str, Model] = {"planar": planar_model(reducer, step=STEP), "MuJoCo": build(design)}
        by_solver = {}
        for solver, model in models.items():
            try:
                by_solver[solver] = figures(reducer, model)
            except RunError as error:
                jams.append(f"{solver}: {str(error).partition(' s ')[2].partition(';')[0].partition(':')[0]}")
        if jams:
            rows.append(f"| {name} | {'; '.join(jams)} |" + " |" * (len(COLUMNS) - 1))
            continue
        larger = difference(by_solver["planar"], by_solver["MuJoCo"])
        rows.append(row(name, larger))
        if (np.abs(larger) > BOUNDS).any():
            rows.append(row(f"{name}, no cone", difference(*without_cone(design))))
    return rows


def without_cone(design: Design) -> tuple[Array, Array]:
    """Compute the figures of both solvers at a fine step, MuJoCo's all but without its cone."""
    reducer = Reducer(override(design, [f"settings.timestep_us={1e6 * FINE!r}"]))
    with patch("cycloid_mj.dynamics.mjcf.model.impratio", lambda *_: NO_CONE):
        model = build(reducer.design)
    return figures(reducer, planar_model(reducer)), figures(reducer, model)


def row(name: str, larger: Array) -> str:
    """Write a row of the table; what is beyond its bound is bold."""
    cells = (
        f"{value:+.2g}" if abs(value) <= bound else f"**{value:+.2g}**"
        for value, bound in zip(larger, BOUNDS, strict=True)
    )
    return f"| {name} | {' | '.join(cells)} |"


def main() -> None:
    """Write the page."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("layouts", nargs="*", metavar="LAYOUT", help=f"of {', '.join(LAYOUTS)}; all by default")
    wanted = parser.parse_args().layouts or list(LAYOUTS)
    if unknown := set(wanted) - set(LAYOUTS):
        parser.error(f"no layout {', '.join(sorted(unknown))}: choose of {', '.join(LAYOUTS)}")
    warnings.simplefilter("ignore")
    kept = PAGE.read_text().splitlines() if PAGE.exists() else []
    head = f"| layout | load | friction | rpm | {' | '.join(COLUMNS)} |"
    table = [head, "|---" * (4 + len(COLUMNS)) + "|"]
    for layout in LAYOUTS:
        old = [line for line in kept if line.startswith(f"| {layout} |")]
        table += rows_of(layout) if layout in wanted else old
        print(layout, file=sys.stderr)
        text = (
            HEAD.format(turns=TURNS, settled=1e3 * SETTLED, least=1e3 * LEAST, read=READ)
            + "\n"
            + "\n".join(table)
            + "\n"
        )
        write_whole({PAGE: text.encode()})


if __name__ == "__main__":
    main()
