"""Verdicts of the page, all by `cycloid_mj.base.judgement`: JavaScript shows them and judges nothing."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from cycloid_mj.base.judgement import Judgement, judge
from cycloid_mj.life.duty import PEAK_FACTOR
from cycloid_mj.life.item import RatedItem

TORQUE_RTOL = 5e-3
"""Relative accuracy of the rated torque in the header of the page."""

SIZE_RTOL = 1e-4
"""Relative tolerance of the other requirements: values in the address of the page are rounded."""

BAR_DECADES = 2.0
"""Decades of a margin on each side of the middle of its bar."""

SMALLEST_BAR = 0.01
"""Shortest bar, as a fraction of a full one, so that it can be seen."""


class RequirementLimit(NamedTuple):
    """A field of the start form, the figure that it limits, and how."""

    figure: str
    sense: str
    unit: str
    rtol: float = SIZE_RTOL


REQUIREMENTS: Mapping[str, RequirementLimit] = {
    "ratio": RequirementLimit("ratio", "", ":1"),
    "diameter_mm": RequirementLimit("drive_diameter_mm", "≤ ", "mm"),
    "length_mm": RequirementLimit("drive_length_mm", "≤ ", "mm"),
    "torque_nm": RequirementLimit("carried_torque_nm", "≥ ", "N m", TORQUE_RTOL),
    "life_h": RequirementLimit("life_h", "≥ ", "h"),
    "backlash_arcmin": RequirementLimit("backlash_arcmin", "≤ ", "arcmin"),
}
"""Fields of the start form; diameter and length are those of the drive with its covers, see also `carried_torque`."""

SIZES = ("diameter_mm", "length_mm")
"""Requirements of the size with covers."""

Verdicts = dict[str, dict[str, str]]


def requirement_verdicts(required: Any, figures: Mapping[str, float]) -> Verdicts:
    """Compare quantities of a drive, such as its backlash, with the requirements of the start form.

    Parameters
    ----------
    required
        Values in the form by field name, or None; a value that is not a positive number is no requirement.
    figures
        Quantities by their keys; a requirement whose quantity is missing is not judged.

    Returns
    -------
    dict
        Field of the form -> dict with ``judgement`` (passed, failed, ...) and ``words``, the requirement in words such
        as "≤ 70 mm".
    """
    verdicts: Verdicts = {}
    for field, rule in REQUIREMENTS.items():
        limit = required.get(field) if isinstance(required, Mapping) else None
        if not isinstance(limit, int | float) or isinstance(limit, bool) or not 0.0 < limit < math.inf:
            continue
        if rule.figure in figures:
            margin = _margin_to_limit(figures[rule.figure], float(limit), rule.sense) * (1.0 + rule.rtol)
            verdicts[field] = verdict(judge(margin), f"{rule.sense}{limit:.6g} {rule.unit}".replace(" :", ":"))
    return verdicts


def carried_torque(rated: float, momentary: float) -> float:
    """Return the torque [N m] that a drive carries continuously, with `PEAK_FACTOR` times as much as a peak.

    `rated` and `momentary` are the torques of the data sheet [N m].
    """
    return min(rated, momentary / PEAK_FACTOR)


def unmet_without_covers(required: Any) -> Verdicts:
    """Return the failed verdicts of the sizes that a drive without covers cannot meet: it cannot be built."""
    infinite = dict.fromkeys((REQUIREMENTS[field].figure for field in SIZES), math.inf)
    return {
        field: verdict(Judgement.FAILED, f"{result['words']} with covers, which do not fit")
        for field, result in requirement_verdicts(required, infinite).items()
    }


def verdict(judgement: Judgement, words: str) -> dict[str, str]:
    """Return a verdict as JSON has it."""
    return {"judgement": judgement, "words": words}


def _margin_to_limit(value: float, limit: float, side: str) -> float:
    """Return the margin of a value to its limit: limit / value for the side "≤ ", value / limit for "≥ ".

    For an empty `side`, the value must equal its limit: the margin is 1 if it does, else 0.
    """
    if not side:
        return float(value == limit)
    return limit / value if side.startswith("≤") else value / limit


def rated_item(item: RatedItem, life: float) -> dict[str, Any]:
    """Convert a rated part with a kind of failure to a table row with a bar as JSON values, for a required life [h].

    ``name`` is its name, ``judgement`` the verdict, ``text`` is the life or safety factor in words, ``title`` has load,
    limit, source and note, and ``margin`` is 1 where the part is just sufficient. ``share`` is the length of the bar, 0
    to 1, on a logarithmic scale of ``margin``: 0.5 where the part is just sufficient, 1 at a margin of 10 to the power
    of `BAR_DECADES` or more, and never less than `SMALLEST_BAR`.
    """
    margin = item.margin(life)
    decades = math.log10(max(margin, 1e-9)) / (2.0 * BAR_DECADES) if math.isfinite(margin) else 1.0
    limit = f" of {item.limit_text}" if item.limit_text else ""
    return {
        "name": item.name,
        "text": f"safety {item.verdict}" if item.safety is not None else item.verdict,
        "judgement": item.judgement(life),
        "margin": margin,
        "share": min(1.0, max(SMALLEST_BAR, 0.5 + decades)),
        "title": ". ".join(filter(None, (f"{item.load_text}{limit}", item.source, item.note))),
    }
