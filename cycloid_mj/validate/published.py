"""Validation step "published": stresses of Krol et al. 2019, efficiency of Wang, Luo and Su 2016, two built drives.

Wang's formula is compared with its printed results and with the simulated reducer of the same proportions and friction;
where the two differ, the closed form with the neglected effect is compared with the simulation, too. The printed drive
is the preset ``printed``, whose backlash its authors measured; ``twodisc`` is a drive with two discs whose forces were
published.
"""

import math
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.powers import mean_powers
from cycloid_mj.base.record import Run
from cycloid_mj.base.validation import ValidationRow, absolute, relative
from cycloid_mj.design import PRESETS, Design
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.geometry import ideal_loads, profile
from cycloid_mj.geometry.profile import CycloidGear
from cycloid_mj.parts.gear import tooth_profile
from cycloid_mj.reducer import Reducer, limits
from cycloid_mj.statics import loads, springs_of
from cycloid_mj.statics.friction import ideal_losses
from cycloid_mj.validate import rig
from cycloid_mj.validate.backlash import turn_to_stop
from cycloid_mj.validate.rig import FIXED, design_of_kind


@dataclass(frozen=True)
class KrolVariant:
    """A variant of Krol et al. 2019: 16 pins, 15 lobes, 8 output sleeves, input `moment` [N m]; lengths [mm].

    `lobe`, `pit` and `sleeve` are the printed stresses [MPa] at the lobe's tip, in its valley and on a sleeve, which
    are `rounded` to within 0.6 MPa.
    """

    eccentricity: float
    pin_radius: float
    shortening: float
    width: float
    sleeve_radius: float
    hole_radius: float
    hole_circle: float
    lobe: float
    pit: float
    sleeve: float
    pins: int = 16
    moment: float = 1.55
    rounded: float = 0.6


KROL = (
    KrolVariant(2.8, 3.5, 0.70, 10.0, 5.0, 8.0, 30.0, 424.0, 139.0, 303.0),
    KrolVariant(1.5, 2.0, 0.65, 8.0, 3.0, 5.0, 20.0, 855.0, 331.0, 552.0),
    KrolVariant(2.9, 3.4, 0.70, 10.0, 5.0, 8.0, 30.0, 419.0, 142.0, 303.0),
)


@dataclass(frozen=True)
class Wang:
    """A row of Wang, Luo and Su 2016: pin circle, pin, hole circle and output pin by diameter [mm].

    `printed` efficiency, and half of its last digit as `rounding`. The sleeves on the output pins have a wall [mm].
    `bearings` is the efficiency of the bearings in the product. The simulated case has a rigid cam [N/m] and a `load`
    [N m]; 0.75 kW correspond to 214 N m.
    """

    pin_circle: float
    pin: float
    shortening: float
    hole_circle: float
    output_pin: float
    printed: float
    rounding: float
    pins: int = 44
    speed_rpm: float = 1440.0
    mesh_friction: float = 0.05
    sleeve_friction: float = 0.02
    sleeve_wall: float = 3.0
    bearings: float = 0.99 * 0.995**2
    load: float = 200.0
    cam_stiffness: float = 5e11


WANG = (Wang(141.0, 8.5, 0.8441, 100.0, 13.2, 0.8947, 0.5e-4), Wang(141.0, 7.7, 0.875, 100.0, 12.2, 0.896, 0.5e-3))


def hertz_rows(quick: bool) -> list[ValidationRow]:
    """Compare the Hertz stresses of the variants `KROL` with those printed by Krol et al. 2019; `quick` is ignored."""
    rows = []
    for variant_number, case in enumerate(KROL, start=1):
        source, unit = f"Krol et al. 2019, variant {variant_number}", "MPa"
        for name, computed_stress, printed_stress in zip(
            ("lobe", "valley", "output sleeve"), krol_stresses(case), (case.lobe, case.pit, case.sleeve), strict=True
        ):
            rows.append(
                absolute(f"Hertz stress, {name}", computed_stress / 1e6, printed_stress, unit, source, case.rounded)
            )
    return rows


