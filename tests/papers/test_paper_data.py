"""The data of every claim: what it is judged at, how far it was searched, how sure it is, and what proves it."""

import json
import math
import re
from pathlib import Path

import docs_results
import pytest
from hsieh2014.page import reproduction_page
from hsieh2014.plan import (
    FULL,
    QUICK,
    SAMPLES,
    designs,
    finer_idle_runs,
    idle_runs,
    main_runs,
    no_load,
    ramp_run,
    rated_runs,
    variations,
    varied_idle_runs,
)
from hsieh2014.run import STEPS
from hsieh2014.stage import StageResult, StageRun

from cycloid_mj.base.result import Claim, Condition, Removal, Value, Verdict
from cycloid_mj.reducer.sockets import socket_half_angle

ROOT = Path(__file__).parents[2]
CLAIMS = json.loads((ROOT / "tests" / "data" / "reproduce.json").read_text(encoding="utf-8"))["claims"]
IDLE = [claim for claim in CLAIMS if claim["condition"]["load_nm"] == 0.0 and claim["key"] != "poisson"]
each_claim = pytest.mark.parametrize("claim", CLAIMS, ids=[claim["key"] for claim in CLAIMS])


@each_claim
def test_a_claim_states_condition_ranges_verdict_and_probability(claim):
    assert claim["condition"]["speed_rpm"] == 1640.0
    assert claim["condition"]["load_nm"] == 0.0 or claim["condition"]["input_torque_nm"] == 1.048
    assert claim["verdict"] in set(Verdict)
    assert claim["ranges_searched"]
    for one in claim["ranges_searched"]:
        assert one["low"] < one["high"]
        assert one["source"]
    assert claim["p"] is not None or len(claim["ours"]["spread"]) == 2


@pytest.mark.parametrize("claim", IDLE, ids=[claim["key"] for claim in IDLE])
def test_an_idle_claim_has_the_p_of_its_starts(claim):
    assert 0.0 < claim["p"] <= 1.0
    # no verdict is given that a test of twelve starts does not find
    if claim["verdict"] in ("agrees", "disagrees"):
        assert claim["p"] < 0.05


@each_claim
def test_the_cause_of_a_verdict_is_proven_by_its_removal(claim):
    removals = {one["taken_away"]: one for one in claim["removals"]}
    assert removals
    named = re.search(r"omitted by the paper: ([^;]*)", claim["decided_by"])
    if named and claim["key"] not in TORQUE:
        deciding = [one for name, one in removals.items() if name in named[1]]
        assert deciding
        for one in deciding:
            near = re.search(r"(\d+) of \d+ starts near", one["ours"])
            assert one["verdict"] != claim["verdict"] or "leads to no clear ranking" in claim["decided_by"]
            assert one["verdict"] != "disagrees" or (near and int(near[1]) > 0)
    if claim["verdict"] == "depends" and claim["paper"]["kind"] == "height":
        # forces grow without a jump: what is reached on both sides is reached
        sizes = [float(size) for one in removals.values() for size in re.findall(r"[\d.e+-]+(?= )", one["ours"])]
        assert min(sizes) < 1.1 * claim["paper"]["value"] < max(sizes) / 0.5
    elif claim["verdict"] == "depends" and claim["key"] != "stress_peaks_shaft_pin":
        assert "agrees" in {one["verdict"] for one in removals.values()}


TORQUE = {claim["key"] for claim in CLAIMS if claim["key"].startswith("output_torque")}


@pytest.mark.parametrize("plan", [QUICK, pytest.param(FULL, marks=pytest.mark.slow)])
def test_no_run_has_a_socket_that_the_drawings_do_not_have(plan):
    drawn = {design.name: socket_half_angle(design) for design in designs() if design.ring.has_sockets}
    runs = [*main_runs(plan), *rated_runs(plan), *(ramp_run(plan, design) for design in designs())]
    for design in designs():
        runs += idle_runs(plan, design) + finer_idle_runs(plan, design)
        runs += [run for one in variations(plan) for run in varied_idle_runs(plan, one, design)]
    for run in dict.fromkeys(runs):
        assert run.ring.socket == "half_open"
        if run.ring.has_sockets:
            # as wide as drawn, but for the clearance that is varied
            assert socket_half_angle(run) == pytest.approx(drawn[run.name], abs=1e-3)
    assert not [claim["key"] for claim in CLAIMS for one in claim["removals"] if "socket" in one["taken_away"]]


def test_a_varied_case_has_as_many_starts_as_the_design_itself():
    assert QUICK.varied_starts == FULL.varied_starts == SAMPLES.starts
    assert {len(idle_runs(QUICK, design)) for design in designs()} == {SAMPLES.starts}


def test_page_and_documentation_state_every_claim_in_the_same_words():
    """One claim of each verdict, through the HTML page and through the table for download."""
    claims = [
        Claim(
            f"claim_{number}",
            f"Fig. {number}",
            "gear",
            "pin",
            Condition(36.68, no_load().speed, 1.048) if number % 2 else no_load(),
            f"claim {number}",
            "order",
            Value("160 MPa", 160.0, "MPa"),
            Value(f"{number} to 9 MPa", float(number), "MPa", (1.0, 9.0)),
            Value("spread of 12 runs", 0.25, ("MPa", "1")[number % 2]),
            verdict,
            f"what decides {number}",
            Value("34 MPa", 34.0, "MPa"),
            removals=(Removal("friction", "1 MPa", Verdict.AGREES),),
            p=0.01,
        )
        for number, verdict in enumerate(Verdict)
    ]
    page = reproduction_page([StageRun(STEPS[0], StageResult(claims=tuple(claims)), 1.0)], [], {}, ())
    rows = re.findall(r'<tr id="claim_\d+">(.*?)</tr>', page, flags=re.DOTALL)
    told = [re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", row, flags=re.DOTALL) for row in rows]
    content = {"quick": True, "claims": [one.as_json() for one in claims]}
    table, written = [list(row) for row in docs_results.claim_rows(content)], docs_results.format_tally(content)
    load = {"no load": "none"}
    assert [row[6] for row in table[:2]] == ["0.25 MPa (spread of 12 runs)", "0.25 (spread of 12 runs)"]
    assert [[load.get(cell, cell) for cell in row] for row in told] == table
    counts = re.findall(r"(\d+) (agree|depend|disagree|are not determined)", written)
    assert sorted(counts) == sorted(re.findall(r"(\d+) (agree|depend|disagree|are not determined)", page))
    assert math.isclose(sum(int(count) for count, _ in counts), len(claims))


def test_a_page_of_stages_without_verdicts_has_no_claims_section():
    page = reproduction_page([StageRun(STEPS[0], StageResult(), 1.0)], [], {}, ())
    assert 'id="claims"' not in page
    assert 'href="#claims"' not in page
