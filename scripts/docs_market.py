"""Compare drives of `design new` with makers' drives: docs/data/market.csv and tables of docs/market.md and docs/rv.md.

python scripts/docs_market.py                      # the tables, from docs/data/market.csv
python scripts/docs_market.py FOLDER               # first the table for download, from a record of each drive
python scripts/docs_market.py --drive rv20e        # create and rate one drive, and print its record; about a minute

The requirement of a drive is the maker's torque, speed, life and size. If it is refused, the drive that is compared has
`SHARES` of the maximum torque that the refusal states. `scripts/docs_figures.py` calls this.
"""

import argparse
import json
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from docs_page import DATA, DOCS, csv_text, markdown_table, read_csv, replace_sections

from cycloid_mj.base.atomic_write import write_files
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.sizing.search import floor_digits

PAGE, RV_PAGE, KEPT = DOCS / "market.md", DOCS / "rv.md", DATA / "market.csv"
SCRIPT = "scripts/docs_market.py"
COLUMNS = ("point", "figure", "unit", "theirs", "source", "ours", "ratio", "note")
"""Columns of the table for download; `ours` and `theirs` in `unit`, `source` is one of `SOURCES`."""

SOURCES = {"S": "read in a catalogue or paper", "M": "from memory, to be checked"}
SHARES = (0.95, 0.9, 0.8)
"""Shares of the stated maximum torque that are requested after a refusal, until a drive is created (heuristic)."""


@dataclass(frozen=True)
class MarketDrive:
    """A drive of `design new`, and the maker's drive with which it is compared."""

    theirs: str
    """Name in `MAKERS`."""
    label: str
    """Heading of the column, unique among the drives of a maker's drive."""
    flags: tuple[str, ...]
    torque: float
    """Required torque [N m]."""
    length: float | None = None
    """Length of the maker's drive [mm], requested first."""
    record: str = ""
    """Name of the drive with the same requirement whose record is used; empty for a record of its own."""

    @property
    def point(self) -> str:
        """Name of the comparison in the table for download."""
        return f"{self.theirs}, {self.label}"

    @property
    def is_rv(self) -> bool:
        """Whether the drive is an RV reducer."""
        return "rv" in self.flags


