"""``cycloid-mj calibrate`` and ``compare-bench``: fit a design to bench measurements, and compare with them."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from cycloid_mj.base.atomic_write import encodable_text
from cycloid_mj.base.errors import CycloidError, RunError, UsageError
from cycloid_mj.base.interrupt import signal_name
from cycloid_mj.base.outcome import MOST_FIGURES, Outcome
from cycloid_mj.cli.delivery import Destination, claim_destination, deliver, write
from cycloid_mj.cli.flags import FLAT, Delivery, DesignOptions, DesignValue, out_flag
from cycloid_mj.reducer import Reducer, reducer_of

if TYPE_CHECKING:
    from cycloid_mj.bench import Calibration
    from cycloid_mj.bench.loop import MeasuredLoop

FILES = (".toml", "-residuals.csv", "-loops.png", "-loops.svg")
"""Ends of the names of the files of a calibration, after the name of the design."""
UNTESTED = "the calibrated design was not tested by its checks, statics and reduce"
OUT, OUT_TE = "runs/calibrate", "runs/compare-bench"

LoopFlag = Annotated[
    tuple[Path, ...],
    Parameter(
        name="--loop",
        metavar="LOOP.csv",
        help="CSV file of a measured loop with the columns torque_output_Nm and deflection_deg, in order of "
        "time, from one end of the torque range to the other and back. Repeatable: all loops are fitted "
        "together.",
    ),
]
FitFlag = Annotated[
    str,
    Parameter(
        metavar="KEY,...",
        help="Comma-separated parameters to fit. Default: play (teeth and holes together), "
        "structure_stiffness, drag, drag_travel, hysteresis, hysteresis_travel. RV reducers: play of the teeth, "
        "and bearing_stiffness (of the crank bearings) instead of structure_stiffness. Also mesh_play, "
        "output_play, cam_play, tooth_stiffness; instead of hysteresis: load_friction (a share of the "
        "torque), or friction (of the contacts) and material_loss; and numeric keys of the design file, "
        "e.g. clearance.output_um.",
    ),
]
HeldFlag = Annotated[
    Literal["crank", "output"],
    Parameter(
        help="Shaft that was locked on the bench: crank (torque on the output), or output (the motor turns "
        "the crank; torque times the ratio, angle divided by it). Default: crank."
    ),
]
CrankFlag = Annotated[
    float, Parameter(metavar="X", help="Crank angle at which the crank was locked, or started [deg]. Default: 0.")
]
LossesFlag = Annotated[
    bool,
    Parameter(
        help="Fit four loss models to the same loops and compare them: constant friction, contact friction, "
        "material hysteresis, both."
    ),
]
TeFlag = Annotated[
    Path,
    Parameter(
        name="--te",
        metavar="TE.csv",
        help="CSV file of the measured transmission error of the output with the columns crank_deg and "
        "te_arcsec, over at least one crank turn: output angle minus ideal angle, counter-clockwise "
        "positive.",
    ),
]
LoadFlag = Annotated[
    float | None,
    DesignValue("load", "torque", nonzero=True).flag(
        "Output torque of the measurement", ". Default: load.torque_nm, or 1 % of the rated."
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
    """Output flags of `calibrate`."""

    out: Annotated[str | None, out_flag("the calibrated design, JSON, residuals, figure and page", OUT)] = None


@dataclass(frozen=True, kw_only=True)
class BenchDelivery(Delivery):
    """Output flags of `compare-bench`."""

    out: Annotated[str | None, out_flag("the JSON file and the figure", OUT_TE)] = None


CALIBRATED, COMPARED = CalibrationDelivery(), BenchDelivery()


def calibrate(
    design_options: Annotated[DesignOptions, FLAT],
    *,
    loop: LoopFlag,
    fit: FitFlag = "",
    held: HeldFlag = "crank",
    crank_deg: CrankFlag = 0.0,
    losses: LossesFlag = False,
    output_flags: Annotated[CalibrationDelivery, FLAT] = CALIBRATED,
) -> int:
    """Fit clearances, stiffness and friction to measured loops.

    The model is quasi-static: contacts with clearances, a compliant structure, and friction that builds
    up over a rotation. With --fit friction, friction acts at teeth, holes and cam and grows with the load. With --fit
    material_loss, the material dissipates energy, too. Each loop has its own offset of torque and deflection.

    The command writes the calibrated design, a JSON file, a table of residuals, a figure and a page. They show play,
    stiffness and Coulomb friction of the measured and of the fitted loops, each parameter with its 95 % confidence
    interval, parameters that the loops do not distinguish, and suggested further measurements. The exit code is 1 if
    the calibrated design has no static equilibrium at the torque of the loops, or cannot be reduced to a joint.
    """
    import math

    from cycloid_mj.bench import calibrate as fit_model
    from cycloid_mj.bench.calibration import CalibrationStopped, calibrated_name
    from cycloid_mj.bench.parameters import default_keys, fit_parameters
    from cycloid_mj.cli.progress import count_progress

    if not math.isfinite(crank_deg):
        raise UsageError(
            f"--crank-deg {crank_deg:g} is not a finite number: give the crank angle in degrees, e.g. --crank-deg 0"
        )
    design = design_options.resolve_checked()
    reducer = reducer_of(design)
    keys = tuple(key.strip() for key in fit.split(",") if key.strip()) if fit else default_keys(reducer)
    loops = _read_loops(loop)
    fit_parameters(reducer, keys, loops)  # raises for an unknown or repeated key
    name = calibrated_name(design)
    destination = claim_destination(output_flags, name, [f"{name}{ending}" for ending in FILES], OUT, with_page=True)
    quiet_delivery, progress = replace(output_flags, quiet=True), count_progress("calibrate", output_flags.quiet)
    try:
        calibration = fit_model(design, loops, keys, held, math.radians(crank_deg), progress)
    except CalibrationStopped as stop:
        write(_calibration_outcome(stop.calibration, destination), destination, quiet_delivery)
        raise RunError(
            f"stopped by {signal_name(stop)}; the values fitted so far are in {destination.folder}. Run the command "
            "again for the complete calibration"
        ) from stop
    if losses:
        write(_calibration_outcome(calibration, destination), destination, quiet_delivery)
        calibration = _fit_loss_models(calibration, destination, output_flags)
    try:
        unusable = _describe_defect(calibration, output_flags.quiet)
    except KeyboardInterrupt as stop:
        write(_calibration_outcome(calibration, destination), destination, quiet_delivery)
        raise RunError(
            f"stopped by {signal_name(stop)}; the calibration is in {destination.folder}, but the calibrated design "
            "was not tested. Test that design with `cycloid-mj design check`, `statics` and `reduce`"
        ) from stop
    return deliver(_calibration_outcome(calibration, destination, unusable), destination, output_flags)


def _read_loops(paths: Iterable[Path]) -> list["MeasuredLoop"]:
    """Read measured loops from CSV files at the `paths` of ``--loop``.

    Raises UsageError if two files have the same name, or a file cannot be read.
    """
    from cycloid_mj.bench import read_loop

    loops = [read_loop(path) for path in paths]
    names = [loop.name for loop in loops]
    if len(set(names)) < len(names):
        raise UsageError(
            f"--loop: two files are named {max(names, key=names.count)}, but results are identified by file name. "
            "Rename one of the files"
        )
    return loops


def _fit_loss_models(
    calibration: "Calibration", destination: Destination, output_flags: CalibrationDelivery
) -> "Calibration":
    """Fit models with different losses to measured loops: constant friction, friction of contacts, lossy material.

    Return the calibration with the fits of all models. After each fit, it is written to the paths of `destination`.
    `output_flags` are those of the output (``--out``, ``--quiet``).

    Raises
    ------
    RunError
        Ctrl-C stopped the fit; the losses fitted so far are written.
    """
    from cycloid_mj.bench import compare_losses
    from cycloid_mj.cli.progress import count_progress

    quiet_delivery = replace(output_flags, quiet=True)
    try:
        return compare_losses(
            calibration,
            count_progress("calibrate: losses", output_flags.quiet),
            lambda partial_calibration: write(
                _calibration_outcome(partial_calibration, destination), destination, quiet_delivery
            ),
        )
    except KeyboardInterrupt as stop:
        raise RunError(
            f"stopped by {signal_name(stop)}; the calibration and the loss models fitted so far are in "
            f"{destination.folder}. Run the command again to fit the other loss models"
        ) from stop


def _describe_defect(calibration: "Calibration", quiet: bool) -> tuple[str, ...]:
    """Test whether a calibrated design can be used; return a sentence on the first failure, or nothing.

    The result is a tuple of one sentence, or an empty tuple. The tests are checks of the design, statics at the torque
    of the loops, and its reduction to a joint (`reduce`). The sentence also lists the fitted parameters that cause the
    failure. A parameter is a cause if the design passes all tests when this parameter alone has its value in the
    original design. With `quiet` no progress is printed.
    """
    from cycloid_mj.cli.progress import show_activity

    torque = max(loop.most for loop in calibration.fitted.loops)
    with show_activity("calibrate: testing the design with its checks, statics and reduce", quiet):
        defect = _first_defect(reducer_of(calibration.design), torque)
    if defect is None:
        return ()
    fit, causes = calibration.fitted, []
    for position, parameter in enumerate(fit.parameters, 1):
        model = fit.model
        for other_parameter, value in zip(fit.parameters, fit.values.tolist(), strict=True):
            model = model if other_parameter == parameter else other_parameter.apply(model, value)
        with show_activity(
            f"calibrate: testing it with the drawn {parameter.key}, {position} of {len(fit.parameters)}", quiet
        ):
            is_usable = _first_defect(model.reducer, torque) is None
        if is_usable:
            causes.append(parameter.key)
    estimates = calibration.estimates
    value_text = " or ".join(
        f"the drawn {key} instead of {estimates[key].value:.4g} {estimates[key].unit}".removesuffix(" 1")
        for key in causes
    )
    alternative_text = ", or fit structure_stiffness instead" if causes == ["tooth_stiffness"] else ""
    remedy = f"with {value_text} it can be used: omit that parameter from --fit{alternative_text}"
    explanation = remedy if causes else "no fitted value alone is the cause; fit other parameters (--fit)"
    return (f"the calibrated design cannot be used: {defect}; {explanation}",)


def _first_defect(reducer: Reducer, torque: float) -> str | None:
    """Return the first error of checks, statics at a torque [N m] and the command `reduce`; None if all succeed."""
    from cycloid_mj.checks import require_sound
    from cycloid_mj.robot import reduce
    from cycloid_mj.statics.sheet import sheet

    tests: tuple[tuple[str, Callable[[], object]], ...] = (
        ("design check", lambda: require_sound(reducer)),
        (f"statics at {torque:.4g} N m", lambda: sheet(reducer, torque)),
        ("reduce", lambda: reduce(reducer.design)),
    )
    for name, run_test in tests:
        try:
            run_test()
        except CycloidError as error:
            return f"{name}: {error}"
    return None


def _calibration_outcome(
    calibration: "Calibration", destination: Destination, unusable: tuple[str, ...] | None = None
) -> Outcome:
    """Convert a calibration to printable results with tables, warnings, figure, page, design file and residuals.

    `destination` has the paths of the files. `unusable` states why the design is unusable or is (); None: not tested.
    """
    from cycloid_mj.base.result import quantity_table
    from cycloid_mj.base.units import DEGREE
    from cycloid_mj.design import dump
    from cycloid_mj.figures import quantities, values_json
    from cycloid_mj.plots.bench import calibration_figure
    from cycloid_mj.plots.save import encode_figure
    from cycloid_mj.report.results import calibration_page

    name, fit = calibration.design.name, calibration.fitted
    design_quantities = quantities(reducer_of(calibration.design))
    residual_rows = ["loop,torque_output_Nm,deflection_deg,model_deg,residual_deg"]
    for loop, model_angles in zip(fit.loops, fit.turns, strict=True):
        measured_angles, model = loop.deflection / DEGREE, model_angles / DEGREE
        residual_rows += [
            f"{loop.name},{torque!r},{measured_angle!r},{modelled_angle!r},{measured_angle - modelled_angle!r}"
            for torque, measured_angle, modelled_angle in zip(
                loop.torque.tolist(), measured_angles.tolist(), model.tolist(), strict=True
            )
        ]
    draw = cache(partial(encode_figure, calibration_figure(calibration)))
    files = {
        f"{name}.toml": dump(calibration.design).encode(),
        f"{name}-residuals.csv": encodable_text("\n".join([*residual_rows, ""])).encode(),
    }
    file_names = [*files, f"{name}-loops.png", f"{name}-loops.svg", f"{name}.json"]
    return Outcome(
        title=f"calibration: {name}",
        failures=unusable or (),
        warnings=[
            *(
                f"the loop does not distinguish {first_key} and {second_key} (correlation {correlation:.3f}): fit one "
                "of them, or measure another loop"
                for first_key, second_key, correlation in calibration.indistinguishable
            ),
            *(
                [f"not determined by the loop: {', '.join(calibration.unidentified)}"]
                if calibration.unidentified
                else []
            ),
            *(f"the model does not fit the loop: {sentence}" for sentence in calibration.misfits),
        ],
        headline=_headline(calibration),
        tables=[*calibration.tables(), quantity_table("figures of the calibrated design", design_quantities.values())],
        summary=[f"measure next: {sentence}" for sentence in calibration.measure_next],
        notes=calibration.notes,
        pictures={f"{name}-loops": draw},
        files=files,
        result=calibration.as_json()
        | {"unusable": None if unusable is None else list(unusable), "figures": values_json(design_quantities)}
        | {"files": [*destination.paths(file_names), str(destination.page)]},
        page=lambda: calibration_page(calibration, draw("svg").decode(), (UNTESTED,) if unusable is None else unusable),
        code=1 if unusable else 0,
    )


def _headline(calibration: "Calibration") -> dict[str, str]:
    """Return the main quantities of a calibration as texts by name, at most `MOST_FIGURES`.

    They are play, stiffness and friction, for the measured loops and for the fitted model, the residual, and the fitted
    parameters.
    """
    from cycloid_mj.base.units import DEGREE

    measured_figures, model_figures = calibration.measured, calibration.modelled
    derived_rows = {
        "play, from the loaded branches": _value_and_model(
            measured_figures.play.value / DEGREE, model_figures.play.value / DEGREE, "deg"
        ),
        "play, at zero torque": _value_and_model(
            measured_figures.width.value / DEGREE, model_figures.width.value / DEGREE, "deg"
        ),
        "stiffness": _value_and_model(measured_figures.stiffness.value, model_figures.stiffness.value, "N m/rad"),
        "Coulomb friction": _value_and_model(measured_figures.coulomb.value, model_figures.coulomb.value, "N m"),
        "residual, rms": f"{calibration.rms / DEGREE:.3g} deg",
    }
    fitted_rows = {
        key: f"{item.value:.4g} {'' if item.unit == '1' else item.unit}".strip()
        + ("" if item.identified else " (not determined by the loop)")
        for key, item in calibration.estimates.items()
    }
    return dict(islice((derived_rows | fitted_rows).items(), MOST_FIGURES))


def _value_and_model(measured: float, model: float, unit: str) -> str:
    """Format a measured figure with its unit, followed by that of the fitted model."""
    return f"{measured:.4g} {unit} (fitted model {model:.4g})"


def compare_bench(
    design_options: Annotated[DesignOptions, FLAT],
    *,
    te: TeFlag,
    load_nm: LoadFlag = None,
    output_flags: Annotated[BenchDelivery, FLAT] = COMPARED,
) -> int:
    """Compare a measured transmission error with the model.

    The file has the columns crank_deg (RV reducer: of the sun) and te_arcsec. The model is the static equilibrium of
    the design under the load; the zero angle of the crank, which a bench does not know, is fitted. Reported for each
    order: both amplitudes, their phase, the share of the measured variance that the model explains, and possible
    causes.
    """
    from cycloid_mj.bench import compare_bench as compare_with_bench
    from cycloid_mj.bench import read_te
    from cycloid_mj.plots.bench import comparison_figure
    from cycloid_mj.plots.save import encode_figure

    measured_error = read_te(te)
    design = design_options.resolve_checked()
    stem = f"{design.name}-{measured_error.name}"
    destination = claim_destination(output_flags, stem, [f"{stem}.png"], OUT_TE)
    comparison = compare_with_bench(design, measured_error, load_nm)
    outcome = Outcome(
        title=f"transmission error of {design.name}, compared with {te}",
        headline={"share of the measured variance that the model explains": f"{comparison.explained_share:.1%}"},
        summary=[f"the model explains {comparison.explained_share:.1%} of the measured curve's variance"],
        tables=[comparison.table()],
        pictures={stem: partial(encode_figure, comparison_figure(comparison))},
        formats=("png",),
        result=comparison.as_json(),
    )
    return deliver(outcome, destination, output_flags)
