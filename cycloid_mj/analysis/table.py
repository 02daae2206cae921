"""The findings as rows of text, for people: what a user of the drive feels comes first.

An error is a difference from a reference that the ideal mechanism would keep. What friction takes and what a load winds
up are no errors: they stand under "simulated".
"""

from collections.abc import Iterator
from typing import NamedTuple

from cycloid_mj.analysis.findings import Findings, PathFindings, SpeedFindings, TransmissionError, VelocityFindings


class Row(NamedTuple):
    """One line of the table; a cell is "" where there is nothing to say."""

    quantity: str
    simulated: str
    closed_form: str
    error: str
    unit: str


class Group(NamedTuple):
    """The rows about one part of the drive, one of `GROUPS`; `detail` says more of it, such as where a point is."""

    name: str
    rows: tuple[Row, ...]
    detail: str = ""


GROUPS = ("output", "gear", "path of q", "contacts", "pin 1", "torques and losses", "energy", "crank")
"""Names of the groups, in their order."""


def table(findings: Findings) -> list[Row]:
    """Give the findings as rows: quantity, simulated, closed form, error, unit."""
    return [row for group in groups(findings) for row in group.rows]


def groups(findings: Findings) -> list[Group]:
    """Give the rows of `table` by what they are about; a group without rows is left out."""
    rows = (
        _part("output", findings.output_speed, findings.output_transmission_error),
        _part("gear", findings.gear_speed, findings.gear_transmission_error),
        _point(findings),
        *(about(findings) for about in (_contacts, _pin_1, _torques, _energy, _crank)),
    )
    x, y = findings.q_path.q_mm
    details = {"path of q": f"= ({x:.6g}, {y:.6g}) mm"}
    found = [Group(name, tuple(part), details.get(name, "")) for name, part in zip(GROUPS, rows, strict=True)]
    return [group for group in found if group.rows]


def _part(part: str, speed: SpeedFindings, error: TransmissionError) -> Iterator[Row]:
    mean, theory = speed.mean_rad_s, speed.theory_rad_s
    yield Row(f"transmission error of the {part}, peak to peak", "", "", _text(error.peak_to_peak_arcsec), "arcsec")
    yield Row(f"transmission error of the {part}, mean (play and wind-up)", _text(error.mean_arcsec), "", "", "arcsec")
    yield Row(f"{part} speed, mean", _text(mean), _text(theory), _text(mean - theory, theory), "rad/s")
    yield Row(f"{part} speed, rms error", "", "", _text(speed.rms_error_rad_s), "rad/s")
    yield Row(f"{part} speed, peak error", "", "", _text(speed.peak_error_rad_s), "rad/s")


def _point(findings: Findings) -> Iterator[Row]:
    yield from _errors(findings.window.phase, findings.q_path, findings.q_speed)
    if findings.ramp and findings.window.phase == "hold":
        yield from _errors("ramp", findings.ramp.q_path, findings.ramp.q_speed)


def _errors(phase: str, path: PathFindings, velocity: VelocityFindings) -> Iterator[Row]:
    yield Row(f"path of q, {phase}, rms error", "", "", _text(path.rms_error_um), "um")
    yield Row(f"path of q, {phase}, largest error", "", "", _text(path.max_error_um), "um")
    yield Row(f"velocity of q, {phase}, rms error", "", "", _text(velocity.rms_error_mm_s), "mm/s")
    yield Row(f"velocity of q, {phase}, largest error", "", "", _text(velocity.max_error_mm_s), "mm/s")


def _contacts(findings: Findings) -> Iterator[Row]:
    contact = findings.contact_summary
    yield Row("contacts in touch, mean", _text(contact.mean_active), "", "", "1")
    yield Row("penetration, largest", _text(contact.max_penetration_um), "", "", "um")
    yield Row("force of one contact, largest", _text(contact.peak_force_n), "", "", "N")


def _pin_1(findings: Findings) -> Iterator[Row]:
    if pin := findings.pin1:
        yield Row("pin 1, distance from where it is centred, largest", _text(pin.max_radial_um), "", "", "um")
        yield Row("pin 1, spin, mean", _text(pin.mean_spin_rad_s), "", "", "rad/s")


def _torques(findings: Findings) -> Iterator[Row]:
    power = findings.power
    yield Row("load torque, mean", _text(power.load_torque_nm), "", "", "N m")
    yield Row("crank torque, mean", _text(power.crank_torque_nm), "", "", "N m")
    yield Row("crank torque without losses, load / (N-1)", "", _text(power.ideal_crank_torque_nm), "", "N m")
    for loss in findings.losses:
        pair = loss.pair.replace("_", "-")
        yield Row(f"loss by friction, {pair}", _text(loss.friction_w), "", "", "W")
        yield Row(f"loss by damping, {pair}", _text(loss.normal_w), "", "", "W")


def _energy(findings: Findings) -> Iterator[Row]:
    power, efficiency = findings.power, findings.efficiency
    yield Row("input power, mean", _text(power.input_w), "", "", "W")
    yield Row("output power, mean", _text(power.output_w), "", "", "W")
    if efficiency is not None:
        yield Row("efficiency", _text(100 * efficiency), "", "", "%")


def _crank(findings: Findings) -> Iterator[Row]:
    crank = findings.crank
    yield Row("crank speed, mean", _text(crank.speed_rad_s), "", "", "rad/s")
    yield Row("crank speed against its law, largest, whole run", "", "", _text(crank.max_relative_error), "1")


ROUNDING = 1e-12
"""Share of its reference below which a difference is rounding."""


def _text(value: float | None, reference: float = 0.0) -> str:
    """Give a number in words: five digits; 0 for a difference that is rounding beside its reference."""
    if value is None:
        return ""
    return "0" if abs(value) <= ROUNDING * abs(reference) else f"{value:.5g}"
