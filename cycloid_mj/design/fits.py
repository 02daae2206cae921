"""Limits and fits of ISO 286-1:2010, up to 500 mm: standard tolerances, zones of shafts and holes, clearances of fits.

A zone is a letter, the fundamental deviation from the nominal size, and a grade, its width: small letters are
shafts, capital letters holes. Holes follow from shafts by the rules of the standard: up to H and for JS they are
mirrored, beyond H mirrored and, in fine grades, moved by the difference of two neighbouring grades.
"""

import re
from bisect import bisect_left

_SIZES = (3, 6, 10, 18, 30, 50, 80, 120, 180, 250, 315, 400, 500)
"""Upper ends of the steps of nominal sizes [mm]; a size at an end belongs to the step below."""

LARGEST = 1e-3 * _SIZES[-1]
"""Largest nominal size [m] that is known here."""

_GRADES = """
0.8 1.2 2   3  4  6  10 14 25  40  60  100 140 250  400  600  1000 1400
1   1.5 2.5 4  5  8  12 18 30  48  75  120 180 300  480  750  1200 1800
1   1.5 2.5 4  6  9  15 22 36  58  90  150 220 360  580  900  1500 2200
1.2 2   3   5  8  11 18 27 43  70  110 180 270 430  700  1100 1800 2700
1.5 2.5 4   6  9  13 21 33 52  84  130 210 330 520  840  1300 2100 3300
1.5 2.5 4   7  11 16 25 39 62  100 160 250 390 620  1000 1600 2500 3900
2   3   5   8  13 19 30 46 74  120 190 300 460 740  1200 1900 3000 4600
2.5 4   6   10 15 22 35 54 87  140 220 350 540 870  1400 2200 3500 5400
3.5 5   8   12 18 25 40 63 100 160 250 400 630 1000 1600 2500 4000 6300
4.5 7   10  14 20 29 46 72 115 185 290 460 720 1150 1850 2900 4600 7200
6   8   12  16 23 32 52 81 130 210 320 520 810 1300 2100 3200 5200 8100
7   9   13  18 25 36 57 89 140 230 360 570 890 1400 2300 3600 5700 8900
8   10  15  20 27 40 63 97 155 250 400 630 970 1550 2500 4000 6300 9700
"""
"""Widths of the grades IT1 to IT18 [um], a row for each step of sizes (table 1)."""

_FINE_ENDS = "3 6 10 14 18 24 30 40 50 65 80 100 120 140 160 180 200 225 250 280 315 355 400 450 500"
_FINE_SIZES = tuple(map(int, _FINE_ENDS.split()))
"""Upper ends of the finer steps [mm] of the letters far from the nominal size."""

_SHAFTS = {
    "d": "-20 -30 -40 -50 -65 -80 -100 -120 -145 -170 -190 -210 -230",
    "e": "-14 -20 -25 -32 -40 -50 -60 -72 -85 -100 -110 -125 -135",
    "f": "-6 -10 -13 -16 -20 -25 -30 -36 -43 -50 -56 -62 -68",
    "g": "-2 -4 -5 -6 -7 -9 -10 -12 -14 -15 -17 -18 -20",
    "h": "0 0 0 0 0 0 0 0 0 0 0 0 0",
    "k": "0 1 1 1 2 2 2 3 3 4 4 4 5",
    "m": "2 4 6 7 8 9 11 13 15 17 20 21 23",
    "n": "4 8 10 12 15 17 20 23 27 31 34 37 40",
    "p": "6 12 15 18 22 26 32 37 43 50 56 62 68",
    "c": "-60 -70 -80 -95 -95 -110 -110 -120 -130 -140 -150 -170 -180"
    " -200 -210 -230 -240 -260 -280 -300 -330 -360 -400 -440 -480",
    "r": "10 15 19 23 23 28 28 34 34 41 43 51 54 63 65 68 77 80 84 94 98 108 114 126 132",
    "s": "14 19 23 28 28 35 35 43 43 53 59 71 79 92 100 108 122 130 140 158 170 190 208 232 252",
    "u": "18 23 28 33 33 41 48 60 70 87 102 124 144 170 190 210 236 258 284 315 350 390 435 490 540",
}
"""Fundamental deviations of shafts [um], the one nearer to the nominal size (tables 4 and 5): of c to h the upper, of
k to u the lower; k's is of the grades 4 to 7, and 0 in others."""

LETTERS = ("c", "d", "e", "f", "g", "h", "js", "k", "m", "n", "p", "r", "s", "u")
"""Letters that are known, of shafts; of holes the same in capitals."""

