"""How far the dynamic figures of a loaded run move with what the contact model assumes and nobody has measured.

Friction comes on over a creep speed and contacts lose a share of critical damping; both are choices of the model. Each
is brought to the other end of its plausible range, and every figure that depends on the motion's detail says how far
it goes. What is stated holds for the designs, load and speed that were run, and for no others.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from cycloid_mj.comparison.measures import Measures
from cycloid_mj.comparison.sweep import Variation
from cycloid_mj.comparison.trial import Trial

ASSUMPTIONS = (
    Variation("creep speed", "1 mm/s", ("contact.creep_speed_mm_s=1.0",)),
    Variation("damping ratio", "0.1", ("contact.damping_ratio=0.1",)),
)
"""The other end of each range: the presets have 20 mm/s and 0.5."""

UNDETERMINED = 2.0
"""Factor between the smallest and the largest value from which on a figure is not determined by the design."""

Figure = Callable[[Measures], float | None]
FIGURES: tuple[tuple[str, str, Figure], ...] = (
    ("transmission error of the output, p-p", "arcsec", lambda m: m.findings.transmission_error.peak_to_peak_arcsec),
    ("output speed error, rms", "rad/s", lambda m: m.findings.output_speed.rms_error_rad_s),
    ("vibration of the output, rms acceleration", "rad/s^2", lambda m: m.vibration.output_rad_s2.rms),
    ("transmission error of the gear, p-p", "arcsec", lambda m: m.findings.gear_transmission_error.peak_to_peak_arcsec),
    ("gear speed error, rms", "rad/s", lambda m: m.fluctuation.gear_speed_rad_s.rms),
    ("vibration of the gear centre, rms acceleration", "m/s^2", lambda m: m.vibration.gear_centre_m_s2.rms),
    ("q path error, rms, without steady shifts", "um", lambda m: m.fluctuation.q_path_um.rms),
    ("q velocity error, rms, without steady shifts", "mm/s", lambda m: m.fluctuation.q_velocity_mm_s.rms),
    ("force on the most loaded tooth, peak", "N", lambda m: m.forces.tooth_peak_n),
    ("spin of pin 1, mean", "rad/s", lambda m: m.findings.pin1.mean_spin_rad_s if m.findings.pin1 else None),
    ("efficiency", "%", lambda m: None if m.findings.efficiency is None else 100.0 * m.findings.efficiency),
)


@dataclass(frozen=True)
class Response:
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
    responses: tuple[Response, ...]

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
                Response(variation.parameter, variation.value, found)
                for variation, others in changed.items()
                if (found := measured(others[place].measures)) is not None
            ),
        )
        for quantity, unit, measured in FIGURES
        for place, trial in enumerate(base)
        if (figure := measured(trial.measures)) is not None
    ]


def sensitivity_table(found: Sequence[Sensitivity]) -> tuple[list[str], list[list[str]]]:
    """Give header and rows: quantity, and for each design its changes with each assumption, or "not determined"."""
    designs = list(dict.fromkeys(each.design for each in found))
    rows = []
    for quantity in dict.fromkeys(each.quantity for each in found):
        by_design = {each.design: each for each in found if each.quantity == quantity}
        rows.append([quantity, *(_words(by_design[name]) if name in by_design else "" for name in designs)])
    return ["quantity", *designs], rows


def _words(found: Sensitivity) -> str:
    if not found.determined:
        return "not determined: x " + ", ".join(f"{1.0 + change:.2g}" for change in found.changes)
    if found.unit == "%":
        return ", ".join(f"{each.figure - found.figure:+.2f} points" for each in found.responses)
    return ", ".join(f"{100.0 * change:+.0f} %" for change in found.changes)


def _ratio(value: float, base: float) -> float:
    if base == 0.0:
        return 1.0 if value == 0.0 else float("inf")
    return value / base