MAKERS: Mapping[str, Mapping[str, tuple[str, str]]] = {
    "RV-20E": {
        "rated_torque": ("167", "S"),
        "acceleration_torque": ("412", "S"),
        "momentary_torque": ("833", "S"),
        "diameter": ("145", "M"),
        "length": ("65", "M"),
        "mass": ("4.7", "S"),
        "lost_motion": ("at most 1", "M"),
        "stiffness": ("49", "M"),
        "tilting_moment": ("882", "M"),
        "tilting_stiffness": ("372", "M"),
    },
    "RV-42N": {
        "rated_torque": ("412", "S"),
        "acceleration_torque": ("1029", "S"),
        "momentary_torque": ("2058", "S"),
        "diameter": ("190", "M"),
        "mass": ("9.3", "S"),
        "lost_motion": ("at most 1", "S"),
        "stiffness": ("113", "S"),
    },
    "RV-80E": {
        "rated_torque": ("784", "S"),
        "diameter": ("222", "M"),
        "mass": ("13.1", "S"),
        "lost_motion": ("at most 1", "M"),
        "stiffness": ("196", "M"),
        "tilting_moment": ("2156", "M"),
        "tilting_stiffness": ("1176", "M"),
    },
    "RV-40E": {
        "rated_torque": ("412", "S"),
        "acceleration_torque": ("1029", "S"),
        "momentary_torque": ("2058", "S"),
        "diameter": ("190", "M"),
        "mass": ("9.3", "S"),
        "lost_motion": ("at most 1", "M"),
        "stiffness": ("108", "M"),
        "tilting_stiffness": ("931", "M"),
    },
    "RV-110E": {
        "rated_torque": ("1078", "M"),
        "diameter": ("244", "M"),
        "mass": ("17.4", "S"),
        "lost_motion": ("at most 1", "M"),
        "stiffness": ("294", "M"),
        "tilting_stiffness": ("1470", "M"),
    },
    "RV-320E": {
        "rated_torque": ("3136", "S"),
        "diameter": ("325", "S"),
        "length": ("125", "S"),
        "mass": ("44.3", "S"),
        "lost_motion": ("at most 1", "M"),
        "stiffness": ("980", "M"),
        "tilting_moment": ("7056", "S"),
        "tilting_stiffness": ("4900", "M"),
    },
    "TS 70": {"rated_torque": ("50", "M"), "diameter": ("70", "S"), "lost_motion": ("at most 1.5", "M")},
    "TS 110": {"rated_torque": ("122", "M"), "diameter": ("110", "S"), "lost_motion": ("at most 1.5", "M")},
    "CSF-25-50": {
        "rated_torque": ("39", "S"),
        "momentary_torque": ("186", "S"),
        "diameter": ("107", "M"),
        "mass": ("1.5", "S"),
        "stiffness": ("12.8", "S"),
        "starting_torque": ("0.15", "S"),
        "back_driving_torque": ("9", "S"),
    },
    "AK80-64": {
        "rated_torque": ("48", "S"),
        "momentary_torque": ("120", "S"),
        "diameter": ("98", "S"),
        "length": ("62", "S"),
        "mass": ("0.85", "S"),
    },
    "Bench drive": {
        "momentary_torque": ("25", "S"),
        "diameter": ("100", "S"),
        "backlash": ("94", "S"),
        "stiffness": ("0.10", "S"),
    },
}
"""Values of the makers' drives by name and figure, in the units of `FIGURES`: value and source."""

CATALOGUE = ("--output-rpm", "15", "--cooling", "mounted")
MOTOR_SPEED = ("--speed-rpm", "2000", "--cooling", "mounted")
MAIN_BEARINGS = ("--set", "cranks.main_bearings=angular_contact")
RV = ("--layout", "rv", "--ratio", "121", "--cooling", "mounted", *MAIN_BEARINGS)
FINE = ("--clearance-um", "1")


def _central(ratio: int, diameter: float, *conditions: str) -> tuple[str, ...]:
    return "--ratio", f"{ratio}", "--diameter-mm", f"{diameter:g}", "--discs", "auto", *conditions


DRIVES: Mapping[str, MarketDrive] = {
    "rv20e": MarketDrive("RV-20E", "ours", _central(40, 145, *CATALOGUE), 167.0, 65.0),
    "rv20e_rv": MarketDrive("RV-20E", "ours, RV", (*RV, "--diameter-mm", "145"), 167.0, 65.0),
    "rv42n": MarketDrive("RV-42N", "ours", _central(40, 190, *CATALOGUE), 412.0),
    "rv42n_rv": MarketDrive("RV-42N", "ours, RV", (*RV, "--diameter-mm", "190"), 412.0),
    "rv80e_rv": MarketDrive("RV-80E", "ours, RV", (*RV, "--diameter-mm", "222"), 784.0),
    "rv40e_rv": MarketDrive("RV-40E", "ours, RV", (*RV, "--diameter-mm", "190"), 412.0, record="rv42n_rv"),
    "rv110e_rv": MarketDrive("RV-110E", "ours, RV", (*RV, "--diameter-mm", "244"), 1078.0),
    "rv320e_rv": MarketDrive("RV-320E", "ours, RV", (*RV, "--diameter-mm", "325"), 3136.0, 125.0),
    "ts70": MarketDrive("TS 70", "ours", _central(35, 70, *MOTOR_SPEED), 50.0),
    "ts70_fine": MarketDrive("TS 70", "ours, 1 um", _central(35, 70, *MOTOR_SPEED, *FINE), 50.0),
    "ts110": MarketDrive("TS 110", "ours", _central(35, 110, *MOTOR_SPEED), 122.0),
    "csf25": MarketDrive("CSF-25-50", "ours", (*_central(50, 107, *MOTOR_SPEED), "--life-h", "7000"), 39.0),
    "ak80": MarketDrive("AK80-64", "ours", _central(64, 98, *MOTOR_SPEED), 48.0, 62.0),
    "bench": MarketDrive(
        "Bench drive", "ours", ("--ratio", "13", "--diameter-mm", "100", "--process", "printed"), 12.5
    ),
}
"""Drives by the name of their design file.

Makers rate a reducer that is bolted to a machine: cooling is ``mounted``. Without a speed, an RV reducer turns its
output at 15 rpm; without a duty, it is loaded for 40 % of the time. RV reducers have main bearings, as the makers'
drives have. The bench drive carried 25 N m for a short time: half of it is required, because a drive of `design new`
has to withstand twice the required torque.
"""

