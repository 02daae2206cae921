"""The pages of the documentation that are written from the code: design file, commands, Python functions."""

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
from cycloid_mj.design import Design
from cycloid_mj.design.units import file_key, section_of, source_of, unit_of

DESIGN = """# Reference: the design file

A design file is TOML. Every key is listed here with its unit, its value in the preset `pin`, what is allowed, and where
the value comes from; `cycloid-mj design show pin` prints them as a file. A key that is left out keeps this value.

Which value counts: `--set table.key=value` overrides the file for a single command, and a flag (`--load-nm`,
`--speed-rpm`, ...) overrides both.
"""

COMMANDS = """# Reference: the commands

What `--help` says, in one page. Results go to stdout, progress and messages to stderr; exit code 0 is done, 1 failed,
2 wrong usage. A design is given by its place or by `--design`. The terminal shows headline, failures and warnings of a
result, all of it with `--all`; `--out` names the folder of its files, `--html` its page.
`cycloid-mj --install-completion` makes the shell complete commands and flags.
"""

PYTHON = """# Reference: Python

```python
import cycloid_mj as cm

design = cm.load("pin", {"clearance.cam_um": 2.0})  # a preset or a file, with changes in the words of its file
sheet = cm.statics(design)  # backlash, stiffness, errors, loads, capacity, losses
print(sheet)
print(f"{sheet.quantities['backlash'].value:.2f} arcmin of play")
run = cm.simulate(cm.load("pin", {"drive.ramp_s": 0.0, "drive.hold_s": 0.01, "load.torque_nm": 36.0}))
findings = cm.analyze(run)
print(findings)
print(f"{findings.contact_summary.peak_force_n:.0f} N at the hardest contact")
page = cm.report({"run": run})  # one HTML page, as text
```

`import cycloid_mj as cm` gives the names below; each is imported when first used, and `dir(cm)` lists them alone.
Numbers are in SI units and radians, but where a name ends in its unit. Tables, sheets and findings print as one line;
in a notebook they show as a table, `.to_frame()` gives a `DataFrame` of pandas, or of polars, and `.plot()` a figure.
"""


def write(folder: Path) -> None:
    """Write the pages into a folder, those alone that have changed."""
    folder.mkdir(exist_ok=True)
    for name, text in {"design-file": design_file(), "commands": commands(), "python": python()}.items():
        page = folder / f"{name}.md"
        if not page.exists() or page.read_text(encoding="utf-8") != text:
            page.write_text(text, encoding="utf-8")


def design_file() -> str:
    """Give the page of the design file: a table for each of its tables."""
    design = Design()
    tables = [(name, section_of(field)) for name, field in Design.model_fields.items()]
    return DESIGN + "".join(_table(name, field, getattr(design, name)) for name, field in tables if field)


def _table(name: str, section: type[BaseModel], values: Any) -> str:
    """Give one table of the design file; parts without a material of their own have no values of it."""
    about = (Design.model_fields[name].description or section.__doc__ or "").strip().partition("\n")[0]
    rows = [
        (f"`{file_key(key, field)}`", _value(field, getattr(values, key, None)), _allowed(field), *_told(field))
        for key, field in section.model_fields.items()
    ]
    head = "| key | in `pin` | allowed | what it is | from |\n|---|---|---|---|---|\n"
    lines = "".join("| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |\n" for row in rows)
    return f"\n## {name}\n\n{about}\n\n{head}{lines}"


def _told(field: FieldInfo) -> tuple[str, str]:
    return str(field.description), source_of(field)


def _value(field: FieldInfo, value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, float):
        return f"{unit_of(field).from_si(value):g}"
    word = str(value).lower() if isinstance(value, bool) else str(value)
    return f"`{word}`" if word and word != "()" else "empty"


def _allowed(field: FieldInfo) -> str:
    """Give the words or the bounds, in the unit of the file."""
    if get_origin(field.annotation) is Literal:
        return ", ".join(f"`{word}`" for word in get_args(field.annotation))
    words = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}
    bounds = [(words[name], getattr(one, name)) for one in field.metadata for name in words if hasattr(one, name)]
    return ", ".join(f"{word} {unit_of(field).from_si(float(bound)):g}" for word, bound in bounds)


def commands() -> str:
    """Give the page of the commands, from their help."""
    text = application().generate_docs(output_format="markdown")
    body = text[text.index("\n## cycloid-mj ") :]
    # of `python -m sphinx`, under whose name the build runs, cyclopts drops the first word alone
    body = re.sub(r"^(cycloid-mj .*?)-m sphinx ", r"\1", body, flags=re.MULTILINE)
    return COMMANDS + "\n" + re.sub(r"\n{3,}", "\n\n", _shown(body))


def _shown(text: str) -> str:
    """Escape what a reader of Markdown would take for HTML and leave out, as ``<design>``, but in code."""
    in_code = re.compile(r"(```.*?```|`[^`\n]*`)", re.DOTALL)
    return "".join(part if k % 2 else part.replace("<", "&lt;") for k, part in enumerate(in_code.split(text)))


def python() -> str:
    """Give the page of the public names of the package, from their docstrings."""
    return PYTHON + "".join(_directives())


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
