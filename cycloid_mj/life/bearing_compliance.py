"""What a cam carries over the give of its bearing: the softer it is, the more teeth carry, the less it bears."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from cycloid_mj.base.result import Table
from cycloid_mj.life.duration import hours, plain_life

IDEAL = "ideal sharing: a cam without give, no clearance, no friction"


@dataclass(frozen=True)
class Give:
    """A cam of one stiffness [N/m]: its name, the mean load on it [N], and the life of its bearing [h].

    The stiffness is None for ideal sharing, the load where there is no balance, the life where the cam has no rollers.
    """

    name: str
    stiffness: float | None
    load: float | None
    life: float | None

    def as_json(self) -> dict[str, Any]:
        """Convert it to JSON values; a life beyond what its law was fitted to is None."""
        return {
            "name": self.name,
            "cam_n_m": self.stiffness,
            "mean_load_n": self.load,
            "life_h": plain_life(self.life),
        }


@dataclass(frozen=True)
class CamGive:
    """Loads and lives from the softest cam to the stiffest, then by ideal sharing."""

    rows: tuple[Give, ...]

    @property
    def words(self) -> str:
        """The spread in a sentence."""
        loads = [row.load for row in self.rows if row.load is not None]
        lives = [row.life for row in self.rows if row.life is not None]
        lasts = f", its life {_between(lives)}" if lives else ""
        return (
            f"the cam's load is {min(loads):.4g} to {max(loads):.4g} N{lasts} over the stiffness that is assumed "
            "for it (stiffness.cam_n_m): where it gives, the gear moves aside and more teeth carry"
        )

    def as_json(self) -> list[dict[str, Any]]:
        """Convert the rows to JSON values."""
        return [row.as_json() for row in self.rows]

    def table(self) -> Table:
        """Tabulate the rows as text."""
        rows = tuple(
            (
                row.name,
                "" if row.stiffness is None else f"{row.stiffness:.3g} N/m",
                "no balance" if row.load is None else f"{row.load:.4g} N",
                "" if row.life is None else hours(row.life),
            )
            for row in self.rows
        )
        return Table("Load of the cam over the give of its bearing", ("cam", "stiffness", "mean load", "life"), rows)


def _between(lives: Sequence[float]) -> str:
    """Tell the least and the largest life, once where both are told alike."""
    least, most = hours(min(lives)), hours(max(lives))
    return least if least == most else f"{least} to {most}"
