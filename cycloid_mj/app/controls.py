"""The parameters that the page changes by sliders and lists, each with unit, range and description."""

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, get_args

from pydantic import BaseModel

from cycloid_mj.app.state import BASES
from cycloid_mj.base.errors import UsageError
from cycloid_mj.design import Design, declaration_of, value_of
from cycloid_mj.design.layouts import Layout, applies
from cycloid_mj.design.materials import MATERIALS
from cycloid_mj.design.units import Unit, bounds_of, file_key, unit_of


@dataclass(frozen=True)
class Control:
    """A slider, or a list if it has options.

    Attributes
    ----------
    key
        ``table.key`` of the design file.
    group, label, unit, meaning
        Heading, name, unit, and the description in its tooltip.
    value, low, high, step
        Value, range and step, in the unit of the design file.
    options
        Values of a list and their words.
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


_LOAD = {"load.torque": "Output torque", "drive.speed": "Crank speed", "service.life": "Required life"}

_CENTRAL: Mapping[str, Mapping[str, str]] = {
    "Disc and ring": {
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
    "Load": _LOAD,
}

_RV: Mapping[str, Mapping[str, str]] = {
    "Planet stage": {
        "planet.sun_teeth": "Sun teeth",
        "planet.planet_teeth": "Planet teeth",
        "planet.module": "Module",
        "planet.face_width": "Planet width",
        "planet.backlash": "Planet backlash",
    },
    "Disc and ring": {name: label for name, label in _CENTRAL["Disc and ring"].items() if name != "gear.bore_radius"},
    "Cranks and carrier": {
        "cranks.eccentric_radius": "Eccentric radius",
        "cranks.needle_radius": "Needle radius",
        "cranks.needles": "Needles",
        "cranks.needle_clearance": "Needle clearance",
        "cranks.taper_radius": "Tapered bearing radius",
        "cranks.taper_clearance": "Tapered bearing clearance",
        "cranks.middle_hole_radius": "Middle hole radius",
        "cranks.post_radius": "Post radius",
        "cranks.flange_thickness": "Flange thickness",
        "housing.outer_radius": "Outer radius",
    },
    "Clearances": {"clearance.mesh": "Teeth"},
    "Load": {**_LOAD, "drive.speed": "Sun speed"},
}

LABELS: Mapping[Layout, Mapping[str, Mapping[str, str]]] = {"central": _CENTRAL, "rv": _RV}
"""Layout -> heading -> ``table.name`` of the model -> label; ``mesh`` is the tooth clearance of the kind of ring."""

WORDS: Mapping[str, tuple[str, Mapping[Any, str]]] = {
    "ring.kind": ("Ring", {"pin": "pins", "nonpin": "internal gear"}),
    "ring.pins": ("Ring pins", {"free": "free to roll", "fixed": "pressed in", "sleeved": "in sleeves"}),
    "gear.discs": ("Discs", {1: "one", 2: "two", 3: "three", 4: "four"}),
    "cranks.count": ("Cranks", {2: "two", 3: "three"}),
    "planet.sun_support": ("Sun", {"floating": "floating", "fixed": "in bearings"}),
    "contact.needles": ("Needles of the cranks", {"lumped": "one spring", "each": "a spring each"}),
    "output.member": ("Output", {"carrier": "pin carrier", "ring": "ring with housing"}),
    "output.support": ("Output pin support", {"cantilever": "at one end", "both_ends": "at both ends"}),
}
"""Key -> label and options; another value of a design is added as it is."""

MADE_OF = {
    "material": "Disc and housing",
    "pin_material": "Ring pins",
    "output_material": "Output",
    "shaft_material": "Crank",
}
"""Tables of materials -> the parts that they belong to."""

SETS_VALUES = "Material of the library; its name sets all its values"

ADJUSTABLE = frozenset(("planet.backlash", "cranks.needle_clearance", "cranks.taper_clearance"))
"""Clearances in other tables than ``clearance``; bearings may be preloaded, with a negative clearance."""

LAYOUT, MATERIAL, OTHERS = "Layout", "Materials", "Other parameters"

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

COUNTS = ("ring.teeth", "output.pins", "planet.sun_teeth", "planet.planet_teeth", "cranks.needles")
"""Integers with a slider."""

SPAN = {"clearance": 3.0, "load": 4.0, "drive": 3.0, "service": 5.0}
"""Range of the sliders of a table, as a factor of the value."""


@dataclass(frozen=True)
class SliderSettings:
    """Ranges of the sliders."""

    span: float = 1.8
    """Upper end of a slider over the value, for lengths of parts and other tables without an entry in `SPAN`."""
    count_span: float = 2.0
    """Upper end of the slider of an integer over its value, and its value over the lower end."""
    min_clearance_range_um: float = 20.0
    """Upper end of the sliders of clearances, at least [um]."""
    steps: int = 400
    """Approximate number of steps of a slider."""


SLIDER = SliderSettings()


def controls(design: Design) -> tuple[Control, ...]:
    """Return the lists and sliders of a design."""
    return (*_list_controls(design), *(_create_slider(design, *row) for row in _slider_rows(design.layout)))


def find_controls(design: Design, text: str) -> tuple[Control, ...]:
    """Return input controls for the keys of a design file that match a text and have no control by default.

    A key matches if its name, its label and its description together contain each word of the text. Only keys with a
    number, an option or a switch as value are searched.
    """
    words, shown_keys = text.lower().split(), {control.key for control in controls(design)}
    return tuple(
        control
        for control in _all_controls(design)
        if control.key not in shown_keys
        and all(word in f"{control.key} {control.label} {control.meaning}".lower() for word in words)
    )


def _all_controls(design: Design) -> Iterator[Control]:
    """Yield an input control for every number, option list and switch in the tables of a design file.

    The controls are in the group `OTHERS`.
    """
    for table, section in design:
        for name, field in type(section).model_fields.items() if isinstance(section, BaseModel) else ():
            if not applies(design.layout, table, name):
                continue
            value, key = getattr(section, name), f"{table}.{file_key(name, field)}"
            options, meaning = get_args(field.annotation), _sentence(field.description)
            label = _sentence(f"{name} ({table})".replace("_", " "))
            if isinstance(value, bool):
                yield Control(key, OTHERS, label, "", meaning, value, options=((True, "yes"), (False, "no")))
            elif isinstance(value, str) and value in options:
                labelled_options = tuple((option, str(option).replace("_", " ")) for option in options)
                yield Control(key, OTHERS, label, "", meaning, value, options=labelled_options)
            elif isinstance(value, int | float) and math.isfinite(value):
                yield _plain_slider(key, label, meaning, unit_of(field), value)


def _plain_slider(key: str, label: str, meaning: str, unit: Unit, value: float) -> Control:
    """Return a slider for a key of the design file, from 0 to `SLIDER.span` times its value, in the unit of the file.

    `value` is in SI units, `label` names the slider, and `meaning` is the description of the key. For a negative value
    the slider begins at the negative end, for the value 0 it ends at 1. An integer has steps of 1, any other number
    steps of a power of ten.
    """
    shown_value = value if isinstance(value, int) else unit.from_si(value)
    low, high = (0.0, max(1.0, abs(shown_value))) if shown_value == 0.0 else sorted((0.0, SLIDER.span * shown_value))
    step = 1.0 if isinstance(value, int) else 10.0 ** math.floor(math.log10((high - low) / SLIDER.steps))
    return Control(
        key, OTHERS, label, _symbol(unit.suffix), meaning, shown_value, low, math.ceil(high / step) * step, step
    )


def key_in_words(key: str) -> str:
    """Return a key of the design file as words, such as "pin radius (output)"; any other text is returned unchanged.

    A key of a control of the page becomes the label of the control with a small initial.
    """
    if "." not in key:
        return key
    word = _control_labels().get(key, key)
    if word != key:
        return f"{word[:1].lower()}{word[1:]}"
    try:
        unit = unit_of(declaration_of(key)).suffix
    except UsageError:
        return key
    table, _, name = key.partition(".")
    if name == "name" and table in MADE_OF:
        return f"material of {MADE_OF[table].lower()}"
    name = name.removesuffix(f"_{unit}") if unit else name
    return f"{name.replace('_', ' ')} ({table.replace('_', ' ')})"


def value_in_words(key: str, value: Any) -> str:
    """Return the value of a key as text: a number with its unit, the label of an option, or "yes" and "no".

    A list becomes the number of its values and their range, an empty list "none".
    """
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
    return number_with_unit(key, value)


def number_with_unit(key: str, value: float) -> str:
    """Return a number of the design file as text, with the symbol of its unit."""
    return f"{value:.6g} {_symbol(unit_of(declaration_of(key)).suffix)}".rstrip()


def with_symbols(text: str) -> str:
    """Replace the unit um by its symbol in a sentence."""
    return re.sub(r"(?<=[0-9] )um\b", SYMBOLS["um"], text)


def _slider_rows(layout: Layout) -> Iterator[tuple[str, str, str]]:
    """Yield heading, name of the value and label of each slider of a design with a layout."""
    for group, labels in LABELS[layout].items():
        for name, label in labels.items():
            yield group, name, label


def _control_labels() -> dict[str, str]:
    """Return the labels of all keys for which the page has a control by default: key of the design file -> label."""
    labels = {key: label for key, (label, _) in WORDS.items()}
    rows = [(design, *row) for layout, design in BASES.items() for row in _slider_rows(layout)]
    for design, group, name, label in rows:
        table, _, key = name.partition(".")
        label_in_sentence = f"Clearance of {label.lower()}" if table == "clearance" else label
        for name in ("pin_gear", "tooth") if key == "mesh" else (key,):
            field = type(getattr(design, table)).model_fields[name]
            labels.setdefault(f"{table}.{file_key(name, field)}", label_in_sentence if group else label)
    return labels


def _list_controls(design: Design) -> Iterator[Control]:
    """Yield the input controls with a list of options: the layout of the design, then each material."""
    for key, (label, texts) in WORDS.items():
        table, _, name = key.partition(".")
        if (key == "ring.pins" and design.ring.kind != "pin") or not applies(design.layout, table, name):
            continue
        section = getattr(design, table)
        value, field = getattr(section, name), type(section).model_fields[name]
        literal_values = get_args(field.annotation)
        options = tuple(option for option in texts.items() if not literal_values or option[0] in literal_values)
        if value not in texts:
            options += ((value, str(value).replace("_", " ")),)
        yield Control(key, LAYOUT, label, "", _sentence(field.description), value, options=options)
    for table, label in MADE_OF.items():
        value = value_of(design, f"{table}.name")
        names = tuple(MATERIALS) if value in MATERIALS else (value, *MATERIALS)
        options = tuple((name, name) for name in names)
        yield Control(
            f"{table}.name",
            MATERIAL,
            label,
            "",
            SETS_VALUES,
            value,
            options=options,
        )


def _create_slider(design: Design, group: str, name: str, label: str) -> Control:
    """Return a slider for a number of the design, with a range around its value in round steps, in units of the file.

    `name` names the number, such as ``ring.pin_radius`` (keys of `LABELS`), `group` the heading and `label` the label
    of the slider. The range follows from `COUNTS` for numbers of parts, else from `SPAN`.
    """
    table, _, key = name.partition(".")
    key = design.tooth_pair if key == "mesh" else key
    section = getattr(design, table)
    field, current_value = type(section).model_fields[key], getattr(section, key)
    unit = unit_of(field)
    path, meaning = f"{table}.{file_key(key, field)}", _sentence(field.description)
    bounds = bounds_of(field)
    min_value, max_value = (
        unit.from_si(bounds.get(key, open_end)) for key, open_end in (("ge", -math.inf), ("le", math.inf))
    )
    if name in COUNTS:
        lower_end = max(bounds["ge"], math.floor(current_value / SLIDER.count_span))
        return Control(
            path, group, label, "", meaning, current_value, lower_end, math.ceil(current_value * SLIDER.count_span), 1
        )
    value, is_clearance = unit.from_si(current_value), table == "clearance" or name in ADJUSTABLE
    typical_value = abs(value) or unit.from_si(design.rated_torque)  # of a design without load
    span = SPAN.get("clearance" if is_clearance else table, SLIDER.span)
    high = max(SLIDER.min_clearance_range_um, span * abs(value)) if is_clearance else span * typical_value
    step = 10.0 ** math.floor(math.log10(high / SLIDER.steps))
    lower_end = max(1.0, math.floor(typical_value / span / step)) * step
    if is_clearance:
        lower_end = max(min_value, -high) if name in ADJUSTABLE else step
    upper_end = min(max_value, math.ceil(high / step) * step)
    return Control(path, group, label, _symbol(unit.suffix), meaning, value, lower_end, upper_end, step)


def _symbol(unit: str) -> str:
    return SYMBOLS.get(unit, unit)


def _sentence(text: str | None) -> str:
    """Return a description with a capital letter."""
    text = text or ""
    return f"{text[:1].upper()}{text[1:]}"
