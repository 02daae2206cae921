"""Comparison of designs by equal measures: runs -> `Measures` -> `Comparison` with its tables.

The motion at no load is chaotic, so its figures come from several independent starts. A paper's claims about two
designs are judged by the paper's own package on the same runs (`papers.judge_runs`).
"""

from cycloid_mj.base.result import load_words
from cycloid_mj.comparison.comparison import Comparison, comparable, compare
from cycloid_mj.comparison.conditions import apply_conditions, conditions, differences, total_play, with_play_of
from cycloid_mj.comparison.measures import Measures, measure_run, settle_run, settling_time
from cycloid_mj.comparison.sensitivity import ASSUMPTIONS, Sensitivity, sensitivities
from cycloid_mj.comparison.starts import (
    STARTS,
    StartSpread,
    compare_order,
    gravity_turn,
    independent_starts,
    start_variant,
)
from cycloid_mj.comparison.trial import Trial
from cycloid_mj.comparison.variation import SWEEP, Variation

__all__ = [
    "ASSUMPTIONS",
    "STARTS",
    "SWEEP",
    "Comparison",
    "Measures",
    "Sensitivity",
    "StartSpread",
    "Trial",
    "Variation",
    "apply_conditions",
    "comparable",
    "compare",
    "compare_order",
    "conditions",
    "differences",
    "gravity_turn",
    "independent_starts",
    "load_words",
    "measure_run",
    "sensitivities",
    "settle_run",
    "settling_time",
    "start_variant",
    "total_play",
    "with_play_of",
]
