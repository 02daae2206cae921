"""Write the tables of docs/printed-drive.md from the kept fits of the printed drive and its twin.

python scripts/docs_bench.py           # from tests/data/bench/fitted.json
python scripts/docs_bench.py --fit          # fits, predicts, and solves the parts first: a quarter of an hour of CPU
python scripts/docs_bench.py --fit --quick  # the same but for contacts that rub, which stay as they are: a minute

`scripts/docs_figures.py` calls this.
"""

import json
import math
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from docs_page import DOCS, markdown_table, replace_sections

ROOT = Path(__file__).parent.parent
PAGE, BENCH = DOCS / "printed-drive.md", ROOT / "tests" / "data" / "bench"
KEPT = BENCH / "fitted.json"
SCRIPT = "scripts/docs_bench.py"
LOOPS = {"pin": ("play_loop", "stiffness_loop"), "nonpin": ("nonpin_play_loop", "nonpin_stiffness_loop")}
AUTHORS = {
    "width_deg": ("1.24", "0.90"),
    "play_deg": ("", ""),
    "stiffness_nm_per_rad": ("310", "292"),
    "coulomb_nm": ("3.94 (running)", "4.26 (running)"),
}
"""Figures that the authors state, baseline drive and twin; running friction is of slow turns, not of the loops."""
FIGURES = {
    "width_deg": "play, as width of the small loop at zero torque [deg]",
    "play_deg": "play, between lines through the loading branches [deg]",
    "stiffness_nm_per_rad": "stiffness [N m/rad]",
    "coulomb_nm": "Coulomb friction [N m]",
}
PARTS = {
    "gear": "disc",
    "ring": "ring and housing",
    "output": "output pins and carrier",
    "pin_1": "ring pins",
    "studs": "output pins in their bores",
    "far_plate": "second plate, supported by the output pins",
    "crank": "crank in its bearing seats",
}
MOUNTS = BENCH / "mounts.toml"

COULOMB = {"law": "coulomb"}
"""Friction of the drives: loops of a locked shaft show Coulomb friction only."""

RUBBING = ("play", "tooth_stiffness", "friction", "drag", "drag_travel")
"""Fitted parameters with friction in the contacts."""

QUARTERS = (0.0, 0.25, 0.5, 0.75)
"""Possible angles of the locked crank, as shares of the angle between two ring pins."""

PRELOADS = (0.0, 5.0, 10.0, 15.0, 20.0, 30.0, 40.0)
"""Angles between the halves of a ring [arcmin]."""

SETTLED, TURNS = 0.06, 0.25
"""Settling time of a run at the speed of the preset [s], and the crank turns evaluated afterwards (heuristic)."""


def fit_drives() -> dict[str, Any]:
    """Fit both measured drives, predict the nonpin drive from the pin drive's fit, and compute compliances and preload.

    Return the content of the page as JSON values.
    """
    import cycloid_mj as cm
    from cycloid_mj.reducer import Reducer

    content: dict[str, Any] = {}
    pin: Any = None
    for kind, names in LOOPS.items():
        drawn = cm.load("printed").but(ring={"kind": kind}, friction=COULOMB)
        loops = [cm.read_loop(BENCH / f"{name}.csv") for name in names]
        calibration = cm.calibrate(drawn, loops)
        content_of = calibration.as_json()
        pin = pin or calibration.design
        play = pin.clearance.pin_gear
        twin = drawn.but(clearance={"pin_gear": play, "tooth": play, "output": play}, springs=pin.springs.model_dump())
        predicted = cm.predict_loops(Reducer(twin), loops)
        content[kind] = {
            **{key: content_of[key] for key in ("parameters", "measured", "model", "models")},
            "shares": [loop["residual_share"] for loop in content_of["loops"]],
            "shares_without_offset": [loop["residual_share_without_offset"] for loop in content_of["loops"]],
            "predicted": {key: quantity.value for key, quantity in predicted.modelled.in_units().items()},
            "predicted_shares": list(predicted.shares),
            **part_compliances(kind),
        }
    return content | {"preload": preload_study()}


def part_compliances(kind: str) -> dict[str, Any]:
    """Compute the compliance of each part of a printed drive by finite elements; `kind` is that of the ring.

    Return ``parts``, part -> compliance [rad/(N m)], and ``interval``, the stiffness of the drive [N m/rad] at both
    limits of the modulus.
    """
    import cycloid_mj as cm
    from cycloid_mj.reducer import Reducer
    from cycloid_mj.stress.mounts import read_mounts
    from cycloid_mj.stress.springs import part_springs

    springs = part_springs(Reducer(cm.load("printed").but(ring={"kind": kind}, friction=COULOMB)), read_mounts(MOUNTS))
    return {"parts": dict(springs.compliance), "interval": springs.interval}


