"""Search over all friction that the paper leaves open for its output torques: teeth, cam, output pins and seals."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from cycloid_mj.base.engine import each_in_threads
from cycloid_mj.base.result import Range
from cycloid_mj.design import Design
from cycloid_mj.dynamics.massless import massless
from cycloid_mj.measure.sensitivity import friction_for, with_common_friction
from cycloid_mj.measure.spread import BEARING, TEETH
from cycloid_mj.measure.steady import steady_design, whole_periods
from cycloid_mj.measure.torque import rated_test
from cycloid_mj.reducer import Reducer

GRID = (0.0, 0.01, 0.03, 0.06, TEETH[1])
"""Frictions of the teeth between which that of a torque is interpolated [1]."""

SEALS = 0.02
"""Most drag of the crank's seals [N m]: a lip seal on a shaft of 12 to 15 mm (SKF, Power transmission seals)."""

PERIODS = 4
"""Fewest mesh periods of a run of the search."""

REACHED = 2e-3
"""A run with the friction that was found gives the paper's rate within this [1]."""

RANGES = (
    Range(
        "friction.pin_gear, pin_socket, tooth", 0.0, TEETH[1], "1", "a model without friction to boundary lubrication"
    ),
    Range("friction.cam_rolling", 0.0, BEARING[1], "1", "a model without friction to needles with a cage (JTEKT)"),
    Range("friction.output_rolling", 0.0, BEARING[1], "1", "a model without friction to needles with a cage (JTEKT)"),
    Range("drag.crank_nm", 0.0, SEALS, "N m", "none to a lip seal on the shaft (SKF)"),
)
"""What the paper leaves open of its torque test, and how far it was searched."""


@dataclass(frozen=True)
class Bearings:
    """How much cam, output pins and seals take: friction of both bearings [1], drag on the crank [N m]."""

    words: str
    cam: float | None
    output: float | None
    seals: float = 0.0

    def of_teeth(self, friction: float) -> str:
        """Name them beside a friction of the teeth."""
        return f"teeth of {friction:.3g} {self.words}"

    def of(self, design: Design) -> Design:
        """Return a design with these bearings; None leaves its own."""
        frictions = {"cam_rolling": self.cam, "output_rolling": self.output}
        stated = {key: value for key, value in frictions.items() if value is not None}
        return design.but(friction=stated, drag={"crank": self.seals})


AS_DESIGNED = Bearings("with cam and output pins as designed", None, None)
WITHOUT = Bearings("without friction of cam and output pins", 0.0, 0.0)
MOST = Bearings("with the most friction of cam, output pins and seals", BEARING[1], BEARING[1], SEALS)
WITHOUT_CAM = Bearings("without friction of the cam", 0.0, None)
WITHOUT_OUTPUT = Bearings("without friction of the output pins", None, 0.0)
SEARCHED = (AS_DESIGNED, WITHOUT, MOST)


Case = tuple[Bearings, float | None]
"""Bearings, and one friction of all that slides; None leaves the design's own."""


@dataclass(frozen=True)
class Solution:
    """One `friction` of the teeth that gives a rate with these bearings, and the `rate` of a run with it [1]."""

    bearings: Bearings
    friction: float
    rate: float

    @property
    def words(self) -> str:
        """Tell the solution."""
        return f"{self.bearings.of_teeth(self.friction)} give {1e2 * self.rate:.1f} %"


@dataclass(frozen=True)
class TorqueSearch:
    """What the search found for one design.

    Attributes
    ----------
    grid
        Output torque as a share of that without losses, of every bearing of `SEARCHED` at every friction of `GRID`.
    solutions
        Way of the paper, simulated or measured -> what gives its rate.
    removed
        Part whose friction is taken away alone -> the rate.
    """

    grid: Mapping[Case, float]
    solutions: Mapping[str, tuple[Solution, ...]]
    removed: Mapping[str, float]


def search(design: Design, targets: Mapping[str, float]) -> TorqueSearch:
    """Search one design for rates by their ways."""
    grid = rates(design, [(bearings, friction) for bearings in SEARCHED for friction in GRID])
    solutions = {way: _solutions(design, grid, target) for way, target in targets.items()}
    return TorqueSearch(grid, solutions, _removed(design))


def rates(design: Design, cases: Iterable[Case]) -> dict[Case, float]:
    """Run the torque test of each case; give the output torque as a share of that without losses."""
    steady = massless(steady_design(Reducer(design)).working_at(design.rated_torque))
    periods = whole_periods(steady, PERIODS)
    wanted = list(dict.fromkeys(cases))
    tested = each_in_threads(lambda case: _rate(steady.design, case, periods), wanted)
    return dict(zip(wanted, tested, strict=True))


def _solutions(design: Design, grid: Mapping[Case, float], target: float) -> tuple[Solution, ...]:
    """Find what gives a rate, each confirmed by a run; nothing where no friction of the grid encloses it."""
    inside: list[tuple[Bearings, float]] = [
        (bearings, friction)
        for bearings in SEARCHED
        if math.isfinite(friction := friction_for({mu: grid[bearings, mu] for mu in GRID}, target))
    ]
    tested = rates(design, inside)
    solutions = [Solution(bearings, friction, tested[bearings, friction]) for bearings, friction in inside]
    return tuple(solution for solution in solutions if abs(solution.rate - target) <= REACHED)


def _removed(design: Design) -> dict[str, float]:
    """Compute the rate with the friction of one part taken away alone, by what is taken away."""
    parts: Sequence[tuple[str, Case]] = (
        ("friction of the teeth", (AS_DESIGNED, 0.0)),
        ("friction of the cam", (WITHOUT_CAM, None)),
        ("friction of the output pins", (WITHOUT_OUTPUT, None)),
    )
    tested_rates = rates(design, [case for _, case in parts])
    return {what: tested_rates[case] for what, case in parts}


def _rate(design: Design, case: Case, periods: int) -> float:
    bearings, friction = case
    varied = bearings.of(design)
    if friction is not None:
        varied = with_common_friction(Reducer(varied), friction).design
    return rated_test(Reducer(varied), periods).output / design.rated_torque
