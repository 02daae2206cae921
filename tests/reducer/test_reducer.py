"""The mechanism as a value: its bodies, its surfaces and its pairs; and the model and the gaps that follow from it."""

import gc
import math
import weakref

import mujoco
import numpy as np
import pytest
from designs import UNLIKE, unlike

from cycloid_mj.base import names
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.dynamics.contact.collider import install
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.mjcf.keyframe import joint_state
from cycloid_mj.geometry.deviations import deviations
from cycloid_mj.reducer import Reducer, bodies, gaps, reducer
from cycloid_mj.reducer.bodies import build_mechanism

VARIANTS = {
    "pin": PRESETS["pin"],
    "nonpin": PRESETS["nonpin"],
    "fixed": override(PRESETS["pin"], ['ring.pins="fixed"']),
    "sleeved": override(PRESETS["pin"], ['ring.pins="sleeved"']),
    **{name: unlike(name) for name in UNLIKE},
}


def three_discs(design: Design) -> Design:
    """Put three discs on the crank: unlike two, no multiple of half a pitch apart, so that no sign can hide."""
    return override(design, ["gear.discs=3"])


def contacts(design: Design, crank: float) -> tuple[mujoco.MjModel, int]:
    """Model of a design and the number of contacts with every part where the ideal mesh has it."""
    model = build(design).model
    data = mujoco.MjData(model)
    for joint, value in joint_state(Reducer(design), crank, 0.0)[0].items():
        data.joint(joint).qpos[0] = value
    with install(design.ring.kind == "nonpin"):
        mujoco.mj_forward(model, data)
    return model, data.ncon


@pytest.mark.parametrize("name", sorted(VARIANTS))
def test_every_gap_belongs_to_a_pair(name: str) -> None:
    design = VARIANTS[name]
    found = gaps.arc_gaps(Reducer(design), 0.3)
    rows = list(zip(found.kind.tolist(), found.owner.tolist(), found.disc.tolist(), strict=True))
    pairs = [(one.kind, one.owner, one.disc) for one in build_mechanism(design).pairs if one.kind in set(found.kind)]
    assert rows == pairs


@pytest.mark.parametrize("name", sorted(VARIANTS))
def test_names_are_unique_and_mates_are_surfaces(name: str) -> None:
    made = build_mechanism(VARIANTS[name])
    names = [pair.name for pair in made.pairs]
    assert len(set(names)) == len(names)
    assert {side for pair in made.pairs for side in (pair.on, pair.by)} == set(made.carriers)
    assert set(made.carriers.values()) <= {body.name for body in made.bodies}


@pytest.mark.parametrize("kind", ["pin", "nonpin"])
def test_more_discs_are_more_bodies_and_more_pairs(kind: str) -> None:
    """Their teeth, holes and cams are where the ring, the output and the crank have room for them."""
    single, _ = contacts(PRESETS[kind], 0.7)
    design = three_discs(PRESETS[kind])
    model, touching = contacts(design, 0.7)
    assert touching == 0
    assert model.nbody == single.nbody + 2
    assert model.npair == single.npair + 2 * (design.ring.teeth + 1 + design.output.pins)
    assert {"gear_1", "gear_2", "gear_3"} <= {model.body(i).name for i in range(model.nbody)}
    assert model.pair("gear_2_cam") is not None


@pytest.mark.parametrize("discs", [1, 2, 3, 4])
def test_discs_are_next_to_each_other_between_the_ends_of_pins_and_ring(discs: int) -> None:
    """Along z each disc is as wide as its own surfaces; what spans all discs reaches from the first to the last."""
    design = override(PRESETS["pin"], [f"gear.discs={discs}", "gear.disc_gap_mm=3.0"])
    model = build(design).model
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    width = discs * 10e-3 + (discs - 1) * 3e-3
    for disc, gear in enumerate(names.gears(discs)):
        for surface in ("teeth", "bore", "cam", "hole_5"):
            geom = model.geom(names.of_disc(surface, disc, discs)).id
            assert data.geom_xpos[geom, 2] == pytest.approx(disc * 13e-3 + 5e-3 - width / 2, abs=1e-15)
            assert model.geom_size[geom, 1] == pytest.approx(5e-3, rel=1e-12)
        assert data.body(gear).xpos[2] == pytest.approx(disc * 13e-3 + 5e-3 - width / 2, abs=1e-15)
    for surface in ("pin_3", "socket_3", "output_pin_2"):
        geom = model.geom(surface).id
        assert data.geom_xpos[geom, 2] == 0.0
        assert 2.0 * model.geom_size[geom, 1] == pytest.approx(width, rel=1e-12)


def test_a_disc_on_the_wrong_phase_is_in_the_ring(monkeypatch: pytest.MonkeyPatch) -> None:
    design = three_discs(PRESETS["pin"])
    turned = build_mechanism(design).mating("pin_gear", 1).on.angle[0]
    assert turned == pytest.approx(2.0 * math.pi / 3.0 / design.lobes)
    original = bodies.tooth_mating

    def spoiled(*args: object) -> bodies.Mating:
        mating = original(*args)  # type: ignore[arg-type]
        teeth = bodies.Surfaces(**(vars(mating.on) | {"angle": -mating.on.angle}))
        return bodies.Mating(mating.kind, mating.names, teeth, mating.by, mating.disc)

    monkeypatch.setattr(bodies, "tooth_mating", spoiled)
    monkeypatch.setattr(reducer, "_cache_of", lambda design: {})  # nothing is kept of the reducer as it is
    _, touching = contacts(design, 0.7)
    assert touching > 0


