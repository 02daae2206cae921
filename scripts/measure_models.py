"""Measure what the READMEs of models/ compare with the models: plain CoACD, mesh and profile contact, free running.

Takes ten minutes; writes plain_coacd.json, agreement.json and free_running.json into models/, which
scripts/build_models.py reads. With names of these files as arguments, only those.
"""

import json
import sys
import time
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from build_models import MODELLED

from cycloid_mj.analysis import analyze
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.dynamics.mjcf.folder import SCENE, quality_um
from cycloid_mj.dynamics.run import Contact, reducer_model, schedule, simulate
from cycloid_mj.parts.convex import CoacdSettings, plain_gear, plain_ring
from cycloid_mj.reducer import Reducer

MODELS = Path(__file__).parent.parent / "models"
RUNS: tuple[tuple[Contact, float], ...] = (("profile", 1.0), ("mesh", 2.0), ("mesh", 5.0))
"""Kinds of contact with their time steps [us]; at 10 us the free pins are unstable under 36 N m."""

HOLD, SETTLED = 0.057, 0.02
"""Duration of a run, and of what is left out at its start [s]; the rest is a turn of the crank."""

FREE_RUN, KEYFRAME = 0.2, "1640rpm_0"


def plain() -> dict[str, dict[str, Any]]:
    """Decompose the toothed parts by CoACD without slices; return their deviations along the true normals."""
    figures = {}
    for threshold in (0.05, 0.02):
        settings = CoacdSettings(threshold=threshold)
        gear, ring = plain_gear(Reducer(PRESETS["pin"]), settings), plain_ring(Reducer(PRESETS["nonpin"]), settings)
        figures[f"gear teeth, plain CoACD at threshold {threshold:g}"] = quality_um(gear.quality)
        figures[f"internal gear, plain CoACD at threshold {threshold:g}"] = quality_um(ring.quality)
    return figures


def agreement() -> list[dict[str, Any]]:
    """Run both designs at both loads by each kind of contact; return means over the last turn of the crank."""
    return [_run(name, load, *how) for name in MODELLED for load in (1.0, 36.0) for how in RUNS]


def _run(name: str, load: float, contact: Contact, timestep_us: float) -> dict[str, Any]:
    """Simulate a preset under a load [N m] with a kind of contact; return its mean figures and its cost."""
    changes = ("drive.ramp_s=0.0", f"drive.hold_s={HOLD}", f"load.torque_nm={load}")
    design = override(PRESETS[name], [*changes, f"settings.timestep_us={timestep_us}"])
    compiled = reducer_model(Reducer(design), contact)
    start = time.process_time()
    run = simulate(design, compiled)
    seconds = time.process_time() - start
    findings = analyze(run, settle=SETTLED)
    settled, speed = run.select(run.time >= SETTLED), findings.gear_speed
    return {
        **{"design": name, "load_nm": load, "contact": contact, "timestep_us": timestep_us},
        "gear_transmission_error_arcsec": round(findings.gear_transmission_error.mean_arcsec, 2),
        "output_transmission_error_arcsec": round(findings.output_transmission_error.mean_arcsec, 2),
        "gear_speed_rms_error_percent": round(100.0 * speed.rms_error_rad_s / abs(speed.theory_rad_s), 3),
        "crank_torque_nm": round(findings.power.crank_torque_nm, 4),
        "cam_force_n": round(float(np.mean(np.hypot(settled["cam_force_x"], settled["cam_force_y"]))), 1),
        "us_per_step": round(1e6 * seconds / schedule(Reducer(design)).steps, 1),
    }


def free_running() -> dict[str, dict[str, float]]:
    """Run the models of both folders without load from a keyframe at full speed; compare the gear's speed."""
    return {name: _free_run(MODELS / name / SCENE, PRESETS[name]) for name in MODELLED}


def _free_run(scene: Path, design: Design) -> dict[str, float]:
    """Simulate a model folder without load from a keyframe; return errors of the gear's speed, and warnings."""
    model = mujoco.MjModel.from_xml_path(str(scene))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key(KEYFRAME).id)
    mujoco.mj_forward(model, data)
    gear, expected, errors = data.sensor("gear_speed").data, float(data.sensor("gear_speed").data[0]), []
    for _ in range(round(FREE_RUN / model.opt.timestep)):
        mujoco.mj_step(model, data)
        errors.append(100.0 * (gear[0] / expected - 1.0))
    period = round(2.0 * np.pi / (design.ring.teeth * design.drive.speed * model.opt.timestep))
    smooth = np.convolve(errors, np.full(period, 1.0 / period), mode="valid")
    return {
        "duration_s": FREE_RUN,
        "mean_error_percent": round(float(np.mean(errors)), 4),
        "largest_mesh_period_error_percent": round(float(np.abs(smooth).max()), 2),
        "rms_error_percent": round(float(np.sqrt(np.mean(np.square(errors)))), 2),
        "peak_error_percent": round(float(np.abs(errors).max()), 2),
        "warnings": sum(int(warning.number) for warning in data.warning),
    }


MEASURES = {"agreement.json": agreement, "free_running.json": free_running, "plain_coacd.json": plain}


def main(arguments: list[str]) -> int:
    """Measure all models and write the results as JSON files; return the exit code."""
    if set(arguments) - set(MEASURES):
        print(__doc__, file=sys.stderr)
        return 2
    for name in arguments or MEASURES:
        (MODELS / name).write_text(json.dumps(MEASURES[name](), indent=2) + "\n", encoding="utf-8")
        print(MODELS / name, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
