"""Wear of RV reducers: doses against the power of friction, and worn flanks against the closed form of lost motion."""

import numpy as np
import pytest

from cycloid_mj.design import PRESETS, override
from cycloid_mj.life.accuracy_life import wear
from cycloid_mj.life.duty import constant_duty
from cycloid_mj.life.wear_course import WearingDrive
from cycloid_mj.life.wearing_surfaces import TABLE
from cycloid_mj.reducer import RvReducer
from cycloid_mj.reducer.worn import WornGaps
from cycloid_mj.statics.rv_sheet import friction_powers, lost_motion

LOAD = 784.0


@pytest.mark.parametrize("name", ["rv80e", pytest.param("rv64", marks=pytest.mark.slow)])
def test_dose_of_the_flanks_is_the_power_of_friction_over_its_coefficient(name: str) -> None:
    """Pressure times speed, summed over the surface, is force times speed: mu times it is the friction power."""
    reducer = RvReducer(PRESETS[name].but(friction={"law": "coulomb"}))
    load = reducer.design.load.torque
    drive = WearingDrive(reducer, constant_duty(load, reducer.design.drive.speed).points)
    (surface,) = (item for item in drive.surfaces if item.key == "flank")
    area = surface.count * surface.section * surface.length
    power = area * float(drive.dose_rates(reducer)[surface.key].mean())
    assert reducer.design.mesh_friction * power == pytest.approx(friction_powers(reducer, load)["teeth"], rel=5e-3)


def test_with_film_friction_flanks_and_sockets_share_the_sliding() -> None:
    """The dose times the area of flanks and sockets together is that of the pins, which slide on one of both."""
    reducer = RvReducer(PRESETS["rv80e"])
    drive = WearingDrive(reducer, constant_duty(LOAD, reducer.design.drive.speed).points)
    rates = drive.dose_rates(reducer)
    power = {
        item.key: item.count * item.section * item.length * float(rates[item.key].mean()) for item in drive.surfaces
    }
    assert power["flank"] + power["socket"] == pytest.approx(power["pin"], rel=1e-9)
    assert min(power.values()) > 0.0


def test_evenly_worn_flanks_add_their_depth_to_the_lost_motion() -> None:
    """The output turns by 2 h/(e (lobes + 1 + z_s/z_p)) more, as by a clearance h along the normals of the flanks."""
    design = override(
        PRESETS["rv80e"],
        [
            *("cranks.needle_stiffness_n_m=1e11", "cranks.taper_stiffness_n_m=1e11", "planet.mesh_stiffness_n_m=1e12"),
            *("stiffness.pin_gear_n_m=1e10", "stiffness.pin_socket_n_m=1e10"),
        ],
    )
    depth = 1e-6
    worn = WornGaps(np.full(TABLE, depth), np.zeros(TABLE), 0.0)
    new, old = (lost_motion(item, LOAD) for item in (RvReducer(design), RvReducer(design, worn)))
    turns = design.lobes + 1.0 + design.planet.sun_teeth / design.planet.planet_teeth
    assert old - new == pytest.approx(2.0 * depth / (design.gear.eccentricity * turns), rel=0.02)


@pytest.mark.slow
def test_records_have_the_figures_of_statics_for_worn_parts() -> None:
    result = wear(PRESETS["rv80e"].but(friction={"law": "coulomb"}), 20.0, growth=0.2)
    names = [key for key, _ in result.columns]
    first, *_, last = (dict(zip(names, row, strict=True)) for row in result.records)
    assert first["stiffness_nm_arcmin"] == pytest.approx(208.0, rel=2e-3)
    assert last["lost_motion_arcmin"] == pytest.approx(first["lost_motion_arcmin"] * 1.2, rel=0.05)
    assert last["flank_depth_um"] > last["pin_depth_um"] > 0.0
