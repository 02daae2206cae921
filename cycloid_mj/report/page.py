"""The report of runs: fills the template ``assets/page.html``."""

import json
from collections.abc import Iterator, Sequence
from contextlib import suppress
from functools import cache

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from cycloid_mj.base.errors import CycloidError
from cycloid_mj.checks import Checks
from cycloid_mj.figures import figure
from cycloid_mj.life.checks import check_design
from cycloid_mj.reducer import Reducer
from cycloid_mj.report import tables
from cycloid_mj.report.data import CHARTS, figures, page_data
from cycloid_mj.report.reviewed import Reviewed
from cycloid_mj.statics.sheet import load_of

SCRIPTS = ("scale.js", "chart.js", "plane.js", "mechanism.js", "page.js")


@cache
def environment() -> Environment:
    """Return the environment of the templates in ``assets``; it escapes all text."""
    loader = PackageLoader("cycloid_mj.report", "assets")
    templates = Environment(loader=loader, autoescape=True, undefined=StrictUndefined)
    templates.globals["asset"] = lambda name: Markup(loader.get_source(templates, name)[0])
    return templates


def page(reviewed: Sequence[Reviewed]) -> str:
    """Return the report of one or more runs as the text of one HTML page; several runs are compared side by side.

    `reviewed` are the analysed runs.
    """
    data = page_data(reviewed)
    mechanisms = [run["mechanism"] for run in data["runs"]]
    spectra = {reviewed_run.name: run["spectrum"] for reviewed_run, run in zip(reviewed, data["runs"], strict=True)}
    return (
        environment()
        .get_template("page.html")
        .render(
            title="cycloid_mj: " + " and ".join(reviewed_run.name for reviewed_run in reviewed),
            runs=reviewed,
            several=len(reviewed) > 1,
            settled=all(reviewed_run.motion.phase == "hold" for reviewed_run in reviewed),
            conditions=_conditions(reviewed),
            warnings=[
                (reviewed_run.name, line) for reviewed_run in reviewed for line in reviewed_run.findings.warnings
            ],
            unmet=list(_failed_checks(reviewed)),
            numbers=_main_values,
            animated=any(mechanisms),
            magnified=min((mechanism["usual"] for mechanism in mechanisms if mechanism), default=1),
            widest=[1e3 * mechanism["widest"] if mechanism else None for mechanism in mechanisms],
            tables=tables,
            figures=figures(reviewed),
            bands=[spectrum["band"] for spectrum in spectra.values() if spectrum],
            without_spectrum=[name for name, spectrum in spectra.items() if not spectrum],
            most_turns=CHARTS.max_spectrum_turns,
            # JSON that cannot end the script element that contains it
            data=Markup(json.dumps(data, separators=(",", ":")).replace("</", "<\\/")),
            scripts=SCRIPTS,
        )
    )


def _failed_checks(reviewed: Sequence[Reviewed]) -> Iterator[tuple[str, Checks]]:
    """Yield the checks of each design that has failures or warnings, by the names of the runs."""
    for item in reviewed:
        checks = check_design(item.motion.design)
        if checks.failures or checks.warnings:
            yield item.name, checks


def _main_values(reviewed_run: Reviewed) -> Iterator[tuple[str, str]]:
    """Yield the main results of a run as pairs of name and text with unit.

    They are efficiency, peak-to-peak transmission error and rms speed error of output and disc, largest contact force,
    mean number of contacts, and backlash and stiffness in static equilibrium. The last two are omitted if there is no
    equilibrium. The text of the efficiency is a remark if there is no load, or if the run ended before reaching
    constant speed. `reviewed_run` is the analysed run.
    """
    findings = reviewed_run.findings
    no_value_text = "not evaluated in a ramp" if findings.condition.load else "no load"
    yield "efficiency", no_value_text if findings.efficiency is None else f"{100 * findings.efficiency:.2f} %"
    for part, error, speed in (
        ("output", findings.transmission_error, findings.output_speed),
        (reviewed_run.motion.gear_words, findings.gear_transmission_error, findings.gear_speed),
    ):
        yield f"{part}: transmission error, peak to peak", f"{_format_number(error.peak_to_peak_arcsec)} arcsec"
        yield f"{part}: rms speed error", f"{_format_number(1e3 * speed.rms_error_rad_s)} mrad/s"
    yield "largest contact force", f"{_format_number(findings.contact_summary.peak_force_n, 4)} N"
    yield "mean number of contacts", f"{findings.contact_summary.mean_active:.3g}"
    with suppress(CycloidError):  # no static equilibrium: the checks among the warnings report it
        yield from _static_values(reviewed_run.motion.reducer)


def _static_values(reducer: Reducer) -> Iterator[tuple[str, str]]:
    """Yield backlash and stiffness of the static equilibrium, which a run does not determine."""
    load, _ = load_of(reducer)
    for name, key in (("backlash", "backlash_arcmin"), (f"stiffness at {load:.3g} N m", "stiffness_nm_per_arcmin")):
        catalogue_row = figure(key)
        yield f"{name} (static)", f"{_format_number(catalogue_row.value(reducer))} {catalogue_row.unit}"


def _format_number(value: float, digits: int = 3) -> str:
    """Format a number with significant digits, without an exponent below 1e7."""
    return f"{value:.0f}" if 10.0**digits <= abs(value) < 1e7 else f"{value:.{digits}g}"


def _conditions(reviewed: Sequence[Reviewed]) -> str:
    """Return the common condition of the runs, or that of each run."""
    conditions = {item.name: item.findings.condition_words for item in reviewed}
    if len(set(conditions.values())) == 1:
        return reviewed[0].findings.condition_words
    return "; ".join(f"{name} {words}" for name, words in conditions.items())
