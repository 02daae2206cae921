"""Design files: TOML to ``Design`` and back, with every error in the words of the file."""

import difflib
import math
import os
import re
import tomllib
from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, get_origin

from pydantic import ValidationError
from pydantic.fields import FieldInfo

from cycloid_mj.base.errors import DesignError, UsageError, reason
from cycloid_mj.base.overwrite_guard import note_input
from cycloid_mj.base.text import match_case
from cycloid_mj.design.layouts import LISTED_IF_SET, applies
from cycloid_mj.design.measured import read_measurements
from cycloid_mj.design.model import Design
from cycloid_mj.design.presets import PRESETS
from cycloid_mj.design.section import Section
from cycloid_mj.design.similarity import scale_design
from cycloid_mj.design.units import Unit, counted_by, file_key, section_of, source_of, unit_of
from cycloid_mj.design.unsupported import unsupported_key
from cycloid_mj.design.validation_errors import as_design_error, literal_choices

S = TypeVar("S", bound=Section)


@dataclass(frozen=True)
class FileLimits:
    """Limits of a design file, against files that exhaust the memory."""

    integer: int = 2**63 - 1  # largest integer of TOML; a larger one counts as infinite
    list_length: int = 10_000  # longest list: more parts than any kind of part may have
    size: int = 1_000_000  # characters of a file that is read; a complete design file has about 25 000


LIMITS = FileLimits()

BASE = "base"
"""Table of a design file that names the preset whose values it keeps, and states whether these are scaled."""

PIN_CIRCLE = "ring.pin_circle_radius_mm"
"""Key of the length that is the size of a design."""

DEEP_KEY = re.compile(r"""(?<![\w-])(?:(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+){32}""")
"""A dotted key of more than 32 parts, which `tomllib` takes quadratic time to read; a design's keys have two."""

Named = Design | str | Path
"""A design, or the name of a preset or a file that has one."""


def resolve(named: Named, changes: Sequence[str] | Mapping[str, Any] = ()) -> Design:
    """Load the design that `named` is or refers to, and apply changes.

    Parameters
    ----------
    named
        A preset's name, a file, or a design, to which only the changes are applied.
    changes
        Changes with keys and units of the file: texts ``table.key=value``, or a mapping of ``table.key`` to value.

    Returns
    -------
    Design
        The design, with values in SI. It is immutable; `Design.but` returns a changed copy.

    Raises
    ------
    UsageError
        The name is no preset and the file does not exist, or `named` is neither a design nor a name.
    DesignError
        The file cannot be read or is not a valid design.
    """
    if not isinstance(named, Design | str | Path):
        raise UsageError(
            f"{named!r:.80} is not a design: choose a Design, the name of a preset ({', '.join(PRESETS)}), or the path "
            "of a design file"
        )
    design = named if isinstance(named, Design) else preset(str(named)) or load(Path(named))
    return override(design, changes) if changes else design


def preset(name: str) -> Design | None:
    """Return the preset of a name, ignoring case; None if there is none, or if a file has that name."""
    if name in PRESETS or os.path.exists(name):
        return PRESETS.get(name)
    return PRESETS.get(name.casefold())


def load(path: Path) -> Design:
    """Read the design of a TOML file, including the files of measurements that it names.

    Raises
    ------
    UsageError
        There is no such file, or it is a folder.
    DesignError
        The file cannot be read, or is not a valid design.
    """
    try:
        text = note_input(path).read_text(encoding="utf-8-sig")
    except FileNotFoundError as error:
        raise UsageError(_unknown_design(path)) from error
    except IsADirectoryError as error:
        raise UsageError(f"{path} is a folder: give the name of a design file (.toml) in it") from error
    except (OSError, ValueError) as error:
        raise DesignError(
            f"cannot read the design file {path}: {reason(error)}. Choose a readable TOML file with UTF-8 text"
        ) from error
    return loads(text, str(path), path.parent)


