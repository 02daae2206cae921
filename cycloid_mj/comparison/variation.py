"""Variations of all designs of a comparison: contact damping, friction and the pins' freedom, one at a time."""

from dataclasses import dataclass

from cycloid_mj.design import Design, override
from cycloid_mj.reducer import Reducer


@dataclass(frozen=True)
class Variation:
    """A value of a parameter that is varied for all designs; `changes` are as for ``--set``."""

    parameter: str
    value: str
    changes: tuple[str, ...]
    pins_only: bool = False

    @property
    def words(self) -> str:
        """Parameter and value, the name of the case in tables."""
        return f"{self.parameter} {self.value}"

    def of(self, reducer: Reducer) -> Design:
        """Return the design with the changes, or unchanged where they do not apply to it."""
        design = reducer.design
        return design if self.pins_only and design.ring.kind != "pin" else override(design, self.changes)


TOOTH_PAIRS = ("pin_gear", "pin_socket", "pin_sleeve", "tooth")
SWEEP = (
    *(Variation("damping", value, (f"contact.damping_ratio={value}",)) for value in ("0.1", "1.0")),
    *(
        Variation("friction", value, tuple(f"friction.{pair}={value}" for pair in TOOTH_PAIRS))
        for value in ("0.0", "0.1")
    ),
    Variation("pins", "fixed", ('ring.pins="fixed"',), pins_only=True),
)
"""Contact damping ratio (0.5 in the presets), friction of teeth and sockets (0.05) and the pins' freedom."""
