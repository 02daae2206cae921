"""Every item of a rating, from the loads at each point of a duty."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from cycloid_mj import profile
from cycloid_mj.checks.strength import SHEAR, TENSION, walls
from cycloid_mj.contact.pressure import SHAKEDOWN_PRESSURE, YIELD_PRESSURE, pair_strength, roller_radius
from cycloid_mj.design import PARTS, Design
from cycloid_mj.design.materials import MATERIALS
from cycloid_mj.errors import DesignError
from cycloid_mj.modification import gear_profile, profile_offset
from cycloid_mj.rating import rolling
from cycloid_mj.rating.duty import Duty, steady
from cycloid_mj.rating.fatigue import Fatigue, endurance_limit, notch_factor
from cycloid_mj.rating.item import Item, Rating
from cycloid_mj.rating.loading import Loading, bending, loading
from cycloid_mj.solid.output import AXIAL_GAP
from cycloid_mj.stress.notch import BENDING, TORSION, shoulder_factor
from cycloid_mj.stress.shaftgrid import shaft_measures

LIFE = 10_000.0
"""Hours that are asked for where nothing else is."""

NEEDLE_FILL = 0.35
"""Of the radius of an output roller: what its needles are thick, where their rating is not given."""

SHAFT_ROLLERS, SHAFT_ROLLER_SHARE = 14, 0.4
"""Rollers of a shaft bearing, and their diameter over the shaft's radius, where its rating is not given."""

PITTING = 2.22, 200e6
"""Allowable pressure at 10^7 cycles, S_c = 2.22 HB + 200 MPa: through-hardened steel, grade 1 (AGMA 2001-D04, 10.3)."""

PITTING_LIFE = 2.466, 0.056
"""Stress-cycle factor Z_N = 2.466 n^-0.056 (AGMA 2001-D04, Fig. 17), for every number of cycles."""

BRINELL = 3.45e6
"""Tensile strength of steel per Brinell hardness [Pa] (ISO 18265)."""

TOUCHING = {"pin_gear": "teeth on pins", "tooth": "gear on internal gear", "output": "output pins in holes"}
SEATED = {"pin_socket": "pins in sockets"}

ANGLES = np.linspace(0.0, math.pi, 36, endpoint=False)
"""Directions around the shaft in which fibres are looked at [rad]."""


def rate(design: Design, duty: Duty | None = None, life: float = LIFE) -> Rating:
    """Rate a sound design under a duty, by default its rated torque and speed, for a life [h].

    Raises
    ------
    DesignError
        The crank does not turn.
    RunError
        The drive cannot hold a torque of the duty.
    """
    duty = duty or steady(design.rated_torque, design.drive.speed)
    if not all(point.speed for point in duty.points):
        raise DesignError("drive.speed_rpm is 0, but lives need a crank that turns: give another speed, such as 1640")
    found = [loading(design, point) for point in duty.points]
    worst = max(found, key=lambda one: abs(one.point.torque))
    items = [
        *_bearings(design, found),
        *_surfaces(design, found),
        *_fatigue(design, worst),
        *_wear(design, found),
        _heat(design, found),
        *_peak(design, duty, worst),
    ]
    ordered = sorted(items, key=lambda item: item.margin(life))
    return Rating(design.name, duty.words, life, {item.key: item for item in ordered}, tuple(_assumptions(design)))


def _turning(design: Design, speed: float) -> float:
    """Speed of crank and gear against each other [rad/s]: the gear turns back by one in N - 1."""
    return abs(speed) * (1.0 + 1.0 / design.lobes)


