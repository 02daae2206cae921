"""Runs with the contact that the authors may have used: that of a motion solver, and flanks made of facets.

The two changes are the contact law and the facets. Each feature of the paper's figures is evaluated with both changes,
with each alone and with none, by a planar solver that supports both (`soft_contact`).
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cycloid_mj.analysis import Series
from cycloid_mj.base.array import Array
from cycloid_mj.base.engine import each_in_threads
from cycloid_mj.base.names import CAM, SOLVERS
from cycloid_mj.base.result import Table
from cycloid_mj.comparison import StartSpread, settle_run
from cycloid_mj.design import Design
from cycloid_mj.dynamics.massless import massless
from cycloid_mj.measure.brake_test import run_brake_test
from cycloid_mj.measure.steady import averaging_periods, steady_design
from cycloid_mj.reducer import Reducer
from hsieh2014.hypothesis import acting
from hsieh2014.idle_stress import idle_stress
from hsieh2014.motion import at_degrees
from hsieh2014.peaks import by_angle, largest_of_halves, maxima
from hsieh2014.pin_claims import GIVE
from hsieh2014.plan import IMPACT, Plan, designs, idle_runs, rated_runs, varied_idle_runs
from hsieh2014.soft_contact import GENERIC, PeakForces, line_contacts, soft_idle
from hsieh2014.stage import PaperFigure, Progress, Runs, StageResult
from hsieh2014.stated import HEIGHTS, IDEAL, LEAST, MOST, NEAR, SHAFT_PEAKS, TORQUES
from hsieh2014.stress import height_plates, settings
from hsieh2014.stress_patterns import angles_in_words
from hsieh2014.torque import NEAR as TORQUE_NEAR
from hsieh2014.verdicts import chance, rank_order

SEED, TURNS, CHORD_ERROR = 2014, 1, 50e-6
"""Random seed of the facets, crank turns, and chord error of the facets [m], as was usual for meshes in 2014
(heuristic)."""

PHASES = (0.0, 1.3, 2.5, 3.8, 5.0)
"""Crank angles of the starts [rad]."""


OURS, SOFT, FACETS, BOTH = "neither", "soft contact alone", "facets alone", "both"
CHANGES = (OURS, SOFT, FACETS, BOTH)
NO_GRAVITY, STIFFER, SOFTER = "soft, no gravity", "soft, 10 times stiffer", "soft, 10 times softer"


Cases = Mapping[str, Mapping[str, Sequence[PeakForces]]]
"""Name of a case -> name of a design -> forces of each start."""


@dataclass(frozen=True)
class Feature:
    """A feature of the paper's figures: figure, description, and functions that evaluate forces of pin and nonpin."""

    figure: str
    words: str
    tell: Callable[[Mapping[str, Sequence[PeakForces]]], str]
    holds: Callable[[Mapping[str, Sequence[PeakForces]]], bool]


def authors(plan: Plan, runs: Runs, progress: Progress) -> StageResult:
    """Compare our contacts with those that the authors may have used: contact law IMPACT, and flanks of facets.

    The result has the paper's figures with both contact laws, and tables of which change causes which feature.
    """
    progress("planar runs with and without soft contact and facets")
    cases = planar_runs()
    progress("runs with IMPACT")
    base = {design.name: settle_run(runs(idle_runs(plan, design), plan.solver)[0]) for design in designs()}
    struck = {each.name: runs(varied_idle_runs(plan, IMPACT, each), plan.solver) for each in designs()}
    soft = {name: settle_run(starts[0]) for name, starts in struck.items()}
    progress("output torque with IMPACT")
    torques = {each.name: (_settled_torque(each), _settled_torque(IMPACT.of(Reducer(each)))) for each in designs()}
    rated = {run.provenance["design"]: run for run in runs(rated_runs(plan))}
    peaks = [largest_of_halves(by_angle(run, [CAM])) for run in struck[designs()[0].name]]
    stresses = {}
    for design in designs():
        progress(f"stress, {design.name}")
        start, name = runs(idle_runs(plan, design)[:1], plan.solver), design.name
        stresses[name] = idle_stress(start, rated[name], settings(plan), struck[name][0])
    solver_words = SOLVERS[plan.solver]
    features = _features({name: stress.by_force for name, stress in stresses.items()})
    return StageResult(
        (*_plates(base, soft, cases), *height_plates(stresses), _torque_plate(torques)),
        (*_feature_tables(cases, features), _torque_table(torques)),
        findings={
            "features": [_as_json(cases, feature) for feature in features],
            "shaft_peaks_deg": [list(pair) for pair in peaks],
            "output_torque_nm": {name: {"line": line, "impact": impact} for name, (line, impact) in torques.items()},
        },
        notes=(
            f"With friction, {solver_words}, the cam's force of the pin design has its maxima of the two half turns at "
            f"{angles_in_words(peaks)} (75 and 255 deg, within {NEAR:g}).",
            "IMPACT: F = k d^e + c step(d) v with k = 1e5 N/mm^2.2, c = 10 N s/mm, fully active from 0.1 mm on: the "
            "default of motion solvers such as ADAMS and SolidWorks Motion without a material. The paper states no "
            "contact parameters; this is a hypothesis with its evidence.",
            f'Gear speed, q and pin 1 are runs with contact.law = "impact" {solver_words}, the torque by MuJoCo. All '
            "have friction. The table of features is from a planar computation without friction over "
            f"{len(PHASES)} starts each, with facets (mean chord error {1e6 * CHORD_ERROR:g} um, seed {SEED}). It "
            "includes only the arcs of the internal gear. A rank test judges which design fluctuates more. The "
            "torque, which depends on friction, has no facets.",
        ),
    )


