"""``cycloid-mj calibrate`` and ``compare-bench``: what a test bench measured, held against a design."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from cycloid_mj.base.atomic_write import storable
from cycloid_mj.base.errors import CycloidError, RunError, UsageError
from cycloid_mj.base.interrupt import cause
from cycloid_mj.base.outcome import MOST_FIGURES, Outcome
from cycloid_mj.cli.delivery import Destination, claimed, deliver, write
from cycloid_mj.cli.flags import FLAT, Delivery, DesignOptions, DesignValue, out_flag
from cycloid_mj.reducer import Reducer

if TYPE_CHECKING:
    from cycloid_mj.bench import Calibration

FILES = (".toml", "-residuals.csv", "-loops.png", "-loops.svg")
"""What a calibration leaves, after the design's name."""
UNTRIED = "whether the design serves, by its checks, statics and reduce, was not tried"
OUT, OUT_TE = "runs/calibrate", "runs/compare-bench"

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
        help="What to fit: play (teeth and holes alike), structure_stiffness, drag, drag_travel, hysteresis, "
        "hysteresis_travel (the default); mesh_play, output_play, cam_play, tooth_stiffness; in place of hysteresis "
        "load_friction (a share of the torque), or "
        "friction of the contacts and material_loss; or numbers of the design file, such as clearance.output_um.",
    ),
]
HeldFlag = Annotated[
    Literal["crank", "output"],
    Parameter(
        help="Which shaft the bench held: the crank, with the torque on the output; or the output, with the motor "
        "turning the crank: torque times the ratio, angle over it. Default: crank."
    ),
]
CrankFlag = Annotated[
    float, Parameter(metavar="X", help="Angle at which the crank was held, or started [deg]. Default: 0.")
]
LossesFlag = Annotated[
    bool,
    Parameter(
        help="Fit four kinds of losses to the same loops, and tell which explain them: constant friction, friction of "
        "the contacts, hysteresis of the material, both."
    ),
]
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
    DesignValue("load", "torque", nonzero=True).flag(
        "Torque on the output under which it was measured", ". Default: load.torque_nm, or 1 % of the rated."
    ),
]

EXAMPLES = """Examples:
  cycloid-mj calibrate --design printed --loop play_loop.csv --loop stiffness_loop.csv --out made
  cycloid-mj calibrate --design my.toml --loop loop.csv --fit play,tooth_stiffness,friction,drag --json
  cycloid-mj calibrate --design my.toml --loop loop.csv --held output --losses --out losses"""

TE_EXAMPLES = """Examples:
  cycloid-mj compare-bench --design my.toml --te te.csv --load-nm 10
  cycloid-mj compare-bench --design pin --set errors.pin_position_um=2 --te te.csv --json"""


@dataclass(frozen=True, kw_only=True)
class CalibrationDelivery(Delivery):
    """Where a calibration goes."""

    out: Annotated[str | None, out_flag("the calibrated design, JSON, residuals, figure and page", OUT)] = None


@dataclass(frozen=True, kw_only=True)
class BenchDelivery(Delivery):
    """Where a comparison with a bench goes."""

    out: Annotated[str | None, out_flag("the JSON file and the figure", OUT_TE)] = None


CALIBRATED, COMPARED = CalibrationDelivery(), BenchDelivery()


