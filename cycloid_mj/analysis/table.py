"""The findings as rows of text, for people."""

from collections.abc import Iterator
from typing import NamedTuple

from cycloid_mj.analysis.findings import Findings, SpeedFindings, TransmissionError


class Row(NamedTuple):
    """One line of the table; a cell is "" where there is nothing to say."""

    quantity: str
    simulated: str
    closed_form: str
    error: str
    unit: str


def table(findings: Findings) -> list[Row]:
    """Give the findings as rows: quantity, simulated, closed form, error, unit."""
    return [*_motion(findings), *_point(findings), *_contact(findings), *_energy(findings)]


def _motion(findings: Findings) -> Iterator[Row]:
    crank = findings.crank
    yield Row("crank speed, mean", _text(crank.speed_rad_s), "", "", "rad/s")
    yield Row("crank speed against its law, largest, whole run", "", "", _text(crank.max_relative_error), "1")
    yield from _speed("gear", findings.gear_speed)
    yield from _speed("output", findings.output_speed)
    yield from _transmission_error("gear", findings.transmission_error)
    yield from _transmission_error("output", findings.output_transmission_error)


def _speed(part: str, speed: SpeedFindings) -> Iterator[Row]:
    mean, theory = speed.mean_rad_s, speed.theory_rad_s
    yield Row(f"{part} speed, mean", _text(mean), _text(theory), _text(mean - theory), "rad/s")
    yield Row(f"{part} speed, rms error", "", "", _text(speed.rms_error_rad_s), "rad/s")
    yield Row(f"{part} speed, peak error", "", "", _text(speed.peak_error_rad_s), "rad/s")


def _transmission_error(part: str, error: TransmissionError) -> Iterator[Row]:
    for name, value in (("peak to peak", error.peak_to_peak_arcsec), ("mean", error.mean_arcsec)):
        yield Row(f"transmission error of the {part}, {name}", _text(value), "0", _text(value), "arcsec")


def _point(findings: Findings) -> Iterator[Row]:
    x, y = findings.q_path.q_mm
    q = f"q = ({x:g}, {y:g}) mm"
    parts = [("hold", findings.q_path, findings.q_speed)]
    if findings.ramp:
        parts.append(("ramp", findings.ramp.q_path, findings.ramp.q_speed))
    for phase, path, velocity in parts:
        yield Row(f"path of {q}, {phase}, rms error", "", "", _text(path.rms_error_um), "um")
        yield Row(f"path of {q}, {phase}, largest error", "", "", _text(path.max_error_um), "um")
        yield Row(f"velocity of q, {phase}, rms error", "", "", _text(velocity.rms_error_mm_s), "mm/s")
        yield Row(f"velocity of q, {phase}, largest error", "", "", _text(velocity.max_error_mm_s), "mm/s")


def _contact(findings: Findings) -> Iterator[Row]:
    contact, pin = findings.contact_summary, findings.pin1
    yield Row("contacts in touch, mean", _text(contact.mean_active), "", "", "1")
    yield Row("penetration, largest", _text(contact.max_penetration_um), "", "", "um")
    yield Row("force of one contact, largest", _text(contact.peak_force_n), "", "", "N")
    if pin:
        yield Row("pin 1, distance from where it is centred, largest", _text(pin.max_radial_um), "", "", "um")
        yield Row("pin 1, spin, mean", _text(pin.mean_spin_rad_s), "", "", "rad/s")


def _energy(findings: Findings) -> Iterator[Row]:
    power, efficiency = findings.power, findings.efficiency
    torque, ideal = power.crank_torque_nm, power.ideal_crank_torque_nm
    yield Row("crank torque, mean", _text(torque), _text(ideal), _text(torque - ideal), "N m")
    yield Row("input power, mean", _text(power.input_w), "", "", "W")
    yield Row("output power, mean", _text(power.output_w), "", "", "W")
    if efficiency is not None:
        yield Row("efficiency", _text(100 * efficiency), "100", _text(100 * (efficiency - 1)), "%")
    for loss in findings.losses:
        pair = loss.pair.replace("_", "-")
        yield Row(f"loss by friction, {pair}", _text(loss.friction_w), "", "", "W")
        yield Row(f"loss by damping, {pair}", _text(loss.normal_w), "", "", "W")


def _text(value: float | None) -> str:
    return "" if value is None else f"{value:.5g}"
