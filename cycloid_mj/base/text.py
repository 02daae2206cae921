"""Text from outside: words matched without regard to case, and messages made legible and short."""

import re
from collections.abc import Iterable

MAX_WORD_LENGTH = 240
"""Characters of a word in a message; a longer one, such as a hostile path, is shortened in its middle."""
MAX_MESSAGE_LENGTH = 1500
"""Characters of a message; a longer one is shortened in its middle."""
NOTE = "...({:,} characters left out)..."
"""What stands for the middle of a shortened text."""
HEAD_SHARE = 0.7
"""Share of a shortened text that is taken from its start; the rest is its end."""

_LONG_WORD = re.compile(rf"\S{{{MAX_WORD_LENGTH + 1},}}")


def escape_controls(text: str, keep: str = "") -> str:
    """Replace every character that cannot be printed, but for those of `keep`, by its escape sequence."""
    if text.isprintable():
        return text
    return "".join(
        sign if sign.isprintable() or sign in keep else sign.encode("unicode_escape").decode() for sign in text
    )


def four_digits(value: float) -> str:
    """Write a figure with four significant digits, below a million without an exponent."""
    return f"{float(f'{value:.4g}'):g}"


def match_case(word: str, choices: Iterable[str]) -> str:
    """Return the choice that equals a word except for capital and small letters; the word itself if there is none."""
    return next((choice for choice in choices if choice.casefold() == word.casefold()), word)


def shorten(text: str, length: int) -> str:
    """Return a text of at most `length` characters: the middle of a longer one is replaced by a note of its length."""
    if len(text) <= length:
        return text
    kept = length - len(NOTE.format(len(text)))
    head = round(HEAD_SHARE * kept)
    return f"{text[:head]}{NOTE.format(len(text) - kept)}{text[len(text) - kept + head :]}"


def legible(text: str) -> str:
    """Return a message in one line: control characters escaped, long words and a long message shortened."""
    text = escape_controls(text)
    if len(text) > MAX_WORD_LENGTH:
        text = _LONG_WORD.sub(lambda match: shorten(match.group(), MAX_WORD_LENGTH), text)
    return shorten(text, MAX_MESSAGE_LENGTH)