def calibrate(
    chosen: Annotated[DesignOptions, FLAT],
    *,
    loop: LoopFlag,
    fit: FitFlag = "",
    held: HeldFlag = "crank",
    crank_deg: CrankFlag = 0.0,
    losses: LossesFlag = False,
    delivery: Annotated[CalibrationDelivery, FLAT] = CALIBRATED,
) -> int:
    """Fit clearances, stiffness and friction to measured loops.

    The model is static: contacts with their clearances, a structure that gives,
    friction that remembers and comes on over a travel. With --fit friction it is
    that of teeth, holes and cam, and grows with the load; with material_loss the
    material loses some too. Each loop has an offset of its own.
    Written are the calibrated design, a JSON file, a table of residuals, a figure
    and a page: play, stiffness and Coulomb friction as the measured loop and the
    fitted one show them, every value with its interval of 95 %, which of them the
    loop cannot tell apart, and what to measure next. A design on which statics at
    the loop's torque or reduce would stop is told, and the exit code is 1.
    """
    import math

    from cycloid_mj.bench import calibrate as calibrated
    from cycloid_mj.bench import compare_losses, read_loop
    from cycloid_mj.bench.calibration import CalibrationStopped, calibrated_name
    from cycloid_mj.bench.parameters import DEFAULT, parameters
    from cycloid_mj.cli.progress import counted

    if not math.isfinite(crank_deg):
        raise UsageError(f"--crank-deg {crank_deg:g}: give an angle in degrees")
    keys = tuple(key.strip() for key in fit.split(",") if key.strip()) if fit else DEFAULT
    loops = [read_loop(path) for path in loop]
    names = [one.name for one in loops]
    if len(set(names)) < len(names):
        raise UsageError(f"two loops are called {max(names, key=names.count)}: give their files names of their own")
    design = chosen.sound()
    parameters(Reducer(design), keys, loops)  # refuses a wrong one
    name = calibrated_name(Reducer(design))
    place = claimed(delivery, name, [f"{name}{rest}" for rest in FILES], OUT, paged=True)
    silent = replace(delivery, quiet=True)
    try:
        calibration = calibrated(
            design, loops, keys, held, math.radians(crank_deg), counted("calibrate", delivery.quiet)
        )
    except CalibrationStopped as stop:
        write(_calibrated(stop.calibration, place), place, silent)
        raise RunError(f"stopped by {cause(stop)}; what was fitted by then is in {place.folder}") from stop
    if losses:
        write(_calibrated(calibration, place), place, silent)
        try:
            calibration = compare_losses(
                calibration,
                counted("calibrate: losses", delivery.quiet),
                lambda so_far: write(_calibrated(so_far, place), place, silent),
            )
        except KeyboardInterrupt as stop:
            raise RunError(
                f"stopped by {cause(stop)}; the calibration, and the losses so far, are in {place.folder}"
            ) from stop
    try:
        unusable = _unusable(calibration, delivery.quiet)
    except KeyboardInterrupt as stop:
        write(_calibrated(calibration, place), place, silent)
        raise RunError(
            f"stopped by {cause(stop)}; the calibration is in {place.folder}, whether its design serves was not tried"
        ) from stop
    return deliver(_calibrated(calibration, place, unusable), place, delivery)


def _unusable(calibration: "Calibration", quiet: bool) -> tuple[str, ...]:
    """Tell on what the written design stops, and which of its fitted values is why; empty where it serves."""
    from cycloid_mj.cli.progress import underway

    most = max(loop.most for loop in calibration.fitted.loops)
    with underway("calibrate: trying the design by its checks, statics and reduce", quiet):
        flaw = _flaw(Reducer(calibration.design), most)
    if flaw is None:
        return ()
    fitted, blamed = calibration.fitted, []
    for number, one in enumerate(fitted.parameters, 1):
        model = fitted.model
        for other, value in zip(fitted.parameters, fitted.values.tolist(), strict=True):
            model = model if other == one else other.put(model, value)
        with underway(f"calibrate: trying it with {one.key} as drawn, {number} of {len(fitted.parameters)}", quiet):
            serves = _flaw(model.reducer, most) is None
        if serves:
            blamed.append(one.key)
    estimates = calibration.estimates
    values = " or ".join(
        f"{key} as drawn instead of {estimates[key].value:.4g} {estimates[key].unit}".removesuffix(" 1")
        for key in blamed
    )
    softer = ", or fit structure_stiffness in its place" if blamed == ["tooth_stiffness"] else ""
    why = f"with {values} it would serve: leave that out of --fit{softer}" if blamed else "no value alone is to blame"
    return (f"the calibrated design is of no use: {flaw}; {why}",)


def _flaw(reducer: Reducer, torque: float) -> str | None:
    """Return on what a reducer stops: its checks, statics under a torque [N m], or its reduction to a joint."""
    from cycloid_mj.checks import require_sound
    from cycloid_mj.robot import reduce
    from cycloid_mj.statics.sheet import sheet

    steps: tuple[tuple[str, Callable[[], object]], ...] = (
        ("design check", lambda: require_sound(reducer)),
        (f"statics at {torque:.4g} N m", lambda: sheet(reducer, torque)),
        ("reduce", lambda: reduce(reducer.design)),
    )
    for name, step in steps:
        try:
            step()
        except CycloidError as error:
            return f"{name}: {error}"
    return None


