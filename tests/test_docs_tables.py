"""Tables of docs/trust.md, solvers.md and market.md agree with their tables for download, and charts can be drawn."""

from pathlib import Path

import docs_market
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


def test_the_market_page_has_the_figures_of_its_table() -> None:
    page, rows = docs_market.PAGE.read_text(encoding="utf-8"), docs_market.read_rows()
    assert replace_sections(page, docs_market.format_sections(rows), docs_market.SCRIPT) == page
    assert list(rows) == [drive.point for drive in docs_market.DRIVES.values()]
    # a drive that is compared with several makers' drives is created once, and is the same in all rows
    requests = [(drive.flags, drive.torque, drive.length) for drive in docs_market.DRIVES.values()]
    assert len(set(requests)) == len(docs_market.CREATED)
    for drive in docs_market.DRIVES.values():
        if drive.record:
            created = rows[docs_market.DRIVES[drive.record].point]
            assert (drive.flags, drive.torque) == (
                docs_market.DRIVES[drive.record].flags,
                docs_market.DRIVES[drive.record].torque,
            )
            assert {key: row["ours"] for key, row in rows[drive.point].items() if row["ours"]} == {
                key: row["ours"] for key, row in created.items() if row["ours"]
            }
    lines = [line for line in page.splitlines() if not line.startswith("| ")]
    assert max(map(len, lines)) <= docs_market.MAX_COLUMNS
    sources = {source for figures in rows.values() for row in figures.values() if (source := row["source"])}
    assert sources == set(docs_market.SOURCES)
    for drive in docs_market.DRIVES.values():
        mass = rows[drive.point]["mass"]
        items = sum(float(rows[drive.point][f"mass: {item}"]["ours"]) for item in docs_market.MASSES)
        assert items == pytest.approx(float(mass["ours"]), rel=0.01)
        for figure, (stated, _) in docs_market.MAKERS[drive.theirs].items():
            row = rows[drive.point][docs_market.FIGURES[figure][0]]
            assert row["theirs"] == stated
            if row["ours"]:
                assert float(row["ratio"]) == pytest.approx(float(row["ours"]) / float(stated.split()[-1]), rel=5e-3)


def test_rv_reducers_are_compared_with_the_catalogue_from_rv_20e_to_rv_320e() -> None:
    """Torque, mass, size and stiffness have a ratio to each maker's value; the lost motion is below 1 arcmin."""
    page, table = docs_market.RV_PAGE.read_text(encoding="utf-8"), docs_market.format_catalogue(docs_market.read_rows())
    assert replace_sections(page, {"catalogue": table}, docs_market.SCRIPT) == page
    rows, drives = docs_market.read_rows(), [drive for drive in docs_market.DRIVES.values() if drive.is_rv]
    assert {"RV-20E", "RV-40E", "RV-80E", "RV-110E", "RV-320E"} <= {drive.theirs for drive in drives}
    for drive in drives:
        figures = rows[drive.point]
        assert float(figures["lost motion"]["ours"]) < 1.0
        assert float(figures["rated torque"]["ratio"]) >= 1.0
        assert float(figures["diameter"]["ratio"]) <= 1.0
        for figure in ("mass", "torsional stiffness"):
            assert 0.0 < float(figures[figure]["ratio"]) < 2.0
        assert figures["length"]["ours"]


def test_masses_of_parts_are_added_by_item() -> None:
    parts = {"housing": 1.0, "pin": 0.5, "output": 2.0, "output_pin": 0.25, "output_cover": 4.0, "output_bearing": 8.0}
    masses = docs_market.group_masses([*parts.items(), ("flange_screw", 0.125)])
    assert masses["ring and ring pins"] == 1.5
    assert masses["carrier and output pins"] == 2.25
    assert (masses["covers"], masses["bearings"], masses["screws, dowels and others"]) == (4.0, 8.0, 0.125)


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
