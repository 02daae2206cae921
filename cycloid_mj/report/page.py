"""The page: its sections in order, and the data that its figures are drawn from."""

import json
from collections.abc import Sequence
from importlib.resources import files
from typing import Any

from cycloid_mj.report import html, tables
from cycloid_mj.report.curves import Figure
from cycloid_mj.report.data import MOST_TURNS, figures, page_data, spectrum_data
from cycloid_mj.report.reviewed import PALETTE, Reviewed, labels

SCRIPTS = ("scale.js", "chart.js", "plane.js", "mechanism.js", "page.js")


def page(reviewed: Sequence[Reviewed]) -> str:
    """Give the page of the runs."""
    title = "cycloid_mj: " + " and ".join(labels(reviewed))
    head = [
        '<meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        html.tag("title", html.text(title)),
        html.tag("style", _asset("page.css")),
    ]
    scripts = [
        html.tag("script", _json(page_data(reviewed)), type_="application/json", id_="data"),
        *(html.tag("script", _asset(name)) for name in SCRIPTS),
    ]
    body = html.tag("main", "".join(_sections(reviewed, title))) + "".join(scripts)
    return f'<!doctype html>\n<html lang="en"><head>{"".join(head)}</head>\n<body>{body}</body></html>\n'


def _sections(reviewed: Sequence[Reviewed], title: str) -> list[str]:
    return [
        html.tag("header", html.tag("h1", html.text(title)) + _badges(reviewed)),
        _warned(reviewed),
        _section("What was run", tables.setup(reviewed)),
        _section("The mechanism", _mechanisms(reviewed)),
        _section(f"Simulated, closed form, error: {_conditions(reviewed)}", tables.findings(reviewed)),
        _section(f"Over time: {_conditions(reviewed)}", _over_time(reviewed), "figures"),
        _section("Order spectrum of the speeds of output and gear", _spectrum(reviewed)),
        _section("Where the power goes", tables.losses(reviewed)),
        _section("Provenance", tables.provenance(reviewed)),
    ]


def _section(title: str, content: str, kind: str = "") -> str:
    return html.tag("section", html.tag("h2", html.text(title)) + content, **({"class_": kind} if kind else {}))


def _badges(reviewed: Sequence[Reviewed]) -> str:
    """Give the numbers that one looks for first, by run."""
    rows = []
    for item, name, colour in zip(reviewed, labels(reviewed), PALETTE, strict=False):
        found = item.findings
        numbers = [
            ("efficiency", f"{100 * found.efficiency:.2f} %" if found.efficiency is not None else _no_efficiency(item)),
            ("output: transmission error, p-p", f"{found.transmission_error.peak_to_peak_arcsec:.3g} arcsec"),
            ("output: speed, rms error", f"{1e3 * found.output_speed.rms_error_rad_s:.3g} mrad/s"),
            ("gear: transmission error, p-p", f"{found.gear_transmission_error.peak_to_peak_arcsec:.3g} arcsec"),
            ("gear: speed, rms error", f"{1e3 * found.gear_speed.rms_error_rad_s:.3g} mrad/s"),
            ("largest contact force", f"{found.contact_summary.peak_force_n:.4g} N"),
            ("contacts, mean", f"{found.contact_summary.mean_active:.3g}"),
        ]
        cards = "".join(
            html.tag("div", html.tag("dt", html.text(key)) + html.tag("dd", html.text(value))) for key, value in numbers
        )
        state = "complete" if found.complete else "stopped early"
        judged = f"{found.condition_words}, {found.window.phase} of {found.window.crank_turns:.2f} crank turns"
        named = html.tag("b", html.text(name), style=f"color:{colour}") if len(reviewed) > 1 else ""
        line = html.tag("p", f"{named} {html.text(f'{judged}; {item.log}: {state}')}", class_="log")
        rows.append(line + html.tag("dl", cards))
    return "".join(rows)


def _no_efficiency(item: Reviewed) -> str:
    return "no load" if not item.findings.condition.load_nm else "not in a ramp"


def _warned(reviewed: Sequence[Reviewed]) -> str:
    names = labels(reviewed)
    told = [(name, line) for item, name in zip(reviewed, names, strict=True) for line in tables.warnings(item)]
    if not told:
        return ""
    several = len(reviewed) > 1
    lines = "".join(html.tag("li", html.text(f"{name}: {line}" if several else line)) for name, line in told)
    return html.tag("section", html.tag("h2", "Warnings") + html.tag("ul", lines), class_="warnings")


