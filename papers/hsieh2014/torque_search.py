"""Search for the friction of teeth, cam, output pins and seals that reproduces the paper's output torques."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from cycloid_mj.base.engine import each_in_threads
from cycloid_mj.base.result import Range
from cycloid_mj.design import Design
from cycloid_mj.dynamics.massless import massless
from cycloid_mj.measure.sensitivity import interpolate_friction, with_common_friction
from cycloid_mj.measure.spread import INPUTS
from cycloid_mj.measure.steady import averaging_periods, steady_design
from cycloid_mj.measure.torque import rated_test
from cycloid_mj.reducer import Reducer

GRID = (0.0, 0.01, 0.03, 0.06, INPUTS.tooth_friction[1])
"""Friction coefficients of the teeth for the interpolation [1]."""

SEALS = 0.02
"""Largest drag of the crank's seals [N m]: a lip seal on a shaft of 12 to 15 mm (SKF, Power transmission seals)."""


REACHED = 2e-3
"""Tolerance of the rate of a run with the solution [1]."""

BOUNDARY, NEEDLES = INPUTS.tooth_friction[1], INPUTS.bearing_friction[1]
"""Largest friction of the teeth, with boundary lubrication, and of a bearing, needles with a cage (JTEKT)."""

CAGED = "a model without friction to needles with a cage (JTEKT)"
TEETH = "friction.pin_gear, pin_socket, tooth"
RANGES = (
    Range(TEETH, 0.0, BOUNDARY, "1", "a model without friction to boundary lubrication"),
    *(Range(f"friction.{pair}_rolling", 0.0, NEEDLES, "1", CAGED) for pair in ("cam", "output")),
    Range("drag.crank_nm", 0.0, SEALS, "N m", "none to a lip seal on the shaft (SKF)"),
)
"""What the paper leaves open of its torque test, with the searched ranges."""


@dataclass(frozen=True)
class Bearings:
    """Losses of cam, output pins and seals: friction of both bearings [1], drag on the crank [N m]."""

    words: str
    cam: float | None
    output: float | None
    seals: float = 0.0

    def of_teeth(self, friction: float) -> str:
        """Return a description, with a friction of the teeth."""
        return f"teeth of {friction:.3g} {self.words}"

    def of(self, design: Design) -> Design:
        """Return a design with these bearings; None keeps its own."""
        frictions = {"cam_rolling": self.cam, "output_rolling": self.output}
        stated = {key: value for key, value in frictions.items() if value is not None}
        return design.but(friction=stated, drag={"crank": self.seals})


AS_DESIGNED = Bearings("with cam and output pins as designed", None, None)
WITHOUT = Bearings("without friction of cam and output pins", 0.0, 0.0)
MOST = Bearings("with the most friction of cam, output pins and seals", NEEDLES, NEEDLES, SEALS)
WITHOUT_CAM = Bearings("without friction of the cam", 0.0, None)
WITHOUT_OUTPUT = Bearings("without friction of the output pins", None, 0.0)
SEARCHED = (AS_DESIGNED, WITHOUT, MOST)


Case = tuple[Bearings, float | None]
"""Bearings, and one friction of all sliding contacts; None keeps the design's own."""


@dataclass(frozen=True)
class Solution:
    """A `friction` of the teeth that reproduces a rate with these bearings, and the `rate` of a run with it [1]."""

    bearings: Bearings
    friction: float
    rate: float

    @property
    def words(self) -> str:
        """Return the solution in words."""
        return f"{self.bearings.of_teeth(self.friction)} give {1e2 * self.rate:.1f} %"


@dataclass(frozen=True)
class TorqueSearch:
    """Result of the search for one design."""

    grid: Mapping[Case, float]
    """Output torque as a share of that without losses, for the bearings of `SEARCHED` and the frictions of `GRID`."""
    solutions: Mapping[str, tuple[Solution, ...]]
    """"simulated" or "measured" in the paper -> solutions for its rate."""
    removed: Mapping[str, float]
    """Part without friction -> the rate."""


def search(design: Design, targets: Mapping[str, float]) -> TorqueSearch:
    """Search one design for the target rates, by name."""
    grid = rates(design, [(bearings, friction) for bearings in SEARCHED for friction in GRID])
    solutions = {kind: _solutions(design, grid, target) for kind, target in targets.items()}
    return TorqueSearch(grid, solutions, _rates_without(design))


def rates(design: Design, cases: Iterable[Case]) -> dict[Case, float]:
    """Run the torque test of each case; return the output torque as a share of that without losses."""
    steady = massless(steady_design(Reducer(design)).working_at(design.rated_torque))
    periods = averaging_periods(steady, 4)
    wanted = list(dict.fromkeys(cases))
    tested = each_in_threads(lambda case: _rate(steady.design, case, periods), wanted)
    return dict(zip(wanted, tested, strict=True))


def _solutions(design: Design, grid: Mapping[Case, float], target: float) -> tuple[Solution, ...]:
    """Return the tooth frictions that reproduce an output rate; none if the grid does not enclose the rate.

    Each is confirmed by a run. `target` is the output torque over that without losses [1], `grid` the computed rates.
    """
    inside: list[tuple[Bearings, float]] = [
        (bearings, friction)
        for bearings in SEARCHED
        if math.isfinite(friction := interpolate_friction({mu: grid[bearings, mu] for mu in GRID}, target))
    ]
    tested = rates(design, inside)
    solutions = [Solution(bearings, friction, tested[bearings, friction]) for bearings, friction in inside]
    return tuple(solution for solution in solutions if abs(solution.rate - target) <= REACHED)


def _rates_without(design: Design) -> dict[str, float]:
    """Compute the output torque over that without losses [1] if one part has no friction, by the name of the part."""
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