def planar_runs() -> dict[str, dict[str, list[PeakForces]]]:
    """Run both designs with every combination of the two changes, and with variations of the soft contact.

    Returns the forces of the starts at `PHASES`, by name of the case and name of the design.
    """
    wanted: list[tuple[str, Design, Any, float, float]] = []
    for design in designs():
        line, stiff = line_contacts(design), GENERIC.stiffness
        floating = design.but(environment={"gravity_x": 0.0, "gravity_y": 0.0})
        cases = (
            (OURS, design, line, 0.0),
            (SOFT, design, GENERIC, 0.0),
            (FACETS, design, line, CHORD_ERROR),
            (BOTH, design, GENERIC, CHORD_ERROR),
            (NO_GRAVITY, floating, GENERIC, 0.0),
            (STIFFER, design, replace(GENERIC, stiffness=10.0 * stiff), 0.0),
            (SOFTER, design, replace(GENERIC, stiffness=0.1 * stiff), 0.0),
        )
        wanted += [(*case, phase) for case in cases for phase in PHASES]
    peaks = each_in_threads(lambda run: soft_idle(run[1], run[2], run[3], TURNS, SEED, run[4]), wanted)
    by_case: dict[str, dict[str, list[PeakForces]]] = {}
    for (name, design, *_), forces in zip(wanted, peaks, strict=True):
        by_case.setdefault(name, {}).setdefault(design.name, []).append(forces)
    return by_case


def brought_by(holds: Mapping[str, bool]) -> str:
    """Return in words which change causes a feature; `holds` states for each case of `CHANGES` whether it shows it."""
    if holds[OURS]:
        return "neither: ours has it" + ("" if holds[BOTH] else "; both together remove it")
    alone = [name for name in (SOFT, FACETS) if holds[name]]
    if holds[BOTH]:
        return " or ".join(alone) if alone else "both together, neither alone"
    return f"{' or '.join(alone)}; the other change removes it" if alone else "neither, nor both"


def mean_curve(forces: Sequence[PeakForces]) -> Any:
    """Average the cam's force over the starts, shape (``peaks.BINS``,) [N]."""
    return np.mean([force.curve for force in forces], axis=0)


def _features(stress: Mapping[str, Mapping[str, Callable[[float], Any]]]) -> list[Feature]:
    """List the evaluated features; `stress` maps the largest force on a design's part [N] to its stress [MPa]."""
    two = "pin: two maxima of the cam's force a turn, near 75 and 255 deg"
    features = [
        Feature("Fig. 12", two, _maxima_function("pin"), _has_two_peaks),
        Feature("Fig. 12", "nonpin: more and flatter maxima than pin", _maxima_function("nonpin"), _has_flatter_maxima),
        Feature("Fig. 6", "the gear's speed fluctuates more with pins", *_fluctuation_functions("rms", 1.0, "rad/s")),
        Feature("Fig. 8", "the velocity of q fluctuates more with pins", *_fluctuation_functions("q_rms", 1e3, "mm/s")),
        Feature("Fig. 9", "pins stay within their clearance, 1 um", _describe_reach, _stays_in_clearance),
    ]
    for figure, part in (("Fig. 12", "shaft"), ("Fig. 14", "ring"), ("Fig. 13", "gear")):
        for name in ("pin", "nonpin"):
            words = f"{name}: the {part} stressed as high as in the paper"
            features.append(Feature(figure, words, *_stress_functions(part, name, stress[name][part])))
    return features


