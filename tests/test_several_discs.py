"""Two and more discs in motion: contact by profiles and by meshes, logs, figures, pictures, files of each disc."""

from collections import Counter
from typing import Any

import mujoco
import numpy as np
import pytest

from cycloid_mj import names
from cycloid_mj.course import initial_state, load_torque, servo_target
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.kinematics import CrankLaw
from cycloid_mj.mjcf import build
from cycloid_mj.mjcf.mesh import build_mesh
from cycloid_mj.run import simulate

CASE_K = [
    *("ring.teeth=30", "ring.pin_circle_radius_mm=52.5", "ring.pin_radius_mm=3.5", "ring.pins=fixed"),
    *("gear.discs=2", "gear.disc_gap_mm=3", "gear.face_width_mm=13.5", "gear.eccentricity_mm=1.250025"),
    *("gear.bore_radius_mm=20", "shaft.radius_mm=12", "housing.outer_radius_mm=65"),
    *("output.pins=4", "output.pin_radius_mm=6", "output.pin_circle_radius_mm=34", "output.hole_radius_mm=7.250025"),
    *("drive.speed_rpm=100", "drive.ramp_s=0", "load.torque_nm=116", "load.rise_s=0.002"),
    *("settings.timestep_us=5", "settings.log_rate_hz=5000"),
]
"""Its ring, discs and output (29:1, 58 N m a disc) on a crank of our own, with pressed-in pins, which cost little."""


def case_k(*changes: str) -> Design:
    return override(PRESETS["pin"], [*CASE_K, *changes])


def stems(model: Any) -> list[str]:
    return [model.geom(i).name.split("/")[0] for i in range(model.ngeom)]


def test_meshes_of_two_discs_meet_their_own_mates_and_press_as_profiles_do() -> None:
    """No cap of a cam reaches the next disc's bore; forces of every disc are within 5 % of those of profile contact."""
    design = case_k("drive.hold_s=0.006")
    mesh = build_mesh(design)
    data, surfaces, met = mujoco.MjData(mesh.model), stems(mesh.model), Counter[frozenset[str]]()
    data.qvel[:] = initial_state(mesh, design).qvel
    law = CrankLaw(design.drive.speed, 0.0)
    for step in range(500):
        now = np.array([step * mesh.model.opt.timestep])
        data.ctrl[0], data.ctrl[1] = servo_target(mesh, law, now)[0], load_torque(design, now)[0]
        mujoco.mj_step(mesh.model, data)
        met.update(frozenset(surfaces[geom] for geom in data.contact[i].geom) for i in range(data.ncon))
    mating = {frozenset((pair.on, pair.by)): pair.name for pair in mesh.pairs}
    assert set(met) <= set(mating)
    assert {names.kind_of(mating[pair]) for pair in met} == {"pin_gear", "cam", "output"}
    assert {names.disc_of(mating[pair]) for pair in met} == {0, 1}
    runs = [simulate(design, reducer) for reducer in (mesh, build(design))]
    for kind in ("cam", "output"):
        sliced, exact = (np.linalg.norm(run.forces(kind)[-8:], axis=2).max(axis=0) for run in runs)
        pressed = exact > 100.0
        np.testing.assert_allclose(sliced[pressed], exact[pressed], rtol=0.05)
