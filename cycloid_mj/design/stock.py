"""Parts that can be bought: dowels, pin gauges, bearings, screws and inserts, with the sizes of their standards.

Sizes in the tables are millimetres and kilonewtons, as printed there; what is handed out is in SI. Dimensions are those
of the standard that is named, load ratings of the makers' catalogues that are named: others differ by some per cent.
"""

import math
from bisect import bisect_left
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cycloid_mj.base.array import Array

MM, KN = 1e-3, 1e3  # in m and in N

OFF = 1.25
"""Largest ratio of the lengths of pins in stock to the requested length, or of that to them (heuristic)."""

ROUNDING = 1e-7
"""Largest difference of two sizes that count as equal [m]."""

_LENGTHS: tuple[int, ...] = (
    *(3, 4, 5, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30, 32, 35, 40, 45, 50, 55, 60, 65, 70, 75),
    *(80, 85, 90, 95, 100),
)

_DOWELS = {
    1: (3, 10),
    1.5: (4, 16),
    2: (5, 20),
    2.5: (6, 24),
    3: (8, 30),
    4: (10, 40),
    5: (12, 50),
    6: (14, 60),
    8: (18, 80),
    10: (22, 100),
    12: (26, 100),
    16: (40, 100),
    20: (50, 100),
}
"""ISO 8734:1997, table 1, hardened, m6: diameter -> shortest and longest of `_LENGTHS`; as in FreeCAD's Fasteners
workbench (``FsData/iso8734range.csv``)."""


@dataclass(frozen=True)
class _Gauges:
    """A set of pin gauges: smallest and largest diameter, length and step [mm]."""

    low: float
    high: float
    length: int
    step: float = 0.01

    def includes(self, size: float) -> bool:
        """Return whether the set has a gauge of a diameter [mm]."""
        return self.low <= size <= self.high and abs(size / self.step - round(size / self.step)) < 1e-6


DOWELS = "ISO 8734"
"""Standard of hardened dowels, in their designation."""

GAUGES = "DIN 2269"
"""Standard of pin gauges, in their designation."""

_GAUGES, _LONG_GAUGES = _Gauges(0.2, 1.0, 40), _Gauges(1.0, 20.0, 70)
"""DIN 2269:1998 (0.1 to 20 mm), as sold: +-2 um; the lengths are those of the usual sets (assumed). The first is for
ring pins below 1 mm, which ISO 8734 does not have."""

ROLLER_LIMITS, GAUGE_LIMITS = (-2e-6, 0.0), (-1e-6, 1e-6)
"""Deviations of the diameter of needle rollers (the first group of grade G2), and of pin gauges for free pins [m]."""

_ROLLERS = {
    1: (5.8, 9.8),
    1.5: (5.8, 13.8),
    2: (6.8, 19.8),
    2.5: (7.8, 23.8),
    3: (9.8, 29.8),
    3.5: (11.8, 34.8),
    4: (13.8, 39.8),
    5: (15.8, 49.8),
    6: (17.8, 59.8),
}
"""ISO 3096 (DIN 5402-3), needle rollers with flat ends: diameter -> shortest and longest of `_ROLLER_LENGTHS` (the
makers' usual ranges, assumed). SKF's grade G2 has diameters sorted in groups of 2 um, 0/-2 um and so on, and lengths
h13."""

_ROLLER_LENGTHS = (
    *(5.8, 6.8, 7.8, 9.8, 11.8, 13.8, 15.8, 17.8, 19.8, 21.8, 23.8, 25.8, 27.8, 29.8, 34.8, 39.8, 49.8, 59.8),
)

_KEYS = """
6 8 2 2 1.2 1 6 20          8 10 3 3 1.8 1.4 6 36       10 12 4 4 2.5 1.8 8 45    12 17 5 5 3 2.3 10 56
17 22 6 6 3.5 2.8 14 70     22 30 8 7 4 3.3 18 90       30 38 10 8 5 3.3 22 110   38 44 12 8 5 3.3 28 140
44 50 14 9 5.5 3.8 36 160   50 58 16 10 6 4.3 45 180    58 65 18 11 7 4.4 50 200  65 75 20 12 7.5 4.9 56 220
"""
"""DIN 6885-1:1968, parallel keys: shaft above, up to, width, height, depth in the shaft, depth in the hub, shortest and
longest; as in engineeringhardware.com and Siemens MD 31.1."""

_KEY_LENGTHS = (
    *(6, 8, 10, 12, 14, 16, 18, 20, 22, 25, 28, 32, 36, 40, 45, 50, 56, 63, 70, 80, 90, 100, 110, 125, 140, 160),
)
"""Lengths of DIN 6885-1 [mm]."""

_SPLINES = """
6 11 14 3    6 13 16 3.5  6 16 20 4    6 18 22 5    6 21 25 5    6 23 26 6    6 23 28 6     6 26 30 6     6 26 32 6
6 28 32 7    6 28 34 7    8 32 36 6    8 32 38 6    8 36 40 7    8 36 42 7    8 42 46 8     8 42 48 8     8 46 50 9
8 46 54 9    8 52 58 10   8 52 60 10   8 56 62 10   8 56 65 10   8 62 68 12   8 62 72 12    10 72 78 12   10 72 82 12
10 82 88 12  10 82 92 12  10 92 98 14  10 92 102 14 10 102 108 16 10 102 112 16 10 112 120 18 10 112 125 18
"""
"""ISO 14:1982, straight-sided splines of the light and the medium series: number of splines, minor diameter, major
diameter, width of a spline; as in roymech.co.uk."""

_TUBES: dict[float, tuple[float, float]] = {
    **{size: (wall, 0.1) for size, wall in zip((4, 5, 6, 7, 8, 9, 10), (1, 1.5, 2, 2, 2.5, 2.5, 3), strict=True)},
    **dict.fromkeys((12, 14, 15, 16, 18, 20, 22, 25, 28), (3, 0.08)),
    30: (3, 0.15),
}
_TUBE_WALLS = 0.5, 0.8, 1.0, 1.2, 1.5, 2.0, 2.5, 3.0
"""EN 10305-1, seamless precision steel tubes, cold finished: outside diameter -> the thickest of the usual walls, where
makers have thicker ones too, and the largest deviation of the outside diameter [mm] (DIN 2391-1:1981, its predecessor).
"""

BORING_ALLOWANCE = 0.2e-3
"""Smallest allowance in diameter to bore and ream a tube [m]: its own bore deviates by up to 0.15 mm (assumed)."""

