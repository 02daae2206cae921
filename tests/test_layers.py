"""The import graph: no circle and no arrow upward, imports inside of functions and names in strings included."""

import ast
import re
import tomllib
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

from grimp import build_graph

import cycloid_mj

PACKAGE = Path(cycloid_mj.__file__).parent
CONTRACTS = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text())["tool"]["importlinter"][
    "contracts"
]
LAYERS = [
    [name.strip().removeprefix("cycloid_mj.") for name in layer.split("|")]
    for layer in next(one for one in CONTRACTS if one["name"].startswith("layers: "))["layers"]
]
"""Packages of each layer, the highest first."""

LEVEL = {package: len(LAYERS) - place for place, layer in enumerate(LAYERS) for package in layer}


def module_name(path: Path) -> str:
    parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


@cache
def trees() -> dict[str, ast.Module]:
    """Parse all modules of the package."""
    return {module_name(path): ast.parse(path.read_text(encoding="utf-8")) for path in PACKAGE.rglob("*.py")}


def docstrings(tree: ast.Module) -> set[ast.AST]:
    return {
        node.value for node in ast.walk(tree) if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    }


def named(name: str) -> Iterator[str]:
    """Yield the modules of the package that a module names in strings, by which it could import them."""
    tree = trees()[name]
    skipped = docstrings(tree)
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node not in skipped:
            yield from re.findall(r"\bcycloid_mj(?:\.\w+)+", node.value)


def package_of(module: str) -> str:
    return module.split(".")[1] if module.count(".") else ""


@cache
def import_graph() -> dict[str, set[str]]:
    """Map each module to those that it imports."""
    imports = build_graph("cycloid_mj", exclude_type_checking_imports=True)
    return {name: set(imports.find_modules_directly_imported_by(name)) for name in imports.modules}


def test_no_modules_import_each_other_in_a_circle() -> None:
    try:
        tuple(TopologicalSorter(import_graph()).static_order())
    except CycleError as error:
        raise AssertionError(" -> ".join(error.args[1])) from None


def test_no_module_imports_or_names_a_layer_above_its_own() -> None:
    """A string that names an upper layer is an import in disguise: upper layers register what they provide."""
    upward = {
        f"{name} -> {other}"
        for name in trees()
        for other in (*import_graph()[name], *named(name))
        if package_of(name) in LEVEL and LEVEL.get(package_of(other), 0) > LEVEL[package_of(name)]
    }
    assert upward == set()


def test_layers_cover_every_package() -> None:
    packages = {path.name for path in PACKAGE.iterdir() if (path / "__init__.py").exists()}
    assert packages == set(LEVEL) - {"hsieh2014", "upper_figures"}
