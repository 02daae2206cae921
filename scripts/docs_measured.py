"""Write the tables of docs/results.md: `compare` of pin and nonpin, and the results of `measure` for both.

python scripts/docs_measured.py                   # from tests/data/measured.json and compared.json
python scripts/docs_measured.py FOLDER            # keeps there first what the `measure` files in a folder say
python scripts/docs_measured.py --compared FILE   # keeps there first what a `compare --json` says

`scripts/docs_figures.py` measures, compares, and calls this.
"""

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from docs_page import markdown_table, replace_sections

from cycloid_mj.comparison.starts import StartSpread, compare_order
from cycloid_mj.comparison.table import CENTRE_VIBRATION, GEAR_SPEED, OUTPUT_VIBRATION, Q_PATH, Q_VELOCITY

ROOT = Path(__file__).parent.parent
PAGE, KEPT = ROOT / "docs" / "results.md", ROOT / "tests" / "data" / "measured.json"
COMPARED, REPRODUCED = (ROOT / "tests" / "data" / name for name in ("compared.json", "reproduce.json"))
SCRIPT = "scripts/docs_measured.py"
DESIGNS = ("pin", "nonpin")
MEASURES = ("backlash", "lost-motion", "te", "torque", "efficiency", "loads")

Quantities = Mapping[str, Mapping[str, Any]]
"""``measure/key`` -> value, unit, numerical_error, reference."""

ROWS = (
    ("backlash of the output, mean [arcmin]", ("backlash/backlash",)),
    ("lost motion at ±3 % of the nominal torque [arcmin]", ("lost-motion/lost_motion",)),
    ("torsional stiffness without friction [N m/arcmin]", ("lost-motion/stiffness_ideal",)),
    ("torsional stiffness with friction [N m/arcmin]", ("lost-motion/stiffness",)),
    (
        "transmission error of the output, peak to peak, loaded [arcsec]",
        ("te/output_peak_to_peak_loaded_forward_speed",),
    ),
    ("output torque at 1.048 N m on the crank [N m]", ("torque/output_torque",)),
    ("efficiency [%]", ("efficiency/efficiency",)),
    ("back-driving efficiency [%]", ("efficiency/back_driving_efficiency",)),
    ("largest force on a tooth [N]", ("loads/pin_gear_peak_force", "loads/tooth_peak_force")),
    ("Hertz pressure of that tooth [MPa]", ("loads/pin_gear_pressure", "loads/tooth_pressure")),
    ("largest force on an output pin [N]", ("loads/output_peak_force",)),
    ("largest force of the cam [N]", ("loads/cam_peak_force",)),
    ("output torque at first yield below a tooth surface [N m]", ("loads/capacity",)),
    ("output torque at shakedown [N m]", ("loads/capacity_shakedown",)),
)
"""Label of each row, and the possible keys, one for each kind of ring."""

STEADY = "without its steady shift"
GEAR, OUTPUT = ("vibration", "gear_centre_m_s2"), ("vibration", "output_rad_s2")
LEVELS = (
    ("gear speed [rad/s]", GEAR_SPEED, ("fluctuation", "gear_speed_rad_s")),
    (f"path of q, {STEADY} [um]", Q_PATH, ("fluctuation", "q_path_um")),
    (f"velocity of q, {STEADY} [mm/s]", Q_VELOCITY, ("fluctuation", "q_velocity_mm_s")),
    ("acceleration of the gear centre [m/s^2]", CENTRE_VIBRATION, GEAR),
    ("acceleration of the output [rad/s^2]", OUTPUT_VIBRATION, OUTPUT),
)
"""Label, figure over the starts without load, and place in the JSON of a loaded run."""

CLAIMS = ("gear_speed", "q_path", "q_velocity", "gear_centre_acceleration", "output_acceleration")
"""Claims of `reproduce` on the same quantities."""


def read_measures(folder: Path, design: str) -> dict[str, dict[str, Any]]:
    """Read the quantities of a design for the table from its measures' JSON files in a folder (``pin-te``, ...)."""
    measures: dict[str, dict[str, Any]] = {}
    for measure in MEASURES:
        content = json.loads((folder / f"{design}-{measure}").read_text(encoding="utf-8"))
        content = content[0] if isinstance(content, list) else content
        for key, quantity in content["quantities"].items():
            if any(f"{measure}/{key}" in keys for _, keys in ROWS):
                kept = ("value", "unit", "numerical_error", "reference")
                measures[f"{measure}/{key}"] = {name: quantity[name] for name in kept}
    return measures


def read_comparison(content: Mapping[str, Any]) -> dict[str, Any]:
    """Extract speed and runs for the page from the JSON of `compare`, with the time step of each run [us]."""
    runs = []
    for run in content["runs"]:
        spreads = {one["quantity"]: one for one in run["spreads"]}
        figures: dict[str, Any] = {}
        for label, figure, (group, key) in LEVELS:
            if run["load_nm"]:
                figures[label] = run[group][key]["rms"]
            else:
                figures[label] = [spreads[figure.words][name] for name in ("least", "largest", "mean")]
        step, efficiency = run["findings"]["timestep_s"], run["findings"]["efficiency"]
        runs.append(
            {key: run[key] for key in ("design", "load_nm", "starts")}
            | {"timestep_us": 1e6 * step, "efficiency": efficiency, "figures": figures}
        )
    return {"speed_rpm": content["conditions"]["drive.speed_rpm"], "runs": runs}