def loads(text: str, source: str = "the design", folder: Path | None = None) -> Design:
    """Parse the design of a TOML text; missing keys have the values of the preset in ``[base]``, or of ``pin``.

    With ``scaled = true`` in ``[base]``, the preset is scaled to the pin circle of the text (`scale_design`).
    If a text without ``[base]`` states a load but no torque of the motor, that torque follows from the load. `source`
    names the text in errors. Files of measurements are relative to the `folder`; without a folder, as for a log, they
    are not read, since the text contains their values.

    Raises
    ------
    DesignError
        The text is empty, not TOML, or not a valid design.
    """
    tables = parse_toml(text, source)
    if not tables:
        raise DesignError(
            f"{source} is empty: write the values of a design into it, or create a complete design file with "
            "`cycloid-mj design new my`"
        )
    if folder is not None and isinstance(tables.get("measured"), Mapping):
        tables["measured"] = read_measurements(tables["measured"], folder)
    if BASE in tables:
        base = base_design(tables, source).design
        del tables[BASE]
        return _apply_changes(base, list(_flat(tables)), source, folder)
    values = _read_table(Design, tables, source)
    design = _validate(Design, _expand_sparse_lists(values, source), source)
    return design if "torque" in values.get("drive", {}) else _add_motor(design, values)


