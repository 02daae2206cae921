"""Linked keys: values of the design file that change together with those that a sweep or an optimisation varies."""

import ast
import operator
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from cycloid_mj.base.array import significant
from cycloid_mj.base.errors import DesignError, UsageError
from cycloid_mj.design import Design, declaration_of, override, value_of
from cycloid_mj.design.layouts import BOTH, CENTRAL, Layout
from cycloid_mj.explore.points import Value
from cycloid_mj.reducer import Reducer, reducer_of

_EXAMPLE = "'output.hole_radius_mm=output.pin_radius_mm+gear.eccentricity_mm'"

_OPERATIONS: Mapping[type[ast.AST], Callable[..., float]] = {
    **{ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv},
    **{ast.USub: operator.neg, ast.UAdd: operator.pos},
}


@dataclass(frozen=True)
class LinkRule:
    """Rule by which a key follows without a formula."""

    words: str
    """The rule in words."""
    leaders: frozenset[str]
    """Keys that it follows."""
    apply: Callable[[Reducer, Reducer], Reducer]
    """Sets the key: from the drive at the start and that at the point to the latter with the key set."""
    layouts: tuple[Layout, ...] = BOTH
    """Layouts that have the key."""


def _set_hole_radius(nominal: Reducer, reducer: Reducer) -> Reducer:
    design = reducer.design
    clearance = nominal.design.output.hole_radius - nominal.design.output.pin_radius - nominal.design.gear.eccentricity
    return reducer.but(output={"hole_radius": design.output.pin_radius + design.gear.eccentricity + clearance})


def _set_torque(nominal: Reducer, reducer: Reducer) -> Reducer:
    design = reducer.design
    return reducer.but(drive={"torque": design.drive.torque * nominal.design.rated_torque / design.rated_torque})


_HOLE, _RATED = (
    "output pin radius plus eccentricity plus the clearance of the start",
    "the nominal torque on the output",
)
_OF_HOLE = {"gear.eccentricity_mm", "output.pin_radius_mm"}
_OF_RATIO = {"ring.teeth", "output.member", "planet.sun_teeth", "planet.planet_teeth"}
RULES: Mapping[str, LinkRule] = {
    "output.hole_radius_mm": LinkRule(_HOLE, frozenset(_OF_HOLE), _set_hole_radius, CENTRAL),
    "drive.torque_nm": LinkRule(f"keeps {_RATED}", frozenset(_OF_RATIO), _set_torque),
}
"""Keys that have a rule of their own."""


@dataclass(frozen=True)
class Link:
    """A key that follows others, in the words and units of the design file."""

    key: str
    """The key that is set."""
    formula: str = ""
    """Sums, differences, products and quotients of numbers and keys; empty for the key's rule in `RULES`."""

    @property
    def words(self) -> str:
        """The formula, or the rule in words."""
        return self.formula or RULES[self.key].words

    def apply(self, nominal: Reducer, reducer: Reducer) -> Design:
        """Set a key of the design that follows other keys, by its formula or rule, and return the new design.

        `nominal` is the drive from which a sweep or optimisation starts, `reducer` that at one of its points, with
        varied keys.

        Raises
        ------
        DesignError
            The formula has no value there, or a value that the key does not allow.
        """
        if not self.formula:
            return RULES[self.key].apply(nominal, reducer).design
        try:
            value = significant(_evaluate(_parse(self.formula), reducer))
        except ArithmeticError as error:
            raise DesignError(
                f"--follow: {self.key} = {self.formula} cannot be computed ({error}). Change the formula, or the "
                "ranges of the keys in it"
            ) from error
        is_integer = declaration_of(self.key).annotation is int and value.is_integer()
        return override(reducer.design, {self.key: int(value) if is_integer else value})


def parse_links(reducer: Reducer, requested: str | Sequence[str], varied_keys: Iterable[str]) -> tuple[Link, ...]:
    """Parse the keys that are computed from others: ``KEY=FORMULA``, or ``KEY`` for a key with a rule in `RULES`.

    Parameters
    ----------
    reducer
        The drive from which the sweep or optimisation starts.
    requested
        Texts in the order in which the keys are set; a later formula may use an earlier key.
    varied_keys
        Keys whose values differ from point to point; they cannot be linked as well.

    Raises
    ------
    UsageError
        There is no such key, it is varied itself or is not a number, or its formula is not valid.
    """
    links: dict[str, Link] = {}
    varied_keys = set(varied_keys)
    for text in (requested,) if isinstance(requested, str) else requested:
        key, separator, formula = (part.strip() for part in text.partition("="))
        option_text = f"--follow {text!r:.80}"
        if not key or (separator and not formula):
            raise UsageError(f"{option_text} is not a formula: give KEY=FORMULA, e.g. {_EXAMPLE}")
        if declaration_of(key).annotation not in (int, float):
            raise UsageError(
                f"{option_text}: the value of {key} is not a number, so a formula cannot set it. Choose a key that "
                "has a single numeric value"
            )
        if key in varied_keys or key in links:
            other_option = "--vary" if key in varied_keys else "another --follow"
            raise UsageError(f"{option_text}: {key} is already set by {other_option}. Remove one of the two flags")
        if not formula and key not in RULES:
            raise UsageError(
                f"{option_text}: the formula is missing; only {' and '.join(RULES)} have a built-in rule and need no "
                f"formula. Give --follow '{key}=FORMULA'"
            )
        if formula:
            _require_numbers(option_text, key, formula, reducer)
        links[key] = Link(key, formula)
    return tuple(links.values())