def _maxima_function(name: str) -> Callable[[Mapping[str, Sequence[PeakForces]]], str]:
    def tell(forces: Mapping[str, Sequence[PeakForces]]) -> str:
        curve = mean_curve(forces[name])
        angles = ", ".join(f"{angle:.0f}" for angle in maxima(curve))
        return f"{angles} deg, swing {np.ptp(curve) / np.mean(curve):.1f} of the mean"

    return tell


def _has_two_peaks(forces: Mapping[str, Sequence[PeakForces]]) -> bool:
    angles = maxima(mean_curve(forces["pin"]))
    return len(angles) == len(SHAFT_PEAKS) and all(
        abs(angle - wanted) <= NEAR for angle, wanted in zip(angles, SHAFT_PEAKS, strict=True)
    )


def _has_flatter_maxima(forces: Mapping[str, Sequence[PeakForces]]) -> bool:
    pin, nonpin = (mean_curve(forces[name]) for name in ("pin", "nonpin"))
    flatter = np.ptp(nonpin) / np.mean(nonpin) < np.ptp(pin) / np.mean(pin)
    return bool(flatter) and len(maxima(nonpin)) > len(maxima(pin))


def _fluctuation_functions(field: str, scale: float, unit: str) -> tuple[Any, Any]:
    """Return two functions of the forces of both designs: their fluctuation in words, and whether pin fluctuates more.

    `field` is the attribute of `PeakForces` that measures the fluctuation, `scale` the factor to the `unit` of the
    text. A rank test decides the second function.
    """

    def sizes(forces: Mapping[str, Sequence[PeakForces]]) -> tuple[StartSpread, StartSpread]:
        pin, nonpin = (
            StartSpread.of(scale * getattr(peaks, field) for peaks in forces[name]) for name in ("pin", "nonpin")
        )
        return pin, nonpin

    def tell(forces: Mapping[str, Sequence[PeakForces]]) -> str:
        pin, nonpin = sizes(forces)
        return f"{pin.words} against {nonpin.words} {unit}, p = {chance(pin, nonpin):.2g}"

    return tell, lambda forces: rank_order(*sizes(forces)) > 0


def _describe_reach(forces: Mapping[str, Sequence[PeakForces]]) -> str:
    reaches = StartSpread.of(1e6 * peaks.reach for peaks in forces["pin"])
    return f"{reaches.words} um"


def _stays_in_clearance(forces: Mapping[str, Sequence[PeakForces]]) -> bool:
    clearance = designs()[0].clearance.pin_socket
    return all(peaks.reach <= (1.0 + GIVE) * clearance for peaks in forces["pin"])


def _stress_functions(part: str, name: str, stress: Callable[[float], Any]) -> tuple[Any, Any]:
    """Return two functions of the forces of both designs: a part's stress in words, and whether it is the paper's.

    `stress` maps the largest force on the part [N] to its stress [MPa]; the functions use the mean of the starts.
    `name` is the design.
    """

    def size(forces: Mapping[str, Sequence[PeakForces]]) -> float:
        return float(np.mean([stress(acting(peaks)[part]) for peaks in forces[name]]))

    wanted = HEIGHTS[part, name]
    return (
        lambda forces: f"{float(f'{size(forces):.3g}'):g} MPa",
        lambda forces: LEAST * wanted <= size(forces) <= MOST * wanted,
    )


def _feature_tables(cases: Cases, features: Sequence[Feature]) -> tuple[Table, Table]:
    """Return the tables of the features: for each combination of the changes, and for variations of soft contact."""
    brought = {feature: brought_by({name: feature.holds(cases[name]) for name in CHANGES}) for feature in features}

    def rows(names: Sequence[str]) -> list[tuple[str, ...]]:
        """Return a row for each feature, with the result of each of some cases."""
        return [
            (
                f"{feature.figure}, {feature.words}",
                *(f"{'yes' if feature.holds(cases[name]) else 'no'}: {feature.tell(cases[name])}" for name in names),
            )
            for feature in features
        ]

    changed = [(*row, brought[feature]) for row, feature in zip(rows(CHANGES), features, strict=True)]
    first, varied = "feature of the paper: shown or not, and result", (SOFT, NO_GRAVITY, STIFFER, SOFTER)
    head = (first, "ours (neither change)", *CHANGES[1:], "brought by")
    return (
        Table("causes of the paper's features: the two changes, alone and together", head, tuple(changed), range(6)),
        Table("the same with the soft contact varied", (first, *varied), tuple(rows(varied)), range(5)),
    )


