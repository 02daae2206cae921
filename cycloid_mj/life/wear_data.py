"""Measured coefficients of wear and depths of run-in, by the materials of a pair, with their spread and source."""

from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.design import Material
from cycloid_mj.design.model import Service

MM3 = 1e9
"""Cubic millimetres in a cubic metre."""

SPREAD = 10.0
"""Factor to the 5 and 95 % percentiles of a coefficient that the design file states (assumed)."""


@dataclass(frozen=True)
class Interval:
    """A value with its 5 and 95 % percentiles, in SI units, and its source."""

    low: float
    typical: float
    high: float
    source: str

    def times(self, factor: float) -> "Interval":
        """Return the interval with all values multiplied by a factor."""
        return Interval(factor * self.low, factor * self.typical, factor * self.high, self.source)


def _per_newton_metre(low: float, typical: float, high: float, source: str) -> Interval:
    """Build a coefficient from values in mm3/(N m)."""
    return Interval(low, typical, high, source).times(1.0 / MM3)


COEFFICIENTS = {
    "metal": _per_newton_metre(
        1e-10,
        1e-9,
        1e-8,
        "metals in mixed lubrication (assumed); an RV reducer's 0.0024 arcsec/h need at most 7.6e-10, "
        "Lubricants 13 (2025) 362",
    ),
    "POM": _per_newton_metre(
        8e-8, 2.6e-7, 1.2e-6, "POM on PA 66, dry: with PTFE, unfilled, on glass fibre; RTP Company"
    ),
    "PA": _per_newton_metre(
        2.2e-7,
        2.65e-6,
        1.2e-5,
        "PA 66 on POM, dry: with PTFE, unfilled, RTP Company; printed PA 6 at most 1.2e-5, doi 10.2478/msp-2025-0039",
    ),
    "PLA": _per_newton_metre(1.0e-4, 2.2e-4, 4.4e-4, "printed PLA, dry, nine tests, doi 10.2478/msp-2025-0039"),
    "plastic": _per_newton_metre(2.6e-7, 1e-5, 4.4e-4, "no data: from POM to printed PLA, dry"),
}
"""Volume that a surface loses per force and sliding distance [m3/(N m)], by the kind of its material.

RTP Company, "Wear factor and friction data", thrust washers, ASTM D3702: POM on PA 66 26e-8, with 20 % PTFE 8e-8, on
PA 66 with 30 % glass fibre 122e-8; PA 66 on POM 265e-8, on POM with PTFE 22e-8.
"""

KIND_OF_MATERIAL = {"POM": "POM", "PA6": "PA", "PA12": "PA", "Onyx": "PA", "PA-CF": "PA", "PLA": "PLA"}
"""Material of the library -> key of `COEFFICIENTS`; other plastics are "plastic"."""

RUN_IN_DEPTHS = {
    "metal": Interval(
        0.33e-6,
        0.65e-6,
        1.3e-6,
        "an RV reducer: 9.2 of its 12.9 arcsec, as if all were teeth of an RV-80E, within a factor of 2 (assumed); "
        "Lubricants 13 (2025) 362",
    ),
    "plastic": Interval(
        27e-6, 39e-6, 56e-6, "printed 13:1 drives: play 1.24 to 1.56 deg with pins, 0.90 to 1.56 deg without (JelmerV)"
    ),
}
"""Depth that run-in removes from a surface in addition to steady wear [m], about the height of its roughness.

Lost motion of the RV reducer grew by 12.9 arcsec in 1550 h, 0.0024 arcsec/h of it steadily: 9.2 arcsec are run-in, or
1.3 um of both surfaces. The play of the printed drives grew by 54 and 112 um of both.
"""


@dataclass(frozen=True)
class RunIn:
    """Run-in of an RV reducer (Lubricants 13 (2025) 362).

    Attributes
    ----------
    factor
        Coefficient of wear of new surfaces over the steady one: the least for which 99 % of the run-in are over after
        600 h, exp(-29 * 600 h * 0.0024 arcsec/h / 9.2 arcsec) = 0.011.
    share
        Share of run-in in the growth of the lost motion after 1550 h, 9.2 of 12.9 arcsec.
    """

    factor: float = 30.0
    share: float = 0.71


RUN_IN = RunIn()


def wear_coefficient(service: Service, material: Material) -> Interval:
    """Return the coefficient of wear of a surface [m3/(N m)] with its 5 and 95 % percentiles.

    `service` is the table of that name of the design, `material` is that of the surface. A coefficient in the design
    file has a tenth and ten times of it as percentiles. Otherwise the kind of material determines coefficient and
    percentiles.
    """
    stated_coefficient = service.wear_coefficient
    if stated_coefficient != Service.model_fields["wear_coefficient"].default:
        source = "service.wear_coefficient_mm3_nm of the design file, within a factor of ten (assumed)"
        return Interval(stated_coefficient / SPREAD, stated_coefficient, stated_coefficient * SPREAD, source)
    if not material.is_plastic:
        return COEFFICIENTS["metal"]
    return COEFFICIENTS[KIND_OF_MATERIAL.get(material.name, "plastic")]


def run_in_depth(service: Service, material: Material) -> Interval:
    """Return the depth that run-in removes from a surface [m]: that of the design file, or of its kind of material."""
    stated_depth = service.run_in_depth
    if stated_depth:
        return Interval(
            stated_depth / 2.0,
            stated_depth,
            2.0 * stated_depth,
            "service.run_in_depth_um, within a factor of 2 (assumed)",
        )
    return RUN_IN_DEPTHS["plastic" if material.is_plastic else "metal"]


def worn_depth(dose: Array, coefficient: float, run_in: float) -> Array:
    """Compute the depth of wear of a surface [m], in the shape of `dose`.

    The depth is k X + h_r (1 - exp(-(R - 1) k X/h_r)). This is Archard's law with a wear coefficient that falls from R
    k to k while run-in removes the depth h_r; R is `RunIn.factor`.

    Parameters
    ----------
    dose
        Pressure times sliding distance X [Pa m].
    coefficient
        Steady coefficient of wear k [m3/(N m)].
    run_in
        Depth of run-in h_r [m]; 0 for none.
    """
    steady_depth = coefficient * dose
    return steady_depth + run_in * _run_in_progress(steady_depth, run_in)


def wear_rate(dose: Array, coefficient: float, run_in: float) -> Array:
    """Compute the derivative of `worn_depth` by the dose [1/Pa], in its shape; parameters as there."""
    remaining_share = 1.0 - _run_in_progress(coefficient * dose, run_in) if run_in else 0.0
    return np.asarray(coefficient * (1.0 + (RUN_IN.factor - 1.0) * remaining_share) * np.ones_like(dose))


def _run_in_progress(steady: Array, run_in: float) -> Array:
    """Compute the part of the run-in that is over [1] at a depth of steady wear [m]."""
    if not run_in:
        return np.zeros_like(steady)
    return np.asarray(-np.expm1(-(RUN_IN.factor - 1.0) * steady / run_in))
