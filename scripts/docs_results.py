"""Write the tables of docs/paper.md from the results of `cycloid-mj reproduce`.

python scripts/docs_results.py           # from tests/data/reproduce.json and authors.json
python scripts/docs_results.py FOLDER    # from the output folder of `cycloid-mj reproduce`, of which JSON and pictures
                                         # are kept first; with --as-the-authors its tables, else claims and errata
"""

import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from docs_page import DATA, DOCS, csv_text, markdown_table, replace_sections
from picture import keep_small

from cycloid_mj.base.atomic_write import write_files

PAGE, PICTURES = DOCS / "paper.md", DOCS / "paper"
SCRIPT = "scripts/docs_results.py"
KEPT = DOCS.parent / "tests" / "data" / "reproduce.json"
AUTHORS = KEPT.with_name("authors.json")
CLAIMS, HYPOTHESIS = DATA / "paper-claims.csv", DATA / "paper-hypothesis.csv"
"""Tables for download: every claim, and the runs with the contact that the authors may have used."""

STAGES = ("geometry", "equal", "input", "gear_speed", "q_path", "q_velocity", "pin_1", "vibration", "stress", "torque")
TALLY = {"agrees": "agree", "depends": "depend on values that the paper omits"}
TALLY |= {"disagrees": "disagree", "not determined": "are not determined"}

SECTIONS = {
    "steel": ("poisson",),
    "speed": ("gear_speed_mean_pin", "gear_speed_mean_nonpin", "gear_speed"),
    "path": ("transmission_error_pin", "transmission_error_nonpin", "q_path"),
    "velocity": ("q_velocity", "gear_centre_acceleration", "output_acceleration"),
    "pin": ("pin_1_sway", "pin_1_spin", "pin_1_turns", "pin_1_slides", "stress_cycle_pin_1"),
    "height": tuple(
        f"stress_height_{part}_{design}" for part in ("shaft", "ring", "gear") for design in ("pin", "nonpin")
    ),
    "torque": (
        *(f"output_torque_{kind}_{design}" for design in ("pin", "nonpin") for kind in ("simulated", "measured")),
        "output_torque_order",
    ),
    "lines": ("double_contact_precision", "double_contact_capacity"),
}
"""Sections of the page with the keys of their claims."""

DOWNLOAD_ONLY = (
    *("stress_order_of_parts_pin", "stress_order_of_parts_nonpin", "stress_peaks_shaft_pin"),
    *("stress_output_pin", "stress_output_nonpin"),
    *(f"stress_order_of_designs_{part}" for part in ("shaft", "ring", "gear")),
    *(f"stress_{kind}_{part}" for part in ("shaft", "ring", "gear") for kind in ("mean", "fluctuation")),
)
"""Keys of the claims that are in the table for download only."""

SHOWN = {"fig6_gear_speed_unloaded": "speed", "fig7_q_path_unloaded": "path", "fig8_q_velocity_unloaded": "velocity"}
SHOWN |= {"fig9_pin_1_pin_unloaded": "pin", "fig19_torque_pin": "torque"}
"""Pictures of the command that the page shows, with their names there."""

CLAIM_COLUMNS = (
    *("Figure", "Design", "Load", "Claim of the paper", "Paper", "Model at that load", "Numerical error"),
    *("Verdict", "Decided by", "Model at the rated load"),
)

MAX_CELL = 120
"""Longest text of a result on the page; the rest is in the table for download."""


def sections(content: Mapping[str, Any]) -> dict[str, str]:
    """Return the generated sections of the page by name."""
    claims = {claim["key"]: claim for claim in content["claims"]}
    if lacking := sorted(claims.keys() ^ {key for keys in (*SECTIONS.values(), DOWNLOAD_ONLY) for key in keys}):
        raise ValueError(f"these claims are not on the page once: {', '.join(lacking)}")
    tables = {name: figure_table([claims[key] for key in keys]) for name, keys in SECTIONS.items()}
    return {"tally": format_tally(content), **tables, "errata": format_errata(content["errata"])}


def figure_table(claims: Sequence[Mapping[str, Any]]) -> str:
    """Return the claims of a section: design, claim, the paper's result, the model's, verdict."""
    head = ("Design", "Claim of the paper", "Paper", "Model", "Verdict")
    papers = [(claim["design"], claim["paper"]["claim"], claim["paper"]["text"]) for claim in claims]
    ours = [(_shorten(claim["ours"]["text"]), f"**{claim['verdict']}**") for claim in claims]
    rows = [(*paper, *model) for paper, model in zip(papers, ours, strict=True)]
    return markdown_table(head, rows)


def _shorten(text: str) -> str:
    """Return a result without what it has in brackets and behind a semicolon, as far as it is too long."""
    if len(text) <= MAX_CELL:
        return text
    return text.partition(" (")[0].partition(";")[0].partition(", the most")[0]


