"""The page of a reduced joint: its parameters, a comparison with the full model, and how to use it."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from markupsafe import Markup

from cycloid_mj.base.result import Curve, Table
from cycloid_mj.base.text import four_digits
from cycloid_mj.base.units import RPM
from cycloid_mj.report.encode import encode_array
from cycloid_mj.report.page import environment
from cycloid_mj.report.tables import TextTable
from cycloid_mj.robot.comparison import ModelComparison
from cycloid_mj.robot.population import Population
from cycloid_mj.robot.reducer import ReducedJoint
from cycloid_mj.robot.stability import StepTrial, recommended_table, trials_table

SCRIPTS = ("scale.js", "chart.js", "joint.js")

MIN_HARMONIC = 0.01
"""Smallest harmonic that is listed, relative to the largest."""

FRICTION_LOADS = (0.0, 0.5, 1.0)
"""Loads relative to the nominal torque at which a constant friction is listed, for formats that have no other."""


def joint_page(
    reduced: ReducedJoint,
    comparison: ModelComparison,
    steps: Sequence[StepTrial],
    scene: StepTrial,
    bam: Mapping[str, Any],
    drives: Population | None = None,
) -> str:
    """Return the report of a reduced joint, the model of a drive for robot simulators, as one HTML page.

    Parameters
    ----------
    comparison
        Its comparison with the full model.
    steps
        Trials of time steps, from `study_time_steps`.
    scene
        Trial of the time step in scene.xml.
    bam
        Parameters of the friction models of BAM (Better Actuator Models), from `fit_bam_models`.
    drives
        Joints of drives with randomly drawn tolerances, if they were computed.
    """
    panels = list(dict.fromkeys(curve.panel for curve in comparison.curves))
    figures = [_chart_data([curve for curve in comparison.curves if curve.panel == panel]) for panel in panels]
    return (
        environment()
        .get_template("joint.html")
        .render(
            title=f"cycloid_mj: {reduced.name} as a joint",
            reducer=reduced,
            numbers=list(_main_values(reduced).items()),
            quantities=_quantity_table(reduced),
            population=[
                {"title": table.title, "text": TextTable.of(table)} for table in (drives.tables() if drives else ())
            ],
            comparison=TextTable.of(comparison.table()),
            missed=comparison.outside_bounds,
            figures=figures,
            steps=TextTable.of(trials_table(tuple(steps))),
            longest=TextTable.of(recommended_table(tuple(steps))),
            asked=scene,
            dynamics=_friction_table(reduced),
            efficiency=TextTable.of(_efficiency_table(reduced)),
            harmonics=_harmonics_table(reduced),
            te_rpm=comparison.highest_speed_rpm,
            bam=_bam_table(bam),
            data=Markup(json.dumps({"figures": figures}, separators=(",", ":")).replace("</", "<\\/")),
            scripts=SCRIPTS,
        )
    )


def _main_values(reduced: ReducedJoint) -> dict[str, str]:
    """Return the main quantities of a joint as texts with units: ratio, backlash, stiffness, efficiency and inertia.

    `reduced` is the joint model.
    """
    quantities = reduced.quantities
    return {
        "ratio": f"{reduced.ratio:g}:1",
        "backlash": f"{quantities['backlash_arcmin'].value:.3g} arcmin",
        "stiffness [N m/arcmin]": f"{quantities['stiffness_nm_per_arcmin'].value:.4g}",
        "efficiency": f"{quantities['efficiency'].value:.2f} %",
        "back-driving": f"{quantities['back_driving_efficiency'].value:.2f} %",
        "inertia at the output": f"{reduced.reflected_inertia:.3g} kg m²",
    }


def _quantity_table(reduced: ReducedJoint) -> TextTable:
    """Tabulate all identified quantities of a joint with their units, and their numerical errors in these units.

    `reduced` is the joint model.
    """
    rows = [
        (
            quantity.name,
            four_digits(quantity.value),
            quantity.unit,
            "" if quantity.error is None else f"{quantity.error:.2g}",
        )
        for quantity in reduced.quantities.values()
    ]
    return TextTable([("quantity", "value", "unit", "numerical error")], rows)


def _chart_data(curves: Sequence[Curve]) -> dict[str, Any]:
    """Return the data of a chart of `curves` as JSON values: title, axis labels, range of x, and points of curves.

    Title and labels are those of the first curve. ``span`` is the range of x over all curves. Each item of ``curves``
    has name, x, y, and ``theory``, which is true for a curve of the full model and false for one of the reduced joint.
    """
    first_curve = curves[0]
    curve_data = []
    for curve in curves:
        order = np.argsort(curve.x, kind="stable")
        curve_data.append(
            {
                "name": curve.name,
                "x": encode_array(curve.x[order]),
                "y": encode_array(curve.y[order]),
                "theory": curve.style == "theory",
            }
        )
    span = [min(float(curve.x.min()) for curve in curves), max(float(curve.x.max()) for curve in curves)]
    return {
        "title": first_curve.panel,
        "x_label": first_curve.x_label,
        "y_label": first_curve.y_label,
        "span": span,
        "curves": curve_data,
    }


def _friction_table(reduced: ReducedJoint) -> TextTable:
    """Tabulate constant friction [N m] and damping [N m s/rad] for simulators without load-dependent friction.

    A row is for one of `FRICTION_LOADS`, shares of the nominal torque. It has the friction of the joint at the rated
    speed under this load, with the crank driving and with the output driving, and the damping without a load. `reduced`
    is the joint model.
    """
    rows = []
    for load_share in FRICTION_LOADS:
        torque, speed = load_share * reduced.rated_torque, reduced.rated_speed
        torques = (reduced.ratio * reduced.friction.torque(torque, speed, is_driving) for is_driving in (True, False))
        rows.append(
            (
                f"correct at {load_share:.0%} of the nominal torque",
                *(f"{torque_at_joint:.4g}" for torque_at_joint in torques),
                f"{reduced.no_load_damping_at_output:.3g}",
            )
        )
    return TextTable([("", "friction, driving [N m]", "friction, driven [N m]", "damping [N m s/rad]")], rows)


def _efficiency_table(reduced: ReducedJoint) -> Table:
    """Tabulate the efficiency [%]: a row for each output torque, and two columns for each crank speed.

    The two columns have the efficiencies with the crank driving and with the output driving. `reduced` is the joint
    model.
    """
    friction = reduced.friction
    header = ["output torque [N m]"]
    rows: list[list[float]] = [[torque] for torque in friction.torques[1:]]
    for speed in friction.speeds:
        for is_driving, direction in ((True, "driving"), (False, "driven")):
            header.append(f"{direction}, {speed / RPM:.0f} rpm [%]")
            for row in rows:
                row.append(100.0 * friction.efficiency(row[0], speed, reduced.ratio, is_driving))
    return Table("Efficiency", tuple(header), tuple(map(tuple, rows)))


def _harmonics_table(reduced: ReducedJoint) -> TextTable:
    """Tabulate the harmonics of the transmission error at nominal torque: amplitudes and numerical errors [arcsec].

    Harmonics below `MIN_HARMONIC` of the largest are left out. `reduced` is the joint model.
    """
    load = reduced.ripple.loads[-1] * reduced.rated_torque
    rated_harmonics = [
        harmonic
        for harmonic in reduced.ripple.harmonics(reduced.way, reduced.rated_torque)
        if harmonic["load_nm"] == load
    ]
    min_amplitude = MIN_HARMONIC * max((harmonic["value"] for harmonic in rated_harmonics), default=0.0)
    harmonics_by_order: dict[float, list[dict[str, Any]]] = {}
    for harmonic in rated_harmonics:
        harmonics_by_order.setdefault(harmonic["order"], []).append(harmonic)
    rows = [
        (
            f"{order:.5g}",
            *(
                text
                for harmonic in directions
                for text in (f"{harmonic['value']:.4g}", f"{harmonic['numerical_error']:.1g}")
            ),
        )
        for order, directions in harmonics_by_order.items()
        if max(harmonic["value"] for harmonic in directions) >= min_amplitude
    ]
    header = ("order of the crank", "forward [arcsec]", "num. error", "reverse [arcsec]", "num. error")
    return TextTable([header], rows)


def _bam_table(bam: Mapping[str, Any]) -> TextTable:
    """Tabulate the parameters of BAM's friction models M3 and M5, and the largest errors of their friction [N m].

    BAM (Better Actuator Models) simulates the motors of robot joints. `bam` is the result of `fit_bam_models`.
    """
    models = [bam["m3"], bam["m5"]]
    keys = [key for key in models[1] if key != "model"]
    keys = list(dict.fromkeys([*(key for key in models[0] if key != "model"), *keys]))
    rows = [(key, *(f"{model[key]:.5g}" if key in model else "" for model in models)) for key in keys]
    rows.append(("largest error of friction [N m]", *(f"{bam['largest_error_nm'][key]:.3g}" for key in ("m3", "m5"))))
    return TextTable([("parameter", "M3", "M5")], rows)
