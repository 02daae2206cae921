"""Check that small changes of written drives do not improve all of their figures together.

    python scripts/dominance.py FILE...

For each drive of `design new`, one or two of face width, rollers, core, ring pins, bore and eccentricity are changed:
free lengths by `STEP`, others to the next size in stock; plain rollers get needles, or the other way round. The holes
of the discs follow the rollers, and the output discs the dowels in stock. A changed drive dominates if it can be built
within the diameter, if at most 1 % of its samples jam, and if mass, length, stiffness, efficiency, rated and momentary
torque within the tolerances are all better. A quarter of a minute of CPU a drive. The exit code is 1 if a
drive is dominated.
"""

import argparse
import itertools
import sys
from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cycloid_mj.base.errors import CycloidError
from cycloid_mj.checks import WALLS, sound_checks
from cycloid_mj.design import load, stock
from cycloid_mj.figures import figure
from cycloid_mj.life.as_built import select_rated_samples
from cycloid_mj.life.items import rate
from cycloid_mj.life.rated import rated_and_momentary_torque
from cycloid_mj.parts.cam_bearing import cam_bearing
from cycloid_mj.parts.export.bearings import output_pin, output_pin_length, roller_bearing
from cycloid_mj.parts.export.casing import casing
from cycloid_mj.parts.export.rules import describe_missing_dowels
from cycloid_mj.reducer import Reducer

STEP = 0.1
"""Relative change of a free length."""

MAX_JAMS = 0.01
"""Largest share of samples that jam."""

CHEAP: Mapping[str, float] = {
    "drive_mass_kg": -1.0,
    "drive_length_mm": -1.0,
    "stiffness_nm_per_arcmin": 1.0,
    "drive_efficiency_percent": 1.0,
}
"""Figures that are compared before the torques, in the order of their cost; -1 if a smaller value is better."""

Change = tuple[str, str, Any]
"""Table, key and new value of a change."""


def list_changes(reducer: Reducer) -> Iterator[tuple[Change, ...]]:
    """Yield all changes of one key, then of two keys, of a drive."""
    options = list(_list_options(reducer).values())
    yield from ((change,) for changes in options for change in changes)
    for first, second in itertools.combinations(options, 2):
        yield from itertools.product(first, second)


def _list_options(reducer: Reducer) -> Mapping[str, list[Change]]:
    """Return the changes of each key of a drive."""
    design = reducer.design
    gear, output, ring = design.gear, design.output, design.ring
    bores = sorted({0.5 * bearing.outside for bearing in stock.needle_bearings()})
    pins, dowels = ([0.5 * size for size in sizes] for sizes in (stock.pin_diameters(), stock.dowel_diameters()))
    options: dict[str, list[Any]] = {
        "gear.face_width": _free(gear.face_width),
        "gear.eccentricity": _free(gear.eccentricity),
        "gear.bore_radius": _next_sizes(gear.bore_radius, bores, 0.0),
        "ring.pin_radius": _next_sizes(ring.pin_radius, sorted(pins), STEP),
        "output.pin_radius": _free(output.pin_radius),
    }
    if output.rollers:
        options["output.core_radius"] = _next_sizes(output.core_radius, sorted(dowels), 0.0)
        options["output.roller_bearing"] = ["plain" if output.has_needles else "needles"]
    return {key: [(*key.split("."), value) for value in values] for key, values in options.items()}


def _free(length: float) -> list[float]:
    return [(1.0 - STEP) * length, (1.0 + STEP) * length]


def _next_sizes(size: float, sizes: Sequence[float], step: float) -> list[float]:
    """Return the next smaller and the next larger of some sorted sizes, at least the share `step` from a size."""
    below = bisect_left(sizes, size * (1.0 - max(step, 1e-6)) * (1.0 + 1e-9)) - 1
    above = bisect_right(sizes, size * (1.0 + max(step, 1e-6)) * (1.0 - 1e-9))
    return [*sizes[max(below, 0) : below + 1], *sizes[above : above + 1]]


