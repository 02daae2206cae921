"""Check that drives can be exported and assembled, turn without contact, and that their bills list what is drawn.

For each design: `export` of solids, outlines, plates, assembly and drawings; the smallest distance of each two kinds
of parts that move against each other, by OpenCASCADE at 12 crank angles; whether each part can pass those that are
there before it; number and mass of each line of the bill against the solids in place. Half a minute to a minute of CPU
a design. Of an RV reducer, which has no covers, the exports alone. Rules for joints that a design violates are those
that `design check` reports.

    python scripts/check_drives.py [DESIGN ...]         # default: the presets
    python scripts/check_drives.py --new [NAME ...]     # drives of `design new` (`NEW_DRIVES`), default: all
"""

import argparse
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import redirect_stderr, redirect_stdout, suppress
from io import StringIO
from pathlib import Path
from typing import get_args

import numpy as np
from drive_distances import smallest_distances

from cycloid_mj.base.errors import DesignError
from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS, resolve
from cycloid_mj.parts.export import Casing, bill, casing, place_parts
from cycloid_mj.parts.export.drive import assembly_mass
from cycloid_mj.parts.export.insertion import blockages
from cycloid_mj.parts.export.motors import MotorName
from cycloid_mj.parts.export.rules import describe_violations
from cycloid_mj.reducer import Reducer

CRANK_ANGLES = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)

EXPORTS = "--format step --plate --assembly --drawings", "--format dxf --plate"
"""Options of the exports: with solids, drawings and plates (STL, 3MF and bill), and with outlines."""

RV_EXPORTS = "--format step --assembly --drawings", "--format dxf", "--format stl"
"""Options of the exports of an RV reducer."""

COVERED = tuple(name for name, design in PRESETS.items() if design.layout == "central")
"""Presets that have covers. RV reducers have none, so no casing, plate or bill: `tests/parts/test_rv_parts.py` checks
that their parts stay apart and that the assembly has the volume of its parts."""

STRADDLED = "--set shaft.mounting=straddle"
BOTH_DISCS = "--set output.support=both_ends --set output.main_bearing_seat=both_discs"

NEW_DRIVES: Mapping[str, str] = {
    "ground": "--ratio 25 --diameter-mm 80 --torque-nm 15",
    "ground-two-discs": "--ratio 39 --diameter-mm 100 --torque-nm 20 --discs 2",
    "ground-hollow": f"--ratio 20 --diameter-mm 120 --torque-nm 20 {STRADDLED} --set shaft.bore_radius_mm=5",
    "ground-short": f"--ratio 30 --diameter-mm 110 --torque-nm 20 {STRADDLED} --set output.main_bearing_seat=disc",
    "ground-both-discs": f"--ratio 30 --diameter-mm 120 --torque-nm 20 {BOTH_DISCS} "
    "--set output.main_bearings=angular_contact --set output.disc_thickness_mm=20",
    "milled": "--process milled --ratio 25 --diameter-mm 90 --torque-nm 4",
    "milled-one-piece": "--process milled --ratio 15 --diameter-mm 110 --torque-nm 4 --discs 2 "
    "--set shaft.cam_joint=one_piece",
    "milled-crossed-roller": "--process milled --ratio 19 --diameter-mm 100 --torque-nm 4 "
    "--set output.main_bearings=crossed_roller",
    "printed-one-disc": "--process printed --ratio 15 --diameter-mm 70 --torque-nm 1.5 --speed-rpm 200 --life-h 500",
    "printed-two-discs": "--process printed --ratio 21 --diameter-mm 110 --torque-nm 3 --discs 2",
    "rv-main-bearings": "--layout rv --ratio 121 --diameter-mm 190 --torque-nm 412 "
    "--set cranks.main_bearings=angular_contact",
    "printed-tapered": f"--process printed --ratio 15 --diameter-mm 130 --torque-nm 2 {BOTH_DISCS} "
    "--set output.main_bearings=tapered --set output.disc_thickness_mm=36",
}
"""Requirements of drives for `design new`, over its three processes (steel is ground), and kinds of drives, by name."""

MASS_TOLERANCE = 0.01
"""Largest difference of the masses of bill and solids."""


def faults(name: str, motor: MotorName = "auto") -> Iterator[str]:
    """Yield a sentence for each fault of the drive of a design with a motor; `name` is a preset or a design file.

    Nothing but the reason is yielded for a design without covers that fit.
    """
    design = resolve(name)
    if design.layout == "rv":
        yield from failed_exports(name, motor, RV_EXPORTS)
        return
    reducer = Reducer(design)
    try:
        drive_casing = casing(reducer, motor)
    except DesignError as error:
        yield f"no covers: {error}"
        return
    yield from touching_parts(reducer, drive_casing)
    yield from (f"{one.part} cannot pass {one.other}" for one in blockages(reducer, drive_casing))
    yield from bill_differences(reducer, drive_casing)
    yield from failed_exports(name, motor)


