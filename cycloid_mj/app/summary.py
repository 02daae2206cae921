"""Results of a design for the page: header, checks with their remedies, static equilibrium, life.

Each function takes a reducer and returns JSON values, numbers with their units as the page shows them.
"""

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from typing import Any, cast

from cycloid_mj.app.controls import key_in_words, number_with_unit, with_symbols
from cycloid_mj.app.drawing import MARKED_PARTS
from cycloid_mj.app.drive import reducer_at_reference
from cycloid_mj.app.state import apply_changes, at_load
from cycloid_mj.app.verdicts import (
    TORQUE_RTOL,
    Verdicts,
    carried_torque,
    rated_item,
    requirement_verdicts,
    unmet_without_covers,
    verdict,
)
from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.judgement import Judgement, gravest, judge
from cycloid_mj.base.result import Quantity
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.checks import Check, soundness
from cycloid_mj.design import value_of
from cycloid_mj.design.layouts import Layout
from cycloid_mj.figures import figure
from cycloid_mj.life.checks import KINDS, check_reducer, life_remedies
from cycloid_mj.life.duration import format_life
from cycloid_mj.life.item import Rating
from cycloid_mj.life.items import rate_for_verdict
from cycloid_mj.life.rated import rated_and_momentary_torque, rated_torque
from cycloid_mj.parts.export import casing_or_none
from cycloid_mj.parts.export.drive import assembly_mass
from cycloid_mj.parts.export.motors import MotorName
from cycloid_mj.reducer import Reducer, RvReducer, reducer_of
from cycloid_mj.statics.sheet import load_of, quick_sheet

NAMES = {
    "backlash_arcmin": "Backlash",
    "lost_motion_arcmin": "Lost motion at ±3 %",
    "stiffness_nm_per_arcmin": "Torsional stiffness",
    "te_loaded_forward_arcsec": "Transmission error, peak to peak",
    "efficiency_percent": "Efficiency",
    "capacity_nm": "Torque at first yield",
    "pin_gear_peak_force_n": "Largest force on a pin",
    "tooth_peak_force_n": "Largest force on a tooth",
    "pin_gear_pressure_mpa": "Hertz pressure on a pin",
    "tooth_pressure_mpa": "Hertz pressure on a tooth",
    "output_peak_force_n": "Largest force on an output pin",
    "cam_peak_force_n": "Largest force on the cam",
    "crank_bearing_running_force_n": "Largest force of a crank on a disc",
    "crank_bearing_running_mean_force_n": "Its 10/3-power mean",
    "planet_mesh_force_n": "Largest force of a planet on the sun",
}
"""Keys of the catalogue -> names on the page, in their order."""

LOSSES: Mapping[Layout, Mapping[str, str]] = {
    "central": {"cam": "cam", "output": "output pins", "seals": "seals"},
    "rv": {"crank_bearing": "crank bearings", "planet": "planets", "seals": "seals and main bearings"},
}
"""Layout -> sources of friction next to the teeth -> their names; keys end in ``_friction_power`` but for seals."""

CLEARANCE = "clearance of "
"""Start of the labels of clearances."""

MAX_FOLLOWING = 2
"""Errors that a change of an error may cause and that its button resolves with it (heuristic)."""

POSES = 61
"""Crank angles of the rated torque in the header; its accuracy is `TORQUE_RTOL`."""


def geometry_figures(reducer: Reducer, required: Any = None) -> dict[str, Any]:
    """Return ``ratio``, ``diameter_mm`` and ``mass_kg`` (or None) for the header of the page, as JSON values.

    The dict also has ``verdicts``, which compares ratio and diameter with `required`, the values in the start form of
    the app by field name. Covers increase the diameter. Therefore a diameter without covers that is within its limit
    has no verdict; `life` judges the diameter with covers.
    """
    design, mass = reducer.design, None
    with suppress(CycloidError):  # a part cannot be built: the checks say which
        mass = figure("mass_kg").value(reducer)
    diameter = 2e3 * design.housing.outer_radius
    verdicts = requirement_verdicts(required, {"ratio": design.reduction, "drive_diameter_mm": diameter})
    if verdicts.get("diameter_mm", {}).get("judgement") == Judgement.PASSED:
        del verdicts["diameter_mm"]
    return {"ratio": design.reduction, "diameter_mm": diameter, "mass_kg": mass, "verdicts": verdicts}


def errors(reducer: Reducer) -> list[dict[str, Any]]:
    """Return the checks that a design fails and without which it cannot be built; empty for a valid design."""
    return _failed_checks_json(reducer, (check for check in soundness(reducer) if check.severity == "error"))


