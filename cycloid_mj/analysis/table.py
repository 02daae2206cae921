"""The findings of a run as rows of text: what a user of the drive notices comes first.

An error is a difference from a reference that the ideal mechanism would reach. Friction losses and elastic wind-up are
not errors: they are in the column "simulated".
"""

from collections.abc import Iterator
from typing import NamedTuple

from cycloid_mj.analysis.findings import Findings, PathFindings, SpeedFindings, TransmissionError, VelocityFindings


class FigureRow(NamedTuple):
    """A row of the table; cells without a value are ""."""

    quantity: str
    simulated: str
    closed_form: str
    error: str
    unit: str


class RowGroup(NamedTuple):
    """The rows of a part of the drive, named as in `GROUPS`; `detail` adds to the name, such as a point's place."""

    name: str
    rows: tuple[FigureRow, ...]
    detail: str = ""


ROUNDING = 1e-12
"""Relative difference below which a value equals its reference."""

GROUPS = ("output", "gear", "path of q", "contacts", "pin 1", "torques and losses", "energy", "crank")
"""Names of the groups, in the order of the table."""


def table(findings: Findings) -> list[FigureRow]:
    """Return the findings as rows: quantity, simulated, closed form, error, unit."""
    return [row for group in groups(findings) for row in group.rows]


def groups(findings: Findings) -> list[RowGroup]:
    """Return the rows of the table of a run's results, in groups with a heading each; empty groups are omitted."""
    rows_by_group = (
        _motion_rows("output", findings.output_speed, findings.output_transmission_error),
        _disc_rows(findings),
        _point_rows(findings),
        *(make_rows(findings) for make_rows in (_contact_rows, _pin_rows, _torque_rows, _energy_rows, _crank_rows)),
    )
    x, y = findings.q_path.q_mm
    disc_clause = f" of {findings.discs[0].name.replace('_', ' ')}" if findings.discs else ""
    details = {"path of q": f"= ({x:.6g}, {y:.6g}) mm{disc_clause}"}
    row_groups = [
        RowGroup(name, tuple(rows), details.get(name, "")) for name, rows in zip(GROUPS, rows_by_group, strict=True)
    ]
    return [group for group in row_groups if group.rows]


def _motion_rows(
    part: str, speed: SpeedFindings, error: TransmissionError, article: str = "the "
) -> Iterator[FigureRow]:
    """Yield the rows of transmission error [arcsec] and speed [rad/s] of a part, such as "output".

    `article` precedes the part's name in the rows of transmission error; "" for names with a number.
    """
    mean_speed, ideal_speed = speed.mean_rad_s, speed.theory_rad_s
    # a difference within rounding is shown as 0
    mean_error = 0.0 if abs(mean_speed - ideal_speed) <= ROUNDING * abs(ideal_speed) else mean_speed - ideal_speed
    yield _format_row(f"transmission error of {article}{part}, peak to peak", "arcsec", error=error.peak_to_peak_arcsec)
    yield _format_row(f"transmission error of {article}{part}, mean (play and wind-up)", "arcsec", error.mean_arcsec)
    yield _format_row(f"{part} speed, mean", "rad/s", mean_speed, ideal_speed, mean_error)
    yield _format_row(f"{part} speed, rms error", "rad/s", error=speed.rms_error_rad_s)
    yield _format_row(f"{part} speed, peak error", "rad/s", error=speed.peak_error_rad_s)


def _disc_rows(findings: Findings) -> Iterator[FigureRow]:
    if not findings.discs:
        yield from _motion_rows("gear", findings.gear_speed, findings.gear_transmission_error)
    for disc in findings.discs:
        yield from _motion_rows(disc.name.replace("_", " "), disc.speed, disc.transmission_error, "")


def _point_rows(findings: Findings) -> Iterator[FigureRow]:
    yield from _path_rows(findings.window.phase, findings.q_path, findings.q_speed)
    if findings.ramp and findings.window.phase == "hold":
        yield from _path_rows("ramp", findings.ramp.q_path, findings.ramp.q_speed)


