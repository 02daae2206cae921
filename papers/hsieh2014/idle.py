"""Idle quantities over independent starts: the spread of each, for each design, as parameters vary."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from cycloid_mj.comparison import Measures, Spread, Variation, measure, order, settled
from cycloid_mj.record import Run
from hsieh2014.plan import Plan, designs, idle_runs, variations, varied_idle_runs
from hsieh2014.stage import Runs


@dataclass(frozen=True)
class Quantity:
    """A quantity that the paper ranks.

    Attributes
    ----------
    key, name, unit
        For programs, in words, and its unit.
    figure
        Of the paper; "vibration" where it speaks of it without one.
    part
        That it belongs to.
    level
        Its rms fluctuation about the closed form, out of a run's measures.
    """

    key: str
    name: str
    unit: str
    figure: str
    part: str
    level: Callable[[Measures], float]


QUANTITIES = (
    Quantity("gear_speed", "gear speed", "rad/s", "Fig. 6", "gear", lambda m: m.fluctuation.gear_speed_rad_s.rms),
    Quantity("q_path", "path of q", "um", "Fig. 7", "gear", lambda m: m.fluctuation.q_path_um.rms),
    Quantity("q_velocity", "velocity of q", "mm/s", "Fig. 8", "gear", lambda m: m.fluctuation.q_velocity_mm_s.rms),
    Quantity(
        "gear_centre_acceleration",
        "acceleration of the gear centre",
        "m/s^2",
        "vibration",
        "gear",
        lambda m: m.vibration.gear_centre_m_s2.rms,
    ),
    Quantity(
        "output_acceleration",
        "acceleration of the output",
        "rad/s^2",
        "vibration",
        "output",
        lambda m: m.vibration.output_rad_s2.rms,
    ),
)
"""What the paper says fluctuates, or vibrates, more with pins than without."""


@dataclass(frozen=True)
class Idle:
    """The idle fluctuations of one case: quantity key -> design name -> rms of each start."""

    levels: Mapping[str, Mapping[str, Spread]]

    def order(self, key: str) -> int:
        """Tell which design fluctuates more in a quantity: pin (1), nonpin (-1), or neither for sure (0)."""
        return order(self.levels[key]["pin"], self.levels[key]["nonpin"])

    def ratio(self, key: str) -> float:
        """Give the mean of the pin design as a multiple of the nonpin design's."""
        found = self.levels[key]
        return found["pin"].mean / found["nonpin"].mean if found["nonpin"].mean else float("inf")


def idle(plan: Plan, runs: Runs) -> Idle:
    """Give the idle fluctuations of both designs."""
    return of_runs({design.name: runs(idle_runs(plan, design)) for design in designs()})


def swept(plan: Plan, runs: Runs) -> dict[Variation, Idle]:
    """Give the idle fluctuations with one parameter varied at a time."""
    sweep = variations(plan)
    # all at once, so that the runs fill every core
    runs([run for one in sweep for design in designs() for run in varied_idle_runs(plan, one, design)])
    return {
        one: of_runs({design.name: runs(varied_idle_runs(plan, one, design)) for design in designs()}) for one in sweep
    }


def of_runs(starts: Mapping[str, Sequence[Run]]) -> Idle:
    """Collect the levels of runs: design name -> its starts."""
    measured = {name: [measure(settled(run)) for run in found] for name, found in starts.items()}
    return Idle(
        {
            each.key: {name: Spread.of(each.level(one) for one in found) for name, found in measured.items()}
            for each in QUANTITIES
        }
    )


def label(variation: Variation) -> str:
    """Name a variation in a row."""
    return f"{variation.parameter} {variation.value}"