def printed_drive_rows(quick: bool) -> list[ValidationRow]:
    """Compare the simulated backlash of the preset ``printed`` with that of rigid parts and with a measurement.

    The simulated backlash is extrapolated to zero torque from runs under two torques. That of rigid parts is solved by
    linear programming. The row of the measurement, by the builder of this 3-D printed drive, compares it with the mean
    for rigid parts and has no bound. `quick` is ignored.
    """
    design = rig.with_changes(Reducer(PRESETS["printed"]), *rig.without_friction(), *rig.without_gravity())
    # torques that press the output against a stop [N m]
    model, (small_torque, large_torque) = build(design.design), (0.1, 0.2)
    small_torque_turn, large_torque_turn = (
        turn_to_stop(model, torque, names.OUTPUT_JOINT) - turn_to_stop(model, -torque, names.OUTPUT_JOINT)
        for torque in (small_torque, large_torque)
    )
    simulated_backlash = small_torque_turn - (large_torque_turn - small_torque_turn) * small_torque / (
        large_torque - small_torque
    )
    min_angle, max_angle = limits.stops(design, 0.0)
    crank_angles = 2.0 * np.pi / design.design.ring.teeth * np.arange(8) / 8
    mean_turn = np.mean([np.ptp(limits.stops(design, float(crank_angle), sides=180)) for crank_angle in crank_angles])
    name = "backlash of a printed drive"
    clearance_note = "nominal clearances; printed parts have about twice as much"
    return [
        relative(
            name,
            math.degrees(simulated_backlash),
            math.degrees(max_angle - min_angle),
            "deg",
            "rigid parts: linear programme",
            0.5,
        ),
        relative(name, math.degrees(mean_turn), 1.24, "deg", "JelmerV, bench", None, clearance_note),
    ]


KUBAKOS = "kubakos/cycloid-drive-generator, recomputed"


def two_disc_rows(quick: bool) -> list[ValidationRow]:
    """Compare the statics of the preset ``twodisc`` with its published calculation, which assumes ideal load sharing.

    The contacts here are equally stiff, without clearance and friction, on rigid cams. The load is a hundredth of the
    published load, so that the contact points stay those of the ideal parts; forces are multiplied by 100. The rows are
    the largest forces on ring pins, output pins and cams, and the smallest on a cam. With `quick` there are fewer crank
    angles.
    """
    no_gravity = {"gravity_x": 0.0, "gravity_y": 0.0}
    pairs = ("pin_gear", "cam", "output")
    design = PRESETS["twodisc"].but(
        structure="rigid",
        clearance=dict.fromkeys(pairs, 1e-12),
        stiffness={"pin_gear": 1e8, "output": 1e8, "cam": 1e12},
        contact={"stiffness_law": "uniform"},
        environment=no_gravity,
        drive={"speed": 0.0},
    )
    reducer = Reducer(design)
    crank_angles = np.linspace(0.0, 2.0 * np.pi, 181 if quick else 721)
    contact_loads = loads(reducer, springs_of(reducer, crank_angles, friction=False), design.rated_torque / 100.0)
    cam_forces = 100.0 * np.linalg.norm(contact_loads.cam, axis=-1)
    compared_forces = (
        ("largest force on a pin", 100.0 * contact_loads.teeth.max(), 213.14),
        ("largest force on an output pin", 100.0 * contact_loads.output.max(), 1705.9),
        ("largest force of a cam", cam_forces.max(), 2460.0),
        ("smallest force of a cam", cam_forces.min(), 1967.0),
    )
    return [
        relative(f"{quantity}, two discs", float(computed_value), published_value, "N", KUBAKOS, 0.5)
        for quantity, computed_value, published_value in compared_forces
    ]


