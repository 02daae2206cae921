"""Try each change that a failed check proposes, and complete it until no other check fails because of it."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.judgement import Judgement
from cycloid_mj.checks import Check, Checks, soundness
from cycloid_mj.checks.check import Change
from cycloid_mj.checks.limit import round_beyond
from cycloid_mj.checks.margin import margin_rules
from cycloid_mj.checks.rule import evaluate
from cycloid_mj.design import override, value_of
from cycloid_mj.reducer import Reducer, RvReducer, reducer_of


@dataclass(frozen=True)
class AdviceSettings:
    """Settings of the search for a change that makes checks pass."""

    max_repairs: int = 6
    """Largest number of further changes that complete a change."""
    strides: tuple[float, float, float, float, float] = (0.02, 0.05, 0.1, 0.2, 0.5)
    """Shares by which a value is changed further to see where a check passes."""
    rtol: float = 1e-3
    """Relative accuracy of such a value."""


ADVICE = AdviceSettings()


RANKS = {Judgement.PASSED: 0, Judgement.NOT_APPLICABLE: 0, Judgement.WARNING: 1, Judgement.FAILED: 2}

EXACT_KEYS = {"output.hole_radius_mm", "planet.planet_teeth", "cranks.radius_mm", "cranks.count", "gear.discs"}
"""Keys whose value must be exact."""

TIED = {"gear.eccentricity_mm", "output.pin_radius_mm"}
"""Keys whose values add up to the hole's radius."""


def verify_remedies(reducer: Reducer, checks: Checks) -> Checks:
    """Try the remedies of all failed checks on the design; return the checks with only those remedies that work.

    A change is kept if the check passes with it and no other check that needs no statics gets worse. It is completed by
    changes for checks that fail because of it, such as a hole that depends on the eccentricity. If no change is left,
    the remedy names only the keys of the design file that could be changed. Checks that pass are returned unchanged.

    Parameters
    ----------
    checks
        All checks of the design, or only those without which it cannot be built (`soundness`).
    """
    checks_before = {check.name: check for check in checks}
    return Checks(check if check.passed else _verify_remedy(reducer, check, checks_before) for check in checks)


def _verify_remedy(reducer: Reducer, check: Check, checks_before: Mapping[str, Check]) -> Check:
    """Try the remedies of a failed check on the design; return the check with those that work, in numbers and words.

    Each change is completed by changes of other keys that it requires. `checks_before` are the checks of the unchanged
    design by name.
    """
    if not check.changes:
        return check
    tried_changes = tuple(
        _distinct(
            change
            for proposed_change in check.changes
            if (change := _complete_change(reducer, proposed_change, check, checks_before))
        )
    )
    if tried_changes == check.changes:
        return check
    keys = dict.fromkeys(key for change in check.changes for key in change)
    remedy_texts = [describe_change(reducer, change) for change in tried_changes] or [
        f"no change of a single key is enough: change {' and '.join(keys)} together with what depends on them"
    ]
    *_, last_alternative = check.remedy.split(", or ")
    if not any(key in last_alternative for key in keys):  # such as "lower the errors"
        remedy_texts.append(last_alternative)
    return replace(check, remedy=", or ".join(remedy_texts), changes=tried_changes)


def _distinct(changes: Iterable[Change]) -> Iterator[Change]:
    """Yield changes without those that came before."""
    earlier_changes: list[Change] = []
    for change in changes:
        if change not in earlier_changes:
            earlier_changes.append(change)
            yield change


def _complete_change(
    reducer: Reducer, change: Change, check: Check, checks_before: Mapping[str, Check]
) -> Change | None:
    """Add further keys to a change of a design until its check passes and no other gets worse; None if impossible.

    `check` is the failed check that proposes the change, `checks_before` are all checks of the unchanged design by
    name.
    """
    complete_change: dict[str, float] = dict(change)
    for _ in range(ADVICE.max_repairs):
        checks_after = quick_checks(reducer, complete_change)
        if checks_after is None:
            return None
        worse_checks = [
            check_after
            for check_after in checks_after.values()
            if _is_worse(check_after, checks_before.get(check_after.name), check.name)
        ]
        hole_check = checks_after.get("hole_size")
        if not worse_checks and hole_check and not hole_check.passed and complete_change.keys() & TIED:
            worse_checks = [hole_check]
        if not worse_checks:
            return complete_change
        repair = _choose_repair(reducer, worse_checks[0], complete_change)
        if repair is None:
            return None
        complete_change.update(repair)
    return None


