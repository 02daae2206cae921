"""Fatigue strength: what notch, surface, size and reliability leave of it, and Goodman's line.

Factors as in Budynas and Nisbett, Shigley's Mechanical Engineering Design (10th ed., 6-7 to 6-12).
"""

import math
from dataclasses import dataclass
from statistics import NormalDist

ENDURANCE_SHARE, ENDURANCE_MOST = 0.5, 700e6
"""Endurance limit of a polished bar in bending, over the tensile strength, and its most [Pa]."""

SURFACES = {"ground": (1.58, -0.085), "machined": (4.51, -0.265), "forged": (272.0, -0.995)}
"""a and b of the surface factor a S^b, S the tensile strength in MPa."""

STANDING = 0.37
"""A round bar that does not turn counts as one of this share of its diameter."""

SCATTER = 0.08
"""Standard deviation of endurance limits, over their mean."""


@dataclass(frozen=True)
class Fatigue:
    """A cycle of stress against what bears it: `amplitude`, `mean`, `endurance` limit and `tensile` strength [Pa]."""

    amplitude: float
    mean: float
    endurance: float
    tensile: float

    @property
    def safety(self) -> float:
        """Factor on the load at Goodman's line, 1/(amplitude/endurance + mean/tensile); inf without a load."""
        used = self.amplitude / self.endurance + max(self.mean, 0.0) / self.tensile
        return 1.0 / used if used else math.inf


def endurance_limit(
    tensile: float, diameter: float, surface: str = "machined", reliability: float = 0.9, turns: bool = False
) -> float:
    """Compute the endurance limit [Pa] of a steel part in bending.

    Parameters
    ----------
    tensile
        Tensile strength [Pa].
    diameter
        Of the section [m].
    surface
        One of `SURFACES`.
    reliability
        Share of parts that last.
    turns
        Whether the bar turns under its load; else a smaller part of it sees the largest stress.
    """
    factor, power = SURFACES[surface]
    finish = min(factor * (1e-6 * tensile) ** power, 1.0)
    size = size_factor(diameter if turns else STANDING * diameter)
    sure = 1.0 - SCATTER * NormalDist().inv_cdf(reliability)
    return min(ENDURANCE_SHARE * tensile, ENDURANCE_MOST) * finish * size * sure


def size_factor(diameter: float) -> float:
    """Compute the size factor of a round bar in bending: 1 up to 2.79 mm, 1.24 d^-0.107, from 51 mm 1.51 d^-0.157."""
    millimetres = 1e3 * diameter
    if millimetres <= 2.79:
        return 1.0
    return float(1.24 * millimetres**-0.107 if millimetres <= 51.0 else 1.51 * millimetres**-0.157)


def notch_factor(shape_factor: float, fillet: float, tensile: float) -> float:
    """Compute K_f = 1 + q (K_t - 1), with Neuber's sensitivity q = 1/(1 + sqrt(a/r)) at a fillet r [m].

    sqrt(a) in sqrt(inch) is 0.246 - 3.08e-3 S + 1.51e-5 S^2 - 2.67e-8 S^3, S the tensile strength in ksi (bending).
    """
    ksi = min(tensile / 6.894757e6, 250.0)
    root = 0.246 - 3.08e-3 * ksi + 1.51e-5 * ksi**2 - 2.67e-8 * ksi**3
    return 1.0 + (shape_factor - 1.0) / (1.0 + root / math.sqrt(fillet / 0.0254))
