"""Outcome of ``cycloid-mj stress``: figures, stress maps for ParaView, tables."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from heapq import nsmallest
from typing import TYPE_CHECKING, Literal, get_args

from cycloid_mj.base.outcome import MOST_FIGURES, Outcome, Picture
from cycloid_mj.base.result import Table
from cycloid_mj.base.units import MEGAPASCAL
from cycloid_mj.cli.delivery import Destination
from cycloid_mj.cli.terminal import with_warnings
from cycloid_mj.papers import stress_claims

if TYPE_CHECKING:
    from cycloid_mj.base.result import Claim
    from cycloid_mj.stress.findings import StressFindings
    from cycloid_mj.stress.study import StressStudy

STEM = "stress"
FILES = (f"{STEM}.json", f"{STEM}.csv")
Drawn = Literal["grid", "map", "turn", "refinement"]
FIGURES: tuple[Drawn, ...] = get_args(Drawn)
CLAIM_HEADER = ("figure", "the paper", "found here", "verdict")
COLUMNS = (
    *("design", "part", "bulk_mpa", "bulk_angle_deg", "contact_mpa", "contact_angle_deg", "governing_mpa"),
    *("safety_against_yield", "safety_against_shakedown", "refinement_change"),
)
"""Columns of the CSV file."""


def outcome_of(studies: "Sequence[StressStudy]", destination: Destination, figures: Sequence[Drawn] = ()) -> Outcome:
    """Convert stress studies to printable results: tables, VTU files, verdicts on the claims of papers, and figures.

    Parts whose stress exceeds the yield strength are failures. Parts that exceed the shakedown limit, or whose stress
    has not converged with the grid, are warnings. `figures` are the kinds of diagrams to draw, and `destination` has
    the paths of the output files.
    """
    from cycloid_mj.base.frame import make_frame
    from cycloid_mj.figures import values_json
    from cycloid_mj.stress.figures import study_quantities
    from cycloid_mj.stress.findings import MAX_CHANGE

    findings = [study.findings for study in studies]
    verdicts = stress_claims(studies)
    pictures, maps = _figure_encoders(studies, figures), _maps(studies)
    picture_files = [f"{name}.{file_format}" for name in pictures for file_format in Outcome.formats]
    return Outcome(
        title="largest von Mises stress of a crank turn",
        condition=", ".join(f"{stresses.design} under {stresses.load:g} N m" for stresses in findings),
        headline=_weakest_parts(findings),
        failures=list(_describe_failures(findings)),
        warnings=[
            (
                f"{stresses.design} {part.part}: contact pressure {part.largest_pressure / MEGAPASCAL:.4g} MPa, "
                f"safety {part.shakedown:.3g} against shakedown: the surface yields in every pass; `cycloid-mj "
                "rate` computes the pitting life"
            )
            for stresses in findings
            for part in stresses.parts
            if part.shakedown < 1.0
        ]
        + [
            (
                f"{stresses.design} {part.part}: not converged to {100 * MAX_CHANGE:g} % in one more refinement; run "
                "it without --quick, or use --solid"
            )
            for stresses in findings
            for part in stresses.parts
            if not part.refinement.is_converged
        ],
        tables=[*_stress_tables(findings), *_claim_tables(verdicts)],
        notes=[*_describe_tables(findings), *_claim_notes(verdicts, any(stresses.references for stresses in findings))],
        summary=["logs: " + " ".join(logs)]
        if (logs := [stresses.log for stresses in findings if stresses.log])
        else [],
        frame=make_frame(list(_csv_rows(findings)), COLUMNS, {}),
        pictures=pictures,
        files=maps,
        result=with_warnings(
            {
                "designs": [
                    stresses.as_json() | {"figures": values_json(study_quantities(stresses))} for stresses in findings
                ],
                "paper": [_claim_json(claim) for claims in verdicts.values() for claim in claims],
                "files": destination.paths([*picture_files, *maps]),
            }
        ),
    )


def _describe_failures(findings: "Sequence[StressFindings]") -> Iterator[str]:
    """Yield a sentence for each part whose stress exceeds its yield strength.

    `findings` has the stresses of the parts of each design. Parts with stress by finite elements come first, then the
    cranks and gear teeth of RV reducers, whose stress is nominal.
    """
    for stresses in findings:
        for part_findings in stresses.parts:
            if part_findings.safety < 1.0:
                part, stress = part_findings.part, part_findings.governing
                yield f"{stresses.design} {part}: {stress / MEGAPASCAL:.3g} MPa exceeds the yield strength"
    for stresses in findings:
        if stresses.strength:
            for part, stress in stresses.strength.largest.items():
                if stress > stresses.strength.yield_strength:
                    yield f"{stresses.design} {part}: {stress / MEGAPASCAL:.3g} MPa exceeds the yield strength"


def _figure_encoders(studies: "Sequence[StressStudy]", figures: Sequence[Drawn]) -> dict[str, Picture]:
    """Draw the requested kinds of diagrams, `figures`, of stress `studies`; return functions that encode them."""
    if not figures:
        return {}
    from cycloid_mj.plots.save import encode_figure
    from cycloid_mj.plots.stress import grid_figure, map_figure, maxima_figures, refinement_figure

    findings = [study.findings for study in studies]
    figures_by_name = maxima_figures(findings) if "turn" in figures else {}
    if "refinement" in figures:
        figures_by_name["stress_refinement"] = refinement_figure(findings)
    for study in studies:
        name, condition = study.design.name, f"{study.design.name}, {study.findings.load:g} N m"
        if "grid" in figures:
            figures_by_name[f"fig10_grid_{name}"] = grid_figure(
                {part_study.findings.part: part_study.grid for part_study in study.parts}, name
            )
        if "map" in figures:
            figures_by_name[f"fig11_map_{name}"] = map_figure(
                {part_study.findings.part: part_study.map for part_study in study.parts}, condition
            )
    return {name: partial(encode_figure, figure) for name, figure in figures_by_name.items()}


def _maps(studies: "Sequence[StressStudy]") -> dict[str, bytes]:
    from cycloid_mj.stress.vtu import as_vtu

    return {
        f"{study.design.name}_{item.findings.part}.vtu": as_vtu(item.map) for study in studies for item in study.parts
    }


def _weakest_parts(findings: "Iterable[StressFindings]") -> dict[str, str]:
    """Return stress and safety factor of the parts with the smallest safety factors, as text by "design part".

    There are at most `MOST_FIGURES` parts.
    """
    parts = [
        (part.safety, f"{stresses.design} {part.part}", part.governing)
        for stresses in findings
        for part in stresses.parts
    ]
    parts += [
        (stresses.strength.yield_strength / stress, f"{stresses.design} {part}", stress)
        for stresses in findings
        if stresses.strength
        for part, stress in stresses.strength.largest.items()
    ]
    return {
        name: f"{stress / MEGAPASCAL:.3g} MPa, safety {safety:.3g}"
        for safety, name, stress in nsmallest(MOST_FIGURES, parts)
    }


def _csv_rows(findings: "Iterable[StressFindings]") -> "Iterator[dict[str, float | str]]":
    """Yield a row of the CSV file for each part of each stress computation: the keys of `COLUMNS` and values.

    `findings` has the stresses of the parts of each design.
    """
    for stresses in findings:
        for part in stresses.parts:
            content = part.as_json()
            bulk, contact = content["bulk_peak"], content["contact_peak"]
            yield {
                **{key: content[key] for key in ("part", "governing_mpa", *COLUMNS[-3:-1])},
                "design": stresses.design,
                "bulk_mpa": bulk["stress_mpa"],
                "bulk_angle_deg": bulk["angle_deg"],
                "contact_mpa": contact["stress_mpa"],
                "contact_angle_deg": contact["angle_deg"],
                "refinement_change": part.refinement.change,
            }


def _stress_tables(findings: "Iterable[StressFindings]") -> Iterator[Table]:
    """Yield the tables of each design: the stress of its parts away from contacts, and below contacts.

    `findings` has the stresses of the parts of each design. An RV reducer has a table of its cranks and gears, too.
    """
    from cycloid_mj.stress.table import (
        BULK_HEADER,
        CONTACT_HEADER,
        STRENGTH_HEADER,
        bulk_table,
        contact_table,
        strength_table,
    )

    for stresses in findings:
        title = f"{stresses.design}, {stresses.load:g} N m"
        yield Table(f"{title}, away from contacts", BULK_HEADER, tuple(map(tuple, bulk_table(stresses))))
        yield Table(f"{title}, below contacts", CONTACT_HEADER, tuple(map(tuple, contact_table(stresses))))
        if stresses.strength:
            yield Table(f"{title}, cranks and gears", STRENGTH_HEADER, tuple(strength_table(stresses.strength)))


def _describe_tables(findings: "Sequence[StressFindings]") -> Iterator[str]:
    """Yield notes on the tables of a stress study: definitions, remarks on parts, force balance and assumptions."""
    from cycloid_mj.stress.table import part_notes

    yield (
        "bulk: where the largest stress is on its plateau, at the distance d from narrow contacts; to 2d: its decrease"
    )
    for stresses in findings:
        for part in stresses.parts:
            yield from part_notes(part)
        balance_text = ", ".join(f"{part.part} {100 * part.imbalance:.2g} %" for part in stresses.parts)
        yield f"{stresses.design}, force imbalance relative to the largest force: {balance_text}"
    yield from (
        f"assumed: {text}" for text in dict.fromkeys(text for stresses in findings for text in stresses.assumptions)
    )


def _claim_tables(verdicts: "Mapping[str, Sequence[Claim]]") -> Iterator[Table]:
    for source, claims in verdicts.items():
        if claims:
            rows = tuple((item.figure, item.claim, item.ours.text, str(item.verdict)) for item in claims)
            yield Table(f"compared with the paper ({source})", CLAIM_HEADER, rows)


def _claim_notes(verdicts: "Mapping[str, Sequence[Claim]]", has_references: bool) -> Iterator[str]:
    """Yield notes on the claims of papers: what decides each, or why a paper is not compared with these designs."""
    for source, claims in verdicts.items():
        if not claims and has_references:
            yield f"not compared with the paper ({source}): its stresses are without load; use --load-nm 0"
        yield from (f"{claim.figure}, {claim.claim}: {claim.decided_by}" for claim in claims)


def _claim_json(claim: "Claim") -> dict[str, str]:
    """Convert a claim of a paper on stresses and our verdict on it to JSON values.

    The keys are ``figure`` (of the paper), ``statement``, ``found`` (our result in words), ``verdict`` and
    ``decided_by`` (what decides the verdict, in words).
    """
    return {
        "figure": claim.figure,
        "statement": claim.claim,
        "found": claim.ours.text,
        "verdict": claim.verdict,
        "decided_by": claim.decided_by,
    }
