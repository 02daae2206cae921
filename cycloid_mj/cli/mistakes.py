"""What cyclopts finds wrong with a command line, told in one line."""

from cyclopts import CycloptsError
from cyclopts.exceptions import CoercionError, MissingArgumentError, UnusedCliTokensError, ValidationError


def sentence(error: CycloptsError) -> str:
    """Give one line that names the flag, what was got and what is allowed."""
    command = " ".join(("cycloid-mj", *(error.command_chain or ())))
    what = " ".join(_what(error).split()).rstrip(".")
    return f"{what}{' S' if what.endswith('?') else '; s'}ee {command} --help"


def _what(error: CycloptsError) -> str:
    argument = error.argument
    if isinstance(error, MissingArgumentError) and argument is not None:
        return f"{argument.name} needs a value"
    if isinstance(error, UnusedCliTokensError):
        return f"unexpected argument {(error.unused_tokens or [''])[0]!r}"
    if isinstance(error, ValidationError) and argument is not None:
        return f"{argument.name} {argument.tokens[0].value}: {error.exception_message}"
    if isinstance(error, CoercionError) and error.target_type in (int, float) and error.token is not None:
        kind = "number" if error.target_type is float else "whole number"
        return f"{error.token.keyword} {error.token.value!r} is not a {kind}"
    return str(error)
