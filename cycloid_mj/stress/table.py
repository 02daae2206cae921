"""Findings of stress as rows of text."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from cycloid_mj.base.units import MEGAPASCAL, MILLIMETRE
from cycloid_mj.stress.findings import PartFindings, Peak, StressFindings

if TYPE_CHECKING:
    from cycloid_mj.stress.rv_strength import RvStrength

BULK_HEADER = (
    "part",
    "bulk [MPa]",
    "from [mm]",
    "choice",
    "at [deg]",
    "x, y, z [mm]",
    "safety",
    "refined",
)
CONTACT_HEADER = ("part", "contact [MPa]", "at [deg]", "below", "safety", "shakedown")
STRENGTH_HEADER = ("section", "nominal [MPa]", "factor", "stress [MPa]", "safety")


def bulk_table(findings: StressFindings) -> list[list[str]]:
    """Return the bulk stress of each part as a row of text, in the columns `BULK_HEADER`.

    `findings` are the results of a stress study. "from" is the distance from narrow contacts at which the largest
    stress reaches its plateau. "choice" is the relative change of the stress if this distance is doubled, or if the
    distance from sharp corners is halved or doubled, whichever is largest. "safety" is the
    safety factor of the larger of bulk and fillet stress. "refined" is the relative change of the stress with a finer
    mesh.
    """
    return [_bulk_row(part) for part in findings.parts]


def contact_table(findings: StressFindings) -> list[list[str]]:
    """Return the contact stress of each part as a row of text, in the columns `CONTACT_HEADER`.

    "shakedown" is the safety factor of the contact pressure against shakedown.
    """
    return [[part.part, *_contact_row(part)] for part in findings.parts]


def strength_table(strength: "RvStrength") -> Iterator[tuple[str, ...]]:
    """Yield the stress of each section of the cranks and gears of an RV reducer as a row of text.

    The columns are named in `STRENGTH_HEADER`.
    """
    sections = [(section.name, section.nominal, section.stress) for section in strength.shoulders]
    sections += [(f"tooth root of {section.part}", section.nominal, section.stress) for section in strength.roots]
    for name, nominal_stress, stress in sections:
        factor = stress / nominal_stress if nominal_stress else math.nan
        cells = (
            f"{quantity:.3g}" for quantity in (factor, stress / MEGAPASCAL, strength.yield_strength / max(stress, 1e-9))
        )
        yield (name, f"{nominal_stress / MEGAPASCAL:.3g}", *cells)


def part_notes(part: PartFindings) -> list[str]:
    """Return notes on a part as lines of text: stress at fillets, stress range for fatigue, other supports."""
    notes = []
    for notch in part.notches:
        note = f"{part.part}, {notch.name}: nominal stress {notch.nominal / MEGAPASCAL:.3g} MPa"
        if notch.bending_factor > 1.0:
            location_text = (
                f"its fillet of {notch.fillet / MILLIMETRE:.3g} mm" if np.isfinite(notch.fillet) else "its seat"
            )
            note += (
                f", {notch.stress / MEGAPASCAL:.3g} at {location_text} "
                f"(notch factor {notch.bending_factor:.2f}), safety {part.yield_strength / notch.stress:.3g}"
                if notch.stress
                else ""
            )
        notes.append(note)
    if part.stress_range:
        amplitude, mean = part.stress_range.amplitude / MEGAPASCAL, part.stress_range.mean / MEGAPASCAL
        notes.append(f"{part.part}, range over the turn: {mean:.3g} +- {amplitude:.3g} MPa at the critical node")
    notes += [f"{part.part}, with {change}: bulk {stress / MEGAPASCAL:.3g} MPa" for change, stress in part.variants]
    return notes


def _bulk_row(part: PartFindings) -> list[str]:
    bulk = part.bulk_peak
    position = ", ".join(f"{value / MILLIMETRE:.1f}" for value in bulk.position)
    return [
        *(part.part, _stress(bulk), f"{part.bulk_distance / MILLIMETRE:.3g}", f"{0.0 - 100 * part.choice:.0f} %"),
        *(_angle(bulk), position, _safety(part), f"{100 * part.refinement.change:.1f} %"),
    ]


def _safety(part: PartFindings) -> str:
    """Format the safety of the governing stress, with that stress [MPa] if it is at a fillet."""
    at = f" (fillet {part.governing / MEGAPASCAL:.3g})" if part.governing > part.bulk_peak.stress else ""
    return f"{part.safety:.3g}{at}"


def _stress(peak: Peak) -> str:
    return f"{peak.stress / MEGAPASCAL:.3g}"


def _contact_row(part: PartFindings) -> list[str]:
    peak = part.contact_peak
    if not np.isfinite(peak.stress):
        return ["-", "-", "conformal", "-", "-"]
    return [_stress(peak), _angle(peak), peak.contact, f"{peak.safety:.3g}", f"{part.shakedown:.3g}"]


def _angle(peak: Peak) -> str:
    return f"{np.degrees(peak.angle):.0f}"