_DRAWN_CUPS = """
3 6.5 6 0.925 0.6   4 8 8 1.54 1.07   5 9 9 2.2 1.79   6 10 8 1.98 1.54   6 10 9 2.65 2.4   7 11 9 2.85 2.75
8 12 8 2.55 2.4   8 12 10 3.5 3.65   9 13 10 4 4.3   9 13 12 5 5.9   10 14 10 4.1 4.7   10 14 12 5.1 6.3
10 14 15 6.3 8.2   12 16 10 4.6 5.8   12 18 12 6 6.8   13 19 12 6.3 7.3   14 20 12 6.6 7.9   14 20 16 10.7 14
15 21 12 7.3 8.7   15 21 16 9.8 13.4   16 22 12 7.1 9   16 22 16 10.1 14.2   17 23 12 6.9 9.3
18 24 12 7.5 10.1   18 24 16 10.8 16   20 26 10 6 7.6   20 26 12 8 11.2   20 26 16 12 19   20 26 20 15.5 24
22 28 10 7 10   22 28 12 8.5 12.5   22 28 16 12.5 20.5   22 28 20 15 27   25 32 12 10 15   25 32 16 14.5 22
25 32 20 18.5 30   28 35 16 15 24.5   28 35 20 20 33.5   30 37 12 11 17   30 37 16 16 27   30 37 20 21 37
35 42 12 12 20   35 42 16 18.5 31   35 42 20 22 43   40 47 12 13 22.6   40 47 16 18.6 36   40 47 20 24 50
45 52 12 14 25.5   45 52 16 20 40.5   45 52 20 25 54.5   50 58 20 29 58.5   50 58 25 35.8 78
55 63 20 29.5 62.3   60 68 12 16.2 30   60 68 20 31 70
"""
"""ISO 3245:2015, drawn cup needle roller bearings with open ends (HK): bore over the needles, outside, width, dynamic
and static load rating [kN].

Ratings are of ZEN, Standard catalogue V.10/12; of HK0408, HK0509 and HK1712 of FBJ, of HK1416 of NTN (CAT. 2300), of
HK0306 the dynamic one of NTN, the static one as much less as that of HK0408 is (assumed). NTN's (CAT. 2203/E) are 4 to
10 % higher where both were compared.
"""

_NEEDLE_BEARINGS = """
00 14 22 13 8.5 9.2   01 16 24 13 9.4 10.9   02 20 28 13 10.6 13.6   03 22 30 13 11 14.6   04 25 37 17 19 23.6
05 30 42 17 23.6 31.5   06 35 47 17 23.2 33.5   07 42 55 20 29 49   08 48 62 22 40 64   09 52 68 22 41.5 69.5
10 58 72 22 43 76.5   11 63 80 25 58 100   12 68 85 25 60 108   13 72 90 25 61 112   14 80 100 30 85.5 156
15 85 105 30 87 162   16 90 110 30 90.5 174   17 100 120 35 112 237   18 105 125 35 116 252
19 110 130 35 118 260   20 115 140 40 127 260   22 125 150 40 131 279   24 135 165 45 180 380
26 150 180 50 202 455   28 160 190 50 209 485
"""
"""ISO 1206:2018, machined needle roller bearings without inner ring (RNA 49): number, bore, outside, width, dynamic and
static load rating [kN]: of ZEN, Standard catalogue V.10/12, from RNA4914 on of NTN (CAT. 2203/E).
"""

_BALL_BEARINGS = """
623 3 10 4 0.488 0.146     624 4 13 5 0.936 0.29     625 5 16 5 1.14 0.38       626 6 19 6 2.34 0.95
607 7 19 6 2.34 0.95       608 8 22 7 3.45 1.37      627 7 22 7 3.45 1.37       629 9 26 8 4.75 1.96
61900 10 22 6 2.7 1.27     61901 12 24 6 2.91 1.46   61902 15 28 7 4.36 2.24    61903 17 30 7 4.62 2.55
61904 20 37 9 6.37 3.65    61905 25 42 9 7.02 4.3    61906 30 47 9 7.28 4.55    61907 35 55 10 9.56 6.8
61908 40 62 12 13.8 10     61909 45 68 12 14 10.8    61910 50 72 12 14.6 11.8
6000 10 26 8 4.75 1.96     6001 12 28 8 5.4 2.36     6002 15 32 9 5.85 2.85     6003 17 35 10 6.37 3.25
6004 20 42 12 9.95 5       6005 25 47 12 11.9 6.55   6006 30 55 13 13.8 8.3     6007 35 62 14 16.8 10.2
6008 40 68 15 17.8 11      6009 45 75 16 22.1 14.6   6010 50 80 16 22.9 16
6200 10 30 9 5.4 2.36      6201 12 32 10 7.28 3.1    6202 15 35 11 8.06 3.75    6203 17 40 12 9.95 4.75
6204 20 47 14 13.5 6.55    6205 25 52 15 14.8 7.8    6206 30 62 16 20.3 11.2    6207 35 72 17 27 15.3
6208 40 80 18 32.5 19      6209 45 85 19 35.1 21.6   6210 50 90 20 37.1 23.2
"""
"""ISO 15:2017, deep groove ball bearings: number, bore, outside, width, dynamic and static load rating [kN] of SKF,
Rolling bearings (PUB BU/P1 17000 EN), 2018.
"""

_THIN_BALL_BEARINGS = """
618/3 3 7 2 0.314 0.108   618/4 4 9 2.5 0.638 0.226   618/5 5 11 3 0.716 0.294   618/6 6 13 3.5 1.079 0.441
618/7 7 14 3.5 1.177 0.51   618/8 8 16 4 1.256 0.589   618/9 9 17 4 1.256 0.589   61800 10 19 5 1.38 0.585
61801 12 21 5 1.43 0.67   61802 15 24 5 1.56 0.8   61803 17 26 5 1.68 0.93   61804 20 32 7 2.7 1.5
61805 25 37 7 4.36 2.6   61806 30 42 7 4.49 2.9   61807 35 47 7 4.75 3.2   61808 40 52 7 4.94 3.45
61809 45 58 7 6.05 4.3   61810 50 65 7 6.24 4.75   61811 55 72 9 8.32 6.2   61812 60 78 10 8.71 6.7
61813 65 85 10 11.7 9.15   61814 70 90 10 12.1 12.7   61815 75 95 10 12.5 13.9   61816 80 100 10 12.7 14.5
61817 85 110 13 18.7 20   61818 90 115 13 19 21   61819 95 120 13 19.3 22   61820 100 125 13 19.6 23
61822 110 140 16 28.1 32.5   61824 120 150 16 28.9 35.5   61826 130 165 18 37 44   61828 140 175 18 38.5 48
61830 150 190 20 47.5 58.5   61832 160 200 20 48.5 61   61834 170 215 22 60 75   61836 180 225 22 60.5 78.5
61838 190 240 24 73 93.5   61840 200 250 24 74 98
"""
"""ISO 15:2017, dimension series 18, deep groove ball bearings for an output's hub: number, bore, outside, width,
dynamic and static load rating [kN] of FBJ's miniature and thin section bearings (68); 618/9 as 618/8 (assumed).
"""

