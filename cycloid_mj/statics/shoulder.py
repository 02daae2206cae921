"""Notch factors of the shoulders and hub seats of a round shaft, and bending moments at the roots of the output pins.

DIN 743-2:2012 (shoulder, in bending and torsion)::

    alpha = 1 + 1/sqrt(A r/t + 2 B r/d (1 + 2 r/d)^2 + C (r/t)^z d/D),   t = (D - d)/2
"""

import math
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.design import Design, stock
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bending import AXIAL_GAP

BENDING = (0.62, 5.8, 0.2, 3.0)
TORSION = (3.4, 19.0, 1.0, 2.0)
"""Coefficients A, B, C and z of a shoulder, by DIN 743-2."""


@dataclass(frozen=True)
class SeatNotch:
    """Fatigue notch factors that DIN 743-2:2012 (table 1) states for a shaft in its hub, from tests.

    In torsion, a key has 0.56 times the factor in bending plus 0.1, a press fit 0.65 times it without an offset: the
    printed factors of press fits in torsion, from 1.2 at 400 MPa to 1.9 at 1200 MPa, agree with 0.65 times those in
    bending and not with 0.1 more.

    Attributes
    ----------
    description
        Words for the seat of a cam.
    factor, power
        Factor in bending: `factor` times a power of the tensile strength over 1000 MPa. Not used for a spline.
    torsion_share, torsion_offset
        Factor in torsion: share of that in bending, plus an offset. Not used for a spline.
    diameter
        Diameter of the shafts in the tests [m].
    min_strength
        Smallest tensile strength of the shafts in the tests [GPa]; weaker shafts count as such (assumed).
    """

    description: str
    factor: float = 0.0
    power: float = 0.0
    torsion_share: float = 0.0
    torsion_offset: float = 0.0
    diameter: float = 40e-3
    min_strength: float = 0.4

    def specimen_factors(self, tensile: float) -> tuple[float, float]:
        """Return the fatigue notch factors (bending, torsion) [1] of the specimens, shafts of `diameter` (DIN 743-2).

        `tensile` is the tensile strength of the shaft [Pa].
        """
        strength = max(1e-9 * tensile, self.min_strength)
        if not self.factor:
            torsion = math.exp(0.42 * strength**2)
            return 1.0 + 0.45 * (torsion - 1.0), torsion
        bending = self.factor * strength**self.power
        return bending, self.torsion_share * bending + self.torsion_offset


SEATS = {
    "key": SeatNotch("keyed cam", 3.0, 0.38, 0.56, 0.1),
    "shrink": SeatNotch("shrunk cam", 2.7, 0.43, 0.65),
    "clamp": SeatNotch("clamped cam, as in a press fit", 2.7, 0.43, 0.65),
    "spline": SeatNotch("splined cam", diameter=29e-3),
}
"""Notch factors of the seat of a cam by `Design.cam_joint`.

Glued cams count as keyed ones, and clamped cams as shrunk ones (assumed).
"""


def seat_factors(design: Design, tensile: float) -> tuple[float, float] | None:
    """Compute the fatigue notch factors of the shaft in its cams, in bending and torsion (DIN 743-2:2012, table 1).

    They are the factors measured in tests on shafts of the diameter d_test, times K3(d_test)/K3(d), with the size
    factor K3 of the standard and the diameter d of the shaft. None is returned for cams in one piece with the shaft,
    which have shoulders. `tensile` is the tensile strength of the shaft [Pa].
    """
    seat, diameter = SEATS.get(design.cam_joint), 2.0 * design.shaft.radius
    if seat is None:
        return None
    bending, torsion = (
        factor * _size_influence(factor, seat.diameter) / _size_influence(factor, diameter)
        for factor in seat.specimen_factors(tensile)
    )
    return bending, torsion


def has_cam_shoulders(design: Design) -> bool:
    """Return whether the shaft has shoulders at its cams: a crank in one piece, or splines around the journals."""
    diameter = 2.0 * design.shaft.radius
    if design.cam_joint != "spline":
        return design.has_one_piece_crank
    splines = stock.splines_around(diameter)
    return bool(splines) and splines[0].minor > diameter + stock.ROUNDING


def _size_influence(factor: float, diameter: float) -> float:
    """Compute K3 [1] of DIN 743-2 for a notch factor from tests and a diameter [m], from 7.5 to 150 mm."""
    size = min(max(diameter / 7.5e-3, 1.0), 20.0)
    return 1.0 - 0.2 * math.log10(factor) * math.log10(size) / math.log10(20.0)


def shoulder_factor(radius: float, fillet: float, outer: float, terms: tuple[float, float, float, float]) -> float:
    """Compute the notch factor alpha [1] of a shoulder of a round shaft in bending or torsion, by DIN 743-2.

    At the shoulder, the radius of the shaft increases from `radius` to `outer` [m]; inf is a wide disc. `fillet` [m] is
    the radius of the fillet between them. `terms` are the coefficients of the formula: `BENDING` or `TORSION`.
    """
    a, b, c, z = terms
    depth = outer - radius
    relative_fillet, fillet_over_depth = fillet / (2.0 * radius), 0.0 if math.isinf(outer) else fillet / depth
    diameter_ratio = 0.0 if math.isinf(outer) else radius / outer
    return 1.0 + 1.0 / math.sqrt(
        a * fillet_over_depth
        + 2.0 * b * relative_fillet * (1.0 + 2.0 * relative_fillet) ** 2
        + c * fillet_over_depth**z * diameter_ratio
    )


def root_arms(reducer: Reducer) -> Array:
    """Compute the bending moments at the roots of an output pin per force of each of D discs [m], shape (roots, D).

    Forces act in the middle planes of the discs. A cantilever has one root, where a force F has the moment F a. A beam
    clamped at both ends has two roots, with moments F a b^2/l^2. a is the distance of the force from the root, b that
    from the other root, and l their sum (Roark, Formulas for Stress and Strain, 8.1, case 1d).
    """
    gear = reducer.design.gear
    root_position = gear.stack_width / 2.0 + AXIAL_GAP
    root_distance = root_position - np.array(gear.disc_planes)
    if reducer.design.output.support == "cantilever":
        return root_distance[np.newaxis]
    other_distance = 2.0 * root_position - root_distance
    return np.stack(
        [
            distance * opposite_distance**2 / (distance + opposite_distance) ** 2
            for distance, opposite_distance in ((root_distance, other_distance), (other_distance, root_distance))
        ]
    )