def _as_json(cases: Cases, feature: Feature) -> dict[str, Any]:
    """Convert a feature to JSON values: which change causes it, and the result of each case."""
    return {
        "figure": feature.figure,
        "feature": feature.words,
        "brought_by": brought_by({name: feature.holds(cases[name]) for name in CHANGES}),
        "cases": {
            name: {"found": feature.tell(forces), "holds": feature.holds(forces)} for name, forces in cases.items()
        },
    }


def _torque_table(torques: Mapping[str, tuple[float, float]]) -> Table:
    """Return the table of output torques with both contact laws, the paper's torques, and which law causes them.

    `torques` are those of each design with line contacts and with IMPACT [N m].
    """
    rows = []
    for name, both in torques.items():
        cells = [f"{torque:.2f}, {100 * torque / IDEAL:.1f} %" for torque in both]
        for kind, paper in TORQUES[name].items():
            stated = f"{paper:g}, {100 * paper / IDEAL:.1f} %"
            rows.append((f"{name}, {kind}", *cells, stated, torque_brought_by(*both, paper)))
    head = ("output torque at 1.048 N m on the crank [N m]", "line contacts", "IMPACT", "the paper", "brought by")
    return Table("output torque by both contact laws, friction as designed, exact flanks", head, tuple(rows))


def torque_brought_by(line: float, impact: float, paper: float) -> str:
    """Return which contact law produces a torque of the paper [N m]."""
    by_line, by_impact = (abs(torque - paper) <= TORQUE_NEAR * IDEAL for torque in (line, impact))
    if by_line:
        return "neither: ours has it" + ("" if by_impact else "; IMPACT removes it")
    return SOFT if by_impact else "neither: friction decides it (claims on Fig. 19)"


def _torque_plate(torques: Mapping[str, tuple[float, float]]) -> PaperFigure:
    """Draw the output torque of both designs with line contacts and with IMPACT [N m], next to the paper's."""
    from hsieh2014.paper_figures import torques_figure

    computed = {name: dict(zip(("line contacts", "IMPACT"), both, strict=True)) for name, both in torques.items()}
    stated = {name: {f"the paper, {kind}": torque for kind, torque in TORQUES[name].items()} for name in torques}
    words = "Output torque at 1.048 N m on the crank by both contact laws; dashed: without losses."
    return PaperFigure("authors_fig19_torque", "Fig. 19", words, torques_figure(computed, stated, IDEAL))


def _settled_torque(design: Design) -> float:
    return float(torques_by_turn(design)[-1])


def torques_by_turn(design: Design, turns: int = 7) -> Array:
    """Compute the mean output torque in each crank turn of the torque test [N m], shape (turns,); the last is settled.

    The damping of soft contacts delays the output torque by some turns, far more than that of line contacts. Over the
    last two of seven turns it is constant within 0.1 %.
    """
    steady = massless(steady_design(Reducer(design)).working_at(design.rated_torque))
    run = run_brake_test(steady, design.drive.torque, averaging_periods(steady, turns * design.ring.teeth))
    return np.array([abs(float(np.mean(part))) for part in np.array_split(run["load_torque"], turns)])


def _plates(base: Mapping[str, Series], soft: Mapping[str, Series], cases: Cases) -> Iterator[PaperFigure]:
    """Yield Figs 6, 8 and 9 with each contact law, and a figure of the cam's force over a turn.

    `base` and `soft` are the runs by design with line contacts and with IMPACT, `cases` the planar runs.
    """
    from cycloid_mj.plots.pin import pin_figure
    from hsieh2014.paper_figures import cam_figure, speeds_figure, velocities_figure

    def pin_1(motions: Sequence[Series]) -> Any:
        first, _ = motions
        assert first.pin_1 is not None
        return pin_figure(first, first.pin_1)

    laws = {
        law: [at_degrees(motion) for motion in motions.values()]
        for law, motions in (("line contacts", base), ("IMPACT", soft))
    }
    drawn: tuple[tuple[int, str, Callable[[Sequence[Series]], Any]], ...] = (
        (6, "speed of the gear", speeds_figure),
        (8, "velocity of q, and its error", velocities_figure),
        (9, "pin 1", pin_1),
    )
    for number, words, draw in drawn:
        for law, motions in laws.items():
            name = f"authors_fig{number}_{law.partition(' ')[0].lower()}"
            yield PaperFigure(name, f"Fig. {number}", f"No load, {law}: {words}.", draw(motions))
    curves = {
        f"{design}, {name}": mean_curve(cases[name][design]) for design in base for name in (OURS, SOFT, NO_GRAVITY)
    }
    words = "Largest force of the cam over a crank turn, mean of the starts; dotted: the paper's peaks."
    yield PaperFigure("authors_fig12_cam", "Fig. 12", words, cam_figure(curves, SHAFT_PEAKS))
