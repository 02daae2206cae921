"""Strength of joints against worked examples of VDI 2230, DIN 7190 and DIN 6885."""

import math

import pytest

from cycloid_mj.parts.joint_strength import (
    PROOF_STRESS,
    ParallelKey,
    PressFit,
    SlottedHub,
    StraightSpline,
    Thread,
    clamped_pin_pressure,
    dowel_force,
    effective_interference,
    friction_torque,
    head_pressure,
    pull_out_force,
    shrink_difference,
    tilting_dowel_force,
)

FINE_THREADS = {
    # diameter, pitch, bearing face, hole [mm]: friction -> preloads [kN] and torques [N m] of 8.8, 10.9 and 12.9
    (8, 1.0, 11.63, 9.0): {
        0.10: (20.7, 30.4, 35.6, 22.8, 33.5, 39.2),
        0.12: (20.2, 29.7, 34.7, 26.1, 38.3, 44.9),
        0.14: (19.7, 28.9, 33.9, 29.2, 42.8, 50.1),
    },
    (10, 1.25, 14.63, 11.0): {
        0.10: (32.4, 47.5, 55.6, 44, 65, 76),
        0.12: (31.6, 46.4, 54.3, 51, 75, 87),
        0.14: (30.8, 45.2, 52.9, 57, 83, 98),
    },
    (12, 1.25, 16.63, 13.5): {
        0.10: (49.1, 72.1, 84.4, 79, 116, 135),
        0.12: (48.0, 70.5, 82.5, 90, 133, 155),
        0.14: (46.8, 68.7, 80.4, 101, 149, 174),
    },
    (14, 1.5, 19.64, 15.5): {
        0.10: (66.4, 97.5, 114.1, 124, 182, 213),
        0.12: (64.8, 95.2, 111.4, 142, 209, 244),
        0.14: (63.2, 92.9, 108.7, 159, 234, 274),
    },
    (16, 1.5, 22.49, 17.5): {
        0.10: (89.6, 131.6, 154.0, 189, 278, 325),
        0.12: (87.6, 128.7, 150.6, 218, 320, 374),
        0.14: (85.5, 125.5, 146.9, 244, 359, 420),
    },
}


@pytest.mark.parametrize("size", FINE_THREADS)
def test_preload_and_tightening_torque_match_vdi_2230(size: tuple[float, float, float, float]) -> None:
    """VDI 2230 table A3 (fine threads, 90 % of yield), as printed by Mastik, p. 685: 45 preloads and 45 torques.

    The preloads agree within 0.3 %, the torques within half of the printed unit or 0.65 %.
    """
    diameter, pitch, bearing, hole = size
    thread = Thread(1e-3 * diameter, 1e-3 * pitch)
    for friction, printed in FINE_THREADS[size].items():
        for proof, preload, torque in zip(PROOF_STRESS.values(), printed[:3], printed[3:], strict=True):
            computed = thread.largest_preload(proof, friction)
            assert computed == pytest.approx(1e3 * preload, rel=3e-3)
            tightening = thread.tightening_torque(computed, 0.5e-3 * (bearing + hole), friction)
            assert tightening == pytest.approx(torque, rel=6.5e-3, abs=0.5)


def test_preload_of_m12_matches_the_example_of_bossard() -> None:
    """Bossard (2021), values of VDI 2230 (2015): M12 x 40, 8.8, friction 0.14: 41.9 kN; over alpha_A = 1.8, 23.3 kN."""
    preload = Thread(12e-3, 1.75e-3).largest_preload(PROOF_STRESS["8.8"], 0.14)
    assert preload == pytest.approx(41.9e3, rel=2.5e-3)
    assert preload / 1.8 == pytest.approx(23.3e3, rel=2.5e-3)


def test_tightening_torque_matches_shigley() -> None:
    """Shigley, 9th ed., example 8-3 (c): 3/4 in-16 UNF, 25 kip, friction 0.15, face at 0.625 d: 3551 lbf in."""
    inch, pound, pound_inch = 25.4e-3, 4.448222, 0.1129848
    thread = Thread(0.75 * inch, inch / 16.0)
    torque = thread.tightening_torque(25e3 * pound, 2.0 * 0.625 * 0.75 * inch, 0.15)
    assert torque == pytest.approx(3551.0 * pound_inch, rel=5e-4)


