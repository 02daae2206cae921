"""Output of ``cycloid-mj stress``: figures, stress maps for ParaView, a JSON file, and tables."""

import json as js
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cycloid_mj.base.whole import write_whole
from cycloid_mj.cli.terminal import say, say_json, say_table, with_warnings
from cycloid_mj.papers import stress_claims

if TYPE_CHECKING:
    from cycloid_mj.base.result import Claim
    from cycloid_mj.stress.study import StressStudy

RESULT = "stress.json"
FORMATS = ("png", "svg")
LINE = 110
CLAIM_HEADER = ("figure", "the paper", "found here", "verdict")


def report(studies: "Sequence[StressStudy]", into: Path, json: bool) -> None:
    """Write figures, maps and the JSON file, then the tables or the JSON object."""
    findings = [study.findings for study in studies]
    judged = stress_claims(studies)
    drawn = _drawn(studies, into)
    files = [*drawn]
    content: dict[str, Any] = with_warnings(
        {
            "designs": [each.as_json() for each in findings],
            "paper": [_as_json(claim) for claims in judged.values() for claim in claims],
            "files": [str(path) for path in files],
        }
    )
    result = into / RESULT
    write_whole({**drawn, result: (js.dumps(content, indent=1) + "\n").encode()})
    if json:
        say_json(content)
        return
    _say(studies, judged, [*files, result])


def _drawn(studies: "Sequence[StressStudy]", into: Path) -> dict[Path, bytes]:
    """Draw figures and maps: path -> content."""
    from cycloid_mj.plots.save import pictures
    from cycloid_mj.plots.stress import grid_figure, map_figure, stress_figures
    from cycloid_mj.stress.vtu import as_vtu

    figures = stress_figures([study.findings for study in studies])
    vtu: dict[Path, bytes] = {}
    for study in studies:
        maps = {one.findings.part: one.map for one in study.parts}
        for part, stress_map in maps.items():
            vtu[into / f"{study.design.name}_{part}.vtu"] = as_vtu(stress_map)
        figures[f"fig10_grid_{study.design.name}"] = grid_figure(
            {one.findings.part: one.grid for one in study.parts}, study.design.name
        )
        condition = f"{study.design.name}, {study.findings.load:g} N m"
        figures[f"fig11_map_{study.design.name}"] = map_figure(maps, condition)
    return pictures(figures, into, FORMATS) | vtu


def _as_json(claim: "Claim") -> dict[str, str]:
    """Convert a claim to JSON values, which has its numbers from the parts."""
    return {
        "figure": claim.figure,
        "statement": claim.claim,
        "found": claim.found.text,
        "verdict": claim.verdict,
        "decided_by": claim.decided_by,
    }


def _say(studies: "Sequence[StressStudy]", judged: "Mapping[str, Sequence[Claim]]", files: Sequence[Path]) -> None:
    from cycloid_mj.stress.findings import ASSUMPTIONS, BOUND
    from cycloid_mj.stress.table import (
        BULK_HEADER,
        CONTACT_HEADER,
        bulk_table,
        contact_table,
        notes_beside,
    )

    for study in studies:
        findings = study.findings
        title = f"{findings.design}, {findings.load:g} N m: largest von Mises stress of a crank turn"
        say_table(f"{title}, away from contacts", BULK_HEADER, bulk_table(findings))
        say_table(f"{title}, below contacts", CONTACT_HEADER, contact_table(findings))
        say("bulk: where the largest stress is on its plateau, d from narrow contacts; to 2d: how far it falls")
        for part in findings.parts:
            for line in notes_beside(part):
                say(line)
        balance = ", ".join(f"{part.part} {100 * part.imbalance:.2g} %" for part in findings.parts)
        say(f"out of balance, of the largest force: {balance}")
        if rough := [part.part for part in findings.parts if not part.refinement.holds]:
            say(f"NOT CONVERGED to {100 * BOUND:g} % under one more refinement: {', '.join(rough)}")
    for source, claims in judged.items():
        _say_claims(source, claims, any(study.findings.references for study in studies))
    say("Assumptions:")
    for text in ASSUMPTIONS:
        for line in _wrapped(text, "- "):
            say(line)
    say("logs: " + " ".join(str(study.findings.log) for study in studies))
    say("files: " + " ".join(str(path) for path in files))


def _say_claims(source: str, claims: "Sequence[Claim]", referred: bool) -> None:
    """Tell what becomes of a paper's claims, or why none of them is judged though the paper has these designs."""
    if not claims:
        if referred:
            say(f"not held against the paper ({source}), whose figures of stress are without load: see --load-nm 0")
        return
    rows = [(claim.figure, claim.claim, claim.found.text, claim.verdict) for claim in claims]
    say_table(f"against the paper ({source})", CLAIM_HEADER, rows)
    say("What decides it:")
    for claim in claims:
        for line in _wrapped(f"{claim.figure}, {claim.claim}: {claim.decided_by}", "- "):
            say(line)


def _wrapped(text: str, mark: str) -> list[str]:
    return textwrap.wrap(text, LINE, initial_indent=mark, subsequent_indent=" " * len(mark), break_on_hyphens=False)