_ANGULAR_CONTACT = """
71810 50 65 7 7.2 9.8   71811 55 72 9 9.9 13   71812 60 78 10 13 17.5   71813 65 85 10 13.2 18
71814 70 90 10 13.5 20   71815 75 95 10 14 21   71816 80 100 10 14.1 22   71817 85 110 13 21 31
71818 90 115 13 21 32   71819 95 120 13 21.5 33   71820 100 125 13 22 35.5   71821 105 130 13 22.3 36.5
71822 110 140 16 31 49   71824 120 150 16 32 54.5   71826 130 165 18 37 64.5   71828 140 175 18 43 75.5
71830 150 190 20 49 87.5   71832 160 200 20 53.5 67.5   71834 170 215 22 63.5 81   71836 180 225 22 66.5 86
71838 190 240 24 76 101   71840 200 250 24 76 105.5   71844 220 270 24 78 110   71848 240 300 28 99 141
71852 260 320 28 100.5 147.6   71856 280 350 33 128 191   71860 300 380 38 167 235   71864 320 400 38 170.5 241
"""
"""ISO 15:2017, dimension series 18, angular contact ball bearings with a contact angle of 25 deg for the flanges of an
RV reducer: number, bore, outside, width, dynamic and static load rating [kN] of IBC, High Precision Bearings
(TI-I-5050.0/E, 2010), type 718 E.
"""

_TAPERED_BEARINGS = """
32004X 20 42 15 29.7 27 10 0.37     32005X 25 47 15 33.2 32.5 11 0.43   32006X 30 55 17 43.9 44 13 0.43
32007X 35 62 18 52.3 54 14 0.46     32008X 40 68 19 64.7 71 14 0.37     32009X 45 75 20 71.7 80 16 0.4
32910 50 72 15 41.3 53 13 0.35      32911 55 80 17 51.7 69.5 14 0.31    32912 60 85 17 53.2 75 15 0.33
32913 65 90 17 54.7 80 16 0.35      32914 70 100 20 85.8 112 17 0.31    32915 75 105 20 86.8 116 18 0.33
32916 80 110 20 89.7 125 19 0.35    32917 85 120 23 115 156 21 0.33     32918 90 125 23 119 166 22 0.35
32919 95 130 23 121 173 23 0.35     32920 100 140 25 147 204 23 0.33    32921 105 145 25 149 212 25 0.35
32922 110 150 25 154 224 26 0.35    32924 120 165 29 204 305 28 0.35    32926 130 180 32 245 365 31 0.33
32928 140 190 32 252 390 33 0.35    32930 150 210 38 346 530 35 0.33    32932 160 220 38 349 540 38 0.35
32934 170 230 38 351 585 41 0.37    32936 180 250 45 435 735 53 0.48    32938 190 260 45 443 765 54 0.48
32940 200 280 51 588 950 53 0.4
"""
"""ISO 355:2019, tapered roller bearings of the series 329, below 50 mm 320: number, bore, outside, width T, dynamic and
static load rating [kN], distance a of the load centre from the back face of the outer ring, and e, the axial load over
the radial load from which on it reduces the life. They are SKF's values from a table (CSV) in a public repository, not
compared with SKF's catalogue.
"""

_CRANK_BEARINGS = """
30202 15 35 11.75 14.8 13.2 8.2 0.32    30203 17 40 13.25 20.1 19.9 9.7 0.35    32004X 20 42 15 24.6 27.4 10.6 0.37
320/22X 22 44 15 25.6 29.4 11.1 0.4     33005 25 47 17 31 38 11 0.29            320/28X 28 52 16 32 39 12.8 0.43
32906 30 47 12 17.6 24.4 9.2 0.32       33006 30 55 20 42 54 13.1 0.29          320/32X 32 58 17 37.5 47 14.2 0.45
32907 35 55 14 27.4 39 10.7 0.29        33007 35 62 21 49 65 14.1 0.31          32908 40 62 15 34 47 11.5 0.29
33008 40 68 22 59 81.5 14.6 0.28        32909 45 68 15 34.5 50.5 12.3 0.32      33009 45 75 24 69 99 16.3 0.29
32910 50 72 15 36 54 13.5 0.34          33010 50 80 24 70.5 104 17.4 0.32
"""
"""ISO 355:2019, tapered roller bearings of small section for the cranks of RV reducers: columns as `_TAPERED_BEARINGS`.

Ratings, a and e are NSK's, from the text of its catalogue of rolling bearings in a public repository. For 32004 X,
SKF's C in `_TAPERED_BEARINGS` is 21 % higher and its C0 1 % lower.
"""

DEEP_GROOVE_FILLED_ANGLE = math.radians(195.0)
"""Angle between the rings that the balls of a deep groove bearing fill [rad] (Conrad; Harris, Rolling Bearing
Analysis)."""


@dataclass(frozen=True)
class AngularContactSeries:
    """The series 718 of angular contact ball bearings, with the dimensions of the series 618 (ISO 15).

    Their ratings are estimated from those of 618 by the balls: C ~ Z^(2/3) (cos a)^0.7 (ISO 281), C0 ~ Z cos a (ISO
    76), with balls of equal size.

    Attributes
    ----------
    angle
        Contact angle [rad]: 25 deg, suffix ACD (SKF, Super-precision bearings, 718 series).
    filled_angle
        Angle between the rings that the balls fill [rad]: a web of the cage is a third of a ball (assumed).
    largest_bore
        Bore of the largest bearing of the series [m].
    """

    angle: float = math.radians(25.0)
    filled_angle: float = math.radians(270.0)
    largest_bore: float = 160e-3


ANGULAR_CONTACT = AngularContactSeries()

_CROSSED_ROLLERS = """
RB 20 36 8 27 3.23 3.1        RB 25 41 8 32 3.63 3.83       RB 30 55 10 41.5 7.35 8.36    RB 35 60 10 46.5 7.64 9.12
RB 40 65 10 51.5 8.33 10.6    RB 45 70 10 56.5 8.62 11.3    RB 50 80 13 64 16.7 20.9      RB 60 90 13 74 18 24.3
RB 70 100 13 84 19.4 27.7     RB 80 120 16 98 30.1 42.1     RB 90 130 16 108 31.4 45.3    RB 110 145 15 126.5 23.7 41.5
RB 120 150 16 134.2 24.2 43.2 RB 130 160 15 144.5 25 46.7   RB 140 175 16 154.8 25.9 50.1 RB 150 180 13 164 27 53.5
RA 50 66 8 57 5.1 7.19        RA 60 76 8 67 5.68 8.68       RA 70 86 8 77 5.98 9.8        RA 80 96 8 87 6.37 11.3
RA 90 106 8 97 6.76 12.4      RA 100 116 8 107 7.15 13.9    RA 110 126 8 117 7.45 15      RA 120 136 8 127 7.84 16.5
RA 130 146 8 137 7.94 17.6    RA 140 156 8 147 8.33 19.1    RA 150 166 8 157 8.82 20.6    RA 160 186 13 172 23.3 44.9
RA 170 196 13 182 23.5 46.5   RA 180 206 13 192 24.5 49.8   RA 190 216 13 202 24.9 51.5   RA 200 226 13 212 25.8 54.7
"""
"""Crossed roller bearings: series, bore, outside, width, pitch circle, dynamic and static load rating [kN].

They are of THK, Cross-Roller Ring Series (No. 382-3E). RA is the thin series, RB has larger sections; other makers sell
bearings of the same dimensions. The designation is series, bore and width; UU is sealed, CC0 preloaded.
"""