def _mechanisms(reviewed: Sequence[Reviewed]) -> str:
    """Give the places that the page draws the moving mechanism in, and the controls that all of them share."""
    controls = (
        '<div class="controls" id="animation">'
        '<button id="play" type="button">Play</button>'
        '<input id="frame" type="range" min="0" max="1000" value="0" step="1" aria-label="crank angle">'
        '<label>one turn in <select id="pace"><option>2</option><option selected>5</option><option>10</option>'
        "<option>30</option></select> s</label>"
        '<label>gaps &times; <select id="magnify"></select></label>'
        '<label><input id="forces" type="checkbox" checked> forces</label></div>'
    )
    views = "".join(
        html.tag(
            "figure",
            '<div class="clock"></div><div class="mechanism"></div><div class="ring"></div><div class="legend"></div>'
            + html.tag("figcaption", html.text(_drawn(item, name))),
            id_=f"mechanism-{index}",
            class_="views",
        )
        for index, (item, name) in enumerate(zip(reviewed, labels(reviewed), strict=True))
    )
    return controls + html.tag("div", views, **({"class_": "several"} if len(reviewed) > 1 else {}))


def _drawn(item: Reviewed, name: str) -> str:
    closed = "; the black line is ideal load sharing" if item.motion.design.ring.kind == "pin" else ""
    return (
        f"{name}, {item.findings.condition_words}, one crank turn of the {item.findings.window.phase}: the mechanism "
        "from the output side with the forces on the gear (ring, cam and output pins have scales of their own; an "
        "overlap is elastic approach), and the force at each place of "
        f"the ring{closed}, the light line the largest of the turn."
    )


def _conditions(reviewed: Sequence[Reviewed]) -> str:
    """Give the condition that all runs share, or that of each."""
    told = [item.findings.condition_words for item in reviewed]
    if len(set(told)) == 1:
        return told[0]
    return "; ".join(f"{name} {words}" for name, words in zip(labels(reviewed), told, strict=True))


def _over_time(reviewed: Sequence[Reviewed]) -> str:
    settled = all(item.motion.phase == "hold" for item in reviewed)
    return _toolbar(settled) + "".join(_figure(figure) for figure in figures(reviewed))


def _toolbar(settled: bool) -> str:
    spans = (("hold", "settled hold" if settled else "judged"), ("turn", "one turn"), ("all", "whole run"))
    buttons = "".join(html.tag("button", name, type_="button", data_span=key) for key, name in spans)
    hint = "Drag or pinch to zoom, double-click to go back; the cursor is shared."
    return html.tag("div", buttons + html.tag("span", hint, class_="hint"), class_="controls")


def _figure(figure: Figure) -> str:
    """Give the place of a figure that the page draws."""
    path = f'<div class="path" data-path="{figure.path}"></div>' if figure.path else ""
    caption = html.tag("b", html.text(figure.title)) + " " + html.text(figure.caption)
    inside = f'<div class="row">{path}<div class="chart"></div></div>' + html.tag("figcaption", caption)
    return html.tag("figure", inside, id_=f"figure-{figure.name}", class_="plot")


def _spectrum(reviewed: Sequence[Reviewed]) -> str:
    spectra = dict(zip(labels(reviewed), map(spectrum_data, reviewed), strict=True))
    missing = [name for name, spectrum in spectra.items() if spectrum is None]
    if len(missing) == len(reviewed):
        return html.tag("p", "The hold is shorter than a crank turn, or was not reached: there is no spectrum.")
    note = f" Not for {', '.join(missing)}: its hold is shorter than a turn." if missing else ""
    bands = [spectrum["band"] for spectrum in spectra.values() if spectrum is not None]
    low, high = max(band[0] for band in bands), min(band[1] for band in bands)
    caption = (
        f"{_conditions(reviewed)}. Amplitude of the speed about its mean, over whole crank turns (at most "
        f"{MOST_TURNS}) with a Hann window, right within 1 % from order {low:.3g} to {high:.4g}. "
        f"Dashed: the mesh orders, multiples of the number of ring teeth per crank turn.{note}"
    )
    inside = '<div class="chart"></div>' + html.tag("figcaption", html.text(caption))
    return html.tag("figure", inside, id_="figure-spectrum", class_="plot wide")


def _json(value: Any) -> str:
    """Give JSON that cannot end the script element it stands in."""
    return json.dumps(value, separators=(",", ":")).replace("</", "<\\/")


def _asset(name: str) -> str:
    return files("cycloid_mj.report").joinpath("assets", name).read_text(encoding="utf-8")
