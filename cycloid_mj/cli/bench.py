"""``cycloid-mj calibrate`` and ``compare-bench``: what a test bench measured, held against a design."""

from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from cycloid_mj.base.errors import RunError, UsageError
from cycloid_mj.base.interrupt import cause
from cycloid_mj.cli.flags import FLAT, LOAD, DesignOptions, ForceFlag, JsonFlag, QuietFlag
from cycloid_mj.cli.terminal import json_text, say, say_json, show, tell
from cycloid_mj.reducer import Reducer

if TYPE_CHECKING:
    from cycloid_mj.bench import Calibration

FILES = (".toml", ".json", "-residuals.csv", ".html", "-loops.png", "-loops.svg")
"""What a calibration leaves, after the design's name."""
OUT, OUT_TE = "runs/calibrate", "runs/compare-bench"
SECONDS_BETWEEN = 5.0

LoopFlag = Annotated[
    tuple[Path, ...],
    Parameter(
        name="--loop",
        metavar="LOOP.csv",
        help="Measured loop: columns torque_output_Nm, deflection_deg, in the order of time, from one end of the "
        "torque to the other and back. Repeatable: loops of one drive are fitted together.",
    ),
]
FitFlag = Annotated[
    str,
    Parameter(
        metavar="KEY,...",
        help="What to fit: mesh_play, output_play, cam_play, play (teeth and holes alike), tooth_stiffness, friction, "
        "drag, drag_travel, material_loss, or numbers of the design file, such as clearance.output_um. Default: "
        "mesh_play,output_play,cam_play,tooth_stiffness,friction,drag,drag_travel.",
    ),
]
HeldFlag = Annotated[
    Literal["crank", "output"],
    Parameter(
        help="Which shaft the bench held: the crank, with the torque on the output; or the output, with the motor "
        "turning the crank: torque times the ratio, angle over it."
    ),
]
CrankFlag = Annotated[float, Parameter(metavar="X", help="Angle at which the crank was held, or started [deg].")]
LossesFlag = Annotated[
    bool,
    Parameter(
        help="Fit four kinds of losses to the same loops, and tell which explain them: constant friction, friction of "
        "the contacts, hysteresis of the material, both."
    ),
]
OutFlag = Annotated[Path, Parameter(metavar="DIR", help="Folder of the results, made if there is none.")]
TeFlag = Annotated[
    Path,
    Parameter(
        name="--te",
        metavar="TE.csv",
        help="Measured transmission error of the output: columns crank_deg, te_arcsec, over at least a turn of the "
        "crank; the output's angle less its ideal one, counter-clockwise.",
    ),
]
LoadFlag = Annotated[
    float | None,
    LOAD.flag("Torque on the output under which it was measured", ". Default: load.torque_nm, or 1 % of the rated."),
]

EXAMPLES = """Examples:
  cycloid-mj calibrate --design printed --loop play_loop.csv --loop stiffness_loop.csv --out made
  cycloid-mj calibrate --design my.toml --loop loop.csv --fit play,tooth_stiffness,friction,drag --json
  cycloid-mj calibrate --design my.toml --loop loop.csv --held output --losses"""

TE_EXAMPLES = """Examples:
  cycloid-mj compare-bench --design my.toml --te te.csv --load-nm 10
  cycloid-mj compare-bench --design pin --set errors.pin_position_um=2 --te te.csv --json"""


def calibrate(
    chosen: Annotated[DesignOptions, FLAT],
    *,
    loop: LoopFlag,
    fit: FitFlag = "",
    held: HeldFlag = "crank",
    crank_deg: CrankFlag = 0.0,
    losses: LossesFlag = False,
    out: OutFlag = Path(OUT),
    force: ForceFlag = False,
    json: JsonFlag = False,
    quiet: QuietFlag = False,
) -> int:
    """Fit clearances, stiffness and friction of a design to measured hysteresis loops.

    The model is static: contacts with their clearances, friction at teeth, holes
    and cam that grows with the load and remembers which way it slid, constant
    friction, and a lossy material where asked. Each loop has an offset of its own.
    Written are the calibrated design, a JSON file, a table of residuals, a figure
    and a page: every value with its interval of 95 %, and which of them the loop
    cannot tell apart.
    """
    import math

    from cycloid_mj.bench import calibrate as calibrated
    from cycloid_mj.bench import compare_losses, read_loop
    from cycloid_mj.bench.calibration import calibrated_name
    from cycloid_mj.bench.parameters import DEFAULT
    from cycloid_mj.cli.outfile import folder

    if not math.isfinite(crank_deg):
        raise UsageError(f"--crank-deg {crank_deg:g}: give an angle in degrees")
    keys = tuple(key.strip() for key in fit.split(",") if key.strip()) if fit else DEFAULT
    loops = [read_loop(path) for path in loop]
    names = [one.name for one in loops]
    if len(set(names)) < len(names):
        raise UsageError(f"two loops are called {max(names, key=names.count)}: give their files names of their own")
    design = chosen.sound()
    into = folder(str(out), "the calibration", [f"{calibrated_name(Reducer(design))}{rest}" for rest in FILES], force)
    progress = _Trials(quiet)
    calibration = calibrated(design, loops, keys, held, math.radians(crank_deg), progress)
    written = _write(calibration, into)
    if losses:
        try:
            calibration = compare_losses(calibration, progress, lambda so_far: _write(so_far, into))
        except KeyboardInterrupt as stop:
            raise RunError(f"stopped by {cause(stop)}; the calibration, and the losses so far, are in {into}") from stop
    if not quiet:
        tell(f"wrote {', '.join(map(str, written))}")
    if json:
        say_json(calibration.as_json() | {"files": [str(path) for path in written]})
        return 0
    for table in calibration.tables():
        show(table)
    for one, other, size in calibration.alike:
        say(f"the loop cannot tell {one} from {other}: correlation {size:.3f}")
    if calibration.unidentified:
        say(f"not determined by the loop: {', '.join(calibration.unidentified)}")
    for note in calibration.notes:
        say(note)
    return 0


