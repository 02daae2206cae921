"""Make the folders models/pin, models/nonpin, models/twodisc and models/rv80e with their READMEs, byte for byte.

With --pictures, the pictures are rendered, too (OpenGL off-screen is needed; their bytes depend on the machine). The
figures of other methods in the READMEs are measured by scripts/measure_models.py.
"""

import json
import sys
from pathlib import Path
from typing import Any

from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.dynamics.mjcf.folder import MANIFEST, SCENE, model_files, write_folder
from cycloid_mj.parts.convex import ConvexSettings
from cycloid_mj.reducer import Reducer, RvReducer

MODELS = Path(__file__).parent.parent / "models"
README = Path(__file__).with_name("model_readme.md")
OVERVIEW = Path(__file__).with_name("models_readme.md")
PLAIN, AGREEMENT, FREE = "plain_coacd.json", "agreement.json", "free_running.json"
TWO_DISCS = Path(__file__).with_name("model_twodisc_readme.md")
COARSE = ConvexSettings(chord_error=1e-6)
"""Of models/twodisc: half as many slices for each of its discs."""

RV_README = Path(__file__).with_name("model_rv80e_readme.md")
RV_CHANGES = ("ring.pins=fixed", "clearance.pin_gear_um=1", "friction.law=coulomb")
"""Changes of the preset rv80e for its folder: fixed pins cost less, slices are less accurate than its clearance, and
MuJoCo alone has no film friction."""

STEPS_US = {"pin": 2.0, "nonpin": 5.0, "twodisc": 5.0, "rv80e": 5.0}
"""Time step of each preset's folder [us]: free pins need the shorter, for at 5 us they add what friction takes."""

MODELLED = ("pin", "nonpin")
"""Presets whose folder has a README of its own kind."""


def at_step(name: str) -> Design:
    """Look up a preset, with the time step of its folder."""
    return override(PRESETS[name], [f"settings.timestep_us={STEPS_US[name]}"])


def two_discs() -> Design:
    """Return the design of models/twodisc, with fixed friction coefficients: MuJoCo alone has no film friction."""
    return override(at_step("twodisc"), ["friction.law=coulomb"])


def two_disc_files() -> dict[str, bytes]:
    """Collect every file of models/twodisc, with its README."""
    generated = model_files(Reducer(two_discs()), COARSE)
    return {**generated, "README.md": format_two_disc_readme(json.loads(generated[MANIFEST])).encode()}


def format_two_disc_readme(manifest: dict[str, Any]) -> str:
    """Return the README of models/twodisc, filled with the values of its manifest."""
    rows = [
        f"| {name} | {figures['parts']} | {figures['max_overfill_um']:.3g} | {figures['max_underfill_um']:.3g} |"
        for name, figures in manifest["surfaces"].items()
    ]
    return TWO_DISCS.read_text(encoding="utf-8").format(
        rows="\n".join(rows),
        spacing=1e3 * two_discs().gear.disc_spacing,
        chord=1e6 * COARSE.chord_error,
        finer=1e6 * ConvexSettings().chord_error,
        geoms=manifest["geoms"],
        step=1e6 * manifest["timestep_s"],
        mujoco=manifest["versions"]["mujoco"],
    )


def rv_design() -> Design:
    """Return the design of models/rv80e."""
    return override(at_step("rv80e"), RV_CHANGES)


def rv_files() -> dict[str, bytes]:
    """Collect every file of models/rv80e but its picture, with its README."""
    generated = model_files(RvReducer(rv_design()))
    manifest = json.loads(generated[MANIFEST])
    text = RV_README.read_text(encoding="utf-8").format(
        chord=1e6 * ConvexSettings().chord_error,
        geoms=manifest["geoms"],
        step=1e6 * manifest["timestep_s"],
        mujoco=manifest["versions"]["mujoco"],
    )
    return {**generated, "README.md": text.encode()}


def files(name: str, design: Design, plain: dict[str, dict[str, Any]]) -> dict[str, bytes]:
    """Collect every generated file of one model folder but its picture."""
    generated = model_files(Reducer(design))
    return {**generated, "README.md": format_readme(name, json.loads(generated[MANIFEST]), plain).encode()}


def format_readme(name: str, manifest: dict[str, Any], plain: dict[str, dict[str, Any]]) -> str:
    """Return the README of a model's folder from its manifest and the deviations of plain CoACD, by part."""
    ring = "free pins in a pinwheel" if name == "pin" else "a double-enveloping internal gear"
    surfaces = {key: value for key, value in manifest["surfaces"].items() if key in ("teeth", "lobe")}
    titles = {"teeth": "gear teeth, sliced (this model)", "lobe": "internal gear, sliced (this model)"}
    rows = [_row(titles[key], value) for key, value in surfaces.items()]
    rows += [_row(title, value) for title, value in plain.items() if title.startswith("gear") or name == "nonpin"]
    bearings = "\n".join(
        f"- {key}: {value['parts']} pieces, {value['max_underfill_um']:.3g} um"
        for key, value in manifest["surfaces"].items()
        if key not in surfaces
    )
    return README.read_text(encoding="utf-8").format(
        name=name,
        ring=ring,
        rows="\n".join(rows),
        bearings=bearings,
        geoms=manifest["geoms"],
        step=1e6 * manifest["timestep_s"],
        mujoco=manifest["versions"]["mujoco"],
    )


