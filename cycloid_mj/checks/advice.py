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
from cycloid_mj.reducer import Reducer


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

TWO_SIDED = "output.hole_radius_mm"
"""The key whose value must be exact."""

TIED = {"gear.eccentricity_mm", "output.pin_radius_mm"}
"""Keys whose values add up to the hole's radius."""


def with_tried_advice(reducer: Reducer, checks: Checks) -> Checks:
    """Return checks whose remedies were tried on the design.

    A change stays if with it the check passes and no other gets worse, of those that need no statics. It is completed
    by changes that make the checks pass that fail because of it, such as a hole that depends on the eccentricity. If no
    change is left, the remedy names the keys only.

    Parameters
    ----------
    checks
        All of its checks, or those of `soundness` alone.
    """
    before = {check.name: check for check in checks}
    return Checks(check if check.passed else _with_tried_remedy(reducer, check, before) for check in checks)


def _with_tried_remedy(reducer: Reducer, check: Check, before: Mapping[str, Check]) -> Check:
    """Return a failed check with the changes that work, completed, and its remedy in words."""
    if not check.changes:
        return check
    tried = tuple(
        _distinct(change for proposed in check.changes if (change := _complete(reducer, proposed, check, before)))
    )
    if tried == check.changes:
        return check
    keys = dict.fromkeys(key for change in check.changes for key in change)
    texts = [describe(reducer, change) for change in tried] or [
        f"no change of a single key is enough: change {' and '.join(keys)} together with what depends on them"
    ]
    *_, last = check.remedy.split(", or ")
    if not any(key in last for key in keys):  # such as "lower the errors"
        texts.append(last)
    return replace(check, remedy=", or ".join(texts), changes=tried)


def _distinct(changes: Iterable[Change]) -> Iterator[Change]:
    """Yield changes without those that came before."""
    seen: list[Change] = []
    for change in changes:
        if change not in seen:
            seen.append(change)
            yield change


def _complete(reducer: Reducer, change: Change, check: Check, before: Mapping[str, Check]) -> Change | None:
    """Complete a change until the check passes and no other is worse than before; None if that leads nowhere."""
    done: dict[str, float] = dict(change)
    for _ in range(ADVICE.max_repairs):
        after = quick_checks(reducer, done)
        if after is None:
            return None
        worse = [other for other in after.values() if _is_worse(other, before.get(other.name), check.name)]
        tied = after["hole_size"]
        if not worse and not tied.passed and done.keys() & TIED:
            worse = [tied]
        if not worse:
            return done
        repair = _repair(reducer, worse[0], done)
        if repair is None:
            return None
        done.update(repair)
    return None


def _is_worse(after: Check, before: Check | None, name: str) -> bool:
    """Return whether a check is more serious than before; a new check must not be a failure."""
    if after.name == name:
        return not after.passed
    return RANKS[after.judgement] > (RANKS[before.judgement] if before else RANKS[Judgement.WARNING])


def _repair(reducer: Reducer, failed: Check, done: Change) -> Change | None:
    """Choose a change that makes a check pass after another: more of the same, else of other keys."""
    design = reducer.design
    for change in failed.changes:
        further = (
            key in done and (value - done[key]) * (done[key] - value_of(design, key)) > 0.0
            for key, value in change.items()
        )
        if all(further):
            return change
    if failed.key != TWO_SIDED and len(done) == 1 and (further_still := _further(reducer, failed, done)):
        return further_still
    return next((change for change in failed.changes if not change.keys() & done.keys()), None)


def _further(reducer: Reducer, failed: Check, done: Change) -> Change | None:
    """Change one key by more, in the same direction, until a check passes, to four digits; None if it never does."""
    ((key, value),) = done.items()
    original = value_of(reducer.design, key)
    lower, is_integer = value < original, isinstance(original, int)

    def passes(candidate: float) -> bool:
        after = quick_checks(reducer, {key: candidate})
        return bool(after and failed.name in after and after[failed.name].passed)

    near = value
    for stride in ADVICE.strides:
        far = float(round_beyond(value / (1.0 + stride) if lower else value * (1.0 + stride), lower, is_integer))
        if passes(far):
            break
        near = far
    else:
        return None
    while abs(far - near) > max(ADVICE.rtol * abs(far), float(is_integer)):
        middle = float(round_beyond(0.5 * (near + far), lower, is_integer))
        if middle in (near, far):
            break
        near, far = (near, middle) if passes(middle) else (middle, far)
    return {key: far}


def quick_checks(reducer: Reducer, change: Change) -> dict[str, Check] | None:
    """Return the checks of a changed design that need no statics, by name; None if the file forbids the change."""
    try:
        changed = Reducer(override(reducer.design, dict(change)))
        sound = soundness(changed)
        if any(check.judgement is Judgement.FAILED for check in sound):
            return {check.name: check for check in sound}
        return {check.name: check for check in (*sound, *evaluate(changed, margin_rules(changed)))}
    except CycloidError:
        return None


def describe(reducer: Reducer, change: Change) -> str:
    """Describe a change: ``lower gear.eccentricity_mm to 0.949 or less``; of several keys all together."""
    texts = []
    for key, value in change.items():
        lower = value < value_of(reducer.design, key)
        text = f"{'lower' if lower else 'raise'} {key} to {value:.10g}"
        texts.append(text if key == TWO_SIDED or len(change) > 1 else f"{text} or {'less' if lower else 'more'}")
    return " and ".join(texts)
