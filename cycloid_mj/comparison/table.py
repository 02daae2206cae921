"""Figures of a comparison: name, unit and access to the measures of a run; and their table."""

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

from cycloid_mj.base.frame import Cell, Frame, make_frame
from cycloid_mj.base.result import Table
from cycloid_mj.comparison.measures import Measures
from cycloid_mj.comparison.starts import StartSpread
from cycloid_mj.comparison.trial import Trial


class ComparedFigure(NamedTuple):
    """A figure of a run; `read` returns it from the run's measures, None where the run has none."""

    words: str
    unit: str
    read: Callable[[Measures], float | None]


def _efficiency(measures: Measures) -> float | None:
    return None if measures.findings.efficiency is None else 100.0 * measures.findings.efficiency


def _spin(measures: Measures) -> float | None:
    return measures.findings.pin1.mean_spin_rad_s if measures.findings.pin1 else None


OUTPUT_ERROR = ComparedFigure(
    "transmission error of the output, p-p", "arcsec", lambda m: m.findings.transmission_error.peak_to_peak_arcsec
)
OUTPUT_SPEED = ComparedFigure("output speed error, rms", "rad/s", lambda m: m.findings.output_speed.rms_error_rad_s)
OUTPUT_VIBRATION = ComparedFigure(
    "vibration of the output, rms acceleration", "rad/s^2", lambda m: m.vibration.output_rad_s2.rms
)
EFFICIENCY = ComparedFigure("efficiency", "%", _efficiency)
GEAR_ERROR = ComparedFigure(
    "transmission error of the gear, p-p", "arcsec", lambda m: m.findings.gear_transmission_error.peak_to_peak_arcsec
)
GEAR_SPEED = ComparedFigure("gear speed error, rms", "rad/s", lambda m: m.fluctuation.gear_speed_rad_s.rms)
CENTRE_VIBRATION = ComparedFigure(
    "vibration of the gear centre, rms acceleration", "m/s^2", lambda m: m.vibration.gear_centre_m_s2.rms
)
Q_PATH = ComparedFigure("q path error, rms, without steady shifts", "um", lambda m: m.fluctuation.q_path_um.rms)
Q_VELOCITY = ComparedFigure(
    "q velocity error, rms, without steady shifts", "mm/s", lambda m: m.fluctuation.q_velocity_mm_s.rms
)
TOOTH_FORCE = ComparedFigure("force on the most loaded tooth, peak", "N", lambda m: m.forces.tooth_peak_n)

ROWS = (
    OUTPUT_ERROR,
    ComparedFigure(
        "play and wind-up of the output, mean", "arcsec", lambda m: m.findings.transmission_error.mean_arcsec
    ),
    OUTPUT_SPEED,
    OUTPUT_VIBRATION,
    EFFICIENCY,
    GEAR_ERROR,
    ComparedFigure(
        "play and wind-up of the gear, mean", "arcsec", lambda m: m.findings.gear_transmission_error.mean_arcsec
    ),
    GEAR_SPEED,
    ComparedFigure("gear speed error, peak", "rad/s", lambda m: m.findings.gear_speed.peak_error_rad_s),
    CENTRE_VIBRATION,
    ComparedFigure("q path error, rms", "um", lambda m: m.findings.q_path.rms_error_um),
    Q_PATH,
    ComparedFigure("q speed error, rms", "mm/s", lambda m: m.findings.q_speed_magnitude.rms_error_mm_s),
    Q_VELOCITY,
    ComparedFigure("contacts in touch, mean", "1", lambda m: m.findings.contact_summary.mean_active),
    ComparedFigure("teeth that carry force, mean", "1", lambda m: m.forces.teeth_mean),
    ComparedFigure("teeth that carry force, least", "1", lambda m: m.forces.teeth_least),
    ComparedFigure("teeth that carry force, most", "1", lambda m: m.forces.teeth_most),
    ComparedFigure("force on the most loaded tooth, mean", "N", lambda m: m.forces.tooth_mean_n),
    TOOTH_FORCE,
    ComparedFigure("force of the cam, mean", "N", lambda m: m.forces.cam_mean_n),
    ComparedFigure("force of the cam, peak", "N", lambda m: m.forces.cam_peak_n),
    ComparedFigure("force of one output pin, peak", "N", lambda m: m.forces.output_pin_peak_n),
    ComparedFigure("force on the most loaded crank bearing, mean", "N", lambda m: m.forces.crank_bearing_mean_n),
    ComparedFigure("force on the most loaded crank bearing, peak", "N", lambda m: m.forces.crank_bearing_peak_n),
    ComparedFigure("force of a planet, peak", "N", lambda m: m.forces.planet_mesh_peak_n),
    ComparedFigure("penetration, largest", "um", lambda m: m.findings.contact_summary.max_penetration_um),
)

DYNAMIC = (
    *(OUTPUT_ERROR, OUTPUT_SPEED, OUTPUT_VIBRATION, GEAR_ERROR, GEAR_SPEED, CENTRE_VIBRATION, Q_PATH, Q_VELOCITY),
    *(TOOTH_FORCE, ComparedFigure("spin of pin 1, mean", "rad/s", _spin), EFFICIENCY),
)
"""Figures that depend on the details of the motion."""

HEADLINE = (OUTPUT_ERROR, GEAR_SPEED, OUTPUT_VIBRATION, CENTRE_VIBRATION, TOOTH_FORCE, EFFICIENCY)
"""Figures of the headline."""

COLUMNS = ("load_nm", "design", "quantity", "unit", "mean", "least", "largest", "starts")


def figure_frame(trials: Iterable[Trial]) -> Frame:
    """Return a table with named columns, `COLUMNS`, of the quantities of simulated designs.

    There is a row for each trial and quantity with a value. A `Trial` has all runs of a design under a load, which
    start from different initial states; the row has the mean, least and largest value of these runs.
    """
    rows: list[dict[str, Cell]] = [
        {
            "load_nm": trial.load,
            "design": trial.name,
            "quantity": figure.words,
            "unit": figure.unit,
            "mean": spread.mean,
            "least": spread.low,
            "largest": spread.high,
            "starts": len(spread.values),
        }
        for trial in trials
        for figure in ROWS
        if (spread := trial.over_starts(figure.read)) is not None
    ]
    return make_frame(rows, COLUMNS, {})


def table(trials: Sequence[Trial]) -> Table:
    """Return a table of the quantities of several designs under one load: name, one column per design, unit.

    `trials` are the runs under this load, a trial with one or more independent runs (starts) for each design. A
    quantity of several starts is written as range and mean; a row without any value is omitted. The title has the time
    window of the first trial and the smallest number of starts.
    """
    findings = trials[0].measures.findings
    window, starts = findings.window, min(len(trial.starts) for trial in trials)
    window_text = f"from {window.start_s:.6g} to {window.end_s:.6g} s ({window.crank_turns:.1f} turns)"
    starts_text = f", range (mean) of {starts} starts" if starts > 1 else ""
    note = ", disc and q of disc 1" if any(trial.measures.findings.discs for trial in trials) else ""
    rows = []
    for figure in ROWS:
        spreads = [trial.over_starts(figure.read) for trial in trials]
        if any(spread is not None for spread in spreads):
            rows.append((figure.words, *("" if spread is None else _words(spread) for spread in spreads), figure.unit))
    header = ("quantity", *(trial.name for trial in trials), "unit")
    return Table(f"{findings.condition}: {window_text}{starts_text}{note}", header, tuple(rows))


def _words(spread: StartSpread) -> str:
    return f"{spread.mean:.4g}" if len(spread.values) == 1 else f"{spread.words} ({spread.mean:.3g})"
