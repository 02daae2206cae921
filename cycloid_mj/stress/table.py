"""Findings of stress as rows of text, for people."""

from collections.abc import Sequence

import numpy as np

from cycloid_mj.stress.findings import MEGAPASCAL, MILLIMETRE, PartFindings, Peak, StressFindings
from cycloid_mj.stress.paper import Claim

HEADER = (
    *("part", "bulk [MPa]", "d/2, 2d", "at [deg]", "x, y, z [mm]", "safety"),
    *("contact [MPa]", "at [deg]", "below", "safety", "refined"),
)
CLAIM_HEADER = ("figure", "the paper", "found here", "verdict")


def table(findings: StressFindings) -> list[list[str]]:
    """Give a row for each part; columns as in `HEADER`.

    `d/2, 2d`: the largest bulk stress if bulk began at half or at twice the bulk distance. `refined`: change under one
    more refinement of the grid.
    """
    return [_row(part) for part in findings.parts]


def distances(findings: StressFindings) -> str:
    """Tell the bulk distance of each part."""
    by_size: dict[str, list[str]] = {}
    for part in findings.parts:
        by_size.setdefault(f"{part.bulk_distance / MILLIMETRE:.4g} mm", []).append(part.part)
    return "; ".join(f"{size} ({', '.join(names)})" for size, names in by_size.items())


def claim_table(claims: Sequence[Claim]) -> list[list[str]]:
    """Give a row for each statement of the paper; columns as in `CLAIM_HEADER`."""
    return [[claim.figure, claim.statement, claim.found, claim.verdict] for claim in claims]


def _row(part: PartFindings) -> list[str]:
    bulk, contact = part.bulk_peak, part.contact_peak
    place = ", ".join(f"{value / MILLIMETRE:.1f}" for value in bulk.place)
    return [
        *(part.part, _stress(bulk), _others(part), _angle(bulk), place, f"{bulk.safety:.3g}"),
        *(_stress(contact), _angle(contact), contact.contact, f"{contact.safety:.3g}"),
        f"{100 * part.refinement.change:.1f} %",
    ]


def _stress(peak: Peak) -> str:
    return f"{peak.stress / MEGAPASCAL:.3g}"


def _others(part: PartFindings) -> str:
    return ", ".join(f"{size / MEGAPASCAL:.3g}" if np.isfinite(size) else "-" for _, size in part.sensitivity)


def _angle(peak: Peak) -> str:
    return f"{np.degrees(peak.angle):.0f}"
