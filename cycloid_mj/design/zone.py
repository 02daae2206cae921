"""Tolerance zones in the words of the design file, and their quantiles.

``normal 2``, ``uniform 5`` and ``between -1 4`` are micrometres about the design's value; ``IT6`` is a grade's zone at
a part's size, ``H7/g6`` the fit of two (ISO 286-1): both are normal, with a sixth of the zone as standard deviation.
"""

import re
from dataclasses import dataclass
from typing import Literal

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError
from cycloid_mj.design.fits import clearances, grade_width

ZONE_SIGMAS = 6.0
"""Standard deviations in a zone of a capable process (ISO 22514): 3 parts in 1000 lie outside."""

LARGEST_ZONE_UM = 1e6
"""Largest deviation that a tolerance may state [um]: a metre, beyond which a number is a slip and overflows follow."""

FORMS = '"normal 2", "uniform 5", "between -1 4" (in um), "IT6", or for a clearance "H7/g6"'


@dataclass(frozen=True)
class Zone:
    """A distribution about `middle` [m]; `width` is its standard deviation, or its half width if it is uniform."""

    kind: Literal["normal", "uniform"]
    middle: float
    width: float

    def quantiles(self, probability: Array) -> Array:
        """Compute the deviations [m] below which a part lies with a probability (0 to 1), in its shape."""
        if self.kind == "uniform":
            return self.middle + self.width * (2.0 * probability - 1.0)
        from scipy.special import ndtri  # not loaded where nothing is drawn

        return np.asarray(self.middle + self.width * ndtri(probability))

    @property
    def standard_deviation(self) -> float:
        """Standard deviation [m]."""
        return self.width if self.kind == "normal" else self.width / 3.0**0.5

    @property
    def limits(self) -> tuple[float, float]:
        """Lower and upper limit [m]: those of a uniform distribution, or three standard deviations from the middle."""
        half_width = 0.5 * ZONE_SIGMAS * self.width if self.kind == "normal" else self.width
        return self.middle - half_width, self.middle + half_width


def parse_zone(
    text: str, key: str, size: float, clearance: float | None = None, table: str = "tolerance"
) -> Zone | None:
    """Parse a tolerance of the design file into its probability distribution; return None for an empty text or 0.

    Parameters
    ----------
    text, key
        Text of the design file, such as ``normal 2``, ``uniform 5`` or ``IT6`` (`FORMS`), and its key.
    size
        Diameter to which ISO tolerance grades and fits refer [m].
    clearance
        Nominal clearance [m], to which the deviations of a fit refer; None if a fit is not allowed.
    table
        Table of the design file that has the key.

    Raises
    ------
    DesignError
        The text does not have one of the `FORMS`, or its numbers are not finite.
    """
    parts = text.split()
    try:
        match [word.lower() for word in parts]:
            case [] | ["0"]:
                return None
            case ["normal", sigma] if _finite(sigma) >= 0.0:
                return Zone("normal", 0.0, 1e-6 * _finite(sigma))
            case ["uniform", half_width] if _finite(half_width) >= 0.0:
                return Zone("uniform", 0.0, 1e-6 * _finite(half_width))
            case ["between", low, high] if _finite(low) <= _finite(high):
                return Zone("uniform", 0.5e-6 * (_finite(low) + _finite(high)), 0.5e-6 * (_finite(high) - _finite(low)))
        if match := re.fullmatch(r"IT(\d+)", text.strip()):
            return Zone("normal", 0.0, 0.5 * grade_width(int(match[1]), size) / ZONE_SIGMAS)
        if clearance is not None and "/" in text:
            return _fit(text, size, clearance)
    except ValueError as error:
        raise DesignError(f"{table}.{key} = {text!r}: {error}; write {FORMS}") from error
    raise DesignError(f"{table}.{key} = {text!r} is not a valid tolerance: write {FORMS}")


def _finite(text: str) -> float:
    """Convert a number [um] of at most `LARGEST_ZONE_UM` in size; raise ValueError for any other text."""
    value = float(text)
    if not abs(value) <= LARGEST_ZONE_UM:
        raise ValueError(f"{text} is out of range, which is -{LARGEST_ZONE_UM:g} to {LARGEST_ZONE_UM:g} um")
    return value


def wave_zones(text: str, highest_order: int, size: float) -> dict[int, Zone]:
    """Parse the tolerances of profile waves [um], such as ``2: normal 1, 35: uniform 2``, to distributions by order.

    A `Zone` is the distribution of the amplitude. `highest_order` is the highest order that is allowed, `size` the
    diameter for ISO tolerance grades [m]. Orders with an empty or zero tolerance are left out.

    Raises
    ------
    DesignError
        An order is not valid or repeated, or its tolerance does not have one of the `FORMS`.
    """
    zones: dict[int, Zone] = {}
    for part in filter(str.strip, text.split(",")):
        order_text, colon, zone_text = part.partition(":")
        order_number = int(order_text) if order_text.strip().isdecimal() else 0
        if not colon or not 1 <= order_number <= highest_order or order_number in zones:
            raise DesignError(
                f"tolerance.profile = {text!r}: {part.strip()!r} is not valid. Write ORDER: TOLERANCE in um for each "
                f"harmonic of the profile, with orders from 1 to {highest_order}, each once, as in "
                f'"2: normal 1, {highest_order - 1}: uniform 2"'
            )
        if zone := parse_zone(zone_text, "profile", size):
            zones[order_number] = zone
    return zones


def _fit(text: str, size: float, clearance: float) -> Zone:
    """Return the deviation of the radial clearance of a fit such as ``H7/g6`` from the nominal `clearance` [m].

    `size` is the nominal diameter [m]. The limits of the fit are 3 standard deviations from its middle.
    """
    tightest, loosest = (0.5 * limit for limit in clearances(text, size))
    return Zone("normal", 0.5 * (tightest + loosest) - clearance, (loosest - tightest) / ZONE_SIGMAS)
