"""Write the table in docs/results.md of what is measured of the two designs, from `cycloid-mj measure`.

`python scripts/docs_measured.py` writes it from tests/data/measured.json; with --measure it measures first, which
takes some ten minutes of two cores, and keeps there what the table shows.
"""

import argparse
import json
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parent.parent
PAGE, KEPT = ROOT / "docs" / "results.md", ROOT / "tests" / "data" / "measured.json"
MARK = "<!-- {word} of measured: scripts/docs_measured.py writes what stands here -->"
BEGIN, END = MARK.format(word="Begin"), MARK.format(word="End")
DESIGNS = ("pin", "nonpin")
MEASURES = ("backlash", "lost-motion", "te", "torque", "efficiency", "loads")

Quantities = Mapping[str, Mapping[str, Any]]
"""``measure/key`` -> value, unit, numerical_error, reference."""

ROWS = (
    ("backlash of the output, mean [arcmin]", ("backlash/backlash",)),
    ("lost motion at +-3 % of the rated torque [arcmin]", ("lost-motion/lost_motion",)),
    ("torsional stiffness without friction [N m/arcmin]", ("lost-motion/stiffness_ideal",)),
    ("torsional stiffness with friction [N m/arcmin]", ("lost-motion/stiffness",)),
    (
        "transmission error of the output, peak to peak, loaded [arcsec]",
        ("te/output_peak_to_peak_loaded_forward_speed",),
    ),
    ("output torque at 1.048 N m in [N m]", ("torque/output_torque",)),
    ("efficiency [%]", ("efficiency/efficiency",)),
    ("back-driving efficiency [%]", ("efficiency/back_driving_efficiency",)),
    ("largest force on a tooth [N]", ("loads/pin_gear_peak_force", "loads/tooth_peak_force")),
    ("its Hertz pressure [MPa]", ("loads/pin_gear_pressure", "loads/tooth_pressure")),
    ("largest force on an output pin [N]", ("loads/output_peak_force",)),
    ("largest force of the cam [N]", ("loads/cam_peak_force",)),
    ("torque at which a tooth first yields below its surface [N m]", ("loads/capacity",)),
    ("torque up to which the contacts shake down [N m]", ("loads/capacity_shakedown",)),
)
"""Label, and the keys of which a design has one."""


def measured(design: str) -> dict[str, dict[str, Any]]:
    """Measure a design by every measure, with the defaults of the command line; give what the table shows."""
    found: dict[str, dict[str, Any]] = {}
    for measure in MEASURES:
        names = [design] if measure == "torque" else ["--design", design]
        command = [sys.executable, "-m", "cycloid_mj.cli", "measure", measure, *names, "--json", "--quiet"]
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
        told = json.loads(done.stdout)
        told = told[0] if isinstance(told, list) else told
        for key, quantity in told["quantities"].items():
            if any(f"{measure}/{key}" in keys for _, keys in ROWS):
                kept = ("value", "unit", "numerical_error", "reference")
                found[f"{measure}/{key}"] = {name: quantity[name] for name in kept}
    return found


def table(found: Mapping[str, Quantities]) -> str:
    """Give the table: value, its numerical error, and its closed form or statics in brackets."""
    lines = ["| | " + " | ".join(found) + " |", "|---" * (len(found) + 1) + "|"]
    for label, keys in ROWS:
        cells = [_cell(next(one[key] for key in keys if key in one)) for one in found.values()]
        lines.append(f"| {label} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _cell(quantity: Mapping[str, Any]) -> str:
    value, error, reference = (quantity[name] for name in ("value", "numerical_error", "reference"))
    text = f"{value:.4g}"
    text += f" +- {error:.1g}" if error else ""
    return text if reference is None else f"{text} ({reference:.4g})"


def written(page: str, found: Mapping[str, Quantities]) -> str:
    """Give the page with its table replaced; raise ValueError if it lacks the marks."""
    if BEGIN not in page or END not in page:
        raise ValueError(f"the page lacks {BEGIN} or {END}")
    before, rest = page.split(BEGIN)
    return f"{before}{BEGIN}\n\n{table(found)}\n\n{END}{rest.split(END)[1]}"


def main() -> int:
    """Write the page; give the exit code."""
    parser = argparse.ArgumentParser(description=str(__doc__).split("\n\n")[0])
    parser.add_argument("--measure", action="store_true", help="measure first")
    if parser.parse_args().measure:
        KEPT.write_text(json.dumps({name: measured(name) for name in DESIGNS}, indent=1) + "\n", encoding="utf-8")
    found = json.loads(KEPT.read_text(encoding="utf-8"))
    PAGE.write_text(written(PAGE.read_text(encoding="utf-8"), found), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
