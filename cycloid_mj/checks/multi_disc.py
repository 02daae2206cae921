"""Checks of drives with several discs: whether all discs are the same part."""

from collections.abc import Iterator

from cycloid_mj.checks.check import Check
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bodies import are_discs_identical

MAX_OUTPUT_PINS = 100
"""Largest number of output pins that a design may have."""


def disc_checks(reducer: Reducer) -> Iterator[Check]:
    """Yield the check that all discs of a drive can be manufactured as the same part; none for a single disc.

    With n output pins and L lobes, n / gcd(n, L) must be a multiple of the number of discs, see `are_discs_identical`.
    A failure is a warning; its remedy is the next larger number of output pins that passes, up to `MAX_OUTPUT_PINS`.
    """
    design = reducer.design
    disc_count, pin_count, lobe_count = design.gear.discs, design.output.pins, design.lobes
    if disc_count == 1:
        return
    is_passed = are_discs_identical(disc_count, pin_count, lobe_count)
    next_pin_count = next(
        (
            count
            for count in range(pin_count, MAX_OUTPUT_PINS + 1)
            if are_discs_identical(disc_count, count, lobe_count)
        ),
        0,
    )
    yield Check(
        name="identical_discs",
        passed=is_passed,
        got=f"{pin_count}, for {lobe_count} lobes",
        limit=f"divisible by {disc_count}, without the factors that {disc_count} shares with the lobes",
        why=f"then all {disc_count} discs are the same part; else each needs its own drawing",
        remedy="" if is_passed or not next_pin_count else f"raise output.pins to {next_pin_count}",
        severity="warning",
        key="output.pins",
        changes=() if is_passed or not next_pin_count else ({"output.pins": next_pin_count},),
    )
