"""The tables of the page: what was run, the findings, the losses, the warnings and the provenance."""

from collections.abc import Iterator, Sequence

from cycloid_mj.analysis import GROUPS, Row, groups
from cycloid_mj.checks import check
from cycloid_mj.design import Design
from cycloid_mj.design.units import DEGREE, MICROMETRE, MICROSECOND, MILLIMETRE, RPM
from cycloid_mj.report import html
from cycloid_mj.report.reviewed import Reviewed, labels


def setup(reviewed: Sequence[Reviewed]) -> str:
    """Give the table of what was run: one column for each run."""
    columns = [list(_told(item)) for item in reviewed]
    rows = [(name, *(column[i][1] for column in columns)) for i, (name, _) in enumerate(columns[0])]
    return html.table([("", *labels(reviewed))], rows, class_="setup")


def findings(reviewed: Sequence[Reviewed]) -> str:
    """Give the table simulated / closed form / error in its groups, with the columns of each run side by side."""
    tables = [
        {group.name: {row.quantity: row for row in group.rows} for group in groups(each.findings)} for each in reviewed
    ]
    head = [("quantity", "unit", *("simulated", "closed form", "error") * len(tables))]
    if len(tables) > 1:
        told = [
            f"{name}: {item.findings.condition_words}" for item, name in zip(reviewed, labels(reviewed), strict=True)
        ]
        head.insert(0, ("", "", *(cell for words in told for cell in (words, "", ""))))
    rows: list[html.Row] = []
    for group in (name for name in GROUPS if any(name in found for found in tables)):
        each = [found.get(group, {}) for found in tables]
        units = {name: row.unit for found in each for name, row in found.items()}
        rows.append((group,))
        rows += [
            (name, _unit(unit), *(c for found in each for c in _cells(found.get(name)))) for name, unit in units.items()
        ]
    return html.table(head, rows, class_="findings one" if len(tables) == 1 else "findings")


def losses(reviewed: Sequence[Reviewed]) -> str:
    """Give the table of where the power goes; nothing if no run lost any."""
    rows = []
    for item, name in zip(reviewed, labels(reviewed), strict=True):
        power = item.findings.power.input_w
        for loss in item.findings.losses:
            share = f"{100 * (loss.friction_w + loss.normal_w) / power:.3g}" if power > 0 else ""
            pair = loss.pair.replace("_", "-")
            rows.append((pair, name, f"{loss.friction_w:.4g}", f"{loss.normal_w:.4g}", share))
    if not rows:
        return html.tag("p", "No pair lost any power.")
    return html.table([("mating pair", "run", "friction [W]", "damping [W]", "share of the input [%]")], rows)


def provenance(reviewed: Sequence[Reviewed]) -> str:
    """Give what each run stands on: versions and settings, and its whole design file to unfold."""
    parts = []
    for item, name in zip(reviewed, labels(reviewed), strict=True):
        run = item.motion.run
        rows = [("log", item.log), *sorted(run.provenance.items())]
        rows.append(
            ("attachments", ", ".join(f"{file} ({len(data):,} bytes)" for file, data in run.attachments.items()))
        )
        source = run.attachments["design.toml"].decode("utf-8", "replace")
        unfolded = html.tag("summary", "design.toml") + html.tag("pre", html.text(source))
        parts.append(
            html.tag("h3", html.text(name)) + html.table([], rows, class_="setup") + html.tag("details", unfolded)
        )
    return "".join(parts)


def warnings(item: Reviewed) -> list[str]:
    """Give what a reader of a run should know before he trusts its numbers."""
    design = item.motion.design
    return [*item.findings.warnings, *(f"design check: {one}" for one in check(design) if not one.passed)]


def _told(item: Reviewed) -> Iterator[tuple[str, str]]:
    design, run = item.motion.design, item.motion.run
    ring, drive, load = design.ring, design.drive, design.load
    yield "ring", _ring(design)
    yield "reduction", f"{design.lobes} : 1"
    yield (
        "eccentricity, pin circle, pin",
        " / ".join(
            f"{MILLIMETRE.from_si(length):g}"
            for length in (design.gear.eccentricity, ring.pin_circle_radius, ring.pin_radius)
        )
        + " mm",
    )
    yield "clearances", _clearances(design)
    yield "friction", _friction(design)
    yield "crank", f"{RPM.from_si(drive.speed):g} rpm, ramp {drive.ramp:g} s"
    yield "load", f"{load.torque:g} N m" if load.torque else "none"
    x, y = item.findings.q_path.q_mm
    yield "point q of the gear", f"({x:.6g}, {y:.6g}) mm"
    span = float(run.time[-1] - run.time[0])
    turns = abs(DEGREE.from_si(float(run["crank_angle"][-1] - run["crank_angle"][0]))) / 360
    yield "simulated", f"{span:.4g} s, {turns:.1f} crank turns, {len(run):,} samples"
    steps = f", {item.findings.steps:,} steps" if item.findings.steps else ""
    yield "time step", f"{MICROSECOND.from_si(item.findings.timestep_s):g} µs{steps}"
    window = item.findings.window
    yield (
        "judged",
        f"{window.phase}, {window.start_s:.4g} to {window.end_s:.4g} s, {window.crank_turns:.2f} crank turns",
    )


def _ring(design: Design) -> str:
    ring = design.ring
    return f"{ring.teeth} {ring.pins} pins" if ring.kind == "pin" else f"internal gear with {ring.teeth} lobes"


def _pairs(design: Design) -> list[str]:
    holders = {"pin_socket": design.ring.has_sockets, "pin_sleeve": design.ring.has_sleeves}
    return [design.tooth_pair, *(pair for pair, holds in holders.items() if holds), "cam", "output"]


def _clearances(design: Design) -> str:
    values = [(pair, MICROMETRE.from_si(getattr(design.clearance, pair))) for pair in _pairs(design)]
    return ", ".join(f"{pair.replace('_', '-')} {value:g}" for pair, value in values) + " µm"


def _friction(design: Design) -> str:
    return ", ".join(f"{pair.replace('_', '-')} {design.friction_of(pair):g}" for pair in _pairs(design))


def _unit(unit: str) -> str:
    return {"um": "µm", "1": ""}.get(unit, unit)


def _cells(row: Row | None) -> tuple[str, str, str]:
    cells = (row.simulated, row.closed_form, row.error) if row else ("", "", "")
    simulated, closed_form, error = (cell.replace("-", "\N{MINUS SIGN}") for cell in cells)
    return simulated, closed_form, error
