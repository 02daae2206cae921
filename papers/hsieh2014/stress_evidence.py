"""Evidence for the claims on stress: computed stress, forces of every start, and searched variations."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.result import Range
from cycloid_mj.comparison import StartSpread, Variation
from hsieh2014.idle_stress import IdleStress
from hsieh2014.run_figures import RunFigures

Forces = Mapping[str, Sequence[Mapping[str, Array]]]
"""Design name -> start by start, part -> the largest force on it in each part of a crank turn [N]."""


@dataclass(frozen=True, eq=False)
class Searched:
    """Variations that were searched for the claims on stress."""

    ranges: tuple[Range, ...] = ()
    """Searched ranges of what the paper leaves open."""
    varied: Mapping[Variation, Mapping[str, Sequence[RunFigures]]] = field(default_factory=dict)
    """Single change -> design name -> its starts without load."""
    reached: Mapping[tuple[str, str], Mapping[str, float]] = field(default_factory=dict)
    """Part and design -> treatment of contact -> stress [MPa] from its forces."""
    contact_ranges: tuple[Range, ...] = ()
    """Searched ranges of these treatments."""


@dataclass(frozen=True, eq=False)
class Evidence:
    """Computed stress of both designs, and the forces of all runs for estimates where it was not computed."""

    stress: Mapping[str, IdleStress]
    forces: Forces
    varied: Mapping[Variation, Forces]

    def curves(self, design: str, part: str, changed: Variation | None = None) -> list[Array]:
        """Compute the largest force on a design's part in each part of a crank turn, start by start [N]."""
        runs = self.forces if changed is None else self.varied[changed]
        return [start[part] for start in runs[design]]

    def sizes(
        self, design: str, part: str, property_of: Callable[[Array], float], changed: Variation | None = None
    ) -> StartSpread:
        """Compute a quantity of the stress curve of a design's part over a turn, in each start [MPa].

        `property_of` computes it from the curve, `changed` is a variation; None for the design itself.
        """
        stress = self.stress[design].by_force[part]
        return StartSpread.of(property_of(stress(curve)) for curve in self.curves(design, part, changed))

    def peaks(self, design: str, part: str, changed: Variation | None = None) -> StartSpread:
        """Return the largest stress [MPa] of a design's part in each start, computed or estimated from the forces."""
        if changed is None:
            return self.stress[design].starts[part]
        return self.sizes(design, part, np.max, changed)


def forces_of(starts: Mapping[str, Sequence[RunFigures]]) -> Forces:
    """Return the force on every part over a crank turn, in every start."""
    return {name: [figures.forces for figures in each] for name, each in starts.items()}
