"""The README's first commands, its Python and its links; its other commands are in `test_docs_commands`."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```(\w+)\n(.*?)```", README, flags=re.DOTALL)


def test_the_first_two_commands_install_and_run() -> None:
    shell = [block.strip() for language, block in BLOCKS if language == "sh"]
    assert shell[0].endswith(".venv/bin/cycloid-mj simulate --design pin")
    assert shell[1] in (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    for command in shell[:2]:
        assert "\n" not in command
        assert command.startswith("python3 -m venv .venv && .venv/bin/pip install ")


@pytest.mark.parametrize("code", [block for language, block in BLOCKS if language == "python"])
def test_python_blocks_print_plausible_figures(code: str, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    exec(compile(code, "README.md", "exec"), {})
    first, second = capsys.readouterr().out.splitlines()
    efficiency, error = map(
        float, re.fullmatch(r"efficiency ([\d.]+)%, transmission error ([\d.]+) arcsec", first).groups()
    )
    force = float(re.fullmatch(r"largest force on a pin (\d+) N", second)[1])
    assert 85.0 < efficiency < 93.0
    assert 0.2 < error < 2.0
    assert 120.0 < force < 200.0


def test_links_and_pictures_exist() -> None:
    for target in re.findall(r"\]\(([^)#]+)\)", README):
        if target.startswith("../../actions/workflows/"):
            assert (ROOT / ".github" / "workflows" / target.split("/")[4]).is_file(), target
        elif not target.startswith("http"):
            assert (ROOT / target).exists(), target
