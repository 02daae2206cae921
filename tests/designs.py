"""Valid designs unlike the paper's, in kind, size, ratio and material: what works on these works on more than one."""

from collections.abc import Collection
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from cycloid_mj.design import PRESETS, Design, load

FOLDER = Path(__file__).parent / "data" / "designs"

UNLIKE = ("light", "printed", "large", "few", "teeth21")
"""Light steel 20:1 with an internal gear; printed 11:1, pressed-in pins; large 59:1, sleeves; 6:1 and 20:1, free pins.

What is called printed here is another drive than the preset of that name.
The last is the paper's own load on fewer teeth; the others are sized with room to spare."""

CENTRAL = {name: design for name, design in PRESETS.items() if design.layout == "central"}
"""Presets with a central crank and output pins, for tests of parts and models that RV reducers do not have.

These are covers with shaft bearings and screws (`casing`, `bill`), the crank with its cams, output pins in holes, and
``statics.balance`` with ``reducer.gaps`` of such pairs. RV reducers have other models of cranks and carrier
(``statics.rv``, ``parts.rv``), whose tests have "rv" in their names. All other tests iterate over `PRESETS`."""

FEW_TEETH_CHANGES = [
    "ring.teeth=8",
    "ring.pin_circle_radius_mm=40.0",
    "ring.pin_radius_mm=5.0",
    "gear.eccentricity_mm=2.5",
    "gear.bore_radius_mm=10.0",
    "output.pins=6",
    "output.pin_circle_radius_mm=21.0",
    "output.hole_radius_mm=6.5",
]
"""What makes a preset of the paper one of eight teeth."""


def design_file(name: str) -> Path:
    """Where a design's file is."""
    return FOLDER / f"{name}.toml"


@cache
def unlike(name: str) -> Design:
    """Load one of `UNLIKE`."""
    return load(design_file(name))


def cases(every: Collection[Any], *quick: Any) -> list[Any]:
    """List the cases of a test of which the quick ones run by default, and all others with ``-m slow``."""
    assert all(case in every for case in quick)
    return [
        pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=[pytest.mark.slow] * (case not in quick))
        for case in every
    ]
