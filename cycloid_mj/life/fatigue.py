"""Fatigue strength: factors of notch, surface, size and reliability, and Goodman's line.

Factors as in Budynas and Nisbett, Shigley's Mechanical Engineering Design (10th ed., 6-7 to 6-12).
"""

import math
from dataclasses import dataclass
from statistics import NormalDist
from typing import Literal


@dataclass(frozen=True)
class EnduranceFactors:
    """Factors of the endurance limit of steel (Shigley, 6-7 to 6-9).

    Attributes
    ----------
    share, maximum
        Endurance limit of a polished bar in rotating bending over the tensile strength, and its maximum [Pa].
    non_rotating_share
        Equivalent diameter of a round bar that does not rotate over its diameter (Eq. 6-24).
    scatter
        Standard deviation of endurance limits over their mean.
    """

    share: float = 0.5
    maximum: float = 700e6
    non_rotating_share: float = 0.37
    scatter: float = 0.08


ENDURANCE = EnduranceFactors()

SURFACES = {"ground": (1.58, -0.085), "machined": (4.51, -0.265), "forged": (272.0, -0.995)}
"""a and b of the surface factor a S^b, S the tensile strength in MPa."""

Stress = Literal["bending", "torsion"]

NEUBER: dict[Stress, tuple[float, ...]] = {
    "bending": (0.246, -3.08e-3, 1.51e-5, -2.67e-8),
    "torsion": (0.190, -2.51e-3, 1.35e-5, -2.67e-8),
}
"""Factors of sqrt(a) in powers of the tensile strength (Shigley, Eqs 6-35a and 6-35b)."""


@dataclass(frozen=True)
class Fatigue:
    """A stress cycle and the strength: `amplitude`, `mean`, `endurance` limit and `tensile` strength [Pa]."""

    amplitude: float
    mean: float
    endurance: float
    tensile: float

    @property
    def safety(self) -> float:
        """Factor on the load at Goodman's line, 1/(amplitude/endurance + mean/tensile); inf without a load."""
        utilization = self.amplitude / self.endurance + max(self.mean, 0.0) / self.tensile
        return 1.0 / utilization if utilization else math.inf


def endurance_limit(
    tensile: float, diameter: float, surface: str = "machined", reliability: float = 0.9, rotates: bool = False
) -> float:
    """Compute the endurance limit [Pa] of a steel part in bending (Shigley, 6-7 to 6-9).

    Parameters
    ----------
    tensile
        Tensile strength [Pa].
    diameter
        Diameter of the section [m].
    surface
        Finish, one of `SURFACES`.
    reliability
        Share of parts that do not fail.
    rotates
        Whether the bar rotates under its load; else a smaller part of it has the largest stress.
    """
    factor, power = SURFACES[surface]
    finish_factor = min(factor * (1e-6 * tensile) ** power, 1.0)
    size_reduction = size_factor(diameter if rotates else ENDURANCE.non_rotating_share * diameter)
    scatter_factor = 1.0 - ENDURANCE.scatter * NormalDist().inv_cdf(reliability)
    return min(ENDURANCE.share * tensile, ENDURANCE.maximum) * finish_factor * size_reduction * scatter_factor


def size_factor(diameter: float) -> float:
    """Compute the size factor of a round bar in bending: 1.24 d^-0.107 in mm, from 51 mm 1.51 d^-0.157, at most 1.

    It is (d/7.62)^-0.107 of a specimen of 7.62 mm (Shigley, Eq. 6-20): a thinner bar counts as that specimen.
    """
    millimetres = max(1e3 * diameter, 1.0)
    return float(min(1.24 * millimetres**-0.107 if millimetres <= 51.0 else 1.51 * millimetres**-0.157, 1.0))


def notch_factor(shape_factor: float, fillet: float, tensile: float, stress: Stress = "bending") -> float:
    """Compute the fatigue notch factor K_f = 1 + q (K_t - 1) [1] (Shigley, 6-10).

    `shape_factor` is K_t, `fillet` the notch radius r [m], `tensile` the tensile strength [Pa]. Neuber's sensitivity is
    q = 1/(1 + sqrt(a/r)), with sqrt(a) in sqrt(inch) a polynomial of the strength in ksi, at most 250 (`NEUBER`).
    """
    strength_ksi = min(tensile / 6.894757e6, 250.0)
    sqrt_a = sum(factor * strength_ksi**power for power, factor in enumerate(NEUBER[stress]))
    return 1.0 + (shape_factor - 1.0) / (1.0 + sqrt_a / math.sqrt(fillet / 0.0254))
