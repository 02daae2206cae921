"""The tables of a report as text: design and conditions, findings, losses, provenance."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from cycloid_mj.analysis import GROUPS, RETURNED, FigureRow, groups
from cycloid_mj.base.result import Table
from cycloid_mj.design.units import DEGREE, MICROMETRE, MICROSECOND, MILLIMETRE, RPM
from cycloid_mj.report.reviewed import Reviewed


class TextTable(NamedTuple):
    """A table of text: the first cell of a row is its name, a row of one cell is the heading of those below.

    A cell of the head also spans the empty cells that follow it.
    """

    head: Sequence[Sequence[str]]
    body: Sequence[Sequence[str]]

    @classmethod
    def of(cls, table: Table) -> "TextTable":
        """Return the text of a table of a result."""
        return cls([table.header], table.cells)

    @property
    def width(self) -> int:
        """Number of cells of the longest row."""
        return max(map(len, (*self.head, *self.body)), default=1)

    def spans(self, row: Sequence[str]) -> list[tuple[str, int]]:
        """Return the cells of a row of the head, each with the number of columns it spans."""
        start_columns = [column for column, cell in enumerate(row) if cell or column == 0]
        return [(row[start], end - start) for start, end in pairwise([*start_columns, len(row)])]


def setup(reviewed: Sequence[Reviewed]) -> TextTable:
    """Return design and conditions, one column for each run."""
    columns = [dict(_setup_rows(item)) for item in reviewed]
    rows = [(name, *(column[name] for column in columns)) for name in columns[0]]
    return TextTable([("", *(item.name for item in reviewed))], rows)


def findings(reviewed: Sequence[Reviewed]) -> TextTable:
    """Tabulate simulation, closed form and error of the evaluated quantities of runs.

    `reviewed` are the analysed runs. There is a row for each quantity, with three columns for each run; cells are empty
    if a run has no such quantity. Rows are grouped below headings in the order of `GROUPS`. With several runs, another
    head row has their names and conditions.
    """
    rows_by_run = [
        {group.name: {row.quantity: row for row in group.rows} for group in groups(run.findings)} for run in reviewed
    ]
    header_rows = [("quantity", "unit", *("simulated", "closed form", "error") * len(rows_by_run))]
    if len(rows_by_run) > 1:
        titles = [f"{run.name}: {run.findings.condition_words}" for run in reviewed]
        header_rows.insert(0, ("", "", *(cell for title in titles for cell in (title, "", ""))))
    rows: list[Sequence[str]] = []
    for group in (name for name in GROUPS if any(name in run_groups for run_groups in rows_by_run)):
        group_rows = [run_groups.get(group, {}) for run_groups in rows_by_run]
        units = {name: row.unit for run_rows in group_rows for name, row in run_rows.items()}
        rows.append((group,))
        rows += [
            (name, _unit_symbol(unit), *(cell for run_rows in group_rows for cell in _cells(run_rows.get(name))))
            for name, unit in units.items()
        ]
    return TextTable(header_rows, rows)


def losses(reviewed: Sequence[Reviewed]) -> TextTable:
    """Tabulate the mean losses by friction and by contact damping [W]: a row for each kind of mating pair of each run.

    The last column is the share in the input power [%]; it is empty if the crank receives no power. Without losses, the
    table has no rows. `reviewed` are the analysed runs.
    """
    rows = []
    for run in reviewed:
        input_power = run.findings.power.input_w
        for loss in run.findings.losses:
            share_text = f"{100 * (loss.friction_w + loss.normal_w) / input_power:.3g}" if input_power > 0 else ""
            pair = loss.pair.replace("_", "-")
            rows.append((pair, run.name, f"{loss.friction_w:.4g}", f"{loss.normal_w:.4g}", share_text))
    return TextTable([("mating pair", "run", "friction [W]", "damping [W]", "share of the input [%]")], rows)


def returns(reviewed: Sequence[Reviewed]) -> str:
    """Return the explanation of a negative loss by damping, if a run has one."""
    negative = any(loss.normal_w < 0.0 for item in reviewed for loss in item.findings.losses)
    return f"{RETURNED[:1].upper()}{RETURNED[1:]}." if negative else ""


def provenance(item: Reviewed) -> TextTable:
    """Return versions, settings and files of a run."""
    run = item.motion.run
    files = ", ".join(f"{file} ({len(data):,} bytes)" for file, data in run.attachments.items())
    return TextTable([], [("log", item.log), *sorted(run.provenance.items()), ("attachments", files)])


def _setup_rows(reviewed_run: Reviewed) -> Iterator[tuple[str, str]]:
    """Yield the rows of a run's setup as pairs of name and text with units: design, drive, load, time, ...

    The row "accuracy at this time step" is omitted if the run does not state it. `reviewed_run` is the analysed run.
    """
    design, run = reviewed_run.motion.design, reviewed_run.motion.run
    ring, drive, load = design.ring, design.drive, design.load
    yield "ring", f"{ring.teeth} {ring.pins} pins" if ring.kind == "pin" else f"internal gear with {ring.teeth} lobes"
    yield "ratio", f"{design.reduction}:1, output: {design.output.member}"
    gap = f", {MILLIMETRE.from_si(design.gear.disc_gap):g} mm apart" if design.gear.discs > 1 else ""
    yield "discs", f"{design.gear.discs}{gap}"
    lengths = (design.gear.eccentricity, ring.pin_circle_radius, ring.pin_radius)
    yield (
        "eccentricity, pin circle radius, pin radius",
        " / ".join(f"{MILLIMETRE.from_si(length):g}" for length in lengths) + " mm",
    )
    kinds = design.pair_kinds
    yield (
        "clearances",
        _format_by_pair({kind: MICROMETRE.from_si(getattr(design.clearance, kind)) for kind in kinds}) + " µm",
    )
    yield "friction coefficients", _format_by_pair({kind: design.friction_of(kind) for kind in kinds})
    yield f"{reviewed_run.motion.reducer.INPUT} speed", f"{RPM.from_si(drive.speed):g} rpm, ramp {drive.ramp:g} s"
    yield "load", f"{load.torque:g} N m" if load.torque else "none"
    x, y = reviewed_run.findings.q_path.q_mm
    disc_text = f" of {reviewed_run.motion.gear_words}" if design.gear.discs > 1 else ""
    yield "point q of the disc", f"({x:.6g}, {y:.6g}) mm{disc_text}"
    duration = float(run.time[-1] - run.time[0])
    turn_count = abs(DEGREE.from_si(float(np.ptp(reviewed_run.motion.crank_angle[[0, -1]])))) / 360
    yield "simulated", f"{duration:.4g} s, {turn_count:.1f} crank turns, {len(run):,} samples"
    steps_text = f", {reviewed_run.findings.steps:,} steps" if reviewed_run.findings.steps else ""
    yield "time step", f"{MICROSECOND.from_si(reviewed_run.findings.timestep_s):g} µs{steps_text}"
    if reviewed_run.findings.timestep_for:
        yield "accuracy at this time step", reviewed_run.findings.timestep_for
    window = reviewed_run.findings.window
    evaluated_text = (
        f"{window.phase}, {window.start_s:.4g} to {window.end_s:.4g} s, {window.crank_turns:.2f} crank turns"
    )
    yield "evaluated", evaluated_text


def _format_by_pair(values: dict[str, float]) -> str:
    return ", ".join(f"{kind.replace('_', '-')} {value:g}" for kind, value in values.items())


def _unit_symbol(unit: str) -> str:
    return {"um": "µm", "1": ""}.get(unit, unit)


def _cells(row: FigureRow | None) -> list[str]:
    cells = (row.simulated, row.closed_form, row.error) if row else ("", "", "")
    return [cell.replace("-", "\N{MINUS SIGN}") for cell in cells]
