"""What a run means, in sentences: the figures of the findings, each beside its closed form."""

from dataclasses import replace

import pytest
from made_run import made_run

from cycloid_mj.analysis import Findings, analyze, explain
from cycloid_mj.analysis.findings import Loss
from cycloid_mj.base.result import Condition
from cycloid_mj.design import PRESETS


@pytest.fixture(scope="module")
def findings() -> Findings:
    """Of a made run whose cam and pins lose power."""
    made = analyze(made_run(PRESETS["pin"]))
    return replace(made, losses=(Loss("cam", 2.0, 0.1), Loss("pin_gear", 0.5, 0.1)))


def test_eight_sentences_at_most_with_the_figures_of_the_run(findings: Findings) -> None:
    sentences = explain(findings)
    assert len(sentences) <= 8
    assert f"{abs(findings.output_speed.theory_rad_s):.4f}" in sentences[0]
    assert "(1/35 of the crank's)" in sentences[0]
    assert any(f"{findings.contact_summary.peak_force_n:.4g} N" in sentence for sentence in sentences)


def test_under_load_the_torque_without_losses_and_the_efficiency_are_printed(findings: Findings) -> None:
    power = replace(findings.power, load_torque_nm=36.0, crank_torque_nm=1.2, ideal_crank_torque_nm=36.0 / 35.0)
    loaded = replace(findings, condition=Condition(36.0, 100.0), power=power, efficiency=0.857)
    told = " ".join(explain(loaded))
    assert "1.2 N m at a load torque of 36 N m; without losses 1.029 N m" in told
    assert "efficiency: 85.70 %" in told
    assert "rattle" not in told


def test_without_load_there_is_no_efficiency_and_the_rattle_is_named(findings: Findings) -> None:
    told = " ".join(explain(replace(findings, condition=Condition(0.0, 100.0), efficiency=None)))
    assert "efficiency is undefined without a load" in told
    assert "parts rattle" in told


def test_the_largest_loss_is_named_with_its_share(findings: Findings) -> None:
    first, second, *_ = findings.losses
    losses = replace(first, friction_w=3.0, normal_w=0.0), replace(second, friction_w=1.0, normal_w=0.0)
    assert f"losses: 4 W, of which 75% at {first.pair.replace('_', '-')}" in explain(replace(findings, losses=losses))
