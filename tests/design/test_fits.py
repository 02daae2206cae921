"""Limits and fits of ISO 286-1: published examples, and the formulas that the standard derived its tables from."""

import math
from itertools import pairwise

import pytest

from cycloid_mj.design.fits import GRADES, LETTERS, clearances, grade_width, limits

STEPS = (0, 3, 6, 10, 18, 30, 50, 80, 120, 180, 250, 315, 400, 500)
MIDDLES = [math.sqrt(max(low, 1) * high) for low, high in pairwise(STEPS)]
"""Geometric means of the steps of sizes [mm], which the formulas are of."""


def um(*values: float) -> tuple[float, ...]:
    return tuple(1e6 * value for value in values)


@pytest.mark.parametrize(
    ("zone", "mm", "lower", "upper"),
    [
        *[("H7", 25, 0, 21), ("g6", 25, -20, -7), ("h6", 10, -9, 0), ("js5", 40, -5.5, 5.5), ("m6", 8, 6, 15)],
        *[("k6", 30, 2, 15), ("k8", 30, 0, 33), ("p6", 60, 32, 51), ("r6", 60, 41, 60), ("s6", 110, 79, 101)],
        *[("G7", 25, 7, 28), ("F8", 60, 30, 76), ("JS7", 25, -10.5, 10.5), ("K7", 25, -15, 6), ("K6", 60, -15, 4)],
        *[("M7", 25, -21, 0), ("M6", 300, -41, -9), ("N7", 60, -39, -9), ("N9", 25, -52, 0), ("P7", 25, -35, -14)],
        *[("R7", 60, -60, -30), ("S7", 60, -72, -42), ("P9", 25, -74, -22), ("N7", 2, -14, -4), ("K7", 2, -10, 0)],
    ],
)
def test_zones_are_those_that_handbooks_print(zone: str, mm: float, lower: float, upper: float) -> None:
    assert um(*limits(zone, 1e-3 * mm)) == pytest.approx((lower, upper))


@pytest.mark.parametrize(
    ("fit", "mm", "least", "most"),
    [
        ("H7/g6", 25, 7, 41),
        ("H8/f7", 40, 25, 89),
        ("H7/p6", 60, -51, -2),
        ("K7/h6", 25, -15, 19),
        ("H11/c11", 500, 480, 1280),
    ],
)
def test_clearances_of_fits(fit: str, mm: float, least: float, most: float) -> None:
    assert um(*clearances(fit, 1e-3 * mm)) == pytest.approx((least, most))


FACTORS = {
    5: 7,
    6: 10,
    7: 16,
    8: 25,
    9: 40,
    10: 64,
    11: 100,
    12: 160,
    13: 250,
    14: 400,
    15: 640,
    16: 1000,
    17: 1600,
    18: 2500,
}


@pytest.mark.parametrize("grade", FACTORS)
def test_grades_follow_the_unit_of_tolerance(grade: int) -> None:
    """i = 0.45 D^(1/3) + 0.001 D um with D in mm; rounded coarsest in the first two steps of sizes."""
    for middle in MIDDLES:
        width = FACTORS[grade] * (0.45 * middle ** (1.0 / 3.0) + 0.001 * middle)
        rounded = 0.16 if middle < 3.0 else 0.10 if middle < 6.0 else 0.06
        assert um(grade_width(grade, 1e-3 * middle))[0] == pytest.approx(width, rel=rounded)


def test_fine_grades_lie_between_it1_and_it5() -> None:
    """IT1 = 0.8 + 0.020 D um, and IT2 to IT4 about a geometric series from it to IT5."""
    for middle in MIDDLES:
        first, *between, fifth = (1e6 * grade_width(grade, 1e-3 * middle) for grade in range(1, 6))
        assert first == pytest.approx(0.8 + 0.020 * middle, rel=0.2)
        series = [first * (fifth / first) ** (i / 4.0) for i in (1, 2, 3)]
        assert between == pytest.approx(series, rel=0.2)


FORMULAS = {
    "d": lambda D: -16.0 * D**0.44,
    "e": lambda D: -11.0 * D**0.41,
    "f": lambda D: -5.5 * D**0.41,
    "g": lambda D: -2.5 * D**0.34,
    "h": lambda D: 0.0,
    "k": lambda D: 0.6 * D ** (1.0 / 3.0),
    "n": lambda D: 5.0 * D**0.34,
}


@pytest.mark.parametrize("letter", FORMULAS)
def test_letters_near_the_nominal_size_follow_their_formulas(letter: str) -> None:
    for middle in MIDDLES[1:]:
        lower, upper = um(*limits(f"{letter}6", 1e-3 * middle))
        nearest = upper if letter <= "h" else lower
        assert nearest == pytest.approx(FORMULAS[letter](middle), rel=0.04, abs=1.0)


def test_shafts_of_interference_follow_from_grades_and_sizes() -> None:
    """m = IT7 - IT6; p = IT7 + 0 to 5 um; s = IT7 + 0.4 D, r the geometric mean of p and s, u = IT7 + D."""
    for mm in (57.0, 90.0, 150.0, 190.0, 264.0, 335.0, 475.0):
        grade, finer = (1e6 * grade_width(number, 1e-3 * mm) for number in (7, 6))
        m, p, r, s, u = (1e6 * limits(f"{letter}6", 1e-3 * mm)[0] for letter in "mprsu")
        assert m == pytest.approx(grade - finer, abs=1.0)
        assert -0.1 < p - grade < 5.1
        assert (s, u) == pytest.approx((grade + 0.4 * mm, grade + mm), rel=0.02)
        assert r == pytest.approx(math.sqrt(p * s), rel=0.02)


def test_zones_grow_with_size_and_grade() -> None:
    sizes = [1e-3 * (mm - 0.5) for mm in range(1, 501)]
    for grade in GRADES:
        widths = [grade_width(grade, size) for size in sizes]
        assert widths == sorted(widths)
    for letter in LETTERS:
        if letter != "js":
            far = [abs(limits(f"{letter}7", size)[1 if letter <= "h" else 0]) for size in sizes]
            assert far == sorted(far)


@pytest.mark.parametrize("zone", ["H0", "H19", "z6", "Hg6", "6", "H", "", "jS6"])
def test_other_zones_are_refused(zone: str) -> None:
    with pytest.raises(ValueError, match=r"tolerance grades are|is not a tolerance zone"):
        limits(zone, 0.025)


@pytest.mark.parametrize("fit", ["g6/H7", "H7", "H7/", "/g6", "H7g6", "H7/G6"])
def test_other_words_are_no_fit(fit: str) -> None:
    with pytest.raises(ValueError, match="a fit is the zone of a hole and that of a shaft"):
        clearances(fit, 0.025)


@pytest.mark.parametrize("mm", [0.0, -1.0, 500.1, math.nan])
def test_sizes_beyond_the_tables_are_refused(mm: float) -> None:
    with pytest.raises(ValueError, match="500"):
        limits("H7", 1e-3 * mm)
