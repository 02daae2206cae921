"""Output torques that a paper gives for a design, put beside ours, and the friction that would give them here."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from cycloid_mj.base.result import Quantity, Table


@dataclass(frozen=True)
class Published:
    """A published output torque, and the friction that gives it.

    Attributes
    ----------
    way, source
        How it was found, simulated or measured, and where it stands.
    torque, ideal
        That torque, and the one without losses at the same input torque [N m].
    friction
        Coefficient of all sliding pairs that gives this rate, interpolated; not a number where none tried encloses it.
    error
        What the interpolation misses, by a run with that friction; None without such a run.
    """

    way: str
    source: str
    torque: float
    ideal: float
    friction: float = math.nan
    error: float | None = None

    @property
    def rate(self) -> float:
        """Output torque as a share of that without losses."""
        return self.torque / self.ideal


def friction_quantities(published: Sequence[Published]) -> list[Quantity]:
    """List the frictions as quantities."""
    note = "all pairs that slide alike; rolling bearings and seals as designed"
    return [
        Quantity(
            f"friction_for_paper_{one.way}",
            f"friction that gives the paper's {one.torque:g} N m, {one.way}",
            one.friction,
            "1",
            one.error,
            note=note,
        )
        for one in published
    ]


def tables(ours: float, published: Sequence[Published]) -> tuple[Table, ...]:
    """Put our output torque [N m] at the design's friction beside the published ones, if there are any."""
    if not published:
        return ()
    first = published[0]
    rows = [(f"the paper, {one.way}", one.torque, 1e2 * one.rate, one.friction) for one in published]
    return (
        Table(
            f"output torque beside the paper's ({first.source})",
            ("", "output torque [N m]", "rate [%]", "friction that gives it"),
            (("here", ours, 1e2 * ours / first.ideal, "as designed"), *rows),
        ),
    )
