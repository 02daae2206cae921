"""Hsieh 2014 again, figure by figure: stages with figures, claims with verdicts, errata with proofs."""

from cycloid_mj.papers import Paper
from hsieh2014.stated import torques

EXAMPLES = """Examples:
  cycloid-mj reproduce --quick
  cycloid-mj reproduce --out paper
  cycloid-mj reproduce --only stress torque --json"""

PAPER = Paper(
    key="hsieh2014",
    source="Hsieh 2014",
    command="hsieh2014.command:reproduce",
    examples=EXAMPLES,
    torques=torques,
)
