"""Materials by name, with the properties of parts for which the design file states none.

Values at 23 °C, in SI, as their sources print them; at other temperatures `WARM_CURVES` apply. Strengths of steels go
with the heat treatment, of plastics with time and temperature. A plastic's modulus is that of a short test: under a
load that stays, Hostaform C 9021 (POM) has 2500 MPa left after 1 h and 1300 MPa after 1000 h (ISO 899-1), and its
fellows creep alike. Thermal expansion is the usual value of the kind, of metals within 5 %, of plastics within a fifth.
A hardened surface yields at a third of its Vickers hardness as a pressure (Tabor); its case is taken to be deeper than
the contacts press.
"""

import math
from dataclasses import dataclass, replace

YIELD_PRESSURE = 1.79
"""Peak pressure at which a line contact first yields, over the yield strength (von Mises; Johnson 1985, 4.4)."""

SHAKEDOWN_PRESSURE = 4.0 / math.sqrt(3.0)
"""Peak pressure up to which rolling stays elastic after a first yield, 4 k (Johnson 1985, 9.2), over the same: 2.31."""

HARDNESS_PRESSURE = 9.807 / 3.45
"""Brinell hardness as a pressure over the tensile strength of steel: HB is 0.29 of the MPa (ISO 18265): 2.84."""


@dataclass(frozen=True)
class Entry:
    """A material of the library.

    Attributes
    ----------
    youngs_modulus, poisson, density
        [Pa], [1], [kg/m3].
    tensile_strength, yield_strength
        [Pa]; of what breaks before it yields, both are the same.
    hottest
        Temperature up to which the values may be relied on in service [°C].
    expansion
        Linear thermal expansion at room temperature [1/K].
    source
        Where the values are from.
    surface_yield
        Yield strength of a hardened surface [Pa]; 0: that of the body.
    endurance_pressure
        Hertzian pressure that a surface withstands 10^7 times without pits [Pa]; 0: that of steel follows from its
        tensile strength, and other materials have none.
    """

    youngs_modulus: float
    poisson: float
    density: float
    tensile_strength: float
    yield_strength: float
    hottest: float
    expansion: float
    source: str
    surface_yield: float = 0.0
    endurance_pressure: float = 0.0


def _material_values(
    modulus: float,
    poisson: float,
    density: float,
    tensile: float,
    yield_strength: float,
    hottest: float,
    expansion: float,
    source: str,
    surface_yield: float = 0.0,
    endurance_pressure: float = 0.0,
) -> Entry:
    """Return the values of a material for the library, converted to SI units.

    Parameters
    ----------
    modulus, poisson, density
        Young's modulus [MPa], Poisson's ratio [1], density [kg/m3].
    tensile, yield_strength, surface_yield, endurance_pressure
        Strengths of body and hardened surface [MPa], as in `Entry`.
    hottest, expansion
        Highest temperature of use [°C], thermal expansion [um/(m K)].
    source
        Origin of the values.
    """
    strengths = (tensile * 1e6, yield_strength * 1e6)
    surface_strength = (surface_yield * 1e6, endurance_pressure * 1e6)
    return Entry(modulus * 1e6, poisson, density, *strengths, hottest, expansion / 1e6, source, *surface_strength)


SOFTEST_METAL = 3e10
"""Young's modulus [Pa] below which a material counts as a plastic, and creeps (heuristic): magnesium has 45 GPa."""

LIGHTEST_MODULUS = 9e10
"""Young's modulus [Pa] below which an unnamed metal counts as aluminium (heuristic): bronze has 95 GPa, aluminium
70."""

DEFAULT = "alloy steel"