CREATED = tuple(name for name, drive in DRIVES.items() if not drive.record)
"""Names of the drives that are created: the others use their records."""

FIGURES: Mapping[str, tuple[str, str]] = {
    "rated_torque": ("rated torque", "N m"),
    "perfect_torque": ("rated torque, perfect parts", "N m"),
    "acceleration_torque": ("acceleration torque", "N m"),
    "momentary_torque": ("momentary torque", "N m"),
    "diameter": ("diameter", "mm"),
    "length": ("length", "mm"),
    "mass": ("mass", "kg"),
    "lost_motion": ("lost motion", "arcmin"),
    "backlash": ("backlash", "arcmin"),
    "stiffness": ("torsional stiffness", "N m/arcmin"),
    "tilting_moment": ("tilting moment", "N m"),
    "tilting_stiffness": ("tilting stiffness", "N m/arcmin"),
    "starting_torque": ("starting torque", "N m"),
    "back_driving_torque": ("back-driving torque", "N m"),
    "efficiency": ("efficiency", "%"),
    "disc_over_ring": ("disc warmer than the ring", "K"),
}
"""Label and unit of each figure, in the order of the tables."""

ALWAYS_SHOWN = ("rated_torque", "length", "mass", "efficiency")
"""Figures that every table of the page has; others only if a maker states them."""

SHEET = {
    "rated_torque": "rated_torque_toleranced",
    "perfect_torque": "rated_torque",
    "acceleration_torque": "acceleration_torque",
    "momentary_torque": "momentary_torque_toleranced",
    "diameter": "drive_diameter_mm",
    "length": "drive_length_mm",
    "mass": "drive_mass_kg",
    "lost_motion": "lost_motion_ideal",
    "stiffness": "stiffness_ideal",
    "tilting_moment": "output_tilting_capacity_nm",
    "tilting_stiffness": "output_tilting_stiffness_nm_per_arcmin",
    "starting_torque": "starting_torque_drive",
    "back_driving_torque": "back_driving_torque_drive",
    "efficiency": "drive_efficiency_percent",
}
"""Key of each figure in the data sheet of a drive with a central crank, but of its backlash."""

RV_SHEET = {
    "rated_torque": "rated_torque",
    "momentary_torque": "momentary_torque",
    "diameter": "outer_diameter",
    "length": "length",
    "mass": "mass",
    "lost_motion": "lost_motion_ideal",
    "backlash": "backlash",
    "stiffness": "stiffness_ideal",
    "tilting_moment": "output_tilting_capacity_nm",
    "tilting_stiffness": "output_tilting_stiffness_nm_per_arcmin",
    "efficiency": "efficiency",
    "disc_over_ring": "disc_over_ring",
}
"""Key of each figure in the data sheet of an RV reducer."""

MOST, CHANGES = "maximum torque", "feasible changes"
"""Figures of a refusal in the table for download."""

