"""Manufacturing processes of a drive: clearances, materials, and usual conditions."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from cycloid_mj.base.units import MICROMETRES

Process = Literal["steel", "printed", "milled"]


@dataclass(frozen=True)
class ProcessLimits:
    """Clearances and materials of a process, and its changes to the preset.

    Attributes
    ----------
    clearance, finest
        Usual clearance of each pair, and the smallest that the process achieves [m].
    matched
        Smallest clearance of parts that are measured and paired (selective assembly) [m].
    material, others
        Usual material of disc and housing, and alternatives.
    stronger
        Processes whose drives carry larger torques.
    changes
        Changes of the preset ``pin``, by table.
    reasons
        Reasons for these values, by the key of the design file's model.
    life_h, speed_rpm, duty_share
        Usual life [h], speed of the crank [rpm], and share of the time under load.
    """

    clearance: float
    finest: float
    matched: float
    material: str
    others: tuple[str, ...]
    stronger: tuple[Process, ...]
    changes: Mapping[str, Mapping[str, object]]
    reasons: Mapping[str, str]
    life_h: float = 6000.0
    speed_rpm: float = 1500.0
    duty_share: float = 1.0


_BOUGHT = {"pin_material": {"name": "bearing steel"}}
_GREASED = {"friction": {"law": "film"}}
_HARD_CRANK = {"shaft_material": {"name": "case-hardened 16MnCr5"}}
"""At least 58 HRC under needles, as their load ratings require (SKF, Rolling bearings, 2018; NTN CAT. 2300)."""

PROCESSES: dict[Process, ProcessLimits] = {
    "steel": ProcessLimits(
        clearance=5e-6,
        finest=2e-6,
        matched=1e-6,
        material="case-hardened 16MnCr5",
        others=("bearing steel",),
        stronger=(),
        changes={**_BOUGHT, **_GREASED},
        reasons={
            "material.name": "turned, case-hardened and ground",
            "pin_material.name": "pins are bought: needle rollers",
            "friction.law": "a greased drive of steel",
            "clearance.pin_gear": "ground parts leave a few micrometres",
        },
    ),
    "milled": ProcessLimits(
        clearance=2e-5,
        finest=1e-5,
        matched=5e-6,
        material="tempered steel",
        others=("nitrided 42CrMo4", "case-hardened 16MnCr5"),
        stronger=("steel",),
        changes={**_BOUGHT, **_GREASED, **_HARD_CRANK, "ring": {"pins": "fixed"}},
        reasons={
            "ring.pins": "pressed in: no sockets to mill",
            "shaft_material.name": "needles run on the crank: it is hardened and ground",
            "material.name": "milled or wire-cut from the tempered bar",
            "pin_material.name": "pins are bought: dowels, pressed in",
            "friction.law": "a greased drive of steel",
            "clearance.pin_gear": "milled parts keep a hundredth of a millimetre or two",
        },
    ),
    "printed": ProcessLimits(
        clearance=1e-4,
        finest=4e-5,
        matched=2e-5,
        material="PLA",
        others=("PETG", "PA-CF", "POM"),
        stronger=("milled", "steel"),
        changes={
            **_BOUGHT,
            "output_material": {"name": "bearing steel"},
            **_HARD_CRANK,
            "ring": {"pins": "fixed"},
            "friction": {
                "law": "film",
                "lubricant": "lithium complex grease 220",
                "roughness": 1e-5,
                "pin_gear": 0.12,
            },
        },
        reasons={
            "ring.pins": "pressed in: in a socket of plastic they would dig in",
            "material.name": "printed; use the numbers of your own filament",
            "shaft_material.name": "a printed one twists and creeps, and needles run on it: it is hardened and ground",
            "pin_material.name": "steel dowels, pressed in",
            "output_material.name": "steel dowels with rollers; the disc is taken with them",
            "clearance.pin_gear": "what a printer needs for parts that move",
            "friction.law": "a greased drive of plastic",
            "friction.lubricant": "synthetic base oil, which plastics withstand",
            "friction.roughness": "layers of a printed flank (assumed)",
            "friction.pin_gear": "with the law coulomb: greased plastic on steel",
            "friction.boundary": "greased plastic on steel (VDI 2736-2)",
        },
        life_h=500.0,
        speed_rpm=300.0,
        duty_share=0.25,
    ),
}

TOLERANCE_SHARE = 0.1
"""Standard deviation of every fit, radius and position over the clearance (heuristic): six of them are 0.6 of it, and
all of 96 samples of each process turn freely (with 0.16, 4 % of printed drives jam)."""

POSITIONS = ("pin_position", "pin_radius", "pin_circle", "hole_position", "eccentricity", "disc_size")
FIT_TOLERANCES = ("mesh", "seat", "cam", "output")
"""Tolerances that follow from a fit."""


def usual_tolerances(clearance: float, discs: int, fit: str = "", tube_deviation: float = 0.0) -> dict[str, str]:
    """Return the table ``tolerance`` of a design: key -> tolerance, such as "normal 5" (standard deviation 5 um).

    Parameters
    ----------
    clearance
        Clearance of the pairs [m]; the standard deviations are `TOLERANCE_SHARE` of it.
    discs
        Number of discs.
    fit
        Fit of the pairs, such as H7/g6, which is used instead for the keys `FIT_TOLERANCES`, such as "mesh".
    tube_deviation
        Standard deviation of the radius of sleeves that are cut from a tube [m]. It adds, in variance, to that of the
        clearance of the output pins.
    """
    deviations = TOLERANCE_SHARE * clearance, math.hypot(TOLERANCE_SHARE * clearance, tube_deviation)
    default_tolerance, output_tolerance = (f"normal {MICROMETRES * deviation:.3g}" for deviation in deviations)
    keys = (*POSITIONS, *FIT_TOLERANCES, *(["cam_position"] if discs > 1 else []))
    return {
        **dict.fromkeys(keys, default_tolerance),
        "output": output_tolerance,
        **(dict.fromkeys(FIT_TOLERANCES, fit) if fit else {}),
    }
