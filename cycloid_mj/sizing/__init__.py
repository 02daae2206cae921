"""Sizing: from what is asked of a drive to designs that do it, or to the most that goes and what would help."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cycloid_mj.sizing.answer import Answer

__all__ = ["new"]


def new(ratio: int, diameter_mm: float, torque_nm: float, **others: Any) -> "Answer":
    """Find drives that do what is asked of them; ``cm.new(20, 60, 10).drives[0].design`` is the lightest.

    Parameters
    ----------
    ratio
        Turns of the crank for one of the output.
    diameter_mm
        Outside [mm].
    torque_nm
        On the output, for all of the life [N m]; twice as much is held once.
    others
        `life_h`, `speed_rpm`, `process`, `discs`, `length_mm`, `backlash_arcmin`, `material`, `clearance_um`,
        `fit`, `custom`, as the flags of ``cycloid-mj design new``.

    Raises
    ------
    UsageError
        A value is out of its range.
    """
    from cycloid_mj.sizing.answer import answered
    from cycloid_mj.sizing.requirement import required

    return answered(required(ratio=ratio, diameter_mm=diameter_mm, torque_nm=torque_nm, **others))
