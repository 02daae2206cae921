"""Command-line errors of cyclopts, restated in one line."""

from collections.abc import Sequence
from difflib import get_close_matches
from typing import Any, Literal, get_args, get_origin

from cyclopts import App, CycloptsError, Group
from cyclopts.exceptions import (
    CoercionError,
    MissingArgumentError,
    UnknownCommandError,
    UnknownOptionError,
    UnusedCliTokensError,
    ValidationError,
)

from cycloid_mj.base.text import match_case
from cycloid_mj.cli.contents import GROUPS
from cycloid_mj.cli.page import commands


def describe_error(error: CycloptsError) -> str:
    """Return one line that names the flag, its value and the allowed values."""
    command = " ".join(("cycloid-mj", *(error.command_chain or ())))
    message = " ".join(_describe_error(error).split()).rstrip(".")
    return f"{message}{' S' if message.endswith('?') else '; s'}ee {command} --help"


def correct_case(error: CoercionError, words: Sequence[str]) -> list[str] | None:
    """Correct a word of a command line that differs from an allowed value of its flag only in upper and lower case.

    `error` is that of cyclopts, `words` is the command line. Returns the corrected words, or None if the flag has no
    fixed values or none of them matches.
    """
    if error.token is None or error.argument is None:
        return None
    flag, wrong_value = error.token.keyword or "", error.token.value
    choice = match_case(wrong_value, _choices(error.argument.hint))
    corrected_words, current_flag = list(words), ""
    for index, word in enumerate(words):
        current_flag = word if word.startswith("--") else current_flag
        if word == f"{flag}={wrong_value}":
            corrected_words[index] = f"{flag}={choice}"
        elif word == wrong_value and current_flag == flag:
            corrected_words[index] = choice
    return corrected_words if corrected_words != words else None


def _choices(hint: Any) -> tuple[str, ...]:
    """Return the words of a type that is a Literal, optional, or a collection of one."""
    parts = get_args(hint)
    if get_origin(hint) is Literal:
        return tuple(part for part in parts if isinstance(part, str))
    return tuple(choice for part in parts for choice in _choices(part))


def _describe_error(error: CycloptsError) -> str:
    """Return the message on an error of cyclopts in the words of this command line, without markup.

    Errors of other types keep their own text.
    """
    argument = error.argument
    if isinstance(error, UnknownCommandError) and error.app is not None:
        return _unknown_command((error.unused_tokens or [""])[0], error.app)
    if isinstance(error, MissingArgumentError) and argument is not None:
        position_text = "" if argument.index is None or not argument.name.startswith("-") else argument.name[2:].upper()
        return _describe_missing(argument.name, error.unused_tokens or [], position_text)
    if isinstance(error, UnknownOptionError):
        word = error.token.keyword or error.token.value
        flags = [
            name for flag_argument in error.argument_collection for name in flag_argument.names if name.startswith("--")
        ]
        # without the dashes, which all of them share
        similar_flags = get_close_matches(word.lstrip("-"), [name[2:] for name in flags], n=1)
        return _unknown_option(word, [f"--{name}" for name in similar_flags])
    if isinstance(error, UnusedCliTokensError):
        return f"unexpected argument {(error.unused_tokens or [''])[0]!r}"
    if isinstance(error, ValidationError) and argument is not None:
        return f"{argument.name} {argument.tokens[0].value}: {error.exception_message}"
    if isinstance(error, CoercionError) and error.target_type in (int, float) and error.token is not None:
        kind = "number" if error.target_type is float else "whole number"
        return f"{error.token.keyword} {error.token.value!r} is not a {kind}"
    return str(error)


def _find_in_groups(word: str) -> list[str]:
    """Return the full names of commands within groups that are called `word`: `design check` for `check`."""
    matches = []
    for name, command in ((name, command) for group in GROUPS.values() for name, command in group.items()):
        if command.function.endswith(":commands"):
            app = App()
            command.add_to(app, name, Group(name), 0)
            matches += [f"{name} {word}"] * (word in commands(app[name]))
    return matches


def _describe_missing(flag: str, unused: Sequence[str], position: str) -> str:
    """Return a message on a missing value, or on the misspelt flag that may be its cause."""
    misspelt = get_close_matches(flag, [word.split("=")[0] for word in unused if word.startswith("--")], n=1)
    if misspelt and misspelt[0] != flag:
        return _unknown_option(misspelt[0], [flag])
    return f"{position} or {flag} needs a value" if position else f"{flag} needs a value"


def _unknown_option(word: str, suggestions: Sequence[str]) -> str:
    return f"unknown option {word}; did you mean {suggestions[0]}?" if suggestions else f"unknown option {word}"


def _unknown_command(word: str, app: App) -> str:
    """Return a message on the unknown command `word`, with similar commands or, if there are none, all commands.

    `app` has all commands.
    """
    names = commands(app)
    if word.startswith("-"):
        return f"unknown option {word}; options come after a command"
    candidates = [name for name in names if name.startswith(word)] or _find_in_groups(word)
    suggestions = candidates or get_close_matches(word, names, n=1)
    if suggestions:
        return f"unknown command {word!r}; did you mean {' or '.join(suggestions)}?"
    return f"unknown command {word!r}; the commands are {', '.join(names)}"
