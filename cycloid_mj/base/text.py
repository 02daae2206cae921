"""Text from outside: words matched without regard to case, and messages shortened to a readable line."""

import re
from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True)
class MessageLimits:
    """Limits of messages, against hostile paths and values; a longer text is shortened in its middle."""

    word: int = 240  # characters of a word
    message: int = 1500  # characters of a message
    head_share: float = 0.7  # share of a shortened text that is taken from its start; the rest is its end


MESSAGE = MessageLimits()

NOTE = "...({:,} characters left out)..."
"""Replacement of the middle of a shortened text."""

_LONG_WORD = re.compile(rf"\S{{{MESSAGE.word + 1},}}")


def escape_controls(text: str, keep: str = "") -> str:
    """Replace every character that cannot be printed, but for those of `keep`, by its escape sequence."""
    if text.isprintable():
        return text
    return "".join(
        character if character.isprintable() or character in keep else character.encode("unicode_escape").decode()
        for character in text
    )


def four_digits(value: float) -> str:
    """Write a quantity with four significant digits, below a million without an exponent."""
    return f"{float(f'{value:.4g}'):g}"


def match_case(word: str, choices: Iterable[str]) -> str:
    """Return the choice that equals a word except for capital and small letters; the word itself if there is none."""
    return next((choice for choice in choices if choice.casefold() == word.casefold()), word)


def shorten(text: str, length: int) -> str:
    """Return a text of at most `length` characters: the middle of a longer one is replaced by a note of its length."""
    if len(text) <= length:
        return text
    kept_length = length - len(NOTE.format(len(text)))
    start_length = round(MESSAGE.head_share * kept_length)
    return (
        f"{text[:start_length]}{NOTE.format(len(text) - kept_length)}{text[len(text) - kept_length + start_length :]}"
    )


def legible(text: str) -> str:
    """Return a message in one line: control characters escaped, long words and a long message shortened."""
    text = escape_controls(text)
    if len(text) > MESSAGE.word:
        text = _LONG_WORD.sub(lambda match: shorten(match.group(), MESSAGE.word), text)
    return shorten(text, MESSAGE.message)
