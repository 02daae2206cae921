"""Hsieh 2014 again, figure by figure: stages with figures, claims with verdicts, errata with proofs."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from cycloid_mj.papers import Paper
from hsieh2014.stated import VIBRATION, is_ours, stress_references, torques

if TYPE_CHECKING:
    from cycloid_mj.base.result import Claim
    from cycloid_mj.stress.study import StressStudy

EXAMPLES = """Examples:
  cycloid-mj reproduce --quick
  cycloid-mj reproduce --out paper
  cycloid-mj reproduce --as-the-authors
  cycloid-mj reproduce --only stress torque --json"""


def _stress_claims(studies: "Sequence[StressStudy]") -> "tuple[Claim, ...]":
    from hsieh2014.one_run import claims

    return claims([study.findings for study in studies if is_ours(study.design)])


PAPER = Paper(
    key="hsieh2014",
    source="Hsieh 2014",
    command="hsieh2014.command:reproduce",
    examples=EXAMPLES,
    torques=torques,
    vibration=VIBRATION,
    stress_references=stress_references,
    stress_claims=_stress_claims,
)
