"""Keys that follow: what changes together with the keys that a sweep or an optimisation varies."""

import ast
import operator
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from cycloid_mj.base.array import significant
from cycloid_mj.base.errors import DesignError, UsageError
from cycloid_mj.design import Design, declared, override, value_of
from cycloid_mj.explore.points import Value
from cycloid_mj.reducer import Reducer

_EXAMPLE = "'output.hole_radius_mm=output.pin_radius_mm+gear.eccentricity_mm'"

_OPERATIONS: Mapping[type[ast.AST], Callable[..., float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
}


@dataclass(frozen=True)
class Rule:
    """How a key follows without a formula: in words, after which `leaders`, and by which design of start and point."""

    words: str
    leaders: frozenset[str]
    put: Callable[[Reducer, Reducer], Reducer]


def _hole(start: Reducer, reducer: Reducer) -> Reducer:
    design = reducer.design
    room = start.design.output.hole_radius - start.design.output.pin_radius - start.design.gear.eccentricity
    return reducer.but(output={"hole_radius": design.output.pin_radius + design.gear.eccentricity + room})


def _torque(start: Reducer, reducer: Reducer) -> Reducer:
    design = reducer.design
    return reducer.but(drive={"torque": design.drive.torque * start.design.rated_torque / design.rated_torque})


RULES: Mapping[str, Rule] = {
    "output.hole_radius_mm": Rule(
        "output pin and eccentricity, with the room that the start has",
        frozenset({"gear.eccentricity_mm", "output.pin_radius_mm"}),
        _hole,
    ),
    "drive.torque_nm": Rule(
        "the rated torque on the output stays", frozenset({"ring.teeth", "output.member"}), _torque
    ),
}
"""Keys that know how to follow."""


@dataclass(frozen=True)
class Follower:
    """A key that is set after others, in the words and units of the design file.

    Attributes
    ----------
    key
        Which.
    formula
        Sums, products and quotients of numbers and keys; empty: as its own rule in `RULES` has it.
    """

    key: str
    formula: str = ""

    @property
    def words(self) -> str:
        """How it follows."""
        return self.formula or RULES[self.key].words

    def at(self, start: Reducer, reducer: Reducer) -> Design:
        """Return a design with the key set; `start` is what all points change.

        Raises
        ------
        DesignError
            The formula gives no number there, or one that the key does not allow.
        """
        if not self.formula:
            return RULES[self.key].put(start, reducer).design
        try:
            value = significant(_value(_parsed(self.formula), reducer))
        except ArithmeticError as error:
            raise DesignError(f"{self.key} = {self.formula} has no value: {error}") from error
        whole = declared(self.key).annotation is int and value.is_integer()
        return override(reducer.design, {self.key: int(value) if whole else value})


def following(reducer: Reducer, requested: str | Sequence[str], varied: Iterable[str]) -> tuple[Follower, ...]:
    """Read which keys follow: ``KEY=FORMULA``, or ``KEY`` for one that knows how.

    Parameters
    ----------
    reducer
        What all points change.
    requested
        In the order in which they are set; a later one may be of an earlier one.
    varied
        Keys that the points have values of.

    Raises
    ------
    UsageError
        There is no such key, it varies itself or holds no number, or its formula is none.
    """
    followers: dict[str, Follower] = {}
    varied = set(varied)
    for text in (requested,) if isinstance(requested, str) else requested:
        key, equals, formula = (part.strip() for part in text.partition("="))
        option = f"--follow {text!r:.80}"
        if not key or (equals and not formula):
            raise UsageError(f"{option}: expected KEY=FORMULA, e.g. {_EXAMPLE}")
        if declared(key).annotation not in (int, float):
            raise UsageError(f"{option}: {key} holds no single number; only such keys can follow")
        if key in varied or key in followers:
            raise UsageError(f"{option}: {key} {'varies itself' if key in varied else 'is there twice'}; leave one out")
        if not formula and key not in RULES:
            raise UsageError(
                f"{option}: say how, --follow '{key}=FORMULA'; {' and '.join(RULES)} alone know it themselves"
            )
        if formula:
            _require_numbers(option, key, formula, reducer)
        followers[key] = Follower(key, formula)
    return tuple(followers.values())


def by_themselves(requested: Iterable[Follower], varied: Iterable[str]) -> tuple[Follower, ...]:
    """List the keys that follow in an optimisation unless they vary or follow otherwise: of a leader that varies."""
    varied = set(varied)
    taken = varied | {one.key for one in requested}
    return tuple(Follower(key) for key, rule in RULES.items() if rule.leaders & varied and key not in taken)


def followed(start: Reducer, reducer: Reducer, followers: Iterable[Follower]) -> Design:
    """Return the design of a point with all keys set that follow; raise DesignError where one cannot be."""
    for follower in followers:
        reducer = Reducer(follower.at(start, reducer))
    return reducer.design


def values_of(reducer: Reducer, followers: Iterable[Follower]) -> dict[str, Value]:
    """Collect what followers came to, key -> value in the file's unit."""
    values = {follower.key: value_of(reducer.design, follower.key) for follower in followers}
    return {key: value if isinstance(value, int) else significant(value) for key, value in values.items()}


def _parsed(formula: str) -> ast.expr:
    return ast.parse(formula, mode="eval").body


def _require_numbers(text: str, key: str, formula: str, reducer: Reducer) -> None:
    """Raise UsageError where a formula is not of numbers and of keys that hold one."""
    try:
        keys = list(_keys(_parsed(formula)))
    except (SyntaxError, ValueError) as error:
        raise UsageError(
            f"{text}: expected sums, products and quotients of numbers and keys, e.g. {_EXAMPLE}"
        ) from error
    if key in keys:
        raise UsageError(f"{text}: {key} cannot follow itself")
    for one in keys:
        value = value_of(reducer.design, one)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise UsageError(f"{text}: {one} holds no single number")


def _keys(node: ast.expr) -> Iterator[str]:
    """Yield the keys in a formula; raise ValueError where there is anything but keys, numbers and operations."""
    match node:
        case ast.Constant(value=int() | float()):
            return
        case ast.Name() | ast.Attribute():
            yield ast.unparse(node)
        case ast.UnaryOp() if type(node.op) in _OPERATIONS:
            yield from _keys(node.operand)
        case ast.BinOp() if type(node.op) in _OPERATIONS:
            yield from _keys(node.left)
            yield from _keys(node.right)
        case _:
            raise ValueError(ast.unparse(node))


def _value(node: ast.expr, reducer: Reducer) -> float:
    match node:
        case ast.Constant():
            return float(node.value)  # type: ignore[arg-type]  # of numbers alone, see `_keys`
        case ast.UnaryOp():
            return _OPERATIONS[type(node.op)](_value(node.operand, reducer))
        case ast.BinOp():
            return _OPERATIONS[type(node.op)](_value(node.left, reducer), _value(node.right, reducer))
    return float(value_of(reducer.design, ast.unparse(node)))
