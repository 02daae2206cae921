"""How the documentation is built, `python -m sphinx -W docs docs/_build`: offline; no page loads from outside.

The references of the design file, the commands and the Python functions are written from the code, into ``_reference``.
"""

import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "scripts")]

import charts  # noqa: E402  (in this folder)
import drawings  # noqa: E402
import notebook  # noqa: E402
import reference  # noqa: E402
import sketches  # noqa: E402
from docutils import nodes  # noqa: E402
from latex2mathml.converter import convert  # noqa: E402
from pydantic import BaseModel  # noqa: E402
from sphinx_gallery.scrapers import figure_rst  # noqa: E402

import cycloid_mj  # noqa: E402
from cycloid_mj.plots.style import NotebookFigure  # noqa: E402

project = "cycloid_mj"
author = "the cycloid_mj developers"
project_copyright = "the cycloid_mj developers, Apache-2.0"
version = release = cycloid_mj.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = ["_build", "_gallery/GALLERY_HEADER.rst", "**/sg_execution_times.rst", "sg_execution_times.rst"]
suppress_warnings = ["config.cache"]  # the sorting of the gallery is an object, which cannot be kept
myst_enable_extensions = ["dollarmath", "attrs_block"]
myst_heading_anchors = 3
smartquotes_action = "qe"  # quotes and dots, no dashes: `--json` stays two hyphens
autodoc_typehints = "none"
autodoc_preserve_defaults = True
napoleon_google_docstring = False
napoleon_use_ivar = True

html_math_renderer = "mathml"
html_theme = "furo"
html_title = f"cycloid_mj {version}"
html_favicon = "../cycloid_mj/app/assets/gear.svg"
html_static_path = ["_static"]
html_css_files = ["pages.css"]
html_show_sphinx = False
pygments_style, pygments_dark_style = "friendly", "monokai"


def by_number(name: str) -> int:
    """Order the examples as they are numbered: the tenth does not come after the first."""
    return int(name.split("_")[1])


def figure_of_a_cell(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Save the figure that a cell shows as its last value, as a notebook does without pyplot."""
    shown = block_vars["example_globals"].get("___")
    if not isinstance(shown, NotebookFigure):
        return ""
    path = next(block_vars["image_path_iterator"])
    Path(path).write_bytes(shown._repr_png_()[0])
    return figure_rst([path], gallery_conf["src_dir"])


sphinx_gallery_conf = {
    "image_scrapers": ("matplotlib", figure_of_a_cell),
    "examples_dirs": "../examples",
    "gallery_dirs": "_gallery",
    "filename_pattern": "/",
    "abort_on_example_error": True,
    "download_all_examples": False,
    "remove_config_comments": True,
    "show_memory": False,
    "show_signature": False,
    "matplotlib_animations": False,
    "reset_modules": ("matplotlib",),
    "capture_repr": (),
    "within_subsection_order": by_number,
    "min_reported_time": 5,
}


def without_defaults(app: Any, what: str, name: str, value: Any, *rest: Any) -> tuple[str, None] | None:
    """Leave out the signatures of parts of a design: their values are in the reference of the design file."""
    return ("", None) if isinstance(value, type) and issubclass(value, BaseModel) else None


def write_inline_mathml(translator: Any, node: Any) -> None:
    """Write an equation as MathML, which browsers show without scripts and without a network."""
    translator.body.append(convert(node.astext()))
    raise nodes.SkipNode


def write_display_mathml(translator: Any, node: Any) -> None:
    """Write a displayed equation as MathML; latex2mathml knows ``align*`` instead of ``gathered``."""
    equation = convert(node.astext().replace("{gathered}", "{align*}"), display="block")
    centred = equation.replace(' columnalign="right"', "")
    translator.body.append(f'<div class="equation">{centred}</div>')
    raise nodes.SkipNode


def setup(app: Any) -> None:
    """Write the references, the drawings and the notebook before the pages are read."""
    app.add_html_math_renderer("mathml", (write_inline_mathml, None), (write_display_mathml, None))
    app.connect("autodoc-process-signature", without_defaults)
    app.connect("builder-inited", lambda app: reference.write(HERE / "_reference"), priority=100)
    app.connect("builder-inited", lambda app: notebook.write(), priority=100)
    for module in (drawings, sketches, charts):
        app.connect("builder-inited", lambda app, module=module: module.write(HERE / "_drawings"), priority=100)
