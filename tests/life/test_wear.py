"""Wear: where a surface wears fastest, the slip of sleeves, the coefficient of plastics."""

import math
import re

import numpy as np
import pytest

from cycloid_mj.design import PRESETS, override
from cycloid_mj.geometry import profile
from cycloid_mj.life import loading as life_loading
from cycloid_mj.life import rate
from cycloid_mj.life.duty import constant_duty
from cycloid_mj.life.loading import SECTORS, Loading, solve_loading
from cycloid_mj.life.wear_data import wear_coefficient
from cycloid_mj.life.wearing_surfaces import wearing_surfaces
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics import powers

PIN = PRESETS["pin"]


def loaded(reducer: Reducer, poses: int = 181) -> Loading:
    design = reducer.design
    return solve_loading(
        reducer, constant_duty(design.rated_torque, design.drive.speed).points[0], poses, with_wind_up=False
    )


def test_flank_is_divided_as_long_as_it_is() -> None:
    """The arcs of all sectors are the outline's length, and each is |dr/dB| dB by the profile's points."""
    reducer = Reducer(PIN)
    lengths = life_loading._flank_lengths(reducer)
    whole = profile.arc_length(reducer.gear_profile, 2.0 * math.pi, reducer.profile_offset)
    assert lengths.sum() == pytest.approx(whole)
    t = np.linspace(0.0, 2.0 * math.pi / PIN.lobes, SECTORS * 50 + 1)
    points = profile.outline(reducer.gear_profile, t, reducer.profile_offset)
    arcs = np.linalg.norm(np.diff(points, axis=0), axis=1).reshape(SECTORS, 50).sum(axis=1)
    assert lengths == pytest.approx(PIN.lobes * arcs, rel=1e-4)


def test_the_largest_line_power_of_an_even_power_is_its_mean() -> None:
    angle = np.linspace(0.0, 2.0 * math.pi, 10 * SECTORS, endpoint=False)[:, np.newaxis] + 1e-6
    power = np.full_like(angle, 3.0)
    assert life_loading._largest_line_power(power, angle, np.full(SECTORS, 2.0 / SECTORS)) == pytest.approx(1.5)
    half = np.where(angle < math.pi, 3.0, 0.0)  # one flank alone: twice the mean
    assert life_loading._largest_line_power(half, angle, np.full(SECTORS, 2.0 / SECTORS)) == pytest.approx(1.5)
    assert half.mean() / 2.0 == pytest.approx(0.75)


def test_holes_wear_pi_times_their_mean_under_a_half_sine() -> None:
    """Plain output pins, no play: forces go as the sine of the pin's angle on one half, the slip is constant."""
    ideal = PIN.but(
        output={"rollers": False},
        clearance={"output": 1e-9, "pin_gear": 1e-9, "pin_socket": 1e-9, "cam": 1e-9},
        friction={"pin_gear": 0.0, "pin_socket": 0.0, "cam": 0.0, "output": 1e-6},
        stiffness={"cam": 1e12},
        drive={"speed": 1.0},
    )
    rub = loaded(Reducer(ideal), 721).sliding["output"]
    around = 2.0 * math.pi * ideal.output.hole_radius * ideal.output.pins
    assert rub.density * around / rub.power == pytest.approx(math.pi, rel=0.02)


@pytest.mark.parametrize(("name", "times"), [("pin", 21.8), pytest.param("twodisc", 8.8, marks=pytest.mark.slow)])
def test_flank_wears_where_its_contacts_dwell(name: str, times: float) -> None:
    """The largest depth over that of F v spread over both flanks; four times the crank angles change it by 3 %."""
    reducer = Reducer(PRESETS[name])
    design = reducer.design
    length = profile.arc_length(reducer.gear_profile, 2.0 * math.pi, reducer.profile_offset) * design.gear.discs
    coarse, fine = (loaded(reducer, poses).sliding["pin_gear"] for poses in (181, 721))
    assert coarse.density * length / coarse.power == pytest.approx(times, rel=0.01)
    assert fine.density == pytest.approx(coarse.density, rel=0.03)
    item = rate(design, stops=False).items["pin_gear_wear"]
    depth = 1e-18 * coarse.density / design.gear.face_width * 3.6e6
    assert item.value == pytest.approx(1e6 * depth)
    assert item.life == pytest.approx(1000.0 * design.clearance.pin_gear / depth)