def test_stress_area_matches_iso_898() -> None:
    assert 1e6 * Thread(4e-3, 0.7e-3).stress_area == pytest.approx(8.78, abs=0.005)
    assert 1e6 * Thread(12e-3, 1.75e-3).stress_area == pytest.approx(84.3, abs=0.05)


def test_flange_of_six_m4_slips_as_computed_by_hand() -> None:
    """6 x 0.7 x 640 MPa x 8.78 mm2 x 0.15 x 19.8 mm = 70.1 N m; head (6.53^2 - 4.5^2) pi/4 = 17.59 mm2."""
    thread = Thread(4e-3, 0.7e-3)
    preload = thread.usual_preload(640e6)
    assert friction_torque(6, preload, 19.8e-3) == pytest.approx(70.1, rel=1e-3)
    assert head_pressure(preload, 6.53e-3, 4.5e-3) == pytest.approx(3933.0 / 17.59e-6, rel=1e-3)


def test_stripping_force_of_m8_in_steel() -> None:
    """M8, 8 mm engaged: (8/1.25 - 0.8) x pi x 8 x (0.625 + 0.812/1.732) mm2 = 154.0 mm2, times 300 MPa."""
    assert Thread(8e-3, 1.25e-3).stripping_force(8e-3, 300e6) == pytest.approx(154.0e-6 * 300e6, rel=2e-3)


@pytest.mark.parametrize(
    ("diameter", "outside", "bore", "length", "interference", "hub", "shaft", "friction", "pressure", "torque"),
    [
        # machinecalc, press fit, worked example: p 48.8 MPa, 1149 N m (E 200 GPa, same material)
        (50, 80, 0, 40, 40, (200e9, 0.3), (200e9, 0.3), 0.15, 48.75e6, 1149.0),
        # aionlinecalculator, press fit, worked example: p 51.2 MPa, 965 N m (E 210 GPa, friction 0.12)
        (50, 80, 0, 40, 40, (210e9, 0.3), (210e9, 0.3), 0.12, 51.2e6, 965.0),
        # novasolver, shrink-fit stress, default values: p 58.3 MPa, 6.87 kN m (E 210 GPa, same material)
        (100, 150, 0, 50, 100, (210e9, 0.3), (210e9, 0.3), 0.15, 58.33e6, 6872.0),
        # Boresi and Schmidt, 6th ed., example 11.3: 72 um on the radius of 25 mm between 10 and 50 mm: 189.0 MPa
        (50, 100, 20, 10, 144, (200e9, 0.29), (200e9, 0.29), 0.15, 189.0e6, 1113.3),
        # Ugural and Fenster, example 8.3: 0.1 mm on the radius of 200 mm between 150 and 250 mm: 12.3 MPa
        (400, 500, 300, 100, 200, (200e9, 0.3), (200e9, 0.3), 0.15, 12.305e6, 46388.0),
        # Bhandari, example 22.8: tube 50/75 mm in a jacket 75/100 mm, bored to 74.9919 mm: 3.615 MPa (E 207 GPa)
        (75, 100, 50, 100, 8.084, (207e9, 0.3), (207e9, 0.3), 0.15, 3.615e6, 479.1),
        # DIN 7190, hollow shaft, steel on steel by hand: K = 5/3 + 0.3 + 5/3 - 0.3 = 10/3, p = 1e-3 x 210e9/(10/3)
        (60, 120, 30, 50, 60, (210e9, 0.3), (210e9, 0.3), 0.12, 63.0e6, 2137.5),
        # steel pin in aluminium by hand: K = 1.25/0.75/70e9 + 0.33/70e9 + 0.7/210e9 = 3.1857e-11 1/Pa
        (10, 20, 0, 20, 10, (70e9, 0.33), (210e9, 0.3), 0.10, 31.39e6, 9.861),
    ],
)
def test_press_fit_matches_worked_examples(
    diameter: float,
    outside: float,
    bore: float,
    length: float,
    interference: float,
    hub: tuple[float, float],
    shaft: tuple[float, float],
    friction: float,
    pressure: float,
    torque: float,
) -> None:
    fit = PressFit(1e-3 * diameter, 1e-3 * length, 1e-3 * outside, hub, shaft, 1e-3 * bore)
    computed = fit.pressure(1e-6 * interference)
    assert computed == pytest.approx(pressure, rel=1e-3)
    assert fit.torque(computed, friction) == pytest.approx(torque, rel=1e-3)
    assert fit.pressure(-1e-6) == 0.0


