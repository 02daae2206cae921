"""A hypothesis for the paper's stress, with evidence and without a verdict.

Stress without load is about a hundred times lower here than in the paper. This module runs the reducer with the default
contact of motion solvers, on exact flanks and on flanks made of facets.
"""

from collections.abc import Callable, Mapping
from typing import Any

from cycloid_mj.base.engine import each_in_threads
from cycloid_mj.base.result import Table
from cycloid_mj.design import PRESETS
from hsieh2014.plan import Plan, chord_errors, designs
from hsieh2014.soft_contact import GENERIC, STEEL, PeakForces, SoftContact, line_contacts, soft_idle
from hsieh2014.stated import HEIGHTS

SEED = 2014
TURNS = 1
EXACT = 0.0
"""Chord error of flanks without facets [m]."""

Case = tuple[str, SoftContact, float]
"""Name of the design, parameters of contact, chord error [m]."""


def soft_cases(plan: Plan) -> list[Case]:
    """List the cases: line contacts, and both defaults of motion solvers, at every chord error."""
    pairs = [(each, contact) for each in designs() for contact in (line_contacts(each), GENERIC, STEEL)]
    return [(each.name, contact, error) for error in chord_errors(plan) for each, contact in pairs]


def soft_runs(plan: Plan) -> dict[Case, PeakForces]:
    """Run every case."""
    cases = soft_cases(plan)
    forces = each_in_threads(lambda case: soft_idle(PRESETS[case[0]], case[1], case[2], TURNS, SEED), cases)
    return dict(zip(cases, forces, strict=True))


def needed(stress: Mapping[str, float], force: Mapping[str, float], design: str) -> dict[str, float]:
    """Compute the force [N] on each part that would cause the paper's stress of a design, in proportion to the force.

    `stress` [MPa] and `force` [N] are those of each part under one load, the largest.
    """
    return {part: HEIGHTS[part, design] * force[part] / stress[part] for part in force}


def stress_by_case(
    forces: Mapping[Case, PeakForces], stress: Mapping[str, Mapping[str, Callable[[float], Any]]]
) -> dict[tuple[str, str], dict[str, float]]:
    """Return the stress [MPa] for the forces of every case: by part and design, then by the case in words.

    `stress` has functions from the largest force on a part [N] to its stress, by design, then by part.
    """
    stresses: dict[tuple[str, str], dict[str, float]] = {}
    for (name, contact, error), peaks in forces.items():
        words = f"{contact.name}, facets of {1e6 * error:g} um" if error else f"{contact.name}, exact flanks"
        for part, force in acting(peaks).items():
            stresses.setdefault((part, name), {})[words] = float(stress[name][part](force))
    return stresses


def acting(forces: PeakForces) -> dict[str, float]:
    """Return the largest force on each part [N]."""
    return {"shaft": forces.cam, "ring": forces.seat, "gear": max(forces.cam, forces.tooth)}


def table(forces: Mapping[Case, PeakForces], wanted: Mapping[str, Mapping[str, float]]) -> Table:
    """Return the table of the forces of every case, and of the forces that would cause the paper's stress.

    The latter are `wanted` [N], by design, then by part.
    """
    rows: list[tuple[str | float, ...]] = [
        (f"{name}, {contact.name}", f"{1e6 * error:g}", f"{force.tooth:.3g}", f"{force.cam:.3g}", f"{force.output:.3g}")
        for (name, contact, error), force in forces.items()
    ]
    rows += [
        (
            f"{name}: forces for the paper's stress",
            "",
            f"{forces_of_parts['ring']:.3g}",
            f"{forces_of_parts['shaft']:.3g}",
            "",
        )
        for name, forces_of_parts in wanted.items()
    ]
    head = ("design, contact", "chord error [um]", "tooth [N]", "cam [N]", "output pin [N]")
    return Table("hypothesis: largest idle forces with the contact of a commercial motion solver", head, tuple(rows))


def sentences(loads: Mapping[Case, PeakForces], wanted: Mapping[str, Mapping[str, float]]) -> list[str]:
    """Return sentences on the forces of the cases, and on the forces that would cause the paper's stress.

    The latter are `wanted` [N], by design, then by part.
    """
    lines = []
    for name, forces in wanted.items():
        exact = loads[name, STEEL, EXACT]
        case = max((each for each in loads if each[0] == name), key=lambda each: loads[each].tooth)
        lines.append(
            f"{name}: soft springs on exact flanks give {exact.tooth:.3g} N at a tooth, {exact.cam:.3g} N at the cam; "
            f"with facets of {1e6 * case[2]:g} um chord error {loads[case].tooth:.3g} and {loads[case].cam:.3g} N. The "
            f"paper's heights would take {forces['ring']:.3g} and {forces['shaft']:.3g} N."
        )
    return [
        "Hypothesis, not a verdict: the paper's stresses are collision forces between surfaces made of facets. Its "
        "tolerance of 0.001 mm lies far below the chord error of a usual tessellation: facets press where exact "
        "flanks do not touch. Compare the forces with and without facets in the table.",
        *lines,
        "Evidence: the function IMPACT with the solver's defaults for steel (100 000 N/mm^1.5, damping 50 N s/mm at a "
        "depth of 0.1 mm) and for no material (exponent 2.2, damping 10); such a solver finds 3-D contacts on polygons "
        "by default. The paper states neither contact parameters nor its mesh, so none of this is judged.",
    ]


def as_json(forces: Mapping[Case, PeakForces], wanted: Mapping[str, Mapping[str, float]]) -> dict[str, Any]:
    """Convert the cases to JSON values; the arguments are those of `table`."""
    return {
        "status": "hypothesis",
        "cases": [
            {
                "design": name,
                "contact": contact.name,
                "stiffness_n_mm": contact.stiffness / 1e3**contact.exponent,
                "exponent": contact.exponent,
                "chord_error_um": 1e6 * error,
                "tooth_n": force.tooth,
                "seat_n": force.seat,
                "cam_n": force.cam,
                "output_pin_n": force.output,
                "cam_sampled_n": force.sampled,
            }
            for (name, contact, error), force in forces.items()
        ],
        "needed_for_the_papers_heights_n": {name: dict(forces_of_parts) for name, forces_of_parts in wanted.items()},
    }
