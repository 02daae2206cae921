"""Stops of the output at a locked driven shaft, extrapolated to no torque."""

from collections.abc import Callable

from cycloid_mj.base.array import Array


def stop_width(rotation: Callable[[float], Array], torque: float) -> Array:
    """Compute the backlash of the output [rad] at m angles of the locked driven shaft, shape (m,).

    It is the rotation from the stop under negative torques to that under positive torques. `rotation` is a function
    from a torque [N m] to rotations [rad], shape (m,). It is evaluated at `torque`, at twice this torque, and in the
    opposite direction; the line through both rotations is extrapolated to no torque.
    """
    negative_stop, positive_stop = (2.0 * rotation(sign * torque) - rotation(2.0 * sign * torque) for sign in (-1, 1))
    return positive_stop - negative_stop
