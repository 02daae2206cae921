"""Checks of a drive with several discs: whether they are one and the same part."""

from collections.abc import Iterator

from cycloid_mj.checks.limit import Check
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bodies import are_one_part

MOST_PINS = 100
"""Most output pins that a design may have."""


def disc_checks(reducer: Reducer) -> Iterator[Check]:
    """Check whether several discs are one part; a single disc needs no check."""
    design = reducer.design
    discs, pins, lobes = design.gear.discs, design.output.pins, design.lobes
    if discs == 1:
        return
    passed = are_one_part(discs, pins, lobes)
    more = next((count for count in range(pins, MOST_PINS + 1) if are_one_part(discs, count, lobes)), 0)
    yield Check(
        name="identical_discs",
        passed=passed,
        got=f"{pins}, for {lobes} lobes",
        limit=f"a number that {discs} divides without the factors that it shares with the lobes",
        why=f"then all {discs} discs are one and the same part; else each needs a drawing of its own",
        remedy="" if passed or not more else f"raise output.pins to {more}",
        severity="warning",
        key="output.pins",
        changes=() if passed or not more else ({"output.pins": more},),
    )
