"""The tables of docs/bench.md are those of what is kept of the fits."""

import importlib.util
import json
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


def test_the_page_is_what_the_script_writes() -> None:
    spec = importlib.util.spec_from_file_location("docs_bench", ROOT / "scripts" / "docs_bench.py")
    assert spec
    assert spec.loader
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    page, content = script.PAGE.read_text(encoding="utf-8"), json.loads(script.KEPT.read_text(encoding="utf-8"))
    texts = script.sections(content)
    assert script.written(page, texts) == page
    content["pin"]["parts"]["gear"] = 1.0
    assert script.written(page, script.sections(content)) != page
    with pytest.raises(ValueError, match="lacks"):
        script.written("nothing", texts)