def compare_bench(
    chosen: Annotated[DesignOptions, FLAT],
    *,
    te: TeFlag,
    load_nm: LoadFlag = None,
    out: OutFlag = Path(OUT_TE),
    force: ForceFlag = False,
    json: JsonFlag = False,
    quiet: QuietFlag = False,
) -> int:
    """Hold a measured transmission error against a design, order by order.

    The file has the columns crank_deg and te_arcsec. Beside it stands the static
    balance of the design under the load; the crank's zero, which a bench does not
    share, is fitted. For each order: both amplitudes, their phase, what share of
    the measured power the model explains, and what can give that order.
    """
    from cycloid_mj.base.whole import write_whole
    from cycloid_mj.bench import compare_bench as compared
    from cycloid_mj.bench import read_te
    from cycloid_mj.cli.outfile import folder
    from cycloid_mj.plots.bench import comparison_figure
    from cycloid_mj.plots.save import pictures

    measured = read_te(te)
    design = chosen.sound()
    stem = f"{design.name}-{measured.name}"
    into = folder(str(out), "the comparison", [f"{stem}.json", f"{stem}.png"], force)
    comparison = compared(design, measured, load_nm)
    path = into / f"{stem}.json"
    files = {
        path: (json_text(comparison.as_json()) + "\n").encode(),
        **pictures({stem: comparison_figure(comparison)}, into),
    }
    write_whole(files)
    if not quiet:
        tell(f"wrote {', '.join(map(str, files))}")
    if json:
        say_json(comparison.as_json())
        return 0
    show(comparison.table())
    say(f"the model explains {comparison.whole:.1%} of the measured curve's variance")
    return 0


class _Trials:
    """Progress of a search, whose end is not known: how many trials, and for how long."""

    def __init__(self, quiet: bool) -> None:
        self._quiet, self._start, self._told = quiet, monotonic(), monotonic()

    def __call__(self, done: int) -> None:
        now = monotonic()
        if not self._quiet and now - self._told > SECONDS_BETWEEN:
            self._told = now
            tell(f"calibrate: {done} trials in {now - self._start:.0f} s; a fit takes some 500 to 2000")


def _write(calibration: "Calibration", into: Path) -> list[Path]:
    """Write the results of a calibration; give the paths."""
    from cycloid_mj.base.units import DEGREE
    from cycloid_mj.base.whole import write_whole
    from cycloid_mj.design import dump
    from cycloid_mj.plots.bench import calibration_figure
    from cycloid_mj.plots.save import pictures
    from cycloid_mj.report.bench import calibration_page

    name = calibration.design.name
    figures = pictures({f"{name}-loops": calibration_figure(calibration)}, into, ("png", "svg"))
    rows = ["loop,torque_output_Nm,deflection_deg,model_deg,residual_deg"]
    for loop, turn in zip(calibration.fitted.loops, calibration.fitted.turns, strict=True):
        measured, model = loop.deflection / DEGREE, turn / DEGREE
        rows += [
            f"{loop.name},{torque!r},{one!r},{other!r},{one - other!r}"
            for torque, one, other in zip(loop.torque.tolist(), measured.tolist(), model.tolist(), strict=True)
        ]
    texts = {
        into / f"{name}.toml": dump(calibration.design),
        into / f"{name}.json": json_text(calibration.as_json()) + "\n",
        into / f"{name}-residuals.csv": "\n".join(rows) + "\n",
        into / f"{name}.html": calibration_page(calibration, figures[into / f"{name}-loops.svg"].decode()),
    }
    write_whole({path: text.encode() for path, text in texts.items()} | figures)
    return [*texts, *figures]
