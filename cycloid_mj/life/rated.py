"""Rated torque for a given life, as makers state it."""

import math
from collections.abc import Callable, Iterable

from cycloid_mj.base.errors import CycloidError, DesignError
from cycloid_mj.base.units import RPM
from cycloid_mj.life.duty import steady
from cycloid_mj.life.item import RatedItem
from cycloid_mj.life.items import rate
from cycloid_mj.life.loading import POSES
from cycloid_mj.life.rolling import EXPONENT
from cycloid_mj.life.surfaces import PITTING_LIFE, SET_POWER
from cycloid_mj.reducer import Reducer

LOWEST, HIGHEST = 1e-3, 1e2
"""Torques between which the rated one is looked for, over that of the drive."""

STRIDE = 2.0
"""Factor from torque to torque where the law of an item leads nowhere."""

EXACT = 5e-4
"""Relative accuracy of the rated torque."""

BEARINGS = "cam_bearing", "shaft_bearing", "output_bearing", "output_rollers"
STOPS, STANDING, WEAR = "peak_", "_static", "_wear"
"""How the keys of bearings and of what is held once begin or end, and that of wear (known to a decade)."""


def rated_torque(
    reducer: Reducer,
    speed: float,
    life: float,
    counts: Callable[[str], bool] | None = None,
    guess: float = 0.0,
    poses: int = POSES,
    exact: float = EXACT,
    stops: bool = False,
) -> tuple[float, RatedItem]:
    """Compute the torque [N m] that everything bears for a life [h] at a crank's speed [rad/s], and what decides it.

    `counts` tells of an item's key whether it does: by default all but emergency stops and wear. The search begins at
    a `guess` [N m], by default the drive's torque, goes on where the weakest item's law leads, and ends a hundred times
    above and a thousand times below that. Fewer `poses` are quicker and less exact, as of `rate`; `exact` is relative.
    With `stops` emergency stops are rated, which `counts` may ask for.

    Raises
    ------
    DesignError
        No torque in that range is borne for so long.
    """
    design = reducer.design
    at, low, high = guess or design.rated_torque, 0.0, math.inf
    decides = counts or _counts
    weakest: RatedItem | None = None
    while high > LOWEST * design.rated_torque:
        bears, item = _torque_borne(reducer, at, speed, life, decides, poses, stops)
        if abs(bears / at - 1.0) <= exact and item:
            return bears, item
        if bears >= at and item:
            low, weakest = at, item
        else:
            high = at
        if weakest and (high < low * (1.0 + exact) or low > HIGHEST * design.rated_torque):
            return low, weakest
        at = bears if low < bears < high else _between(low, high)
    raise DesignError(
        f"{design.name}: no torque down to {at:.3g} N m is borne for {life:g} h at {speed / RPM:.4g} "
        "rpm; rate it to see what fails"
    )


def _torque_borne(
    reducer: Reducer,
    torque: float,
    speed: float,
    life: float,
    decides: Callable[[str], bool],
    poses: int,
    stops: bool,
) -> tuple[float, RatedItem | None]:
    """Compute what is borne by the law of the item that is weakest at a torque [N m]; 0 where none is held at all."""
    try:
        items = rate(reducer.design, steady(torque, speed), life, poses=poses, stops=stops).items.values()
    except CycloidError:
        return 0.0, None
    return weakest_torque((item for item in items if decides(item.key)), torque, life)


def _between(low: float, high: float) -> float:
    """Return a torque between one that is borne and one that is not, or beyond the one that is known."""
    if not low:
        return high / STRIDE
    return math.sqrt(low * high) if math.isfinite(high) else STRIDE * low


def weakest_torque(items: Iterable[RatedItem], torque: float, life: float) -> tuple[float, RatedItem]:
    """Compute the torque [N m] at which the first of some items would fail by its law, as rated at one, and that item.

    The laws are those of loads in proportion to the torque (docs/rating.md): from far off it is an estimate.
    """
    return min(((_borne(item, torque, life), item) for item in items), key=lambda one: one[0])


def _borne(item: RatedItem, torque: float, life: float) -> float:
    margin = item.margin(life)
    if item.safety is None:
        power = 2.0 * (SET_POWER if item.key.endswith("_set") else PITTING_LIFE[1])
        return torque * float(margin ** (1.0 / EXPONENT if is_bearing_life(item.key) else power))
    by_pressure = item.key.endswith(("_yield", "_shakedown")) and not item.key.startswith(STOPS)
    return torque * (margin**2 if by_pressure else margin)


def _counts(key: str) -> bool:
    return not is_held_once(key) and not key.endswith(WEAR)


def is_held_once(key: str) -> bool:
    """Tell whether an item, by its key, is about an emergency stop: it does not decide the rated torque."""
    return key.startswith(STOPS) or key.endswith(STANDING)


def is_bearing_life(key: str) -> bool:
    """Tell whether an item, by its key, is the life of a bearing."""
    return key.startswith(("cam_bearing", "shaft_bearing", "output_bearing", "output_rollers")) and not key.endswith(
        "_static"
    )
