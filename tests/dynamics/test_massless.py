"""Massless pins: the statics of real ones exactly, their loaded means nearly, and nothing else."""

from types import SimpleNamespace

import mujoco
import numpy as np
import pytest
from designs import cases, unlike

from cycloid_mj.analysis.transmission import output_error
from cycloid_mj.base.errors import CycloidWarning, DesignError
from cycloid_mj.base.powers import mean_powers
from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS, Design
from cycloid_mj.dynamics.contact.collider import install
from cycloid_mj.dynamics.contact.gap import flank_distance, trochoid_curvature
from cycloid_mj.dynamics.contact.teeth import teeth_of
from cycloid_mj.dynamics.massless import assumptions, massless, require_pin_bodies
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.measure import bench, efficiency_map
from cycloid_mj.measure.conditions import STEADY
from cycloid_mj.measure.steady import run_steady, steady_design
from cycloid_mj.reducer import Reducer
from cycloid_mj.scene.pose import poses
from cycloid_mj.statics import transmission_error

PIN = PRESETS["pin"]
MOVING = {"pin": PIN, **{name: unlike(name) for name in ("few", "teeth21", "large")}}


def loaded(design: Design, **settings: float) -> Design:
    """Return a design at its rated torque, ready for a steady run."""
    own = Reducer(design).at_rated_load
    return steady_design(own.but(load={"torque": own.design.rated_torque}, settings=settings)).design


@pytest.mark.parametrize("name", MOVING)
def test_a_pin_of_any_kind_has_one_without_inertia(name):
    design = MOVING[name]
    light = massless(Reducer(design))
    assert light.design.ring.has_massless_pins
    assert not light.design.ring.has_pin_bodies
    assert (light.design.pin_play, light.design.socket_play) == (design.pin_play, design.socket_play)
    assert light.design.pair_kinds == design.pair_kinds
    assert massless(light) == light
    model = build(light.design).model
    assert (model.nbody, model.nv) == (5, 5)


@pytest.mark.parametrize("name", ["light", "printed"])
def test_designs_without_moving_pins_are_unchanged(name):
    assert massless(Reducer(unlike(name))) == Reducer(unlike(name))


@pytest.mark.parametrize("name", MOVING)
def test_at_rest_they_carry_as_pins_and_seats_in_series(name):
    """Without friction a locked crank finds the balance of the linear mesh, which has plays and springs in series."""
    design = massless(bench.without_friction(Reducer(MOVING[name]).at_rated_load))
    torque, still = 0.5 * design.design.rated_torque, design.but(drive={"speed": 0.0})
    for crank in bench.crank_angles(design, 2):
        run = bench.run_with_step_retries(
            design, float(crank), lambda time: np.full_like(time, torque), torque, 0.04, 4
        )
        turned = output_error(run, design)[-1]
        assert turned == pytest.approx(transmission_error(still, crank, torque)[0, 1], rel=2e-3)


@pytest.mark.slow
def test_contact_stiffness_follows_curvature_as_two_springs():
    """Each contact of a turned gear: force over true overlap, beside both springs at the curvature there."""
    design = massless(Reducer(PIN.but(contact={"working_load": 36.68})))
    compiled = build(design.design)
    data = mujoco.MjData(compiled.model)
    data.joint("gear_angle").qpos[0] = 2e-4
    with install():
        mujoco.mj_forward(compiled.model, data)
    law, seat, rho = (
        design.contacts.teeth.curvature_law,
        design.contacts["pin_socket"].stiffness,
        design.design.ring.pin_radius,
    )
    flank = teeth_of(compiled.model.geom("teeth").user).flank
    teeth, turned = compiled.model.geom("teeth").id, data.joint("gear_angle").qpos[0]
    to_gear = np.array([[np.cos(turned), np.sin(turned)], [-np.sin(turned), np.cos(turned)]])
    factors = []
    for geoms, distance in zip(data.contact.geom, data.contact.dist, strict=True):
        if teeth not in geoms:
            continue
        place = data.geom_xpos[next(geom for geom in geoms if geom != teeth)] - data.geom_xpos[teeth]
        t, away, *_ = flank_distance(*(to_gear @ place[:2]), flank)
        bend = trochoid_curvature(t, flank.curve)
        own = law.stiffness * law.factor(bend / (1.0 - flank.offset * bend) + 1.0 / rho)
        overlap = rho - design.design.pin_play - away - flank.offset
        force = -distance * compiled.laws["pin_gear"].stiffness
        assert force == pytest.approx(overlap / (1.0 / own + 1.0 / seat), rel=1e-6)
        factors.append(own / law.stiffness)
    assert len(factors) > 10
    assert max(factors) > 1.5 * min(factors)