def _is_worse(check_after: Check, check_before: Check | None, target_name: str) -> bool:
    """Return whether a check is more serious after a change of the design (`check_after`) than before (`check_before`).

    The check with the `target_name`, for which the change is made, must pass. A check that did not exist before, None,
    must not fail.
    """
    if check_after.name == target_name:
        return not check_after.passed
    return RANKS[check_after.judgement] > (RANKS[check_before.judgement] if check_before else RANKS[Judgement.WARNING])


def _choose_repair(reducer: Reducer, failed_check: Check, applied_change: Change) -> Change | None:
    """Choose the next change of a design that makes a failed check pass: a larger change, or one of other keys.

    `applied_change` maps the keys changed so far to their values, with which `failed_check` fails. Preferred is a
    remedy of the check that changes the same keys further in the same direction, then an increase by `_extend_change`,
    then a remedy that changes none of these keys; None if there is no such change.
    """
    design = reducer.design
    for change in failed_check.changes:
        extends_change = (
            key in applied_change
            and (value - applied_change[key]) * (applied_change[key] - value_of(design, key)) > 0.0
            for key, value in change.items()
        )
        if all(extends_change):
            return change
    if (
        failed_check.key not in EXACT_KEYS
        and len(applied_change) == 1
        and (extended_change := _extend_change(reducer, failed_check, applied_change))
    ):
        return extended_change
    return next((change for change in failed_check.changes if not change.keys() & applied_change.keys()), None)


def _extend_change(reducer: Reducer, failed_check: Check, applied_change: Change) -> Change | None:
    """Increase the change of one design key until the failed check passes: by growing steps, then by bisection.

    `applied_change` maps the key to its value so far, with which `failed_check` fails. Return the key with its new
    value, rounded to four digits, or None if the check never passes.
    """
    ((key, applied_value),) = applied_change.items()
    original_value = value_of(reducer.design, key)
    is_decrease, is_integer = applied_value < original_value, isinstance(original_value, int)
    convert = int if is_integer else float

    def passes(candidate: float) -> bool:
        checks_after = quick_checks(reducer, {key: candidate})
        return bool(checks_after and failed_check.name in checks_after and checks_after[failed_check.name].passed)

    failing_value = applied_value
    for relative_step in ADVICE.strides:
        passing_value = convert(
            round_beyond(
                applied_value / (1.0 + relative_step) if is_decrease else applied_value * (1.0 + relative_step),
                is_decrease,
                is_integer,
            )
        )
        if passes(passing_value):
            break
        failing_value = passing_value
    else:
        return None
    while abs(passing_value - failing_value) > max(ADVICE.rtol * abs(passing_value), float(is_integer)):
        midpoint = convert(round_beyond(0.5 * (failing_value + passing_value), is_decrease, is_integer))
        if midpoint in (failing_value, passing_value):
            break
        failing_value, passing_value = (failing_value, midpoint) if passes(midpoint) else (midpoint, passing_value)
    return {key: passing_value}


def quick_checks(reducer: Reducer, change: Change) -> dict[str, Check] | None:
    """Check a design with a `change`, without the slow checks that need statics; return the checks by name.

    `change` maps keys of the design file to new values. The result is None if the design file does not allow them. The
    checks of usual margins are left out if the design cannot be built.
    """
    try:
        changed_reducer = reducer_of(override(reducer.design, dict(change)))
        feasibility_checks = soundness(changed_reducer)
        if isinstance(changed_reducer, RvReducer) or any(
            check.judgement is Judgement.FAILED for check in feasibility_checks
        ):
            return {check.name: check for check in feasibility_checks}
        return {
            check.name: check
            for check in (*feasibility_checks, *evaluate(changed_reducer, margin_rules(changed_reducer)))
        }
    except CycloidError:
        return None


def describe_change(reducer: Reducer, change: Change) -> str:
    """Describe a change of the design in words, such as ``lower gear.eccentricity_mm to 0.949 or less``."""
    change_texts = []
    for key, value in change.items():
        is_lower = value < value_of(reducer.design, key)
        change_text = f"{'lower' if is_lower else 'raise'} {key} to {value:.10g}"
        change_texts.append(
            change_text
            if key in EXACT_KEYS or len(change) > 1
            else f"{change_text} or {'less' if is_lower else 'more'}"
        )
    return " and ".join(change_texts)
