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
from cycloid_mj.life.rated import is_held_once, rated_torque
from cycloid_mj.reducer import Reducer

REMEDY = (
    "lower drive.torque_nm to what `cycloid-mj datasheet` rates it for, or see `cycloid-mj rate` for what to change"
)

FEW, NEAR = 61, 5e-3
"""Crank angles, and relative accuracy, of the torque that is to be borne instead."""

BELOW, ABOVE = -1, 1

WIDEST, SHORTEST = 2.0, 1.0
"""Times as wide as it is that a gear may become, and the least life that may be asked for instead [h]."""

KINDS = {
    "momentary_torque": (
        "the safety of what is held once",
        "twice the nominal torque is to be held once, as in an emergency stop",
    ),
    "heat": ("the safety against heat", "grease, seals, materials and clearances end where the housing gets hotter"),
    "life": ("the life", "the first part that wears out ends the drive (service.life_h)"),
    "strength": ("the safety of the strength", "surfaces yield, or a part breaks by fatigue"),
}
"""Name of a check -> what it is about, and why."""


def check_design(design: Named) -> Checks:
    """Return every check of a design: whether it can be built, how well it works, and whether it lasts.

    The last two need a design that can be built, and are warnings. From Python as ``cm.check(design)``.

    Parameters
    ----------
    design
        A design, or the name of a preset or a file.
    """
    reducer = Reducer(resolve(design))
    checks = with_tried_advice(reducer, check(reducer.design))
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
    """Return the single changes that mend each failed check of `life_checks`, as keys of the design file and values.

    They are less torque or, by what fails, a wider gear, a shorter life or a slower crank; each was tried.
    """
    try:
        rating = rate_at_rated_load(reducer)
    except CycloidError:
        return {}
    failed = [one for one in checks_of_rating(rating) if not one.passed]
    return {
        one.name: tuple(change for change in _candidates(reducer, rating, one) if _mends(reducer, change, one.name))
        for one in failed
    }


def _candidates(reducer: Reducer, rating: Rating, failed: Check) -> Iterator[tuple[str, float]]:
    """Yield changes that may mend a failed check, by the laws of what fails."""
    design = reducer.design
    keys = {item.key for item in rating.items.values() if item.decisive and _kind(item) == failed.name}
    with suppress(DesignError):  # no torque is borne at all
        torque, _ = rated_torque(
            reducer, design.drive.speed, rating.life, keys.__contains__, poses=FEW, exact=NEAR, stops=True
        )
        yield "drive.torque_nm", _safely(torque, BELOW) / design.reduction
        if failed.name in ("life", "strength") and (share := design.rated_torque / torque) < WIDEST:
            yield "gear.face_width_mm", _safely(MILLIMETRES * design.gear.face_width * share, ABOVE)
    if failed.name == "life" and failed.value and failed.value > SHORTEST:
        yield "service.life_h", _safely(failed.value, BELOW)
    if failed.name == "heat" and failed.value:
        yield "drive.speed_rpm", _safely(design.drive.speed / RPM * failed.value, BELOW)


def _mends(reducer: Reducer, change: tuple[str, float], name: str) -> bool:
    """Tell whether a check of `KINDS` holds after a change."""
    try:
        mended = checks_of_rating(rate(override(reducer.design, dict([change]))))
    except CycloidError:
        return False
    return all(one.passed for one in mended if one.name == name)


def _safely(value: float, side: int) -> float:
    """Round to three digits, on the safe side of a value that is right within ``NEAR``."""
    return float(f"{(1.0 + 2.0 * side * NEAR) * value:.3g}")


def checks_of_rating(rating: Rating) -> tuple[Check, ...]:
    """Sum a rating up as checks: of each kind the weakest item."""
    items = [item for item in rating.items.values() if item.decisive]
    return tuple(_checks(rating, items))


def _checks(rating: Rating, items: Sequence[RatedItem]) -> Iterator[Check]:
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
            got=f"{weakest.verdict} by {weakest.name}",
            limit=f"at least {rating.life:g} h" if by_life else "at least 1",
            why=f"{why}; at {rating.duty}: {weakest.load} of {weakest.borne}",
            remedy="" if margin >= 1.0 else REMEDY,
            severity="warning",
            key=about,
            value=weakest.life if by_life else weakest.safety,
            bound=rating.life if by_life else 1.0,
            unit="h" if by_life else "1",
        )


def _kind(item: RatedItem) -> str:
    if is_held_once(item.key):
        return "momentary_torque"
    if item.key == "temperature" or item.key.endswith("_hot_clearance"):
        return "heat"
    return "life" if item.safety is None else "strength"
