"""The contact law IMPACT of motion solvers (ADAMS, SolidWorks Motion): a spring F = k d^e, and damping by depth.

The force is k d^e + c step(d/D) v, never negative, with the depth d [m], the closing speed v [m/s], and the cubic
step(s) = s^2 (3 - 2 s) from 0 at the surface to the full damping c at the depth D.
"""

import math
from dataclasses import dataclass

MIN_DEPTH = 1e-12
"""Smallest depth [m] at which solvers evaluate the law: the slope of the spring is its force over the depth."""


@dataclass(frozen=True)
class ImpactLaw:
    """Parameters of the law.

    Attributes
    ----------
    stiffness, exponent
        k [N/m^e] and e [1] of the spring.
    damping, depth
        Full damping c [N s/m], and the depth D from which on it acts [m].
    """

    stiffness: float
    exponent: float
    damping: float
    depth: float

    def depth_under(self, force: float) -> float:
        """Return the depth [m] of the spring under a force [N]."""
        return float((force / self.stiffness) ** (1.0 / self.exponent))

    def secant(self, force: float) -> float:
        """Return the secant stiffness [N/m] of the spring at a force [N]."""
        return force / self.depth_under(force)

    def damping_ratio(self, force: float, mass: float) -> float:
        """Return the damping ratio [1] under a force [N], of a mass [kg] on the secant stiffness."""
        acting = damper(self.depth_under(force), self.damping, self.depth)
        return float(acting / (2.0 * math.sqrt(self.secant(force) * mass)))

    def in_series(self) -> "ImpactLaw":
        """Return the law of two such contacts in series, which share the depth and transmit the same force."""
        return ImpactLaw(self.stiffness / 2.0**self.exponent, self.exponent, self.damping / 2.0, 2.0 * self.depth)

    def of_lines(self, lines: int) -> "ImpactLaw":
        """Return the law of each of several lines into which a contact is divided."""
        return ImpactLaw(self.stiffness / lines, self.exponent, self.damping / lines, self.depth)


def spring(depth: float, stiffness: float, exponent: float) -> float:
    """Compute the force of the spring [N] at a depth [m]."""
    return stiffness * depth**exponent if depth > 0.0 else 0.0


def damper(depth: float, damping: float, full_depth: float) -> float:
    """Return the damping [N s/m] at a depth [m]; it is constant from `full_depth` on."""
    if depth <= 0.0:
        return 0.0
    share = min(depth / full_depth, 1.0)
    return damping * share * share * (3.0 - 2.0 * share)