def checks(reducer: Reducer) -> dict[str, Any]:
    """Run all checks of a design at its load; return the failed checks, the warnings and a summary as JSON values.

    ``failed`` has the failed checks and warnings, ``count`` is the number of all checks, and ``judgement`` the gravest
    verdict; ``words`` is the summary.
    """
    loaded_reducer = at_load(reducer)
    results = check_reducer(loaded_reducer)
    return {
        "count": len(results),
        "judgement": gravest(check.judgement for check in results),
        "words": f"{len(results)} checks: {results.counts}"
        if results.failures or results.warnings
        else f"All {len(results)} checks passed",
        "failed": _failed_checks_json(loaded_reducer, (*results.failures, *results.warnings)),
    }


def remedies(reducer: Reducer, check_name: str) -> dict[str, Any]:
    """Return the changes of a design that resolve a failed check of life, heat or strength at its load, as JSON values.

    ``name`` in the result is the name of the check, and ``changes`` are the alternatives, empty if there are none. Each
    has ``changes`` (key of the design file -> new value) and ``words``.
    """
    loaded_reducer, name = at_load(reducer), check_name.replace(" ", "_")
    changes = life_remedies(loaded_reducer, [name]).get(name, ())
    return {"name": check_name, "changes": [_remedy_json(loaded_reducer, dict([change])) for change in changes]}


def statics(reducer: Reducer, required: Any = None) -> dict[str, Any]:
    """Return the data-sheet quantities that statics computes for a valid design at its load, as JSON values.

    ``rows`` has name, value and note of each quantity in `NAMES` that `quick_sheet` returns. ``losses`` has the mean
    powers of crank and output, and of each source of friction [W]. `required` are the values in the start form of the
    app by the field names in `REQUIREMENTS`, such as ``{"backlash_arcmin": 3.0}``. ``verdicts`` compares the backlash
    with that field only; it is empty without it. The other keys are ``condition`` (load, speed etc. in words),
    ``backlash_arcmin`` and ``assumptions`` (sentences). The errors that `quick_sheet` raises are not caught.
    """
    design = reducer.design
    sheet = quick_sheet(reducer)
    computed_quantities = {figure(key).key: quantity for key, quantity in sheet.quantities.items()}
    powers = {key: sheet.quantities[key].value for key in ("input_power", "output_power")}
    sources = {design.tooth_pair: "teeth", **LOSSES[reducer.LAYOUT]}
    losses = {
        name: sheet.quantities["seals_power" if key == "seals" else f"{key}_friction_power"].value
        for key, name in sources.items()
    }
    return {
        "condition": sheet.condition,
        "backlash_arcmin": computed_quantities["backlash_arcmin"].value,
        "verdicts": requirement_verdicts(required, {"backlash_arcmin": computed_quantities["backlash_arcmin"].value}),
        "rows": [
            {
                "name": name,
                "value": format_quantity(computed_quantities[key]),
                "note": computed_quantities[key].note or figure(key).definition,
            }
            for key, name in NAMES.items()
            if key in computed_quantities
        ],
        "losses": {**powers, "parts": [{"name": name, "watts": watts} for name, watts in losses.items()]},
        "assumptions": [sentence_in_words(assumption) for assumption in sheet.assumptions],
    }


def life(reducer: Reducer, required: Any = None, motor: MotorName = "auto") -> dict[str, Any]:
    """Rate a valid design at its load; return load capacity of its parts, life, and rated torque as JSON values.

    ``items`` are the rated parts, each with a kind of failure, ``life_h`` is the shortest of their lives, and
    ``limited_by`` names what limits the rated torque, which is that for the required life. ``verdicts`` compares rated
    torque, diameter and length with `required`, the values in the start form of the app by field name, and the life
    with the required life of the design. The torque counts as met if twice as much is allowed as a peak. Diameter and
    length are those with covers for the motor. If the covers do not fit, the requirements on diameter and length count
    as not met. An RV reducer has no covers: ``length_mm`` is the length of the drive.
    """
    hours_required = reducer.design.service.life
    rating = rate_for_verdict(at_load(reducer))
    lives = [item.life for item in rating.items.values() if item.decisive and item.life is not None]
    shortest_life = min(lives, default=math.inf)
    rated_torque, limited_by, momentary = _rated_torque(reducer, rating)
    verdicts = requirement_verdicts(required, {"carried_torque_nm": carried_torque(rated_torque, momentary)})
    size_verdicts, sizes = SIZES[reducer.LAYOUT](reducer, required, motor)
    verdicts |= size_verdicts
    verdicts["life_h"] = verdict(judge(shortest_life / hours_required), f"≥ {hours_required:.6g} h")
    return {
        "condition": f"{rating.duty}, parts {rating.parts}",
        "required_h": hours_required,
        "rated_torque_nm": rated_torque,
        "limited_by": limited_by,
        "momentary_torque_nm": momentary,
        "life_h": shortest_life,
        "life": format_life(shortest_life),
        "verdicts": verdicts,
        "items": rated_items(rating),
        **sizes,
    }