def krol_stresses(case: KrolVariant) -> tuple[float, float, float]:
    """Compute Hertz's peak pressures of a variant, `case`, of Krol et al. 2019 by their ideal load sharing.

    Returns
    -------
    tuple of float
        Pressure at the lobe's tip, in the valley and on an output sleeve [Pa].
    """
    lobe_count, pin_count = case.pins - 1, case.pins
    eccentricity, pin_radius, width = 1e-3 * case.eccentricity, 1e-3 * case.pin_radius, 1e-3 * case.width
    gear = CycloidGear(pin_count, eccentricity, eccentricity * pin_count / case.shortening, pin_radius)
    tip_curvature, valley_curvature = profile.curvature(gear, [np.pi / lobe_count, 0.0])
    ring_force = 4.0 * case.moment * lobe_count / (eccentricity * lobe_count * pin_count)
    output_force = 2.0 * case.moment * lobe_count * math.cos(2.0 * math.pi / 8) / (math.pi * 1e-3 * case.hole_circle)
    sleeve_curvature = 1e3 / case.sleeve_radius - 1e3 / case.hole_radius
    modulus = ideal_loads.contact_modulus(200e9, 0.3)
    forces = [ring_force, ring_force, output_force]
    curvatures = [1.0 / pin_radius + tip_curvature, 1.0 / pin_radius + valley_curvature, sleeve_curvature]
    lobe_pressure, valley_pressure, output_pressure = ideal_loads.hertz_line_contact(
        forces, width, curvatures, modulus
    ).peak_pressure
    return float(lobe_pressure), float(valley_pressure), float(output_pressure)


def efficiency_rows(quick: bool) -> list[ValidationRow]:
    """Compare the efficiency by the formula of Wang et al. with their printed results and with the simulated reducer.

    Rows that compare the formula with the simulation have no bound, because the formula neglects the moment of friction
    and the clearance. Further rows with bounds compare the simulation with closed forms that include them. `quick`
    shortens the runs.
    """
    rows = []
    for row_number, case in enumerate(WANG, start=1):
        name, values = (
            f"efficiency by formula, row {row_number}",
            (100.0 * total_efficiency(case), 100.0 * case.printed),
        )
        rows.append(absolute(name, *values, "%", "Wang et al. 2016", 100.0 * case.rounding))
    case = WANG[0]
    formula_efficiency = 100.0 * mesh_efficiency(case) * output_efficiency(case)
    ideal_run, ideal_design = wang_run(case, True, quick)
    built_run, built_design = wang_run(case, False, quick)
    closed_form = 100.0 / (1.0 + sum(ideal_losses(Reducer(ideal_design), ideal_run["crank_angle"], case.mesh_friction)))
    ideal_efficiency, built_efficiency = (100.0 * mean_powers(run).efficiency for run in (ideal_run, built_run))
    expected_power = coulomb_friction_power(built_run, Reducer(built_design))
    simulated_power = float(np.mean(built_run["pin_gear_friction_power"]))
    return [
        *rows,
        absolute(
            "efficiency, simulated, ideal",
            ideal_efficiency,
            formula_efficiency,
            "%",
            "Wang et al. 2016",
            None,
            "the formula neglects the moment of friction on the disc, which increases the tooth forces: see next row",
        ),
        absolute(
            "efficiency, simulated, ideal",
            ideal_efficiency,
            closed_form,
            "%",
            "the same with the moment of friction",
            0.2,
        ),
        absolute(
            "efficiency, simulated, as built",
            built_efficiency,
            formula_efficiency,
            "%",
            "Wang et al. 2016",
            None,
            "1 um of clearance and the compliance of the cam displace the disc: pins far from the pitch point, which "
            "slide fastest, carry more; the next row has the loss of these forces",
        ),
        relative(
            "friction power of the mesh, as built",
            simulated_power,
            expected_power,
            "W",
            "mu w sum F (l - rho)/(N-1)",
            0.45,
        ),
    ]


def total_efficiency(case: Wang) -> float:
    """Compute the total efficiency [1] of a case: the product of those of mesh, bearings and output (Wang 2016)."""
    return mesh_efficiency(case) * case.bearings * output_efficiency(case)


def mesh_efficiency(case: Wang) -> float:
    """Compute the efficiency of the mesh: eta_x = eta_nx/(1 + z (1 - eta_nx)), eta_nx = 1 - 4 mu (Dp - d)/(K1 z Dp pi).

    Symbols: z lobes, friction coefficient mu, diameters Dp of the pin circle and d of a pin, trochoid ratio K1.
    """
    lobe_count = case.pins - 1
    eta_nx = 1.0 - 4.0 * case.mesh_friction * (case.pin_circle - case.pin) / (
        case.shortening * lobe_count * case.pin_circle * math.pi
    )
    return eta_nx / (1.0 + lobe_count * (1.0 - eta_nx))


