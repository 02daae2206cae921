"""Balance of an RV reducer: against closed forms, and its equilibrium."""

import math

import numpy as np
import pytest
from rv_runs import COULOMB_RV80E

from cycloid_mj.base.errors import RunError
from cycloid_mj.design import override
from cycloid_mj.geometry.rv_loads import closed_form_error, ideal_rv_loads
from cycloid_mj.reducer import RvReducer
from cycloid_mj.statics import main as statics
from cycloid_mj.statics.rv import (
    compute_rv_springs,
    crank_misfits,
    phase_errors,
    solve_rv_loads,
)
from cycloid_mj.statics.rv_sheet import (
    carrier_turn_angles,
    friction_powers,
    rv_powers,
    solve_forward_equilibrium,
    solve_running_equilibrium,
    solve_rv_equilibrium,
)
from cycloid_mj.statics.sheet import sheet_part

RV80E = COULOMB_RV80E
ARCSECOND = math.pi / 648000.0
TIGHT = ("clearance.pin_gear_um=1e-6", "clearance.pin_socket_um=1e-6")
"""Vanishing clearances of the pins."""

STIFF = (
    *("cranks.needle_stiffness_n_m=1e11", "cranks.taper_stiffness_n_m=1e11"),
    *("stiffness.pin_gear_n_m=1e8", "stiffness.pin_socket_n_m=1e8", "planet.mesh_stiffness_n_m=1e12"),
    *TIGHT,
)
"""Crank bearings far stiffer than the teeth: the discs keep their places, so that pins share by their arms alone."""


def reducer(*changes: str) -> RvReducer:
    """Build the reducer of the preset with changes."""
    return RvReducer(override(RV80E, changes))


@pytest.mark.parametrize(("cranks", "discs"), [(3, 2), (2, 2), (3, 1)])
def test_stiff_cranks_share_as_the_closed_form(cranks: int, discs: int) -> None:
    """Under a hundredth of the load: the closed form is that of vanishing displacements along curved flanks."""
    drive = reducer(*STIFF, f"cranks.count={cranks}", f"gear.discs={discs}")
    crank = np.radians([0.0, 30.0, 90.0, 200.0])
    found, ideal = solve_rv_loads(compute_rv_springs(drive, crank), 7.84), ideal_rv_loads(drive.stage, 7.84, crank)
    assert found.pins.reshape(4, discs, -1) == pytest.approx(ideal.pins, abs=0.02 * ideal.pins.max())
    if discs == 2:  # a single disc loads the cranks unequally, which springs of planets equalise in part
        assert found.bearings == pytest.approx(ideal.bearings, abs=0.01 * ideal.bearings.max())


def test_forces_are_in_equilibrium_and_the_planets_carry_the_input_torque() -> None:
    """Under a hundredth of the load: displacements turn the normals of curved flanks, here by less than 1e-3."""
    drive, torque = reducer("cranks.needle_clearance_um=0.03", "planet.backlash_um=0.2", *TIGHT), 7.84
    springs = compute_rv_springs(drive, np.linspace(0.0, 40.0, 7))
    found = solve_rv_loads(springs, torque)
    normals = springs.slope[:, : springs.pins, :6].reshape(7, -1, 2, 3)[..., :2].sum(axis=2)
    on_discs = (normals * found.pins[..., np.newaxis]).reshape(7, 2, -1, 2).sum(axis=2)
    assert on_discs + found.cranks.sum(axis=2) == pytest.approx(0.0, abs=1e-3 * np.abs(on_discs).max())
    base = drive.planet.module * drive.planet.sun_teeth / 2.0 * math.cos(drive.planet.pressure_angle)
    assert (found.flanks[:, 0] - found.flanks[:, 1]).sum(axis=1) * base == pytest.approx(torque / 153.0, rel=1e-4)


def test_friction_that_does_not_converge_is_refused() -> None:
    with pytest.raises(
        RunError, match=r"friction forces of the last two iterations differ by .* Reduce the friction coefficients"
    ):
        solve_running_equilibrium(reducer("friction.cam_rolling=0.5"), 784.0, 8)