def format_comparison(data: Mapping[str, Any]) -> str:
    """Tabulate the result of `compare` in Markdown, a column for each run, with its conditions."""
    runs = data["runs"]
    loads = [f"{run['load_nm']:g} N m" if run["load_nm"] else "no load" for run in runs]
    names = [run["design"].replace("-", " ") for run in runs]
    steps = ", ".join(dict.fromkeys(f"{run['timestep_us']:.3g}" for run in runs))
    starts = max(run["starts"] for run in runs)
    condition = (
        f"The table shows results of `compare pin nonpin` at {data['speed_rpm']:g} rpm. Except for the efficiency,\n"
        f"all values are rms differences from the ideal motion. Simulations without load were repeated\n"
        f"with {starts} independent starts. For these simulations, the table shows the smallest and the largest\n"
        f"value and, in parentheses, the mean value. The time step is {steps} us."
    )
    rows = [(label, *(_level(run["figures"][label]) for run in runs)) for label, *_ in LEVELS]
    shares = (f"{100.0 * run['efficiency']:.1f}" if run["efficiency"] is not None else "" for run in runs)
    head = ("Quantity", *map("{}, {}".format, loads, names))
    return f"{condition}\n\n{markdown_table(head, [*rows, ('efficiency [%]', *shares)])}"


def format_fluctuations(data: Mapping[str, Any], claims: Sequence[Mapping[str, Any]]) -> str:
    """Tabulate which design fluctuates more, under load and over the starts without load, in Markdown.

    `claims` are those of `reproduce`, whose fluctuations contain the range of pin over nonpin.
    """
    pin, nonpin, alike = (_idle(data, name) for name in ("pin", "nonpin", "nonpin-like-pin"))
    loaded = {run["design"]: run["figures"] for run in data["runs"] if run["load_nm"]}
    ratios = {claim["key"]: claim["ours"]["spread"] for claim in claims}
    head = (
        *("Quantity", "Under load: value of pin / value of nonpin", "No load, by `compare`: pin or nonpin"),
        *("No load, by `reproduce`: pin or nonpin", "No load: nonpin or nonpin like pin"),
        "No load: pin or nonpin like pin",
    )
    rows = [
        (
            label.split(" [")[0],
            f"{loaded['pin'][label] / loaded['nonpin'][label]:.2g}",
            _rougher(compare_order(pin[label], nonpin[label]), "pin", "nonpin"),
            _rougher(compare_order(StartSpread(tuple(ratios[key])), StartSpread((1.0,))), "pin", "nonpin"),
            _rougher(compare_order(nonpin[label], alike[label]), "nonpin", "nonpin like pin"),
            _rougher(compare_order(pin[label], alike[label]), "pin", "nonpin like pin"),
        )
        for (label, *_), key in zip(LEVELS, CLAIMS, strict=True)
    ]
    return markdown_table(head, rows)


def _idle(data: Mapping[str, Any], design: str) -> Mapping[str, StartSpread]:
    """Return the range of each quantity over the starts of a design without load, by its label."""
    (figures,) = (run["figures"] for run in data["runs"] if run["design"] == design and not run["load_nm"])
    return {label: StartSpread(tuple(figures[label][:2])) for label, *_ in LEVELS}


def _rougher(sign: int, first: str, second: str) -> str:
    return {1: first, -1: second, 0: "no order"}[sign]


def _level(value: float | Sequence[float]) -> str:
    if isinstance(value, Sequence):
        least, largest, mean = (f"{one:.0f}" if one >= 100.0 else f"{one:.2g}" for one in value)
        return f"{least} to {largest} ({mean})"
    return f"{value:.3g}"


def table(quantities: Mapping[str, Quantities]) -> str:
    """Return the table of values with numerical errors, and closed forms or static results in brackets."""
    rows = [
        (label, *(_cell(next(quantity[key] for key in keys if key in quantity)) for quantity in quantities.values()))
        for label, keys in ROWS
    ]
    return markdown_table(("Quantity", *quantities), rows)


def _cell(quantity: Mapping[str, Any]) -> str:
    value, error, reference = (quantity[name] for name in ("value", "numerical_error", "reference"))
    text = f"{value:.4g}"
    text += f" ± {error:.1g}" if error else ""
    return text if reference is None else f"{text} ({reference:.4g})"


def fill_page(page: str) -> str:
    """Return the page with its generated tables replaced by those of all kept results."""
    sections = {
        "measured": table(_read(KEPT)),
        "compared": format_comparison(_read(COMPARED)),
        "orders": format_fluctuations(_read(COMPARED), _read(REPRODUCED)["claims"]),
    }
    return replace_sections(page, sections, SCRIPT)


def _read(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))


def _keep(path: Path, value: Any) -> None:
    path.write_text(json.dumps(value, indent=1) + "\n", encoding="utf-8")


def main() -> int:
    """Write the page and return the exit code."""
    parser = argparse.ArgumentParser(description=str(__doc__).split("\n\n")[0])
    parser.add_argument("folder", nargs="?", type=Path, help="of the measures' JSON")
    parser.add_argument("--compared", type=Path, help="JSON of `compare`")
    options = parser.parse_args()
    if options.folder:
        _keep(KEPT, {name: read_measures(options.folder, name) for name in DESIGNS})
    if options.compared:
        _keep(COMPARED, read_comparison(_read(options.compared)))
    PAGE.write_text(fill_page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
