"""Sensitivity of the dynamic figures of a loaded run to unmeasured assumptions of the contact model.

Friction comes on over a creep speed and contacts lose a share of critical damping; both are choices of the model. Each
is brought to the other end of its plausible range, and every figure that depends on the motion's detail says how far
it goes. What is stated holds for the designs, load and speed that were run, and for no others.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from cycloid_mj.base.result import Table
from cycloid_mj.comparison.table import DYNAMIC
from cycloid_mj.comparison.trial import Trial
from cycloid_mj.comparison.variation import Variation

ASSUMPTIONS = (
    Variation("creep speed", "20 mm/s", ("contact.creep_speed_mm_s=20.0",)),
    Variation("damping ratio", "0.1", ("contact.damping_ratio=0.1",)),
)
"""The other end of each range: the presets have 0.2 % of the speed of the gear's centre (0.34 mm/s) and 0.5."""

UNDETERMINED = 2.0
"""Factor between the smallest and the largest value from which on a figure is not determined by the design."""


@dataclass(frozen=True)
class SensitivityPoint:
    """What a figure becomes where one assumption has another value."""

    parameter: str
    value: str
    figure: float


@dataclass(frozen=True)
class Sensitivity:
    """How one figure of one run answers to each assumption; `figure` is its value as the design has them."""

    quantity: str
    unit: str
    design: str
    load_nm: float
    figure: float
    responses: tuple[SensitivityPoint, ...]

    @property
    def changes(self) -> tuple[float, ...]:
        """Relative change with each assumption; infinite where the figure is zero and becomes something else."""
        return tuple(_ratio(each.figure, self.figure) - 1.0 for each in self.responses)

    @property
    def determined(self) -> bool:
        """Whether the assumptions leave the figure its sign and its size within a factor `UNDETERMINED`."""
        ratios = [1.0, *(1.0 + change for change in self.changes)]
        return min(ratios) > 0.0 and max(ratios) / min(ratios) < UNDETERMINED


def sensitivities(base: Sequence[Trial], changed: Mapping[Variation, Sequence[Trial]]) -> list[Sensitivity]:
    """Hold each figure of runs against the same runs with one assumption changed, in the same order."""
    return [
        Sensitivity(
            quantity,
            unit,
            trial.name,
            trial.load,
            figure,
            tuple(
                SensitivityPoint(variation.parameter, variation.value, varied)
                for variation, others in changed.items()
                if (varied := measured(others[place].measures)) is not None
            ),
        )
        for quantity, unit, measured in DYNAMIC
        for place, trial in enumerate(base)
        if (figure := measured(trial.measures)) is not None
    ]


def sensitivity_table(sensitivities: Sequence[Sensitivity], condition: str) -> Table:
    """Tabulate the changes of each figure with each assumption, a column for each design, or "not determined"."""
    ends = " and ".join(each.words for each in ASSUMPTIONS)
    designs = list(dict.fromkeys(each.design for each in sensitivities))
    rows = []
    for quantity in dict.fromkeys(each.quantity for each in sensitivities):
        by_design = {each.design: each for each in sensitivities if each.quantity == quantity}
        rows.append((quantity, *(_words(by_design[name]) if name in by_design else "" for name in designs)))
    return Table(f"{condition}: change with {ends}", ("quantity", *designs), tuple(rows))


def _words(sensitivity: Sensitivity) -> str:
    if not sensitivity.determined:
        return "not determined: x " + ", ".join(f"{1.0 + change:.2g}" for change in sensitivity.changes)
    if sensitivity.unit == "%":
        return ", ".join(f"{each.figure - sensitivity.figure:+.2f} points" for each in sensitivity.responses)
    return ", ".join(f"{100.0 * change:+.0f} %" for change in sensitivity.changes)


def _ratio(value: float, base: float) -> float:
    if base == 0.0:
        return 1.0 if value == 0.0 else float("inf")
    return value / base