@pytest.mark.parametrize("member", ["carrier", "ring"])
@pytest.mark.parametrize("load", [784.0, -784.0])
def test_power_of_the_sun_is_that_of_the_load_and_of_friction(member: str, load: float) -> None:
    """The sun's power by the forces and the friction of its planets, against the losses of all parts.

    A negative load drives the output.
    """
    drive = reducer(f'output.member="{member}"')
    loads, mesh = solve_forward_equilibrium(drive, load), drive.planet_mesh
    sun_torque = np.abs(loads.flanks[:, 0] - loads.flanks[:, 1]).sum(axis=1).mean() * mesh.sun_base * np.sign(load)
    sun_torque += drive.planet.friction * loads.meshes.sum(axis=1).mean() * mesh.arm
    powers = rv_powers(drive, load)
    assert powers.output == pytest.approx(-load * abs(drive.output_speed))
    # the torque on a fixed carrier is that without losses, 0.1 % more than with them
    tolerance = 2e-3 if member == "ring" else 1e-3
    assert powers.crank == pytest.approx(sun_torque * abs(drive.design.drive.speed), rel=tolerance)


def test_figures_of_the_rv80e() -> None:
    sheet = statics(RV80E, 784.0)
    found = {key: item.value for key, item in sheet.quantities.items()}
    assert found["crank_bearing_force"] == pytest.approx(5333.0, rel=1e-3)
    assert found["crank_bearing_mean_force"] == pytest.approx(4083.0, rel=1e-3)
    assert found["stiffness_ideal"] == pytest.approx(208.0, rel=2e-3)
    # less than by ideal sharing: the discs move, and pins next to the crank take more
    assert found["crank_bearing_balanced_force"] == pytest.approx(5180.0, rel=5e-3)
    # friction adds to the torque of the planets, and pushes the discs aside
    assert found["crank_bearing_running_force"] == pytest.approx(5315.0, rel=5e-3)
    assert 85.0 < found["efficiency"] < 95.0


def test_ring_as_output_has_the_same_mesh() -> None:
    share = 153.0 / 152.0
    carrier, ring = (
        {
            key: item.value
            for key, item in statics(override(RV80E, [f"output.member={member}"]), torque).quantities.items()
        }
        for member, torque in (("carrier", 784.0), ("ring", 784.0 / share))
    )
    assert ring["crank_bearing_force"] == pytest.approx(carrier["crank_bearing_force"], rel=1e-9)
    assert ring["stiffness_ideal"] == pytest.approx(carrier["stiffness_ideal"] / share**2, rel=1e-6)
    assert ring["backlash"] == pytest.approx(carrier["backlash"] * share, rel=1e-4)


@pytest.mark.parametrize(
    ("change", "arcsec"),
    [
        ("planet.backlash_um=30", 4.6),
        ("clearance.pin_gear_um=1", 6.8),
        pytest.param("cranks.needle_clearance_um=1", 9.5, marks=pytest.mark.slow),
    ],
)
def test_each_clearance_has_the_lost_motion_of_the_closed_form(change: str, arcsec: float) -> None:
    """Of all crank bearings at once the turn of the disc counts, and their play along the eccentricity partly."""
    tight = (*STIFF, "clearance.pin_socket_um=1e-6", change)
    found = sheet_part(reducer(*tight), "motions", 784.0)["backlash"].value * 60.0
    assert arcsec - 0.2 < found < (arcsec + 6.8 if "needle" in change else arcsec + 0.2)


MODERATE = (
    *("cranks.needle_stiffness_n_m=2e9", "cranks.taper_stiffness_n_m=2e9", "planet.mesh_stiffness_n_m=1e12"),
    *("stiffness.pin_gear_n_m=2e9", "stiffness.pin_socket_n_m=2e9", "planet.sun_support=fixed"),
    *("planet.backlash_um=1", *TIGHT),
)
"""Bearings and teeth of 1e9 N/m, and rigid planets with a backlash larger than their run-out."""

ERRORS = {
    "carrier hole, tangential": ("carrier_x_um=[-10.0, 0, 0]", 22.8, 0.0),
    "disc hole, tangential": ("bore_x_um={1 = -10.0}", 22.8, 11.4),
    "disc hole, radial": ("bore_y_um={1 = 10.0}", 22.8, 11.4),
    "eccentricity of one crank": ("eccentric_radial_um={1 = 10.0}", 31.7, 15.8),
    "eccentricity of all cranks": ("eccentric_radial_um={1 = 10.0, 2 = 10.0, 3 = 10.0}", 0.0, 0.0),
    "phase of one eccentric": ("eccentric_tangential_um={1 = 10.0}", 31.7, 15.9),
    "run-out of one planet": ("planet_x_um={1 = 10.0}", 1.484, 1.093),
    "carrier off the axis of the ring": ("axis_x_um=10.0", 68.3, 0.0),
}
"""Error of 10 um -> the change, and the range of the output's angle with one disc and with two [arcsec]."""


