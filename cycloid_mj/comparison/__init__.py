"""Designs side by side by the same measures: runs -> `Measures` -> `Comparison`, its table and its words.

A verdict on the paper's findings rests on more than one number: at no load on independent starts, whose motion is
chaotic, and under load on the crank turns of a run.
"""

from cycloid_mj.base.result import load_words
from cycloid_mj.comparison.comparison import Comparison, comparable, compare
from cycloid_mj.comparison.conditions import conditions, differences, total_play, under, with_play_of
from cycloid_mj.comparison.measures import Measures, measure, settled, settling
from cycloid_mj.comparison.ranking import RANKED, Ranked, Ranking, rankings
from cycloid_mj.comparison.sensitivity import ASSUMPTIONS, Sensitivity, sensitivities
from cycloid_mj.comparison.starts import STARTS, StartSpread, all_started, gravity_turn, order, started
from cycloid_mj.comparison.sweep import SWEEP, Variation, Varied, varied
from cycloid_mj.comparison.trial import Trial

__all__ = [
    "ASSUMPTIONS",
    "RANKED",
    "STARTS",
    "SWEEP",
    "Comparison",
    "Measures",
    "Ranked",
    "Ranking",
    "Sensitivity",
    "StartSpread",
    "Trial",
    "Variation",
    "Varied",
    "all_started",
    "comparable",
    "compare",
    "conditions",
    "differences",
    "gravity_turn",
    "load_words",
    "measure",
    "order",
    "rankings",
    "sensitivities",
    "settled",
    "settling",
    "started",
    "total_play",
    "under",
    "varied",
    "with_play_of",
]
