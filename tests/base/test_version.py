"""The version stands in one module, and no other module imports the package's front."""

import ast
from pathlib import Path

import cycloid_mj
from cycloid_mj.base.version import __version__

PACKAGE = Path(cycloid_mj.__file__).parent


def test_the_version_is_defined_in_one_module() -> None:
    assert cycloid_mj.__version__ == __version__


def test_no_module_imports_a_name_from_the_front_of_the_package() -> None:
    """`from cycloid_mj import name` would lead from a lower layer through `cycloid_mj/__init__.py` to every layer."""
    importers = [
        f"{path.relative_to(PACKAGE)}:{node.lineno}"
        for path in sorted(PACKAGE.rglob("*.py"))
        if path != PACKAGE / "__init__.py"
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.ImportFrom) and node.module == "cycloid_mj"
    ]
    assert importers == []
