"""The example notebook, generated from its script in the gallery, without stored outputs."""

import ast
import json
import re
from pathlib import Path
from typing import Any

EXAMPLES = Path(__file__).parent.parent / "examples"
SCRIPT, NOTEBOOK = EXAMPLES / "plot_14_notebook.py", EXAMPLES / "notebook.ipynb"

METADATA = {
    "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
    "language_info": {"name": "python"},
}


def write() -> None:
    """Write the notebook if it differs."""
    text = notebook_text(SCRIPT.read_text(encoding="utf-8"))
    if not NOTEBOOK.exists() or NOTEBOOK.read_text(encoding="utf-8") != text:
        NOTEBOOK.write_text(text, encoding="utf-8", newline="\n")


def notebook_text(script: str) -> str:
    """Return the notebook of a script: its docstring and the comment after each ``# %%`` are text, the rest is code."""
    first, *others = re.split(r"^# %%\n", script, flags=re.MULTILINE)
    docstring = ast.get_docstring(ast.parse(first)) or ""
    title, text = re.match(r"(.+)\n=+\n\n(.*)", docstring, re.DOTALL).groups()
    code = re.sub(r"^# sphinx_gallery_.*\n", "", first.rpartition('"""\n')[2], flags=re.MULTILINE)
    cells = [_cell("markdown", f"# {title}\n\n{_markdown(text)}"), _cell("code", code)]
    for block in others:
        comment = re.match(r"(?:#.*\n)*", block)[0]
        cells.append(_cell("markdown", _markdown(re.sub(r"^# ?", "", comment, flags=re.MULTILINE))))
        cells.append(_cell("code", block[len(comment) :]))
    for number, cell in enumerate(cells):
        cell["id"] = f"cell-{number}"
    content = {"cells": cells, "metadata": METADATA, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


def _cell(kind: str, source: str) -> dict[str, Any]:
    """Return a cell; the lines of its source keep their ends, as the format requires."""
    cell: dict[str, Any] = {"cell_type": kind, "id": "", "metadata": {}, "source": source.strip().splitlines(True)}
    return cell | ({"execution_count": None, "outputs": []} if kind == "code" else {})


def _markdown(text: str) -> str:
    """Return reStructuredText of the script as Markdown: literals have one backtick."""
    return text.replace("``", "`")


if __name__ == "__main__":
    write()
