"""Checks of life, fatigue, heat and emergency stops at the nominal torque, and all checks of a design together."""

from collections.abc import Iterator, Sequence
from contextlib import suppress

from cycloid_mj.base.errors import CycloidError, DesignError
from cycloid_mj.base.units import MILLIMETRES, RPM
from cycloid_mj.checks import Check, Checks, check
from cycloid_mj.checks.advice import with_tried_advice
from cycloid_mj.design import Named, override, resolve
from cycloid_mj.life.item import RatedItem, Rating
from cycloid_mj.life.items import rate, rate_at_rated_load
from cycloid_mj.life.rated import is_momentary, rated_torque
from cycloid_mj.reducer import Reducer, RvReducer, reducer_of

REMEDY = "lower drive.torque_nm to the rated torque of `cycloid-mj datasheet`, or see `cycloid-mj rate` for each item"

FEW_POSES, TORQUE_RTOL = 61, 5e-3
"""Crank angles and relative accuracy of the torque of a remedy."""

BELOW, ABOVE = -1, 1

MAX_WIDENING, MIN_LIFE = 2.0, 1.0
"""Largest factor on the face width, and shortest required life [h], of a remedy."""

KINDS = {
    "momentary_torque": (
        "the safety factor of the momentary torque",
        "an emergency stop is assumed to take twice the nominal torque",
    ),
    "heat": ("the safety factor of heat", "grease, seals, materials or clearances fail if the housing gets hotter"),
    "life": ("the life", "the first part that fails ends the life of the drive (service.life_h)"),
    "strength": ("the safety factor of strength", "surfaces yield, or a part fails by fatigue"),
}
"""Name of a check -> what it checks, and why."""


def check_design(design: Named) -> Checks:
    """Return every check of a design: whether it can be built, how well it works, and whether it lasts.

    The last two need a design that can be built, and are warnings. From Python as ``cm.check(design)``.

    Parameters
    ----------
    design
        A design, or the name of a preset or a file.

    Returns
    -------
    Checks
        Each check with value, bound and advice; `failures` and `warnings` list those that are not passed.
    """
    reducer = reducer_of(resolve(design))
    checks = check(reducer.design)
    if isinstance(reducer, RvReducer):
        return checks
    checks = with_tried_advice(reducer, checks)
    return checks if checks.failures else Checks((*checks, *life_checks(reducer)))


def life_checks(reducer: Reducer) -> tuple[Check, ...]:
    """Check whether a sound design withstands its nominal torque and speed for its required life; all are warnings.

    Empty where the crank stands still, or where there is no static balance, which `rated_load` reports.
    """
    try:
        return checks_of_rating(rate_at_rated_load(reducer))
    except CycloidError:
        return ()


def life_remedies(reducer: Reducer) -> dict[str, tuple[tuple[str, float], ...]]:
    """Return single changes with which each failed check of `life_checks` passes, as keys of the file and values.

    They are less torque or, depending on the check, a wider face, a shorter life or a slower crank; each was tried.
    """
    try:
        rating = rate_at_rated_load(reducer)
    except CycloidError:
        return {}
    return {
        check.name: tuple(
            change for change in _candidates(reducer, rating, check) if _passes_with(reducer, change, check.name)
        )
        for check in checks_of_rating(rating)
        if not check.passed
    }


def _candidates(reducer: Reducer, rating: Rating, failed: Check) -> Iterator[tuple[str, float]]:
    """Yield changes that may make a failed check pass, by the laws of its items."""
    design = reducer.design
    keys = {item.key for item in rating.items.values() if item.decisive and _kind(item) == failed.name}
    with suppress(DesignError):  # no torque is enough
        torque, _ = rated_torque(
            reducer, design.drive.speed, rating.life, keys.__contains__, poses=FEW_POSES, exact=TORQUE_RTOL, stops=True
        )
        yield "drive.torque_nm", _rounded_safely(torque, BELOW) / design.reduction
        if failed.name in ("life", "strength") and (share := design.rated_torque / torque) < MAX_WIDENING:
            yield "gear.face_width_mm", _rounded_safely(MILLIMETRES * design.gear.face_width * share, ABOVE)
    if failed.name == "life" and failed.value and failed.value > MIN_LIFE:
        yield "service.life_h", _rounded_safely(failed.value, BELOW)
    if failed.name == "heat" and failed.value:
        yield "drive.speed_rpm", _rounded_safely(design.drive.speed / RPM * failed.value, BELOW)


def _passes_with(reducer: Reducer, change: tuple[str, float], name: str) -> bool:
    """Return whether a check of `KINDS` passes after a change."""
    try:
        checks = checks_of_rating(rate(override(reducer.design, dict([change]))))
    except CycloidError:
        return False
    return all(check.passed for check in checks if check.name == name)


def _rounded_safely(value: float, side: int) -> float:
    """Round to three digits, on the safe side of a value that is accurate to `TORQUE_RTOL`."""
    return float(f"{(1.0 + 2.0 * side * TORQUE_RTOL) * value:.3g}")


def checks_of_rating(rating: Rating) -> tuple[Check, ...]:
    """Summarize a rating as checks, one for each of `KINDS` by its weakest item."""
    items = [item for item in rating.items.values() if item.decisive]
    return tuple(_checks(rating, items))


def _checks(rating: Rating, items: Sequence[RatedItem]) -> Iterator[Check]:
    """Yield the checks of `checks_of_rating`."""
    for kind, (about, why) in KINDS.items():
        of_kind = [item for item in items if _kind(item) == kind]
        if not of_kind:
            continue
        weakest = min(of_kind, key=lambda item: item.margin(rating.life))
        margin = weakest.margin(rating.life)
        by_life = weakest.safety is None
        yield Check(
            name=kind,
            passed=margin >= 1.0,
            got=f"{weakest.verdict} ({weakest.name})",
            limit=f"at least {rating.life:g} h" if by_life else "at least 1",
            why=f"{why}; {weakest.load_text}, limit {weakest.limit_text}, at {rating.duty}",
            remedy="" if margin >= 1.0 else REMEDY,
            severity="warning",
            key=about,
            value=weakest.life if by_life else weakest.safety,
            bound=rating.life if by_life else 1.0,
            unit="h" if by_life else "1",
        )


def _kind(item: RatedItem) -> str:
    """Return which of `KINDS` an item belongs to."""
    if is_momentary(item.key):
        return "momentary_torque"
    if item.key == "temperature" or item.key.endswith("_hot_clearance"):
        return "heat"
    return "life" if item.safety is None else "strength"