def _row(title: str, figures: dict[str, Any]) -> str:
    keys = ("max_overfill_um", "rms_overfill_um", "max_underfill_um", "rms_underfill_um")
    lengths = " | ".join(f"{figures[key]:.3g}" if figures[key] < 1000 else f"{figures[key]:.0f}" for key in keys)
    return f"| {title} | {figures['parts']} | {lengths} | {100 * figures['volume_error']:.2g} % |"


def read_measurements(name: str) -> Any:
    """Read a file of results of scripts/measure_models.py."""
    return json.loads((MODELS / name).read_text(encoding="utf-8"))


def format_overview(manifests: dict[str, dict[str, Any]]) -> str:
    """Return the README of models/ from the manifests of all models and the kept measurements."""
    plain, rows, free = (read_measurements(name) for name in (PLAIN, AGREEMENT, FREE))
    sliced = {
        "gear teeth, sliced": manifests["pin"]["surfaces"]["teeth"],
        "internal gear, sliced": manifests["nonpin"]["surfaces"]["lobe"],
    }
    return OVERVIEW.read_text(encoding="utf-8").format(
        rows="\n".join(_row(title, figures) for title, figures in {**sliced, **plain}.items()),
        agreement="\n".join(_format_run(row) for row in rows),
        ratios=_format_ratios(rows),
        free="\n".join(_free_row(name, row) for name, row in free.items()),
        force=round(Reducer(PRESETS["pin"]).at_rated_load.contacts["pin_gear"].force),
    )


def _format_run(row: dict[str, Any]) -> str:
    """Return a measured run as a row of a Markdown table."""
    cells = (
        row["design"],
        f"{row['load_nm']:g} N m",
        row["contact"],
        f"{row['timestep_us']:g}",
        f"{row['gear_transmission_error_arcsec']:.2f}",
        f"{row['output_transmission_error_arcsec']:.2f}",
        f"{row['cam_force_n']:.1f}",
        f"{row['crank_torque_nm']:.4f}",
        f"{row['gear_speed_rms_error_percent']:.2f} %",
        str(row["us_per_step"]),
    )
    return f"| {' | '.join(cells)} |"


def _free_row(name: str, run: dict[str, float]) -> str:
    """Return a free run as a row of the table."""
    keys = ("mean_error", "largest_mesh_period_error", "rms_error", "peak_error")
    errors = [f"{run[f'{key}_percent']:g} %" for key in keys]
    return f"| {' | '.join([name, *errors, str(run['warnings'])])} |"


def _format_ratios(rows: list[dict[str, Any]]) -> str:
    """Return a sentence on how much slower mesh contact is than exact contact, per step and per simulated second."""
    lines = []
    for name in MODELLED:
        mesh, exact = (
            [row["us_per_step"] for row in rows if (row["design"], row["contact"]) == (name, contact)]
            for contact in ("mesh", "profile")
        )
        lines.append(f"{sum(mesh) / len(mesh) / (sum(exact) / len(exact)):.0f} times as long for {name}")
    return (
        f"A step takes {' and '.join(lines)} with mesh contact.\n"
        "A simulated second takes half of that factor, with steps of 2 us instead of 1 us."
    )


def render(folder: Path) -> None:
    """Render a model as images next to it: from the input side, obliquely, and from the output side."""
    import mujoco
    import numpy as np
    from PIL import Image

    from cycloid_mj.scene.render import render_model

    model = mujoco.MjModel.from_xml_path(str(folder / SCENE))
    data, camera = mujoco.MjData(model), mujoco.MjvCamera()
    mujoco.mj_resetDataKeyframe(model, data, model.key("rest_90").id)
    mujoco.mj_forward(model, data)
    camera.type = mujoco.mjtCamera.mjCAMERA_FIXED
    views = []
    for name in ("oblique", "output_side"):
        camera.fixedcamid = model.camera(name).id
        views.append(render_model(model, data, camera, (720, 600)))
    Image.fromarray(np.hstack(views)).save(folder / "picture.png", optimize=True)


def write_model(name: str, contents: dict[str, bytes]) -> Path:
    """Write the files of a model into its folder, whose previous content is removed; return the folder."""
    folder = MODELS / name
    folder.mkdir(exist_ok=True)
    for stale in {str(path.relative_to(folder)) for path in folder.glob("assets/*")} - set(contents):
        (folder / stale).unlink()
    write_folder(contents, folder)
    return folder


def main(arguments: list[str]) -> int:
    """Build both model folders and the README above them; return the exit code."""
    if set(arguments) - {"--pictures"}:
        print(__doc__, file=sys.stderr)
        return 2
    plain = read_measurements(PLAIN)
    manifests = {}
    print(write_model("twodisc", two_disc_files()))
    folder = write_model("rv80e", rv_files())
    if "--pictures" in arguments:
        render(folder)
    print(folder)
    for name in MODELLED:
        generated = files(name, at_step(name), plain)
        folder = write_model(name, generated)
        manifests[name] = json.loads(generated[MANIFEST])
        if "--pictures" in arguments:
            render(folder)
        print(folder)
    (MODELS / "README.md").write_text(format_overview(manifests), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