def _judge_covered_size(reducer: Reducer, required: Any, motor: MotorName) -> tuple[Verdicts, dict[str, Any]]:
    """Return the verdicts on diameter and length with covers, and the part of the result of `life` about sizes.

    `motor` is the motor of the requirement. `required` are the values in the start form by field name. The dict has
    ``cased`` (the result of `covered_size`), ``no_covers`` (why no covers fit, else empty) and ``length_mm``, which is
    None with covers.
    """
    size_with_covers, cover_problem = covered_size(reducer, motor)
    if size_with_covers:
        sizes = {"drive_diameter_mm": size_with_covers["diameter_mm"], "drive_length_mm": size_with_covers["length_mm"]}
        verdicts = requirement_verdicts(required, sizes)
    else:
        verdicts = unmet_without_covers(required)
    return verdicts, {"cased": size_with_covers, "no_covers": cover_problem, "length_mm": None}


def _judge_rv_size(reducer: Reducer, required: Any, _motor: MotorName) -> tuple[Verdicts, dict[str, Any]]:
    """Return the result of `_judge_covered_size` for an RV reducer, which has no covers."""
    sizes = rv_size(cast(RvReducer, reducer))
    length = sizes["drive_length_mm"]
    return requirement_verdicts(required, sizes), {"cased": None, "no_covers": "", "length_mm": length}


SIZES: Mapping[Layout, Callable[[Reducer, Any, MotorName], tuple[Verdicts, dict[str, Any]]]] = {
    "central": _judge_covered_size,
    "rv": _judge_rv_size,
}
"""Layout -> function that judges its size."""


def rv_size(reducer: RvReducer) -> dict[str, float]:
    """Return diameter and length of an RV reducer [mm], which has no covers, as figures of the requirements."""
    sizes = {"drive_diameter_mm": "outer_diameter_mm", "drive_length_mm": "length_mm"}
    return {name: figure(key).value(reducer) for name, key in sizes.items()}


def _rated_torque(reducer: Reducer, rating: Rating) -> tuple[float, str, float]:
    """Return the rated torque [N m] for the required life, the name of what limits it, and the momentary torque [N m].

    These are the values of the data sheet.

    For a design with tolerances, the torque is extrapolated from `rating`, its rating at the load. Otherwise the design
    is rated again at several torques. If a rating fails, both torques are 0, and the text of the error is returned.
    """
    if rating.parts == "toleranced":
        load, _ = load_of(reducer)
        (torque, limiting_item), (momentary, _) = rated_and_momentary_torque(rating.items.values(), load, rating.life)
        return torque, limiting_item.name, momentary
    design = reducer.design
    try:
        life = design.service.life
        torque, limiting_item = rated_torque(reducer, design.drive.speed, life, crank_angles=POSES, rtol=TORQUE_RTOL)
        momentary = figure("momentary_torque_nm").value(reducer)
    except CycloidError as error:
        return 0.0, str(error), 0.0
    rating_result = (
        (torque, limiting_item.name) if torque < momentary else (momentary, "emergency stop at twice the torque")
    )
    return *rating_result, momentary


def rated_items(rating: Rating) -> list[dict[str, Any]]:
    """Return the items of a rating that have a safety or a life, as rows with bars."""
    items = [item for item in rating.items.values() if item.safety is not None or item.life is not None]
    rows = [rated_item(item, rating.life) for item in items]
    return [row | {"title": sentence_in_words(row["title"])} for row in rows]


def covered_size(reducer: Reducer, motor: MotorName = "auto") -> tuple[dict[str, float] | None, str]:
    """Return ``diameter_mm``, ``length_mm`` and ``mass_kg`` with covers, bearings and screws, and an empty text.

    If the covers or the motor do not fit, or a part cannot be built, return None and the reason.
    """
    try:
        reference_reducer = reducer_at_reference(reducer)
        casing, reason = casing_or_none(reference_reducer, motor)
        if not casing:
            return None, reason
        lower_end, upper_end = casing.ends
        return {
            "diameter_mm": 2.0 * MILLIMETRES * casing.outer,
            "length_mm": MILLIMETRES * (upper_end - lower_end),
            "mass_kg": assembly_mass(reference_reducer, casing),
        }, ""
    except CycloidError as error:
        return None, str(error)


