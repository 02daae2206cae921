"""The script that flips the signs of `reducer`: it finds every sign, and what it flips is seen."""

import ast
import importlib.util
import subprocess
import sys
from pathlib import Path

import flip_signs
import pytest

from cycloid_mj.design import PRESETS
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer import gaps as unspoiled


def test_every_sign_is_found_and_flipped_separately(tmp_path: Path) -> None:
    path = tmp_path / "one.py"
    path.write_text("# é - +\na = -b + (c\n    - d)  # - e\na += f(-1)\n")
    content, found = path.read_bytes(), list(flip_signs.find_signs(path))
    assert sorted(flip.expression for flip in found) == ["-1", "-b", "-b + (c - d)", "a += f(-1)", "c - d"]
    for flip in found:
        other = flip_signs.flip_sign(content, flip)
        assert sum(a != b for a, b in zip(content, other, strict=True)) == 1
        assert ast.dump(ast.parse(other)) != ast.dump(ast.parse(content))


def test_a_module_is_loaded_with_its_sign_flipped(monkeypatch) -> None:
    flip = next(
        flip
        for flip in flip_signs.choose_flips("gaps.py", "", 0)
        if flip.expression == "self.clearance + self.distance"
    )
    finder = flip_signs.Flipped(flip)
    assert finder.find_spec("cycloid_mj.reducer.limits", None) is None
    spec = finder.find_spec("cycloid_mj.reducer.gaps", None)
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, spec.name, module)
    spec.loader.exec_module(module)
    ours, spoiled = (gaps(Reducer(PRESETS["pin"]), 1.9) for gaps in (unspoiled.gaps, module.gaps))
    assert abs(ours.width - (ours.clearance + ours.distance)).max() == 0.0
    assert abs(spoiled.width - (spoiled.clearance - spoiled.distance)).max() == 0.0


@pytest.mark.slow
def test_a_sample_of_flips_is_seen_by_tests() -> None:
    """In a process of its own, where nothing of the project is loaded before a sign is flipped."""
    command = [sys.executable, flip_signs.__file__, "--sample", "8", "--workers", "1"]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stdout
