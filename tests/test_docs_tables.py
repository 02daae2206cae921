"""The summaries of docs/trust.md and docs/solvers.md agree with their tables for download, and charts can be drawn."""

from pathlib import Path

import docs_solvers
import docs_validation
import pytest
from docs_page import replace_sections

ROOT = Path(__file__).resolve().parents[1]


def test_the_validation_page_summarises_its_table() -> None:
    page = docs_validation.PAGE.read_text(encoding="utf-8")
    rows = docs_validation.read_rows()
    assert replace_sections(page, {"summary": docs_validation.table(rows)}, docs_validation.SCRIPT) == page
    shares = [summary.share for summary in docs_validation.summaries(rows)]
    assert max(shares) < 1.0
    with pytest.raises(ValueError, match="no row of the validation belongs to Backlash"):
        docs_validation.summaries([row for row in rows if row["rung"] != "backlash"])


def test_a_failed_or_shortened_validation_is_not_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(docs_validation, "KEPT", tmp_path / "validation.csv")
    content = {"passed": True, "quick": False, "rows": [{"quantity": "backlash", "error": 0.25, "bound": None}]}
    for change in ({"passed": False}, {"quick": True}):
        with pytest.raises(ValueError, match="full run"):
            docs_validation.keep(content | change)
    docs_validation.keep(content)
    (row,) = docs_validation.read_rows()
    assert (row["quantity"], row["error"], row["bound"]) == ("backlash", "0.25", "")


def test_the_page_of_two_solvers_summarises_its_table() -> None:
    page, rows = docs_solvers.PAGE.read_text(encoding="utf-8"), docs_solvers.read_rows()
    assert replace_sections(page, {"summary": docs_solvers.summary(rows)}, docs_solvers.SCRIPT) == page
    assert {row["layout"] for row in rows} == set(docs_solvers.LAYOUTS)
    conditions = {tuple(row[key] for key in docs_solvers.CONDITION) for row in rows}
    assert len(conditions) == len(rows)


def test_every_chart_and_sketch_can_be_drawn(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    import charts
    import sketches

    for module in (charts, sketches):
        module.write(tmp_path)
    drawn = {path.stem for path in tmp_path.iterdir()}
    assert drawn == {draw.__name__ for draw in (*charts.CHARTS, *sketches.SKETCHES)}
    pages = "".join(page.read_text(encoding="utf-8") for page in (ROOT / "docs").glob("*.md"))
    assert not [name for name in drawn if f"_drawings/{name}.svg" not in pages]
