"""The contact law IMPACT in runs: every contact bears what the law says of its depth and speed; friction goes on."""

import mujoco
import numpy as np
import pytest

from cycloid_mj.base.errors import DesignError
from cycloid_mj.design import PRESETS, override
from cycloid_mj.dynamics.contact import collider, each_step
from cycloid_mj.dynamics.contact.each_step import EachStep
from cycloid_mj.dynamics.contact.forces import pair_index
from cycloid_mj.dynamics.drive_cycle import initial_state
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.run import model_for, reducer_model, simulate
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.impact import ImpactLaw, damper, spring

IMPACT = ('contact.law="impact"', "settings.timestep_us=1", "drive.ramp_s=0", "drive.hold_s=0.0004")


@pytest.mark.parametrize("preset", ["pin", "nonpin"])
def test_contact_forces_follow_the_contact_law(preset):
    design = override(PRESETS[preset], IMPACT)
    law = Reducer(design).contacts.impact
    assert law is not None
    reduced = build(design)
    index = pair_index(reduced.model, reduced.pairs)
    data = initial_state(reduced, Reducer(design))
    # the gear aside and turned: teeth, cam and holes overlap by some um, and close with some mm/s
    data.joint("gear_x").qpos[0] += 12e-6
    data.joint("gear_x").qvel[0] += 0.05
    step = EachStep(reduced.model, data, index, impacts=[law] * len(reduced.pairs))
    step.command(np.array([data.ctrl]))
    with collider.install(), each_step.install():
        step.advance(1)
    row = [contact.efc_address for contact in data.contact if contact.efc_address >= 0]
    depth, closing = -data.efc_pos[row], -data.efc_vel[row]
    deep = depth > 3e-6
    assert np.count_nonzero(deep) > 5
    wanted = law.stiffness * depth**law.exponent + [damper(d, law.damping, law.depth) for d in depth] * closing
    found = data.efc_force[row]
    # the added mass takes next to nothing, and no contact pulls
    assert found[deep] == pytest.approx(np.maximum(wanted[deep], 0.0), rel=0.01, abs=0.01)
    assert (found >= 0.0).all()


def test_a_run_without_the_law_is_left_as_it_is():
    model = build(PRESETS["pin"]).model
    assert model.nsensor == build(override(PRESETS["pin"], IMPACT)).model.nsensor - 1
    assert mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, each_step.IMPACT_SENSOR) == -1


def test_the_parameters_are_those_of_the_file():
    law = Reducer(override(PRESETS["pin"], ['contact.law="impact"'])).contacts.impact
    assert law is not None
    assert spring(1e-3, law.stiffness, law.exponent) == pytest.approx(1e5)
    assert damper(1e-3, law.damping, law.depth) == pytest.approx(1e4)
    assert damper(0.5e-4, law.damping, law.depth) == pytest.approx(5e3)
    assert (spring(-1e-6, law.stiffness, law.exponent), damper(0.0, law.damping, law.depth)) == (0.0, 0.0)
    other = Reducer(override(PRESETS["pin"], ['contact.law="impact"', "contact.impact_exponent=1.5"])).contacts.impact
    assert other is not None
    assert spring(1e-3, other.stiffness, other.exponent) == pytest.approx(1e5)
    assert Reducer(PRESETS["pin"]).contacts.impact is None


def test_two_contacts_in_series_share_the_depth():
    law = ImpactLaw(3e11, 2.2, 1e4, 1e-4)
    both = law.in_series()
    assert both.depth_under(50.0) == pytest.approx(2.0 * law.depth_under(50.0))
    assert both.damping_ratio(50.0, 0.1) == pytest.approx(law.damping_ratio(50.0, 0.1) / 2.0**0.5)
    assert damper(8e-5, both.damping, both.depth) == pytest.approx(0.5 * damper(4e-5, law.damping, law.depth))
    design = override(PRESETS["pin"], ['contact.law="impact"', 'ring.pins="massless"'])
    found, seat = Reducer(design).contacts["pin_gear"].impact, Reducer(design).contacts["cam"].impact
    assert found is not None
    assert seat is not None
    assert found == seat.in_series()


def test_elsewhere_the_law_is_its_secant_at_the_working_force():
    design = override(PRESETS["pin"], ['contact.law="impact"', "load.torque_nm=36.68"])
    law = Reducer(design).contacts.impact
    assert law is not None
    for kind in design.pair_kinds:
        force = Reducer(design).contacts[kind].force
        assert Reducer(design).contacts[kind].stiffness * law.depth_under(force) == pytest.approx(force)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ("stiffness.cam_n_m=1e8", "stiffness.cam_n_m"),
        ("damping.cam=0.3", "damping.cam"),
        ("contact.stiffness_n_m=1e8", "contact.stiffness_n_m"),
        ('structure="springs"', "structure"),
    ],
)
def test_a_second_law_is_refused(change, named):
    with pytest.raises(DesignError, match=named):
        override(PRESETS["pin"], ['contact.law="impact"', change])


def test_the_impact_law_is_refused_for_meshes():
    with pytest.raises(DesignError, match="--contact profile"):
        reducer_model(Reducer(override(PRESETS["nonpin"], IMPACT)), "mesh")


@pytest.mark.parametrize(("preset", "pins"), [("pin", "massless"), ("nonpin", "free")])
def test_energy_of_a_loaded_run_is_conserved_by_both_solvers(preset, pins):
    changes = (f'ring.pins="{pins}"',) if preset == "pin" else ()
    design = override(
        PRESETS[preset], (*IMPACT, *changes, "load.torque_nm=20", "load.rise_s=0.002", "drive.hold_s=0.006")
    )
    found = {}
    for solver in ("planar", "mujoco"):
        run = simulate(design, model_for(solver, Reducer(design)))
        assert run.provenance["solver"] == solver
        late = run.time > 0.004
        cam = np.hypot(run["cam_force_x"], run["cam_force_y"])
        signals = (run["crank_torque"], run["load_torque"], cam, run["penetration"])
        found[solver] = [abs(signal[late].mean()) for signal in signals]
        crank, load, _, depth = found[solver]
        assert load == pytest.approx(20.0, rel=1e-3)
        # friction takes its share: the crank's torque is more than that without losses, by less than a quarter
        assert 20.0 / 35.0 < crank < 1.25 * 20.0 / 35.0
        assert depth > 20e-6
    assert found["planar"] == pytest.approx(found["mujoco"], rel=1e-3)
