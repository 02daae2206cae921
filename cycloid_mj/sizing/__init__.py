"""Sizing: from a requirement to designs that meet it, or to the maximum achievable torque and remedies.

The search is surrogate-assisted illumination (Gaier, Asteroth and Mouret, Evol. Comput. 26, 2018): MAP-Elites (Mouret
and Clune, arXiv:1504.04909) on closed-form estimates keeps the lightest candidate of each torque and length, with
children along the line between two elites (Vassiliades and Mouret, GECCO 2018). Neither limits nor conditions of a
requirement enter, so that one archive serves all of them. Under the conditions of a requirement, the candidate with the
largest expected improvement is rated by statics of one tolerance sample, until none is expected (efficient global
optimization; Jones, Schonlau and Welch, J. Global Optim. 13, 1998): first for the largest torque and then the smallest
length, until each is sufficient, then for the lowest mass, then for the lowest loss among the drives with nearly that
mass (lexicographic order with a tolerance; Marler and Arora, Struct. Multidisc. Optim. 26, 2004). Each rating corrects
the estimates near it (weighted by inverse distance, Shepard 1968), also those of other conditions and sizes by which
remedies of a refusal are predicted. Only a drive that passes its tolerance study is an answer.
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
        Continuous output torque [N m]; the drive carries twice this torque as a peak.
    others
        `life_h`, `speed_rpm`, `process`, `discs`, `length_mm`, `backlash_arcmin`, `material`, `clearance_um`, `fit`,
        `custom`, `duty`, `cooling`, `ambient_c`, `output_rpm`: the same as the options of ``cycloid-mj design new``.

    Returns
    -------
    Answer
        Feasible drives, the lightest first; or the limit that makes the requirement infeasible, and remedies.

    Raises
    ------
    UsageError
        A value is out of range.
    """
    from cycloid_mj.sizing.drives import size_drive
    from cycloid_mj.sizing.requirement import make_requirement

    return size_drive(make_requirement(ratio=ratio, diameter_mm=diameter_mm, torque_nm=torque_nm, **others))
