"""Reproduction of Hsieh 2014: stages with figures, claims with verdicts, errata with proofs."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from cycloid_mj.papers import Paper, RunsJudged
from hsieh2014.stated import is_ours, stress_references, torques

if TYPE_CHECKING:
    from cycloid_mj.base.result import Claim
    from cycloid_mj.comparison import Trial, Variation
    from cycloid_mj.stress.study import StressStudy

EXAMPLES = """Examples:
  cycloid-mj reproduce --quick
  cycloid-mj reproduce --out paper
  cycloid-mj reproduce --as-the-authors
  cycloid-mj reproduce --only stress torque --json"""


def _stress_claims(studies: "Sequence[StressStudy]") -> "tuple[Claim, ...]":
    from hsieh2014.one_run import claims

    return claims([study.findings for study in studies if is_ours(study.design)])


def _judged_runs(trials: "Sequence[Trial]", varied: "Mapping[Variation, Sequence[Trial]]") -> RunsJudged:
    from hsieh2014.rivals import judged_runs

    return judged_runs(trials, varied)


PAPER = Paper(
    key="hsieh2014",
    source="Hsieh 2014",
    command="hsieh2014.command:reproduce",
    examples=EXAMPLES,
    torques=torques,
    judged_runs=_judged_runs,
    stress_references=stress_references,
    stress_claims=_stress_claims,
)
