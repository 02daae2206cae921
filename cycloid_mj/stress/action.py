"""Where a force acts: its line of action, from force and moment, met with the surface it presses on."""

from dataclasses import dataclass

import numpy as np
from scipy.special import j1

from cycloid_mj.base.array import Array, Mask

NEGLIGIBLE = 1e-9
"""A force below this share of the turn's largest is rounding and is left out."""


@dataclass(frozen=True)
class Action:
    """A force along a turn: `force` [N] (k, 2), and its `moment` [N m] (k,) about the origin of its frame."""

    force: Array
    moment: Array

    @property
    def size(self) -> Array:
        """Size of the force [N], shape (k,)."""
        return np.linalg.norm(self.force, axis=-1)

    @property
    def direction(self) -> Array:
        """Unit vectors along the force, nan where there is none, shape (k, 2)."""
        size = self.size[..., np.newaxis]
        return np.divide(self.force, size, out=np.full_like(self.force, np.nan), where=size > 0.0)

    @property
    def foot(self) -> Array:
        """Point of the line of action nearest to the origin [m], nan where there is no force, shape (k, 2)."""
        squared = self.size**2
        arm = np.divide(self.moment, squared, out=np.full_like(squared, np.nan), where=squared > 0.0)
        return arm[..., np.newaxis] * turned_right(self.force)

    def reaction(self) -> "Action":
        """Compute the reaction: the same action on the other body."""
        return Action(-self.force, -self.moment)

    def seen_from(self, origin: Array, angle: Array) -> "Action":
        """Compute the action in a frame at `origin` [m] (k, 2) of the present one, turned by `angle` [rad] (k,)."""
        return Action(turned(self.force, -angle), self.moment - cross(origin, self.force))

    def without_rounding(self) -> "Action":
        """Compute the action with negligible forces set to zero."""
        return self.where(self.size > NEGLIGIBLE * np.max(self.size, initial=0.0))

    def where(self, chosen: Mask) -> "Action":
        """Compute the action at the chosen samples (k,), and no force at the others."""
        return Action(np.where(chosen[..., np.newaxis], self.force, 0.0), np.where(chosen, self.moment, 0.0))

    def on_hole(self, centre: Array, radius: float, half_width: Array | float = 0.0) -> Array:
        """Compute where the force presses on the wall of a hole [m], (k, 2): ahead of the hole's centre."""
        return self._on_circle(centre, radius, half_width, 1.0)

    def on_disc(self, centre: Array, radius: float, half_width: Array | float = 0.0) -> Array:
        """Compute where the force presses on a disc [m], (k, 2): behind the disc's centre."""
        return self._on_circle(centre, radius, half_width, -1.0)

    def _on_circle(self, centre: Array, radius: float, half_width: Array | float, side: float) -> Array:
        """Compute the middle of a patch of a half width [m] on a circle.

        A narrow patch lies where the line of action meets the circle. The tractions of a wide one point in many
        directions: for the same force they add up to more, and so does the moment of friction. Their resultant acts at
        a larger radius (the friction radius of a journal bearing), where the line of action is met. A line that misses
        the circle by rounding touches it.
        """
        along = self.direction
        out = self.foot - centre
        across = out - dot(out, along)[..., np.newaxis] * along
        reach = radius / mean_cosine(np.asarray(half_width) / radius)
        depth = np.sqrt(np.maximum(reach**2 - dot(across, across), 0.0))
        met = across + side * depth[..., np.newaxis] * along
        return centre + met * (radius / reach)[..., np.newaxis]


def mean_cosine(half_angle: Array) -> Array:
    """Average the cosine over an elliptical pressure of a half angle a [rad]: 2 J1(a)/a."""
    a = np.maximum(half_angle, 1e-9)
    return 2.0 * j1(a) / a


def dot(a: Array, b: Array) -> Array:
    """Compute inner products along the last axis."""
    return np.sum(a * b, axis=-1)


def cross(a: Array, b: Array) -> Array:
    """Compute the z of vector products of vectors (..., 2)."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def turned_right(vectors: Array) -> Array:
    """Turn vectors (..., 2) by a quarter turn clockwise."""
    return np.stack([vectors[..., 1], -vectors[..., 0]], axis=-1)


def turned(vectors: Array, angle: Array) -> Array:
    """Turn vectors (..., 2) counter-clockwise by angles (...) [rad]."""
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)