def change_drive(reducer: Reducer, changes: Sequence[Change]) -> Reducer | None:
    """Return a drive with some changes; None if it cannot be built within the diameter, or its parts are not in stock.

    The holes of the discs follow the rollers, and the thickness of the output discs the dowels in stock.
    """
    tables: dict[str, dict[str, Any]] = {}
    for table, key, value in changes:
        tables.setdefault(table, {})[key] = value
    design = reducer.design
    hole = design.output.hole_radius - design.output.pin_radius - design.gear.eccentricity
    try:
        changed = reducer.but(**tables, bearing={"output_dynamic_capacity": 0.0})
        output, eccentricity = changed.design.output, changed.design.gear.eccentricity
        if not output.rollers:
            changed = changed.but(output={"core_radius": 0.0})
        changed = changed.but(output={"hole_radius": output.pin_radius + eccentricity + hole})
        changed = _fit_dowels(changed)
        return changed if _is_buildable(reducer, changed) else None
    except CycloidError:
        return None


def _fit_dowels(reducer: Reducer) -> Reducer:
    """Return a drive whose output discs have the thickness at which dowels in stock reach from face to face."""
    output, length = reducer.design.output, output_pin_length(reducer)
    (fitting,) = stock.stock_pin_lengths(2.0 * output.root_radius, np.array([length]), max_count=1)
    return reducer.but(output={"disc_thickness": output.disc_thickness + 0.5 * (float(fitting) - length)})


def _is_buildable(original: Reducer, changed: Reducer) -> bool:
    """Return whether a changed drive passes its checks within the diameter of the original with parts in stock."""
    covers = casing(changed)
    if covers.outer > casing(original).outer + 1e-6 or any(describe_missing_dowels(changed, covers)):
        return False
    if not output_pin(changed) or not cam_bearing(changed):
        return False
    if changed.design.output.has_needles and changed.design.output.rollers and not roller_bearing(changed):
        return False
    failed = [item for item in sound_checks(changed) if not item.passed]
    return not any(item.severity == "error" or item.name in WALLS for item in failed)


def dominating_changes(reducer: Reducer) -> Iterator[tuple[tuple[Change, ...], list[tuple[str, float, float]]]]:
    """Yield changes that improve all figures of a drive, with (figure, value before, value after) for each figure."""
    original = {key: figure(key).value(_loaded(reducer)) for key in CHEAP}
    torques = find_torques(reducer)
    for changes in list_changes(reducer):
        changed = change_drive(reducer, changes)
        if changed is None or not _is_better_in_all(changed, original):
            continue
        try:
            if find_jam_share(changed) > MAX_JAMS:
                continue
            changed_torques = find_torques(changed)
        except CycloidError:
            continue
        if all(new > old for new, old in zip(changed_torques, torques, strict=True)):
            rows = [(key, original[key], figure(key).value(_loaded(changed))) for key in CHEAP]
            names = "rated_torque_nm", "momentary_torque_nm"
            yield changes, rows + list(zip(names, torques, changed_torques, strict=True))


def _is_better_in_all(changed: Reducer, original: Mapping[str, float]) -> bool:
    """Return whether a changed drive has better values than `original` of all figures of `CHEAP`."""
    try:
        return all(sign * (figure(key).value(_loaded(changed)) - original[key]) > 0.0 for key, sign in CHEAP.items())
    except CycloidError:
        return False


def _loaded(reducer: Reducer) -> Reducer:
    return reducer.but(load={"torque": reducer.design.rated_torque})


def find_jam_share(reducer: Reducer) -> float:
    """Return the share of the samples of a drive within its tolerances that jam."""
    return float(select_rated_samples(reducer).jams.mean())


def find_torques(reducer: Reducer) -> tuple[float, float]:
    """Return rated and momentary torque [N m] of a drive within its tolerances."""
    design = reducer.design
    items = rate(design, parts="toleranced").items.values()
    (rated, _), (momentary, _) = rated_and_momentary_torque(items, design.rated_torque, design.service.life)
    return rated, momentary


def main() -> int:
    """Print the changes that dominate each drive; return 1 if there are any."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", type=Path)
    count = 0
    for file in parser.parse_args().files:
        reducer = Reducer(load(file))
        dominating = list(dominating_changes(reducer))
        count += bool(dominating)
        print(f"{file}: {len(dominating)} of {len(list(list_changes(reducer)))} changes dominate", flush=True)
        for changes, rows in dominating:
            words = ", ".join(
                f"{table}.{key} = {value if isinstance(value, str) else f'{1e3 * value:.5g} mm'}"
                for table, key, value in changes
            )
            print(f"  {words}: " + ", ".join(f"{key} {old:.4g} -> {new:.4g}" for key, old, new in rows))
    return int(count > 0)


if __name__ == "__main__":
    sys.exit(main())