MATERIALS = {
    DEFAULT: _material_values(
        210000.0, 0.28, 7700.0, 723.1, 620.4, 250.0, 13.0, "Hsieh 2014, Table 1; SolidWorks Alloy Steel"
    ),
    "bearing steel": _material_values(
        203000.0, 0.29, 7830.0, 2241.0, 2034.0, 150.0, 12.5, "AISI 52100, 60 to 67 HRC, makers of balls"
    ),
    "case-hardened 16MnCr5": _material_values(
        210000.0,
        0.30,
        7850.0,
        900.0,
        490.0,
        160.0,
        12.0,
        "core: Saarstahl 16MnCr5, 16 to 40 mm, and Lucefin 16MnCr5 (2018), 30 mm; surface: 58 HRC, 653 HV, over 3; "
        "AGMA 2001-D04, Table 3, carburised, grade 1",
        2135.0,
        1240.0,
    ),
    "case-hardened 20MnCr5": _material_values(
        210000.0,
        0.30,
        7850.0,
        930.0,
        690.0,
        160.0,
        12.0,
        "core: Lucefin 20MnCr5 (EN 10084:2008), 30 mm; surface: 58 HRC, 653 HV, over 3; AGMA 2001-D04, Table 3, "
        "carburised, grade 1",
        2135.0,
        1240.0,
    ),
    "nitrided 42CrMo4": _material_values(
        210000.0,
        0.30,
        7850.0,
        1000.0,
        750.0,
        250.0,
        12.0,
        "core: 42CrMo4+QT, 16 to 40 mm, EN ISO 683-2; surface: 600 HV over 3 (assumed); AGMA 2001-D04, Table 3, "
        "nitrided, 83.5 HR15N, grade 1",
        1961.0,
        1034.0,
    ),
    "tempered steel": _material_values(
        210000.0, 0.30, 7850.0, 1000.0, 750.0, 250.0, 12.0, "42CrMo4+QT, 16 to 40 mm, EN ISO 683-2"
    ),
    "stainless steel": _material_values(200000.0, 0.30, 7900.0, 500.0, 190.0, 250.0, 16.0, "1.4301, EN 10088-3"),
    "aluminium 6061": _material_values(
        68900.0, 0.33, 2700.0, 310.0, 276.0, 150.0, 23.6, "6061-T6, ASM Metals Handbook, vol. 2"
    ),
    "aluminium 7075": _material_values(
        71700.0, 0.33, 2810.0, 572.0, 503.0, 130.0, 23.6, "7075-T6, ASM Metals Handbook, vol. 2"
    ),
    "bronze": _material_values(
        95000.0, 0.34, 8700.0, 260.0, 140.0, 200.0, 18.5, "CuSn12-C (CC483K), sand cast, EN 1982"
    ),
    "PA12": _material_values(
        1387.0, 0.39, 1020.0, 43.0, 43.0, 80.0, 110.0, "3D Systems, by PMC10406103, Table 2, ISO 527; nu, limit as PA6"
    ),
    "PETG": _material_values(
        1810.0,
        0.40,
        1230.0,
        44.0,
        44.0,
        60.0,
        70.0,
        "Essentium PCTG, printed, in the layers' plane, ISO 527-2 (across 40 to 45); makers of PETG 44 to 56, across "
        "25 to 38 (additive.tools); its deflection by heat at 1.8 MPa is 64 °C",
    ),
    "POM": _material_values(2850.0, 0.37, 1410.0, 64.0, 64.0, 90.0, 110.0, "Hostaform C 9021, ISO 527; UL 746B"),
    "PA6": _material_values(
        3300.0, 0.39, 1140.0, 79.0, 78.0, 80.0, 100.0, "Ensinger TECAMID 6, dry; moist it has about a third of it"
    ),
    "Onyx": _material_values(
        1400.0, 0.39, 1200.0, 36.0, 36.0, 80.0, 100.0, "Markforged Composites data sheet, ASTM D638; nu, limit as PA6"
    ),
    "PLA": _material_values(
        3039.0,
        0.36,
        1264.0,
        48.0,
        45.0,
        50.0,
        101.0,
        "Stratasys PLA, printed, in the layers' plane, ASTM D638 (across 26 MPa); other makers 23 (PolyTerra) to 65",
    ),
    "resin": _material_values(2800.0, 0.41, 1180.0, 65.0, 65.0, 50.0, 80.0, "Formlabs Clear, post-cured, ASTM D638"),
}
"""Materials by name."""

