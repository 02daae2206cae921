"""Values that a design file takes from a preset, and whether the file states this."""

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cycloid_mj.base.overwrite_guard import note_input
from cycloid_mj.design.file import BASE, PIN_CIRCLE, Base, Named, base_design, preset, resolve, value_of
from cycloid_mj.design.layouts import applies
from cycloid_mj.design.model import PARTNERS, Design
from cycloid_mj.design.section import Section
from cycloid_mj.design.units import file_key

DESCRIBING = ("ring", "gear", "output", "shaft", "housing", "clearance", "drive")
"""Tables that describe the drive itself; the others have settings, assumptions and what is 0 by default."""

RAMP = ("drive.ramp_s", "drive.hold_s")
"""Keys of the course of a run, which are no property of the drive."""

MOTOR = ("drive.torque_nm", "drive.speed_rpm")
"""Keys of the motor's torque and speed."""


@dataclass(frozen=True)
class Inheritance:
    """Values of a design that its file takes from a preset.

    Attributes
    ----------
    preset
        Name of the preset.
    is_stated
        True if the file names it in ``[base]``.
    factor
        Factor on the lengths of the preset [1]; None if ``[base]`` does not request that they are scaled.
    values
        Key -> value in the units of the file, of the tables that describe the drive; those that are 0, and so computed
        from others, are left out.
    """

    preset: str
    is_stated: bool
    factor: float | None
    values: Mapping[str, Any]

    @property
    def note(self) -> str:
        """Return a sentence that lists the values which a design file takes from its preset, or an empty text."""
        if not self.values:
            return ""
        value_texts = ", ".join(f"{key} {_written(value)}" for key, value in self.values.items())
        source = "[base]" if self.is_stated else f'the default; [base] preset = "{self.preset}" states it'
        scale_text = "" if self.factor is None else f", with its lengths scaled by {self.factor:.4g} to the pin circle"
        return (
            f"{len(self.values)} values are taken from the preset {self.preset} ({source}){scale_text}: {value_texts}"
        )

    @property
    def remedy(self) -> tuple[str, ...]:
        """Return one sentence that advises to scale the preset's lengths to the file's pin circle, or an empty tuple.

        It applies if lengths were taken unscaled from a preset with another pin circle.
        """
        lengths = [key for key in self.values if key.endswith("_mm")]
        if self.factor is not None or not lengths or PIN_CIRCLE in self.values:
            return ()
        return (
            f"{len(lengths)} lengths are those of the preset {self.preset}, which has another pin circle: add "
            f'preset = "{self.preset}" and scaled = true to the table [base] of the file to scale them with '
            f"{PIN_CIRCLE}",
        )

    @property
    def motor(self) -> tuple[str, ...]:
        """Keys of torque and speed of the motor that are taken without a statement."""
        return () if self.is_stated else tuple(key for key in MOTOR if key in self.values)


def find_inheritance(named: Named, changes: Sequence[str] = ()) -> Inheritance | None:
    """Return the values that a design takes from its preset because neither its file nor `changes` set them.

    Only values that describe the drive (tables `DESCRIBING`, such as ring and gear, and the name of the material) are
    included; values of 0 are omitted. The result is None if `named` is a preset or a design.

    Parameters
    ----------
    named
        A design, the name of a preset, or the path of a design file, which must be readable and valid.
    changes
        Texts ``table.key=value`` of the command line.
    """
    if isinstance(named, Design) or preset(str(named)):
        return None
    tables = tomllib.loads(note_input(Path(named)).read_text(encoding="utf-8-sig"))
    stated_keys = {change.partition("=")[0].strip() for change in changes}
    stated_keys |= {f"{table}.{key}" for table, keys in tables.items() if isinstance(keys, Mapping) for key in keys}
    if "load.torque_nm" in stated_keys and BASE not in tables:
        stated_keys |= {"drive.torque_nm", "drive.power_kw"}  # from the load
    if any(key.startswith("material.") for key in stated_keys):
        stated_keys.add("material.name")
    base = base_design(tables, str(named)) if BASE in tables else Base("pin", Design(), None)
    design = resolve(named, changes)
    kinds = design.pair_kinds
    unused_keys = {f"clearance.{kind}_um" for kind in PARTNERS if kind not in kinds}
    inherited_values = {
        key: value
        for key in _describing_keys(design)
        if key not in stated_keys | unused_keys and (value := value_of(base.design, key))
    }
    return Inheritance(base.name, BASE in tables, base.factor, inherited_values)


def _describing_keys(design: Design) -> list[str]:
    """List the file keys (``table.key``) that describe the drive and have an effect with the layout of the design.

    They are ``material.name`` and the keys of the tables `DESCRIBING`, such as ring and gear, without those of a run
    (`RAMP`).
    """
    tables: dict[str, Section] = {name: getattr(Design(), name) for name in DESCRIBING}
    keys = [
        f"{table}.{file_key(name, field)}"
        for table, section in tables.items()
        for name, field in type(section).model_fields.items()
        if applies(design.layout, table, name)
    ]
    return [key for key in keys if key not in RAMP and not key.startswith("material.")] + ["material.name"]


def _written(value: Any) -> str:
    return str(value) if isinstance(value, (str, bool)) else f"{value:.6g}"
