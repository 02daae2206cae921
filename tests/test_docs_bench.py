"""The tables of docs/printed-drive.md agree with the kept fits."""

import json

import docs_bench
import pytest
from docs_page import replace_sections


def test_the_page_has_the_tables_that_the_script_writes() -> None:
    page = docs_bench.PAGE.read_text(encoding="utf-8")
    content = json.loads(docs_bench.KEPT.read_text(encoding="utf-8"))
    sections = docs_bench.format_sections(content)
    assert replace_sections(page, sections, docs_bench.SCRIPT) == page
    content["pin"]["parts"]["gear"] = 1.0
    assert replace_sections(page, docs_bench.format_sections(content), docs_bench.SCRIPT) != page


def test_a_page_without_marks_is_refused() -> None:
    with pytest.raises(ValueError, match="lacks"):
        replace_sections("nothing", {"fit": ""}, docs_bench.SCRIPT)