def fit_contact_friction() -> dict[str, Any]:
    """Fit friction in the contacts to the loops of the pin drive, and compare other kinds of losses.

    Return JSON values: ``held``, the fit for each crank angle and locked shaft, and ``losses``, a row for each kind.
    """
    import cycloid_mj as cm
    from cycloid_mj.bench import compare_losses
    from cycloid_mj.reducer import Reducer
    from cycloid_mj.reducer.limits import stops

    drawn, loops = (
        cm.load("printed").but(friction=COULOMB),
        [cm.read_loop(BENCH / f"{name}.csv") for name in LOOPS["pin"]],
    )
    pitch = 2.0 * math.pi / drawn.ring.teeth
    fits = {
        f"{math.degrees(share * pitch):.4g}, crank": cm.calibrate(drawn, loops, RUBBING, crank=share * pitch)
        for share in QUARTERS
    }
    first = next(iter(fits.values()))
    fits["0, output"] = cm.calibrate(drawn, loops, RUBBING, "output")
    rows: dict[str, Any] = {}
    for held, calibration in fits.items():
        content, ends = calibration.as_json(), stops(Reducer(calibration.design), calibration.fitted.condition.crank)
        rows[held] = {
            "parameters": content["parameters"],
            "play": math.degrees(ends[1] - ends[0]),
            "shares": [loop["residual_share"] for loop in content["loops"]],
        }
    losses = [
        {"meaning": variant.meaning, "shares": list(variant.shares), "values": variant.values}
        for variant in compare_losses(first).variants
    ]
    return {"held": rows, "losses": losses}


def preload_study() -> dict[str, dict[str, float | None]]:
    """Compute play [deg], friction [N m] and stiffness [N m/rad] of the nonpin drive by preload of its ring [arcmin].

    Friction is that at the output, by statics and by a run; that of a run is None without preload.
    """
    import cycloid_mj as cm
    from cycloid_mj.dynamics.planar.model import planar_model
    from cycloid_mj.figures import figure
    from cycloid_mj.reducer import Reducer

    rows: dict[str, dict[str, float | None]] = {}
    for arcmin in PRELOADS:
        halves = {"kind": "nonpin", "halves": 2, "preload": math.radians(arcmin / 60.0)}
        reducer = Reducer(cm.load("printed").but(ring=halves, load={"torque": 0.0}, friction=COULOMB))
        ratio = reducer.design.reduction
        run = reducer.steady(SETTLED, TURNS, settings={"log_rate": 2000.0})
        ran = cm.simulate(run.design, planar_model(run)) if arcmin else None
        rows[f"{arcmin:g}"] = {
            "play": figure("backlash_arcmin").value(reducer) / 60.0,
            "friction": ratio * figure("no_load_torque_nm").value(reducer),
            "friction of a run": ratio * float(ran["crank_torque"][ran.time > SETTLED].mean()) if ran else None,
            "stiffness": figure("stiffness_nm_per_arcmin").value(reducer) * 60.0 * math.degrees(1.0),
        }
    return rows


def format_sections(content: Mapping[str, Any]) -> dict[str, str]:
    """Return the generated sections of the page in Markdown, by name."""
    return {
        "figures": format_figures(content),
        "fit": format_fits(content),
        "models": format_models(content),
        "parts": format_compliances(content),
        "losses": format_losses(content),
        "preload": format_preload(content),
    }


def format_figures(content: Mapping[str, Any]) -> str:
    """Tabulate the figures of both drives in Markdown: stated by the authors, measured, and fitted or predicted."""
    head = ("Value", *("Baseline, " + name for name in ("stated by authors", "measured", "fitted")))
    head += tuple("Twin, " + name for name in ("stated by authors", "measured", "predicted"))
    pin, nonpin = (content[kind] for kind in LOOPS)
    rows = []
    for key, label in FIGURES.items():
        stated = AUTHORS[key]
        fitted, predicted = _number(pin["model"][key]["value"]), _number(nonpin["predicted"][key])
        measured = [_interval(drive["measured"][key]) for drive in (pin, nonpin)]
        rows.append((label, stated[0], measured[0], fitted, stated[1], measured[1], predicted))
    shares = zip(("play loop", "stiffness loop"), pin["predicted_shares"], nonpin["predicted_shares"], strict=True)
    rows += (
        (f"rms error of the {loop}, relative to its height", "", "", f"{fit:.1%}", "", "", f"{twin:.1%}")
        for loop, fit, twin in shares
    )
    return markdown_table(head, rows)