_BARS = (3, 4, 5, 6, 8, 10, 12, 14, 15, 16, 18, *range(20, 61, 5), 80)
"""Diameters of shafts of hardened and ground steel, h6, by the metre (ISO 13012-1 has bushings for most of them)."""

_BOLTS = """
1.6 3 1.6   2 3.8 2   2.5 4.5 2.5   3 5.5 3   4 7 4   5 8.5 5   6 10 6   8 13 8   10 16 10   12 18 12   16 24 16
"""
"""ISO 4762:2004, table 1, hexagon socket head cap screws: thread, d_k max of a plain head, k max; as in
``FsData/iso4762def.csv`` of FreeCAD's Fasteners workbench, and amesweb.info."""

_BOLT_LENGTHS: tuple[int, ...] = (
    *(3, 4, 5, 6, 8, 10, 12, 16, 20, 25, 30, 35, 40, 45, 50, 55, 60, 65, 70, 80, 90, 100, 110, 120, 130, 140, 150, 160),
)
"""Lengths of screws of ISO 4762 [mm]."""

_BOLT_RANGES = {
    1.6: (2.5, 16),
    2: (3, 20),
    2.5: (4, 25),
    3: (5, 30),
    4: (6, 40),
    5: (8, 50),
    6: (10, 60),
    8: (12, 80),
    10: (16, 100),
    12: (20, 120),
    16: (25, 160),
}
"""ISO 4762:2004, table 1: thread -> length of the shortest and of the longest screw [mm].

FreeCAD's Fasteners workbench also lists M6 x 8 mm and M8 x 10 mm, as DIN 912; all other lengths agree.
"""

_BOLT_HOLES = {1.6: 1.8, 2: 2.4, 2.5: 2.9, 3: 3.4, 4: 4.5, 5: 5.5, 6: 6.6, 8: 9, 10: 11, 12: 13.5, 16: 17.5}
"""ISO 273:1979, medium (H13): thread -> clearance hole [mm]; as in engineeringhardware.com and NBK's technical data."""

_PITCHES = {1.6: 0.35, 2: 0.4, 2.5: 0.45, 3: 0.5, 4: 0.7, 5: 0.8, 6: 1, 8: 1.25, 10: 1.5, 12: 1.75, 16: 2}
"""ISO 261:1998, coarse pitch of a thread [mm]."""

_HEAD_BEARINGS = dict(
    zip(_PITCHES, (2.72, 3.48, 4.18, 5.07, 6.53, 8.03, 9.38, 12.33, 15.33, 17.23, 23.17), strict=True)
)
"""ISO 4762:2004, table 1, d_w min: thread -> diameter of the bearing face under the head [mm]."""

_WASHERS = """
1.6 1.7 4 0.3   2 2.2 5 0.3   2.5 2.7 6 0.5   3 3.2 7 0.5   4 4.3 9 0.8   5 5.3 10 1   6 6.4 12 1.6   8 8.4 16 1.6
10 10.5 20 2   12 13 24 2.5   16 17 30 3
"""
"""ISO 7089:2000, plain washers, product grade A: thread, bore d_1 min, outside d_2 max, thickness h [mm]; as in
``FsData/iso7089def.csv`` of FreeCAD's Fasteners workbench."""

_INSERTS = """
2 3.2 4   2.5 4 5.7   3 4 5.7   4 5.6 8.1   5 6.4 9.5   6 8 12.7   8 9.6 12.7   10 12 12.7
"""
"""Heat-set inserts for plastics: thread, hole d_3, length; of RX-M2x4 to RX-M10x12.7 in the maker's table of sizes
(ruthex.de, 2025)."""


_SHAFT_RINGS = """
3 0.4 2.8 2 0.8      4 0.4 3.8 2.2 0.9    5 0.6 4.8 2.5 1.1    6 0.7 5.7 2.7 1.3    7 0.8 6.7 3.1 1.4
8 0.8 7.6 3.2 1.5    9 1 8.6 3.3 1.7      10 1 9.6 3.3 1.8     11 1 10.5 3.3 1.8    12 1 11.5 3.3 1.8
13 1 12.4 3.4 2      14 1 13.4 3.5 2.1    15 1 14.3 3.6 2.2    16 1 15.2 3.7 2.2    17 1 16.2 3.8 2.3
18 1.2 17 3.9 2.4    20 1.2 19 4 2.6      22 1.2 21 4.2 2.8    24 1.2 22.9 4.4 3    25 1.2 23.9 4.4 3
26 1.2 24.9 4.5 3.1  28 1.5 26.6 4.7 3.2  30 1.5 28.6 5 3.5    32 1.5 30.3 5.2 3.6  35 1.5 33 5.6 3.9
40 1.75 37.5 6 4.4   45 1.75 42.5 6.7 4.7 50 2 47 6.9 5.1
"""
"""DIN 471:2011, retaining rings for shafts: shaft, thickness, groove, largest height of the eyes from the shaft,
largest width of the ring; as in ``FsData/din471def.csv`` of FreeCAD's Fasteners workbench."""

_BORE_RINGS = """
10 1 10.4 3.2 1.4     13 1 13.6 3.6 1.8     16 1 16.8 3.8 2       19 1 20 4.1 2.2      22 1 23 4.2 2.5
24 1.2 25.2 4.4 2.6   26 1.2 27.2 4.7 2.8   28 1.2 29.4 4.8 2.9   30 1.2 31.4 4.8 3    32 1.2 33.7 5.4 3.2
35 1.5 37 5.4 3.4     37 1.5 39 5.5 3.6     40 1.75 42.5 5.8 3.9  42 1.75 44.5 5.9 4.1 47 1.75 49.5 6.4 4.4
52 2 55 6.7 4.7       55 2 58 6.8 5         58 2 61 6.9 5.2       62 2 65 7.3 5.5      65 2.5 68 7.6 5.8
68 2.5 71 7.8 6.1     72 2.5 75 7.8 6.4     75 2.5 78 7.8 6.6     78 2.5 81 8.5 6.8    80 2.5 83.5 8.5 7
85 3 88.5 8.6 7.2     90 3 93.5 8.6 7.6
"""
"""DIN 472:2017, retaining rings for bores: as `_SHAFT_RINGS`, from ``FsData/din472def.csv``."""

_SEAL_RINGS = """
4 8 2    5 9 2    6 10 2   7 11 2   8 12 3   9 13 3   10 14 3  12 16 3  12 18 3  13 19 3  14 20 3  15 21 3  16 22 3
17 23 3  18 24 3  20 26 4  22 28 4  25 32 4  28 35 4  30 37 4  35 42 4  40 47 4  45 52 4  50 58 4
"""
"""Seal rings with one lip for needle bearings, type G of INA and NTN (CAT. 2300): shaft, outside, width. They have the
outside diameter of drawn cups, and are pressed into the same bore (NTN: G7 to R7). No standard applies to them. Widths
are assumed, 2 mm up to shafts of 7 mm, 3 mm up to 18 mm and 4 mm beyond: compare them with the maker's before ordering.
They determine only how much longer the motor cover is."""