def _failed_checks_json(reducer: Reducer, evaluated_checks: Iterable[Check]) -> list[dict[str, Any]]:
    """Convert those of `evaluated_checks` that failed to JSON values, a dict each.

    The keys are ``name``, ``severity``, ``judgement``, ``part`` (which the page marks), ``what`` (value and limit),
    ``why``, ``remedy`` and ``changes`` (those of `_resolving_changes`). For a check in `KINDS` the ``remedy`` is empty,
    because it takes longer to compute; `remedies` returns it later.
    """
    return [
        {
            "name": check.name.replace("_", " "),
            "severity": check.severity,
            "judgement": check.judgement,
            "part": MARKED_PARTS.get(check.name, ""),
            "what": sentence_in_words(f"{key_in_words(check.key)} is {check.got}, must be {check.limit}"),
            "why": sentence_in_words(check.why),
            "remedy": "" if check.name in KINDS else sentence_in_words(check.remedy),
            "changes": [_remedy_json(reducer, change) for change in _resolving_changes(reducer, check)],
        }
        for check in evaluated_checks
        if not check.passed
    ]


def _resolving_changes(reducer: Reducer, check: Check) -> list[Mapping[str, float]]:
    """Return the changes of the design that resolve a failed check, those with the fewest keys first.

    If the check is an error, its changes are extended until no other error is left. Changes for which this fails are
    omitted; if it fails for all, all are returned without extension.
    """
    if check.severity != "error":
        return list(check.changes)
    completed_changes = [_complete_change(reducer, change, MAX_FOLLOWING) for change in check.changes]
    return sorted((change for change in completed_changes if change), key=len) or list(check.changes)


def _complete_change(reducer: Reducer, change: Mapping[str, float], max_additions: int) -> Mapping[str, float] | None:
    """Extend a change of the design by up to `max_additions` further changes until it causes no errors of other checks.

    `change` maps keys to new values. An extension never changes a key of `change` again. Return None if no extension
    resolves the errors.
    """
    failed_check = next(_errors_after(reducer, change), None)
    if failed_check is None:
        return change
    remaining_changes = (
        addition for addition in failed_check.changes if max_additions and not addition.keys() & change.keys()
    )
    completed = (_complete_change(reducer, {**change, **addition}, max_additions - 1) for addition in remaining_changes)
    return next((extended_change for extended_change in completed if extended_change), None)


def _errors_after(reducer: Reducer, change: Mapping[str, float]) -> Iterator[Check]:
    """Yield the failed checks of severity "error" of a design after a change; none if the change is not allowed."""
    with suppress(CycloidError):
        changed_reducer = reducer_of(apply_changes(reducer.design, _page_values(reducer, change)))
        yield from (check for check in soundness(changed_reducer) if check.severity == "error" and not check.passed)


def _remedy_json(reducer: Reducer, change: Mapping[str, float]) -> dict[str, Any]:
    """Return a remedy as a button has it: values by key, the motor torque as output torque, and words."""
    values = _page_values(reducer, change)
    return {"changes": values, "words": _change_in_words(reducer, values)}


def _page_values(reducer: Reducer, change: Mapping[str, float]) -> dict[str, float]:
    """Return the values of a change by key, the motor torque as output torque."""
    values = dict(change)
    if "drive.torque_nm" in values:
        values["load.torque_nm"] = float(f"{values.pop('drive.torque_nm') * reducer.design.reduction:.10g}")
    return values


def _change_in_words(reducer: Reducer, values: Mapping[str, float]) -> str:
    """Describe new values of keys in words, "raise X, Y to 5 mm"; keys with the same new value are listed together."""
    keys_by_target: dict[tuple[str, str], list[str]] = {}
    for key, value in values.items():
        verb = "raise" if value > value_of(reducer.design, key) else "lower"
        keys_by_target.setdefault((verb, number_with_unit(key, value)), []).append(key_in_words(key))
    parts = (f"{verb} {', '.join(names)} to {target_text}" for (verb, target_text), names in keys_by_target.items())
    return "; ".join(parts).replace(f", {CLEARANCE}", ", ")


def sentence_in_words(text: str) -> str:
    """Replace keys of the design file and units in a sentence by the words and symbols of the page."""
    text = re.sub(r"\b[a-z]+(?:_[a-z]+)*\.[a-z][a-z0-9_]*", lambda match: key_in_words(match[0]), text)
    text = re.sub(r"\b(?:pin_gear|tooth|pin_socket|pin_sleeve|cam|output)(?: \+ \w+)+", _name_pairs, text)
    text = re.sub(r"\b(?:pin_gear|pin_socket|pin_sleeve)\b", _name_pairs, text)
    return with_symbols(re.sub(r"(?<=[a-z]{2})_(?=[a-z]{2})", " ", text))  # names of parts, not indices of formulas


def _name_pairs(listed: re.Match[str]) -> str:
    """Name the pairs of parts of a sum such as ``cam + output``."""
    return " + ".join(key_in_words(f"clearance.{kind}_um").removeprefix(CLEARANCE) for kind in listed[0].split(" + "))


def format_quantity(quantity: Quantity) -> str:
    """Format a quantity with four digits and its unit."""
    return "-" if math.isnan(quantity.value) else f"{quantity.value:.4g} {quantity.unit}"
