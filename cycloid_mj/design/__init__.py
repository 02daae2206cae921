"""The design of a reducer: one frozen value, read from and written to TOML.

This room owns every input of the project and is the only place where mm, rpm, degrees and micrometres become SI.
"""

from cycloid_mj.design.file import dump, load, loads, override, resolve
from cycloid_mj.design.model import (
    PARTNERS,
    PARTS,
    Clearance,
    ContactLaw,
    Damping,
    Design,
    Drag,
    Drive,
    Environment,
    Errors,
    Friction,
    Gear,
    Housing,
    Load,
    Material,
    Modification,
    Output,
    Ring,
    Settings,
    Shaft,
    Stiffness,
    WorkingForce,
)
from cycloid_mj.design.presets import PRESETS

__all__ = [
    "PARTNERS",
    "PARTS",
    "PRESETS",
    "Clearance",
    "ContactLaw",
    "Damping",
    "Design",
    "Drag",
    "Drive",
    "Environment",
    "Errors",
    "Friction",
    "Gear",
    "Housing",
    "Load",
    "Material",
    "Modification",
    "Output",
    "Ring",
    "Settings",
    "Shaft",
    "Stiffness",
    "WorkingForce",
    "dump",
    "load",
    "loads",
    "override",
    "resolve",
]
