"""Rated torque for a required life, as manufacturers state it."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from operator import itemgetter

from cycloid_mj.base.errors import CycloidError, DesignError
from cycloid_mj.base.units import RPM
from cycloid_mj.life.as_built import Parts
from cycloid_mj.life.duty import PEAK_FACTOR, constant_duty
from cycloid_mj.life.item import RatedItem
from cycloid_mj.life.items import rate, rate_at_rated_load
from cycloid_mj.life.loading import POSES
from cycloid_mj.life.plastic_set import SET_POWER
from cycloid_mj.life.rolling import EXPONENT
from cycloid_mj.life.surfaces import AGMA_2001
from cycloid_mj.reducer import Reducer, RvReducer


@dataclass(frozen=True)
class TorqueSearch:
    """Secant search of the rated torque in a bracket.

    Attributes
    ----------
    lowest, highest
        Range of the search over the nominal torque.
    bracket_factor
        Factor between torques while only one end of the bracket is known.
    rtol
        Relative accuracy of the rated torque.
    """

    lowest: float = 1e-3
    highest: float = 1e2
    bracket_factor: float = 2.0
    rtol: float = 5e-4


SEARCH = TorqueSearch()

BEARINGS = "cam_bearing", "shaft_bearing", "output_bearing", "output_rollers", "crank_needles", "crank_tapers"
"""Beginnings of the keys of bearings."""

STOPS, STATIC, WEAR = ("peak_", "joint_"), "_static", "_wear"
"""Beginnings of the keys of emergency stops and joints, and endings of those of static factors and wear."""


def rated_torque(
    reducer: Reducer,
    speed: float,
    life: float,
    limits_torque: Callable[[str], bool] | None = None,
    start_torque: float = 0.0,
    crank_angles: int = POSES,
    rtol: float = SEARCH.rtol,
    with_stops: bool = False,
    parts: Parts = "perfect",
) -> tuple[float, RatedItem]:
    """Compute the rated output torque [N m] for a life at a speed of the crank, and the item that limits it.

    An item is a part with a kind of failure. Each step rates the reducer, and extrapolates the torque at which its
    weakest item reaches its limit (`weakest_torque`). Where this leaves the bracket, the logarithm of the torque is
    bisected.

    Parameters
    ----------
    reducer, speed, life
        The reducer of a valid design, speed of the crank [rad/s], and life [h].
    limits_torque
        Function from the key of an item to whether it limits the torque; by default all items do, except for wear and
        those that limit the momentary torque (`is_stop`).
    start_torque
        Torque at which the search starts [N m]; by default the nominal torque.
    crank_angles, rtol
        Number of crank angles of the rating, and relative accuracy of the torque.
    with_stops
        Whether emergency stops are rated, for a `limits_torque` that includes them.
    parts
        "perfect" to rate the parts as designed, "toleranced" to rate samples within the tolerances of the design.

    Raises
    ------
    DesignError
        No torque between `TorqueSearch.lowest` and `highest` times the nominal torque is rated for that life.
    """
    design = reducer.design
    torque, lower_torque, upper_torque = start_torque or design.rated_torque, 0.0, math.inf
    is_limit = limits_torque or (lambda key: not is_stop(reducer, key) and not key.endswith(WEAR))
    weakest_item: RatedItem | None = None
    while upper_torque > SEARCH.lowest * design.rated_torque:
        limit, item = _extrapolate_torque_limit(reducer, torque, speed, life, is_limit, crank_angles, with_stops, parts)
        if abs(limit / torque - 1.0) <= rtol and item:
            return limit, item
        if limit >= torque and item:
            lower_torque, weakest_item = torque, item
        else:
            upper_torque = torque
        if weakest_item and (
            upper_torque < lower_torque * (1.0 + rtol) or lower_torque > SEARCH.highest * design.rated_torque
        ):
            return lower_torque, weakest_item
        torque = limit if lower_torque < limit < upper_torque else _next_in_bracket(lower_torque, upper_torque)
    raise DesignError(
        f"{design.name}: there is no rated torque for {life:g} h at {speed / RPM:.4g} rpm, because even {torque:.3g} N "
        "m is too much. `cycloid-mj rate` shows what fails; strengthen that part, or require a shorter life"
    )


def _extrapolate_torque_limit(
    reducer: Reducer,
    torque: float,
    speed: float,
    life: float,
    limits_torque: Callable[[str], bool],
    crank_angles: int,
    with_stops: bool,
    parts: Parts,
) -> tuple[float, RatedItem | None]:
    """Rate the reducer at a torque [N m], and extrapolate the torque at which its weakest item reaches its limit.

    An item is a part with a kind of failure; see `weakest_torque`. `speed` is the crank speed [rad/s], `life` the
    required life [h], and `crank_angles` the number of crank angles of the rating. Only items for whose key
    `limits_torque` returns True are considered. `with_stops` includes emergency stops. `parts` is "perfect" for the
    parts as designed, or "toleranced" for samples within the tolerances.

    Returns
    -------
    tuple
        The limit [N m] and the item that sets it; (0, None) if the rating fails, for example because there is no static
        equilibrium at this torque.
    """
    try:
        items = rate(
            reducer, constant_duty(torque, speed), life, poses=crank_angles, stops=with_stops, parts=parts
        ).items.values()
    except CycloidError:
        return 0.0, None
    return weakest_torque((item for item in items if limits_torque(item.key)), torque, life)


def _next_in_bracket(lower_torque: float, upper_torque: float) -> float:
    """Return the next torque [N m] within a bracket, whose lower end may be 0 and upper end infinite."""
    if not lower_torque:
        return upper_torque / SEARCH.bracket_factor
    return (
        math.sqrt(lower_torque * upper_torque) if math.isfinite(upper_torque) else SEARCH.bracket_factor * lower_torque
    )


def weakest_torque(items: Iterable[RatedItem], torque: float, life: float) -> tuple[float, RatedItem]:
    """Extrapolate the output torque [N m] at which the first of several rated items reaches its limit; return both.

    An item is a part with a kind of failure; `items` were rated at the output `torque` [N m] for the required `life`
    [h]. Loads are assumed to be in proportion to the torque (docs/rating.md). Far from the torque at which the items
    were rated, the result is an estimate.
    """
    limits = ((_extrapolate_item_limit(item, torque, life), item) for item in items)
    return min(limits, key=lambda pair: pair[0])


def momentary_torque(reducer: Reducer) -> tuple[float, RatedItem]:
    """Compute the largest output torque of an emergency stop, at which the smallest safety factor is 1.

    It is extrapolated from the rating at the nominal torque, with safety factors in proportion to 1/torque.

    Returns
    -------
    tuple
        The torque [N m], and the item that limits it.
    """
    design = reducer.design
    duty = constant_duty(design.rated_torque, design.drive.speed)
    stop_items = (item for item in rate_at_rated_load(reducer).items.values() if is_stop(reducer, item.key))
    weakest_item = min(stop_items, key=lambda item: item.safety or 0.0)
    return duty.peak * (weakest_item.safety or 0.0), weakest_item


def rated_and_momentary_torque(
    rated_items: Iterable[RatedItem], torque: float, life: float, reducer: Reducer | None = None
) -> tuple[tuple[float, RatedItem], tuple[float, RatedItem]]:
    """Estimate rated and momentary output torque [N m] from a rating at a single torque, by `weakest_torque`.

    `rated_items` are the items (a part with a kind of failure each) of the rating at `torque` [N m] for a `life` [h].
    The peak torque of that rating must be `PEAK_FACTOR` times `torque`. The rated torque is at most the momentary
    torque. `reducer` is required only for an RV reducer (`is_stop`), whose safety factors at the peak torque are
    inversely proportional to the torque.

    Returns
    -------
    tuple
        For the rated, then the momentary torque: its value [N m], and the item that limits it.
    """
    items = tuple(rated_items)
    is_stop_item = is_momentary if reducer is None else partial(is_stop, reducer)
    stop_items = [item for item in items if is_stop_item(item.key)]
    other_items = [item for item in items if item.decisive and not is_stop_item(item.key)]
    momentary_limit = min(((PEAK_FACTOR * torque * item.margin(life), item) for item in stop_items), key=itemgetter(0))
    return min(weakest_torque(other_items, torque, life), momentary_limit, key=lambda pair: pair[0]), momentary_limit


def torque_limits(items: Iterable[RatedItem], torque: float, life: float) -> dict[str, float]:
    """Compute the torque [N m] at which each item fails by its law, by key; see `weakest_torque`."""
    return {item.key: _extrapolate_item_limit(item, torque, life) for item in items}


def _extrapolate_item_limit(item: RatedItem, torque: float, life: float) -> float:
    """Extrapolate the output torque [N m] at which a rated item just reaches its limit, or the required `life` [h].

    `item` is a part with a kind of failure that was rated at `torque` [N m]. Its load is assumed to be a power of the
    torque, such as the square root for pressures.
    """
    margin = item.margin(life)
    if item.safety is None:
        # the strip that loads a plastic is as wide as the pressure is high: damage ~ p^(1 + 1/SET_POWER)
        power = 2.0 * (SET_POWER / (1.0 + SET_POWER) if item.key.endswith("_set") else AGMA_2001.power)
        return torque * float(margin ** (1.0 / EXPONENT if is_bearing_life(item.key) else power))
    is_pressure_limit = item.key.endswith(("_yield", "_shakedown")) and not item.key.startswith(STOPS)
    return torque * (margin**2 if is_pressure_limit else margin)


def is_momentary(key: str) -> bool:
    """Return whether an item, by its key, limits the momentary torque: emergency stops, joints and static factors."""
    return key.startswith(STOPS) or key.endswith(STATIC)


def is_stop(reducer: Reducer, key: str) -> bool:
    """Return whether an item of a rating limits the momentary torque: `is_momentary`, or first yield of an RV reducer.

    An RV reducer has no items of emergency stops; its first yield is rated at the peak torque.
    """
    return is_momentary(key) or (isinstance(reducer, RvReducer) and key.endswith("_yield"))


def is_strength(key: str) -> bool:
    """Return whether an item, by its key, limits a torque that is repeated at every start and stop."""
    return key.endswith(("_yield", "_shakedown", "_fatigue")) and not is_momentary(key)


def is_bearing_life(key: str) -> bool:
    """Return whether an item, by its key, is the life of a bearing."""
    return key.startswith(BEARINGS) and not key.endswith(STATIC)
