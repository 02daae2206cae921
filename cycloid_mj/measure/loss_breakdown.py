"""Breakdown of an efficiency into the losses of teeth, bearings or planets, seals and damping."""

from collections.abc import Sequence
from typing import Any

from cycloid_mj.base.names import CRANK_BEARING, DRAGS, PLANET_MESH
from cycloid_mj.base.powers import Powers
from cycloid_mj.base.result import Table
from cycloid_mj.measure.published import Published

TEETH = ("pin_gear", "pin_socket", "pin_sleeve", "tooth")
STAGES = {"cam": "cam", "output": "output", CRANK_BEARING: "crank bearings", PLANET_MESH: "planets"}
"""Further kinds of pairs, and the parts that they belong to."""
DAMPING = "damping of all contacts"
NOTES = {
    "seals": "drag.crank_nm, drag.output_nm",
    DAMPING: "including elastic energy that time step and window leave open",
}


def loss_shares(powers: Powers) -> dict[str, float]:
    """Compute the loss of each part as a share of the input power [1], and the damping of all contacts."""
    stages = {part: (kind,) for kind, part in STAGES.items() if kind in powers.friction}
    parts = {"teeth": TEETH, **stages, "seals": tuple(DRAGS)}
    friction = {part: sum(powers.friction.get(kind, 0.0) for kind in kinds) for part, kinds in parts.items()}
    losses = {**friction, DAMPING: sum(powers.normal.values())}
    return {part: power / powers.supplied for part, power in losses.items()}


def table(powers: Powers, published: Sequence[Published], error: float) -> Table:
    """Return a table of the losses of a torque test in percent of the input power, and of published output rates.

    There is a row for each part with losses, for the efficiency, and for each published rate. The output rate is the
    output torque over that without losses. A published rate has a note with the friction coefficient at which the model
    has this rate. `powers` are the mean powers of the run [W], `error` is the numerical error of the efficiency [1].
    """
    remaining_share, rows = 1.0, []
    for part, share in loss_shares(powers).items():
        remaining_share -= share
        rows.append((part, 1e2 * share, 1e2 * remaining_share, NOTES.get(part, "")))
    rows.append(
        ("efficiency", 1e2 * (1.0 - powers.efficiency), 1e2 * powers.efficiency, f"numerical error {1e2 * error:.2g}")
    )
    for paper in published:
        friction_text = f"{paper.friction:.3f}" if paper.friction == paper.friction else "outside of the range run"
        rows.append(
            (
                f"the paper, {paper.method}",
                1e2 * (1.0 - paper.rate),
                1e2 * paper.rate,
                f"friction of the teeth: {friction_text}",
            )
        )
    return Table("losses, in % of the input power", ("part", "loss", "remainder", "note"), tuple(rows))


def as_json(powers: Powers, published: Sequence[Published]) -> dict[str, Any]:
    """Convert the losses of a torque test to JSON values under the key ``build_up``.

    `powers` are the mean powers of the run [W]. ``losses`` are shares of the input power by part, ``efficiency`` is the
    efficiency of the run [1]. ``paper`` has the published output rates [1], and the friction coefficient of the teeth
    at which the model has the same rate, or None.
    """
    by_method = {
        paper.method: {
            "rate": paper.rate,
            "friction_of_teeth": paper.friction if paper.friction == paper.friction else None,
        }
        for paper in published
    }
    return {"build_up": {"losses": loss_shares(powers), "efficiency": powers.efficiency, "paper": by_method}}
