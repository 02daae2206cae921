"""Judgement, from runs of `compare`, whether a pin design fluctuates more than a nonpin one, as the paper states.

Without load the motion is chaotic, and independent starts decide whether two designs differ. Under load it is regular,
and the crank turns of one run decide.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

from cycloid_mj.base.result import load_words
from cycloid_mj.comparison import STARTS, Measures, StartSpread, Trial, compare_order
from cycloid_mj.comparison.fluctuation import Level
from cycloid_mj.comparison.starts import ORDER_MARGIN
from hsieh2014.stated import FLUCTUATIONS

Verdict = Literal["confirmed", "contradicted", "alike", "undecided", "not determined"]

OUTCOMES: dict[str, tuple[str, ...]] = {
    word: (word,) for word in ("confirmed", "not confirmed", "undecided", "not determined")
}
OUTCOMES["not confirmed"] = ("contradicted", "alike")

SIGNIFICANCE = 0.05
"""Significance level of the rank test of turns."""

FEWEST_TURNS = 4
"""Smallest number of turns of each design for the rank test: 2 of C(8, 4) orders are 3 %."""


class Ranked(NamedTuple):
    """A quantity whose fluctuation is ranked: key, name, unit, and its level in the results of a run."""

    key: str
    name: str
    unit: str
    level: Callable[[Measures], Level]


RANKED = (
    Ranked("gear_speed", "disc speed", "rad/s", lambda m: m.fluctuation.gear_speed_rad_s),
    Ranked("q_path", "path of q", "um", lambda m: m.fluctuation.q_path_um),
    Ranked("q_velocity", "velocity of q", "mm/s", lambda m: m.fluctuation.q_velocity_mm_s),
    Ranked(
        "gear_centre_acceleration",
        "acceleration of the disc's centre",
        "m/s^2",
        lambda m: m.vibration.gear_centre_m_s2,
    ),
    Ranked("output_acceleration", "acceleration of the output", "rad/s^2", lambda m: m.vibration.output_rad_s2),
)


@dataclass(frozen=True)
class Ranking:
    """A quantity of a pin and of a nonpin design under one load: levels and verdict on the paper's statement.

    The paper states that the pin design fluctuates more. Under load this is `confirmed` or `contradicted` if a rank
    test (Mann and Whitney, two-sided, 5 %) distinguishes the crank turns of the two designs. The designs are `alike` if
    their rms values are within 5 %. Otherwise, and with fewer than `FEWEST_TURNS`, it is `undecided`. Without load it
    is `confirmed` or `contradicted` if all starts of one design exceed all of the other by more than 5 %. Otherwise,
    and with fewer than `STARTS` independent starts, it is `not determined`.
    """

    quantity: str
    figure: str
    unit: str
    """Name, the paper's figure ("" if it has none) and unit."""
    load_nm: float
    """Load torque [N m]."""
    pin: str
    nonpin: str
    """Names of the designs."""
    pin_level: Level
    nonpin_level: Level
    """Levels of the first start, with those of its turns."""
    pin_starts: StartSpread
    nonpin_starts: StartSpread
    """The rms value of every start."""

    @property
    def ratio(self) -> float:
        """Return the mean level of the pin design relative to that of the nonpin design."""
        return self.pin_starts.mean / self.nonpin_starts.mean if self.nonpin_starts.mean else float("inf")

    @property
    def starts(self) -> int:
        """Return the number of independent starts of each design; bitwise copies do not count."""
        return min(self.pin_starts.independent, self.nonpin_starts.independent)

    @property
    def verdict(self) -> Verdict:
        """Verdict on the paper's statement, by the rules that the docstring of the class states."""
        if self.load_nm == 0.0:
            ordering = compare_order(self.pin_starts, self.nonpin_starts) if self.starts >= STARTS else 0
            return ("not determined", "confirmed", "contradicted")[ordering]
        if min(len(self.pin_level.by_turn), len(self.nonpin_level.by_turn)) < FEWEST_TURNS:
            return "undecided"
        if 1 / ORDER_MARGIN <= self.ratio <= ORDER_MARGIN:
            return "alike"
        if self.chance > SIGNIFICANCE:
            return "undecided"
        return "confirmed" if self.ratio > 1.0 else "contradicted"

    @property
    def chance(self) -> float:
        """Return the p value of the turns under the hypothesis of equal designs."""
        from scipy.stats import mannwhitneyu

        return float(mannwhitneyu(self.pin_level.by_turn, self.nonpin_level.by_turn).pvalue)

    @property
    def sentence(self) -> str:
        """Return the verdict in words, with the numbers."""
        phrase = {
            "confirmed": f"CONFIRMED, {self.pin} fluctuates more",
            "contradicted": f"NOT CONFIRMED, {self.nonpin} fluctuates more",
            "alike": "NOT CONFIRMED, both are alike",
            "undecided": "UNDECIDED, their turns do not tell them apart",
            "not determined": f"NOT DETERMINED, {self._open()}",
        }[self.verdict]
        claim = f"{self.figure}): {phrase}" if self.figure else f"not in the paper): {phrase.split(', ', 1)[1]}"
        return f"{load_words(self.load_nm)}, {self.quantity} ({claim}: {self._numbers()}"

    def _open(self) -> str:
        """Return in words why the starts do not determine an order."""
        if self.starts < STARTS:
            return f"{self.starts} {'start' if self.starts == 1 else 'starts'} of the {STARTS} that it takes"
        return f"{self.starts} starts spread by more than their difference"

    def _numbers(self) -> str:
        """Return the rms of both designs and their ratio in words: over starts without load, else over turns."""
        if self.load_nm == 0.0:
            spreads = ((self.pin, self.pin_starts), (self.nonpin, self.nonpin_starts))
            parts = [f"{name} {level.words} {self.unit} (mean {level.mean:.3g})" for name, level in spreads]
            return f"rms {', '.join(parts)}, ratio of the means {self.ratio:.2f}"
        levels = ((self.pin, self.pin_level), (self.nonpin, self.nonpin_level))
        parts = [
            f"{name} {level.rms:.3g} {self.unit} (turns {min(level.by_turn):.3g} to {max(level.by_turn):.3g})"
            for name, level in levels
        ]
        return f"rms {', '.join(parts)}, ratio {self.ratio:.2f}"


