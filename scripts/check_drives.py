"""Check that drives can be exported and assembled, turn without contact, and that their bills list what is drawn.

For each design: `export` of solids, outlines, plates, assembly and drawings; the smallest distance of each two kinds
of parts that move against each other, by OpenCASCADE at 12 crank angles; whether each part can pass those that are
there before it; number and mass of each line of the bill against the solids in place. Half a minute to a minute of CPU
a design. Of an RV reducer, which has no covers, the exports alone.
"""

import argparse
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import get_args

import numpy as np
from drive_distances import smallest_distances

from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS, resolve
from cycloid_mj.parts.export import Casing, bill, casing, place_parts
from cycloid_mj.parts.export.drive import assembly_mass
from cycloid_mj.parts.export.insertion import blockages
from cycloid_mj.parts.export.motors import MotorName
from cycloid_mj.reducer import Reducer

CRANK_ANGLES = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)

EXPORTS = "--format step --plate --assembly --drawings", "--format dxf --plate"
"""Options of the exports: with solids, drawings and plates (STL, 3MF and bill), and with outlines."""

RV_EXPORTS = "--format step --assembly --drawings", "--format dxf", "--format stl"
"""Options of the exports of an RV reducer."""

COVERED = tuple(name for name, design in PRESETS.items() if design.layout == "central")
"""Presets that have covers. RV reducers have none, so no casing, plate or bill: `tests/parts/test_rv_parts.py` checks
that their parts stay apart and that the assembly has the volume of its parts."""

MASS_TOLERANCE = 0.01
"""Largest difference of the masses of bill and solids."""


def faults(name: str, motor: MotorName = "auto") -> Iterator[str]:
    """Yield a sentence for each fault of the drive of a design with a motor; `name` is a preset or a design file."""
    design = resolve(name)
    if design.layout == "rv":
        yield from failed_exports(name, motor, RV_EXPORTS)
        return
    reducer = Reducer(design)
    drive_casing = casing(reducer, motor)
    yield from touching_parts(reducer, drive_casing)
    yield from (f"{one.part} cannot pass {one.other}" for one in blockages(reducer, drive_casing))
    yield from bill_differences(reducer, drive_casing)
    yield from failed_exports(name, motor)


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


def run(arguments: list[str]) -> int:
    """Print the faults of the drives of designs; return 1 if there are any, else 0."""
    parser = argparse.ArgumentParser(description=str(__doc__).split("\n\n")[0])
    parser.add_argument("designs", nargs="*", default=COVERED, help="presets or design files")
    parser.add_argument("--motor", default="auto", choices=get_args(MotorName), help="motor, as for export --motor")
    options, count = parser.parse_args(arguments), 0
    for name in options.designs:
        sentences = list(faults(name, options.motor))
        count += len(sentences)
        print(f"{name}: {'; '.join(sentences) or 'good'}", flush=True)
    return int(count > 0)


if __name__ == "__main__":
    sys.exit(run(sys.argv[1:]))