def _calibrated(calibration: "Calibration", place: Destination, unusable: tuple[str, ...] | None = None) -> Outcome:
    """Collect the outcome of a calibration; `unusable` is None where its design was not tried."""
    from cycloid_mj.base.result import quantity_table
    from cycloid_mj.base.units import DEGREE
    from cycloid_mj.design import dump
    from cycloid_mj.figures import quantities, values_json
    from cycloid_mj.plots.bench import calibration_figure
    from cycloid_mj.plots.save import encode_figure
    from cycloid_mj.report.results import calibration_page

    name, fitted = calibration.design.name, calibration.fitted
    figures = quantities(Reducer(calibration.design))
    rows = ["loop,torque_output_Nm,deflection_deg,model_deg,residual_deg"]
    for loop, turn in zip(fitted.loops, fitted.turns, strict=True):
        measured, model = loop.deflection / DEGREE, turn / DEGREE
        rows += [
            f"{loop.name},{torque!r},{one!r},{other!r},{one - other!r}"
            for torque, one, other in zip(loop.torque.tolist(), measured.tolist(), model.tolist(), strict=True)
        ]
    draw = cache(partial(encode_figure, calibration_figure(calibration)))
    files = {
        f"{name}.toml": dump(calibration.design).encode(),
        f"{name}-residuals.csv": storable("\n".join([*rows, ""])).encode(),
    }
    names = [*files, f"{name}-loops.png", f"{name}-loops.svg", f"{name}.json"]
    return Outcome(
        title=f"calibration: {name}",
        failures=unusable or (),
        warnings=[
            *(
                f"the loop cannot tell {one} from {other}: correlation {size:.3f}"
                for one, other, size in calibration.alike
            ),
            *(
                [f"not determined by the loop: {', '.join(calibration.unidentified)}"]
                if calibration.unidentified
                else []
            ),
            *(f"the model does not follow the loop: {sentence}" for sentence in calibration.misfits),
        ],
        headline=_headline(calibration),
        tables=[*calibration.tables(), quantity_table("figures of the calibrated design", figures.values())],
        summary=[f"measure next: {sentence}" for sentence in calibration.measure_next],
        notes=calibration.notes,
        pictures={f"{name}-loops": draw},
        files=files,
        result=calibration.as_json()
        | {"unusable": None if unusable is None else list(unusable), "figures": values_json(figures)}
        | {"files": [*place.paths(names), str(place.page)]},
        page=lambda: calibration_page(calibration, draw("svg").decode(), (UNTRIED,) if unusable is None else unusable),
        code=1 if unusable else 0,
    )


def _headline(calibration: "Calibration") -> dict[str, str]:
    from cycloid_mj.base.units import DEGREE

    read, modelled = calibration.measured, calibration.modelled
    derived = {
        "play, from the loaded branches": _beside(read.play.value / DEGREE, modelled.play.value / DEGREE, "deg"),
        "play, at zero torque": _beside(read.width.value / DEGREE, modelled.width.value / DEGREE, "deg"),
        "stiffness": _beside(read.stiffness.value, modelled.stiffness.value, "N m/rad"),
        "Coulomb friction": _beside(read.coulomb.value, modelled.coulomb.value, "N m"),
        "residual, rms": f"{calibration.rms / DEGREE:.3g} deg",
    }
    fitted = {
        key: f"{one.value:.4g} {'' if one.unit == '1' else one.unit}".strip()
        + ("" if one.identified else " (not determined by the loop)")
        for key, one in calibration.estimates.items()
    }
    return dict(islice((derived | fitted).items(), MOST_FIGURES))


def _beside(measured: float, model: float, unit: str) -> str:
    return f"{measured:.4g} {unit} (fitted model {model:.4g})"


def compare_bench(
    chosen: Annotated[DesignOptions, FLAT],
    *,
    te: TeFlag,
    load_nm: LoadFlag = None,
    delivery: Annotated[BenchDelivery, FLAT] = COMPARED,
) -> int:
    """Hold a measured transmission error against a design.

    The file has the columns crank_deg and te_arcsec. Beside it stands the static
    balance of the design under the load; the crank's zero, which a bench does not
    share, is fitted. For each order: both amplitudes, their phase, what share of
    the measured power the model explains, and what can give that order.
    """
    from cycloid_mj.bench import compare_bench as compared
    from cycloid_mj.bench import read_te
    from cycloid_mj.plots.bench import comparison_figure
    from cycloid_mj.plots.save import encode_figure

    measured = read_te(te)
    design = chosen.sound()
    stem = f"{design.name}-{measured.name}"
    place = claimed(delivery, stem, [f"{stem}.png"], OUT_TE)
    comparison = compared(design, measured, load_nm)
    outcome = Outcome(
        title=f"transmission error of {design.name} against {te}",
        headline={"of the measured variance, the model explains": f"{comparison.whole:.1%}"},
        summary=[f"the model explains {comparison.whole:.1%} of the measured curve's variance"],
        tables=[comparison.table()],
        pictures={stem: partial(encode_figure, comparison_figure(comparison))},
        formats=("png",),
        result=comparison.as_json(),
    )
    return deliver(outcome, place, delivery)
