"""Checks of life, fatigue, heat and emergency stops at the nominal torque, and all checks of a design together."""

from collections.abc import Collection, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass

from cycloid_mj.base.errors import CycloidError, DesignError
from cycloid_mj.base.units import MILLIMETRES, RPM
from cycloid_mj.checks import Check, Checks, check
from cycloid_mj.checks.advice import verify_remedies
from cycloid_mj.design import Named, override, resolve
from cycloid_mj.life.as_built import default_parts
from cycloid_mj.life.item import RatedItem, Rating
from cycloid_mj.life.items import rate, rate_for_verdict
from cycloid_mj.life.rated import is_momentary, rated_torque
from cycloid_mj.reducer import Reducer, reducer_of

REMEDY = "lower drive.torque_nm to the rated torque of `cycloid-mj datasheet`, or see `cycloid-mj rate` for each item"
HEAT_REMEDY = (
    "lower drive.torque_nm or service.duty_share, or cool the housing better (service.film_coefficient_w_m2_k); see "
    "`cycloid-mj thermal`"
)

BELOW, ABOVE = -1, 1  # directions of rounding

THERMAL_TORQUE = "thermal_torque"
"""Key of the item with the largest torque that steady temperatures allow."""


@dataclass(frozen=True)
class RemedySettings:
    """Search of single changes that make a failed check pass.

    Attributes
    ----------
    crank_angles, rtol
        Number of crank angles, and relative accuracy, of a torque.
    max_widening, min_life
        Largest factor on the face width, and shortest required life [h].
    """

    crank_angles: int = 61
    rtol: float = 5e-3
    max_widening: float = 2.0
    min_life: float = 1.0


REMEDIES = RemedySettings()

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
    """Check whether a design can be built, works well, and withstands its rated load for its life.

    The checks of function and life are warnings, and are run only if the design can be built. In Python this function
    is also ``cm.check(design)``.

    Parameters
    ----------
    design
        A design, or the name of a preset or a file.

    Returns
    -------
    Checks
        Each check with value, bound and advice; `failures` and `warnings` list those that are not passed.
    """
    return check_reducer(reducer_of(resolve(design)))


def check_reducer(reducer: Reducer) -> Checks:
    """Run all checks of a reducer, as `check_design`."""
    checks = verify_remedies(reducer, check(reducer.design))
    return checks if checks.failures else Checks((*checks, *life_checks(reducer)))


def life_checks(reducer: Reducer) -> tuple[Check, ...]:
    """Return the checks whether a valid design withstands its nominal torque and speed for its required life.

    There is a `Check` for each kind of failure in `KINDS`; it compares the safety factor or life of the weakest part
    with its limit. All checks are warnings. If the design has tolerances, parts with errors within them are rated.
    The result is empty if the crank does not turn or no static equilibrium exists (check ``rated_load``).
    """
    try:
        return checks_of_rating(rate_for_verdict(reducer))
    except CycloidError:
        return ()


def life_remedies(reducer: Reducer, names: Collection[str] = KINDS) -> dict[str, tuple[tuple[str, float], ...]]:
    """Return single changes of the design file that make failed checks of `life_checks` pass, by name of the check.

    Each change is a pair, such as ("service.life_h", 4500.0): key of the design file, and new value in its unit.
    Candidates are less torque and, depending on the check, a larger face width, a shorter life, a slower crank or,
    where the rating has the torque limit of steady temperatures, a smaller share of the time under load. Each change
    has been rated again and passes. Only checks in `names` are included.
    """
    try:
        rating = rate_for_verdict(reducer)
    except CycloidError:
        return {}
    return {
        check.name: tuple(
            change for change in _candidate_changes(reducer, rating, check) if _passes_with(reducer, change, check.name)
        )
        for check in checks_of_rating(rating)
        if not check.passed and check.name in names
    }


def _candidate_changes(reducer: Reducer, rating: Rating, failed_check: Check) -> Iterator[tuple[str, float]]:
    """Yield changes of the design file that may make a failed check pass.

    `rating` has the load capacity of all parts. The new torque is the result of a search; face width, life and speed
    are changed by the ratio of value and limit.

    Yields
    ------
    tuple
        Key of the design file, and its new value.
    """
    design = reducer.design
    keys = {item.key for item in rating.items.values() if item.decisive and _check_kind(item) == failed_check.name}
    with suppress(DesignError):  # no torque is enough
        torque = _largest_torque(reducer, rating, keys)
        yield "drive.torque_nm", _round_safely(torque, BELOW) / design.reduction
        if (
            failed_check.name in ("life", "strength")
            and (torque_ratio := design.rated_torque / torque) < REMEDIES.max_widening
        ):
            yield "gear.face_width_mm", _round_safely(MILLIMETRES * design.gear.face_width * torque_ratio, ABOVE)
    if failed_check.name == "life" and failed_check.value and failed_check.value > REMEDIES.min_life:
        yield "service.life_h", _round_safely(failed_check.value, BELOW)
    if failed_check.name == "heat" and failed_check.value:
        yield "drive.speed_rpm", _round_safely(design.drive.speed / RPM * failed_check.value, BELOW)
        if THERMAL_TORQUE in rating.items:
            yield "service.duty_share", _round_safely(design.service.duty_share * failed_check.value, BELOW)


