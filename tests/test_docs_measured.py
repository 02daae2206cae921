"""The table of measures in docs/results.md is what the script writes from what was measured."""

import json
from pathlib import Path
from typing import Any

import docs_measured
import pytest

ROOT = Path(__file__).parent.parent


def test_the_page_states_what_was_measured() -> None:
    page = docs_measured.PAGE.read_text(encoding="utf-8")
    found = json.loads(docs_measured.KEPT.read_text(encoding="utf-8"))
    assert docs_measured.fill_page(page) == page
    for design, quantities in found.items():
        for label, keys in docs_measured.ROWS:
            assert sum(key in quantities for key in keys) == 1, (design, label)


def test_the_page_states_what_was_compared() -> None:
    """Two idle starts and a loaded run, as the command's JSON has them."""
    levels = {name: {"rms": value} for name, value in (("gear_speed_rad_s", 0.002), ("q_path_um", 0.03))}
    vibration = {"gear_centre_m_s2": {"rms": 1.7}, "output_rad_s2": {"rms": 55.0}}
    run = {"design": "nonpin-like-pin", "starts": 2, "fluctuation": levels | {"q_velocity_mm_s": {"rms": 0.09}}}
    run |= {"vibration": vibration, "findings": {"timestep_s": 3.1e-6, "efficiency": 0.8804}}
    spreads = [
        {"quantity": figure.words, "least": 114.2, "largest": 157.0, "mean": 0.013}
        for _, figure, _ in docs_measured.LEVELS
    ]
    runs = [run | {"load_nm": 0.0, "spreads": spreads}, run | {"load_nm": 36.68, "spreads": []}]
    told = docs_measured.format_comparison(
        docs_measured.read_comparison({"conditions": {"drive.speed_rpm": 1640.0}, "runs": runs})
    )
    assert "at 1640 rpm." in told
    assert "The time step is 3.1 us." in told
    assert "| Quantity | no load, nonpin like pin | 36.68 N m, nonpin like pin |" in told
    assert "| gear speed [rad/s] | 114 to 157 (0.013) | 0.002 |" in told
    assert "| efficiency [%] | 88.0 | 88.0 |" in told


def test_the_page_states_the_order_of_designs_of_both_commands() -> None:
    def run(design: str, load: float, *figures: list[float] | float) -> dict[str, Any]:
        told = dict(zip((label for label, *_ in docs_measured.LEVELS), figures, strict=True))
        return {"design": design, "load_nm": load, "figures": told}

    apart, wide = [2.0, 3.0, 2.5], [1.0, 3.0, 2.0]
    runs = [
        run("pin", 0.0, apart, apart, apart, apart, wide),
        run("nonpin", 0.0, [1.0, 1.5, 1.2], [1.0, 1.95, 1.5], wide, [4.0, 5.0, 4.5], wide),
        run("nonpin-like-pin", 0.0, *([[0.1, 0.2, 0.15]] * 5)),
        run("pin", 36.0, *([3.0] * 5)),
        run("nonpin", 36.0, *([2.0] * 5)),
    ]
    spreads = ([1.1, 2.0], [1.04, 2.0], [0.3, 0.9], [0.3, 0.96], [0.5, 3.0])
    claims = [{"key": key, "ours": {"spread": one}} for key, one in zip(docs_measured.CLAIMS, spreads, strict=True)]
    rows = [
        line.strip("| ").split(" | ")
        for line in docs_measured.format_fluctuations({"runs": runs}, claims).splitlines()[2:]
    ]
    assert [row[0] for row in rows[:2]] == ["gear speed", "path of q, without its steady shift"]
    assert [row[1] for row in rows] == ["1.5"] * 5
    # beyond all starts of the other, by more than 5 %
    assert [row[2] for row in rows] == ["pin", "no order", "no order", "nonpin", "no order"]
    assert [row[3] for row in rows] == ["pin", "no order", "nonpin", "no order", "no order"]
    assert [row[4:] for row in rows] == [["nonpin", "pin"]] * 5


def test_a_number_is_printed_with_its_error_and_its_closed_form() -> None:
    one = {"value": 1.23456, "unit": "m", "numerical_error": 0.0123, "reference": 1.2}
    table = docs_measured.table({"pin": dict.fromkeys([key for _, keys in docs_measured.ROWS for key in keys], one)})
    assert "| 1.235 ± 0.01 (1.2) |" in table
    bare = {**one, "numerical_error": None, "reference": None}
    assert "| 1.235 |" in docs_measured.table(
        {"pin": dict.fromkeys([key for _, keys in docs_measured.ROWS for key in keys], bare)}
    )


def test_a_page_without_marks_is_refused() -> None:
    with pytest.raises(ValueError, match="lacks"):
        docs_measured.fill_page("nothing")
