"""Fatigue of a shaft in cams that are keyed, shrunk, clamped or splined on it."""

import pytest

from cycloid_mj.design import override, resolve
from cycloid_mj.life import rate
from cycloid_mj.parts.crank import shaft_dimensions
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.shoulder import SEATS, has_cam_shoulders, seat_factors
from cycloid_mj.stress.notch import shaft_shoulders

TWODISC = resolve("twodisc")
DIN_743_2_TABLE_1 = {
    400: (2.1, 1.8),
    500: (2.3, 2.0),
    600: (2.5, 2.2),
    700: (2.6, 2.3),
    800: (2.8, 2.5),
    900: (2.9, 2.6),
    1000: (3.0, 2.7),
    1100: (3.1, 2.8),
    1200: (3.2, 2.9),
}
"""Tensile strength [MPa]: notch factors in bending of a shaft with a key, and in a press fit, as printed."""

PRESS_FITS_IN_TORSION = {400: 1.2, 500: 1.3, 600: 1.4, 700: 1.5, 800: 1.6, 900: 1.7, 1000: 1.8, 1100: 1.8, 1200: 1.9}
"""Tensile strength [MPa]: notch factor in torsion of a shaft in a press fit, of the same table."""


def item(*changes: str):
    return rate(Reducer(override(TWODISC, list(changes)))).items["shaft_fatigue"]


@pytest.mark.parametrize("strength", DIN_743_2_TABLE_1)
def test_notch_factors_agree_with_the_table_of_din_743(strength: int) -> None:
    key, press = (SEATS[name].specimen_factors(1e6 * strength)[0] for name in ("key", "shrink"))
    assert (key, press) == pytest.approx(DIN_743_2_TABLE_1[strength], abs=0.051)


@pytest.mark.parametrize("strength", PRESS_FITS_IN_TORSION)
def test_press_fits_in_torsion_have_no_offset(strength: int) -> None:
    """The offset of 0.1 of a key would make each of the nine factors of a press fit larger than the printed one."""
    bending, torsion = SEATS["shrink"].specimen_factors(1e6 * strength)
    assert torsion == pytest.approx(0.65 * bending)
    assert round(torsion, 1) == PRESS_FITS_IN_TORSION[strength]


def test_torsion_and_splines_follow_din_743() -> None:
    """A key: 0.56 x 3 + 0.1; a press fit: 0.65 x 2.7; a spline: exp(4.2e-7 x 1000^2), 1 + 0.45 of what exceeds 1."""
    assert SEATS["key"].specimen_factors(1e9)[1] == pytest.approx(1.78)
    assert SEATS["shrink"].specimen_factors(1e9)[1] == pytest.approx(1.755)
    assert SEATS["spline"].specimen_factors(1e9) == pytest.approx((1.2349, 1.5220), abs=1e-4)


def test_thinner_shafts_than_those_of_the_tests_are_less_sensitive() -> None:
    """K3(40 mm) = 1 - 0.2 lg 3 lg(40/7.5)/lg 20 = 0.9467 and K3(16 mm) = 0.9759 of a factor of 3."""
    design = TWODISC.but(shaft={"radius": 8e-3})
    assert seat_factors(design, 1e9)[0] == pytest.approx(3.0 * 0.9467 / 0.9759, rel=1e-3)
    assert seat_factors(TWODISC.but(shaft={"radius": 20e-3}), 1e9) == pytest.approx((3.0, 1.78))


def test_a_crank_in_one_piece_has_shoulders_and_no_seats() -> None:
    for design in (resolve("pin"), TWODISC.but(shaft={"cam_joint": "one_piece"})):
        assert seat_factors(design, 1e9) is None
        assert has_cam_shoulders(design)


def test_fatigue_of_the_shaft_uses_the_joint_of_its_cams() -> None:
    keyed, shrunk = item(), item("shaft.cam_joint=shrink")
    assert "seat of a keyed cam" in keyed.note
    assert "fillet" not in keyed.note
    assert "seat of a shrunk cam" in shrunk.note
    assert keyed.safety < shrunk.safety


def test_splines_larger_than_the_journals_are_rated_as_shoulders_too() -> None:
    equal = item("shaft.cam_joint=spline", "shaft.radius_mm=8")
    larger = item("shaft.cam_joint=spline", "shaft.radius_mm=7.5")
    assert "seat of a splined cam" in equal.note
    assert "fillet of 0.3 mm at splines" in larger.note


def test_stress_at_cams_uses_the_same_factors() -> None:
    reducer = Reducer(TWODISC)
    shaft = shaft_dimensions(reducer)
    moments = 1.0 + 0.0 * shaft.stations[None, :, None].repeat(3, axis=2)
    _, *notches = shaft_shoulders(reducer, shaft, moments, shaft.stations[:1])
    factors = seat_factors(reducer.design, reducer.design.material_of("shaft").tensile_strength)
    assert {(notch.bending_factor, notch.torsion_factor) for notch in notches} == {factors}
    assert notches[0].as_json(1e9)["fillet_mm"] is None
