"""Validation errors of pydantic, restated in the words of the design file."""

import re
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any, get_args

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.text import escape_controls
from cycloid_mj.design.units import BOUNDS, Unit, bounds_of, file_key, section_of, unit_of
from cycloid_mj.design.unsupported import unsupported_value


@dataclass(frozen=True)
class ListingLimits:
    """Limits of the message on wrong values."""

    errors: int = 5  # wrong values that are listed; the others are counted
    value_length: int = 80  # characters of a wrong value that are quoted


LISTING = ListingLimits()


REQUIREMENTS = {
    "bool_type": "true or false",
    "bool_parsing": "true or false",
    "finite_number": "a finite number",
    "float_parsing": "a number",
    "float_type": "a number",
    "int_from_float": "a whole number, without a decimal point",
    "int_parsing": "a whole number",
    "int_parsing_size": "a whole number of at most 18 digits",
    "int_type": "a whole number",
    "dataclass_type": "a table",
    "dict_type": "a table",
    "mapping_type": "a table",
    "model_attributes_type": "a table",
    "model_type": "a table",
    "string_pattern_mismatch": "text of the allowed characters",
    "string_type": 'text in quotes, such as "pin"',
    "list_type": "a list such as [5.0, 0.0] or {1 = 5.0}",
    "tuple_type": "a list such as [5.0, 0.0] or {1 = 5.0}",
}
"""Error type of pydantic -> what the value must be."""


def as_design_error(error: ValidationError, root: type[BaseModel], source: str) -> DesignError:
    """Convert a validation error to a DesignError that lists key, value and allowed values of each wrong value.

    Parameters
    ----------
    root
        The model that was validated.
    source
        Origin of the values, such as the name of a file.
    """
    sentences = [_describe_error(details, root) for details in error.errors()[: LISTING.errors]]
    if len(sentences) == 1:
        return DesignError(f"{source}: {sentences[0]}")
    error_count, unlisted_count = error.error_count(), error.error_count() - len(sentences)
    return DesignError(
        f"{source} has {error_count:,} wrong values. Correct them as follows:",
        [*sentences, f"and {unlisted_count:,} more"] if unlisted_count else sentences,
    )


def literal_choices(field: FieldInfo) -> tuple[str, ...]:
    """Return the words that a declared value may be; empty for a value of another type."""
    return tuple(choice for choice in get_args(field.annotation) if isinstance(choice, str))


def _describe_error(details: ErrorDetails, root: type[BaseModel]) -> str:
    """Describe a wrong value in a sentence: key, value, allowed values and meaning.

    `details` are those of pydantic, `root` is the model that was validated.
    """
    keys, field = _locate_error(details, root)
    key = ".".join(keys)
    if not keys or field is None:
        requirement = _requirement(details)
        return f"{key}: {requirement}" if keys else requirement
    if details["type"] == "missing":
        return f"{key} is missing ({field.description})"
    unit, value = unit_of(field), details["input"]
    value_text = _quote(unit.from_si(value) if isinstance(value, float) else value)
    if isinstance(value, str) and (unsupported_text := unsupported_value(key, value)):
        return f"{key} = {value_text} is not supported: {unsupported_text}"
    description_text = "" if details["type"] == "value_error" else f" ({field.description})"
    return f"{key} = {value_text} is not allowed: {_describe_allowed(details, field, unit)}{description_text}"


def _quote(value: Any) -> str:
    """Write a value as in TOML, and of a long one its start."""
    if isinstance(value, bool):
        return str(value).lower()
    text = f'"{escape_controls(value)}"' if isinstance(value, str) else repr(value)
    return text if len(text) <= LISTING.value_length else f"{text[: LISTING.value_length]}..."


def _locate_error(details: ErrorDetails, root: type[BaseModel]) -> tuple[list[str], FieldInfo | None]:
    """Return file keys and declaration (type, unit, bounds) of a wrong value.

    `details` are those of pydantic, `root` is the model that was validated. Items of lists have their number in
    brackets, from 1 on.

    Returns
    -------
    tuple
        File keys (table, key) of the value, and its declaration, which is None for an unknown key.
    """
    section, field, keys = root, None, list[str]()
    for name in details["loc"]:
        if isinstance(name, int) and keys:
            keys[-1] += f"[{name + 1}]"
            continue
        field = section.model_fields.get(str(name))
        keys.append(file_key(str(name), field) if field else str(name))
        section = (section_of(field) if field else None) or section
    return keys, field


def _describe_allowed(details: ErrorDetails, field: FieldInfo, unit: Unit) -> str:
    """Describe the allowed values of a key in words: a range in the file's unit, a choice, or a type.

    `details` are those of pydantic, `field` is the declaration of the key.
    """
    value, choices = details["input"], literal_choices(field)
    if details["type"] == "literal_error" and choices:
        similar_choices = get_close_matches(value.casefold(), choices, n=1) if isinstance(value, str) else []
        suggestion = f'; did you mean "{similar_choices[0]}"?' if similar_choices else ""
        return f"it must be {_either(choices)}{suggestion}"
    if details["type"] in ("greater_than", "greater_than_equal", "less_than", "less_than_equal"):
        # the bounds of the items of a list stand in the error alone
        bounds = bounds_of(field) or details.get("ctx", {})
        return f"it must be {range_words({name: unit.from_si(float(bound)) for name, bound in bounds.items()})}"
    return _requirement(details)


def range_words(bounds: dict[str, float]) -> str:
    """Describe bounds by name (``gt``, ``ge``, ``lt``, ``le``) in words: "from 4 to 400", "greater than 0"."""
    numbers = {name: f"{bound:.10g}" for name, bound in bounds.items() if name in BOUNDS}
    if numbers.keys() == {"ge", "le"}:
        return f"from {numbers['ge']} to {numbers['le']}"
    return " and ".join(f"{BOUNDS[name]} {number}" for name, number in numbers.items())


def _requirement(details: ErrorDetails) -> str:
    """Describe the allowed values by the type of an error."""
    if details["type"] in ("value_error", "assertion_error"):
        return str(details.get("ctx", {}).get("error", "")) or _plain(details["msg"])
    if (words := REQUIREMENTS.get(details["type"])) is not None:
        return f"it must be {words}"
    return _plain(details["msg"])


def _plain(message: str) -> str:
    """Return a message of pydantic without its prefix "Value error," and its phrase "Input should be"."""
    message = re.sub(r"^(\w+ error|Assertion failed), ", "", message)
    message = re.sub(r"^(\w+ )*?(should|must)\b", "it must", message)
    return message[:1].lower() + message[1:]


def _either(choices: tuple[Any, ...]) -> str:
    """List words as alternatives."""
    *first_choices, last_choice = (f'"{choice}"' for choice in choices)
    return f"{', '.join(first_choices)} or {last_choice}" if first_choices else str(last_choice)
