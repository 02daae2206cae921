"""Cam load over the stiffness of its bearing: with a softer cam more teeth carry, and the cam carries less."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from cycloid_mj.base.result import Table
from cycloid_mj.life.duration import finite_life, format_life

IDEAL = "ideal sharing: rigid cam, no clearance, no friction"


@dataclass(frozen=True)
class CamCase:
    """A cam of one stiffness.

    Attributes
    ----------
    name
        The stiffness in words.
    stiffness
        Stiffness of the cam [N/m]; None for ideal sharing.
    load
        Equivalent load [N]; None if no equilibrium was found.
    life
        Life of its bearing [h]; None of a plain cam.
    """

    name: str
    stiffness: float | None
    load: float | None
    life: float | None

    def as_json(self) -> dict[str, Any]:
        """Convert equivalent load [N] and life [h] of a cam bearing for an assumed radial stiffness to JSON.

        Keys are ``name``, ``cam_n_m`` (stiffness [N/m]), ``mean_load_n`` (equivalent load) and ``life_h``. An unlimited
        life is None.
        """
        return {
            "name": self.name,
            "cam_n_m": self.stiffness,
            "mean_load_n": self.load,
            "life_h": finite_life(self.life),
        }


@dataclass(frozen=True)
class CamCompliance:
    """Cam loads and lives from the softest to the stiffest cam, and by ideal sharing."""

    rows: tuple[CamCase, ...]

    @property
    def words(self) -> str:
        """Return a sentence with the range of loads [N] and lives [h] of the cam bearing over its assumed stiffness."""
        loads = [row.load for row in self.rows if row.load is not None]
        lives = [row.life for row in self.rows if row.life is not None]
        life_text = f", its life {_range_text(lives)}" if lives else ""
        return (
            f"cam load: {min(loads):.4g} to {max(loads):.4g} N{life_text}, over the range of its assumed stiffness "
            "(stiffness.cam_n_m): with a softer cam, the disc moves sideways and more teeth carry load"
        )

    def as_json(self) -> list[dict[str, Any]]:
        """Convert the cases to JSON values, a dict each (`CamCase.as_json`)."""
        return [row.as_json() for row in self.rows]

    def table(self) -> Table:
        """Return a table of load [N] and life [h] of the cam bearing, with a row for each radial stiffness [N/m]."""
        rows = tuple(
            (
                row.name,
                "" if row.stiffness is None else f"{row.stiffness:.3g} N/m",
                "no equilibrium" if row.load is None else f"{row.load:.4g} N",
                "" if row.life is None else format_life(row.life),
            )
            for row in self.rows
        )
        return Table(
            "Cam load over the stiffness of its bearing", ("cam", "stiffness", "equivalent load", "life"), rows
        )


def _range_text(lives: Sequence[float]) -> str:
    """Format the shortest and the longest life [h], once if both have the same text."""
    shortest, longest = format_life(min(lives)), format_life(max(lives))
    return shortest if shortest == longest else f"{shortest} to {longest}"
