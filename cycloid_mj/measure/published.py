"""Published output torques of a design, and the friction that would explain them in this model."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from cycloid_mj.base.result import Quantity, Table


@dataclass(frozen=True)
class Published:
    """A published output torque, and the friction that explains it."""

    method: str
    source: str
    """Whether it was simulated or measured, and the reference."""
    torque: float
    ideal: float
    """The torque, and that without losses at the same input torque [N m]."""
    friction: float = math.nan
    """Coefficient of all sliding pairs at which the model has this rate, interpolated; NaN outside of the range run."""
    error: float | None = None
    """Error of the interpolation, by a run with that friction; None without such a run."""

    @property
    def rate(self) -> float:
        """Output torque relative to that without losses."""
        return self.torque / self.ideal


def friction_quantities(published: Sequence[Published]) -> list[Quantity]:
    """Return, for each published output torque, the friction coefficient at which the model has this torque.

    The coefficient is the same for all sliding pairs; the results are quantities with their errors.
    """
    note = "the same for all sliding pairs; rolling bearings and seals as designed"
    quantity_names = [f"friction at the paper's {paper.torque:g} N m, {paper.method}" for paper in published]
    return [
        Quantity(f"friction_for_paper_{paper.method}", name, paper.friction, "1", paper.error, note=note)
        for paper, name in zip(published, quantity_names, strict=True)
    ]


def tables(output_torque: float, published: Sequence[Published]) -> tuple[Table, ...]:
    """Return a table that compares the model's output torque [N m] with published torques: torque, rate and friction.

    The rate is the torque over that without losses [%]; the friction is the coefficient at which the model has the
    published torque. Returns a tuple of this table, empty without published torques.
    """
    if not published:
        return ()
    first_paper = published[0]
    rows = [(f"the paper, {paper.method}", paper.torque, 1e2 * paper.rate, paper.friction) for paper in published]
    return (
        Table(
            f"output torque, compared with {first_paper.source}",
            ("", "output torque [N m]", "rate [%]", "friction"),
            (("this model", output_torque, 1e2 * output_torque / first_paper.ideal, "as designed"), *rows),
        ),
    )
