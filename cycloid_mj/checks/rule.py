"""Rules for values of a design, and their evaluation."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace

from cycloid_mj.checks.check import Check, Severity
from cycloid_mj.checks.limit import Limit, millimetres, single_remedies
from cycloid_mj.reducer import Reducer


@dataclass(frozen=True)
class Rule:
    """A limit on a design, from which `evaluate` creates a check.

    Attributes
    ----------
    name, limit, why, severity
        As in `Check`.
    alternatives
        Limits on other keys, each of which is a remedy too.
    tied
        Whether the checked value depends on others, so that changing it alone is no remedy.
    failure
        A rule on the same value with a wider limit, whose violation is an error. If it is violated, its check is
        returned instead, with the remedy of this rule.
    """

    name: str
    limit: Limit
    why: str
    alternatives: tuple[Limit, ...] = ()
    severity: Severity = "error"
    tied: bool = False
    failure: "Rule | None" = None


def wall_rule(
    name: str,
    limits: Callable[[float], tuple[Limit, ...]],
    share: float,
    radius: float,
    location: str,
    depends_on_others: bool = False,
) -> Rule:
    """Return the rule of a wall thickness: a warning below an assumed thickness, an error if no wall is left.

    Parameters
    ----------
    name
        Name of the check.
    limits
        Function that maps a wall thickness, divided by `radius` [1], to limits. Each `Limit` is the bound on a key of
        the design at which the wall has this thickness, such as a largest value of "gear.bore_radius". The first is
        that of the checked key; the others are alternative remedies.
    share, radius
        Assumed smallest wall thickness, divided by `radius` [1], and radius of the pin circle [m].
    location
        Position of the wall, in words.
    depends_on_others
        Whether the checked value depends on others, so that changing it alone is no remedy (`Rule.tied`).
    """
    limit, *other_limits = limits(share)
    explanation = (
        f"the wall {location} should be at least {millimetres(share * radius)} thick ({share:.0%} of E, assumed)"
    )
    no_wall = Rule(name, limits(0.0)[0], f"there is no wall left {location}")
    return Rule(
        name, limit, explanation, tuple(other_limits), severity="warning", tied=depends_on_others, failure=no_wall
    )


def evaluate(reducer: Reducer, rules: Iterable[Rule | Check]) -> Iterator[Check]:
    """Evaluate rules on a design, in their order; checks among them are passed through."""
    return (rule if isinstance(rule, Check) else _evaluate_rule(reducer, rule) for rule in rules)


def _evaluate_rule(reducer: Reducer, rule: Rule) -> Check:
    """Evaluate a design `rule` on a reducer; return its check with value, limit and remedy.

    A rule that warns may have a second rule `failure` with a wider limit. If that is violated too, the check of the
    second rule, which is an error, is returned instead, with the remedy of `rule`.
    """
    limit = rule.limit
    is_passed = limit.is_met(reducer)
    value_text, limit_text = limit.texts(reducer)
    remedies = [] if is_passed else [*([] if rule.tied else [limit]), *rule.alternatives]
    keys = " and ".join(remedy.file_key for remedy in remedies)
    remedy = single_remedies(reducer, remedies)
    if remedies and not remedy["remedy"]:
        remedy["remedy"] = f"no change of a single key is enough: change {keys} together"
        if len(remedies) == 1:
            remedy["remedy"] = f"no value of {keys} is enough: change other dimensions, too"
    check = Check(
        name=rule.name,
        passed=is_passed,
        got=value_text,
        limit=limit_text,
        why=rule.why,
        severity=rule.severity,
        key=limit.file_key,
        **remedy,
        **limit.numbers(reducer),
    )
    if rule.failure is None or rule.failure.limit.is_met(reducer):
        return check
    return replace(_evaluate_rule(reducer, rule.failure), remedy=check.remedy, changes=check.changes)
