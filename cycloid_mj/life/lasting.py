"""Whether a drive lasts at its rated torque: the checks of life, fatigue, heat and what is held once."""

from collections.abc import Iterator, Sequence

from cycloid_mj.base.errors import CycloidError
from cycloid_mj.checks.limit import Check
from cycloid_mj.life.item import RatedItem, Rating
from cycloid_mj.life.items import rate
from cycloid_mj.life.rated import STOPS
from cycloid_mj.reducer import Reducer

UNDECIDED = ("_wear", "_way", "_pv", "power_lost")
"""Items that decide nothing: figures, and wear, whose coefficient is known to a decade."""

REMEDY = (
    "lower drive.torque_nm to what `cycloid-mj datasheet` rates it for, or see `cycloid-mj rate` for what to change"
)

KINDS = {
    "momentary_torque": ("what is held once", "twice the rated torque is to be held once, as in an emergency stop"),
    "heat": ("heat", "grease, seals, materials and clearances end where the housing gets hotter"),
    "life": ("life", "the first part that wears out ends the drive (service.life_h)"),
    "strength": ("strength", "surfaces yield, or a part breaks by fatigue"),
}
"""Name of a check -> what it is about, and why."""


def decides(item: RatedItem) -> bool:
    """Tell whether an item of a rating decides what a drive bears."""
    return not item.key.endswith(UNDECIDED)


def lasting_checks(reducer: Reducer) -> tuple[Check, ...]:
    """Check whether a sound design bears its rated torque and speed for the life that it asks for; all are warnings.

    None where its crank stands still, or statics find no balance, which another check tells.
    """
    try:
        rating = rate(reducer.design)
    except CycloidError:
        return ()
    return checks_of(rating)


def checks_of(rating: Rating) -> tuple[Check, ...]:
    """Sum a rating up as checks: of each kind the weakest item."""
    items = [item for item in rating.items.values() if decides(item)]
    return tuple(_checks(rating, items))


def _checks(rating: Rating, items: Sequence[RatedItem]) -> Iterator[Check]:
    for kind, (about, why) in KINDS.items():
        found = [item for item in items if _kind(item) == kind]
        if not found:
            continue
        weakest = min(found, key=lambda item: item.margin(rating.life))
        margin = weakest.margin(rating.life)
        by_life = weakest.safety is None
        yield Check(
            name=kind,
            passed=margin >= 1.0,
            got=f"{weakest.verdict} by {weakest.name}",
            limit=f"at least {rating.life:g} h" if by_life else "a safety of at least 1",
            why=f"{why}; at {rating.duty}: {weakest.load} of {weakest.borne}",
            remedy="" if margin >= 1.0 else REMEDY,
            severity="warning",
            key=about,
            value=weakest.life if by_life else weakest.safety,
            bound=rating.life if by_life else 1.0,
            unit="h" if by_life else "1",
        )


def _kind(item: RatedItem) -> str:
    if item.key.startswith(STOPS) or item.key.endswith("_static"):
        return "momentary_torque"
    if item.key == "temperature" or item.key.endswith("_hot_clearance"):
        return "heat"
    return "life" if item.safety is None else "strength"