@pytest.mark.parametrize("name", cases(["pin", "large"], "pin"))
def test_loaded_means_of_massless_pins_match_real_pins(name):
    """At steps that no real pin bears the means are the same."""
    real = Reducer(loaded(MOVING[name]))
    light = massless(real).but(settings={"timestep": 1e-5})
    found = []
    for reducer in (real, light):
        run = run_steady(reducer, STEADY.settling_time, 3)
        error = run["output_angle"] + run["crank_angle"] / reducer.design.lobes
        cam = np.hypot(run["cam_force_x"], run["cam_force_y"])
        found.append((error.mean(), cam.mean(), mean_powers(run).efficiency))
    (error, cam, efficiency), (light_error, light_cam, light_efficiency) = found
    assert light_error == pytest.approx(error, rel=3e-3)
    assert light_cam == pytest.approx(cam, rel=2e-3)
    assert light_efficiency == pytest.approx(efficiency, abs=1e-3)


def test_contact_with_less_friction_slides():
    rough = massless(Reducer(unlike("large"))).but(friction={"pin_gear": 0.2, "pin_sleeve": 0.04})
    ring = rough.design.ring
    law = build(rough.design).laws["pin_gear"]
    assert law.friction == pytest.approx(0.04 * ring.sleeve_bore_radius / ring.pin_radius)


def test_a_thicker_pin_has_less_play_in_its_socket():
    thick = massless(Reducer(PIN)).but(errors={"pin_dr": (0.4e-6,) + (0.0,) * 35})
    model = build(thick.design).model
    plays = [model.geom(f"pin_{number}").user[2] for number in (1, 2)]
    assert plays == pytest.approx([0.6e-6, 1e-6])


def test_without_load_a_run_warns_and_dynamic_figures_are_refused(capsys):
    light = massless(Reducer(PIN))
    with pytest.warns(CycloidWarning, match="massless pins, which are valid under load only"):
        simulate(light.but(drive={"ramp": 0.0, "hold": 1e-4}, settings={"timestep": 1e-5}).design)
    with pytest.raises(DesignError, match=r'vibration. Set ring.pins = "free"'):
        require_pin_bodies(light, "vibration")
    require_pin_bodies(Reducer(PIN), "vibration")
    for command in (("measure", "vibration", "--design", "pin"), ("compare", "pin", "nonpin", "--workers", "1")):
        assert main([*command, "--set", 'ring.pins="massless"']) == 1
        assert "valid only for averages over a crank turn under load" in capsys.readouterr().err


def test_pins_are_drawn_where_the_gear_presses_them():
    light = massless(Reducer(PIN))
    columns = {name: np.zeros(1) for name in ("crank_angle", "gear_x", "gear_y", "gear_angle", "output_angle")}
    columns |= {"pin_1_force_x": np.array([3.0]), "pin_1_force_y": np.array([-4.0])}
    place = poses(light, columns)
    home = poses(Reducer(PIN), columns)
    assert (place["pin_1"] - home["pin_1"])[0] == pytest.approx([-0.6e-6, 0.8e-6, 0.0])
    assert np.array_equal(place["pin_2"], home["pin_2"])


def test_a_measure_states_its_use_of_massless_pins(monkeypatch):
    """The map and the varied inputs of a design with moving pins, but not its rated point; of others nothing."""
    seen = []

    def steady_run(reducer, settled, periods, solver):
        seen.append(reducer.design.ring.pins)
        raise StopIteration

    monkeypatch.setattr(efficiency_map, "run_steady", steady_run)
    monkeypatch.setattr(efficiency_map, "break_away", lambda reducer, solver: SimpleNamespace(is_locked=True))

    def tried(tasks, progress):
        for key, task in tasks.items():
            with pytest.raises(StopIteration):
                task()
            seen[-1] = (key, seen[-1])
        raise InterruptedError

    monkeypatch.setattr(efficiency_map, "all_in_threads", tried)
    for design in (PIN, PIN.but(ring={"pins": "fixed"})):
        with pytest.raises(InterruptedError):
            efficiency_map.run_map(
                steady_design(Reducer(design)), [10.0, 36.68], [design.drive.speed], 4, True, None, "planar"
            )
    pins = dict(seen[: len(seen) // 2 + 1])
    assert pins["rated"] == pins["halved"] == pins["unloaded"] == "free"
    assert pins[36.68, PIN.drive.speed] == pins[10.0, PIN.drive.speed] == pins[0.02] == "massless"
    assert dict(seen)["rated"] == "fixed"
    assert "are massless" in assumptions(Reducer(PIN), "the map")[0]
    assert assumptions(Reducer(PIN.but(ring={"pins": "fixed"})), "the map") == ()