def default_links(reducer: Reducer, requested: Iterable[Link], varied_keys: Iterable[str]) -> tuple[Link, ...]:
    """Return the links (keys that follow other keys) that an optimisation adds beyond those that are `requested`.

    A rule of `RULES`, such as the radius of the holes that follows from that of the output pins, applies if the layout
    of the reducer has its key, one of the keys in it (`LinkRule.leaders`) is varied, and the key that it sets is
    neither varied nor linked by `requested`.
    """
    varied_keys = set(varied_keys)
    excluded_keys = varied_keys | {link.key for link in requested}
    return tuple(
        Link(key)
        for key, rule in RULES.items()
        if reducer.LAYOUT in rule.layouts and rule.leaders & varied_keys and key not in excluded_keys
    )


def apply_links(nominal: Reducer, reducer: Reducer, links: Iterable[Link]) -> Design:
    """Set all keys of a design that follow other keys by their formulas, in order, and return the new design.

    `links` are the keys with their formulas. `nominal` is the drive from which a sweep or optimisation starts,
    `reducer` that at one of its points, with varied keys.

    Raises
    ------
    DesignError
        A formula has no value, or a value that its key does not allow.
    """
    for link in links:
        reducer = reducer_of(link.apply(nominal, reducer))
    return reducer.design


def linked_values(reducer: Reducer, links: Iterable[Link]) -> dict[str, Value]:
    """Collect the values of the linked keys in a design, in the file's units."""
    values = {link.key: value_of(reducer.design, link.key) for link in links}
    return {key: value if isinstance(value, int) else significant(value) for key, value in values.items()}


def _parse(formula: str) -> ast.expr:
    return ast.parse(formula, mode="eval").body


def _require_numbers(option: str, key: str, formula: str, reducer: Reducer) -> None:
    """Raise UsageError unless a formula consists of numbers, operators and other numeric keys of the design file.

    `key` is the key that the formula sets, `option` the user's text for the message.
    """
    try:
        keys = list(_keys_in_formula(_parse(formula)))
    except (SyntaxError, ValueError) as error:
        raise UsageError(
            f"{option}: the formula may contain only numbers, keys, + - * / and parentheses. Correct it, e.g. "
            f"{_EXAMPLE}"
        ) from error
    if key in keys:
        raise UsageError(f"{option}: the formula for {key} contains {key} itself. Use only other keys in it")
    for used_key in keys:
        value = value_of(reducer.design, used_key)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise UsageError(
                f"{option}: the value of {used_key} is not a number, so it cannot be used in a formula. Use only keys "
                "that have a single numeric value"
            )


def _keys_in_formula(node: ast.expr) -> Iterator[str]:
    """Yield the keys in a parsed formula, the expression `node`.

    Raises ValueError if it does not consist of keys, numbers and + - * / only.
    """
    match node:
        case ast.Constant(value=int() | float()):
            return
        case ast.Name() | ast.Attribute():
            yield ast.unparse(node)
        case ast.UnaryOp() if type(node.op) in _OPERATIONS:
            yield from _keys_in_formula(node.operand)
        case ast.BinOp() if type(node.op) in _OPERATIONS:
            yield from _keys_in_formula(node.left)
            yield from _keys_in_formula(node.right)
        case _:
            raise ValueError(ast.unparse(node))


def _evaluate(node: ast.expr, reducer: Reducer) -> float:
    """Compute the value of a parsed formula of numbers and keys of the design file, in the units of the file.

    `node` is the expression, `reducer` has the values of the keys.
    """
    match node:
        case ast.Constant():
            return float(node.value)  # type: ignore[arg-type]  # a number, see `_keys_in_formula`
        case ast.UnaryOp():
            return _OPERATIONS[type(node.op)](_evaluate(node.operand, reducer))
        case ast.BinOp():
            return _OPERATIONS[type(node.op)](_evaluate(node.left, reducer), _evaluate(node.right, reducer))
    return float(value_of(reducer.design, ast.unparse(node)))