def _largest_torque(reducer: Reducer, rating: Rating, keys: Collection[str]) -> float:
    """Compute the largest output torque [N m] at which none of some rated items exceeds its limit.

    `keys` are the keys of these items in `rating`, such as "output bearing".

    Raises
    ------
    DesignError
        No torque is small enough.
    """
    if THERMAL_TORQUE in rating.items and all(_is_heat(key) for key in keys):
        return rating.items[THERMAL_TORQUE].limit
    torque, _ = rated_torque(
        reducer,
        reducer.design.drive.speed,
        rating.life,
        keys.__contains__,
        crank_angles=REMEDIES.crank_angles,
        rtol=REMEDIES.rtol,
        with_stops=True,
        parts=default_parts(reducer.design),
    )
    return torque


def _passes_with(reducer: Reducer, change: tuple[str, float], check_name: str) -> bool:
    """Return whether the check named `check_name` passes after a `change`: key of the design file, and new value."""
    try:
        changed_reducer = reducer_of(override(reducer.design, dict([change])))
        # steady temperatures, which take most of the time, decide on heat only
        rating = (
            rate_for_verdict(changed_reducer)
            if check_name == "heat"
            else rate(changed_reducer, parts=default_parts(changed_reducer.design))
        )
    except CycloidError:
        return False
    return all(check.passed for check in checks_of_rating(rating) if check.name == check_name)


def _round_safely(value: float, direction: int) -> float:
    """Round a value of accuracy `RemedySettings.rtol` to three digits, safely `BELOW` or `ABOVE` it."""
    return float(f"{(1.0 + 2.0 * direction * REMEDIES.rtol) * value:.3g}")


def checks_of_rating(rating: Rating) -> tuple[Check, ...]:
    """Summarize a rating as checks: for each of `KINDS` that occurs, its weakest item against the limit."""
    items = [item for item in rating.items.values() if item.decisive]
    return tuple(_checks_by_kind(rating, items))


def _checks_by_kind(rating: Rating, decisive_items: Sequence[RatedItem]) -> Iterator[Check]:
    """Yield a check for each kind of failure in `KINDS`: the weakest rated item of the kind against its limit.

    The limit is a safety factor of 1, or the required life [h]. Kinds without rated items have no check.
    `decisive_items` are the items to check: those of the `rating` that limit the rated torque (`RatedItem.decisive`).
    """
    for kind, (quantity_text, explanation) in KINDS.items():
        items_of_kind = [item for item in decisive_items if _check_kind(item) == kind]
        if not items_of_kind:
            continue
        weakest_item = min(items_of_kind, key=lambda item: item.margin(rating.life))
        margin = weakest_item.margin(rating.life)
        is_life = weakest_item.safety is None
        limit_text = f" against a limit of {weakest_item.limit_text}" if weakest_item.limit_text else ""
        yield Check(
            name=kind,
            passed=margin >= 1.0,
            got=f"{weakest_item.verdict} ({weakest_item.name})",
            limit=f"at least {rating.life:g} h" if is_life else "at least 1",
            why=f"{explanation}; {weakest_item.load_text}{limit_text}, for {rating.duty}"
            f"{', toleranced parts' if rating.parts == 'toleranced' else ''}",
            remedy="" if margin >= 1.0 else HEAT_REMEDY if kind == "heat" else REMEDY,
            severity="warning",
            key=quantity_text,
            value=weakest_item.life if is_life else weakest_item.safety,
            bound=rating.life if is_life else 1.0,
            unit="h" if is_life else "1",
        )


def _check_kind(item: RatedItem) -> str:
    """Return the key in `KINDS` of the check to which an item belongs."""
    if is_momentary(item.key):
        return "momentary_torque"
    if _is_heat(item.key):
        return "heat"
    return "life" if item.safety is None else "strength"


def _is_heat(key: str) -> bool:
    """Return whether an item, by its key, fails by heat."""
    return key == "temperature" or key.endswith("_hot_clearance")
