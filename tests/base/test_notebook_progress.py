"""Progress bars in cells: shown in the kernel of a notebook only, once, and removed at the end."""

import sys
from types import SimpleNamespace
from typing import Any

import pytest

from cycloid_mj.base import notebook_progress
from cycloid_mj.base.notebook_progress import shows_progress


class Notebook:
    """Stand-in for IPython that records what cells show."""

    def __init__(self) -> None:
        self.shown: list[dict[str, str]] = []

    def display(self, bundle: dict[str, str], raw: bool, display_id: bool) -> "Notebook":
        assert raw
        assert display_id
        self.shown.append(bundle)
        return self

    def update(self, bundle: dict[str, str], raw: bool) -> None:
        assert raw
        self.shown.append(bundle)


@pytest.fixture
def notebook(monkeypatch: pytest.MonkeyPatch) -> Notebook:
    pretended = Notebook()
    shell = SimpleNamespace(kernel=object())
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: shell))
    monkeypatch.setitem(sys.modules, "IPython.display", SimpleNamespace(display=pretended.display))
    clock = iter(range(0, 1000, 2))
    monkeypatch.setattr(notebook_progress, "monotonic", lambda: next(clock))
    return pretended


def silent(done: int, total: int) -> None:
    """Do nothing."""


@shows_progress
def inner(progress: Any = silent) -> None:
    """Count to two."""
    for done in (1, 2):
        progress(done, 2)


@shows_progress
def outer(progress: Any = silent) -> str:
    """Call a function with a progress of its own, then count to three."""
    inner()
    for done in (1, 2, 3):
        progress(done, 3)
    return "result"


def test_a_cell_shows_one_bar_and_clears_it(notebook: Notebook) -> None:
    assert outer() == "result"
    texts = [bundle["text/plain"] for bundle in notebook.shown]
    assert texts[0].startswith("outer: 1 of 3, about ")
    assert '<progress value="1" max="3">' in notebook.shown[0]["text/html"]
    assert texts[-1] == ""
    assert not any("inner" in text for text in texts), "what a function calls shows no bar"


def test_a_progress_of_the_caller_replaces_the_bar(notebook: Notebook) -> None:
    counted = []
    outer(lambda done, total: counted.append((done, total)))
    outer(progress=lambda done, total: counted.append((done, total)))
    assert counted == [(1, 3), (2, 3), (3, 3)] * 2


def test_scripts_and_terminals_show_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    assert not notebook_progress.in_notebook()
    outer()
    assert capsys.readouterr() == ("", "")