def test_smoothing_and_yield_of_a_press_fit() -> None:
    """DIN 7190: 0.8 x (6.3 + 4) um are lost; a hub of twice the diameter yields at 0.75 R_e/sqrt(3)."""
    assert effective_interference(40e-6, 6.3e-6, 4e-6) == pytest.approx(31.76e-6)
    fit = PressFit(10e-3, 10e-3, 20e-3, (210e9, 0.3), (210e9, 0.3))
    assert fit.yield_pressure(300e6) == pytest.approx(0.75 * 300e6 / math.sqrt(3.0))


def test_growth_yield_and_joining_temperature_of_a_shrink_fit() -> None:
    """By hand, 60/120 mm, bore 30 mm: 2 p Q^2/(1 - Q^2) D/E = 2 x 63 x 0.25/0.75 x 120/210000 mm = 24 um."""
    fit = PressFit(60e-3, 50e-3, 120e-3, (210e9, 0.3), (210e9, 0.3), 30e-3)
    assert fit.growth(63e6) == pytest.approx(24e-6)
    assert fit.shaft_yield_pressure(300e6) == pytest.approx(0.75 * 300e6 / math.sqrt(3.0))
    solid = PressFit(60e-3, 50e-3, 120e-3, (210e9, 0.3), (210e9, 0.3))
    assert solid.shaft_yield_pressure(300e6) == pytest.approx(2.0 * 300e6 / math.sqrt(3.0))
    # 60 um of interference and 60 um of play on 60 mm: 120/(11e-6 x 60e3) K
    assert shrink_difference(60e-3, 60e-6, 11e-6) == pytest.approx(181.8, abs=0.05)


@pytest.mark.parametrize(
    ("width", "height", "depth", "length", "shaft", "torque", "pressure"),
    [
        # DIN 6892, example E.2 (its geometry, shape AB, 91 mm carry), method C: 2 x 1950/(0.06 x 0.004 x 0.091)
        (18, 11, 7, 109, 60, 1950.0, 178.6e6),
        # 12 x 8 x 56 on 40 mm, 500 N m: 25 000 N on 3 mm x 44 mm
        (12, 8, 5, 56, 40, 500.0, 189.4e6),
        # 6 x 6 x 20 on 20 mm, 40 N m: 4000 N on 2.5 mm x 14 mm
        (6, 6, 3.5, 20, 20, 40.0, 114.3e6),
    ],
)
def test_key_pressure_matches_worked_examples(
    width: float, height: float, depth: float, length: float, shaft: float, torque: float, pressure: float
) -> None:
    key = ParallelKey(1e-3 * height, 1e-3 * depth, 1e-3 * (length - width))  # shape A: without the round ends
    assert key.pressure(torque, 1e-3 * shaft) == pytest.approx(pressure, rel=1e-3)
    assert key.torque(1e-3 * shaft, pressure / 0.9) == pytest.approx(torque, rel=1e-3)


def test_key_length_matches_shigley() -> None:
    """Shigley, example 7-6: square key of 3/8 in on 1 7/16 in, 4200 lbf in, 65 kpsi over 1.5: 0.720 in are crushed."""
    inch, psi, pound_inch = 25.4e-3, 6894.757, 0.1129848
    key = ParallelKey(0.375 * inch, 0.1875 * inch, 0.720 * inch)
    assert key.pressure(4200.0 * pound_inch, 1.4375 * inch) == pytest.approx(65e3 / 1.5 * psi, rel=2e-3)


