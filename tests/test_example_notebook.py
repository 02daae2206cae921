"""The example notebook: generated from its script, and executed."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
NOTEBOOK = ROOT / "examples" / "notebook.ipynb"
CELLS, MAX_CPU_S = 16, 60.0
PICTURES = 12
"""Cells of the example that show a picture."""


def test_the_notebook_is_that_of_its_script() -> None:
    code = "import notebook; print(notebook.notebook_text(notebook.SCRIPT.read_text(encoding='utf-8')), end='')"
    generated = subprocess.run(
        [sys.executable, "-X", "utf8", "-c", code], cwd=ROOT / "docs", capture_output=True, text=True, check=True
    ).stdout
    assert generated == NOTEBOOK.read_text(encoding="utf-8"), "run `python docs/notebook.py`"
    cells = json.loads(generated)["cells"]
    code_cells = [cell for cell in cells if cell["cell_type"] == "code"]
    assert len(code_cells) == CELLS
    assert "".join(code_cells[0]["source"]) == "import cycloid_mj as cm"
    assert not any("import" in line for cell in code_cells[1:] for line in cell["source"])
    assert not any(cell["outputs"] for cell in code_cells)


@pytest.mark.slow
def test_the_notebook_runs_and_shows_pictures(tmp_path: Path) -> None:
    pytest.importorskip("nbconvert", reason="needs nbconvert and ipykernel")
    pytest.importorskip("ipykernel", reason="needs nbconvert and ipykernel")
    before = os.times()
    command = [sys.executable, "-m", "nbconvert", "--to", "notebook", "--execute", "--output-dir", tmp_path, NOTEBOOK]
    subprocess.run(list(map(str, command)), check=True, timeout=900)
    after = os.times()
    cells = json.loads((tmp_path / NOTEBOOK.name).read_text(encoding="utf-8"))["cells"]
    formats = [output.get("data", {}) for cell in cells for output in cell.get("outputs", ())]
    assert sum("image/png" in shown for shown in formats) == PICTURES
    used = after.children_user + after.children_system - before.children_user - before.children_system
    assert used < MAX_CPU_S
