"""What the findings of a run mean, in sentences: each figure beside what the ideal drive would have."""

import math
from collections.abc import Iterator

from cycloid_mj.analysis.findings import Findings

RETURNED = (
    "a negative loss by damping is elastic energy that comes back: the power of a contact's normal force is damping "
    "and what goes into its spring and out of it, which a window of few turns does not level out"
)
"""Why a loss may be negative."""


def meaning(findings: Findings) -> list[str]:
    """Write what a run shows, a sentence each, eight at most: motion first, then torque, losses and contacts."""
    return [*_motion(findings), *_torques(findings), *_losses(findings), _contacts(findings)]


def _motion(findings: Findings) -> Iterator[str]:
    speed, error, crank = findings.output_speed, findings.transmission_error, findings.crank
    if speed.theory_rad_s:
        yield (
            f"speed: the output turns at {abs(speed.mean_rad_s):.4f} rad/s, and "
            f"1/{abs(crank.speed_rad_s / speed.theory_rad_s):.4g} of the crank's is {abs(speed.theory_rad_s):.4f}; it "
            f"wavers by {1e3 * speed.rms_error_rad_s:.3g} mrad/s rms"
        )
    chance = "" if findings.condition.load else "; both differ from start to start, as an idle gear rattles in its play"
    wavers = f"transmission error: the output's angle wavers by {error.peak_to_peak_arcsec:.3g} arcsec; ideal is 0"
    yield f"{wavers}{chance}"
    if findings.condition.load:
        yield f"wind-up: it lags {abs(error.mean_arcsec) / 60.0:.3g} arcmin behind, by play and by what the load bends"
    path = findings.q_path
    yield f"path: the point q of the gear keeps within {path.max_error_um:.3g} um of the ideal curve (Eq. 16)"


def _torques(findings: Findings) -> Iterator[str]:
    power = findings.power
    asked = f"crank torque: {abs(power.crank_torque_nm):.4g} N m"
    if findings.condition.load:
        yield (
            f"{asked} for {abs(power.load_torque_nm):.4g} N m at the output; without losses it would be "
            f"{abs(power.ideal_crank_torque_nm):.4g} N m"
        )
        if findings.efficiency is not None:
            yield f"efficiency: {100 * findings.efficiency:.2f} %; the ideal drive has 100 %"
    else:
        yield f"{asked}, against friction alone, as nothing is driven: there is no efficiency to tell"


def _losses(findings: Findings) -> Iterator[str]:
    losses = {one.pair.replace("_", "-"): one.friction_w + one.normal_w for one in findings.losses}
    whole = math.fsum(losses.values())
    if whole > 0.0:
        pair, most = max(losses.items(), key=lambda item: item[1])
        yield f"losses: {whole:.3g} W, most of it at {pair} ({min(1.0, most / whole):.0%})"


def _contacts(findings: Findings) -> str:
    contact, pin = findings.contact_summary, findings.pin1
    strays = f"; pin 1 strays {pin.max_radial_um:.3g} um at most, with play and load" if pin else ""
    return (
        f"contacts: {contact.mean_active:.3g} touch at a time, the hardest with {contact.peak_force_n:.4g} N; parts "
        f"approach by {contact.max_penetration_um:.2g} um at most{strays}"
    )