def format_tally(content: Mapping[str, Any]) -> str:
    """Return a sentence with the number of claims for each verdict."""
    claims = content["claims"]
    *counts, last_count = (
        f"{sum(claim['verdict'] == verdict for claim in claims)} {words}" for verdict, words in TALLY.items()
    )
    command = "cycloid-mj reproduce --quick" if content["quick"] else "cycloid-mj reproduce"
    tally = f"{', '.join(counts)}, and {last_count}"
    return f"`{command}` compares {len(claims)} claims of the paper with the model.\nOf these, {tally}."


def claim_rows(content: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """Return the rows of the table for download, in the order of `CLAIM_COLUMNS`."""
    return [_row(claim) for claim in content["claims"]]


def load(condition: Mapping[str, float]) -> str:
    """Return the load of a claim's condition in words."""
    if "input_torque_nm" in condition:
        return f"{condition['input_torque_nm']:g} N m on the crank"
    return f"{condition['load_nm']:g} N m" if condition["load_nm"] else "none"


def _row(claim: Mapping[str, Any]) -> tuple[str, ...]:
    """Return a claim as a row of the table for download."""
    error, rated = claim["numerical_error"], claim["at_rated_load"]
    unit = "" if error["unit"] == "1" else f" {error['unit']}"
    error_text = f"{error['value']:.2g}{unit} ({error['source']})" if error["value"] is not None else error["source"]
    return (
        *(claim["figure"], claim["design"], load(claim["condition"]), claim["paper"]["claim"], claim["paper"]["text"]),
        *(claim["ours"]["text"], error_text, claim["verdict"], claim["decided_by"], rated["text"] if rated else ""),
    )


def format_errata(entries: Sequence[Mapping[str, Any]]) -> str:
    """Tabulate the errata in Markdown: printed and corrected, with the relative errors of both against a proof."""
    head = ("Eq.", "Printed", "Correct", "Error as printed", "Error corrected", "Compared with")
    rows = []
    for entry in entries:
        printed = "none" if entry["harmless"] else f"{entry['printed_error']:.2g}"
        texts = (entry["equation"], entry["printed"], entry["right"], printed)
        rows.append((*texts, _upper_bound(entry["right_error"]), entry["proof"]))
    return markdown_table(head, rows)


def _upper_bound(error: float) -> str:
    """Return the power of ten below which an error lies: its digits are rounding errors of this machine."""
    return next((f"< 1e-{power}" for power in (9, 7, 5) if error < 10.0**-power), f"{error:.1g}")


def hypothesis_csv(content: Mapping[str, Any]) -> str:
    """Return the tables of `--as-the-authors` as one CSV text, each behind a line with its title."""
    tables = content["tables"]
    return csv_text(line for table in tables for line in ([table["title"]], table["columns"], *table["rows"]))


def claims_csv(content: Mapping[str, Any]) -> str:
    """Return the claims as CSV text."""
    return csv_text([CLAIM_COLUMNS, *claim_rows(content)])


def extract_page_data(content: Mapping[str, Any]) -> dict[str, Any]:
    """Extract from the JSON of `reproduce` what the page needs; raise ValueError if a stage failed or is missing."""
    errors = {stage["key"]: stage["error"] for stage in content["stages"]}
    if failed := [key for key, error in errors.items() if error]:
        raise ValueError(f"the page needs a run without a broken stage: {', '.join(failed)}")
    if missing := [key for key in STAGES if key not in errors]:
        raise ValueError(f"the page needs a run of all stages; missing: {', '.join(missing)}")
    return {key: content[key] for key in ("quick", "claims", "errata")}


def kept_authors(content: Mapping[str, Any]) -> dict[str, Any]:
    """Return the tables of a run with `--as-the-authors`; raise ValueError if it failed."""
    (stage,) = content["stages"]
    if stage["error"]:
        raise ValueError(f"the page is not written from a broken stage: {stage['error']}")
    return {"note": stage["notes"][0], "tables": stage["tables"]}


def save_page_data(folder: Path) -> None:
    """Save what the page needs of the output folder of `cycloid-mj reproduce`."""
    content = json.loads((folder / "reproduce.json").read_text(encoding="utf-8"))
    if [stage["key"] for stage in content["stages"]] == ["authors"]:
        path, chosen = AUTHORS, kept_authors(content)
    else:
        path, chosen = KEPT, extract_page_data(content)
        for name, shown in SHOWN.items():
            keep_small(folder / "figures" / f"{name}.png", PICTURES / f"{shown}.png")
    path.write_text(json.dumps(chosen, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def main(arguments: Sequence[str]) -> int:
    """Write the page and its tables for download; return the exit code."""
    if arguments:
        save_page_data(Path(arguments[0]))
    content, hypothesis = (json.loads(path.read_text(encoding="utf-8")) for path in (KEPT, AUTHORS))
    page = replace_sections(PAGE.read_text(encoding="utf-8"), sections(content), SCRIPT)
    texts = {PAGE: page, CLAIMS: claims_csv(content), HYPOTHESIS: hypothesis_csv(hypothesis)}
    write_files({path: text.encode() for path, text in texts.items()})
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