def output_efficiency(case: Wang) -> float:
    """Compute the efficiency of the output pins: eta_sx = 1 - 4 f K1 d Dp/(pi Dw (d + 2 D2)).

    Symbols: friction coefficient f of the sleeves, the trochoid ratio K1, diameters d of an output pin, Dp of the pin
    circle and Dw of the circle of holes, and the wall D2 of a sleeve.
    """
    sleeve = case.output_pin / (case.output_pin + 2.0 * case.sleeve_wall)
    return 1.0 - 4.0 * case.sleeve_friction * sleeve * case.shortening * case.pin_circle / (math.pi * case.hole_circle)


def wang_run(case: Wang, ideal: bool, quick: bool) -> tuple[Run, Design]:
    """Simulate a reducer with the proportions of a `case` of Wang, Luo and Su 2016.

    With `ideal`, clearances are almost zero and the cam is rigid; otherwise they have their defaults. With `quick`, the
    run lasts 8 mesh periods instead of a full turn of the crank.

    Returns
    -------
    tuple
        Samples over full mesh periods after the transient, and the design.
    """
    design = wang_design(case, ideal)
    periods = 8 if quick else case.pins
    settling_time = 0.012
    hold_time = settling_time + periods * 60.0 / (case.speed_rpm * case.pins)
    design = rig.with_changes(Reducer(design), f"drive.hold_s={hold_time!r}").design
    model = build(design)
    if ideal:
        rig.stiffen_cam(model, case.cam_stiffness)
    run = simulate(design, model)
    return run.select(run.time >= settling_time), design


def wang_design(case: Wang, ideal: bool) -> Design:
    """Return a design with the proportions of a `case` of Wang, Luo and Su 2016, with fixed pins.

    With `ideal`, clearances are 1 nm and the contact stiffness is uniform. Rollers on the output pins are represented
    by a smaller coefficient of friction.
    """
    eccentricity = case.shortening * case.pin_circle / 2.0 / case.pins
    sleeve_radius = case.output_pin / 2.0 + case.sleeve_wall
    roller_friction = case.sleeve_friction * case.output_pin / (2.0 * sleeve_radius)
    # the automatic step ignores the stiffness of the cam, which is set in the compiled model only
    ideal_changes = (
        [*rig.clearances(1e-3), 'contact.stiffness_law="uniform"', "settings.timestep_us=2.0"] if ideal else []
    )
    return design_of_kind(
        FIXED,
        f"ring.teeth={case.pins}",
        f"ring.pin_circle_radius_mm={case.pin_circle / 2.0!r}",
        f"ring.pin_radius_mm={case.pin / 2.0!r}",
        f"gear.eccentricity_mm={eccentricity!r}",
        "gear.bore_radius_mm=30.0",
        f"output.pin_circle_radius_mm={case.hole_circle / 2.0!r}",
        f"output.pin_radius_mm={sleeve_radius!r}",
        f"output.hole_radius_mm={sleeve_radius + eccentricity!r}",
        "housing.outer_radius_mm=80.0",
        "shaft.counterweight_radius_mm=45.0",
        f"friction.pin_gear={case.mesh_friction}",
        f"friction.output_rolling={roller_friction!r}",
        # The formula has separate factors for the bearings.
        "friction.cam_rolling=0.0",
        f"drive.speed_rpm={case.speed_rpm}",
        f"load.torque_nm={case.load}",
        # Contacts of this force slide with full friction.
        "contact.working_force_n=400.0",
        "settings.log_rate_hz=20000.0",
        *ideal_changes,
    )


def coulomb_friction_power(run: Run, reducer: Reducer) -> float:
    """Compute the mean friction power of the mesh over a run [W] by Coulomb's law from the logged normal forces."""
    design = reducer.design
    gear = tooth_profile(design)
    phase = profile.pin_angles(gear) + run["crank_angle"][:, np.newaxis]
    inward = -profile.unit(profile.pin_angles(gear) - profile.conjugate_alpha(gear, phase))
    normal_force = np.sum(run.forces(design.tooth_pair) * inward, axis=-1)
    sliding_radius = profile.pitch_distance(gear, phase) - gear.pin_radius
    disc_speed = design.drive.speed / gear.lobes
    return float(design.friction.pin_gear * disc_speed * np.mean(np.sum(normal_force * sliding_radius, axis=1)))
