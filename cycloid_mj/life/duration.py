"""Hours of life as they are written, and as programs get them: beyond what the laws were fitted to, unlimited."""

import math

LONGEST = 1e8
"""Hours from which a life is told as unlimited: more than ten thousand years."""

LARGE = 1e9
"""Size from which a number is written with a power of ten."""


def hours(life: float) -> str:
    """Write a life [h]: "unlimited" beyond `LONGEST`."""
    return "unlimited" if life > LONGEST else f"{written(life)} h"


def plain_life(life: float | None) -> float | None:
    """Compute a life [h] for a program: None where there is none, and beyond `LONGEST`."""
    return None if life is None or life > LONGEST else life


def written(value: float) -> str:
    """Write a number with four digits, up to `LARGE` without a power of ten."""
    if not math.isfinite(value) or abs(value) < 1e4 or abs(value) >= LARGE:
        return f"{value:.4g}"
    return f"{float(f'{value:.4g}'):.0f}"
