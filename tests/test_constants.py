"""Every numeric constant of a module has a kind and a docstring; few are heuristics, and those are named as such."""

import ast
import re
import tomllib
from collections import defaultdict
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[1]
KINDS = ROOT / "tests" / "data" / "constants.toml"
MAX_STATEMENTS, MAX_HEURISTICS = 500, 120


def is_number(value: ast.expr | None) -> bool:
    """Return whether an expression is a number, a product with a number or a tuple of such."""
    match value:
        case ast.Constant(value=number):
            return isinstance(number, (int, float)) and not isinstance(number, bool)
        case ast.UnaryOp(operand=operand):
            return is_number(operand)
        case ast.BinOp(left=left, right=right):
            return is_number(left) or is_number(right)
        case ast.Tuple(elts=items):
            return bool(items) and all(map(is_number, items))
    return False


def description(source: str, statements: list[ast.stmt], index: int) -> str:
    """Return the comment on the line of a constant, and the docstring below its block of assignments."""
    lines = source.splitlines()
    text = lines[statements[index].end_lineno - 1].partition("#")[2]
    for before, after in zip(statements[index:], statements[index + 1 :], strict=False):
        if after.lineno > before.end_lineno + 1:
            break
        if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant):
            return text + after.value.value
    return text


def constants_of(path: Path) -> Iterator[tuple[str, int, str, str]]:
    """Yield the module, the line, the name and the description of each constant of a module."""
    source = path.read_text(encoding="utf-8")
    statements = ast.parse(source).body
    for index, statement in enumerate(statements):
        if not isinstance(statement, (ast.Assign, ast.AnnAssign)) or not is_number(statement.value):
            continue
        target = statement.targets[0] if isinstance(statement, ast.Assign) else statement.target
        text = description(source, statements, index)
        for name in target.elts if isinstance(target, ast.Tuple) else [target]:
            yield path.relative_to(ROOT).as_posix(), statement.lineno, ast.unparse(name), text


@cache
def constants() -> tuple[tuple[str, int, str, str], ...]:
    """Return the constants of all modules, see `constants_of`."""
    paths = [path for room in ("cycloid_mj", "papers", "scripts") for path in (ROOT / room).rglob("*.py")]
    return tuple(constant for path in sorted(paths) for constant in constants_of(path))


KIND_OF = {
    (module, name): kind
    for kind, modules in tomllib.loads(KINDS.read_text(encoding="utf-8")).items()
    for module, names in modules.items()
    for name in names
}


def test_every_constant_has_a_kind():
    named = {(module, name) for module, _, name, _ in constants()}
    assert sorted(named - KIND_OF.keys()) == [], f"state their kinds in {KINDS.relative_to(ROOT)}"
    assert sorted(KIND_OF.keys() - named) == [], f"remove them from {KINDS.relative_to(ROOT)}"
    assert set(KIND_OF.values()) == {"definition", "heuristic", "interface", "physical", "tolerance"}
    assert len(named) == len(constants()), "a module assigns a constant twice"
    assert len({(module, line) for module, line, _, _ in constants()}) < MAX_STATEMENTS


def test_every_constant_is_described():
    assert [(module, name) for module, _, name, text in constants() if not text.strip()] == []


def test_few_constants_are_heuristics_and_their_descriptions_say_so():
    heuristics = [(module, name, text) for module, _, name, text in constants() if KIND_OF[module, name] == "heuristic"]
    assert len(heuristics) < MAX_HEURISTICS
    assert [(module, name) for module, name, text in heuristics if not re.search("heuristic|assumed", text, re.I)] == []


def test_descriptions_with_the_word_heuristic_belong_to_heuristics():
    kinds = defaultdict(set)
    for module, _, name, text in constants():
        kinds[module, text].add(KIND_OF[module, name])  # constants of a block share their description
    assert [block for block, of in kinds.items() if "heuristic" in block[1] and "heuristic" not in of] == []
