"""Output rollers on separate needles, linearised at many contacts."""

from collections.abc import Callable
from typing import Any, cast

from cycloid_mj.base.array import Array
from cycloid_mj.base.compiling import cacheable, njit
from cycloid_mj.reducer import roller_needles
from cycloid_mj.reducer.roller_needles import RollerNeedles

_njit = cast("Callable[[Any], Any]", njit(inner=True, allocates=False, error_model="numpy"))

_onset, _roller_contact = _njit(roller_needles.onset), _njit(roller_needles.roller_contact)


@njit(cache=cacheable(), allocates=False, nogil=True, error_model="numpy")
def linearise_rollers(
    needles: RollerNeedles, angle: Array, stiffness: Array, approach: Array, force: Array, slope: Array, start: Array
) -> None:
    """Linearise the force of n output rollers on their needles about an approach, at m crank angles.

    The linear force is `slope` times (approach - `start`).

    Parameters
    ----------
    needles
        Needles of the rollers.
    angle
        Direction of the force on each roller, relative to that of a needle [rad], shape (m, n).
    stiffness
        Stiffness of the contact with the hole [N/m], shape (m, n).
    approach
        Approach of hole and core [m], shape (m, n), as in `roller_needles.roller_contact`.
    force, slope, start
        Results, shape (m, n): force [N] at this approach, slope [N/m], and approach at which the linear force is 0 [m].
        Without force, the slope is that of the hole's contact in series with the needles of the loaded half.
    """
    for k in range(angle.shape[0]):
        for i in range(angle.shape[1]):
            onset = _onset(needles, angle[k, i])
            bearing_stiffness = 0.25 * needles.needles * needles.stiffness
            force[k, i], slope[k, i], start[k, i] = 0.0, 1.0 / (1.0 / stiffness[k, i] + 1.0 / bearing_stiffness), onset
            if approach[k, i] > onset:
                force[k, i], slope[k, i] = _roller_contact(
                    approach[k, i], angle[k, i], stiffness[k, i], needles.needles, needles.stiffness, needles.clearance
                )
                start[k, i] = approach[k, i] - force[k, i] / slope[k, i]
