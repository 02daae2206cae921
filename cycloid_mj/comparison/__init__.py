"""Designs side by side by the same measures: runs -> `Measures` -> `Comparison`, its tables.

A figure at no load rests on independent starts, whose motion is chaotic. What a paper claims of two designs is for
that paper to judge, by the same runs (`papers.judged_runs`).
"""

from cycloid_mj.base.result import load_words
from cycloid_mj.comparison.comparison import Comparison, comparable, compare
from cycloid_mj.comparison.conditions import conditions, differences, total_play, under, with_play_of
from cycloid_mj.comparison.measures import Measures, measure, settled, settling
from cycloid_mj.comparison.sensitivity import ASSUMPTIONS, Sensitivity, sensitivities
from cycloid_mj.comparison.starts import STARTS, StartSpread, all_started, gravity_turn, order, started
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
    "all_started",
    "comparable",
    "compare",
    "conditions",
    "differences",
    "gravity_turn",
    "load_words",
    "measure",
    "order",
    "sensitivities",
    "settled",
    "settling",
    "started",
    "total_play",
    "under",
    "with_play_of",
]
