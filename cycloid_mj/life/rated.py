"""Rated torque for a given life, as makers state it."""

import math
from collections.abc import Callable

from scipy.optimize import brentq

from cycloid_mj.base.errors import CycloidError, DesignError
from cycloid_mj.base.units import RPM
from cycloid_mj.life.duty import steady
from cycloid_mj.life.item import RatedItem
from cycloid_mj.life.items import rate
from cycloid_mj.reducer import Reducer

LOWEST, HIGHEST = 1e-3, 1e2
"""Torques between which the rated one is looked for, over that of the drive."""

STRIDE = math.log(2.0)
"""Step of that search, of the torque's logarithm, until the rated one lies within."""

EXACT = 1e-3
"""Relative accuracy of the rated torque."""

NO_BALANCE = -100.0
"""Logarithm of the margin of what is not held at all."""

STOPS, NOT_COUNTED = "peak_", ("_wear", "_static")
"""Items that do not decide the rated torque: stops, wear (its coefficient is known to a decade), figures."""


def rated_torque(
    reducer: Reducer, speed: float, life: float, counts: Callable[[str], bool] | None = None, guess: float = 0.0
) -> tuple[float, RatedItem]:
    """Compute the torque [N m] that everything bears for a life [h] at a crank's speed [rad/s], and what decides it.

    `counts` tells of an item's key whether it does: by default all but emergency stops and wear. The search begins at
    a `guess` [N m], by default the drive's torque, and ends a hundred times above and a thousand times below that.

    Raises
    ------
    DesignError
        No torque in that range is borne for so long.
    """
    design = reducer.design
    decides, rated = counts or _counts, design.rated_torque
    decisive: dict[float, RatedItem] = {}

    def margin(logarithm: float) -> float:
        """Compute the logarithm of the least margin; where the drive holds no such torque, far less than nothing."""
        try:
            items = rate(design, steady(math.exp(logarithm), speed), life).items
        except CycloidError:
            return NO_BALANCE
        decisive[logarithm] = next(item for item in items.values() if decides(item.key))
        return math.log(max(decisive[logarithm].margin(life), math.exp(NO_BALANCE)))

    at = math.log(guess or rated)
    bears = margin(at) > 0.0
    step = STRIDE if bears else -STRIDE
    lowest, highest = (math.log(share * rated) for share in (LOWEST, HIGHEST))
    while (margin(at + step) > 0.0) == bears:
        at += step
        if not lowest < at < highest:
            break
    else:
        root = float(brentq(margin, min(at, at + step), max(at, at + step), xtol=EXACT))
        return math.exp(root), decisive[min(decisive, key=lambda one: abs(one - root))]
    if not bears:
        raise DesignError(
            f"{design.name}: no torque down to {math.exp(at):.3g} N m is borne for {life:g} h at {speed / RPM:.4g} "
            "rpm; rate it to see what fails"
        )
    return math.exp(at), decisive[at]


def _counts(key: str) -> bool:
    return not key.startswith(STOPS) and not key.endswith(NOT_COUNTED)


def is_bearing_life(key: str) -> bool:
    """Tell whether an item, by its key, is the life of a bearing."""
    return key.startswith(("cam_bearing", "shaft_bearing", "output_rollers")) and not key.endswith("_static")