def _bearings(design: Design, found: Sequence[Loading]) -> Iterator[Item]:
    bearing = design.bearing
    turns = np.array([_turning(design, one.point.speed) * one.point.share for one in found])
    cam = design.bearing.dynamic_capacity or rolling.dynamic_capacity(*_cam_rollers(design))
    given = "" if bearing.dynamic_capacity else f"{design.contact.cam_rollers} rollers side by side on the cam's circle"
    if design.gear.bearing == "rolling":
        yield _life(design, "cam_bearing", "cam bearing, life", [one.cam for one in found], turns, cam, given)
        static = bearing.static_capacity or rolling.static_capacity(*_cam_rollers(design))
        peak = max(float(one.cam.max()) for one in found)
        yield Item(
            "cam_bearing_static",
            "cam bearing, standing",
            peak,
            static,
            "N",
            static / peak,
            None,
            "C0/P0, ISO 76",
            given,
        )
    radius = design.shaft.radius
    size = SHAFT_ROLLER_SHARE * radius
    width = shaft_measures(design).bearings[0]
    rated = rolling.dynamic_capacity(SHAFT_ROLLERS, size, width[1] - width[0], 2.0 * radius + size)
    shaft = bearing.shaft_dynamic_capacity or rated
    given = "" if bearing.shaft_dynamic_capacity else f"{SHAFT_ROLLERS} rollers of {1e3 * size:.3g} mm (assumed)"
    crank = np.array([abs(one.point.speed) * one.point.share for one in found])
    for place, name in ((2, "far"), (3, "near")):
        force = [rolling.magnitudes(one.shaft[:, place]) for one in found]
        yield _life(design, f"shaft_bearing_{name}", f"shaft bearing, {name} from the gear", force, crank, shaft, given)
    if design.output.rollers:
        needle = NEEDLE_FILL * (design.output.pin_radius - design.output.root_radius) * 2.0
        pitch = 2.0 * design.output.root_radius + needle
        count = max(int(math.pi * pitch / needle), 3)
        needles = rolling.dynamic_capacity(count, needle, design.gear.face_width, pitch)
        capacity = bearing.output_dynamic_capacity or needles
        given = "" if bearing.output_dynamic_capacity else f"{count} needles of {1e3 * needle:.3g} mm (assumed)"
        # a roller turns on its pin as often as it rolls round its hole
        rolls = crank * (design.output.hole_radius / design.output.pin_radius - 1.0 + 1.0 / design.lobes)
        loads = [one.output for one in found]
        yield _life(design, "output_rollers", "rollers of the output pins, life", loads, rolls, capacity, given)


def _cam_rollers(design: Design) -> tuple[int, float, float, float]:
    gear = design.gear
    return design.contact.cam_rollers, 2.0 * roller_radius(design), gear.face_width, 2.0 * gear.bore_radius


def _life(
    design: Design, key: str, name: str, force: Sequence[np.ndarray], turns: np.ndarray, capacity: float, note: str
) -> Item:
    """Rate one bearing; `turns` are its relative speeds at each point, times the share of the time [rad/s]."""
    bearing = design.bearing
    means = np.array([rolling.mean_load(one) for one in force])
    load = bearing.service_factor * rolling.mean_load(means, turns)
    life = rolling.life_hours(capacity, load, float(turns.sum()), bearing.reliability)
    sure = f"a1 at {bearing.reliability:.0%}"
    return Item(key, name, load, capacity, "N", None, life, f"L = a1 (C/P)^(10/3), {sure}, ISO 281", note)


def _surfaces(design: Design, found: Sequence[Loading]) -> Iterator[Item]:
    """Rate the pressures of teeth, holes and seats: shakedown by the worst, pitting by Miner's sum."""
    for kind, name in (TOUCHING | SEATED).items():
        if kind not in found[0].pressures:
            continue
        pressure = max(one.pressures[kind] for one in found)
        if not pressure > 0.0:
            continue
        shakedown = SHAKEDOWN_PRESSURE * pair_strength(design, kind)
        source = "4 k over Hertz's p0 (Johnson 1985, 9.2)"
        yield Item(
            f"{kind}_shakedown",
            f"{name}, shakedown",
            1e-6 * pressure,
            1e-6 * shakedown,
            "MPa",
            shakedown / pressure,
            None,
            source,
        )
        if kind in SEATED or any(part.youngs_modulus < 1e11 for part in design.partners(kind)):
            continue
        allowed = pitting_pressure(min(part.tensile_strength for part in design.partners(kind)))
        damage = 0.0
        for one in found:
            cycles = _turning(design, one.point.speed) / (2.0 * math.pi) * 3600.0 * one.point.share
            damage += cycles / pitting_cycles(one.pressures[kind], allowed) if one.pressures[kind] > 0.0 else 0.0
        yield Item(
            f"{kind}_pitting",
            f"{name}, pitting",
            1e-6 * pressure,
            1e-6 * allowed,
            "MPa",
            None,
            1.0 / damage,
            "Z_N = 2.466 n^-0.056, AGMA 2001-D04",
            "one cycle a turn of the crank against the gear",
        )


def pitting_pressure(tensile: float) -> float:
    """Give the pressure [Pa] that a steel of a tensile strength [Pa] bears 10^7 times without pits."""
    slope, base = PITTING
    return slope * 1e6 * tensile / BRINELL + base


