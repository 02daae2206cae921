"""The force at which contacts have their secant stiffness follows from the load, and every measure states one law."""

import math

import numpy as np
import pytest

from cycloid_mj.base.errors import ContactError
from cycloid_mj.design import PRESETS, override
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.run import provenance
from cycloid_mj.geometry import ideal_loads
from cycloid_mj.geometry.modification import tooth_profile
from cycloid_mj.parts import gear_solid, mass_properties
from cycloid_mj.reducer import Reducer

PIN, NONPIN = PRESETS["pin"], PRESETS["nonpin"]
RATED = 36.68


def loaded(torque, *changes):
    return override(PIN, [f"load.torque_nm={torque!r}", *changes])


def test_working_forces_are_shares_of_the_load():
    design = loaded(RATED)
    gear, crank = tooth_profile(design), np.linspace(0.0, 2 * np.pi, 720, endpoint=False)
    ring = ideal_loads.ideal_load_sharing(gear, RATED, crank)
    output = ideal_loads.ideal_output_forces(gear, 8, 26e-3, RATED, crank)
    cam = np.linalg.norm(ideal_loads.cam_force(ring, output, crank), axis=1)
    for kind in ("pin_gear", "pin_socket"):
        assert Reducer(design).contacts[kind].force == pytest.approx(ring.forces.max(axis=1).mean(), rel=0.01)
    # the most loaded of eight output pins bears 4 T/(n R) where it stands across the eccentric
    assert Reducer(design).contacts["output"].force == pytest.approx(output.max(), rel=0.01)
    assert Reducer(design).contacts["cam"].force == pytest.approx(cam.mean(), rel=2e-3)
    # far from the 100 N that all pairs had: the drive is stiffer by the logarithm of that
    assert Reducer(design).contacts["output"].force > 600.0
    assert Reducer(design).contacts["cam"].force > 1300.0


def test_contacts_stiffen_with_the_load():
    at = {torque: Reducer(loaded(torque)).contacts["output"].stiffness for torque in (9.17, RATED)}
    before = Reducer(loaded(RATED, "contact.working_force_n=100")).contacts["output"].stiffness
    assert at[9.17] < at[RATED]
    assert before < at[RATED]
    # the compliance falls by the logarithm of the force: E* L pi (1/K1 - 1/K2) = ln 4, but for the doubled limit
    modulus = ideal_loads.contact_modulus(210e9, 0.28)
    flat = {torque: Reducer(loaded(torque)).contacts["pin_gear"].stiffness for torque in at}
    assert math.pi * modulus * 10e-3 * (1 / flat[9.17] - 1 / flat[RATED]) == pytest.approx(math.log(4.0), rel=1e-9)


def test_without_load_the_gears_own_forces_work():
    mass = mass_properties(gear_solid(Reducer(PIN))).mass
    force = mass * (9.8 + 1e-3 * PIN.drive.speed**2)
    assert Reducer(PIN).contacts.own_load == pytest.approx(force * 35e-3, rel=0.01)
    assert Reducer(PIN).contacts.working_load == Reducer(PIN).contacts.own_load
    assert {Reducer(PIN).contacts[kind].source for kind in ("pin_gear", "cam")} == {"weight and inertia"}
    # a load below that does not soften the contacts further, whatever its sign
    assert Reducer(loaded(0.1)).contacts.working_load == Reducer(PIN).contacts.own_load
    assert Reducer(loaded(-RATED)).contacts.working_load == RATED


def test_stated_values_have_priority():
    given = loaded(RATED, "contact.working_force_n=100", "working_force.output_n=300", "contact.working_load_nm=5")
    assert (Reducer(given).contacts["pin_gear"].force, Reducer(given).contacts["output"].force) == (100.0, 300.0)
    assert Reducer(given).contacts["output"].source == "given"
    one = loaded(RATED, "contact.working_load_nm=5")
    assert Reducer(one).contacts.working_load == 5.0
    assert Reducer(one).contacts["cam"].source == "working load"
    assert Reducer(given).working_at(20.0) == Reducer(given)
    assert Reducer(loaded(RATED)).working_at(20.0).contacts.working_load == 20.0


def test_an_unloaded_design_works_at_the_rated_load():
    assert Reducer(PIN).at_rated_load.contacts.working_load == pytest.approx(RATED)
    assert Reducer(loaded(10.0)).at_rated_load.contacts.working_load == 10.0


def test_the_reducer_at_the_rated_load_is_cached():
    """A rating uses it some 80 times, and validated a design each time."""
    reducer = Reducer(loaded(10.0))
    assert reducer.at_rated_load is reducer.at_rated_load
    assert reducer.at_rated_load.at_rated_load is reducer.at_rated_load


@pytest.mark.parametrize("design", [PIN, NONPIN, loaded(RATED), override(NONPIN, ["working_force.cam_n=900"])])
def test_a_run_states_its_working_forces(design):
    told = provenance(Reducer(design))["working_forces"]
    kinds = ("tooth",) if design.ring.kind == "nonpin" else ("pin_gear", "pin_socket")
    assert told == Reducer(design).contacts.working_forces_text([*kinds, "cam", "output"])
    assert ("weight and inertia" in told) == (design.load.torque == 0.0)
    assert ("given" in told) == bool(design.working_force.cam)


def test_the_model_has_the_stiffness_of_its_load():
    idle, busy = (build(loaded(torque)).laws for torque in (0.0, RATED))
    assert all(busy[kind].stiffness > idle[kind].stiffness for kind in busy)


def test_a_load_beyond_a_line_contact_is_reported_by_its_key():
    with pytest.raises(ContactError, match=r"^load\.torque_nm \(a working load of 1e\+05 N m\) is too large: "):
        assert Reducer(loaded(1e5, "gear.face_width_mm=0.1")).contacts["output"].stiffness
