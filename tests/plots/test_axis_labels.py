"""Every axis that is named in the code names its unit, unless it counts."""

import ast
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest

from cycloid_mj.explore.tolerances import Tolerances
from cycloid_mj.plots.explored import figure_words
from cycloid_mj.plots.style import in_words
from cycloid_mj.plots.tolerance import budget_figure

ROOT = Path(__file__).parents[2]
DRAW = [
    path
    for place in ("cycloid_mj", "papers", "examples", "docs")
    for path in sorted((ROOT / place).rglob("*.py"))
    if "_gallery" not in path.parts
]
NUMBERS = {"evaluation", "unknowns", "samples", "number of the pin", "order: cycles per crank turn", "number of claims"}
"""What is counted, and has no unit."""

RATIOS = ("rms of ", "{} (1 on +y")
"""How labels begin of shares of one quantity in another of its kind, and of numbers of parts."""


def labels(code: str) -> Iterator[str]:
    """Yield what axes and colour bars are labelled with in a module, what is filled in later as {}."""
    for call in [node for node in ast.walk(ast.parse(code)) if isinstance(node, ast.Call)]:
        name = getattr(call.func, "attr", getattr(call.func, "id", ""))
        named = {"xlabel", "ylabel", "x_label", "y_label"} | ({"label"} if name == "colorbar" else set())
        found = [word.value for word in call.keywords if word.arg in named]
        for value in found + (call.args[:1] if name in {"set_xlabel", "set_ylabel"} else []):
            if isinstance(value, ast.Constant):
                yield str(value.value)
            elif isinstance(value, ast.JoinedStr):
                yield "".join(str(part.value) if isinstance(part, ast.Constant) else "{}" for part in value.values)


def bare(label: str) -> bool:
    """Tell whether a label lacks a unit that it should have."""
    return bool(label) and "[" not in label and label not in NUMBERS and not label.startswith(RATIOS)


@pytest.mark.parametrize("place", ["cycloid_mj", "papers", "examples", "docs"])
def test_axes_name_their_unit(place: str) -> None:
    written = [
        (path.name, label)
        for path in DRAW
        if path.is_relative_to(ROOT / place)
        for label in labels(path.read_text(encoding="utf-8"))
    ]
    assert len(written) > 3
    assert not [(file, label) for file, label in written if bare(label)]


def test_a_label_without_a_unit_is_detected() -> None:
    code = "axes.set(xlabel='force', ylabel=f'{part} [N]')\naxes.set_ylabel('speed')\nfigure.colorbar(x, label='p')"
    assert [label for label in labels(code) if bare(label)] == ["force", "speed", "p"]


def test_a_column_is_named_in_words_with_its_unit() -> None:
    assert in_words("clearance.pin_gear_um", "um") == "clearance: pin gear [um]"
    assert in_words("stiffness_nm_per_arcmin", "N m/arcmin") == "stiffness [N m/arcmin]"
    assert in_words("working_force.cam_n", "N") == "working force: cam [N]"
    assert in_words("loaded_teeth") == "loaded teeth"


def test_a_figure_is_named_as_the_catalogue_does() -> None:
    assert (
        figure_words("stiffness_ideal_nm_arcmin", "N m/arcmin")
        == "torsional stiffness, 50 to 100 % of the load [N m/arcmin]"
    )
    assert figure_words("statics.cam_peak_force_n", "N") == "statics: cam: largest force [N]"
    assert figure_words("simulate.gear_speed_rms", "rad/s") == "simulate: gear speed rms [rad/s]"


def test_bars_of_an_error_budget_have_words() -> None:
    share = SimpleNamespace(source="pin_position", first_order=0.4, total=0.5, ci95=(0.4, 0.6))
    study = SimpleNamespace(budget=(share,), budget_of="backlash_arcmin", design="pin")
    (axes,) = budget_figure(cast(Tolerances, study)).axes
    assert [label.get_text() for label in axes.get_yticklabels()] == ["pin position"]