MASSES = {
    "ring and ring pins": ("housing", "pin", "sleeve", "stop_ring"),
    "discs": ("gear",),
    "crank": ("shaft", "cam", "spacer", "crank", "key", "sun", "planet"),
    "carrier and output pins": ("output", "carrier"),
    "output flange": ("output_flange",),
    "covers": ("motor_cover", "output_cover"),
    "bearings": ("cam_bearing", "shaft_bearing", "output_bearing", "tapered_bearing", "needle"),
    "screws, dowels and others": (),
}
"""Items of the mass, with the beginnings of the names of their parts; the longest beginning decides."""

LENGTHS = ("motor side", "ring", "output side")

MAX_COLUMNS = 100
"""Longest line of a command on the page."""

TABLES: Mapping[str, tuple[str, ...]] = {
    "Nabtesco RV": ("RV-20E", "RV-42N", "RV-80E"),
    "Nabtesco RV-E, other sizes": ("RV-40E", "RV-110E", "RV-320E"),
    "TwinSpin (TS), strain wave gear (CSF), actuator (AK80)": ("TS 70", "TS 110", "CSF-25-50", "AK80-64"),
    "Printed 13:1 drive": ("Bench drive",),
}
"""Tables of the page: heading, and names of the makers' drives."""


def create_drive(name: str) -> dict[str, Any]:
    """Create a drive by `design new`, with less torque if the requirement is refused, and compute its figures.

    Returns
    -------
    dict
        JSON values. ``requests``: command, and the maximum and the reason of a refusal. ``figures``: value and note by
        key of `FIGURES`. ``mass`` [kg] and ``length`` [mm] by item.
    """
    drive = DRIVES[name]
    with tempfile.TemporaryDirectory() as folder:
        requests, shortlist = _request_drive(drive, name, Path(folder))
        file = Path(folder) / f"{name}.toml"
        figures = _sheet_figures(file, RV_SHEET if drive.is_rv else SHEET)
        masses, lengths = (_rv_masses(file), {}) if drive.is_rv else _parts(file)
    if not drive.is_rv:
        backlash = shortlist["backlash_p95_arcmin"]
        figures["backlash"] = {"value": backlash, "note": "95 % percentile of the tolerance study"}
    return {"requests": requests, "figures": figures, "mass": masses, "length": lengths}


