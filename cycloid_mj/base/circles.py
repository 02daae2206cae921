"""Garbage-collector thresholds: modules and classes are a hundred thousand objects that stay."""

import gc

_RARELY = 100_000, 20, 100
"""Objects made until Python looks for circles of them, and how much more rarely it looks among older ones."""


def look_rarely() -> None:
    """Have this process look for circles of objects rarely: it takes a quarter of a short command, else a twentieth."""
    gc.set_threshold(*_RARELY)