MATERIALS["PA-CF"] = replace(MATERIALS["Onyx"], source="as Onyx, PA6 with chopped carbon fibre, printed")


@dataclass(frozen=True)
class WarmCurve:
    """Modulus and strengths at temperatures [°C], relative to those at 20 °C [1]; constant beyond both ends."""

    temperatures: tuple[float, ...]
    modulus: tuple[float, ...]
    strength: tuple[float, ...]
    source: str


WARM_CURVES = {
    "steel": WarmCurve(
        (20.0, 100.0, 200.0, 300.0),
        (1.0, 0.98, 0.95, 0.915),
        (1.0, 0.96, 0.88, 0.77),
        "modulus ASME BPVC II-D, TM-1, carbon steel; strength 42CrMo4, EN 10269",
    ),
    "stainless": WarmCurve(
        (20.0, 100.0, 200.0, 300.0), (1.0, 0.97, 0.93, 0.895), (1.0, 0.82, 0.67, 0.58), "1.4301, EN 10088-1 and -3"
    ),
    "aluminium": WarmCurve(
        (20.0, 50.0, 100.0, 150.0, 200.0),
        (1.0, 0.99, 0.97, 0.93, 0.86),
        (1.0, 0.98, 0.95, 0.91, 0.79),
        "EN 1999-1-2, EN AW-6061 T6; 7075 loses more above 100 °C",
    ),
    "POM": WarmCurve(
        (20.0, 60.0, 80.0, 100.0), (1.0, 0.6, 0.45, 0.32), (1.0, 0.67, 0.54, 0.43), "usual of POM, within a fifth"
    ),
    "PA": WarmCurve(
        (20.0, 60.0, 80.0, 100.0), (1.0, 0.45, 0.25, 0.18), (1.0, 0.62, 0.5, 0.42), "usual of dry PA 6, within a fifth"
    ),
    "PLA": WarmCurve(
        (20.0, 50.0, 60.0), (1.0, 0.8, 0.1), (1.0, 0.6, 0.1), "glass transition near 58 °C, within a fifth up to 50 °C"
    ),
    "PETG": WarmCurve(
        (20.0, 60.0, 80.0), (1.0, 0.8, 0.1), (1.0, 0.6, 0.1), "glass transition near 80 °C, within a fifth up to 60 °C"
    ),
}
"""Curves of kinds of materials, rounded. Plastics differ by grade and moisture."""

CURVE_OF_MATERIAL = {
    **{"stainless steel": "stainless", "aluminium 6061": "aluminium", "aluminium 7075": "aluminium"},
    **{"POM": "POM", "PA6": "PA", "PA12": "PA", "Onyx": "PA", "PA-CF": "PA", "PLA": "PLA", "resin": "PLA"},
    "PETG": "PETG",
}
"""Material -> key of its curve; that of all other metals is "steel", and other plastics have none."""


def warm_curve(name: str, modulus: float) -> WarmCurve | None:
    """Return the curve of a material by its name, else of a metal by its Young's modulus [Pa]; None if unknown."""
    if name in CURVE_OF_MATERIAL:
        return WARM_CURVES[CURVE_OF_MATERIAL[name]]
    if modulus < SOFTEST_METAL:
        return None
    return WARM_CURVES["aluminium" if modulus < LIGHTEST_MODULUS else "steel"]


BY_CASEFOLD = {name.casefold(): name for name in MATERIALS}
"""Name in small letters -> name."""


def material_name(name: str) -> str:
    """Return the name of the library for one in any capital and small letters; an unknown name as it is."""
    return name if name in MATERIALS else BY_CASEFOLD.get(name.casefold(), name)
