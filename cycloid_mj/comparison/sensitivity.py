"""Sensitivity of the dynamic figures of a loaded run to assumptions of the contact model that are not measured.

Friction rises over a creep speed, and contacts have a damping ratio; both are choices of the model. Each is set to the
other end of its plausible range, and the change of each figure that depends on the details of the motion is reported.
It applies to the designs, load and speed of the runs only.
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
"""Ratio of the largest to the smallest value from which a figure counts as not determined by the design (heuristic)."""


@dataclass(frozen=True)
class SensitivityPoint:
    """Value of a figure with another value of one assumption."""

    parameter: str
    value: str
    figure: float


@dataclass(frozen=True)
class Sensitivity:
    """Values of a quantity of a run with other assumptions; `figure` is its value with those of the design."""

    quantity: str
    unit: str
    design: str
    load_nm: float
    figure: float
    responses: tuple[SensitivityPoint, ...]

    @property
    def changes(self) -> tuple[float, ...]:
        """Relative change with each assumption; infinite where the quantity is zero and changes."""
        return tuple(_ratio(each.figure, self.figure) - 1.0 for each in self.responses)

    @property
    def is_determined(self) -> bool:
        """True if the sign of the quantity is certain, and its magnitude within a factor `UNDETERMINED`."""
        ratios = [1.0, *(1.0 + change for change in self.changes)]
        return min(ratios) > 0.0 and max(ratios) / min(ratios) < UNDETERMINED


def sensitivities(reference: Sequence[Trial], varied_trials: Mapping[Variation, Sequence[Trial]]) -> list[Sensitivity]:
    """Return the values of each dynamic quantity of loaded runs, with and without a change of each assumption.

    The result has one `Sensitivity` for each quantity and each run in `reference`. `varied_trials` has, for each
    changed assumption, the runs of `reference` in the same order, repeated with this change. A quantity without a value
    in the reference run is omitted; so are changed runs without a value of it.
    """
    return [
        Sensitivity(
            quantity,
            unit,
            trial.name,
            trial.load,
            figure,
            tuple(
                SensitivityPoint(variation.parameter, variation.value, varied_figure)
                for variation, trials in varied_trials.items()
                if (varied_figure := read_measure(trials[index].measures)) is not None
            ),
        )
        for quantity, unit, read_measure in DYNAMIC
        for index, trial in enumerate(reference)
        if (figure := read_measure(trial.measures)) is not None
    ]


def sensitivity_table(sensitivities: Sequence[Sensitivity], condition: str) -> Table:
    """Return a table of how much each quantity changes with the assumptions: a row per quantity, a column per design.

    A cell has the changes with each of `ASSUMPTIONS`, in this order. They are relative [%], or in points for quantities
    in %. A cell is "not determined" where `Sensitivity.is_determined` is False. `condition` is part of the title. If a
    design has several loads, its column has the changes under the last.
    """
    assumptions = " and ".join(entry.words for entry in ASSUMPTIONS)
    designs = list(dict.fromkeys(entry.design for entry in sensitivities))
    rows = []
    for quantity in dict.fromkeys(entry.quantity for entry in sensitivities):
        by_design = {entry.design: entry for entry in sensitivities if entry.quantity == quantity}
        rows.append((quantity, *(_words(by_design[name]) if name in by_design else "" for name in designs)))
    return Table(f"{condition}: change with {assumptions}", ("quantity", *designs), tuple(rows))


def _words(sensitivity: Sensitivity) -> str:
    if not sensitivity.is_determined:
        return "not determined: x " + ", ".join(f"{1.0 + change:.2g}" for change in sensitivity.changes)
    if sensitivity.unit == "%":
        return ", ".join(f"{each.figure - sensitivity.figure:+.2f} points" for each in sensitivity.responses)
    return ", ".join(f"{100.0 * change:+.0f} %" for change in sensitivity.changes)


def _ratio(value: float, base: float) -> float:
    if base == 0.0:
        return 1.0 if value == 0.0 else float("inf")
    return value / base