@pytest.mark.parametrize("pins", ["free", "fixed", "sleeved", "massless"])
def test_clearances_and_errors_are_in_places_and_radii(pins: str) -> None:
    errors = ["errors.pin_position_um=1.0", "errors.pin_radius_um=0.5", "errors.hole_position_um=1.0"]
    more = [
        "errors.eccentricity_um=3.0",
        "clearance.cam_um=2.0",
        "clearance.output_um=3.0",
        "clearance.pin_socket_um=4.0",
    ]
    design = override(PRESETS["pin"], [*errors, *more, "clearance.pin_sleeve_um=5.0", f'ring.pins="{pins}"'])
    wrong, made, ring = deviations(design), build_mechanism(design), design.ring
    angle = 2.0 * np.pi * np.arange(ring.teeth) / ring.teeth
    home = ring.pin_circle_radius * np.stack([np.sin(angle), np.cos(angle)], axis=1) + wrong.pin_displacement
    mesh = made.mating("pin_gear")
    np.testing.assert_allclose(mesh.by.radius, 2.25e-3 + wrong.pin_radius, rtol=1e-14)
    if made.pins:
        np.testing.assert_allclose([pin.position for pin in made.pins], home, rtol=0.0, atol=1e-17)
        assert not mesh.by.position.any()
    else:
        np.testing.assert_allclose(mesh.by.position, home, rtol=0.0, atol=1e-17)
    assert mesh.on.radius[0] > ring.pin_circle_radius + design.gear.eccentricity + wrong.largest
    np.testing.assert_allclose(mesh.by.play, 4e-6 - wrong.pin_radius if pins == "massless" else 0.0, atol=1e-18)
    if pins == "free":
        seats = made.mating("pin_socket").by
        np.testing.assert_allclose(seats.radius, 2.254e-3, rtol=1e-14)
        np.testing.assert_allclose(seats.position, home, rtol=0.0, atol=1e-17)
    if pins == "sleeved":
        sleeves = made.mating("pin_sleeve")
        np.testing.assert_allclose(sleeves.on.radius, 1.5e-3, rtol=1e-14)
        np.testing.assert_allclose(sleeves.by.radius, 1.495e-3, rtol=1e-14)
    cam, holes = made.mating("cam"), made.mating("output")
    np.testing.assert_allclose(cam.by.position, [[0.0, 1.003e-3]], rtol=0.0, atol=1e-17)
    np.testing.assert_allclose([cam.by.radius[0], cam.on.radius[0]], [15e-3, 15.002e-3], rtol=1e-14)
    turned = 2.0 * np.pi * np.arange(design.output.pins) / design.output.pins
    circle = design.output.pin_circle_radius * np.stack([np.sin(turned), np.cos(turned)], axis=1)
    np.testing.assert_allclose(holes.on.position, circle + wrong.hole_displacement[0], rtol=0.0, atol=1e-17)
    np.testing.assert_allclose(holes.by.position, circle, rtol=0.0, atol=1e-17)
    np.testing.assert_allclose([holes.on.radius[0], holes.by.radius[0]], [5.003e-3, 4e-3], rtol=1e-14)


@pytest.mark.parametrize("name", UNLIKE)
def test_geometry_is_computed_once_for_all_loads_and_speeds(name: str) -> None:
    # of a name of its own: what a design keeps may outlive, by the order of tests, what is kept of its shape
    design = Reducer(unlike(name).but(name="own"))
    other = design.but(load={"torque": 3.0}, drive={"speed": 7.0}, environment={"gravity_y": 0.0})
    assert other != design
    for key in ("phases", "tooth_profile", "gear_profile", "profile_offset", "share", "mesh_turn"):
        assert getattr(other, key) == getattr(design, key)
    assert other.tooth_profile is design.tooth_profile
    wider = design.but(gear={"eccentricity": 1.01 * design.design.gear.eccentricity})
    assert wider.tooth_profile.eccentricity == 1.01 * design.tooth_profile.eccentricity


@pytest.mark.parametrize("name", UNLIKE)
def test_in_a_turn_of_the_mesh_the_crank_passes_the_ring_once(name: str) -> None:
    design = unlike(name)
    assert float(Reducer(design).member.against_ring(Reducer(design).mesh_turn)) == pytest.approx(
        2.0 * math.pi, rel=1e-15
    )


def test_cached_values_are_released_when_other_designs_are_used() -> None:
    """Without the garbage collector, which comes late: nothing that is kept on a reducer leads back to it."""
    design = VARIANTS["pin"].but(name="kept")
    gc.disable()
    try:
        one = Reducer(design)
        assert one.shape.shape.mechanism
        assert one.at_rated_load.at_rated_load.mechanism
        kept = [weakref.ref(found.mechanism) for found in (one, one.shape, one.at_rated_load)]
        del one
        assert all(found() is not None for found in kept)
        for number in range(2 * reducer.CACHED_DESIGNS):
            assert Reducer(VARIANTS["nonpin"].but(name=f"other-{number}")).shape.share
        assert [found() for found in kept] == [None] * 3
    finally:
        gc.enable()