SNAP_LAND = 3.0
"""Length of the shaft or bore beyond the groove of a retaining ring, relative to the depth of the groove (DIN 471)."""


@dataclass(frozen=True)
class Dowel:
    """A round pin: designation, diameter and length [m]."""

    designation: str
    diameter: float
    length: float


@dataclass(frozen=True)
class Roller:
    """A free pin: a needle roller or a pin gauge, with designation, diameter and length as sold [m].

    `limits` are the lower and upper deviation of its diameter [m]; `count` of them stand in line, each cut to the
    length `cut` [m] if that is not 0.
    """

    designation: str
    limits: tuple[float, float]
    diameter: float
    length: float
    count: int = 1
    cut: float = 0.0

    @property
    def used_length(self) -> float:
        """Length in the drive [m]."""
        return self.cut or self.length


@dataclass(frozen=True)
class Tube:
    """A steel tube: designation, outside and inside diameter [m]."""

    designation: str
    outside: float
    bore: float


@dataclass(frozen=True)
class StockSpline:
    """A straight-sided spline: designation, number of splines, minor and major diameter, width of a spline [m]."""

    designation: str
    count: int
    minor: float
    major: float
    width: float


@dataclass(frozen=True)
class StockKey:
    """A parallel key: designation, width, height and length, depths of its keyways in shaft and hub [m]."""

    designation: str
    width: float
    height: float
    length: float
    in_shaft: float
    in_hub: float


@dataclass(frozen=True)
class ShoulderShares:
    """Heights of the shoulders next to the rings of a bearing, relative to its section (D - d)/2 [1].

    Attributes
    ----------
    ball, crossed_roller
        Height at both rings (balls: assumed; crossed rollers: the least of THK's dimensions for series RA and RB).
    tapered
        Height at the inner and at the outer ring of a tapered roller bearing: series 329 has 0.22 to 0.34, and 0.2 to
        0.32 (SKF, Rolling bearings, 2018: d_b min, D_a max).
    """

    ball: float = 0.3
    crossed_roller: float = 0.19
    tapered: tuple[float, float] = (0.34, 0.25)


SHOULDERS = ShoulderShares()


@dataclass(frozen=True)
class StockBearing:
    """A rolling bearing: designation, bore, outside and width [m], load ratings [N], contact angle [rad].

    `pitch` is the diameter of the pitch circle of crossed rollers [m]; 0 for all other bearings. `load_centre` is the
    distance of the load centre of tapered rollers from the back face of their outer ring [m]; 0 for all others.
    """

    designation: str
    bore: float
    outside: float
    width: float
    dynamic: float
    static: float
    contact_angle: float = 0.0
    pitch: float = 0.0
    load_centre: float = 0.0

    @property
    def has_tapered_rollers(self) -> bool:
        """Whether it is a tapered roller bearing, two of which support the output."""
        return self.load_centre > 0.0

    @property
    def has_crossed_rollers(self) -> bool:
        """Whether it is a crossed roller bearing, a single one of which supports the output."""
        return self.pitch > 0.0

    @property
    def has_balls(self) -> bool:
        """Whether the bearing, one of those for the output, has balls instead of rollers."""
        return not (self.has_tapered_rollers or self.has_crossed_rollers)

    @property
    def shoulders(self) -> tuple[float, float]:
        """Largest radius of a shoulder beside the inner ring, and smallest of one beside the outer ring [m].

        They are for a bearing of the output; within them, a shoulder touches one ring only.
        """
        bore_radius, outer_radius = 0.5 * self.bore, 0.5 * self.outside
        shoulder_shares = SHOULDERS.ball, SHOULDERS.ball
        if self.has_tapered_rollers:
            shoulder_shares = SHOULDERS.tapered
        elif self.has_crossed_rollers:
            shoulder_shares = SHOULDERS.crossed_roller, SHOULDERS.crossed_roller
        return bore_radius + shoulder_shares[0] * (outer_radius - bore_radius), outer_radius - shoulder_shares[1] * (
            outer_radius - bore_radius
        )

    @property
    def load_centre_offset(self) -> float:
        """Distance from its middle to the point at which its lines of contact meet the axis [m]."""
        if self.load_centre:
            return self.load_centre - 0.5 * self.width
        return 0.25 * (self.bore + self.outside) * math.tan(self.contact_angle)


@dataclass(frozen=True)
class Bolt:
    """A socket head screw: designation, thread, diameter and height of its head [m]."""

    designation: str
    thread: float
    head: float
    head_height: float


@dataclass(frozen=True)
class Insert:
    """A heat-set insert: designation, thread, hole and length [m]."""

    designation: str
    thread: float
    hole: float
    length: float


@dataclass(frozen=True)
class Washer:
    """A plain washer: designation, bore, outside diameter and thickness [m]."""

    designation: str
    bore: float
    outside: float
    thickness: float


@dataclass(frozen=True)
class RetainingRing:
    """A retaining ring: designation, and diameters of its shaft or bore and of its groove [m].

    Further dimensions are its `thickness` and largest `width` across, and the `height` of its eyes from the shaft or
    bore [m].
    """

    designation: str
    diameter: float
    groove: float
    thickness: float
    height: float
    width: float

    @property
    def is_internal(self) -> bool:
        """Whether the ring is in a bore."""
        return self.groove > self.diameter

    @property
    def radii(self) -> tuple[float, float]:
        """Inner and outer radius of the ring in its groove [m]."""
        radius = 0.5 * self.groove
        return (radius - self.width, radius) if self.is_internal else (radius, radius + self.width)

    @property
    def eye_radius(self) -> float:
        """Radius up to which the eyes protrude from the shaft, or into the bore [m]."""
        return 0.5 * self.diameter + (-self.height if self.is_internal else self.height)

    @property
    def groove_width(self) -> float:
        """Width of the groove [m] (DIN 471)."""
        return self.thickness + (0.1e-3 if self.thickness < 2e-3 else 0.15e-3)

    @property
    def groove_zone(self) -> str:
        """Tolerance zone of the diameter of the groove (DIN 471 and 472)."""
        grade = 10 if self.diameter <= 10e-3 else 11 if self.diameter <= 22e-3 else 12
        return f"H{max(grade, 11)}" if self.is_internal else f"h{grade}"

    @property
    def room(self) -> float:
        """Length of the groove with the land beyond it [m]."""
        return self.groove_width + SNAP_LAND * 0.5 * abs(self.diameter - self.groove)


@dataclass(frozen=True)
class SealRing:
    """A seal ring of a shaft: designation, bore, outside diameter and width [m]."""

    designation: str
    bore: float
    outside: float
    width: float


@cache
def pin_diameters() -> tuple[float, ...]:
    """List the diameters of hardened pins [m], from the thinnest on."""
    numbers = range(round(_GAUGES.low / _GAUGES.step), round(_GAUGES.high / _GAUGES.step))
    return _metres(*(number * _GAUGES.step for number in numbers), *_DOWELS)


