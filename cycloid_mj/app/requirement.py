"""What a new drive is asked for on the page, and the answer: up to three drives, or the most that goes and ways out."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from cycloid_mj.app.controls import with_symbols
from cycloid_mj.app.state import values_of
from cycloid_mj.app.verdicts import requirement_verdicts, verdict
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.judgement import Judgement, gravest
from cycloid_mj.base.units import MICROMETRES, MILLIMETRES, RPM
from cycloid_mj.life.hours import hours
from cycloid_mj.sizing.answer import Answer, SizedDrive, answered
from cycloid_mj.sizing.process import PROCESSES
from cycloid_mj.sizing.requirement import Requirement, required

WHOLE = ("ratio", "discs")
NUMBERS = ("diameter_mm", "torque_nm", "life_h", "speed_rpm", "length_mm", "backlash_arcmin", "clearance_um")
WORDS = ("process", "material", "fit")

NAMES = {
    "ratio": "ratio",
    "diameter_mm": "diameter with covers",
    "length_mm": "length",
    "torque_nm": "rated torque",
    "life_h": "life",
    "backlash_arcmin": "backlash",
}
"""Requirements, as they are named where a drive violates them."""


def requirement_of(form: Any) -> Requirement:
    """Read what is asked for from the page's form; what is empty is left out.

    Raises
    ------
    UsageError
        A value is missing, none, or out of its range.
    """
    if not isinstance(form, Mapping):
        raise UsageError("a form is asked for: its fields with their values")
    given = {key: value for key, value in form.items() if value not in ("", None)}
    if unknown := set(given) - {*WHOLE, *NUMBERS, *WORDS, "custom"}:
        raise UsageError(f"there is no field {min(unknown)!r}")
    for key in ("ratio", "diameter_mm", "torque_nm"):
        if key not in given:
            raise UsageError(f"the {key.partition('_')[0]} is missing")
    for key in (*WHOLE, *NUMBERS):
        if key in given and not (type(given[key]) in (int, float) and math.isfinite(given[key])):
            raise UsageError(f"the {key.partition('_')[0]} is {given[key]!r}: give a number")
    if given.get("process", "steel") not in PROCESSES:
        raise UsageError(f"there is no process {given['process']!r}: it is one of {', '.join(PROCESSES)}")
    for key in WORDS:
        if not isinstance(given.get(key, ""), str):
            raise UsageError(f"the {key} is {given[key]!r}: give a word")
    return required(**given)


def form_of(asked: Requirement) -> dict[str, Any]:
    """Write a requirement as the page's form has it."""

    def plain(value: float) -> float | None:
        return None if not math.isfinite(value) or value == 0.0 else float(f"{value:.10g}")

    return {
        "ratio": asked.ratio,
        "diameter_mm": plain(MILLIMETRES * asked.diameter),
        "torque_nm": asked.torque,
        "life_h": asked.life,
        "speed_rpm": plain(asked.speed / RPM),
        "process": asked.process,
        "discs": asked.discs,
        "length_mm": plain(MILLIMETRES * asked.length),
        "backlash_arcmin": plain(asked.backlash),
        "material": asked.material,
        "clearance_um": plain(MICROMETRES * asked.clearance),
        "fit": asked.fit,
        "custom": asked.custom,
    }


def size(told: Callable[[Any], None], form: Any) -> dict[str, Any]:
    """Find drives for a requirement; pass on a refusal as its ways out are found."""
    told({"doing": "searching proportions that hold it"})
    return _answer(answered(requirement_of(form), lambda answer: told({"answer": _answer(answer)})))


def _answer(answer: Answer) -> dict[str, Any]:
    drives = [_drive(drive, answer.asked) for drive in answer.drives]
    return {
        "asked": form_of(answer.asked),
        "drives": drives,
        "verdict": _summary([drive["verdict"]["judgement"] for drive in drives]),
        "most": answer.most,
        "limit": with_symbols(answer.limit),
        "refusal": "" if answer.drives else with_symbols(answer.refusal),
        "ways": [{"words": with_symbols(way.words), "asked": form_of(way.asked)} for way in answer.ways],
    }


def _drive(drive: SizedDrive, required: Requirement) -> dict[str, Any]:
    figures = dict(drive.figures)
    verdicts = requirement_verdicts(form_of(required), figures)
    violated = {field: one for field, one in verdicts.items() if one["judgement"] != Judgement.PASSED}
    words = "; ".join(f"{NAMES[field]}: {one['words']} required" for field, one in violated.items())
    return {
        "title": drive.title,
        "why": drive.why,
        "design": values_of(drive.design.but(load={"torque": required.torque})),
        "figures": figures,
        "life": hours(figures["life_h"]),
        "verdicts": verdicts,
        "verdict": verdict(gravest(Judgement(one["judgement"]) for one in verdicts.values()), words),
    }


def _summary(judgements: Sequence[str]) -> dict[str, str]:
    """Summarize how many drives meet the requirements: passed if all do, a warning if some do."""
    met, count = judgements.count(Judgement.PASSED), len(judgements)
    if met == count:
        return verdict(Judgement.PASSED, f"{count} drive{'s meet' if count > 1 else ' meets'} the requirements")
    if met:
        return verdict(Judgement.WARNING, f"{met} of {count} drives meet{'s' if met == 1 else ''} the requirements")
    nearest = "the nearest drive is" if count == 1 else f"the nearest {count} drives are"
    return verdict(Judgement.FAILED, f"No drive meets all requirements; {nearest}")
