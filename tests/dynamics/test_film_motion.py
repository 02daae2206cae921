"""The friction law ``film`` in both solvers of motion, against statics."""

from itertools import product

import numpy as np
import pytest

from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.units import RPM
from cycloid_mj.design import resolve
from cycloid_mj.dynamics.film_table import CAM, OUTPUT, SEAT, TABLE, TEETH, film_table
from cycloid_mj.dynamics.mjcf.mesh import build_mesh
from cycloid_mj.dynamics.run import Solver
from cycloid_mj.measure.efficiency_map import run_forward
from cycloid_mj.measure.steady import steady_design
from cycloid_mj.reducer import Reducer, reducer_of
from cycloid_mj.statics.sheet import shaft_powers
from cycloid_mj.statics.springs import springs_of

TOLERANCE = 0.2
"""Points of efficiency."""


def lubricated(*changes: str, name: str = "pin", at: float = 20.0) -> Reducer:
    """Return a preset with the law ``film`` at a temperature [°C]."""
    parts = [f"thermal.{part}_c={at}" for part in ("disc", "ring", "crank", "output")] if at != 20.0 else []
    return reducer_of(resolve(name, ["friction.law=film", *parts, *changes]))


def difference(reducer: Reducer, torque: float, rpm: float, solver: Solver) -> float:
    """Return the efficiency of a run less that of statics [points]."""
    steady = steady_design(reducer)
    loaded = steady.but(drive={"speed": rpm * RPM}, load={"torque": torque})
    run = run_forward(steady, torque, rpm * RPM, 12, solver)
    return 100.0 * (run.powers.efficiency - shaft_powers(loaded, torque).efficiency)


@pytest.mark.parametrize("pins", ["free", "fixed"])
@pytest.mark.parametrize(("torque", "rpm", "at"), [(36.68, 1640.0, 20.0), (9.2, 1640.0, 40.0), (18.3, 820.0, 60.0)])
def test_planar_solver_agrees_with_statics(pins: str, torque: float, rpm: float, at: float) -> None:
    assert abs(difference(lubricated(f"ring.pins={pins}", at=at), torque, rpm, "planar")) < TOLERANCE


@pytest.mark.parametrize("pins", ["free", "fixed"])
def test_mujoco_agrees_with_statics(pins: str) -> None:
    assert abs(difference(lubricated(f"ring.pins={pins}"), 36.68, 1640.0, "mujoco")) < TOLERANCE


TEMPERATURES = (20.0, 40.0, 60.0)
CONDITIONS = [
    *product(("pin",), ("free", "fixed"), (9.2, 18.3, 36.68), (400.0, 820.0, 1640.0), TEMPERATURES),
    *product(("twodisc",), ("free", "fixed"), (29.0, 58.0, 116.0), (150.0, 300.0, 600.0), TEMPERATURES),
]
"""Preset, pins, torque [N m], speed [rpm] and temperature [°C]."""


@pytest.mark.slow
@pytest.mark.parametrize(("name", "pins", "torque", "rpm", "at"), CONDITIONS)
@pytest.mark.parametrize("solver", ["planar", "mujoco"])
def test_solvers_agree_with_statics(solver: Solver, name: str, pins: str, torque: float, rpm: float, at: float) -> None:
    assert abs(difference(lubricated(f"ring.pins={pins}", name=name, at=at), torque, rpm, solver)) < TOLERANCE


@pytest.mark.slow
@pytest.mark.parametrize("pins", ["free", "fixed"])
@pytest.mark.parametrize(("torque", "rpm", "at"), [(784.0, 2295.0, 20.0), (392.0, 1147.0, 40.0), (78.4, 2295.0, 60.0)])
def test_mujoco_agrees_with_statics_for_rv_reducers(pins: str, torque: float, rpm: float, at: float) -> None:
    assert abs(difference(lubricated(f"ring.pins={pins}", name="rv80e", at=at), torque, rpm, "mujoco")) < TOLERANCE


@pytest.mark.parametrize(("pins", "torque"), [("free", 5.2), ("free", 10.4), ("fixed", 1.0), ("fixed", 5.2)])
def test_planar_solver_agrees_with_statics_for_printed_drives(pins: str, torque: float) -> None:
    assert abs(difference(lubricated(f"ring.pins={pins}", name="printed"), torque, 60.0, "planar")) < TOLERANCE


@pytest.mark.parametrize(
    "changes",
    [
        ("ring.pins=massless",),
        ("output.rollers=false",),
        ("ring.kind=nonpin",),
        ("gear.bearing=plain",),
        ("gear.bearing=plain", "clearance.cam_um=25"),
    ],
    ids=["massless pins", "output pins without rollers", "internal gear", "dry plain cam", "plain cam with a film"],
)
def test_planar_solver_agrees_with_statics_for_other_contacts(changes: tuple[str, ...]) -> None:
    assert abs(difference(lubricated(*changes, at=40.0), 36.68, 1640.0, "planar")) < TOLERANCE


def test_table_has_the_coefficients_of_statics() -> None:
    reducer = lubricated("ring.pins=fixed", "output.rollers=false")
    table, springs = film_table(reducer), springs_of(reducer, [0.0])
    assert springs.film is not None
    row = 25
    force = TABLE.least * (TABLE.most / TABLE.least) ** (row / (TABLE.forces - 1))
    phases = 2.0 * np.pi * np.arange(36) / 36
    teeth, output = np.full((1, 36), force), np.full((1, springs.film.studs), force)
    friction = springs.film.friction(teeth, output, np.full((1, 1), force))
    at = np.linspace(0.0, np.pi, TABLE.phases)
    found = np.interp(np.arccos(np.cos(phases)), at, table[TEETH, :, row])
    assert friction.teeth.coefficient[0] == pytest.approx(found, rel=0.02)
    assert friction.contacts[0, -1] == pytest.approx(table[OUTPUT, 0, row])
    assert friction.cam == pytest.approx(table[CAM, 0, row])
    assert not np.any(table[SEAT])


def test_coulomb_has_no_table() -> None:
    assert film_table(Reducer(resolve("pin"))).size == 0


def test_contact_by_meshes_is_refused() -> None:
    with pytest.raises(DesignError, match=r"friction\.law"):
        build_mesh(lubricated())