def _path_rows(phase: str, path: PathFindings, velocity: VelocityFindings) -> Iterator[FigureRow]:
    yield _format_row(f"path of q, {phase}, rms error", "um", error=path.rms_error_um)
    yield _format_row(f"path of q, {phase}, largest error", "um", error=path.max_error_um)
    yield _format_row(f"velocity of q, {phase}, rms error", "mm/s", error=velocity.rms_error_mm_s)
    yield _format_row(f"velocity of q, {phase}, largest error", "mm/s", error=velocity.max_error_mm_s)


def _contact_rows(findings: Findings) -> Iterator[FigureRow]:
    """Yield the rows of contacts: their mean number, and the largest penetration [um] and force [N] of one contact.

    An RV reducer also has rows of the cranks: the largest force of a crank on a disc, and the largest of their mean
    forces [N]. The mean is the equivalent load of roller bearings, with the exponent 10/3. `findings` are the evaluated
    results of the run.
    """
    contact = findings.contact_summary
    yield _format_row("contacts in touch, mean", "1", contact.mean_active)
    yield _format_row("penetration, largest", "um", contact.max_penetration_um)
    yield _format_row("force of one contact, largest", "N", contact.peak_force_n)
    if bearings := findings.crank_bearings:
        yield _format_row("force of a crank on a disc, largest", "N", bearings.max_force_n)
        yield _format_row("force of a crank on a disc, largest 10/3-power mean", "N", bearings.mean_force_n)


def _pin_rows(findings: Findings) -> Iterator[FigureRow]:
    if pin := findings.pin1:
        yield _format_row("pin 1, radial displacement, largest", "um", pin.max_radial_um)
        yield _format_row("pin 1, spin, mean", "rad/s", pin.mean_spin_rad_s)


def _torque_rows(findings: Findings) -> Iterator[FigureRow]:
    """Yield the rows of mean torques [N m], and of friction and damping losses [W] of each kind of mating pair.

    `findings` are the evaluated results of the run.
    """
    power = findings.power
    yield _format_row("load torque, mean", "N m", power.load_torque_nm)
    driven_shaft = findings.driven_shaft
    yield _format_row(f"{driven_shaft} torque, mean", "N m", power.crank_torque_nm)
    yield _format_row(
        f"{driven_shaft} torque without losses, load / ratio", "N m", closed_form=power.ideal_crank_torque_nm
    )
    for loss in findings.losses:
        pair = loss.pair.replace("_", "-")
        yield _format_row(f"loss by friction, {pair}", "W", loss.friction_w)
        yield _format_row(f"loss by damping, {pair}", "W", loss.normal_w)


def _energy_rows(findings: Findings) -> Iterator[FigureRow]:
    power, efficiency = findings.power, findings.efficiency
    yield _format_row("input power, mean", "W", power.input_w)
    yield _format_row("output power, mean", "W", power.output_w)
    if efficiency is not None:
        yield _format_row("efficiency", "%", 100 * efficiency)


def _crank_rows(findings: Findings) -> Iterator[FigureRow]:
    crank, driven = findings.crank, findings.driven_shaft
    yield _format_row(f"{driven} speed, mean", "rad/s", crank.speed_rad_s)
    yield _format_row(f"{driven} speed, largest relative error in the entire run", "1", error=crank.max_relative_error)


def _format_row(
    quantity: str,
    unit: str,
    simulated: float | None = None,
    closed_form: float | None = None,
    error: float | None = None,
) -> FigureRow:
    """Return a row of the table: a quantity with its unit, the simulated value, its closed form and its error.

    All values have the same unit and five digits; missing values are empty cells.
    """
    return FigureRow(quantity, _format_value(simulated), _format_value(closed_form), _format_value(error), unit)


def _format_value(value: float | None) -> str:
    if value is None:
        return ""
    return f"{value:.5g}" if value else "0"
