"""A prism of one outline with holes, and a solid as a stack of prisms."""

from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError


@dataclass(frozen=True, eq=False)
class Prism:
    """A plane region extruded along z.

    Attributes
    ----------
    outline
        Counter-clockwise polygon (n, 2) [m]; the last vertex joins the first.
    holes
        Counter-clockwise polygons (m, 2) [m] inside the outline, without common points.
    z0, z1
        The two faces [m], z0 < z1.

    Raises
    ------
    DesignError
        A polygon is not counter-clockwise, or z0 is not below z1.
    """

    outline: Array
    holes: tuple[Array, ...]
    z0: float
    z1: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "outline", _checked_copy(self.outline))
        object.__setattr__(self, "holes", tuple(_checked_copy(hole) for hole in self.holes))
        if not self.z0 < self.z1:
            raise DesignError(
                f"a prism from z0 = {self.z0} m to z1 = {self.z1} m has no height: make z1 greater than z0"
            )

    @property
    def height(self) -> float:
        """Distance between the faces [m]."""
        return self.z1 - self.z0


@dataclass(frozen=True, eq=False)
class Solid:
    """A part of the reducer: prisms without common volume, of one density [kg/m3]."""

    name: str
    prisms: tuple[Prism, ...]
    density: float


def _checked_copy(polygon: Array) -> Array:
    """Return a read-only copy of a polygon of n points (n, 2) [m]; raise DesignError unless it is counter-clockwise."""
    copy = np.array(polygon, dtype=np.float64)
    if copy.ndim != 2 or copy.shape[1] != 2 or len(copy) < 3:
        raise DesignError(
            f"the outline or a hole of a prism has shape {copy.shape}: pass an array of shape (n, 2) with n >= 3"
        )
    # a plain sum suffices for the sign; `polygon.signed_area` has twice the digits, for volumes
    (x, y), (next_x, next_y) = copy.T, np.roll(copy, -1, axis=0).T
    area = float(np.sum(x * next_y - next_x * y)) / 2
    if not area > 0.0:
        raise DesignError(
            f"the outline or a hole of a prism runs clockwise (signed area {area:.6g} m2), but must run "
            "counter-clockwise: reverse the order of its points"
        )
    copy.setflags(write=False)
    return copy