def test_key_length_matches_wentzell() -> None:
    """Wentzell, example 15.1: square key of 1/8 in on 1/2 in, 180 lbf in, 51 kpsi over 2.5: 0.56 in are crushed."""
    inch, psi, pound_inch = 25.4e-3, 6894.757, 0.1129848
    key = ParallelKey(0.125 * inch, 0.0625 * inch, 0.565 * inch)
    assert key.pressure(180.0 * pound_inch, 0.5 * inch) == pytest.approx(51e3 / 2.5 * psi, rel=1e-2)


def test_a_stiff_dowel_tilts_in_soft_holes_at_the_limit_load_of_johansen() -> None:
    """EN 1995-1-1, 8.6 (c): (sqrt(2) - 1) d s R_e for equal parts; else the limit load of both holes in balance."""
    assert tilting_dowel_force(4e-3, (7e-3, 7e-3), (36e6, 36e6)) == pytest.approx(
        (math.sqrt(2.0) - 1.0) * 4e-3 * 7e-3 * 36e6
    )
    diameter, depths, strengths = 3e-3, (4e-3, 7e-3), (36e6, 50e6)
    force = tilting_dowel_force(diameter, depths, strengths)
    moments = []
    for depth, strength in zip(depths, strengths, strict=True):
        turned = 0.5 * (depth - force / (diameter * strength))  # length that yields on the other side
        pressed = depth - turned
        moments.append(diameter * strength * (0.5 * pressed**2 - turned * (pressed + 0.5 * turned)))
    assert sum(moments) == pytest.approx(0.0, abs=1e-9 * force * depths[0])
    assert force == pytest.approx(tilting_dowel_force(diameter, depths[::-1], strengths[::-1]))
    assert tilting_dowel_force(1e-3, (9e-3, 9e-3), (500e6, 500e6)) == pytest.approx(0.25 * math.pi * 1e-6 * 896e6)
    assert tilting_dowel_force(3e-3, (1e-3, 20e-3), (36e6, 36e6)) == pytest.approx(3e-3 * 1e-3 * 36e6)


def test_dowels_inserts_and_bent_pins() -> None:
    assert dowel_force(3e-3, 4e-3, 1e9) == pytest.approx(0.25 * math.pi * 9e-6 * 896e6)
    assert dowel_force(3e-3, 4e-3, 45e6) == pytest.approx(540.0), "the hole in a plastic yields first"
    assert pull_out_force(4e-3, 5.7e-3, 26e6) == pytest.approx(1862.0, rel=1e-3)
    # Roloff/Matek 9.19: F (6 h + 4 s)/(d s^2) = 400 x (90 + 48)/(8 x 144) MPa
    assert clamped_pin_pressure(400.0, 400.0 * 15e-3, 8e-3, 12e-3) == pytest.approx(47.92e6, rel=1e-3)


def test_flanks_of_a_spline_by_hand() -> None:
    """8 x 46 x 50, 60 mm, 500 N m: h = 0.4 x 4 = 1.6 mm, p = 2 x 500 000/(48 x 1.6 x 60 x 0.75 x 8) = 36.17 MPa."""
    spline = StraightSpline(8, 46e-3, 50e-3, 60e-3)
    assert spline.pressure(500.0) == pytest.approx(36.17e6, rel=1e-3)
    assert spline.torque(36.17e6) == pytest.approx(500.0, rel=1e-3)


def test_slotted_hub_slips_as_computed_by_hand() -> None:
    """Shaft of 20 mm, l1 = 32 mm, l2 = 12 mm, wall 4 x 15 mm, 5 kN: N = 5 x 32/12 = 13.33 kN, T = 0.15 N d = 40 N m.

    A clearance of 20 um takes M = 210 000 x 15 x 4^3/12 x 0.02/(2 x 12^2) = 1167 N mm, so that T falls by 0.29 N m.
    """
    hub = SlottedHub(20e-3, 32e-3, 12e-3, 4e-3, 15e-3, 210e9)
    assert hub.torque(5e3) == pytest.approx(40.0, rel=1e-9)
    assert hub.closing_moment(20e-6) == pytest.approx(1.1667, rel=1e-3)
    assert hub.torque(5e3, 20e-6) == pytest.approx(40.0 - 0.15 * 1.1667 / 12e-3 * 20e-3, rel=1e-4)
    assert hub.torque(10.0, 20e-6) == 0.0, "screws that do not close the hub transmit nothing"