def _flat(tables: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield the values of a file by ``table.key``, and those outside of tables by their key."""
    for name, value in tables.items():
        if isinstance(value, Mapping):
            yield from ((f"{name}.{key}", item) for key, item in value.items())
        else:
            yield name, value


@dataclass(frozen=True)
class Base:
    """The preset in ``[base]`` with its name, and the factor on its lengths [1]; None if they are not scaled."""

    name: str
    design: Design
    factor: float | None


def base_design(tables: Mapping[str, Any], source: str) -> Base:
    """Return the preset that the table ``[base]`` of a design file names, scaled to the file's pin circle if requested.

    The result has the preset's name, its design, and the factor on its lengths, which is None if they are not scaled.
    `tables` are those of the file, and `source` names it in errors. Raises DesignError if ``preset`` is not the name of
    a preset, ``scaled`` is not true or false, or there is another key.
    """
    table = tables[BASE] if isinstance(tables[BASE], Mapping) else {}
    name, is_scaled = str(table.get("preset", "")), table.get("scaled", False)
    if name.casefold() not in PRESETS or not isinstance(is_scaled, bool) or not table.keys() <= {"preset", "scaled"}:
        raise DesignError(
            f'{source}: the table [base] must contain only preset = "NAME" and, optionally, scaled = true or false. '
            f"Choose NAME from {', '.join(PRESETS)}"
        )
    design = PRESETS[name.casefold()]
    if not is_scaled:
        return Base(name, design, None)
    preset_size, size = value_of(design, PIN_CIRCLE), dict(_flat(tables)).get(PIN_CIRCLE)
    is_valid_size = isinstance(size, (int, float)) and not isinstance(size, bool) and 0.0 < size < math.inf
    factor = size / preset_size if is_valid_size else 1.0  # the validation of the file refuses any other size
    return Base(name, scale_design(design, factor), factor)


def _add_motor(design: Design, values: Mapping[str, Any]) -> Design:
    """Return a design with the motor torque and power that its load requires at the drive's speed, without losses.

    `values` are those of the file in SI, by table and name: a motor power in them is not changed. A design without load
    is unchanged.
    """
    torque = abs(design.load.torque) / design.reduction
    if not torque:
        return design
    power = torque * abs(design.drive.speed)
    motor_values = {"torque": torque} | ({"power": power} if power and "power" not in values.get("drive", {}) else {})
    return design.but(drive=motor_values)


def parse_toml(
    text: str, source: str, example: str = "`cycloid-mj design show pin` prints a complete design file"
) -> dict[str, Any]:
    """Parse an untrusted TOML text; return its tables as a dict.

    In errors, `source` names the text and `example` says where a correct file is shown.

    Raises
    ------
    DesignError
        It is not TOML, is larger than `LIMITS.size`, or is nested too deeply.
    """
    if len(text) > LIMITS.size:
        raise DesignError(
            f"{source} has {len(text):,} characters, but at most {LIMITS.size:,} are allowed. Check that it is a TOML "
            f"file; {example}"
        )
    try:
        if DEEP_KEY.search(text):
            raise RecursionError
        return tomllib.loads(text)
    except RecursionError as error:
        raise DesignError(
            f"{source} is nested too deeply: a design file contains tables with keys, and no tables inside tables. "
            f"Remove the inner tables; {example}"
        ) from error
    except ValueError as error:
        raise DesignError(f"{source} is not valid TOML: {error}. Correct this line; {example}") from error


def record(kind: type[S], tables: Mapping[str, Any], where: str) -> S:
    """Read the tables of another file than a design's, by the same rules; `kind` has them as its sections."""
    return _validate(kind, _read_table(kind, tables, where, root=kind), where)


def override(design: Design, changes: Sequence[str] | Mapping[str, Any]) -> Design:
    """Return a copy of the design with changed values; keys and units are those of the design file.

    ``override(design, ["load.torque_nm=36"])`` and ``override(design, {"load.torque_nm": 36.0})`` are the same. Values
    of a mapping are numbers, texts or lists. For values in SI use `Design.but`.

    Raises
    ------
    UsageError
        A change does not have the form ``table.key=value``.
    DesignError
        There is no such key, or its value is not allowed.
    """
    if isinstance(changes, str):
        changes = [changes]
    if not isinstance(changes, Mapping | Sequence) or not all(isinstance(change, str) for change in changes):
        raise UsageError(
            f'changes = {changes!r:.80} is not allowed: use texts such as "load.torque_nm=36", or a mapping such as '
            '{"load.torque_nm": 36}'
        )
    if isinstance(changes, Mapping):
        return _apply_changes(design, [(path, _plain(value)) for path, value in changes.items()], "override", Path())
    return _apply_changes(design, [_pair(change) for change in changes], "--set", Path())


def _apply_changes(design: Design, pairs: Sequence[tuple[str, Any]], source: str, folder: Path | None) -> Design:
    """Return a copy of the design with changed values, validated as a file is.

    `pairs` are paths such as ``load.torque_nm`` and values in the units of the file; `source` names their origin in
    errors. Measurements that they name are read from the `folder`.
    """
    affected_tables = {keys[0] for path, _ in pairs if (keys := _keys(path))}
    tables, changed_tables = dict(_file_tables(design, affected_tables)), dict[str, dict[str, Any]]()
    for path, value in pairs:
        keys = _keys(path)
        if not keys:
            raise UsageError(f"{source} {path!r} is not a key: give table.key, e.g. load.torque_nm")
        if len(keys) == 1:
            tables[path] = value
        elif isinstance(tables.get(keys[0], {}), dict):
            changed_tables.setdefault(keys[0], {})[keys[1]] = value
        else:
            raise UsageError(
                f"{source} {path!r} is not a key, because {keys[0]} is a value and not a table: give {keys[0]} alone"
            )
    for name, change in changed_tables.items():
        section = section_of(field) if (field := Design.model_fields.get(name)) else None
        tables[name] = (section or Section).merge_change(tables.get(name, {}), change)
    if "measured" in changed_tables and folder is not None:
        tables["measured"] = read_measurements(tables["measured"], folder)
    if not pairs:
        return design
    values = _values_except(design, affected_tables) | _read_table(Design, tables, source)
    return _validate(Design, _expand_sparse_lists(values, source), source)


def declaration_of(path: str) -> FieldInfo:
    """Return the declaration (type, unit, bounds, description) of a key of the design file, such as ``load.torque_nm``.

    Raises
    ------
    UsageError
        There is no such key; the message suggests a similar key.
    """
    section, prefix = Design, ""
    *tables, key = _keys(path) or [path]
    for table in tables:
        section, prefix = section_of(_field_of(section, table, path, prefix)), f"{table}."
    return _field_of(section, key, path, prefix)


def value_of(design: Design, path: str) -> Any:
    """Return the value of a key of the design file, such as ``load.torque_nm``, in the unit of the file.

    A part without its own material table has the values of the table ``material``.

    Raises
    ------
    UsageError
        There is no such key; the message suggests a similar key.
    """
    declaration_of(path)
    table_name, *inner_keys = _keys(path)
    tables: dict[str, Any] = dict(_file_tables(design, (table_name, "material")))
    return tables.get(table_name, tables["material"])[inner_keys[0]] if inner_keys else tables[path]


def _field_of(section: type[Section] | None, key: str, path: str, prefix: str) -> FieldInfo:
    fields_by_key = {file_key(name, field): field for name, field in section.model_fields.items()} if section else {}
    if key not in fields_by_key:
        raise UsageError(f"unknown key {path:.80}; {_suggest_key(key, list(fields_by_key), prefix)}")
    return fields_by_key[key]


def _pair(change: str) -> tuple[str, Any]:
    """Split ``table.key=value``."""
    path, equals, value = change.partition("=")
    if not equals or not _keys(path.strip()):
        raise UsageError(f"--set {change!r} is not an assignment: give table.key=value, e.g. --set load.torque_nm=36")
    return path.strip(), _parse_value(value.strip())


def _keys(path: str) -> list[str]:
    """List table and key, or the one key of a value outside of tables; nothing if a path is neither."""
    keys = path.split(".")
    return keys if len(keys) <= 2 and all(keys) else []


def _plain(value: Any) -> Any:
    """Convert a NumPy value to a Python value."""
    return value.tolist() if hasattr(value, "tolist") else value


def dump(design: Design, reasons: Mapping[str, str] | None = None) -> str:
    """Return the complete design file of a design as TOML text with comments; `loads` reads back an equal design.

    `reasons` are explanations of values, which are written in the comments. Their keys are the attribute names of
    `Design`, without the units of the file's keys: ``table.name``, such as ``load.torque`` for ``load.torque_nm``, or
    the name alone for a value outside of tables.
    """
    reasons = reasons or {}
    lines = ["# cycloid_mj design file. Each key ends in its unit."]
    lines += [
        ("# (assumed): not given in the paper (Hsieh 2014) and assumed here. Any other name: source of the default."),
        "",
    ]
    for name, field, value in _fields(design):
        if isinstance(value, Section):
            listed_fields = [inner for inner in _fields(value) if _is_listed(design, name, *inner)]
            if listed_fields:
                lines += ["", f"# {field.description or _summary(type(value))}", f"[{name}]"]
            lines += [
                _line(inner_name, inner_field, inner_value, reasons.get(f"{name}.{inner_name}", ""))
                for inner_name, inner_field, inner_value in listed_fields
            ]
        elif applies(design.layout, "", name):
            lines.append(_line(name, field, value, reasons.get(name, "")))
    return "\n".join(lines) + "\n"


def _is_listed(design: Design, table: str, name: str, field: FieldInfo, value: Any) -> bool:
    """Return whether a design file lists the value of a `field`, which has the attribute name `name` in a table."""
    is_set = f"{table}.{name}" in LISTED_IF_SET and value != field.default
    return is_set or applies(design.layout, table, name)


def dump_short(design: Design, preset_name: str, changed: Container[str] = ()) -> str:
    """Return a design file to extend by hand: number of teeth, pin circle and the keys in `changed`, with comments.

    All other values are those of the preset `preset_name`, scaled to the pin circle.
    """
    value_lines, table_lines = list[str](), list[str]()
    for name, field, value in _fields(design):
        if isinstance(value, Section):
            paths = {
                f"{name}.{file_key(inner_name, inner_field)}": (inner_name, inner_field, inner_value)
                for inner_name, inner_field, inner_value in _fields(value)
            }
            lines = [
                _line(*inner) for path, inner in paths.items() if path in ("ring.teeth", PIN_CIRCLE) or path in changed
            ]
            table_lines += ["", f"[{name}]", *lines] if lines else []
        elif name == "name" or name in changed:
            value_lines.append(_line(name, field, value))
    header = [
        "# cycloid_mj design file. Keys that are left out have the values of [base]; lengths follow the pin circle.",
        "# `cycloid-mj design show` prints all keys with their values.",
    ]
    base_lines = ["", f"[{BASE}]", f"preset = {_toml(preset_name)}", "scaled = true"]
    return "\n".join([*header, "", *value_lines, *base_lines, *table_lines]) + "\n"


def _summary(section: type[Section]) -> str:
    """Return the first sentence on a section: the rest of its docstring is for readers of the code."""
    return (section.__doc__ or "").strip().partition("\n")[0]


def _line(name: str, field: FieldInfo, value: Any, reason: str = "") -> str:
    """Return one commented line; the source is stated only for a value that is the default."""
    source = reason or (source_of(field) if value == field.default else "")
    note = f" ({source})" if source else ""
    return f"{file_key(name, field)} = {_toml(_to_file(field, value))}  # {field.description}{note}"


def _toml(value: Any) -> str:
    """Write a value as TOML."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return f"[{', '.join(map(repr, value))}]"
    return _toml_text(value) if isinstance(value, str) else repr(value)


def _toml_text(text: str) -> str:
    """Write a text as a basic string of TOML, with escapes where it needs them."""
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + "".join(sign if sign.isprintable() else f"\\U{ord(sign):08x}" for sign in escaped) + '"'


def _to_file(field: FieldInfo, value: Any) -> Any:
    if isinstance(value, tuple):
        return tuple(unit_of(field).from_si(item) for item in value)
    return unit_of(field).from_si(value) if isinstance(value, float) else value


def _fields(section: Section) -> Iterator[tuple[str, FieldInfo, Any]]:
    for name, field in type(section).model_fields.items():
        if (value := getattr(section, name)) is not None:
            yield name, field, value


def _file_tables(section: Section, table_names: Container[str] | None = None) -> Iterator[tuple[str, Any]]:
    """Yield the keys and values of a section of the design model as they are written in a design file.

    `table_names` limits them to some tables; by default, all are included.

    Yields
    ------
    tuple
        Key, and value in the unit of the file. For a section within this section, the value is a dict of its keys.
    """
    for name, field, value in _fields(section):
        if table_names is not None and name not in table_names:
            continue
        if isinstance(value, Section):
            yield name, dict(_file_tables(value))
        else:
            yield file_key(name, field), _to_file(field, value)


def _values_except(design: Design, named: Container[str]) -> dict[str, Any]:
    """Return the values of a design in SI, except for `names`."""
    return {
        name: {key: item for key, _, item in _fields(value)} if isinstance(value, Section) else value
        for name, _, value in _fields(design)
        if name not in named
    }


@cache
def _keys_of(section: type[Section]) -> dict[str, tuple[str, FieldInfo]]:
    """Map key of the file to name and declaration in the model."""
    return {file_key(name, field): (name, field) for name, field in section.model_fields.items()}


def _read_table(
    section: type[Section], table: Mapping[str, Any], source: str, prefix: str = "", root: type[Section] = Design
) -> dict[str, Any]:
    """Return the values of a table of the file by their names in the model instead of file keys, in SI units.

    Parameters
    ----------
    section, table
        The section of the model, and the table of the file.
    source
        Name of the file in errors.
    prefix
        Name of this table followed by a dot, which precedes its keys in errors; empty for the entire file.
    root
        Model of all tables of the file.

    Raises
    ------
    DesignError
        A key is unknown, or a table is written as a single value. Other wrong values are left to the validation.
    """
    known_keys = _keys_of(section)
    values: dict[str, Any] = {}
    for key, value in table.items():
        if key not in known_keys:
            hint = unsupported_key(f"{prefix}{key}") or _suggest_key(key, list(known_keys), prefix, root)
            raise DesignError(f"{source}: unknown key {prefix}{key:.80}; {hint}")
        name, field = known_keys[key]
        annotation, inner_section = field.annotation, section_of(field)
        if inner_section:
            if not isinstance(value, Mapping):
                raise DesignError(
                    f"{source}: {key} is a table, but is given as a value: write [{key}], and its keys on the lines "
                    "below"
                )
            values[name] = _read_table(inner_section, value, source, f"{prefix}{key}.", root)
        elif get_origin(annotation) is tuple and isinstance(value, Mapping):
            values[name] = {part: _number_to_si(unit_of(field), item) for part, item in value.items()}
        elif get_origin(annotation) is tuple and isinstance(value, (list, tuple)):
            values[name] = tuple(_number_to_si(unit_of(field), item) for item in value)
        elif annotation is float or (isinstance(value, int) and abs(value) > LIMITS.integer):
            values[name] = _number_to_si(unit_of(field), value)
        elif isinstance(value, str):
            values[name] = match_case(value, literal_choices(field))
        else:
            values[name] = value
    return values


def _number_to_si(unit: Unit, value: Any) -> Any:
    """Convert a number of the file to SI; any other value is returned as it is, for the validation to refuse."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return value
    if isinstance(value, int) and abs(value) > LIMITS.integer:
        return math.inf if value > 0 else -math.inf
    return unit.to_si(float(value))


def _expand_sparse_lists(values: dict[str, Any], source: str) -> dict[str, Any]:
    """Replace sparse lists such as ``{3 = 5.0}`` in a design file by lists with a value for each part, in place.

    In this example the third value is 5 and the others are 0. `values` are the tables of the file, `source` names it in
    errors; the lengths of lists follow from counts such as ``ring.teeth``.
    """
    for table, section in values.items():
        section_type = section_of(Design.model_fields[table])
        fields = section_type.model_fields if section_type else {}
        for name in [key for key, value in section.items() if isinstance(value, Mapping)] if fields else ():
            counts = [_count(values, *key) for key in counted_by(fields[name])]
            if counts:
                key = f"{table}.{file_key(name, fields[name])}"
                section[name] = _expand_list(section[name], counts, f"{source}: {key}")
    return values


def _count(values: Mapping[str, Any], table: str, name: str) -> Any:
    """Return an integer of the file, or its default."""
    return values.get(table, {}).get(name, section_of(Design.model_fields[table]).model_fields[name].default)


def _expand_list(sparse: Mapping[str, Any], counts: Sequence[Any], source: str) -> tuple[Any, ...]:
    """Expand sparse values such as ``{"3": 5.0}`` to a tuple with a value for each part, 0 for parts not in `sparse`.

    Parts are numbered from 1, and their number is the product of `counts`; `source` names the key in errors. If a count
    is out of range, only the values in `sparse` are returned, and the validation reports the count. Raises DesignError
    if a part does not exist.
    """
    if not all(isinstance(count, int) and count <= LIMITS.list_length for count in counts):
        return tuple(sparse.values())  # the validation reports the number of parts, which is out of range
    part_count = math.prod(counts)
    parts = [str(part) for part in range(1, part_count + 1)]
    for part in sparse:
        if part not in parts:
            raise DesignError(f"{source}: there is no value number {part:.40}: use numbers from 1 to {len(parts)}")
    return tuple(sparse.get(part, 0.0) for part in parts)


def _validate(kind: type[S], values: dict[str, Any], where: str) -> S:
    try:
        return kind.model_validate(values, strict=True)
    except ValidationError as error:
        raise as_design_error(error, kind, where) from error


def _suggest_key(key: str, known_keys: list[str], prefix: str, root: type[Section] = Design) -> str:
    """Return a sentence that suggests known keys for an unknown one: another unit, another table, or similar spelling.

    `known_keys` are the keys of the table, `prefix` is its name followed by a dot, and `root` is the model of the file.
    If no key is similar, the sentence lists all keys of the table.
    """
    stems = (key, key.rsplit("_", 1)[0])
    keys_of_other_unit = next(
        filter(None, ([prefix + name for name in known_keys if name.rsplit("_", 1)[0] == stem] for stem in stems)), []
    )
    tables = ((name, section_of(field)) for name, field in root.model_fields.items())
    all_keys = [f"{table}.{name}" for table, section in tables if section for name in _keys_of(section)]
    same_name_keys = [name for name in all_keys if name.endswith(f".{key}")]
    similar_keys = [prefix + name for name in difflib.get_close_matches(key, known_keys, n=1)]
    suggestions = (
        keys_of_other_unit or same_name_keys or similar_keys or difflib.get_close_matches(prefix + key, all_keys, n=1)
    )
    if suggestions:
        return f"did you mean {' or '.join(suggestions)}?"
    return "available keys: " + ", ".join(prefix + name for name in known_keys)


def _unknown_design(path: Path) -> str:
    """Return the error message for a design that is neither a preset nor a file, with the most similar name."""
    presets = ", ".join(PRESETS)
    folder = path.parent if path.parent.is_dir() else Path()
    files = [str(folder / name) for name in sorted(item.name for item in folder.glob("*.toml"))]
    similar_designs = difflib.get_close_matches(str(path), [*PRESETS, *files], n=1)
    hint = (
        f"did you mean {similar_designs[0]}?"
        if similar_designs
        else "`cycloid-mj design new my` writes a design file to start from"
    )
    return f"unknown design {str(path)!r}: it is neither a preset ({presets}) nor a file; {hint}"


def _parse_value(value: str) -> Any:
    try:
        return tomllib.loads(f"value = {value}")["value"]
    except (ValueError, RecursionError):
        return value
