"""Make the folders models/pin and models/nonpin with their READMEs, byte for byte.

With --plain, plain CoACD is measured again for the READMEs (ten minutes); with --pictures, the pictures are rendered
(OpenGL off-screen is needed; their bytes depend on the machine).
"""

import json
import sys
from pathlib import Path
from typing import Any

from cycloid_mj.convex import CoacdSettings, plain_gear, plain_ring
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.mjcf.folder import MANIFEST, SCENE, model_files, quality_um, write_folder

MODELS = Path(__file__).parent.parent / "models"
README = Path(__file__).with_name("model_readme.md")
PLAIN = "plain_coacd.json"
THRESHOLDS = (0.05, 0.02)
STEP = "settings.timestep_us=5.0"
"""At half of it, means of transmission error, torque and cam force differ by less than 1 %."""


def designs() -> dict[str, Design]:
    """Give the designs that models are made of."""
    return {name: override(design, [STEP]) for name, design in PRESETS.items()}


def files(name: str, design: Design, plain: dict[str, dict[str, Any]]) -> dict[str, bytes]:
    """Give every generated file of one model folder but its picture."""
    made = model_files(design)
    return {**made, "README.md": readme(name, json.loads(made[MANIFEST]), plain).encode()}


def readme(name: str, manifest: dict[str, Any], plain: dict[str, dict[str, Any]]) -> str:
    """Give the README of a model folder from its manifest and the figures of plain CoACD."""
    ring = "free pins in a pinwheel" if name == "pin" else "a double-enveloping internal gear"
    surfaces = {key: value for key, value in manifest["surfaces"].items() if key in ("teeth", "lobe")}
    titles = {"teeth": "gear teeth, sliced (this model)", "lobe": "internal gear, sliced (this model)"}
    rows = [_row(titles[key], value) for key, value in surfaces.items()]
    rows += [_row(title, value) for title, value in plain.items() if title.startswith("gear") or name == "nonpin"]
    bearings = ", ".join(
        f"{key} {value['parts']} ({value['max_underfill_um']:.3g} um at the corners)"
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


def measure_plain() -> dict[str, dict[str, Any]]:
    """Let CoACD cut the toothed parts whole, and measure it along the true normals."""
    found = {}
    for threshold in THRESHOLDS:
        settings = CoacdSettings(threshold=threshold)
        gear, ring = plain_gear(PRESETS["pin"], settings), plain_ring(PRESETS["nonpin"], settings)
        found[f"gear teeth, plain CoACD at threshold {threshold:g}"] = quality_um(gear.quality)
        found[f"internal gear, plain CoACD at threshold {threshold:g}"] = quality_um(ring.quality)
    return found


def render(folder: Path) -> None:
    """Render a model from its input side, obliquely, and from its output side."""
    import mujoco
    import numpy as np
    from PIL import Image

    from cycloid_mj.scene.opengl import opengl

    model = mujoco.MjModel.from_xml_path(str(folder / SCENE))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("rest_90").id)
    mujoco.mj_forward(model, data)
    scene, camera, frame = mujoco.MjvScene(model, model.ngeom), mujoco.MjvCamera(), mujoco.MjrRect(0, 0, 720, 600)
    camera.type = mujoco.mjtCamera.mjCAMERA_FIXED
    views = []
    with opengl(model, frame.width, frame.height) as context:
        for name in ("oblique", "output_side"):
            camera.fixedcamid = model.camera(name).id
            everything = mujoco.mjtCatBit.mjCAT_ALL
            mujoco.mjv_updateScene(model, data, mujoco.MjvOption(), None, camera, everything, scene)
            mujoco.mjr_render(frame, scene, context)
            pixels = np.empty((frame.height, frame.width, 3), np.uint8)
            mujoco.mjr_readPixels(pixels, None, frame, context)
            views.append(pixels[::-1])
    Image.fromarray(np.hstack(views)).save(folder / "picture.png", optimize=True)


def main(arguments: list[str]) -> int:
    """Make both folders."""
    unknown = set(arguments) - {"--plain", "--pictures"}
    if unknown:
        print(__doc__, file=sys.stderr)
        return 2
    MODELS.mkdir(exist_ok=True)
    if "--plain" in arguments:
        (MODELS / PLAIN).write_text(json.dumps(measure_plain(), indent=2) + "\n", encoding="utf-8")
    plain = json.loads((MODELS / PLAIN).read_text(encoding="utf-8"))
    for name, design in designs().items():
        folder = MODELS / name
        folder.mkdir(exist_ok=True)
        write_folder(files(name, design, plain), folder)
        if "--pictures" in arguments:
            render(folder)
        print(folder)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