GRADES = range(1, 19)
"""Grades that are known."""


def grade_width(grade: int, size: float) -> float:
    """Compute the width [m] of a standard tolerance grade, for example 7 for IT7, at a nominal size [m].

    Raises
    ------
    ValueError
        There is no such grade, or the size is not in (0, 0.5].
    """
    if grade not in GRADES:
        raise ValueError(f"tolerance grades are IT{GRADES[0]} to IT{GRADES[-1]}")
    return 1e-6 * float(_GRADES.splitlines()[1 + _step(_SIZES, size)].split()[grade - 1])


def limits(zone: str, size: float) -> tuple[float, float]:
    """Compute the deviations of a tolerance zone, such as ``g6`` or ``H7``, at a nominal size [m].

    Returns
    -------
    tuple of float
        Lower and upper deviation [m].

    Raises
    ------
    ValueError
        The zone is unknown, or the size is not in (0, 0.5].
    """
    match = re.fullmatch(r"([a-z]+|[A-Z]+)(\d+)", zone)
    if not match or match[1].lower() not in LETTERS:
        raise ValueError(
            f"{zone!r} is not a tolerance zone: its letter must be one of {', '.join(LETTERS)}, in capitals for a hole"
        )
    letter, grade = match[1].lower(), int(match[2])
    width = grade_width(grade, size)
    if letter == "js":
        return -0.5 * width, 0.5 * width
    deviation = _deviation(letter, grade, size)
    if match[1].islower():
        return (deviation - width, deviation) if letter <= "h" else (deviation, deviation + width)
    if letter <= "h":
        return -deviation, width - deviation
    upper_deviation = _upper_hole_deviation(letter, grade, size)
    return upper_deviation - width, upper_deviation


def clearances(fit: str, size: float) -> tuple[float, float]:
    """Compute the clearances on the diameter of a fit, such as ``H7/g6``, at a nominal size [m].

    Returns
    -------
    tuple of float
        Least and largest clearance [m]; below zero it is an interference.

    Raises
    ------
    ValueError
        The fit is not a zone of a hole and a zone of a shaft, a zone is unknown, or the size is not in (0, 0.5].
    """
    hole, separator, shaft = fit.strip().partition("/")
    if not (separator and hole[:1].isupper() and shaft[:1].islower()):
        raise ValueError("a fit is the zone of a hole and that of a shaft, e.g. H7/g6")
    (hole_low, hole_high), (shaft_low, shaft_high) = limits(hole, size), limits(shaft, size)
    return hole_low - shaft_high, hole_high - shaft_low


def _upper_hole_deviation(letter: str, grade: int, size: float) -> float:
    """Compute the upper deviation [m] of a hole zone, of a letter after H, at a nominal size [m] (ISO 286-1, 4.3.2.5).

    The deviation is minus that of the shaft zone with the same letter. For sizes above 3 mm, and grades up to IT8 (k,
    m, n) or IT7 (p to zc), the width of the grade minus that of the next finer grade is added. `letter` is in lower
    case.
    """
    max_delta_grade = 8 if letter in "kmn" else 7
    if letter == "n" and grade > max_delta_grade:
        return 0.0 if size > 3e-3 else -_deviation(letter, grade, size)
    mirrored_deviation = -_deviation(
        letter, 7 if grade == max_delta_grade else grade, size
    )  # K8 has the k of the finer grades
    if not (size > 3e-3 and 3 <= grade <= max_delta_grade):
        return mirrored_deviation
    if letter == "m" and grade == 6 and 250e-3 < size <= 315e-3:
        return -9e-6  # the standard's one exception
    return mirrored_deviation + grade_width(grade, size) - grade_width(grade - 1, size)


def _deviation(letter: str, grade: int, size: float) -> float:
    """Compute the fundamental deviation of a shaft [m]."""
    values = _SHAFTS[letter].split()
    step_index = _step(_SIZES if len(values) == len(_SIZES) else _FINE_SIZES, size)
    return 0.0 if letter == "k" and not 4 <= grade <= 7 else 1e-6 * float(values[step_index])


def _step(ends: tuple[int, ...], size: float) -> int:
    """Find the step of nominal sizes that a size [m] is in."""
    if not 0.0 < size <= 1e-3 * ends[-1]:
        raise ValueError(
            f"the size {1e3 * size:g} mm is out of range: fits of ISO 286-1 are available up to {ends[-1]} mm"
        )
    return bisect_left(ends, round(1e3 * size, 9))
