"""Sizing: from a requirement to designs that meet it, or to the maximum achievable torque and remedies."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cycloid_mj.sizing.answer import Answer

__all__ = ["new"]


def new(ratio: int, diameter_mm: float, torque_nm: float, **others: Any) -> "Answer":
    """Find drives that meet a requirement; ``cm.new(20, 60, 10).drives[0].design`` is the lightest.

    Parameters
    ----------
    ratio
        Crank turns per output turn.
    diameter_mm
        Outer diameter [mm].
    torque_nm
        Continuous output torque [N m]; twice as much is allowed as a peak.
    others
        `life_h`, `speed_rpm`, `process`, `discs`, `length_mm`, `backlash_arcmin`, `material`, `clearance_um`,
        `fit`, `custom`, as the flags of ``cycloid-mj design new``.

    Raises
    ------
    UsageError
        A value is out of range.
    """
    from cycloid_mj.sizing.answer import size_drive
    from cycloid_mj.sizing.requirement import required

    return size_drive(required(ratio=ratio, diameter_mm=diameter_mm, torque_nm=torque_nm, **others))
