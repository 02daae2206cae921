"""Write the results of docs/paper.md from the numbers of `cycloid-mj reproduce`.

`python scripts/docs_results.py` writes them from tests/data/reproduce.json and authors.json; with the path of another
reproduce.json it keeps there first what the pages show: of a run of `--as-the-authors` its tables, else claims and
errata.
"""

import json
import re
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from cycloid_mj.base.result import Table

ROOT = Path(__file__).parent.parent
PAGE, KEPT = ROOT / "docs" / "paper.md", ROOT / "tests" / "data" / "reproduce.json"
AUTHORS = KEPT.with_name("authors.json")
MARK = "<!-- {word} of {name}: scripts/docs_results.py writes what stands here -->"
STAGES = ("geometry", "equal", "input", "gear_speed", "q_path", "q_velocity", "pin_1", "vibration", "stress", "torque")
TALLY = {"agrees": "agree", "depends": "depend", "disagrees": "disagree", "not determined": "are not determined"}


def sections(content: dict[str, Any], with_soft_contact: dict[str, Any]) -> dict[str, str]:
    """Collect the generated sections of the page by name, from both runs of the command."""
    return {
        "authors": authors(with_soft_contact),
        "results": results(content),
        "errata": errata(content["errata"]),
    }


def authors(content: dict[str, Any]) -> str:
    """Return the tables of `--as-the-authors`, and its sentence on the peaks of the cam's force."""
    tables = [Table(one["title"], tuple(one["columns"]), tuple(map(tuple, one["rows"]))) for one in content["tables"]]
    titled = [f"{table.title[0].upper()}{table.title[1:]}:\n\n{table.as_markdown()}" for table in tables]
    return "\n\n".join([content["note"], *titled])


def results(content: dict[str, Any]) -> str:
    """Return the claims: a row for each, with the load at which it is judged, and ours at the rated load beside it."""
    claims, summary = content["claims"], tally(content)
    head = (
        *("figure", "design", "load", "the paper says", "its number", "ours at that load", "numerical error"),
        *("verdict", "decided by", "beside it: ours at the rated load"),
    )
    return f"{summary}\n\n{_table(head, [_row(claim) for claim in claims])}"


def tally(content: dict[str, Any]) -> str:
    """Tell how many claims there are, and what becomes of them."""
    claims = content["claims"]
    counts = ", ".join(
        f"{sum(claim['verdict'] == verdict for claim in claims)} {words}" for verdict, words in TALLY.items()
    )
    command = "cycloid-mj reproduce --quick" if content["quick"] else "cycloid-mj reproduce"
    return (
        f"`{command}` holds {len(claims)} claims of the paper against this model, each at the paper's own condition: "
        f"{counts}."
    )


def load(condition: dict[str, float]) -> str:
    """Format the load of a claim's condition in words."""
    if "input_torque_nm" in condition:
        return f"{condition['input_torque_nm']:g} N m in"
    return f"{condition['load_nm']:g} N m" if condition["load_nm"] else "none"


def _row(one: dict[str, Any]) -> tuple[str, ...]:
    error, rated = one["numerical_error"], one["at_rated_load"]
    unit = "" if error["unit"] == "1" else f" {error['unit']}"
    error_text = f"{error['value']:.2g}{unit} ({error['source']})" if error["value"] is not None else error["source"]
    return (
        *(one["figure"], one["design"], load(one["condition"]), one["paper"]["claim"], one["paper"]["text"]),
        *(one["ours"]["text"], error_text, one["verdict"], one["decided_by"], rated["text"] if rated else ""),
    )


def errata(entries: Sequence[dict[str, Any]]) -> str:
    """Return the errata: printed and corrected, and by how much each misses what its proof holds it against."""
    head = ("Eq.", "printed", "right", "relative error as printed", "corrected", "held against")
    rows = [
        (
            entry["equation"],
            entry["printed"],
            entry["right"],
            "none" if entry["harmless"] else f"{entry['printed_error']:.2g}",
            _bounded(entry["right_error"]),
            entry["proof"],
        )
        for entry in entries
    ]
    return _table(head, rows)


def written(page: str, texts: Mapping[str, str]) -> str:
    """Return a page with its generated sections replaced; raise ValueError if it lacks the marks of one."""
    for name, text in texts.items():
        begin, end = (MARK.format(word=word, name=name) for word in ("Begin", "End"))
        if begin not in page or end not in page:
            raise ValueError(f"the page lacks {begin} or {end}")
        between = re.compile(f"{re.escape(begin)}.*{re.escape(end)}", re.DOTALL)
        before, after = between.split(page)
        page = f"{before}{begin}\n\n{text}\n\n{end}{after}"
    return page


def kept(content: dict[str, Any]) -> dict[str, Any]:
    """Collect what of the command's JSON the page stands on; raise ValueError if a stage broke or was left out."""
    stages = {stage["key"]: stage["error"] for stage in content["stages"]}
    if broken := [key for key, error in stages.items() if error]:
        raise ValueError(f"the page is not written from a run with a broken stage: {', '.join(broken)}")
    if missing := [key for key in STAGES if key not in stages]:
        raise ValueError(f"the page is not written from a run of some stages alone; missing: {', '.join(missing)}")
    return {key: content[key] for key in ("quick", "claims", "errata")}


def kept_authors(content: dict[str, Any]) -> dict[str, Any]:
    """Collect what the page shows of the stage as the authors may have run it; raise ValueError if it broke."""
    (stage,) = content["stages"]
    if stage["error"]:
        raise ValueError(f"the page is not written from a broken stage: {stage['error']}")
    return {"note": stage["notes"][0], "tables": stage["tables"]}


def _bounded(error: float) -> str:
    """Return the decade below which an error lies: its digits are rounding, another machine has others."""
    return next((f"< 1e-{power}" for power in (9, 7, 5) if error < 10.0**-power), f"{error:.1g}")


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    return Table("", tuple(head), tuple(map(tuple, rows))).as_markdown()


def main(arguments: Sequence[str]) -> int:
    """Write the page; give the exit code."""
    if arguments:
        given = json.loads(Path(arguments[0]).read_text(encoding="utf-8"))
        of_authors = [stage["key"] for stage in given["stages"]] == ["authors"]
        path, chosen = (AUTHORS, kept_authors(given)) if of_authors else (KEPT, kept(given))
        path.write_text(json.dumps(chosen, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    content, with_soft_contact = (json.loads(path.read_text(encoding="utf-8")) for path in (KEPT, AUTHORS))
    page = written(PAGE.read_text(encoding="utf-8"), sections(content, with_soft_contact))
    PAGE.write_text(page, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
