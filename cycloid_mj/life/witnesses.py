"""Published cases of bearing life and fatigue, compared by `cycloid-mj validate`.

Catalogues print no number of rollers, but two ratings of each bearing: C0 of ISO 76 gives Z L, and with that ISO 281
gives C, which depends on how Z L is split only by its 36th root. Roller and pitch diameter follow from the circles
that the needles touch.
"""

import math
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.units import RPM
from cycloid_mj.base.validation import ValidationPart, ValidationRow, relative
from cycloid_mj.geometry import ideal_loads
from cycloid_mj.geometry.profile import CycloidGear
from cycloid_mj.life import rolling
from cycloid_mj.life.fatigue import Fatigue, endurance_limit

NEEDLE_LENGTH_SHARE = 0.78
"""Assumed length of the needles over the width of their cage; 0.65 and 0.9 change C by 0.5 %."""


@dataclass(frozen=True)
class Cage:
    """A needle cage of a catalogue: circles inside and outside its needles and width [mm], C and C0 [N]."""

    inside: int
    outside: int
    width: int
    dynamic: float
    static: float

    def __str__(self) -> str:
        """Return its designation."""
        return f"K{self.inside}x{self.outside}x{self.width}"

    def rating(self) -> float:
        """Compute C by ISO 281 [N], with Z L from the catalogue's C0."""
        roller, pitch = 5e-4 * (self.outside - self.inside), 5e-4 * (self.outside + self.inside)
        length = 1e-3 * NEEDLE_LENGTH_SHARE * self.width
        return rolling.dynamic_capacity(
            self.static / rolling.static_capacity(1, roller, length, pitch), roller, length, pitch
        )


CATALOGUE = "NTN, Needle Roller Bearings, Cat. No. 2300/E, p. B-9 ff."
CAGES = (
    Cage(20, 24, 11, 9_500.0, 13_400.0),
    Cage(20, 26, 12, 12_900.0, 15_100.0),
    Cage(20, 28, 25, 27_100.0, 32_500.0),
    Cage(35, 40, 17, 20_000.0, 36_000.0),
    Cage(40, 48, 20, 33_000.0, 51_000.0),
    Cage(50, 58, 25, 48_500.0, 90_000.0),
    Cage(80, 86, 20, 39_000.0, 98_000.0),
)

INCH, POUND = 0.0254, 4.4482216
KPSI = 1e3 * POUND / INCH**2
"""Inch [m], pound-force [N] and kilopound per square inch [Pa]."""


def bearing_rows(quick: bool) -> list[ValidationRow]:
    """Compare capacities of needle cages, and force and life of a cam bearing, with published values.

    Returns rows of `cycloid-mj validate` for the dynamic capacity C [N] of each cage in `CAGES`, computed from its
    catalogued static capacity; and, for the cam bearing of a published drive, for the mean force [N], and the life [h]
    at the speed of the crank and at the speed of the crank relative to the disc. `quick` has no effect.
    """
    rows = [relative(f"C of {cage}", cage.rating(), cage.dynamic, "N", CATALOGUE, 5.0) for cage in CAGES]
    crank_angles = np.linspace(0.0, 29 * 2.0 * np.pi, 29 * 360, endpoint=False)
    tooth_profile, source = CycloidGear(30, 1.250025e-3, 52.5e-3, 3.5e-3), "kubakos/cycloid-drive-generator, recomputed"
    ring_sharing = ideal_loads.ideal_load_sharing(tooth_profile, 58.0, crank_angles)
    cam_forces = ideal_loads.cam_force(
        ring_sharing, ideal_loads.ideal_output_forces(tooth_profile, 4, 34e-3, 58.0, crank_angles), crank_angles
    )
    mean_force = rolling.mean_load(rolling.magnitudes(cam_forces))
    rows.append(relative("cam force, 10/3-power mean of a turn", mean_force, 2294.0, "N", source, 0.5))
    for speed_name, speed, hours in (("crank's", 600.0, 126_953.0), ("relative", 600.0 * (1 + 1 / 29), 122_721.0)):
        life = rolling.life_hours(34_500.0, 1.2 * mean_force, speed * RPM)
        rows.append(relative(f"life of the cam bearing, {speed_name} speed", life, hours, "h", source, 0.5))
    return rows


def fatigue_rows(quick: bool) -> list[ValidationRow]:
    """Compare Goodman's line and the endurance limit with two worked problems of Shigley, 8th edition.

    Returns a row of `cycloid-mj validate` for each; `quick` has no effect. Problem 7-1 has bending moments of 600 lbf
    in (amplitude) and 500 lbf in (mean), torsional moments of 400 and 300 lbf in, fatigue notch factors K_f 2.2 and
    K_fs 1.8, endurance limit 30 kpsi, tensile strength 100 kpsi, and the safety factor 2. Problem 7-2 has a rotating,
    machined bar of SAE 2340 with 1226 MPa and 22 mm.
    """
    source = "Shigley 8th ed., Problem {} (Solutions Manual, p. {})"
    diameter = 1.073 * INCH
    stress_per_moment = 32.0 / (math.pi * diameter**3) * POUND * INCH

    def mises(bending: float, torsion: float) -> float:
        return stress_per_moment * math.hypot(2.2 * bending, math.sqrt(3.0) * 0.5 * 1.8 * torsion)

    fatigue = Fatigue(mises(600.0, 400.0), mises(500.0, 300.0), 30.0 * KPSI, 100.0 * KPSI)
    limit = endurance_limit(1226e6, 22e-3, "machined", reliability=0.5, rotates=True)
    return [
        relative("Goodman, a shaft of 1.073 in", fatigue.safety, 2.0, "1", source.format("7-1 (d)", 178), 1.0),
        relative("endurance limit, SAE 2340", limit / 1e6, 375.0, "MPa", source.format("7-2", 179), 1.0),
    ]


PARTS = tuple(ValidationPart("published", rows, (0.1, 0.1)) for rows in (bearing_rows, fatigue_rows))
"""The parts of `cycloid-mj validate` of this package."""
