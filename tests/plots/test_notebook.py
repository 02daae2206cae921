"""Figures in a notebook: pictures, although nothing but ``import cycloid_mj as cm`` was run."""

import struct
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import pytest
from made_run import made_run

import cycloid_mj as cm
from cycloid_mj.design import PRESETS

FRESH = """
from IPython.core.interactiveshell import InteractiveShell
shell = InteractiveShell.instance()
shell.run_cell("import cycloid_mj as cm")
result = shell.run_cell("cm.statics('pin', 5.0).plot()").result
formats, _ = shell.display_formatter.format(result)
assert formats["image/png"][:8] == b"\\x89PNG\\r\\n\\x1a\\n", list(formats)
import sys
assert "matplotlib.pyplot" not in sys.modules
"""

RESULTS: dict[str, Callable[[], Any]] = {
    "statics": lambda: cm.statics("pin", 5.0),
    "design": lambda: PRESETS["pin"],
    "run": lambda: made_run(PRESETS["pin"]),
    "check": lambda: cm.check("pin"),
    "rating": lambda: cm.rate("pin"),
    "measurement": lambda: cm.measure.backlash("pin"),
}


SLOW = {"measurement"}


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * (name in SLOW)) for name in RESULTS])
def test_a_plot_shows_itself_as_png(name: str) -> None:
    figure = RESULTS[name]().plot()
    picture, size = figure._repr_png_()
    assert picture.startswith(b"\x89PNG\r\n\x1a\n")
    width, height = struct.unpack(">II", picture[16:24])
    assert width == pytest.approx(2 * size["width"], abs=2)
    assert height == pytest.approx(2 * size["height"], abs=2)


def test_a_cell_of_a_fresh_notebook_shows_a_picture() -> None:
    pytest.importorskip("IPython")
    subprocess.run([sys.executable, "-c", FRESH], check=True, timeout=300)