def summary(ranked: Sequence[Ranking]) -> list[str]:
    """Return for each load and pair of designs which statements of the paper the runs confirm."""
    lines = []
    for load, pin, nonpin in dict.fromkeys((ranking.load_nm, ranking.pin, ranking.nonpin) for ranking in ranked):
        claims = [r for r in ranked if r.figure and (r.load_nm, r.pin, r.nonpin) == (load, pin, nonpin)]
        parts = [
            f"{words} for {', '.join(quantities)}"
            for words, verdicts in OUTCOMES.items()
            if (quantities := [f"{r.quantity} ({r.figure})" for r in claims if r.verdict in verdicts])
        ]
        lines.append(f"{load_words(load)}, {pin} fluctuates more than {nonpin}: {'; '.join(parts)}")
    return lines


def rankings(trials: Sequence[Trial]) -> list[Ranking]:
    """Rank every pin design against every nonpin design under each load."""
    pins = [trial for trial in trials if trial.design.ring.kind == "pin"]
    others = [trial for trial in trials if trial.design.ring.kind == "nonpin"]
    pairs = [(pin, nonpin) for pin in pins for nonpin in others if pin.load == nonpin.load]
    return [_ranking(quantity, pin, nonpin) for pin, nonpin in pairs for quantity in RANKED]


def _ranking(quantity: Ranked, pin: Trial, nonpin: Trial) -> Ranking:
    pins, others = ([quantity.level(start) for start in trial.starts] for trial in (pin, nonpin))
    spreads = (StartSpread.of(level.rms for level in levels) for levels in (pins, others))
    figure = FLUCTUATIONS.get(quantity.name, "")
    return Ranking(quantity.name, figure, quantity.unit, pin.load, pin.name, nonpin.name, pins[0], others[0], *spreads)