def _run(*words: str) -> dict[str, Any]:
    """Run a command that prints JSON, also where it refuses a requirement."""
    command = [sys.executable, "-m", "cycloid_mj", *words, "--json", "--quiet"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if not done.stdout:
        raise ValueError(f"{' '.join(words)}: {done.stderr}")
    return dict(json.loads(done.stdout))


def _request_drive(drive: MarketDrive, name: str, folder: Path) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Return all requests with their refusals, and the figures of the drive that was created last.

    The drive is requested as required, then without its length, then with `SHARES` of the maximum torque that the last
    refusal states.
    """
    requests: list[dict[str, Any]] = []
    for length in dict.fromkeys((drive.length, None)):
        answer = _request(requests, drive, name, drive.torque, length, folder)
        if answer.get("designs"):
            return requests, answer["designs"][0]["figures"]
    for share in SHARES:
        torque = floor_digits(share * answer["most"])
        smaller = _request(requests, drive, name, torque, None, folder)
        if smaller.get("designs"):
            return requests, smaller["designs"][0]["figures"]
    raise ValueError(f"{name}: no drive for {SHARES[-1]} of the stated maximum")


def _request(
    requests: list[dict[str, Any]],
    drive: MarketDrive,
    name: str,
    torque: float,
    length: float | None,
    folder: Path,
) -> dict[str, Any]:
    """Run `design new`, append the command with its refusal to `requests`, and return the output."""
    limit = ("--length-mm", f"{length:g}") if length else ()
    words = ("design", "new", name, *drive.flags, *limit, "--torque-nm", f"{torque:g}")
    answer = _run(*words, "--out", str(folder))
    refusal = {} if answer.get("designs") else {key: answer[key] for key in ("most", "limit", "why")}
    changes = [way["words"] for way in answer.get("ways", ())]
    requests.append(
        {"command": f"cycloid-mj {' '.join(words)}", "torque": torque, "length": length, **refusal, "changes": changes}
    )
    return answer


def _sheet_figures(file: Path, keys: Mapping[str, str]) -> dict[str, Any]:
    """Return value and note of the figures of a data sheet; `keys` are their keys there."""
    with tempfile.TemporaryDirectory() as folder:
        quantities = _run("datasheet", str(file), "--out", folder)["quantities"]
    return {
        key: {"value": row["value"], "note": row["condition"]}
        for key, place in keys.items()
        if (row := quantities.get(place)) and row["value"] is not None
    }


def _rv_masses(file: Path) -> dict[str, float]:
    """Return the mass of an RV reducer [kg] by item."""
    from cycloid_mj.design import load
    from cycloid_mj.parts.export.rv_assembly import rv_masses
    from cycloid_mj.reducer import RvReducer

    return group_masses(rv_masses(RvReducer(load(file))).items())


def _parts(file: Path) -> tuple[dict[str, float], dict[str, float]]:
    """Return the mass [kg] and the length [mm] of a drive with a central crank by item."""
    from cycloid_mj.design import load
    from cycloid_mj.parts.export.bill import bill
    from cycloid_mj.parts.export.casing import casing
    from cycloid_mj.reducer import Reducer

    reducer = Reducer(load(file))
    drive_casing = casing(reducer)
    masses = group_masses((line.item, line.mass_kg) for line in bill(reducer, casing=drive_casing))
    (low, high), end = drive_casing.ends, drive_casing.end
    lengths = (MILLIMETRES * length for length in (-low - end, 2.0 * end, high - end))
    return masses, dict(zip(LENGTHS, lengths, strict=True))


def group_masses(parts: Iterable[tuple[str, float]]) -> dict[str, float]:
    """Add the masses of the parts of each item of `MASSES`."""
    masses = dict.fromkeys(MASSES, 0.0)
    *_, others = MASSES
    for part, mass in parts:
        beginnings = [(len(name), item) for item, names in MASSES.items() for name in names if part.startswith(name)]
        masses[max(beginnings)[1] if beginnings else others] += mass
    return masses


def market_rows(records: Mapping[str, Mapping[str, Any]]) -> Iterator[tuple[str, ...]]:
    """Yield the rows of the table for download, in the order of `COLUMNS`, from the record of each drive."""
    for name, drive in DRIVES.items():
        record, maker = records[name], MAKERS[drive.theirs]
        yield drive.point, "command", "", "", "", "", "", record["requests"][-1]["command"]
        for request in record["requests"]:
            if "most" in request:
                within = _within(request["length"])
                if request["torque"] != drive.torque:
                    within += f", if {request['torque']:g} N m is requested"
                limit, changes = request["limit"] or "", "; ".join(request["changes"])
                yield drive.point, MOST + within, "N m", "", "", f"{request['most'] or 0:.4g}", "", limit
                yield drive.point, CHANGES + within, "", "", "", "", "", changes
        for key, (label, unit) in FIGURES.items():
            ours = record["figures"].get(key, {})
            stated, source = maker.get(key, ("", ""))
            value = f"{ours['value']:.4g}" if ours else ""
            ratio = f"{float(value) / float(stated.split()[-1]):.3g}" if value and stated else ""
            if value or stated:
                yield drive.point, label, unit, stated, source, value, ratio, ours.get("note", "")
        for group, unit in (("mass", "kg"), ("length", "mm")):
            for item, value in record[group].items():
                yield drive.point, f"{group}: {item}", unit, "", "", f"{value:.3g}", "", ""


def read_records(folder: Path) -> dict[str, Any]:
    """Read the record of each drive from a folder, files by the names of the drives."""
    return {
        name: json.loads((folder / (drive.record or name)).read_text(encoding="utf-8"))
        for name, drive in DRIVES.items()
    }


Rows = Mapping[str, Mapping[str, Mapping[str, str]]]
"""Rows of the table for download, by point and figure."""


def read_rows() -> Rows:
    """Read the table for download."""
    rows: dict[str, dict[str, Mapping[str, str]]] = {}
    for row in read_csv(KEPT):
        rows.setdefault(row["point"], {})[row["figure"]] = row
    return rows


def format_sections(rows: Rows) -> dict[str, str]:
    """Return the generated sections of the page in Markdown, by name."""
    comparisons = (f"## {heading}\n\n{format_comparison(rows, makers)}" for heading, makers in TABLES.items())
    return {"drives": "\n\n".join(comparisons), "items": format_items(rows), "commands": format_commands(rows)}


def format_comparison(rows: Rows, makers: Sequence[str]) -> str:
    """Tabulate makers' drives and ours in Markdown, a column each; ours with the ratio to the maker's value."""
    columns = [(drive, theirs) for maker in makers for drive, theirs in _columns(maker)]
    drives = [drive for drive, theirs in columns if not theirs]
    head = (
        "Value",
        *(drive.theirs if theirs else drive.label.replace("ours", "our drive") for drive, theirs in columns),
    )
    lines = []
    for suffix in sorted({_within(length) for drive in drives for length in (None, drive.length)}):
        if not any(MOST + suffix in rows[drive.point] for drive in drives):
            continue
        refusals = [("", "", "") if theirs else _refusal(rows[drive.point], suffix) for drive, theirs in columns]
        label = f"largest feasible torque{suffix.replace('within', 'within a length of')}"
        names = f"{label}, N m", f"{label} is limited by", "the required torque is feasible with"
        lines += [(name, *cells) for name, cells in zip(names, zip(*refusals, strict=True), strict=True)]
    for key, (label, unit) in FIGURES.items():
        if key not in ALWAYS_SHOWN and not any(key in MAKERS[maker] for maker in makers):
            continue
        pairs = [(rows[drive.point].get(label), theirs) for drive, theirs in columns]
        lines.append((f"{label}, {unit}", *(_cell(row, theirs) for row, theirs in pairs)))
        limits = ["" if theirs or not row else row["note"].partition("limited by ")[2] for row, theirs in pairs]
        if any(limits):
            lines.append((f"{label} is limited by", *limits))
    return markdown_table(head, lines)


def _columns(maker: str) -> Iterator[tuple[MarketDrive, bool]]:
    """Yield the columns of a maker's drive: a drive of ours, and whether the column has the maker's values."""
    drives = [drive for drive in DRIVES.values() if drive.theirs == maker]
    yield drives[0], True
    yield from ((drive, False) for drive in drives)


def _within(length: float | None) -> str:
    """Return the words that follow a figure of a request with a length [mm]; empty without a length."""
    return f" within {length:g} mm" if length else ""


def _refusal(figures: Mapping[str, Mapping[str, str]], suffix: str) -> tuple[str, str, str]:
    """Return the maximum torque that a refusal states, its reason, and the first and the last feasible change.

    The refusal names lengths, lives and speeds; bare millimetres are a diameter, and bare rpm the speed of the crank.
    """
    row, changes = (figures.get(f"{figure}{suffix}") for figure in (MOST, CHANGES))
    if not row or not changes:
        return "", "", ""
    options = changes["note"].split("; ")
    shown = " or ".join(dict.fromkeys((options[0], options[-1])))
    feasible = re.sub(r"(?<!of )(?<![\d.])([\d.]+ mm)", r"a diameter of \1", shown)
    feasible = re.sub(r"(?<![\d.])([\d.]+ rpm)", r"an input speed of \1", feasible)
    return _number(row["ours"]) if float(row["ours"]) else "none", row["note"].partition(" (")[0], feasible


def _cell(row: Mapping[str, str] | None, theirs: bool) -> str:
    """Return a maker's value with its source, or ours with its ratio."""
    if not row:
        return ""
    if theirs:
        return f"{row['theirs']} ({row['source']})" if row["theirs"] else ""
    ratio = f" ({float(row['ratio']):.{2 if float(row['ratio']) < 10.0 else 0}f})" if row["ratio"] else ""
    return f"{_number(row['ours'])}{ratio}" if row["ours"] else ""


def _number(text: str) -> str:
    value = float(text)
    return f"{value:.0f}" if value >= 1e3 else f"{value:.3g}"


CATALOGUE_FIGURES = (
    *("rated_torque", "mass", "diameter", "length", "stiffness"),
    *("tilting_moment", "tilting_stiffness"),
)
"""Figures of the table of RV reducers on their page, as ratios; the lost motion is added as a value."""


def format_catalogue(rows: Rows) -> str:
    """Tabulate our RV reducers over those of the catalogue in Markdown: ratios of values, and our lost motion."""
    drives = [drive for drive in DRIVES.values() if drive.is_rv and drive.theirs.endswith("E")]
    drives.sort(key=lambda drive: drive.torque)
    lines = []
    for key in CATALOGUE_FIGURES:
        cells = (rows[drive.point][FIGURES[key][0]]["ratio"] for drive in drives)
        lines.append((FIGURES[key][0], *(f"{float(cell):.2f}" if cell else "" for cell in cells)))
    lost = (rows[drive.point]["lost motion"]["ours"] for drive in drives)
    lines.append(("lost motion, arcmin", *(f"{float(value):.2f}" for value in lost)))
    return markdown_table(("Ours / theirs", *(drive.theirs for drive in drives)), lines)


def format_items(rows: Rows) -> str:
    """Tabulate mass and length of the created drives by item in Markdown."""
    drives = [DRIVES[name] for name in CREATED]
    head = ("Item", *(drive.theirs + drive.label.removeprefix("ours") for drive in drives))
    lines = []
    for group, unit, items in (("mass", "kg", tuple(MASSES)), ("length", "mm", LENGTHS)):
        for item in items:
            cells = (rows[drive.point].get(f"{group}: {item}") for drive in drives)
            values = (float(cell["ours"]) if cell else 0.0 for cell in cells)
            lines.append(
                (f"{item}, {unit}", *(f"{value:.{2 if unit == 'kg' else 0}f}" if value else "" for value in values))
            )
    return markdown_table(head, lines)


def format_commands(rows: Rows) -> str:
    """Return the code block of the commands that create the drives, lines of at most `MAX_COLUMNS`."""
    lines = ["```sh"]
    for name in CREATED:
        line = rows[DRIVES[name].point]["command"]["note"]
        while len(line) > MAX_COLUMNS:
            cut = line.rindex(" --", 0, MAX_COLUMNS - 2)
            lines.append(f"{line[:cut]} \\")
            line = f"   {line[cut:]}"
        lines.append(line)
    return "\n".join([*lines, "```"])


def main(arguments: Sequence[str]) -> int:
    """Create a drive and print its record, or write the table for download and the page; return the exit code."""
    parser = argparse.ArgumentParser(description=str(__doc__).split("\n\n")[0])
    parser.add_argument("folder", nargs="?", type=Path, help="records of the drives, a file each")
    parser.add_argument("--drive", choices=CREATED, help="create this drive and print its record")
    options = parser.parse_args(arguments)
    if options.drive:
        print(json.dumps(create_drive(options.drive), indent=1))
        return 0
    if options.folder:
        write_files({KEPT: csv_text([COLUMNS, *market_rows(read_records(options.folder))]).encode()})
    rows = read_rows()
    sections = {PAGE: format_sections(rows), RV_PAGE: {"catalogue": format_catalogue(rows)}}
    pages = {path: path.read_text(encoding="utf-8") for path in sections}
    write_files({path: replace_sections(pages[path], sections[path], SCRIPT).encode() for path in sections})
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
