"""The findings of a run in sentences that compare each figure with that of an ideal drive."""

import math
from collections.abc import Iterator

from cycloid_mj.analysis.findings import Findings

RETURNED = (
    "a negative loss by damping is elastic energy that is returned: the power of a normal force includes the energy "
    "stored in the contact's spring and released by it, which a window of few turns does not average out"
)
"""Explanation of a negative loss."""


def explain(findings: Findings) -> list[str]:
    """Return up to eight sentences on the results of a run: motion first, then torque, losses and contacts.

    `findings` are the evaluated results of the run.
    """
    return [
        *_motion_sentences(findings),
        *_torque_sentences(findings),
        *_loss_sentences(findings),
        _contact_sentence(findings),
    ]


def _motion_sentences(findings: Findings) -> Iterator[str]:
    """Yield sentences on the output's speed, the transmission error, the wind-up and the path of the disc.

    `findings` are the evaluated results of the run. The sentence on the speed is omitted if the ideal speed is 0 (crank
    at rest), that on the wind-up if there is no load.
    """
    speed, error, crank = findings.output_speed, findings.transmission_error, findings.crank
    if speed.theory_rad_s:
        yield (
            f"speed: output {abs(speed.mean_rad_s):.4f} rad/s, ideal {abs(speed.theory_rad_s):.4f} rad/s (1/"
            f"{abs(crank.speed_rad_s / speed.theory_rad_s):.4g} of the {findings.driven_shaft}'s); ripple "
            f"{1e3 * speed.rms_error_rad_s:.3g} mrad/s rms"
        )
    error_sentence = f"transmission error: {error.peak_to_peak_arcsec:.3g} arcsec peak to peak, ideal 0"
    repeatability_note = (
        "" if findings.condition.load else " (without load it differs from start to start: parts rattle)"
    )
    yield f"{error_sentence}{repeatability_note}"
    if findings.condition.load:
        yield f"wind-up: {abs(error.mean_arcsec) / 60.0:.3g} arcmin (backlash taken up plus elastic deflection)"
    path = findings.q_path
    yield f"path: the point q of the disc deviates by at most {path.max_error_um:.3g} um from the ideal curve (Eq. 16)"


def _torque_sentences(findings: Findings) -> Iterator[str]:
    """Yield sentences on the mean crank torque and, under a load, the efficiency if it is defined.

    `findings` are the evaluated results of the run.
    """
    power = findings.power
    crank_sentence = f"{findings.driven_shaft} torque: {abs(power.crank_torque_nm):.4g} N m"
    if findings.condition.load:
        yield (
            f"{crank_sentence} at a load torque of {abs(power.load_torque_nm):.4g} N m; without losses "
            f"{abs(power.ideal_crank_torque_nm):.4g} N m"
        )
        if findings.efficiency is not None:
            yield f"efficiency: {100 * findings.efficiency:.2f} %"
    else:
        yield f"{crank_sentence}, friction only; efficiency is undefined without a load"


def _loss_sentences(findings: Findings) -> Iterator[str]:
    """Yield a sentence on the losses, unless there are none."""
    losses = {loss.pair.replace("_", "-"): loss.friction_w + loss.normal_w for loss in findings.losses}
    total_loss = math.fsum(losses.values())
    if total_loss > 0.0:
        pair, largest_loss = max(losses.items(), key=lambda item: item[1])
        yield f"losses: {total_loss:.3g} W, of which {min(1.0, largest_loss / total_loss):.0%} at {pair}"


def _contact_sentence(findings: Findings) -> str:
    """Return a sentence on the number, force and deflection of the contacts.

    `findings` are the evaluated results of the run. The sentence also states the largest radial displacement of ring
    pin 1 if the ring pins can move, and the largest force of the crank bearings of an RV reducer if their forces were
    logged.
    """
    contact, pin, bearings = findings.contact_summary, findings.pin1, findings.crank_bearings
    pin_clause = f"; pin 1 moves up to {pin.max_radial_um:.3g} um (clearance plus deflection)" if pin else ""
    bearing_clause = f"; crank bearings carry up to {bearings.max_force_n:.4g} N" if bearings else ""
    return (
        f"contacts: {contact.mean_active:.3g} on average; largest contact force {contact.peak_force_n:.4g} N, largest "
        f"deflection {contact.max_penetration_um:.2g} um{pin_clause}{bearing_clause}"
    )
