"""The design of a reducer: one frozen value, read from and written to TOML.

This room owns every input of the project and is the only place where mm, rpm, degrees and micrometres become SI.
"""

from cycloid_mj.design.file import dump, load, loads, override, resolve
from cycloid_mj.design.model import (
    Clearance,
    ContactLaw,
    Design,
    Drive,
    Environment,
    Friction,
    Gear,
    Housing,
    Load,
    Material,
    Output,
    Ring,
    Settings,
    Shaft,
)
from cycloid_mj.design.presets import PRESETS

__all__ = [
    "PRESETS",
    "Clearance",
    "ContactLaw",
    "Design",
    "Drive",
    "Environment",
    "Friction",
    "Gear",
    "Housing",
    "Load",
    "Material",
    "Output",
    "Ring",
    "Settings",
    "Shaft",
    "dump",
    "load",
    "loads",
    "override",
    "resolve",
]