def reported_violations(name: str, motor: MotorName = "auto") -> tuple[str, ...]:
    """Return the rules for joints that the drive of a design with a motor violates, as `design check` reports them."""
    design = resolve(name)
    if design.layout == "rv":
        return ()
    reducer = Reducer(design)
    with suppress(DesignError):
        return tuple(describe_violations(reducer, casing(reducer, motor)))
    return ()


def touching_parts(reducer: Reducer, casing: Casing) -> Iterator[str]:
    """Yield a sentence for two kinds of parts that touch at a crank angle, or are closer than the axial play."""
    for distance in smallest_distances(reducer, casing, CRANK_ANGLES):
        if not distance.keeps(casing.play):
            yield f"{distance.part} and {distance.other} are {1e6 * distance.value:.4g} um apart"


def bill_differences(reducer: Reducer, casing: Casing) -> Iterator[str]:
    """Yield a sentence for each line of the bill whose count differs from the solids, and if the masses differ."""
    lines = [line for line in bill(reducer, 0.0, casing) if line.made_or_bought != "consumable"]
    listed = {line.item: line.count for line in lines}
    drawn = Counter(place.part for place in place_parts(reducer, 0.0, casing))
    for item in sorted(listed.keys() | drawn.keys()):
        if listed.get(item, 0) != drawn[item]:
            yield f"{item}: {listed.get(item, 0)} in the bill, {drawn[item]} in the assembly"
    masses = sum(line.mass_kg for line in lines), assembly_mass(reducer, casing)
    if not abs(masses[0] / masses[1] - 1.0) <= MASS_TOLERANCE:
        yield f"mass {masses[0]:.4g} kg in the bill, {masses[1]:.4g} kg of the solids"


def failed_exports(name: str, motor: MotorName, exports: Sequence[str] = EXPORTS) -> Iterator[str]:
    """Yield a sentence for each of some `exports` of a design that fails, with the last line of its messages."""
    for flags in exports:
        with tempfile.TemporaryDirectory() as folder:
            command = ["export", *flags.split(), "--design", name, "--out", str(Path(folder) / "parts")]
            command += ["--motor", motor]
            messages = StringIO()
            with redirect_stderr(messages), redirect_stdout(StringIO()):
                code = main(command)
            if code:
                yield f"export {flags} ends with {code}: {messages.getvalue().strip().splitlines()[-1:]}"


def create_drive(name: str, folder: str) -> str:
    """Create a drive of `NEW_DRIVES` in a folder by `design new`; return the path of its design file.

    Raises
    ------
    DesignError
        The requirement is refused.
    """
    messages = StringIO()
    with redirect_stderr(messages), redirect_stdout(messages):
        code = main(["design", "new", name, *NEW_DRIVES[name].split(), "--out", folder])
    if code:
        raise DesignError(f"design new {NEW_DRIVES[name]} ends with {code}: {messages.getvalue().strip()}")
    return str(Path(folder) / f"{name}.toml")


def check_drive(name: str, motor: MotorName) -> int:
    """Print the faults of the drive of a design, and the rules that it violates; return the number of faults."""
    sentences = list(faults(name, motor))
    print(f"{name}: {'; '.join(sentences) or 'good'}", flush=True)
    for violation in reported_violations(name, motor):
        print(f"  reported by design check: {violation}", flush=True)
    return len(sentences)


def check_new_drive(name: str, motor: MotorName) -> int:
    """Create a drive of `NEW_DRIVES` and check it as `check_drive` does; a refused requirement is a fault."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            return check_drive(create_drive(name, folder), motor)
        except DesignError as error:
            print(f"{name}: {error}", flush=True)
            return 1


def run(arguments: list[str]) -> int:
    """Print the faults of the drives of designs; return 1 if there are any, else 0."""
    parser = argparse.ArgumentParser(description=str(__doc__).split("\n\n")[0])
    parser.add_argument("designs", nargs="*", help="presets or design files; with --new, names of NEW_DRIVES")
    parser.add_argument("--new", action="store_true", help="create the drives by design new first")
    parser.add_argument("--motor", default="auto", choices=get_args(MotorName), help="motor, as for export --motor")
    options = parser.parse_args(arguments)
    if unknown := options.new and {*options.designs} - NEW_DRIVES.keys():
        parser.error(f"unknown: {', '.join(sorted(unknown))}. Drives of --new are {', '.join(NEW_DRIVES)}")
    check, names = (check_new_drive, NEW_DRIVES) if options.new else (check_drive, COVERED)
    return int(sum(check(name, options.motor) for name in options.designs or names) > 0)


if __name__ == "__main__":
    sys.exit(run(sys.argv[1:]))
