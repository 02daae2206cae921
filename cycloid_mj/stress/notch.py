"""Stress at fillets and hub seats: nominal stress of a round section times its notch factors.

The grids have sharp inner corners, where stress diverges under refinement. The bulk therefore excludes them, and the
stress of their fillets is computed separately.
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.names import OUTPUT_PIN, disc_of, number_of, numbered_name
from cycloid_mj.base.units import MEGAPASCAL, MILLIMETRE
from cycloid_mj.parts.crank import ShaftDimensions
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.shoulder import (
    BENDING,
    TORSION,
    has_cam_shoulders,
    root_arms,
    seat_factors,
    shoulder_factor,
)

if TYPE_CHECKING:
    from cycloid_mj.stress.loads import PartLoads


@dataclass(frozen=True)
class Notch:
    """Largest stress of a turn at the fillet of a shoulder, or at the seat of a cam that is joined to the shaft.

    Attributes
    ----------
    name
        Name of the shoulder.
    radius, fillet
        Radii of the thinner section and of the fillet [m]; inf without a fillet.
    angle
        Crank angle [rad].
    bending, torsion
        Nominal stresses on the surface, 4 M/(pi R^3) and 2 T/(pi R^3) [Pa]; a bore increases them.
    bending_factor, torsion_factor
        Their notch factors.
    """

    name: str
    radius: float
    fillet: float
    angle: float
    bending: float
    torsion: float
    bending_factor: float
    torsion_factor: float

    @property
    def nominal(self) -> float:
        """Nominal von Mises stress [Pa]."""
        return math.hypot(self.bending, math.sqrt(3.0) * self.torsion)

    @property
    def stress(self) -> float:
        """Von Mises stress [Pa] at the notch."""
        return math.hypot(self.bending_factor * self.bending, math.sqrt(3.0) * self.torsion_factor * self.torsion)

    def as_json(self, yield_strength: float) -> dict[str, Any]:
        """Convert the stress at a notch to JSON values; keys end in their units.

        ``safety_against_yield`` [1] is `yield_strength` [Pa] over the stress; None without stress.
        """
        return {
            "name": self.name,
            "radius_mm": self.radius / MILLIMETRE,
            "fillet_mm": None if math.isinf(self.fillet) else self.fillet / MILLIMETRE,
            "angle_deg": math.degrees(self.angle),
            "nominal_mpa": self.nominal / MEGAPASCAL,
            "bending_mpa": self.bending / MEGAPASCAL,
            "torsion_mpa": self.torsion / MEGAPASCAL,
            "bending_factor": self.bending_factor,
            "torsion_factor": self.torsion_factor,
            "stress_mpa": self.stress / MEGAPASCAL,
            "safety_against_yield": yield_strength / self.stress if self.stress else None,
        }


def output_roots(reducer: Reducer, loads: "PartLoads") -> tuple[Notch, ...]:
    """Return the largest stress at the roots of the output pins over the turn, under `loads`; a tuple of one `Notch`.

    Forces are uniform over a disc's width. The nominal bending stress is 4 M/(pi R^3), with the bending moment M at the
    root and the radius R of the pin, or of its core under a roller.
    """
    design = reducer.design
    discs = np.array([disc_of(label) for label in loads.labels])
    loaded_pins = np.array([number_of(label) for label in loads.labels])
    arms, pin_numbers = root_arms(reducer)[:, discs], np.unique(loaded_pins)
    # Bending moments (k, r, p, 2): crank angle, root (one per output disc), output pin, x and y
    moments = np.stack(
        [
            np.einsum("rc,kcx->krx", arms[:, loaded_pins == pin_number], loads.force[:, loaded_pins == pin_number])
            for pin_number in pin_numbers
        ],
        axis=2,
    )
    magnitude = np.linalg.norm(moments, axis=3)
    angle_index, root, pin = np.unravel_index(int(magnitude.argmax()), magnitude.shape)
    radius, fillet, moment = (
        design.output.root_radius,
        design.output.root_fillet,
        float(magnitude[angle_index, root, pin]),
    )
    location_text = ", at the second output disc" if root else ""
    return (
        Notch(
            name=f"root of {numbered_name(OUTPUT_PIN, int(pin_numbers[pin]))}{location_text}",
            radius=radius,
            fillet=fillet,
            angle=float(loads.angle[angle_index]),
            bending=4.0 * moment / (math.pi * radius**3),
            torsion=0.0,
            bending_factor=shoulder_factor(radius, fillet, math.inf, BENDING),
            torsion_factor=shoulder_factor(radius, fillet, math.inf, TORSION),
        ),
    )


def shaft_shoulders(reducer: Reducer, shaft: ShaftDimensions, moments: Array, angle: Array) -> tuple[Notch, ...]:
    """Return the largest stresses in the shaft over k crank angles: a `Notch` for the journals, then one per shoulder.

    The first is the most stressed section of all journals, without a notch (notch factors of 1). `moments` (k, s, 3) [N
    m] are the moments about x, y and z in the s cross-sections `shaft.stations` [m], at the crank angles `angle` (k,)
    [rad]. The first of these sections are the shoulders.
    """
    bending_stress = shaft.nominal_bending * np.hypot(moments[..., 0], moments[..., 1])
    torsion_stress = 0.5 * shaft.nominal_bending * np.abs(moments[..., 2])
    factors_of_seat = seat_factors(reducer.design, reducer.design.material_of("shaft").tensile_strength)
    fillet_radius = (
        math.inf if factors_of_seat and not has_cam_shoulders(reducer.design) else reducer.design.shaft.shoulder_fillet
    )

    def notch(name: str, station: int, fillet: float, factors: tuple[float, float]) -> Notch:
        """Return the largest stress over the turn in the shaft's cross-section with the index `station`.

        `name` is that of the result, `factors` are the notch factors in bending and in torsion, `fillet` [m] is the
        radius of the fillet.
        """
        bending_factor, torsion_factor = factors
        station_bending, station_torsion = bending_stress[:, station], torsion_stress[:, station]
        angle_index = int(
            np.argmax(np.hypot(bending_factor * station_bending, np.sqrt(3.0) * torsion_factor * station_torsion))
        )
        stresses = float(station_bending[angle_index]), float(station_torsion[angle_index])
        return Notch(name, shaft.radius, fillet, float(angle[angle_index]), *stresses, *factors)

    nominal_stress = np.hypot(bending_stress, np.sqrt(3.0) * torsion_stress)
    largest_station = int(np.unravel_index(int(nominal_stress.argmax()), nominal_stress.shape)[1])
    journal_name = f"journal at z = {shaft.stations[largest_station] / MILLIMETRE:.1f} mm"
    return (
        notch(journal_name, largest_station, math.inf, (1.0, 1.0)),
        *(
            notch(
                shoulder.name,
                station,
                fillet_radius,
                _notch_factors(shaft.radius, fillet_radius, shoulder.outer, factors_of_seat),
            )
            for station, shoulder in enumerate(shaft.shoulders)
        ),
    )


def _notch_factors(
    radius: float, fillet: float, outer_radius: float, cam_factors: tuple[float, float] | None
) -> tuple[float, float]:
    """Return the notch factors of a step of the shaft in bending and torsion, the larger of its shoulder and its seat.

    At the step, the radius increases from `radius` to `outer_radius` [m] with a `fillet` [m], inf without a shoulder.
    `cam_factors` are the notch factors of a cam that is joined to the shaft; None for a cam in one piece with it.
    """
    shoulder_factors = tuple(shoulder_factor(radius, fillet, outer_radius, terms) for terms in (BENDING, TORSION))
    bending, torsion = (max(factors) for factors in zip(shoulder_factors, cam_factors or shoulder_factors, strict=True))
    return bending, torsion