def dowel_diameters() -> tuple[float, ...]:
    """List the diameters of dowels [m], from the thinnest on."""
    return _metres(*_DOWELS)


def longest_dowel(diameter: float, max_length: float) -> Dowel | None:
    """Return the longest dowel in stock with a diameter and up to a length [m]; None if all are longer."""
    size_mm = round(diameter / MM, 6)
    shortest, longest = _DOWELS[size_mm]
    lengths = [item for item in _LENGTHS if shortest <= item <= min(longest, max_length / MM + 1e-6)]
    return Dowel(f"{DOWELS} - {size_mm:g} x {lengths[-1]} - A", diameter, lengths[-1] * MM) if lengths else None


def pins(diameter: float, length: float) -> tuple[Dowel, int] | None:
    """Return the pin in stock for a diameter [m] and a length [m], and how many are in line; None if there is none.

    If there are dowels (ISO 8734) of the diameter, it is the shortest that fills the length alone or, if all are too
    short, in line with equal dowels. For other diameters below 1 mm it is one pin gauge (DIN 2269), whatever the
    length.
    """
    size_mm, length_mm = round(diameter / MM, 6), length / MM
    if size_mm in _DOWELS:
        min_length, max_length = _DOWELS[size_mm]
        count = max(-(-length_mm // max_length), 1)
        stock_lengths = [stock_length for stock_length in _LENGTHS if min_length <= stock_length <= max_length]
        dowel_length = stock_lengths[min(bisect_left(stock_lengths, length_mm / count - 1e-6), len(stock_lengths) - 1)]
        return Dowel(f"{DOWELS} - {size_mm:g} x {dowel_length} - A", diameter, dowel_length * MM), int(count)
    if size_mm < _GAUGES.high and _GAUGES.includes(size_mm):
        return Dowel(f"{GAUGES} - {size_mm:.2f} x {_GAUGES.length}", diameter, _GAUGES.length * MM), 1
    return None


def is_dowel(diameter: float, length: float) -> bool:
    """Return whether a dowel with a diameter [m] and a length [m] is in stock, so that it need not be cut."""
    stock_pins = pins(diameter, length)
    return stock_pins is not None and stock_pins[1] == 1 and abs(stock_pins[0].length - length) < ROUNDING


def single_pin(diameter: float, length: float) -> Dowel | None:
    """Return the pin in stock with a diameter [m] that fills a length [m] in one piece; None if there is none.

    It is the result of `pins` if that is a single pin, else a longer pin gauge, which is to be cut to length.
    """
    stock_pins = pins(diameter, length)
    if not stock_pins or stock_pins[1] == 1:
        return stock_pins[0] if stock_pins else None
    return pin_gauge(diameter, length)


def pin_gauge(diameter: float, length: float) -> Dowel | None:
    """Return the pin gauge with a diameter [m], to be cut to a length [m]; None if there is none of sufficient length.

    Gauges are within 1 um of their nominal diameter. Dowels (m6) are 2 to 12 um thicker, and jam in a bore of a few
    micrometres of clearance.
    """
    size = round(diameter / MM, 6)
    for gauges in (_GAUGES, _LONG_GAUGES):
        if gauges.includes(size) and length <= gauges.length * MM:
            return Dowel(f"{GAUGES} - {size:.2f} x {gauges.length}", diameter, gauges.length * MM)
    return None


def free_pin(diameter: float, width: float, play: float) -> Roller | None:
    """Return the needle roller or pin gauge for a free pin between two covers; None if none has the diameter.

    If the longest one is too short, several equal pieces are placed in line, each with an equal share of `width`. A
    needle roller that is shorter than this share by at most five times `play` is used uncut. Otherwise a longer
    roller, or a pin gauge, is to be cut.

    Parameters
    ----------
    diameter
        Diameter of the pin [m].
    width
        Distance of the covers [m].
    play
        Axial play at each end [m].
    """
    size_mm, width_mm = round(diameter / MM, 6), width / MM
    if size_mm in _ROLLERS:
        shortest, longest = _ROLLERS[size_mm]
        lengths = [length for length in _ROLLER_LENGTHS if shortest <= length <= longest]
        count = max(-(-(width_mm - 5.0 * play / MM) // longest), 1)
        stock_length = next((item for item in lengths if 0.0 <= width_mm / count - item <= 5.0 * play / MM), 0.0)
        cut_length = 0.0 if stock_length else width / count - 2.0 * play
        length = stock_length or next(item for item in lengths if item >= width_mm / count - 2.0 * play / MM - 1e-6)
        return Roller(
            f"ISO 3096 - {size_mm:g} x {length:g} - G2", ROLLER_LIMITS, diameter, length * MM, int(count), cut_length
        )
    longest = next((gauges.length for gauges in (_GAUGES, _LONG_GAUGES) if gauges.includes(size_mm)), 0)
    if not longest:
        return None
    count = int(max(-(-(width_mm - 2.0 * play / MM) // longest), 1))
    designation = f"{GAUGES} - {size_mm:.2f} x {longest:g}"
    return Roller(designation, GAUGE_LIMITS, diameter, longest * MM, count, width / count - 2.0 * play)


def key_for(shaft: float, max_length: float) -> StockKey | None:
    """Return the longest parallel key (DIN 6885) for a shaft diameter [m], at most `max_length` [m]; else None."""
    for min_diameter, max_diameter, width, height, shaft_depth, hub_depth, shortest, longest in _rows(_KEYS, 8):
        if min_diameter < round(shaft / MM, 6) <= max_diameter:
            lengths = [length for length in _KEY_LENGTHS if shortest <= length <= min(longest, max_length / MM + 1e-6)]
            if lengths:
                sizes = _metres(width, height, lengths[-1], shaft_depth, hub_depth)
                return StockKey(f"DIN 6885 - B {width:g} x {height:g} x {lengths[-1]}", *sizes)
    return None


def tube_outsides() -> tuple[float, ...]:
    """List the outside diameters of precision steel tubes [m]."""
    return _metres(*_TUBES)


def is_tube(outside: float) -> bool:
    """Return whether there are precision steel tubes with an outside diameter [m]."""
    return any(abs(outside - size) < ROUNDING for size in tube_outsides())


def tube_tolerance(outside: float) -> float:
    """Return the largest deviation of the outside diameter of a precision steel tube in stock [m].

    `outside` is the nominal outside diameter [m].
    """
    return round(_TUBES[round(outside / MM, 6)][1] * MM, 9)


def tube_for(outside: float, bore: float) -> Tube | None:
    """Return the tube with the thinnest wall from which a sleeve with an outside diameter and a bore [m] is bored."""
    size, largest_bore = round(outside / MM, 6), (bore - BORING_ALLOWANCE) / MM + 1e-6
    for wall in _TUBE_WALLS:
        if wall <= _TUBES.get(size, (0.0,))[0] and size - 2.0 * wall <= largest_bore:
            return Tube(f"EN 10305-1 - {size:g} x {wall:g}", outside, round((size - 2.0 * wall) * MM, 9))
    return None


def splines_around(shaft: float) -> tuple[StockSpline, ...]:
    """List the straight-sided splines (ISO 14) whose hubs slide over a shaft diameter [m], the smallest first."""
    fitting_splines = (
        StockSpline(f"ISO 14 - {count:g} x {minor:g} x {major:g}", int(count), *_si(minor, major, width))
        for count, minor, major, width in _rows(_SPLINES, 4)
        if minor * MM > shaft - ROUNDING
    )
    return tuple(sorted(fitting_splines, key=lambda spline: (spline.major, -spline.minor)))


def stock_pin_lengths(diameter: float, lengths: "Array", max_count: int = 4) -> "Array":
    """Round n lengths [m], shape (n,), to those of dowels in stock with a diameter [m], or of equal dowels in line.

    At most `max_count` dowels are in line. A length is returned unchanged if the nearest length in stock differs by
    more than the factor `OFF` (1.25), or if there are no dowels of the diameter; the dowels are then to be cut.
    """
    import numpy as np

    size = round(diameter / MM, 6)
    shortest, longest = _DOWELS.get(size, (math.inf, 0))
    stock_lengths = [dowel for dowel in _LENGTHS if shortest <= dowel <= longest]
    counts = range(1, max_count + 1)
    stack_lengths = {
        count * dowel for count in counts for dowel in stock_lengths if -(-count * dowel // longest) == count
    }
    if not stack_lengths:
        return lengths
    stack_lengths_m = np.round(MM * np.array(sorted(stack_lengths)), 9)
    nearest_lengths = stack_lengths_m[np.abs(np.log(stack_lengths_m / lengths[:, np.newaxis])).argmin(axis=1)]
    return np.where((lengths / OFF <= nearest_lengths) & (nearest_lengths <= lengths * OFF), nearest_lengths, lengths)


def bar_diameters() -> tuple[float, ...]:
    """List the diameters of ground bars [m], from the thinnest on."""
    return _metres(*_BARS)


@cache
def needle_bearings() -> tuple[StockBearing, ...]:
    """List the needle roller bearings without inner ring in stock, sorted by outside diameter, bore and width.

    They are drawn cups (HK), and for larger outside diameters bearings with machined rings (RNA 49).
    """
    cups = [
        StockBearing(f"HK{bore:02g}{width:02g}", *_si(bore, outer_diameter, width), dynamic * KN, static * KN)
        for bore, outer_diameter, width, dynamic, static in _rows(_DRAWN_CUPS, 5)
    ]
    machined_bearings = [
        StockBearing(f"RNA49{series_number:02g}", *_si(bore, outer_diameter, width), dynamic * KN, static * KN)
        for series_number, bore, outer_diameter, width, dynamic, static in _rows(_NEEDLE_BEARINGS, 6)
    ]
    max_cup_diameter = max(cup.outside for cup in cups)
    bearings = [*cups, *(bearing for bearing in machined_bearings if bearing.outside > max_cup_diameter)]
    return tuple(sorted(bearings, key=lambda item: (item.outside, item.bore, item.width)))


@cache
def ball_bearings() -> tuple[StockBearing, ...]:
    """List deep groove ball bearings, the smallest first."""
    bearings = [
        StockBearing(f"{series_number:g}", *_si(bore, outside, width), dynamic * KN, static * KN)
        for series_number, bore, outside, width, dynamic, static in _rows(_BALL_BEARINGS, 6)
    ]
    return tuple(sorted(bearings, key=lambda item: (item.bore, item.outside)))


@cache
def thin_ball_bearings() -> tuple[StockBearing, ...]:
    """List the thin deep groove ball bearings in stock, the smallest first."""
    return tuple(
        StockBearing(designation, *_si(bore, outer_diameter, width), dynamic * KN, static * KN)
        for designation, (bore, outer_diameter, width, dynamic, static) in _named_rows(_THIN_BALL_BEARINGS, 5)
    )


@cache
def angular_contact_bearings() -> tuple[StockBearing, ...]:
    """List the thin angular contact ball bearings (series 718) in stock, the smallest first, with estimated ratings."""
    angle = ANGULAR_CONTACT.angle
    ball_ratio = ANGULAR_CONTACT.filled_angle / DEEP_GROOVE_FILLED_ANGLE
    dynamic_factor = ball_ratio ** (2.0 / 3.0) * math.cos(angle) ** 0.7
    static_factor = ball_ratio * math.cos(angle)
    return tuple(
        replace(
            bearing,
            designation=f"{bearing.designation.replace('618', '718', 1)} ACD",
            dynamic=round(dynamic_factor * bearing.dynamic),
            static=round(static_factor * bearing.static),
            contact_angle=angle,
        )
        for bearing in thin_ball_bearings()
        if "/" not in bearing.designation and bearing.bore <= ANGULAR_CONTACT.largest_bore
    )


@cache
def catalogued_angular_contact_bearings() -> tuple[StockBearing, ...]:
    """List the thin angular contact ball bearings of IBC, whose ratings are catalogued, the smallest first."""
    return tuple(
        StockBearing(
            f"{number:g}.E", *_si(bore, outer_diameter, width), dynamic * KN, static * KN, ANGULAR_CONTACT.angle
        )
        for number, bore, outer_diameter, width, dynamic, static in _rows(_ANGULAR_CONTACT, 6)
    )


@cache
def tapered_bearings() -> tuple[StockBearing, ...]:
    """List the tapered roller bearings with a small section in stock for an output, the smallest first."""
    return tuple(_read_tapered(_TAPERED_BEARINGS))


@cache
def crank_bearings() -> tuple[StockBearing, ...]:
    """List the tapered roller bearings in stock for the cranks of an RV reducer, by bore and width."""
    return tuple(_read_tapered(_CRANK_BEARINGS))


def _read_tapered(table: str) -> Iterator[StockBearing]:
    """Yield the tapered roller bearings of a table; the contact angle of the outer ring follows from e = 1.5 tan a.

    The formula is that of ISO 281.
    """
    for designation, (bore, outer_diameter, width, dynamic, static, centre, limit) in _named_rows(table, 7):
        yield StockBearing(
            designation.replace("X", " X"),
            *_si(bore, outer_diameter, width),
            dynamic * KN,
            static * KN,
            contact_angle=math.atan(limit / 1.5),
            load_centre=round(centre * MM, 9),
        )


def needle_diameters() -> tuple[float, ...]:
    """List the diameters of needle rollers (ISO 3096) [m], from the thinnest on."""
    return _metres(*_ROLLERS)


@cache
def crossed_roller_bearings() -> tuple[StockBearing, ...]:
    """List the crossed roller bearings in stock, sorted by bore and outside diameter."""
    bearings = [
        StockBearing(
            f"{series} {bore:g}{width:02g} UU CC0",
            *_si(bore, outer_diameter, width),
            dynamic * KN,
            static * KN,
            pitch=round(pitch_circle * MM, 9),
        )
        for series, (bore, outer_diameter, width, pitch_circle, dynamic, static) in _named_rows(_CROSSED_ROLLERS, 6)
    ]
    return tuple(sorted(bearings, key=lambda item: (item.bore, item.outside)))


def has_catalogued_ratings(bearing: StockBearing) -> bool:
    """Return whether the load ratings of an angular contact ball bearing are catalogued, not estimated."""
    return bearing in catalogued_angular_contact_bearings()


def bolt_lengths(thread: float) -> tuple[float, ...]:
    """Return the lengths in stock of screws of a thread [m], the shortest first."""
    shortest, longest = _BOLT_RANGES[round(thread / MM, 3)]
    return _metres(*(length for length in _BOLT_LENGTHS if shortest <= length <= longest))


def bolt_length(thread: float, reach: float) -> float | None:
    """Return the shortest length in stock [m] of screws of a thread that is at least `reach` [m]; None if all are less.

    Both `thread` and `reach` are in metres.
    """
    return next((length for length in bolt_lengths(thread) if length >= reach - ROUNDING), None)


def bolt_hole(thread: float) -> float:
    """Return the diameter of the hole that a thread passes through [m]."""
    return round(_BOLT_HOLES[round(thread / MM, 3)] * MM, 9)


def pitch(thread: float) -> float:
    """Return the coarse pitch of a thread [m]."""
    return round(_PITCHES[round(thread / MM, 3)] * MM, 9)


def thread_core(thread: float) -> float:
    """Return the diameter of the drilled hole of a thread [m], d - P."""
    return thread - pitch(thread)


def head_bearing(thread: float) -> float:
    """Return the diameter of the bearing face under the head of a screw of a thread [m]."""
    return round(_HEAD_BEARINGS[round(thread / MM, 3)] * MM, 9)


@cache
def bolts() -> tuple[Bolt, ...]:
    """List socket head screws, the thinnest first."""
    return tuple(Bolt(f"ISO 4762 - M{size:g}", *_si(size, head, high)) for size, head, high in _rows(_BOLTS, 3))


def washer_of(thread: float) -> Washer:
    """Return the plain washer of a thread [m]."""
    sizes = next(rest for size, *rest in _rows(_WASHERS, 4) if abs(size * MM - thread) < ROUNDING)
    return Washer(f"ISO 7089 - {thread / MM:g}", *_si(*sizes))


@cache
def inserts() -> tuple[Insert, ...]:
    """List heat-set inserts, the thinnest first."""
    return tuple(Insert(f"M{size:g} x {high:g}", *_si(size, hole, high)) for size, hole, high in _rows(_INSERTS, 3))


def side_by_side(bearings: Iterable[StockBearing], width: float) -> tuple[StockBearing, int] | None:
    """Choose of bearings alike but for their width those that fill a width [m] best; none if none fits."""
    fitting = [(item, int(width / item.width + 1e-6)) for item in bearings if item.width <= width * (1.0 + 1e-6)]
    return max(fitting, key=lambda pair: (round(pair[1] * pair[0].width, 9), -pair[1]), default=None)


@lru_cache(maxsize=256)
def bearings_outside(outside: float, *, ringed: bool = False) -> tuple[StockBearing, ...]:
    """List the bearings in stock with an outside diameter [m]: needle bearings, or ball bearings if there are none.

    `ringed` selects bearings with an inner ring, for a crank that is too soft to roll needles on; these are ball
    bearings only.
    """
    if ringed:
        return _alike((*ball_bearings(), *thin_ball_bearings()), outside, "outside")
    return _alike(needle_bearings(), outside, "outside") or _alike(ball_bearings(), outside, "outside")


def has_inner_ring(bearing: StockBearing) -> bool:
    """Return whether a bearing has an inner ring; the needles of others roll on the shaft."""
    return bearing not in needle_bearings()


@lru_cache(maxsize=256)
def bearings_on(bore: float, width: float, *, ringed: bool = False) -> tuple[StockBearing, ...]:
    """List the bearings for a shaft that have a width [m]: needle bearings, then ball bearings.

    `ringed` ones have an inner ring: all ball bearings.
    """
    bearings = (*ball_bearings(), *thin_ball_bearings()) if ringed else (*needle_bearings(), *ball_bearings())
    return _alike(_alike(bearings, bore, "bore"), width, "width")


def _alike(bearings: Iterable[StockBearing], size: float, name: str) -> tuple[StockBearing, ...]:
    return tuple(item for item in bearings if abs(getattr(item, name) - size) < ROUNDING)


def bolt_under(head: float) -> Bolt | None:
    """Find the thickest screw whose head is at most so thick [m]."""
    return max((item for item in bolts() if item.head <= head * (1.0 + 1e-9)), key=lambda item: item.head, default=None)


def insert_of(thread: float) -> Insert | None:
    """Find the heat-set insert of a thread [m]."""
    return next((item for item in inserts() if abs(item.thread - thread) < ROUNDING), None)


def shaft_ring(diameter: float) -> RetainingRing | None:
    """Return the retaining ring (DIN 471) of a shaft diameter [m]; None if none is in stock."""
    return _retaining_ring("DIN 471", _SHAFT_RINGS, diameter)


def bore_ring(diameter: float) -> RetainingRing | None:
    """Return the retaining ring (DIN 472) of a bore [m]; None if none is in stock."""
    return _retaining_ring("DIN 472", _BORE_RINGS, diameter)


def _retaining_ring(standard: str, table: str, diameter: float) -> RetainingRing | None:
    for size, thickness, groove, height, width in _rows(table, 5):
        if abs(size * MM - diameter) < ROUNDING:
            sizes = _metres(size, groove, thickness, height, width)
            return RetainingRing(f"{standard} - {size:g} x {thickness:g}", *sizes)
    return None


def seal_ring(shaft: float, outside: float) -> SealRing | None:
    """Return the seal ring of a shaft diameter and an outside diameter [m]; None if none is in stock."""
    for bore, outer_diameter, width in _rows(_SEAL_RINGS, 3):
        if abs(bore * MM - shaft) < ROUNDING and abs(outer_diameter * MM - outside) < ROUNDING:
            return SealRing(f"G {bore:g} x {outer_diameter:g} x {width:g}", *_si(bore, outer_diameter, width))
    return None


def _si(first: float, second: float, third: float) -> tuple[float, float, float]:
    return round(first * MM, 9), round(second * MM, 9), round(third * MM, 9)


def _metres(*sizes: float) -> tuple[float, ...]:
    """Convert sizes [mm] to metres, rounded to 1 nm, so that equal sizes are equal numbers."""
    return tuple(round(size * MM, 9) for size in sizes)


def _rows(table: str, columns: int) -> Iterator[tuple[float, ...]]:
    """Yield the rows of a table of numbers."""
    fields = table.split()
    for start in range(0, len(fields), columns):
        yield tuple(map(float, fields[start : start + columns]))


def _named_rows(table: str, columns: int) -> Iterator[tuple[str, tuple[float, ...]]]:
    """Yield the rows of a table whose first column is a text: this text, and the numbers of the other columns."""
    fields = table.split()
    for start in range(0, len(fields), columns + 1):
        yield fields[start], tuple(map(float, fields[start + 1 : start + 1 + columns]))
