"""Lives in hours as text and for programs: beyond what their laws were fitted to they are unlimited."""

import math

MAX_LIFE = 1e8
"""Life [h] above which it counts as unlimited: more than ten thousand years."""

MIN_POWER_OF_TEN = 1e9
"""Size from which a number is written with a power of ten."""


def format_life(life: float) -> str:
    """Format a life [h]: "unlimited" beyond `MAX_LIFE`."""
    return "unlimited" if life > MAX_LIFE else f"{format_number(life)} h"


def finite_life(life: float | None) -> float | None:
    """Return a life [h] for a program: None if there is none, or it is beyond `MAX_LIFE`."""
    return None if life is None or life > MAX_LIFE else life


def format_number(value: float) -> str:
    """Format a number with four digits, up to `MIN_POWER_OF_TEN` without a power of ten."""
    if not math.isfinite(value) or abs(value) < 1e4 or abs(value) >= MIN_POWER_OF_TEN:
        return f"{value:.4g}"
    return f"{float(f'{value:.4g}'):.0f}"