def pitting_cycles(pressure: float, allowed: float) -> float:
    """Give the cycles until pits at a pressure [Pa], by what is allowed for 10^7 [Pa]."""
    factor, power = PITTING_LIFE
    return float((factor * allowed / pressure) ** (1.0 / power))


def _fatigue(design: Design, worst: Loading) -> Iterator[Item]:
    """Rate output pins, the shaft's shoulders and the walls against endless repetition of the largest load."""
    yield output_pin(design, float(worst.output.max()))
    yield from _shoulders(design, worst)
    for wall in walls(design):
        made = design.material_of(wall.part)
        force = worst.teeth if wall.kind == design.tooth_pair else float(worst.output.max())
        half = 0.5 * wall.stress(force, design.gear.face_width) / wall.share
        safety = Fatigue(half, half, _endurance(design, made.tensile_strength, wall.thickness), made.tensile_strength)
        kind = {TENSION: "tension", SHEAR: "shear"}[wall.share]
        yield Item(
            f"{wall.name}_fatigue",
            f"wall {wall.where}, fatigue",
            2e-6 * half,
            1e-6 * safety.endurance,
            "MPa",
            safety.safety,
            None,
            f"Goodman, pulsating {kind}, as von Mises stress",
        )


def output_pin(design: Design, force: float) -> Item:
    """Rate the root of an output pin, a cantilever under a force [N] in the middle of the gear, which pulsates."""
    output, made = design.output, design.material_of("output")
    radius, fillet = output.root_radius, output.root_fillet
    nominal = 4.0 * force * (design.gear.face_width / 2.0 + AXIAL_GAP) / (math.pi * radius**3)
    shape = shoulder_factor(radius, fillet, math.inf, BENDING)
    notch = design.service.notch_factor or notch_factor(shape, fillet, made.tensile_strength)
    half = 0.5 * notch * nominal
    fatigue = Fatigue(half, half, _endurance(design, made.tensile_strength, 2.0 * radius), made.tensile_strength)
    return Item(
        "output_pin_fatigue",
        "output pin at its root, fatigue",
        1e-6 * nominal,
        1e-6 * fatigue.endurance,
        "MPa",
        fatigue.safety,
        None,
        "Goodman, pulsating bending of a cantilever",
        f"notch factor {notch:.3g}",
    )


def _shoulders(design: Design, worst: Loading) -> Iterator[Item]:
    """Rate the shaft's shoulders; in its own frame the load stands nearly still, and its ripple is the amplitude."""
    shaft, made, fillet = shaft_measures(design), design.material_of("shaft"), design.shaft.shoulder_fillet
    around = np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1)
    section = 4.0 / (math.pi * shaft.radius**3)
    endurance = _endurance(design, made.tensile_strength, 2.0 * shaft.radius)
    found: list[tuple[float, Item]] = []
    for shoulder in shaft.shoulders:
        factors = [
            notch_factor(shoulder_factor(shaft.radius, fillet, shoulder.outer, terms), fillet, made.tensile_strength)
            for terms in (BENDING, TORSION)
        ]
        stress = factors[0] * section * bending(worst, shoulder.z) @ around.T
        shear = factors[1] * 0.5 * section * worst.crank_torque
        high, low = stress.max(axis=0), stress.min(axis=0)
        amplitude = 0.5 * (high - low)
        mean = np.hypot(0.5 * (high + low), math.sqrt(3.0) * shear)
        used = int(np.argmax(amplitude / endurance + mean / made.tensile_strength))
        fatigue = Fatigue(float(amplitude[used]), float(mean[used]), endurance, made.tensile_strength)
        item = Item(
            "shaft_fatigue",
            f"shaft, {shoulder.name}, fatigue",
            1e-6 * float(mean[used] + amplitude[used]),
            1e-6 * endurance,
            "MPa",
            fatigue.safety,
            None,
            "Goodman, notch factors of DIN 743-2, a ripple on a standing load",
            f"notch factor {factors[0]:.3g} in bending",
        )
        found.append((fatigue.safety, item))
    yield min(found, key=lambda one: one[0])[1]


def _endurance(design: Design, tensile: float, thickness: float) -> float:
    service, bearing = design.service, design.bearing
    given = service.endurance_limit
    return given or endurance_limit(tensile, thickness, service.surface, bearing.reliability)


