"""The design values that the page changes by sliders and lists, each with unit, range and meaning."""

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, get_args

from cycloid_mj.base.errors import UsageError
from cycloid_mj.design import Design, declared, value_of
from cycloid_mj.design.materials import MATERIALS
from cycloid_mj.design.units import file_key, unit_of


@dataclass(frozen=True)
class Knob:
    """One slider, or one list where it has options.

    Attributes
    ----------
    key
        ``table.key`` of the design file.
    group, label, unit, meaning
        What stands over, beside and behind it, and in its tooltip.
    value, low, high, step
        In the unit of the file.
    options
        Values and their words.
    """

    key: str
    group: str
    label: str
    unit: str
    meaning: str
    value: Any
    low: float = 0.0
    high: float = 0.0
    step: float = 0.0
    options: tuple[tuple[Any, str], ...] = ()


LABELS: Mapping[str, Mapping[str, str]] = {
    "Gear and ring": {
        "ring.teeth": "Ring teeth",
        "ring.pin_circle_radius": "Pin circle radius",
        "ring.pin_radius": "Pin radius",
        "gear.eccentricity": "Eccentricity",
        "gear.face_width": "Face width",
        "gear.bore_radius": "Bore radius",
    },
    "Output": {
        "output.pins": "Output pins",
        "output.pin_radius": "Output pin radius",
        "output.pin_circle_radius": "Output circle radius",
    },
    "Crank and housing": {
        "shaft.radius": "Shaft radius",
        "housing.outer_radius": "Outer radius",
    },
    "Clearances": {
        "clearance.mesh": "Teeth",
        "clearance.cam": "Cam",
        "clearance.output": "Output pins",
    },
    "Load": {
        "load.torque": "Output torque",
        "drive.speed": "Crank speed",
        "service.life": "Life asked for",
    },
}
"""Heading -> ``table.name`` of the model -> label; the clearance of the teeth is that of the design's kind of ring."""

WORDS: Mapping[str, tuple[str, Mapping[Any, str]]] = {
    "ring.kind": ("Ring", {"pin": "pins", "nonpin": "internal gear"}),
    "ring.pins": ("Ring pins", {"free": "free to roll", "fixed": "pressed in", "sleeved": "in sleeves"}),
    "gear.discs": ("Discs", {1: "one", 2: "two", 3: "three", 4: "four"}),
    "output.member": ("Output", {"carrier": "carrier of the pins", "ring": "ring with housing"}),
    "output.support": ("Output pins held", {"cantilever": "at one end", "both_ends": "at both ends"}),
}
"""Key -> label and options; a value that is none of them is added as it is."""

MADE_OF = {
    "material": "Gear and housing",
    "pin_material": "Ring pins",
    "output_material": "Output",
    "shaft_material": "Crank",
}
"""Tables of materials, and whose they are."""

LAYOUT, MATERIAL = "Layout", "Materials"

SYMBOLS = {
    "um": "µm",
    "us": "µs",
    "deg": "°",
    "n": "N",
    "nm": "N m",
    "n_m": "N/m",
    "n_mm": "N/mm",
    "n_s_mm": "N s/mm",
    "nm_arcmin": "N m/arcmin",
    "mpa": "MPa",
    "kw": "kW",
    "kg_m2": "kg m²",
    "kg_m3": "kg/m³",
    "um_m_k": "µm/(m K)",
    "m_s2": "m/s²",
    "mm_s": "mm/s",
    "c": "°C",
    "w_m2_k": "W/(m² K)",
    "mm3_nm": "mm³/(N m)",
    "hz": "Hz",
}
"""Units in keys of a design file -> their symbols; the others are their own."""

COUNTS = {"ring.teeth": 2.0, "output.pins": 2.0}
"""Whole numbers, and how many times more or less of them a slider reaches."""

SPAN = {"clearance": 3.0, "load": 4.0, "drive": 3.0, "service": 5.0}
"""How many times more, and less, than the value a slider goes, by table; else `NARROW`."""

NARROW = 1.8

STEPS = 400
"""Steps of a slider, about."""


def knobs(design: Design) -> tuple[Knob, ...]:
    """List the lists and sliders of a design."""
    return (*_lists(design), *(_slider(design, *one) for one in _rows()))


