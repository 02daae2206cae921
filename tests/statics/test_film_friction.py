"""The friction law ``film`` in statics: limits of mixed friction, the reducers of the paper, and intervals."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from cycloid_mj.base.errors import CycloidWarning, DesignError, UsageError
from cycloid_mj.design import resolve
from cycloid_mj.design.lubricants import lubricant
from cycloid_mj.figures import quantity, values_json
from cycloid_mj.figures.film_map import compute_film_map, map_tables
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.surface_speeds import entrainment_zeros
from cycloid_mj.lubrication.mixed import FilmLaw, asperity_share, journal_friction, line_friction
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics import film_spread
from cycloid_mj.statics.balance import Loads, friction_losses, loads, powers
from cycloid_mj.statics.film import DESIGN_INPUTS, FilmInputs, drag_torques, film_law
from cycloid_mj.statics.sheet import sampled_efficiency
from cycloid_mj.statics.springs import Springs, springs_of

LOAD = 36.68
OIL = FilmLaw(viscosity=0.087, pressure_coefficient=2e-8, roughness=0.4e-6, boundary=0.11)


def lubricated(*changes: str, name: str = "pin", at: float = 20.0) -> Reducer:
    """Return a preset with the law ``film`` at a temperature [°C], under the load."""
    parts = [f"thermal.{part}_c={at}" for part in ("disc", "ring", "crank", "output")] if at != 20.0 else []
    return Reducer(resolve(name, ["friction.law=film", f"load.torque_nm={LOAD}", *parts, *changes]))


def balanced(reducer: Reducer, inputs: FilmInputs = DESIGN_INPUTS) -> tuple[Springs, Loads]:
    """Return springs and loads of a reducer under its load."""
    springs = springs_of(reducer)
    assert springs.film is not None
    film = replace(springs.film, surfaces=replace(springs.film.surfaces, inputs=inputs))
    springs = replace(springs, film=film)
    return springs, loads(reducer, springs, LOAD, warm_start=True)


def efficiency(reducer: Reducer) -> float:
    """Return the efficiency under the load [%]."""
    return 100.0 * powers(reducer, LOAD).efficiency


def test_without_viscosity_friction_is_that_of_the_boundary() -> None:
    dry = replace(OIL, viscosity=0.0)
    line = line_friction(dry, [1.0, 100.0], 0.3, 0.1, 2e-3, 0.01, 1.15e11)
    journal = journal_friction(dry, [1.0, 100.0], 0.3, 0.1, 2e-3, 1e-6, 0.01)
    for friction in (line, journal):
        assert friction.coefficient == pytest.approx(0.11)
        assert friction.asperity_share == pytest.approx(1.0)
    for pins in ("free", "fixed"):
        _, solved = balanced(lubricated(f"ring.pins={pins}", "output.rollers=false"), FilmInputs(viscosity=0.0))
        assert solved.friction is not None
        assert solved.friction.contacts == pytest.approx(0.11)


def test_where_entrainment_vanishes_lubrication_is_boundary() -> None:
    reducer = lubricated("ring.pins=fixed")
    zero = float(entrainment_zeros(reducer.tooth_profile)[0])
    springs = springs_of(reducer, [zero])  # the pin on +y is then at this phase
    assert springs.film is not None
    phases = profile.pin_angles(reducer.tooth_profile) + zero
    there = int(np.argmin(np.abs(phases - zero)))
    teeth = springs.film.friction_at_working_forces().teeth
    assert teeth.asperity_share[0, there] > 0.99
    assert teeth.coefficient[0, there] == pytest.approx(0.11, rel=0.01)
    assert np.min(teeth.asperity_share[0]) < 0.6


def test_share_of_asperities_falls_to_zero() -> None:
    assert asperity_share(OIL, [0.0, 1.0, 3.0]) == pytest.approx([1.0, 0.18, 0.0])


@pytest.mark.parametrize("formula", ["pan-hamrock", "dowson-higginson", "hamrock-dowson"])
def test_formulas_agree_to_a_point_of_efficiency(formula: str) -> None:
    assert efficiency(lubricated(f"friction.film_formula={formula}")) == pytest.approx(86.0, abs=1.0)


def test_coulomb_is_unchanged() -> None:
    design = resolve("pin", [f"load.torque_nm={LOAD}"])
    assert design.friction.law == "coulomb"
    assert efficiency(Reducer(design)) == pytest.approx(88.05, abs=0.005)


def test_free_pins_are_at_least_three_points_more_efficient_than_fixed_pins() -> None:
    free, fixed = (sampled_efficiency(lubricated(f"ring.pins={pins}"), LOAD) for pins in ("free", "fixed"))
    assert 76.0 < free.low < free.value < free.high < 93.0
    assert fixed.value < free.value - 3.0


def test_output_pins_at_high_speed_have_a_full_film() -> None:
    _, solved = balanced(lubricated("output.rollers=false", "drive.speed_rpm=6000"))
    assert solved.friction is not None
    assert solved.friction.output is not None
    assert np.min(solved.friction.output.ratio[solved.output > 1.0]) > 3.0
    assert np.max(solved.friction.output.asperity_share[solved.output > 1.0]) == 0.0


def test_most_loaded_free_pins_roll_and_a_stopped_pin_has_less_friction() -> None:
    reducer = lubricated()
    springs, solved = balanced(reducer)
    friction, loaded = solved.friction, solved.teeth > 1.0
    assert friction is not None
    assert np.mean(friction.rolls[loaded]) > 0.5
    fixed = springs_of(lubricated("ring.pins=fixed"))
    assert fixed.film is not None
    film = fixed.film.displaced(solved.departures)
    flank = film.friction(solved.teeth, solved.output, np.linalg.norm(solved.cam, axis=-1))
    assert np.all(friction.teeth.coefficient <= flank.teeth.coefficient + 1e-5)
    assert springs.friction is not None


@pytest.mark.parametrize("name", ["nonpin", "printed", "twodisc"])
def test_power_balance_closes(name: str) -> None:
    reducer = Reducer(resolve(name, ["friction.law=film"]))
    mean = powers(reducer, reducer.design.rated_torque)
    assert mean.supplied - mean.delivered - mean.lost == pytest.approx(0.0, abs=1e-9)
    assert 0.5 < mean.efficiency < 0.99


def test_temperature_of_the_parts_is_that_of_the_lubricant() -> None:
    oil = lubricant("lithium grease 100")
    warm = lubricated("thermal.disc_c=62", "thermal.ring_c=60")
    assert film_law(warm, "pin_gear").viscosity == pytest.approx(oil.viscosity(61.0))
    assert film_law(warm, "output").viscosity == pytest.approx(oil.viscosity(0.5 * (62.0 + 20.0)))


def test_drag_of_the_design_replaces_that_of_the_seals() -> None:
    plain = lubricated("gear.bearing=plain")
    crank, output = drag_torques(plain)
    assert crank == pytest.approx(7.69e-6 * 16.0**2 * 60.0 / (2.0 * np.pi))
    assert output == pytest.approx(7.69e-6 * 60.0**2 * 60.0 / (2.0 * np.pi))
    assert drag_torques(plain.but(drag={"crank": 0.02})) == pytest.approx((0.02, 0.0))
    assert drag_torques(Reducer(resolve("pin"))) == (0.0, 0.0)


def test_samples_at_fixed_forces_match_full_solutions() -> None:
    reducer = lubricated("ring.pins=fixed")
    _, outcomes = film_spread.lost_powers(reducer, LOAD)
    samples, _ = film_spread.sample_inputs()
    for k in (0, 5, 9):
        springs, _ = balanced(reducer, samples[k])
        crank, output = drag_torques(reducer, samples[k])
        solved = loads(reducer, springs, LOAD + drag_torques(reducer)[1], warm_start=True)
        lost = sum(float(np.mean(power)) for power in friction_losses(reducer, springs, solved).values())
        speed = reducer.design.drive.speed
        assert outcomes[k] == pytest.approx(lost + speed * (crank + output / 35.0), rel=0.01)


def outcomes_of(slopes: Sequence[float]) -> film_spread.Spread:
    """Return the spread of a linear function of the inputs."""
    places = film_spread.sample_inputs()[1]
    return film_spread.compute_spread(0.0, places @ np.array(slopes), places)


def test_causes_are_the_inputs_of_the_largest_variance() -> None:
    spread = outcomes_of([0.0, 3.0, 0.0, 0.0, 4.0, *[0.0] * 5])
    assert [name for name, _ in spread.causes[:2]] == ["film thickness", "roughness"]
    assert [share for _, share in spread.causes[:2]] == pytest.approx([0.64, 0.36], abs=0.03)
    assert sum(share for _, share in spread.causes[2:]) < 1e-3


def test_an_interval_holds_nine_tenths_of_a_uniform_input() -> None:
    spread = outcomes_of([1.0, *[0.0] * 9])
    assert (spread.low, spread.high) == pytest.approx((0.05, 0.95), abs=0.01)


def test_an_unknown_lubricant_is_refused_with_the_nearest_name() -> None:
    with pytest.raises(DesignError, match='did you mean "PAO 150"'):
        resolve("pin", ["friction.lubricant=PAO 15"])
    assert resolve("pin", ["friction.lubricant=pao 150"]).friction.lubricant == "PAO 150"


def test_figures_have_value_and_interval_under_film_only() -> None:
    key = "efficiency_percent"
    film = values_json({key: quantity(lubricated(), key)})[key]
    assert film["low"] < film["value"] < film["high"]
    assert len(film["causes"]) == 2
    coulomb = values_json({key: quantity(Reducer(resolve("pin", [f"load.torque_nm={LOAD}"])), key)})[key]
    assert set(coulomb) == {"name", "value", "unit"}


def test_starting_torque_has_an_interval() -> None:
    figure = quantity(lubricated(), "starting_torque_nm")
    assert figure.low is not None
    assert figure.high is not None
    assert figure.low < figure.value < figure.high
    assert quantity(Reducer(resolve("pin")), "starting_torque_nm").low is None


def test_map_covers_torque_speed_and_temperature() -> None:
    points = compute_film_map(lubricated(), shares=(0.5, 1.0), temperatures=(20.0, 60.0))
    efficiencies = [point for point in points if point.quantity == "efficiency"]
    assert len(efficiencies) == 8
    for point in points:
        assert point.spread.low < point.spread.value < point.spread.high
    assert efficiencies[3].spread.value == pytest.approx(efficiency(lubricated()), abs=1e-3)
    idle = {(p.temperature, p.speed): p.spread.value for p in points if p.quantity == "no-load torque"}
    assert sorted(idle.values()) == [idle[key] for key in sorted(idle, key=lambda key: (-key[0], key[1]))]
    assert sum(len(table.rows) for table in map_tables(points)) == len(points)
    assert {point.as_json()["speed_rpm"] for point in efficiencies} <= {410.0, 820.0, 1230.0, 1640.0}


def test_a_map_omits_temperatures_at_which_the_parts_jam() -> None:
    """The plastic bore of `printed` closes on its steel cam at 0 °C."""
    printed = Reducer(resolve("printed", ["friction.law=film"]))
    with pytest.warns(CycloidWarning, match="no values at 0 °C, because the parts jam"):
        points = compute_film_map(printed, shares=(1.0,), temperatures=(0.0, 20.0))
    assert {point.temperature for point in points} == {20.0}
    with pytest.raises(DesignError, match="the parts jam"):
        compute_film_map(printed, shares=(1.0,), temperatures=(0.0,))


def test_map_requires_the_law_film() -> None:
    with pytest.raises(UsageError, match="--map needs"):
        compute_film_map(Reducer(resolve("pin")))
