"""The start form of the page: requirements of a new drive, and up to three drives or the alternatives."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, cast

from cycloid_mj.app.controls import with_symbols
from cycloid_mj.app.drive import parse_options
from cycloid_mj.app.state import BASES, changed_values
from cycloid_mj.app.summary import covered_size
from cycloid_mj.app.verdicts import carried_torque, requirement_verdicts, unmet_without_covers, verdict
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.judgement import Judgement, gravest
from cycloid_mj.base.units import MICROMETRES, MILLIMETRES, RPM
from cycloid_mj.design import PRESETS
from cycloid_mj.design.layouts import Layout
from cycloid_mj.design.processes import PROCESSES
from cycloid_mj.figures import figure
from cycloid_mj.life.as_built import find_likely_critical_samples
from cycloid_mj.life.duration import format_life
from cycloid_mj.life.heat import COOLING
from cycloid_mj.life.items import rate_for_verdict
from cycloid_mj.parts.export.motors import MotorName
from cycloid_mj.reducer import Reducer, reducer_of
from cycloid_mj.sizing.answer import Answer, SizedDrive
from cycloid_mj.sizing.drives import size_drive
from cycloid_mj.sizing.requirement import Requirement, make_requirement
from cycloid_mj.sizing.rv import DUTY_SHARE, OUTPUT_RPM, RvRequirement, size_rv

INTEGERS = ("ratio", "discs")
NUMBERS = (
    "diameter_mm",
    "torque_nm",
    "life_h",
    "speed_rpm",
    "duty_percent",
    "length_mm",
    "backlash_arcmin",
    "clearance_um",
)
WORDS = ("process", "material", "fit", "cooling", "motor", "layout")
"""Fields of the form by the kind of their values."""

RV_FIELDS = (
    *("ratio", "diameter_mm", "torque_nm", "life_h", "speed_rpm", "duty_percent", "length_mm", "clearance_um"),
    *("cooling", "layout"),
)
"""Fields that the search for RV reducers supports; it ignores all others."""


class FormKind(NamedTuple):
    """The search for drives of one layout.

    Attributes
    ----------
    fields
        Fields of the form that the search supports; it ignores all others.
    require
        Function that returns the requirement of the values of these fields, and of the motor.
    search
        Function that returns the drives, as `size_drive`.
    name
        First part of the names of the drives; empty for their process.
    has_covers
        Whether the drives have covers, which decide on their size.
    """

    fields: tuple[str, ...]
    require: Callable[[Mapping[str, Any], MotorName], Requirement]
    search: Callable[[Any, Callable[[Answer], None]], Answer]
    name: str
    has_covers: bool


NAMES = {
    "ratio": "ratio",
    "diameter_mm": "diameter with covers",
    "length_mm": "length",
    "torque_nm": "rated torque",
    "life_h": "life",
    "backlash_arcmin": "backlash",
}
"""Requirements, as they are named where a drive violates them."""


WARM_UP_DESIGN = PRESETS["printed"].but(tolerance={"cam": "uniform 10"})
"""A design with tolerances, whose rating needs the same compiled code as that of the candidates of a search."""


def parse_form(form: Any) -> Requirement:
    """Convert the values of the start form of the page to a requirement; empty fields are left out.

    `form` maps the names of its fields to values.

    Raises
    ------
    UsageError
        A value is missing, not a number, or out of its range.
    """
    if not isinstance(form, Mapping):
        raise UsageError(
            f"the form is of type {type(form).__name__}: send a JSON object of field names and values, such as "
            '{"ratio": 15}'
        )
    values = {key: value for key, value in form.items() if value not in ("", None)}
    allowed_fields = (*INTEGERS, *NUMBERS, *WORDS, "custom")
    if unknown_fields := set(values) - set(allowed_fields):
        raise UsageError(f"the form has an unknown field {min(unknown_fields)!r}: use only {', '.join(allowed_fields)}")
    for key in ("ratio", "diameter_mm", "torque_nm"):
        if key not in values:
            raise UsageError(f"the {key.partition('_')[0]} is missing: enter a number greater than 0")
    for key in (*INTEGERS, *NUMBERS):
        if key in values and not (type(values[key]) in (int, float) and math.isfinite(values[key])):
            raise UsageError(
                f"the {key.partition('_')[0]} is {values[key]!r}, which is not a number: enter a finite number"
            )
    if values.get("layout", "central") not in BASES:
        raise UsageError(f"unknown layout {values['layout']!r}: choose one of {', '.join(BASES)}")
    if values.get("process", "steel") not in PROCESSES:
        raise UsageError(f"unknown process {values['process']!r}: choose one of {', '.join(PROCESSES)}")
    for key in WORDS:
        if not isinstance(values.get(key, ""), str):
            raise UsageError(f'the {key} is {values[key]!r}, which is not text: send a string, such as "auto"')
    motor = parse_options(values).motor
    values.pop("motor", None)
    if "duty_percent" in values:
        values["duty"] = values.pop("duty_percent") / 100.0
    kind = FORM_KINDS[cast("Layout", values.pop("layout", "central"))]
    return kind.require({key: value for key, value in values.items() if key in (*kind.fields, "duty")}, motor)


def _require_central(values: Mapping[str, Any], motor: MotorName) -> Requirement:
    """Return the requirement of a drive with a central crank."""
    return make_requirement(**values, motor=motor)


def _require_rv(values: Mapping[str, Any], _motor: MotorName) -> Requirement:
    """Return the requirement of an RV reducer with the `values` of the start form, by field name.

    Missing fields have the defaults of ``design new --layout rv``. The motor has no effect.
    """
    values_with_defaults = {
        "duty": DUTY_SHARE,
        **({} if "speed_rpm" in values else {"output_rpm": OUTPUT_RPM}),
        **values,
    }
    return make_requirement(**values_with_defaults, kind=RvRequirement)


FORM_KINDS: Mapping[Layout, FormKind] = {
    "central": FormKind(
        (*INTEGERS, *NUMBERS, *WORDS, "custom"), _require_central, lambda *args: size_drive(*args), "", True
    ),
    "rv": FormKind(RV_FIELDS, _require_rv, lambda *args: size_rv(*args), "rv", False),
}
"""Layout -> its search for drives."""


def fill_form(requirement: Requirement) -> dict[str, Any]:
    """Convert a requirement, in SI, to the fields of the start form in the units of their names.

    A field without a limit (zero or infinite) is None.
    """

    def limit_or_none(value: float) -> float | None:
        return None if not math.isfinite(value) or value == 0.0 else float(f"{value:.10g}")

    values = {
        "layout": requirement.LAYOUT,
        "ratio": requirement.ratio,
        "diameter_mm": limit_or_none(MILLIMETRES * requirement.diameter),
        "torque_nm": requirement.torque,
        "life_h": requirement.life,
        "speed_rpm": limit_or_none(requirement.speed / RPM),
        "duty_percent": limit_or_none(100.0 * requirement.duty_share),
        "cooling": next((name for name, film in COOLING.items() if film == requirement.film), f"{requirement.film:g}"),
        "process": requirement.process,
        "discs": requirement.discs,
        "length_mm": limit_or_none(MILLIMETRES * requirement.length),
        "backlash_arcmin": limit_or_none(requirement.backlash),
        "material": requirement.material,
        "clearance_um": limit_or_none(MICROMETRES * requirement.clearance),
        "fit": requirement.fit,
        "custom": requirement.custom,
    }
    return {key: value for key, value in values.items() if key in FORM_KINDS[requirement.LAYOUT].fields}


def size(on_progress: Callable[[Any], None], form: Any) -> dict[str, Any]:
    """Find drives for the requirement in the start form of the page; return the answer as JSON values (`_answer_json`).

    `form` maps the names of the form's fields to values.
    `on_progress` is called with the preliminary answer, and again after each alternative that is added to it.
    """
    on_progress({"doing": "searching for proportions that meet the requirements"})
    motor = parse_options(form).motor
    requirement = parse_form(form)

    def report_answer(answer: Answer) -> None:
        on_progress({"answer": _answer_json(answer, motor)})

    return _answer_json(FORM_KINDS[requirement.LAYOUT].search(requirement, report_answer), motor)


def load_search() -> None:
    """Load the code of the search, and its compiled code, before the user has filled in the form."""
    find_likely_critical_samples([Reducer(WARM_UP_DESIGN)])
    rate_for_verdict(Reducer(WARM_UP_DESIGN))


def _answer_json(answer: Answer, motor: MotorName) -> dict[str, Any]:
    """Convert the result of a search for drives to JSON values for the page.

    `motor` is the motor of the requirement.

    Returns
    -------
    dict
        ``required``: the requirement as fields of the start form; ``drives`` and their common ``verdict``. If there are
        no drives, ``max_torque_nm`` is the largest feasible torque, ``limit`` is what limits it, ``refusal`` is the
        reason, and ``remedies`` are changed requirements that are feasible.
    """
    drives = [_drive_json(drive, answer.requirement, motor) for drive in answer.drives]
    return {
        "required": fill_form(answer.requirement),
        "drives": drives,
        "verdict": _summary_json(drives),
        "max_torque_nm": answer.most,
        "limit": with_symbols(answer.limit),
        "refusal": "" if answer.drives else with_symbols(answer.refusal),
        "remedies": [
            {"words": with_symbols(option.words), "required": fill_form(option.requirement)}
            for option in answer.remedies
        ],
    }


def _drive_json(drive: SizedDrive, requirement: Requirement, motor: MotorName) -> dict[str, Any]:
    """Convert a drive that the search returned to JSON values, with verdicts on the requirement.

    ``title`` and ``why`` describe it in words, ``design`` are its values as the page stores them, ``figures`` its
    quantities by key, ``life`` its life as text, ``verdicts`` the verdict on each field of the form, and ``verdict``
    the gravest of them. Its size and mass are those with covers for the motor; if these do not fit, the requirements on
    size are not met.
    """
    form, reason, kind = fill_form(requirement), "", FORM_KINDS[requirement.LAYOUT]
    name = f"{kind.name or requirement.process}-{requirement.ratio}"
    design = drive.design.but(name=name, load={"torque": requirement.torque})
    # the backlash of parts without deviations, as in the header of the page: samples within the tolerances have less
    figures = dict(drive.figures) | {"backlash_arcmin": figure("backlash_arcmin").value(reducer_of(design))}
    if not kind.has_covers:
        figures["drive_diameter_mm"] = figures["outer_diameter_mm"]
    figures["carried_torque_nm"] = carried_torque(figures["rated_torque_nm"], figures["momentary_torque_nm"])
    if motor != "auto" and kind.has_covers:
        size_with_covers, reason = covered_size(Reducer(design), motor)
        sizes = {"drive_diameter_mm": "diameter_mm", "drive_length_mm": "length_mm", "mass_kg": "mass_kg"}
        figures |= {key: size_with_covers[size_key] for key, size_key in sizes.items()} if size_with_covers else {}
    verdicts = requirement_verdicts(form, figures) | (unmet_without_covers(form) if reason else {})
    violations = {field: result for field, result in verdicts.items() if result["judgement"] != Judgement.PASSED}
    requirement_texts = [f"{NAMES[field]}: {result['words']} required" for field, result in violations.items()]
    violation_text = "; ".join([*requirement_texts, *filter(None, (reason,))])
    return {
        "title": drive.title,
        "why": drive.why,
        "design": changed_values(design),
        "figures": figures,
        "life": format_life(figures["life_h"]),
        "verdicts": verdicts,
        "verdict": verdict(gravest(Judgement(result["judgement"]) for result in verdicts.values()), violation_text),
    }


def _summary_json(drives: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """Return the common verdict on the drives, as ``judgement`` and ``words``.

    It is passed if all drives meet the requirements, a warning if only some do, and failed if none does.
    """
    passed_count, drive_count = sum(drive["verdict"]["judgement"] == Judgement.PASSED for drive in drives), len(drives)
    if passed_count == drive_count:
        return verdict(
            Judgement.PASSED, f"{drive_count} drive{'s meet' if drive_count > 1 else ' meets'} the requirements"
        )
    if passed_count:
        return verdict(
            Judgement.WARNING,
            f"{passed_count} of {drive_count} drives meet{'s' if passed_count == 1 else ''} the requirements",
        )
    verdicts = [item for drive in drives for item in drive["verdicts"].items()]
    field_names = dict.fromkeys(NAMES[field] for field, result in verdicts if result["judgement"] != Judgement.PASSED)
    return verdict(Judgement.FAILED, f"No drive meets all requirements: see {', '.join(field_names)}")
