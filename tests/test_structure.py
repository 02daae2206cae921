"""How the code is put together: no circles, no private names across modules, no decision by a sentence, rooms named."""

import ast
import re
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import grimp
import pytest

ROOT = Path(__file__).parents[1]
SOURCES = sorted(path for room in ("cycloid_mj", "papers", "scripts") for path in (ROOT / room).rglob("*.py"))

PUBLIC_DESPITE_THE_UNDERSCORE = {
    # NamedTuple's own methods, which have it so that they cannot clash with a field
    *("_fields", "_replace", "_asdict"),
    # MuJoCo's bindings: the address of a structure
    "_address",
    # of os: how a forked process ends
    "_exit",
}
JUDGED_BY_WORDS = {
    # a file of the Linux kernel, whose lines have no other key
    ("scripts/benchmark.py", "model name"),
}
METHODS_OF_TEXT = (
    "startswith",
    "endswith",
    "find",
    "index",
    "count",
    "removeprefix",
    "removesuffix",
    "match",
    "search",
)


Nodes = tuple[ast.AST, ...]


def nodes_of(source: str) -> Nodes:
    """All of a module's nodes, itself first."""
    return tuple(ast.walk(ast.parse(source)))


@cache
def nodes(path: Path) -> Nodes:
    return nodes_of(path.read_text(encoding="utf-8"))


def is_private(name: str) -> bool:
    return name.startswith("_") and not name.startswith("__") and name not in PUBLIC_DESPITE_THE_UNDERSCORE


def own_names(module: Nodes) -> set[str]:
    """Every name that a module makes itself: functions, classes, variables, attributes and fields."""
    made = set()
    for node in module:
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
            made.add(node.name)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            made.add(node.id)
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            made.add(node.attr)
    return made


def inherited(node: ast.Attribute) -> bool:
    """Tell whether a name is asked of `self` or of the class above: what a class inherits is its own."""
    return ast.unparse(node.value) in ("self", "super()")


def private_names_of_others(module: Nodes) -> Iterator[str]:
    own = own_names(module)
    for node in module:
        if isinstance(node, ast.ImportFrom):
            yield from (f"{node.lineno}: {name.name}" for name in node.names if is_private(name.name))
        elif isinstance(node, ast.Attribute) and is_private(node.attr) and node.attr not in own and not inherited(node):
            yield f"{node.lineno}: {ast.unparse(node)}"


def is_sentence(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, str) and " " in node.value.strip()


def decisions_by_words(module: Nodes) -> Iterator[tuple[int, str]]:
    """Yield line and words of each comparison, search or case that looks for several words in a text."""
    for node in module:
        asked: list[ast.AST] = []
        if isinstance(node, ast.Compare):
            asked = [part for side in (node.left, *node.comparators) for part in ast.walk(side)]
        elif isinstance(node, ast.MatchValue):
            asked = [node.value]
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in METHODS_OF_TEXT:
            asked = [part for argument in node.args for part in ast.walk(argument)]
        yield from ((part.lineno, part.value) for part in asked if is_sentence(part))


def literals() -> set[str]:
    """Words of every ``Literal[...]``: they are keys, since mypy knows all of them and finds one that is reworded."""
    return {
        part.value
        for path in SOURCES
        for node in nodes(path)
        if isinstance(node, ast.Subscript) and ast.unparse(node.value) == "Literal"
        for part in ast.walk(node.slice)
        if isinstance(part, ast.Constant)
    }


def test_modules_keep_their_private_names() -> None:
    found = {str(path.relative_to(ROOT)): list(private_names_of_others(nodes(path))) for path in SOURCES}
    assert {place: names for place, names in found.items() if names} == {}


def test_modules_decide_by_keys() -> None:
    keys = literals()
    found = {
        (path.relative_to(ROOT).as_posix(), words)
        for path in SOURCES
        for _, words in decisions_by_words(nodes(path))
        if words not in keys
    }
    assert found == JUDGED_BY_WORDS


@pytest.mark.parametrize("line", ["from a import _b", "import a\na._b()", "c = d._b"])
def test_a_private_name_of_another_module_is_found(line: str) -> None:
    assert list(private_names_of_others(nodes_of(line)))
    assert not list(private_names_of_others(nodes_of(f"def _b(): ...\n{line.split(chr(10))[-1]}"))) or "from" in line


@pytest.mark.parametrize(
    "line",
    [
        'if "too long" in message: ...',
        'if title == "of the shaft": ...',
        'if note.startswith("no load"): ...',
        'match title:\n    case "no load": ...',
        'if verdict in ("holds", "not judged"): ...',
    ],
)
def test_a_decision_by_words_is_found(line: str) -> None:
    assert list(decisions_by_words(nodes_of(line)))
    assert not list(decisions_by_words(nodes_of(line.replace(" l", "_l").replace("of the ", "").replace("t j", "t_j"))))


def imports() -> dict[str, set[str]]:
    graph = grimp.build_graph("cycloid_mj", exclude_type_checking_imports=True)
    return {module: set(graph.find_modules_directly_imported_by(module)) for module in graph.modules}


def test_no_module_imports_itself_indirectly() -> None:
    graph = imports()
    TopologicalSorter(graph).prepare()
    above = next(module for module, below in graph.items() if "cycloid_mj.base.errors" in below)
    graph["cycloid_mj.base.errors"].add(above)
    with pytest.raises(CycleError):
        TopologicalSorter(graph).prepare()


ROOMS = sorted((ROOT / "cycloid_mj").rglob("__init__.py")) + sorted((ROOT / "cycloid_mj").glob("[a-z]*.py"))


def test_each_package_states_its_content_in_a_sentence() -> None:
    said = {}
    for path in ROOMS:
        sentence = (ast.get_docstring(nodes(path)[0]) or "").split("\n\n")[0].split("\n")[0]
        assert re.fullmatch(r"[A-Z`].{25,}\.", sentence), f"{path.relative_to(ROOT)}: {sentence!r}"
        said[path] = sentence
    assert len(set(said.values())) == len(ROOMS)


def documented_parameters(docstring: str) -> list[str]:
    """Names in the section Parameters of a docstring."""
    _, _, rest = docstring.partition("Parameters\n----------\n")
    section = re.split(r"\n\n(?=\S)", rest)[0]
    return [name for line in section.splitlines() if line[:1].strip() for name in re.findall(r"\w+", line)]


def unknown_parameters(module: Nodes) -> Iterator[str]:
    """Parameters that a docstring describes and its function has not."""
    for node in module:
        if isinstance(node, ast.FunctionDef):
            taken = {each.arg for each in ast.walk(node.args) if isinstance(each, ast.arg)}
            for name in documented_parameters(ast.get_docstring(node) or ""):
                if name not in taken:
                    yield f"{node.lineno}: {node.name} has no {name}"


def test_docstrings_describe_parameters_that_are_there() -> None:
    assert {str(path): unknown for path in SOURCES if (unknown := list(unknown_parameters(nodes(path))))} == {}
    spoiled = 'def f(a):\n    """Do.\n\n    Parameters\n    ----------\n    a, b\n        Two.\n    """\n'
    assert list(unknown_parameters(nodes_of(spoiled))) == ["1: f has no b"]