def format_fits(content: Mapping[str, Any]) -> str:
    """Tabulate the fitted values of both drives, and the residual of each fit, in Markdown."""
    pin, nonpin = (content[kind] for kind in LOOPS)
    rows: list[tuple[str, ...]] = [
        (f"`{key}` [{parameter['unit']}]", _estimate(parameter), _estimate(nonpin["parameters"][key]))
        for key, parameter in pin["parameters"].items()
    ]
    for name, key in (("with", "shares"), ("without", "shares_without_offset")):
        for loop, *shares in zip(("play loop", "stiffness loop"), pin[key], nonpin[key], strict=True):
            rows.append((f"relative rms error of the {loop}, {name} torque offset", *map("{:.1%}".format, shares)))
    return markdown_table(("Fitted value", "Baseline (95 % interval)", "Twin (95 % interval)"), rows)


def format_models(content: Mapping[str, Any]) -> str:
    """Tabulate the residual of each candidate model for both drives, and its criterion, in Markdown."""
    head = ("Friction model", "Baseline: rms errors", "Baseline: BIC", "Twin: rms errors", "Twin: BIC")
    both = [content[kind]["models"] for kind in LOOPS]
    rows = []
    for pair in zip(*both, strict=True):
        cells = [pair[0]["meaning"]]
        for one, models in zip(pair, both, strict=True):
            above = one["bic"] - min(other["bic"] for other in models)
            cells += [" and ".join(f"{share:.1%}" for share in one["residual_shares"]), f"{above:+.0f}"]
        rows.append(tuple(cells))
    return markdown_table(head, rows)


def format_compliances(content: Mapping[str, Any]) -> str:
    """Tabulate the compliance of each part by finite elements, and their stiffness together, in Markdown."""
    drives = [content[kind] for kind in LOOPS]
    rows = [
        (label, *(_number(1e3 * drive["parts"][key]) if key in drive["parts"] else "" for drive in drives))
        for key, label in PARTS.items()
    ]
    rows.append(("sum", *(_number(1e3 * sum(drive["parts"].values())) for drive in drives)))
    stiffness = [{"value": 1.0 / sum(drive["parts"].values()), "ci95": drive["interval"]} for drive in drives]
    rows.append(("predicted stiffness (for the limits of the modulus) [N m/rad]", *map(_interval, stiffness)))
    return markdown_table(
        ("Rotation of the output per torque [mrad/(N m)]", "With ring pins", "With internal gear"), rows
    )


def format_losses(content: Mapping[str, Any]) -> str:
    """Tabulate the residual of each kind of losses, in Markdown."""
    names = {"friction": "friction", "material_loss": "material loss"}
    rows = []
    for losses in content["rubbing"]["losses"]:
        values = [f"{name} {losses['values'][key]:.2g}" for key, name in names.items() if key in losses["values"]]
        rows.append((losses["meaning"], ", ".join(values), *map("{:.1%}".format, losses["shares"])))
    return markdown_table(
        ("Losses in the model", "Fitted coefficients", "Rms error, small loop", "Rms error, large loop"), rows
    )


def format_preload(content: Mapping[str, Any]) -> str:
    """Tabulate play, friction and stiffness over the preload, a column for each angle, in Markdown."""
    rows = content["preload"]
    names = {
        "play": ("play [deg]", ".3f"),
        "friction": ("friction at the output, by statics [N m]", ".2f"),
        "friction of a run": ("friction at the output, simulated [N m]", ".2f"),
        "stiffness": ("stiffness [N m/rad]", ".0f"),
    }
    lines = [
        (label, *("" if (value := row[key]) is None else format(value, form) for row in rows.values()))
        for key, (label, form) in names.items()
    ]
    return markdown_table(("Preload [arcmin]", *rows), lines)


def _number(value: float) -> str:
    return f"{value:.3g}" if abs(value) < 1e3 else f"{value:.0f}"


def _interval(fitted: Mapping[str, Any]) -> str:
    low, high = fitted["ci95"]
    return f"{_number(fitted['value'])} ({_number(low)} to {_number(high)})"


def _estimate(fitted: Mapping[str, Any]) -> str:
    return _interval(fitted) + ("" if fitted["identified"] else ": not identified")


def main(arguments: Sequence[str]) -> int:
    """Compute the results if requested, write the page, and return the exit code."""
    if "--fit" in arguments:
        kept = json.loads(KEPT.read_text(encoding="utf-8"))
        again = {} if "--quick" in arguments else {"rubbing": fit_contact_friction()}
        KEPT.write_text(json.dumps(kept | fit_drives() | again, indent=1) + "\n", encoding="utf-8")
    content = json.loads(KEPT.read_text(encoding="utf-8"))
    PAGE.write_text(
        replace_sections(PAGE.read_text(encoding="utf-8"), format_sections(content), SCRIPT), encoding="utf-8"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
