"""Openings of the gaps by wear, as functions of the place of contact; equal for all parts of a kind."""

from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array


@dataclass(frozen=True, eq=False)
class WornGaps:
    """Depths of wear of both surfaces of a pair, by which its gap is wider than that of new parts [m].

    Attributes
    ----------
    teeth
        By the phase B of a pin or lobe of the ring, at the angles of `table_angles`, shape (m,).
    output
        By the direction of the force on the disc, from the radius of the output pin counter-clockwise, shape (m,).
    cam
        Uniform.
    """

    teeth: Array
    output: Array
    cam: float

    def of_teeth(self, phase: Array) -> Array:
        """Return the opening of the gaps of the teeth [m] at phases B [rad], in their shape."""
        return np.interp(phase, table_angles(self.teeth.size), self.teeth, period=2.0 * np.pi)

    def of_output(self, direction: Array) -> Array:
        """Return the opening of the gaps of the output pins [m] at directions [rad], in their shape."""
        return np.interp(direction, table_angles(self.output.size), self.output, period=2.0 * np.pi)


def table_angles(count: int) -> Array:
    """Return the angles of a table of a full turn [rad], shape (count,), from -pi on."""
    return -np.pi + 2.0 * np.pi * np.arange(count) / count