def test_sleeves_slip_at_their_bore() -> None:
    """A sleeve that rolls on the gear turns by v/rho: its bore slips at v r/rho, here 1.27 times less.

    So its friction takes mu F v r/rho, which is what the statics count for the teeth.
    """
    sleeved = Reducer(
        override(
            PRESETS["printed"],
            {"friction.law": "coulomb", "friction.pin_gear": 0.2, "friction.pin_sleeve": 0.05, "ring.pins": "sleeved"},
        )
    )
    ring, one = sleeved.design.ring, loaded(sleeved, 61)
    assert ring.pin_radius / ring.sleeve_bore_radius == pytest.approx(14.0 / 11.0)
    rub = one.sliding["pin_sleeve"]
    lost = powers(sleeved, sleeved.design.rated_torque).friction["teeth"]
    assert sleeved.design.friction_of("pin_sleeve") * rub.power == pytest.approx(lost, rel=1e-3)
    assert rub.density == pytest.approx(rub.power / (2.0 * math.pi * ring.sleeve_bore_radius * ring.teeth))


def test_with_film_friction_pins_wear_flanks_and_sockets() -> None:
    """Each pin slides on the flank or in its socket, where its friction is lower."""
    film = loaded(Reducer(override(PRESETS["pin"], ["friction.law=film"])), 61)
    coulomb = loaded(Reducer(PRESETS["pin"]), 61)
    assert set(coulomb.sliding) == {"pin_gear"}
    assert set(film.sliding) == {"pin_gear", "pin_socket"}
    assert min(item.power for item in film.sliding.values()) > 0.0
    assert sum(item.power for item in film.sliding.values()) == pytest.approx(
        coulomb.sliding["pin_gear"].power, rel=0.2
    )


def test_each_material_wears_by_its_own_coefficient() -> None:
    """2.65e-6 mm3/(N m) of Onyx, a PA 6, and 1e-9 of metals; what the design file states counts for both."""
    printed, metal = (rate(PRESETS[name], stops=False).items for name in ("printed", "pin"))
    worn = next(item for key, item in printed.items() if key.endswith("_wear"))
    assert worn.note.startswith("k = 2.65e-06 mm3/(N m), 5 to 95 %: 2.2e-07 to 1.2e-05; PA 66 on POM")
    assert metal["pin_gear_wear"].note.startswith("k = 1e-09 mm3/(N m), 5 to 95 %: 1e-10 to 1e-08; metals in mixed")
    stated = rate(override(PRESETS["printed"], {"service.wear_coefficient_mm3_nm": 2e-7}), stops=False).items
    assert "2e-08 to 2e-06; service.wear_coefficient_mm3_nm of the design file" in stated[worn.key].note


def test_a_part_wears_at_most_until_it_is_worn_through() -> None:
    """A disc of PLA without grease would lose 23 mm in 1000 h: its lobes, 3 mm high, are gone before."""
    item = rate(override(PRESETS["printed"], {"material.name": "PLA"}), stops=False).items["pin_gear_wear"]
    assert item.value == pytest.approx(2e6 * PRESETS["printed"].gear.eccentricity)
    hours = float(re.search(r"worn through after ([\d.]+) h", item.note)[1])
    assert item.life is not None
    assert hours == pytest.approx(item.life * item.value / item.limit, rel=0.01)
    assert "worn through" not in rate(PRESETS["printed"], stops=False).items["pin_gear_wear"].note


def test_bare_dowels_wear_the_printed_holes_by_the_coefficient_of_the_plastic() -> None:
    """Dowels of 2 mm without sleeves: k F s/A of the hole, with k of its PA 6, more than the mean over the hole.

    A dowel is of steel and wears by 1e-9 mm3/(N m). It does not turn in its own hole while its press fit is safe.
    """
    dowels = {"rollers": False, "pin_radius": 1e-3, "hole_radius": 2.5e-3}
    design = PRESETS["printed"].but(output=dowels, drive={"torque": 0.05})
    reducer = Reducer(design)
    item = rate(design, stops=False).items["output_wear"]
    assert item.name == "wear of output holes by output pins, per 1000 h"
    assert item.note.startswith("k = 2.65e-06 mm3/(N m)")
    area = 2.0 * math.pi * design.output.hole_radius * design.output.pins * design.gear.face_width
    rub = loaded(reducer, 181).sliding["output"]
    assert 1e-6 * item.value == pytest.approx(2.65e-15 * rub.density * 3.6e6 / design.gear.face_width, rel=0.01)
    assert 1e-6 * item.value > math.pi * 2.65e-15 * rub.power * 3.6e6 / area
    surfaces = {surface.key: surface.part for surface in wearing_surfaces(reducer)}
    assert (surfaces["hole"], surfaces["output_pin"]) == ("gear", "output")
    hole, pin = (wear_coefficient(design.service, design.material_of(part)).typical for part in ("gear", "output"))
    assert (hole, pin) == (pytest.approx(2.65e-15), pytest.approx(1e-18))
    assert "joint_output_pin_press" in rate(design).items
