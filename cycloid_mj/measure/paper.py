"""The paper's output torques, and the friction that would give them here."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from cycloid_mj.design import PRESETS, Design
from cycloid_mj.measure.conditions import rated_torque
from cycloid_mj.result import Quantity, Table

TORQUES = {"pin": {"simulated": 34.7, "measured": 34.335}, "nonpin": {"simulated": 35.8, "measured": 35.08}}
"""Output torque [N m] at 1.048 N m in (Hsieh 2014, section 3.4 and Fig. 19)."""
IDEAL = 36.68
"""The torque without losses [N m]: 1.048 x 35."""


@dataclass(frozen=True)
class PaperFigure:
    """One of the paper's torques, and the friction that gives it.

    Attributes
    ----------
    way
        How the paper found it: simulated or measured.
    torque
        [N m].
    friction
        Coefficient of all sliding pairs that gives this rate, interpolated; not a number where none tried encloses it.
    error
        What the interpolation misses, by a run with that friction; None without such a run.
    """

    way: str
    torque: float
    friction: float = math.nan
    error: float | None = None

    @property
    def rate(self) -> float:
        """Output torque as a share of that without losses."""
        return self.torque / IDEAL


def figures(design: Design) -> list[PaperFigure]:
    """Give the paper's torques for this kind of ring; none for a reducer of other teeth or another input torque."""
    paper = PRESETS[design.ring.kind]
    cut = [(one.ring.teeth, one.gear.eccentricity, one.ring.pin_circle_radius) for one in (design, paper)]
    if cut[0] != cut[1] or not math.isclose(rated_torque(design), IDEAL, rel_tol=1e-3):
        return []
    return [PaperFigure(way, torque) for way, torque in TORQUES[design.ring.kind].items()]


def friction_quantities(found: Sequence[PaperFigure]) -> dict[str, Quantity]:
    """Give the frictions as quantities."""
    note = "all pairs that slide alike; rolling bearings and seals as designed"
    return {
        f"friction_for_paper_{one.way}": Quantity(
            f"friction that gives the paper's {one.torque:g} N m, {one.way}", one.friction, "1", one.error, note=note
        )
        for one in found
    }


def tables(ours: float, found: Sequence[PaperFigure]) -> tuple[Table, ...]:
    """Put our output torque [N m] at the design's friction beside the paper's, if it has one for this design."""
    if not found:
        return ()
    rows = [(f"the paper, {one.way}", one.torque, 1e2 * one.rate, one.friction) for one in found]
    return (
        Table(
            "output torque beside the paper's (Hsieh 2014, Fig. 19)",
            ("", "output torque [N m]", "rate [%]", "friction that gives it"),
            (("here", ours, 1e2 * ours / IDEAL, "as designed"), *rows),
        ),
    )
