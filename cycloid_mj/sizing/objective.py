"""Objectives of the search, and the expected improvement of candidates that are only estimated."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr

from cycloid_mj.base.array import Array
from cycloid_mj.sizing.requirement import Requirement

DEVIATIONS = {"capacity": 0.15, "temperature": 0.3, "mass": 0.1, "length": 0.04, "backlash": 0.1}
"""Standard deviations of the logarithms of estimates from those of ratings, among drives of a requirement."""

MAXIMIZED = ("capacity", "temperature")
"""Figures whose largest value is the best; of all others it is the smallest."""


@dataclass(frozen=True)
class Objective:
    """A figure to maximize or to minimize within limits.

    Attributes
    ----------
    key
        The figure: ``capacity`` (the torque that a drive carries), ``temperature`` (the torque that its losses allow),
        ``mass`` or ``length``.
    limits
        Smallest capacity [N m], and largest mass [kg], length [m] and backlash [arcmin], by key.
    """

    key: str
    limits: Mapping[str, float]

    def merit(self, figures: Mapping[str, Array | float]) -> Array:
        """Return the logarithm of the quantity of each candidate, shape (n,), negative if it is minimized."""
        return np.asarray(_sign(self.key) * np.log(figures[self.key]))

    def excess(self, figures: Mapping[str, Array | float]) -> Array:
        """Return the logarithm of the largest ratio by which each candidate exceeds a limit, shape (n,); 0 if none."""
        return np.maximum(-_slack(self.limits, figures).min(axis=0), 0.0)

    def expected_improvement(self, figures: Mapping[str, Array | float], scale: Array, best: float) -> Array:
        """Compute by how much a full evaluation of each of n candidates is expected to improve the merit, shape (n,).

        The merit is the logarithm of the objective's quantity (`merit`). `figures` are the estimates of the candidates,
        by key, shape (n,) each. Their errors are normal with standard deviations of `DEVIATIONS` times `scale` (n,).
        The improvement over the merit `best` counts only within the limits (Schonlau, Welch and Jones, Global versus
        local search in constrained optimization of computer models, 1998). If `best` is -inf, it is the probability
        that all limits are met.
        """
        deviations = np.reshape([DEVIATIONS[key] for key in self.limits], (-1, 1)) * scale
        probability = ndtr(_slack(self.limits, figures) / deviations).prod(axis=0)
        if not np.isfinite(best):
            return np.asarray(probability)
        deviation = DEVIATIONS[self.key] * scale
        normalized = (self.merit(figures) - best) / deviation
        density = np.exp(-0.5 * normalized**2) / np.sqrt(2.0 * np.pi)
        return np.asarray(probability * deviation * (normalized * ndtr(normalized) + density))


def _sign(key: str) -> float:
    return 1.0 if key in MAXIMIZED else -1.0


def _slack(limits: Mapping[str, float], figures: Mapping[str, Array | float]) -> Array:
    """Return the logarithms by which quantities are better than their limits, shape (limits, n)."""
    return np.array([_sign(key) * np.log(figures[key] / limit) for key, limit in limits.items()])


def strongest(requirement: Requirement, torque: float = 1e-9) -> Objective:
    """Return the objective of the largest capacity within length and backlash, and of at least a `torque` [N m]."""
    limits = {"capacity": torque, "length": requirement.length, "backlash": requirement.backlash}
    return Objective("capacity", {key: limit for key, limit in limits.items() if limit < math.inf})


def shortest(requirement: Requirement) -> Objective:
    """Return the objective of the smallest length of candidates that meet a requirement, whatever length it allows."""
    return Objective("length", strongest(requirement.but(length=math.inf), requirement.torque).limits)


def lightest(requirement: Requirement) -> Objective:
    """Return the objective of the lowest mass of candidates that meet a requirement."""
    return Objective("mass", strongest(requirement, requirement.torque).limits)


def most_efficient(requirement: Requirement, mass: float) -> Objective:
    """Return the objective of the lowest loss of candidates up to a mass [kg]: of the highest torque limit by heat."""
    return Objective("temperature", {**lightest(requirement).limits, "mass": mass})