def label_of(key: str) -> str:
    """Return the page's word for a key of the design file; the key itself where the page has none."""
    return _labels().get(key, key)


def in_words(key: str) -> str:
    """Return a key of the design file in words, in the middle of a sentence; other words as they are."""
    if "." not in key:
        return key
    word = label_of(key)
    if word != key:
        return f"{word[:1].lower()}{word[1:]}"
    try:
        unit = unit_of(declared(key)).suffix
    except UsageError:
        return key
    table, _, name = key.partition(".")
    if name == "name" and table in MADE_OF:
        return f"material of {MADE_OF[table].lower()}"
    name = name.removesuffix(f"_{unit}") if unit else name
    return f"{name.replace('_', ' ')} ({table.replace('_', ' ')})"


def value_in_words(key: str, value: Any) -> str:
    """Return a value of the design file with its unit, or in the words of its list."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list | tuple):
        return (
            f"{len(value)} values, {value_in_words(key, min(value))} to {value_in_words(key, max(value))}"
            if value
            else "none"
        )
    _, options = WORDS.get(key, ("", {}))
    if value in options:
        return str(options[value])
    if not isinstance(value, int | float):
        return str(value).replace("_", " ")
    unit = unit_of(declared(key)).suffix
    return f"{value:.6g} {SYMBOLS.get(unit, unit)}".rstrip()


def with_symbols(text: str) -> str:
    """Put the symbol for the unit um in a sentence."""
    return re.sub(r"(?<=[0-9] )um\b", SYMBOLS["um"], text)


def _rows() -> Iterator[tuple[str, str, str]]:
    for group, labels in LABELS.items():
        for name, label in labels.items():
            yield group, name, label


def _labels() -> dict[str, str]:
    words = {key: label for key, (label, _) in WORDS.items()}
    for group, name, label in _rows():
        table, _, key = name.partition(".")
        named = f"Clearance of {label.lower()}" if table == "clearance" else label
        for one in ("pin_gear", "tooth") if key == "mesh" else (key,):
            field = type(getattr(Design(), table)).model_fields[one]
            words[f"{table}.{file_key(one, field)}"] = named if group else label
    return words


def _lists(design: Design) -> Iterator[Knob]:
    for key, (label, words) in WORDS.items():
        if key == "ring.pins" and design.ring.kind != "pin":
            continue
        table, _, name = key.partition(".")
        section = getattr(design, table)
        value, field = getattr(section, name), type(section).model_fields[name]
        known = get_args(field.annotation)
        options = tuple((one, word) for one, word in words.items() if not known or one in known)
        if value not in words:
            options += ((value, str(value).replace("_", " ")),)
        yield Knob(key, LAYOUT, label, "", _sentence(field.description), value, options=options)
    for table, label in MADE_OF.items():
        value = value_of(design, f"{table}.name")
        names = tuple(MATERIALS) if value in MATERIALS else (value, *MATERIALS)
        options = tuple((name, name) for name in names)
        yield Knob(f"{table}.name", MATERIAL, label, "", "Its numbers come with its name.", value, options=options)


def _slider(design: Design, group: str, name: str, label: str) -> Knob:
    table, _, key = name.partition(".")
    key = design.tooth_pair if key == "mesh" else key
    section = getattr(design, table)
    field, current = type(section).model_fields[key], getattr(section, key)
    unit = unit_of(field)
    path, meaning = f"{table}.{file_key(key, field)}", _sentence(field.description)
    if name in COUNTS:
        low = max(4 if name == "ring.teeth" else 2, math.floor(current / COUNTS[name]))
        return Knob(path, group, label, "", meaning, current, low, math.ceil(current * COUNTS[name]), 1)
    value = unit.from_si(current)
    middle = abs(value) or unit.from_si(design.rated_torque)  # of a design without load
    span = SPAN.get(table, NARROW)
    high = max(20.0, span * middle) if table == "clearance" else span * middle
    step = 10.0 ** math.floor(math.log10(high / STEPS))
    low = step if table == "clearance" else max(1.0, math.floor(middle / span / step)) * step
    reach = math.ceil(high / step) * step
    return Knob(path, group, label, SYMBOLS.get(unit.suffix, unit.suffix), meaning, value, low, reach, step)


def _sentence(text: str | None) -> str:
    text = text or ""
    return f"{text[:1].upper()}{text[1:]}"