def _wear(design: Design, found: Sequence[Loading]) -> Iterator[Item]:
    """Rate wear by Archard: volume k F s, spread over the flanks of the gear and the walls of its holes."""
    gear, width = gear_profile(design), design.gear.face_width
    flanks = float(profile.arc_length(gear, 2.0 * math.pi, profile_offset(design))) * width
    holes = 2.0 * math.pi * design.output.hole_radius * design.output.pins * width
    for kind, part, area in ((design.tooth_pair, "teeth", flanks), ("output", "output", holes)):
        coefficient = design.mesh_friction if part == "teeth" else design.friction_of(kind)
        if not coefficient:
            continue
        rubbed = sum(one.losses[part] * one.point.share for one in found) / coefficient
        depth = design.service.wear_coefficient * rubbed * 3.6e6 / area
        limit = getattr(design.clearance, kind)
        life = 1000.0 * limit / depth if depth else math.inf
        yield Item(
            f"{kind}_wear",
            f"wear of the gear by {kind.replace('_', ' ')}, per 1000 h",
            1e6 * depth,
            1e6 * limit,
            "um",
            None,
            life,
            "Archard, k F s over the whole surface; until the clearance has doubled",
            f"k = {1e9 * design.service.wear_coefficient:g} mm3/(N m)",
        )


def _heat(design: Design, found: Sequence[Loading]) -> Item:
    """Rate the housing's temperature in still air, by what the softest part bears."""
    service, housing = design.service, design.housing
    lost = sum(sum(one.losses.values()) * one.point.share for one in found)
    length = design.gear.face_width + design.output.disc_thickness
    area = 2.0 * math.pi * housing.outer_radius * (housing.outer_radius + length)
    hot = service.ambient_temperature + lost / (service.film_coefficient * area)
    limit = min(hottest(design))
    safety = (limit - service.ambient_temperature) / max(hot - service.ambient_temperature, 1e-12)
    return Item(
        "temperature",
        "housing temperature",
        hot,
        limit,
        "°C",
        safety,
        None,
        "dT = losses/(h A), whole outside",
        f"{lost:.3g} W, h = {service.film_coefficient:g} W/(m2 K), {1e4 * area:.3g} cm2; safety of the rise",
    )


def hottest(design: Design) -> Iterator[float]:
    """Give the temperature that each part may have in service [°C]; 120 where its material is not of the library."""
    for part in PARTS:
        entry = MATERIALS.get(design.material_of(part).name)
        yield entry.hottest if entry else 120.0


def _peak(design: Design, duty: Duty, worst: Loading) -> Iterator[Item]:
    """Rate the torque of an emergency stop: first yield of every contact, and shear of the output pins."""
    yields: dict[str, float] = {}
    for kind, pressure in worst.pressures.items():
        if pressure > 0.0:
            allowed = YIELD_PRESSURE * pair_strength(design, kind)
            yields[kind] = abs(worst.point.torque) * (allowed / pressure) ** 2
    kind = min(yields, key=lambda one: yields[one])
    yield Item(
        "peak_yield",
        "emergency stop, first yield",
        duty.peak,
        yields[kind],
        "N m",
        yields[kind] / duty.peak,
        None,
        "1.79 yield strength over Hertz's p0, which goes with the root of the torque",
        f"in {kind}",
    )
    made, radius = design.material_of("output"), design.output.root_radius
    force = float(worst.output.max()) * duty.peak / abs(worst.point.torque)
    shear, strength = force / (math.pi * radius**2), made.yield_strength / math.sqrt(3.0)
    yield Item(
        "peak_pin_shear",
        "emergency stop, shear of an output pin",
        1e-6 * shear,
        1e-6 * strength,
        "MPa",
        strength / shear,
        None,
        "F/(pi r^2) against the yield strength over sqrt(3)",
    )


def _assumptions(design: Design) -> Iterator[str]:
    service, bearing = design.service, design.bearing
    yield "forces by statics with friction at the clearances of the design, a crank that turns evenly"
    yield f"reliability {bearing.reliability:.0%} (bearing.reliability), service factor {bearing.service_factor:g}"
    if not service.endurance_limit:
        yield f"endurance limits by tensile strength, {service.surface} surface, size and reliability (Shigley)"
    yield f"wear coefficient {1e9 * service.wear_coefficient:g} mm3/(N m), mixed lubrication (assumed, within a decade)"
    yield f"air of {service.ambient_temperature:g} °C, h = {service.film_coefficient:g} W/(m2 K) (assumed, 8 to 15)"
