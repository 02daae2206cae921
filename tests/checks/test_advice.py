"""Advice of failed checks: followed, it makes its check pass and no other worse; it never repeats the value."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from commands import told
from random_drives import KINDS, drawn

from cycloid_mj.base.errors import CycloidError
from cycloid_mj.checks import Checks, check, soundness
from cycloid_mj.checks.advice import RANKS, quick_checks, verify_remedies
from cycloid_mj.checks.limit import value_and_limit
from cycloid_mj.design import PRESETS, Design, load, override, presets_for, value_of
from cycloid_mj.design.units import MILLIMETRE
from cycloid_mj.geometry import profile
from cycloid_mj.life.checks import check_design
from cycloid_mj.reducer import Reducer, reducer_of
from cycloid_mj.statics.sheet import sheet

CASES = Path(__file__).parents[1] / "data" / "cases"

VARIED = (
    "ring.teeth",
    "ring.pin_circle_radius_mm",
    "ring.pin_radius_mm",
    "gear.eccentricity_mm",
    "gear.bore_radius_mm",
    "gear.face_width_mm",
    "output.pins",
    "output.pin_radius_mm",
    "output.pin_circle_radius_mm",
    "output.hole_radius_mm",
    "shaft.radius_mm",
    "shaft.length_mm",
    "shaft.counterweight_radius_mm",
    "housing.outer_radius_mm",
    "clearance.pin_gear_um",
    "clearance.output_um",
    "clearance.cam_um",
    "drive.torque_nm",
)
"""Keys of which one to three are changed by a factor between a third and three."""

VARIED_RV = (
    "ring.teeth",
    "ring.pin_circle_radius_mm",
    "ring.pin_radius_mm",
    "gear.eccentricity_mm",
    "gear.face_width_mm",
    "planet.sun_teeth",
    "planet.planet_teeth",
    "planet.module_mm",
    "cranks.eccentric_radius_mm",
    "cranks.needle_radius_mm",
    "cranks.needles",
    "cranks.taper_radius_mm",
    "cranks.middle_hole_radius_mm",
    "cranks.post_radius_mm",
    "housing.outer_radius_mm",
    "drive.torque_nm",
)
"""The same for RV reducers."""


def bad_designs(count: int, seed: int, with_statics: bool) -> Iterator[tuple[Design, Checks]]:
    """Yield random designs that fail a check, and their checks: half of them of presets, half of random drives."""
    draw = np.random.default_rng(seed)
    presets = list(presets_for("rate").values())
    while count:
        base = presets[draw.integers(len(presets))] if draw.random() < 0.5 else drawn(draw, KINDS[draw.integers(6)], 0)
        if base is None:
            continue
        changes = {}
        varied = VARIED_RV if base.layout == "rv" else VARIED
        for key in map(str, draw.choice(varied, int(draw.integers(1, 4)), replace=False)):
            value = value_of(base, key) * np.exp(draw.uniform(-1.1, 1.1))
            counted = key.endswith(("teeth", "pins", "needles"))
            changes[key] = max(round(value), 3) if counted else float(f"{value:.4g}")
        try:
            design = override(base, changes)
            checks = check(design) if with_statics else Checks(soundness(reducer_of(design)))
        except CycloidError:
            continue
        if any(not one.passed for one in checks):
            count -= 1
            yield design, checks


def follow(design: Design, checks: Checks, with_statics: bool) -> Iterator[tuple[str, bool]]:
    """Follow each advice of a design: a line about it, and whether its check passes and no other is worse."""
    before = {one.name: one for one in checks}
    for one in verify_remedies(reducer_of(design), checks):
        if one.passed:
            continue
        for change in one.changes:
            assert all(value != value_of(design, key) for key, value in change.items()), "an advice repeats the value"
            try:
                after = {check.name: check for check in check(override(design, change))} if with_statics else None
            except CycloidError as error:
                yield f"{one.name}: {change} ends with {error}", False
                continue
            after = after or quick_checks(reducer_of(design), change) or {}
            worse = [
                name
                for name, item in after.items()
                if name != one.name and RANKS[item.judgement] > (RANKS[before[name].judgement] if name in before else 1)
            ]
            passes = one.name not in after or after[one.name].passed
            yield f"{one.name}: {change} passes {passes}, worse {worse}", passes and not worse


@pytest.mark.parametrize(
    ("count", "with_statics"),
    [
        (12, False),
        pytest.param(500, False, marks=pytest.mark.slow),
        pytest.param(60, True, marks=pytest.mark.slow),
    ],
)
def test_followed_advice_passes_its_check_and_makes_no_other_worse(count: int, with_statics: bool) -> None:
    followed = [
        (design.layout, *result)
        for design, checks in bad_designs(count, 1, with_statics)
        for result in follow(design, checks, with_statics)
    ]
    for layout in ("central", "rv") if count >= 60 else ("central",):
        lines = {line: good for found, line, good in followed if found == layout}
        failed = [line for line, good in lines.items() if not good]
        assert lines
        assert len(failed) <= 0.05 * len(lines), "\n".join(failed)
    assert len(followed) > count
    assert any("ring.teeth" in line for _, line, _ in followed), "advice on whole numbers is followed"


@pytest.mark.parametrize(
    ("change", "count"),
    [("planet.sun_teeth=12", 2), ("housing.outer_radius_mm=80", 2), ("cranks.eccentric_radius_mm=25", 4)],
)
def test_advice_on_an_rv_reducer_is_tried(change: str, count: int) -> None:
    design = override(PRESETS["rv80e"], [change])
    followed = list(follow(design, check(design), with_statics=False))
    assert len(followed) == count
    assert all(good for _, good in followed), followed
    assert check_design(design).failures[0].changes == check(design).failures[0].changes


def test_first_advice_on_the_eccentricity_passes_every_check_of_the_profile() -> None:
    """50 pins of 1.5708 mm on 50 mm: 0.9999 mm has no loops but an undercut; at 0.9491 mm the sharpest convex bend,

    R (1 + K^2 - 2 K cos t)^1.5/(1 + N K^2 - (N + 1) K cos t) with K = c N/R, is as large as the pin with its clearance.
    """
    design = load(CASES / "31-eccentricity-advice.toml")
    reducer = Reducer(design)
    loops = next(one for one in check_design(design) if one.name == "loops")
    change = loops.changes[0]
    assert change == {"gear.eccentricity_mm": 0.9491, "output.hole_radius_mm": 4.9491}
    assert loops.remedy.startswith("lower gear.eccentricity_mm to 0.9491 and lower output.hole_radius_mm to 4.9491")
    mended = Reducer(override(design, change))
    assert not [one for one in soundness(mended) if one.name in ("loops", "undercut", "socket") and not one.passed]
    t = np.linspace(0.0, np.pi, 200_001)
    for eccentricity, cut in ((0.9491, False), (0.9496, True)):
        K = eccentricity * 50 / 50.0
        cos = np.cos(t)
        bend = 50.0 * (1 + K**2 - 2 * K * cos) ** 1.5 / (1 + 50 * K**2 - 51 * K * cos)
        sharpest = bend[bend > 0.0].min()
        assert (sharpest < 1.5708 + 1e3 * design.clearance.pin_gear) == cut
    assert profile.undercut_radius(mended.gear_profile) > mended.profile_offset > 0.0
    assert reducer.design.ring.teeth == 50


def test_value_and_limit_are_distinguished_or_written_in_full() -> None:
    """A pin of 1.5708 mm that must be more than 1.5708 mm read 1.571, more than 1.571, raise to 1.571."""
    socket = next(one for one in check_design(load(CASES / "31-eccentricity-advice.toml")) if one.name == "socket")
    assert (socket.got, socket.limit) == ("1.5708 mm", "more than 1.5708 mm")
    assert socket.changes[0] == {"ring.pin_radius_mm": 1.571}
    assert value_and_limit(1.23456e-3, "at most", 1.23455e-3, MILLIMETRE) == ("1.23456 mm", "at most 1.23455 mm")


def test_torque_and_speed_of_the_preset_are_stated_before_the_warnings() -> None:
    code, out, _ = told("design", "check", str(CASES / "41-default-torque.toml"))
    first, *rest = out.splitlines()
    assert code == 0
    assert "nominal torque of 9.432 N m by the defaults drive.torque_nm = 1.048 and drive.speed_rpm = 1640" in first
    assert rest[0].startswith("warn")
    assert not any("by the default" in line for line in rest)
    stated = told("design", "check", str(CASES / "41-default-torque.toml"), "--set", "drive.torque_nm=0.1")[1]
    assert "by the default drive.speed_rpm = 1640, which" in stated.splitlines()[0]
    assert "default" not in told("design", "check", "pin")[1]


def test_few_lobes_have_a_warning_whose_advice_works() -> None:
    """5:1 with K1 = 0.24: a mean pressure angle of 77.5 deg; with the advice 70.0 deg and no warning is left."""
    design = load(CASES / "44-few-lobes.toml")
    checks = {one.name: one for one in check_design(design).warnings}
    assert checks.keys() == {"short_width", "pressure_angle"}
    assert checks["pressure_angle"].value == pytest.approx(77.5, abs=0.05)
    assert checks["pressure_angle"].changes == ({"gear.eccentricity_mm": 3.188, "output.hole_radius_mm": 7.188},)
    mended = check_design(override(design, checks["pressure_angle"].changes[0]))
    assert not mended.warnings
    assert next(one for one in mended if one.name == "pressure_angle").value == pytest.approx(70.0, abs=0.05)


def test_discs_on_cantilever_pins_share_by_pin_compliance() -> None:
    """`twodisc`, roots 9.75 and 26.25 mm away: a beam of bending and shear leaves the far disc 0.140 of the torque."""
    design = PRESETS["twodisc"].but(friction={"law": "coulomb"})
    shares = {
        support: sheet(Reducer(design.but(output={"support": support}))).quantities
        for support in ("cantilever", "both_ends")
    }
    assert shares["cantilever"]["disc_1_share"].value == pytest.approx(0.143, abs=0.002)
    assert shares["cantilever"]["disc_2_share"].value == pytest.approx(0.857, abs=0.002)
    assert shares["both_ends"]["disc_1_share"].value == pytest.approx(0.5, abs=0.002)
