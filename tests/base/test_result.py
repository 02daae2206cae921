"""The records that results are made of."""

import json
import math

import pytest

from cycloid_mj.base.result import Claim, Condition, Quantity, Table, Value, Verdict, by_key, quantity_table


@pytest.mark.parametrize(
    ("condition", "words", "told"),
    [
        (Condition(0.0, 1640 * math.pi / 30), "no load", {"load_nm": 0.0, "speed_rpm": 1640.0}),
        (Condition(36.68, 0.0), "36.68 N m", {"load_nm": 36.68, "speed_rpm": 0.0}),
        (
            Condition(30.0, 0.0, 1.048),
            "1.048 N m on the crank",
            {"load_nm": 30.0, "speed_rpm": 0.0, "input_torque_nm": 1.048},
        ),
    ],
)
def test_a_condition_is_named_by_its_test(condition: Condition, words: str, told: dict[str, float]) -> None:
    assert condition.words == words
    assert condition.as_json() == told


def test_a_claim_in_json_has_both_numbers_and_its_verdict() -> None:
    ours = Value("5 um", 5.0, "um", (4.0, 6.0))
    claim = Claim(
        key="sway",
        figure="Fig. 9",
        part="pin 1",
        design="pin",
        condition=Condition(0.0, 0.0),
        claim="pin 1 sways",
        kind="height",
        stated=Value("1 um", 1.0, "um"),
        ours=ours,
        error=Value("half the step", 0.1, "um"),
        verdict=Verdict.NOT_DETERMINED,
        decided_by="the starts",
    )
    told = json.loads(json.dumps(claim.as_json()))
    assert told["verdict"] == "not determined"
    assert told["paper"] == {"claim": "pin 1 sways", "kind": "height", "value": 1.0, "unit": "um", "text": "1 um"}
    assert told["ours"] == {"value": 5.0, "unit": "um", "spread": [4.0, 6.0], "text": "5 um"}
    assert told["numerical_error"] == {"value": 0.1, "unit": "um", "source": "half the step"}
    assert told["at_rated_load"] is None


def test_quantities_are_one_table_and_one_mapping() -> None:
    one = Quantity("play", "backlash", 1.23456789, "arcmin", 0.0123, 1.2, "linear programme")
    other = Quantity("margin", "margin", math.nan, "1", math.nan)
    assert by_key([one], (item for item in [other])) == {"play": one, "margin": other}
    table = quantity_table("backlash: pin", [one, other])
    assert table.cells == [
        ["backlash", "1.235", "arcmin", "0.012", "1.2", "linear programme"],
        ["margin", "-", "1", "", "", ""],
    ]
    assert "key" not in one.as_json()


def test_a_table_is_markdown_with_its_bars_escaped() -> None:
    table = Table("title", ("what", "value"), (("a|b", 1.0 / 3.0),))
    assert table.as_markdown() == "| what | value |\n| --- | --- |\n| a\\|b | 0.3333 |"
