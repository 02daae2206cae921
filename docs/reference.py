"""The pages of the documentation that are generated from the code: design file, commands, Python functions."""

import inspect
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

import cycloid_mj
from cycloid_mj.base.notebook_display import CallableRoom
from cycloid_mj.cli.app import application
from cycloid_mj.cli.contents import PYTHON as FUNCTIONS
from cycloid_mj.design import Design
from cycloid_mj.design.units import file_key, section_of, source_of, unit_of

DESIGN = """# The design file

A design file is a TOML file that describes a drive. This page lists every key with its unit, its value in the preset
`pin`, the allowed values and the source of the value. `cycloid-mj design show pin` prints them as a file. A key that
you leave out has the value of `pin`, or of the preset that `[base] preset = "NAME"` names. With `scaled = true` in
`[base]`, the preset is scaled to the pin circle of the file.

`--set table.key=value` overrides the file for a single command. A flag such as `--load-nm` or `--speed-rpm` overrides
both.
"""

COMMANDS = """# The commands

This page has the text of `--help` for every command.

- Results go to stdout, progress and messages to stderr.
- Exit codes: 0 success, 1 failure, 2 wrong usage.
- A design is the first argument, or the value of `--design`.
- The terminal shows the headline, failures and warnings; `--all` shows everything.
- `--out` is the folder of the written files, `--html` writes a page.
- `cycloid-mj --install-completion` lets your shell complete commands and flags.
"""

PYTHON = """# The Python package

Use the package from Python for your own studies. A short example:

```python
import cycloid_mj as cm

design = cm.load("pin", {"clearance.cam_um": 2.0})  # a preset or a file, with changed keys
sheet = cm.statics(design)  # backlash, stiffness, errors, loads, capacity, losses
print(sheet)
print(f"backlash {sheet.quantities['backlash'].value:.2f} arcmin")
run = cm.simulate(cm.load("pin", {"drive.ramp_s": 0.0, "drive.hold_s": 0.01, "load.torque_nm": 36.0}))
results = cm.analyze(run)
print(results)
print(f"largest contact force {results.contact_summary.peak_force_n:.0f} N")
page = cm.report({"run": run})  # one HTML page, as text
```

`import cycloid_mj as cm` provides the names below. Each is imported when you first use it.

- Numbers are in SI units and radians, unless a name ends in its unit.
- Results print as one line, and as a table in a notebook.
- `.to_frame()` returns a pandas (or polars) `DataFrame`, `.plot()` a figure.
- Long calls show a progress bar in a notebook. Elsewhere, pass `progress=print` or your own function
  of the numbers of finished and of all steps.

The [example notebook](../_gallery/plot_14_notebook) shows most of them. Each command of the
terminal has a function:

"""


def write(folder: Path) -> None:
    """Write the pages that have changed into a folder."""
    folder.mkdir(exist_ok=True)
    for name, text in {"design-file": design_file(), "commands": commands(), "python": python()}.items():
        page = folder / f"{name}.md"
        if not page.exists() or page.read_text(encoding="utf-8") != text:
            page.write_text(text, encoding="utf-8")


def design_file() -> str:
    """Return the page of the design file, with a table for each of its tables."""
    design = Design()
    tables = [(name, section_of(field)) for name, field in Design.model_fields.items()]
    return DESIGN + "".join(_table(name, field, getattr(design, name)) for name, field in tables if field)


def _table(name: str, section: type[BaseModel], values: Any) -> str:
    """Return one table of the design file; the values of an optional table are empty."""
    about = (Design.model_fields[name].description or section.__doc__ or "").strip().partition("\n")[0]
    rows = [
        (
            f"`{file_key(key, field)}`",
            _value(field, getattr(values, key, None)),
            _allowed(field),
            str(field.description),
            source_of(field),
        )
        for key, field in section.model_fields.items()
    ]
    head = "| Key | In `pin` | Allowed | Meaning | Source |\n|---|---|---|---|---|\n"
    lines = "".join("| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |\n" for row in rows)
    return f"\n## {name}\n\n{about}\n\n{head}{lines}"


def _value(field: FieldInfo, value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, float):
        return f"{unit_of(field).from_si(value):g}"
    word = str(value).lower() if isinstance(value, bool) else str(value)
    return f"`{word}`" if word and word != "()" else "empty"


def _allowed(field: FieldInfo) -> str:
    """Return the allowed words or bounds, in the unit of the file."""
    if get_origin(field.annotation) is Literal:
        return ", ".join(f"`{word}`" for word in get_args(field.annotation))
    words = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}
    bounds = [(words[name], getattr(one, name)) for one in field.metadata for name in words if hasattr(one, name)]
    return ", ".join(f"{word} {unit_of(field).from_si(float(bound)):g}" for word, bound in bounds)


UNLISTED_FLAGS = re.compile(r", --(?:no|empty)-[\w-]+(?=[`,])")
"""Negative flags that the parser accepts and ``--help`` does not list."""

DEFAULT = re.compile(r" \*\[default: (.*?)\]\*$")
"""Default value at the end of a parameter's line."""

UNSAID_DEFAULTS = {"False", "()", '""', "None"}
"""Default values that say nothing."""


def commands() -> str:
    """Return the page of the commands, from their help."""
    text = application().generate_docs(output_format="markdown")
    body = text[text.index("\n## cycloid-mj ") :]
    # of `python -m sphinx`, under whose name the build runs, cyclopts drops the first word alone
    body = re.sub(r"^(cycloid-mj .*?)-m sphinx ", r"\1", body, flags=re.MULTILINE)
    body = "\n".join(_parameter(line) if line.startswith("* `") else line for line in body.splitlines())
    return COMMANDS + "\n" + re.sub(r"\n{3,}", "\n\n", _escape_brackets(body)) + "\n"


def _parameter(line: str) -> str:
    """Return the line of a parameter as ``--help`` has it: listed flags, and a default value said once."""
    line = UNLISTED_FLAGS.sub("", line)
    default = DEFAULT.search(line)
    return DEFAULT.sub("", line) if default and (default[1] in UNSAID_DEFAULTS or "Default:" in line) else line


def _escape_brackets(text: str) -> str:
    """Escape ``<``, which Markdown reads as HTML, outside of code."""
    in_code = re.compile(r"(```.*?```|`[^`\n]*`)", re.DOTALL)
    return "".join(part if k % 2 else part.replace("<", "&lt;") for k, part in enumerate(in_code.split(text)))


def python() -> str:
    """Return the page of the public names of the package, from their docstrings."""
    rows = (
        f"| `{command}` | {', '.join(f'`cm.{name}`' for name in names)} |\n" for command, names in FUNCTIONS.items()
    )
    return PYTHON + "| Command | Python |\n|---|---|\n" + "".join(rows) + "".join(_directives())


def _directives() -> Iterator[str]:
    for name in cycloid_mj.__all__:
        value = getattr(cycloid_mj, name)
        is_room = inspect.ismodule(value) and not isinstance(value, CallableRoom)
        kind = "module" if is_room else "class" if inspect.isclass(value) else "function"
        if not (inspect.ismodule(value) or callable(value)):
            continue
        members = "   :members:\n   :exclude-members: model_config\n" if kind == "class" else ""
        place = f"{name}.main" if isinstance(value, CallableRoom) else name
        yield f"\n## `{name}`\n\n```{{eval-rst}}\n.. auto{kind}:: cycloid_mj.{place}\n{members}```\n"
