"""The same design is the same model and the same run, whatever the number of threads and the order of sums."""

import hashlib
import os
import subprocess
import sys

import numpy as np
import pytest
from designs import UNLIKE, unlike

from cycloid_mj.base.array import on_grid, significant, significant_tensor
from cycloid_mj.design import PRESETS, Design
from cycloid_mj.dynamics.mjcf import build, xml
from cycloid_mj.parts import mass_properties, parts
from cycloid_mj.parts.polygon import area_moments
from cycloid_mj.reducer import Reducer, reducer_of

RUN = """
import hashlib, sys
from cycloid_mj.design import PRESETS, override
from cycloid_mj.dynamics.run import simulate
found = hashlib.sha256()
for preset in ("pin", "nonpin", "rv80e"):
    changes = ["drive.ramp_s=0", "drive.hold_s=0.001", "load.torque_nm=10", "load.rise_s=0.0005"]
    run = simulate(override(PRESETS[preset], changes))
    found.update(run.attachments["model.xml"])
    for name in run.columns:
        found.update(name.encode() + run[name].tobytes())
sys.stdout.write(found.hexdigest())
"""
"""Free pins without a ramp rattle from the first step on: a last bit anywhere would be seen."""


@pytest.mark.slow
def test_a_run_is_the_same_bit_for_bit_with_any_number_of_threads() -> None:
    found = []
    for threads in ("1", "2"):
        own = os.environ | {"OPENBLAS_NUM_THREADS": threads, "OMP_NUM_THREADS": threads, "MKL_NUM_THREADS": threads}
        done = subprocess.run([sys.executable, "-c", RUN], env=own, capture_output=True, text=True, check=True)
        found.append(done.stdout)
    assert len(found[0]) == len(hashlib.sha256().hexdigest())
    assert found[0] == found[1]


def test_moments_do_not_depend_on_where_a_polygon_begins() -> None:
    polygon = parts(Reducer(PRESETS["pin"]))["gear"].prisms[0].outline
    first = area_moments(polygon)
    for shift in (1, 1000, 12345):
        assert area_moments(np.roll(polygon, shift, axis=0)) == first


@pytest.mark.parametrize("design", [*PRESETS.values(), *map(unlike, UNLIKE)], ids=lambda one: one.name)
def test_derived_numbers_have_only_significant_digits(design: Design) -> None:
    for name, solid in parts(reducer_of(design)).items():
        made = mass_properties(solid)
        assert made.mass == float(f"{made.mass:.12g}"), name
        assert np.array_equal(made.inertia, significant_tensor(made.inertia)), name
        assert np.array_equal(made.centroid, on_grid(made.centroid)), name
    compiled = build(design)
    for pair in compiled.spec.pairs:
        numbers = [*pair.solref, pair.solreffriction[1], *pair.solimp]
        assert [one for one in numbers if one != float(f"{one:.12g}")] == [], pair.name


def test_parts_are_drawn_once_for_all_loads_but_not_for_another_shape() -> None:
    drawn = parts(Reducer(PRESETS["pin"]))
    assert parts(Reducer(PRESETS["pin"].but(load={"torque": 36.0}, name="loaded")))["gear"] is drawn["gear"]
    for change in (
        {"material": {"density": 7800.0}},
        {"clearance": {"pin_gear": 2e-6}},
        {"gear": {"bore_radius": 0.014}},
    ):
        other = parts(Reducer(PRESETS["pin"].but(**change)))["gear"]
        assert mass_properties(other).mass != mass_properties(drawn["gear"]).mass
    drawn.clear()
    assert parts(Reducer(PRESETS["pin"]))


def test_rounding_of_a_mass_does_not_change_the_model(monkeypatch: pytest.MonkeyPatch) -> None:
    """What another machine or another number of threads would give: sums that differ by some last bits."""
    expected = xml(build(PRESETS["nonpin"]).spec)
    from cycloid_mj.parts import inertia
    from cycloid_mj.reducer import reducer

    monkeypatch.setattr(reducer, "_cache_of", lambda design: {})  # nothing is kept of the reducer as it is
    moments = inertia.area_moments
    monkeypatch.setattr(
        inertia, "area_moments", lambda polygon: type(moments(polygon))(*(2e-16 * m + m for m in moments(polygon)))
    )
    inertia.mass_properties.cache_clear()
    assert xml(build(PRESETS["nonpin"]).spec) == expected
    assert inertia.mass_properties.cache_info().misses


def test_rounding() -> None:
    assert significant(-177317621.06893986) == significant(-177317621.06893998) == -177317621.069
    assert significant(0.0) == 0.0
    assert significant_tensor([1.23456789012345e-3, 1e-19]).tolist() == [1.23456789012e-3, 0.0]
    assert significant_tensor([0.0, 0.0]).tolist() == [0.0, 0.0]
    assert on_grid([0.04, 4.99e-18, -1e-17]).tolist() == [0.04, 0.0, 0.0]
    assert str(on_grid([-1e-17])[0]) == "0.0"
