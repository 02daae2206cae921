"""Count what the architecture is judged by, from the sources and from one data sheet.

python scripts/counts.py         # the counts, each with its bound
python scripts/counts.py --where # and the places behind each count

CONTRIBUTING.md states them; a test holds that table against this script.
"""

import argparse
import ast
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from cycloid_mj.reducer import Reducer

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("cycloid_mj", "papers/hsieh2014")

Function = ast.FunctionDef | ast.AsyncFunctionDef

TURNING_RING = frozenset({"turns_ring", "ring_turns", "seen_from_ring", "columns_from_ring"})
"""Names whose use shows that the output is the ring; the module that defines them does not count.

So does a comparison of ``turning``, the body that the load is on, with the name of a body. Angles of ring, carrier and
gear, and the carrier's `share` in the torque, are the same functions of either member and do not count.
"""

RING_MODULE = "cycloid_mj/reducer/member.py"
RV_MODULES = ("cycloid_mj/geometry/rv.py", "cycloid_mj/reducer/rv.py", "cycloid_mj/reducer/rv_member.py")
"""Modules that convert for a turning ring of RV reducers."""

DRAWERS = {
    "share": RING_MODULE,
    "phases": "reducer/bodies.py",
    "tooth_profile": "cycloid_mj/geometry/modification.py",
}
"""Functions that one data sheet should not have to call over and over, with the end of their module's path."""


@dataclass(frozen=True)
class Count:
    """A count: what is counted, its `bound`, and the `places` that make it up."""

    name: str
    bound: int
    places: tuple[str, ...]

    @property
    def value(self) -> int:
        """Number of places."""
        return len(self.places)


@dataclass(frozen=True)
class Module:
    """A parsed module with its path from the root of the repository."""

    path: str
    tree: ast.Module

    def functions(self) -> Iterator[Function]:
        """Iterate over all functions and methods, including nested functions."""
        return (node for node in ast.walk(self.tree) if isinstance(node, Function))

    def place(self, node: ast.stmt | ast.expr) -> str:
        """Name a line of the module."""
        return f"{self.path}:{node.lineno}"


def modules() -> list[Module]:
    """Parse every module of the product."""
    paths = sorted(path for package in PACKAGES for path in (ROOT / package).rglob("*.py"))
    return [Module(path.relative_to(ROOT).as_posix(), ast.parse(path.read_text("utf-8"))) for path in paths]


def takes_design(function: Function) -> bool:
    """Return whether a parameter of a function is annotated with Design, alone or as a part of its type."""
    arguments = function.args
    parameters = [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs]
    return any(
        isinstance(part, ast.Name) and part.id == "Design"
        for parameter in parameters
        if parameter.annotation
        for part in ast.walk(parameter.annotation)
    )


def is_cached(function: Function) -> bool:
    """Return whether a function is decorated with one of functools' caches."""
    plain = (one.func if isinstance(one, ast.Call) else one for one in function.decorator_list)
    return any(ast.unparse(one).rpartition(".")[2] in ("cache", "lru_cache") for one in plain)


def taking_design(parsed: Iterable[Module]) -> tuple[str, ...]:
    """List the functions that take a Design, and no name of one in its place."""
    return tuple(f"{one.place(each)} {each.name}" for one in parsed for each in one.functions() if takes_design(each))


def cached_by_design(parsed: Iterable[Module]) -> tuple[str, ...]:
    """List the caches keyed by a Design."""
    return tuple(
        f"{one.place(each)} {each.name}"
        for one in parsed
        for each in one.functions()
        if takes_design(each) and is_cached(each)
    )


def ring_conversions(parsed: Iterable[Module]) -> tuple[str, ...]:
    """List the lines that decide by whether the ring is the output, outside of the modules meant for it."""
    places: dict[str, None] = {}
    for one in parsed:
        if one.path in (RING_MODULE, *RV_MODULES):
            continue
        for node in ast.walk(one.tree):
            name = node.attr if isinstance(node, ast.Attribute) else node.id if isinstance(node, ast.Name) else ""
            if isinstance(node, ast.expr) and (name in TURNING_RING or _compares_member(node)):
                places[one.place(node)] = None
    return tuple(places)


def _compares_member(node: ast.AST) -> bool:
    """Return whether a node compares the body that the load is on with one of a certain name."""
    if not isinstance(node, ast.Compare) or not isinstance(node.ops[0], ast.Eq | ast.NotEq):
        return False
    return any(isinstance(side, ast.Attribute) and side.attr == "turning" for side in (node.left, *node.comparators))


def list_homonyms(parsed: Iterable[Module]) -> tuple[str, ...]:
    """List the names that classes of several modules have in common."""
    defined: dict[str, list[str]] = {}
    for one in parsed:
        for node in ast.walk(one.tree):
            if isinstance(node, ast.ClassDef):
                defined.setdefault(node.name, []).append(one.place(node))
    return tuple(f"{name}: {', '.join(places)}" for name, places in sorted(defined.items()) if len(places) > 1)


def list_drawer_calls() -> tuple[str, ...]:
    """List every call of a function in `DRAWERS` during one data sheet of the preset twodisc."""
    from cycloid_mj.design import PRESETS
    from cycloid_mj.life.datasheet import datasheet

    calls: list[str] = []

    def watch(frame: object, event: str, _: object) -> None:
        code = getattr(frame, "f_code", None)
        if event == "call" and code is not None and code.co_filename.endswith(DRAWERS.get(code.co_name, "\0")):
            calls.append(code.co_name)

    sys.setprofile(watch)
    try:
        datasheet(Reducer(PRESETS["twodisc"]))
    finally:
        sys.setprofile(None)
    return tuple(calls)


def count_sources() -> list[Count]:
    """Count properties of the sources: parameters, caches, conversions and names, with the lines behind each count."""
    of = modules()
    return [
        Count("functions that take a Design alone, not its name", 250, taking_design(of)),
        Count("caches keyed by a Design", 3, cached_by_design(of)),
        Count("lines that convert for a turning ring", 10, ring_conversions(of)),
        Count("class names with several meanings", 10, list_homonyms(of)),
    ]


def counts() -> list[Count]:
    """Count everything."""
    sheet = Count("calls of share, phases, tooth_profile in one data sheet of twodisc", 50, list_drawer_calls())
    return [*count_sources(), sheet]


def table(counted: Iterable[Count]) -> str:
    """Write counts as the table of CONTRIBUTING.md."""
    rows = [f"| {one.name} | {one.value} | under {one.bound} |" for one in counted]
    return "\n".join(["| count | now | aim |", "|---|---|---|", *rows])


def main() -> None:
    """Print the counts, and with --where the lines behind each."""
    parser = argparse.ArgumentParser(description=str(__doc__).split("\n\n")[0])
    parser.add_argument("--where", action="store_true", help="list the places behind each count")
    listed = parser.parse_args().where
    of = counts()
    print(table(of))
    for one in of if listed else ():
        print(f"\n{one.name}: {one.value}", *one.places, sep="\n  ")


if __name__ == "__main__":
    main()
