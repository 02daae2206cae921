"""Sizing: from a requirement to designs that meet it, or to the maximum achievable torque and remedies.

The search is MAP-Elites (Mouret and Clune, arXiv:1504.04909) on closed-form estimates: an archive has the lightest
candidate of each torque and length. It starts with the R sequence (Roberts 2018), and children vary along the line
between two elites (Vassiliades and Mouret, GECCO 2018). Neither limits nor conditions of a requirement enter, so that
one archive serves all of them. Under the conditions of a requirement, the candidates that could be best are rated by
statics: first for the largest torque, until it is enough, then for the lowest mass. Each rating multiplies the
estimates near it (variable fidelity: Alexandrov et al., J. Aircraft 38, 2001, weighted by inverse distance, Shepard
1968), and single changes of a variable refine the best.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cycloid_mj.sizing.answer import Answer

__all__ = ["new"]


def new(ratio: int, diameter_mm: float, torque_nm: float, **others: Any) -> "Answer":
    """Find drives that meet a requirement; ``cm.new(20, 60, 4).drives[0].design`` is the lightest.

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
        `fit`, `custom`, `duty`, `cooling`, `ambient_c`, `output_rpm`, as the flags of ``cycloid-mj design new``.

    Returns
    -------
    Answer
        Feasible drives, the lightest first, or the limit that makes the requirement infeasible, and remedies.

    Raises
    ------
    UsageError
        A value is out of range.
    """
    from cycloid_mj.sizing.drives import size_drive
    from cycloid_mj.sizing.requirement import required

    return size_drive(required(ratio=ratio, diameter_mm=diameter_mm, torque_nm=torque_nm, **others))