@pytest.mark.parametrize("name", ERRORS)
@pytest.mark.parametrize("discs", [1, 2])
def test_error_map(name: str, discs: int) -> None:
    """Springs against the closed form: the same pins stay loaded, so the errors count a hundredth.

    The torque brakes the drive. What is 0 in closed form presses the teeth, which deflect.
    """
    change, *ranges = ERRORS[name]
    expected, crank = ranges[discs - 1], np.linspace(0.0, 2.0 * math.pi, 80, endpoint=False)
    drive = reducer(*MODERATE, f"gear.discs={discs}")
    small = RvReducer(override(drive.design, [f"crank_errors.{change.replace('10.0', '0.1')}"]))
    closed = closed_form_error(small.stage, crank, phase_errors(small, crank), crank_misfits(small, crank)) / ARCSECOND
    assert 100.0 * np.ptp(closed) == pytest.approx(expected, rel=0.03, abs=0.05)
    with_errors, without = (
        solve_rv_loads(compute_rv_springs(item, crank), -784.0).carrier_turn for item in (small, drive)
    )
    rotation = 100.0 * np.ptp(with_errors - without) / ARCSECOND
    assert rotation == pytest.approx(expected, rel=0.01) if expected else rotation < 0.1


@pytest.mark.parametrize("speed", [2295.0, -2295.0])
@pytest.mark.parametrize("discs", [1, 2])
def test_the_run_out_of_a_planet_acts_along_the_line_of_action(speed: float, discs: int) -> None:
    """At every angle and in both directions; unequal cranks also rotate a single disc, whose teeth then deflect."""
    drive = reducer(*MODERATE, f"gear.discs={discs}", f"drive.speed_rpm={speed}")
    small, crank = drive.but(crank_errors={"planet_x": (1e-7, 0.0, 0.0)}), np.linspace(0.0, 2.0 * math.pi, 40)
    closed = closed_form_error(small.stage, crank, phase_errors(small, crank), crank_misfits(small, crank))
    torque = -math.copysign(784.0, speed)
    with_errors, without = (
        solve_rv_loads(compute_rv_springs(item, crank), torque).carrier_turn for item in (small, drive)
    )
    difference = with_errors - without - closed
    assert np.ptp(difference) < (0.08 if discs == 1 else 1e-3) * np.ptp(closed)


def test_a_mirrored_drive_has_the_same_figures() -> None:
    """Bore errors of the cranks 2 and 3, which mirror each other, at opposite speeds."""
    forward, backward = (
        reducer(f"crank_errors.bore_x_um={bores}", f"drive.speed_rpm={speed}")
        for bores, speed in (("{2 = 10.0}", 2295.0), ("{3 = -10.0}", -2295.0))
    )
    unmirrored = reducer("crank_errors.bore_x_um={2 = 10.0}", "drive.speed_rpm=-2295")
    loads = [solve_running_equilibrium(item, 784.0, 61) for item in (forward, backward, unmirrored)]
    turns = [item.carrier_turn for item in loads]
    assert turns[1] == pytest.approx(-turns[0], rel=1e-9)
    assert turns[0].max() < 0.0  # the load turns the carrier back, of a sun that turns counter-clockwise
    assert np.abs(turns[2] + turns[0]).max() > 1e-6
    assert loads[1].bearings.max() == pytest.approx(loads[0].bearings.max(), rel=1e-9)


def test_a_running_drive_carries_the_friction_torque_of_its_cranks_in_its_planets() -> None:
    """Power of the sun over that without friction is the inverse of the efficiency."""
    drive = reducer("planet.friction=0")
    idle, running = (
        float(balance(drive, 784.0, 241).meshes.sum(axis=1).mean())
        for balance in (solve_rv_equilibrium, solve_running_equilibrium)
    )
    delivered = 784.0 * abs(drive.output_speed)
    losses = sum(friction_powers(drive, 784.0).values())
    assert running / idle == pytest.approx(1.0 + losses / delivered, rel=2e-3)


def test_half_the_angles_have_the_same_peaks() -> None:
    drive = reducer()
    peaks = [
        solve_rv_loads(compute_rv_springs(drive, carrier_turn_angles(drive, count)), 784.0).bearings.max()
        for count in (360, 720)
    ]
    assert peaks[0] == pytest.approx(peaks[1], rel=2e-3)
