"""Validation errors of pydantic, restated in the words of the design file."""

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from cycloid_mj.base.errors import DesignError
from cycloid_mj.design.units import file_key, section_of, unit_of

MOST_ERRORS = 5
"""Wrong values of a design that are told one by one; the others are counted."""


def refusal(error: ValidationError, root: type[BaseModel], where: str) -> DesignError:
    """Return the error that tells each mistake in a design: key, value and what is allowed, in the units of the file.

    `root` is the model that was validated; `where` tells where the values came from.
    """
    sentences = [_sentence(details, root, where) for details in error.errors()[:MOST_ERRORS]]
    rest = error.error_count() - len(sentences)
    return DesignError("; ".join([*sentences, f"and {rest:,} more"] if rest else sentences))


def _sentence(details: ErrorDetails, root: type[BaseModel], where: str) -> str:
    """One validation error in the words of the file: key, value, what is allowed."""
    section = root
    field: FieldInfo | None = None
    keys: list[str] = []
    for name in details["loc"]:
        if isinstance(name, int) and keys:
            keys[-1] += f"[{name + 1}]"
            continue
        field = section.model_fields.get(str(name))
        keys.append(file_key(str(name), field) if field else str(name))
        section = (section_of(field) if field else None) or section
    got = details["input"]
    if not keys:
        return f"{where}: {details.get('ctx', {}).get('error', details['msg'])}"
    if field is None:
        return f"{where}: {'.'.join(keys)}: {details['msg']}"
    if details["type"] == "missing":
        return f"{where}: {'.'.join(keys)} is missing ({field.description})"
    unit = unit_of(field)
    shown = unit.from_si(got) if isinstance(got, float) else got
    bounds = {name: bound for name, bound in details.get("ctx", {}).items() if isinstance(bound, (int, float))}
    words = {"gt": "more than", "ge": "at least", "lt": "less than", "le": "at most"}
    limits = [f"{words[name]} {unit.from_si(float(bound)):g}" for name, bound in bounds.items() if name in words]
    message = "a list such as [5.0, 0.0] or {1 = 5.0}" if details["type"] == "tuple_type" else details["msg"]
    allowed = " and ".join(limits) if limits else message
    return f"{where}: {'.'.join(keys)} = {shown!r:.80} is not allowed: {allowed} ({field.description})"
