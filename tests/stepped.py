"""One step of a model, and what a sample of a run would tell of it."""

from collections.abc import Sequence
from typing import Any, NamedTuple

from cycloid_mj.base.array import Array
from cycloid_mj.dynamics.contact import each_step
from cycloid_mj.dynamics.contact.each_step import EachStep
from cycloid_mj.dynamics.contact.forces import pair_index
from cycloid_mj.dynamics.contact.sample_layout import OF_PAIR


class Stepped(NamedTuple):
    """Of each pair force x, y [N] and moment [N m], shape (pairs, 3), and powers [W]; the deepest penetration [m]."""

    wrench: Array
    friction_power: Array
    normal_power: Array
    penetration: float


def stepped(model: Any, data: Any, pairs: Sequence[Any]) -> Stepped:
    """Take a step, under the collider that is installed; what it gives is of the step's start."""
    run = EachStep(model, data, pair_index(model, pairs))
    with each_step.install():
        row = run.advance(1)[0]
    data.userdata[0] = 0.0
    table = row[run.pairs].reshape(-1, OF_PAIR)
    return Stepped(table[:, :3], table[:, 4], table[:, 5], row[run.solver][1])
