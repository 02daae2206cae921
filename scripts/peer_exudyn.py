"""Compare Exudyn with this project: cost and results for the same gear, ring of fixed pins, cam and load.

Exudyn is no dependency: install it in a separate environment together with this project, and run this script there.

    pip install exudyn==1.13.6
    python scripts/peer_exudyn.py

Both have one planar gear on a cam that turns at constant speed, with the load on the gear itself (Exudyn's model has
no pins in holes), uniform contact stiffness, no play in the cam and no friction there. Exudyn's settings are the best
of those tried on version 1.13.6. For its own contact, a polygon, these are generalised alpha at 10 us (20 us fails),
contact model 0 (model 1 does not converge), no contact damping (with it the efficiency without friction leaves 1), and
as many segments as it takes, since ``polynomialData`` is refused. A segment is a bed of springs per length, with the
stiffness of our contact at the working force, so mean transmission errors may differ by some percent. With contacts
that its user compiles (numba), of the exact teeth and of free pins in their sockets, it is its explicit RK44.
"""

import argparse
import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numba import njit

from cycloid_mj.base.array import Array
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.dynamics.contact.collider import install
from cycloid_mj.dynamics.drive_cycle import initial_state, ramp_and_hold
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.geometry.modification import gear_profile, profile_offset, tooth_profile
from cycloid_mj.geometry.profile import pin_angles, sample, unit
from cycloid_mj.reducer import Reducer

SAMPLING = 1e-4  # interval of the results [s]
LOAD = 36.0  # torque on the output [N m], as in `validate`


@dataclass(frozen=True)
class Motion:
    """Samples of a run: crank angle [rad], gear angle [rad] and speed [rad/s], torque on the crank [N m], shape (n,).

    `cpu` is the CPU time [s] of the steps of a whole second.
    """

    crank: Array
    gear: Array
    speed: Array
    torque: Array
    cpu: float


def _solve(exu: Any, mbs: Any, end: float, timestep: float, solver: Any) -> float:
    """Solve an assembled Exudyn system up to the time `end` with a fixed step [s].

    Return the CPU time of a simulated second [s].
    """
    settings = exu.SimulationSettings()
    settings.timeIntegration.endTime, settings.timeIntegration.numberOfSteps = end, round(end / timestep)
    settings.timeIntegration.automaticStepSize = settings.timeIntegration.adaptiveStep = False
    settings.timeIntegration.verboseMode = 0
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = SAMPLING
    begin = time.process_time()
    mbs.SolveDynamic(settings, solverType=solver)
    return (time.process_time() - begin) / end


def reduced_design(timestep: float, friction: float, pins: str = "fixed") -> Design:
    """Return the preset `pin` reduced to the features of Exudyn's model: uniform contacts, a rigid cam, no output.

    `timestep` is in [s], `friction` is that of pin on gear, `pins` the kind of ring pins.
    """
    changes = [
        f'ring.pins="{pins}"',
        'contact.stiffness_law="uniform"',
        "clearance.cam_um=0.001",
        "clearance.output_um=500.0",
        "drive.ramp_s=0.0",
        "drive.rotor_inertia_kg_m2=10.0",
        f"settings.timestep_us={timestep * 1e6!r}",
        f"friction.pin_gear={friction}",
        "friction.cam_rolling=0.0",
        f"load.torque_nm={LOAD}",
    ]
    return override(PRESETS["pin"], changes)


def run_ours(timestep: float, friction: float, end: float, pins: str = "fixed") -> Motion:
    """Simulate this project's model in MuJoCo, with the load on the gear.

    `timestep` and `end` are time step and duration [s], `friction` is that of pin on gear, `pins` the kind of ring
    pins, ``fixed`` or ``free``.
    """
    design = reduced_design(timestep, friction, pins)
    compiled = build(design)
    data = initial_state(compiled, Reducer(design))
    data.joint("gear_angle").qfrc_applied[0] = LOAD
    commands = ramp_and_hold(compiled, Reducer(design)).commands(
        timestep * np.arange(round(end / timestep), dtype=np.float64)
    )
    commands[:, 1] = 0.0  # the output, which nothing holds, has no load: that is on the gear
    stride, rows = round(SAMPLING / timestep), []
    crank, gear, drive = data.joint("crank"), data.joint("gear_angle"), data.actuator("drive")
    with install():
        start = time.process_time()
        for number, command in enumerate(commands):
            data.ctrl[:] = command
            mujoco.mj_step(compiled.model, data)
            if number % stride == 0:
                rows.append((crank.qpos[0], gear.qpos[0], gear.qvel[0], drive.force[0]))
        cpu = (time.process_time() - start) / end
    theta, gamma, speed, torque = np.array(rows).T
    return Motion(theta, gamma, speed, torque, cpu)


def match_stiffness(design: Design, stiffness: float) -> float:
    """Compute the bedding modulus [N/m2] at which a pin enters Exudyn's segments as deep as it enters our contact.

    A circle of radius rho that is pressed into the bed by the depth p experiences a force of 4/3 sqrt(2 rho) p^(3/2)
    times the modulus. `stiffness` is that of our contact [N/m].
    """
    force = Reducer(design).contacts[design.tooth_pair].force
    return force / (4.0 / 3.0 * math.sqrt(2.0 * design.ring.pin_radius) * (force / stiffness) ** 1.5)


def _add_teeth(mbs: Any, design: Design, markers: list[Any], segments: int, stiffness: float, friction: float) -> None:
    """Add the contact of the ring pins with the gear's outline to an Exudyn system `mbs`.

    The outline is a polygon of `segments`; `markers` are those of the gear and then of the pins. `stiffness` is the
    bedding modulus [N/m2].
    """
    import exudyn as exu  # type: ignore[import-not-found]
    from exudyn import itemInterface as item

    # Going along a segment, Exudyn has the outside on the right.
    corners = sample(gear_profile(design), segments, profile_offset(design)).points[::-1]
    edges = np.hstack([corners, np.roll(corners, -1, axis=0)])
    active = mbs.AddNode(
        item.NodeGenericData(initialCoordinates=[-1, 0, 0] * segments, numberOfDataCoordinates=3 * segments)
    )
    mbs.AddObject(
        item.ObjectContactCurveCircles(
            markerNumbers=markers,
            nodeNumber=active,
            circlesRadii=[design.ring.pin_radius] * design.ring.teeth,
            segmentsData=exu.MatrixContainer(edges),
            contactStiffness=stiffness,
            dynamicFriction=friction,
            frictionProportionalZone=Reducer(design).contacts.creep_speed,
        )
    )


def run_exudyn(timestep: float, friction: float, end: float, segments: int) -> Motion:
    """Simulate Exudyn's model with a polygon of `segments` as the gear's outline, by the generalized-alpha integrator.

    Other parameters are those of `run_ours`.
    """
    import exudyn as exu
    from exudyn import itemInterface as item

    design = reduced_design(timestep, friction)
    compiled = build(design)
    tooth, cam, gear = compiled.laws["pin_gear"], compiled.laws["cam"], compiled.model.body("gear")
    speed, eccentricity = design.drive.speed, design.gear.eccentricity
    mbs = exu.SystemContainer().AddSystem()
    crank_node = mbs.AddNode(item.Node1D(initialVelocities=[speed]))
    crank = mbs.AddObject(item.ObjectRotationalMass1D(inertia=100.0, nodeNumber=crank_node))
    start = [-eccentricity * speed, 0.0, -speed / design.lobes]
    gear_node = mbs.AddNode(item.NodeRigidBody2D(referenceCoordinates=[0, eccentricity, 0], initialVelocities=start))
    mass, inertia = float(gear.mass[0]), float(gear.inertia[0])
    wheel = mbs.AddObject(item.ObjectRigidBody2D(mass=mass, inertia=inertia, nodeNumber=gear_node))
    # A marker on the ground makes this contact fail (size mismatch): the ring is a body that nothing moves.
    ring_node = mbs.AddNode(item.NodeRigidBody2D())
    ring = mbs.AddObject(item.ObjectRigidBody2D(mass=1e9, inertia=1e9, nodeNumber=ring_node))

    def marker(body: Any, x: float = 0.0, y: float = 0.0) -> Any:
        return mbs.AddMarker(item.MarkerBodyRigid(bodyNumber=body, localPosition=[x, y, 0]))

    on_gear = marker(wheel)
    bearing = mbs.AddObject(
        item.ObjectConnectorCartesianSpringDamper(
            markerNumbers=[marker(crank, y=eccentricity), on_gear],
            stiffness=[cam.stiffness] * 2 + [0],
            damping=[cam.damping] * 2 + [0],
        )
    )
    radius = design.ring.pin_circle_radius
    pins = [
        marker(ring, radius * math.sin(angle), radius * math.cos(angle)) for angle in pin_angles(tooth_profile(design))
    ]
    _add_teeth(mbs, design, [on_gear, *pins], segments, match_stiffness(design, tooth.stiffness), friction)
    mbs.AddLoad(item.LoadTorqueVector(markerNumber=on_gear, loadVector=[0, 0, LOAD]))

    def sensor(what: Any, kind: str, **of: Any) -> Any:
        return mbs.AddSensor(what(**of, storeInternal=True, outputVariableType=getattr(exu.OutputVariableType, kind)))

    sensors = [
        sensor(item.SensorNode, "Coordinates", nodeNumber=crank_node),
        sensor(item.SensorNode, "Coordinates", nodeNumber=gear_node),
        sensor(item.SensorNode, "Coordinates_t", nodeNumber=gear_node),
        sensor(item.SensorObject, "Force", objectNumber=bearing),
    ]
    mbs.Assemble()
    cpu = _solve(exu, mbs, end, timestep, exu.DynamicSolverType.GeneralizedAlpha)
    crank_coordinates, gear_coordinates, velocity, force = (
        mbs.GetSensorStoredData(number)[:, 1:] for number in sensors
    )
    theta = crank_coordinates[:, 0]
    torque = eccentricity * (np.sin(theta) * force[:, 1] + np.cos(theta) * force[:, 0])
    return Motion(theta, gear_coordinates[:, 2], velocity[:, 2], torque, cpu)


class Parts(NamedTuple):
    """Parts on which the compiled forces act: lengths [m], and the law of each contact [N/m, N s/m].

    `places` (N, 2) are those of the pins, and `pin` is 1 where they move. The trochoid, on which ideal pins have their
    centres, is E u(t) - c u(N t) with u(b) = (sin b, cos b).
    """

    E: float
    c: float
    N: float
    radius: float
    clearance: float
    play: float
    places: Array
    tooth: tuple[float, float]
    seat: tuple[float, float]
    cam: tuple[float, float]
    friction: tuple[float, float]
    creep: float
    speed: float
    load: float
    pin: int


@njit(error_model="numpy")
def nearest_point(parts: Parts, x: float, y: float, t: float) -> tuple[float, float, float, float, float]:
    """Find the point of the trochoid nearest to (x, y) [m] by Newton's method from the parameter t [rad].

    Return its parameter, the components of the vector from the point to (x, y) [m], and those of the tangent [m/rad].
    """
    for _ in range(8):
        st, ct, sn, cn = math.sin(t), math.cos(t), math.sin(parts.N * t), math.cos(parts.N * t)
        rx, ry = x - parts.E * st + parts.c * sn, y - parts.E * ct + parts.c * cn
        tx, ty = parts.E * ct - parts.c * parts.N * cn, -parts.E * st + parts.c * parts.N * sn
        bx, by = -parts.E * st + parts.c * parts.N**2 * sn, -parts.E * ct + parts.c * parts.N**2 * cn
        square = tx * tx + ty * ty
        step = (rx * tx + ry * ty) / max(square - rx * bx - ry * by, 0.1 * square)
        t += min(max(step, -0.2 / parts.N), 0.2 / parts.N)
        if abs(step) < 1e-9:
            break
    return t, rx, ry, tx, ty


@njit(error_model="numpy")
def add_seat_force(parts: Parts, state: tuple[float, float, float, float, float], out: Array) -> None:
    """Add the force of a pin's seat to `out`: force on x and y [N] and torque [N m] of the pin.

    `state` is the pin's displacement (x, y) [m] from the middle of its seat, its velocity [m/s] and spin [rad/s].
    """
    ex, ey, pu, pv, spin = state
    distance = math.hypot(ex, ey)
    if distance <= parts.play:  # a circle in a circle
        return
    nx, ny = -ex / distance, -ey / distance
    normal = parts.seat[0] * (distance - parts.play) - parts.seat[1] * (nx * pu + ny * pv)
    if normal > 0.0:
        slip = -ny * pu + nx * pv - parts.radius * spin
        side = -parts.friction[1] * normal * min(max(slip / parts.creep, -1.0), 1.0)
        out[0] += normal * nx - side * ny
        out[1] += normal * ny + side * nx
        out[2] -= side * parts.radius


@njit(error_model="numpy")
def forces(parts: Parts, time: float, q: Array, v: Array, parameters: Array, out: Array) -> None:
    """Write the forces of all contacts, the cam and the load into `out`: on x, y and angle of the gear, then of pins.

    `q` and `v` are these coordinates [m, rad] and their velocities. `parameters` (N,) are those of the points of the
    trochoid nearest to the pins, where Newton's method starts; they are updated.
    """
    out[:] = 0.0
    theta = parts.speed * time
    x, y, angle = q[0], q[1], q[2]
    sine, cosine = math.sin(angle), math.cos(angle)
    stretch_x, stretch_y = x + parts.c * math.sin(theta), y - parts.c * math.cos(theta)
    rate_x = v[0] + parts.c * parts.speed * math.cos(theta)
    rate_y = v[1] + parts.c * parts.speed * math.sin(theta)
    out[0] -= parts.cam[0] * stretch_x + parts.cam[1] * rate_x
    out[1] -= parts.cam[0] * stretch_y + parts.cam[1] * rate_y
    out[2] += parts.load
    for i in range(parts.places.shape[0]):
        row = 3 + 3 * i
        px, py, pu, pv, spin = parts.places[i, 0], parts.places[i, 1], 0.0, 0.0, 0.0
        if parts.pin:
            pu, pv, spin = v[row], v[row + 1], v[row + 2]
            add_seat_force(parts, (q[row], q[row + 1], pu, pv, spin), out[row : row + 3])
            px, py = px + q[row], py + q[row + 1]
        ax, ay = px - x, py - y
        # seen from the gear
        t, rx, ry, tx, ty = nearest_point(parts, cosine * ax + sine * ay, cosine * ay - sine * ax, parameters[i])
        parameters[i] = t
        size = math.hypot(tx, ty)
        ox, oy = -ty / size, tx / size  # outwards, seen from the gear
        depth = -(rx * ox + ry * oy) - parts.clearance
        if depth <= 0.0:
            continue
        nx, ny = cosine * ox - sine * oy, sine * ox + cosine * oy
        hx, hy = ax - parts.radius * nx, ay - parts.radius * ny
        apart_x = pu + parts.radius * spin * ny - v[0] + v[2] * hy
        apart_y = pv - parts.radius * spin * nx - v[1] - v[2] * hx
        normal = parts.tooth[0] * depth - parts.tooth[1] * (nx * apart_x + ny * apart_y)
        if normal <= 0.0:
            continue
        slip = -ny * apart_x + nx * apart_y
        side = -parts.friction[0] * normal * min(max(slip / parts.creep, -1.0), 1.0)
        fx, fy = normal * nx - side * ny, normal * ny + side * nx
        out[0] -= fx
        out[1] -= fy
        out[2] -= hx * fy - hy * fx
        if parts.pin:
            out[row] += fx
            out[row + 1] += fy
            out[row + 2] -= side * parts.radius


def _collect_parts(design: Design, laws: Mapping[str, Any], friction: float, free: bool) -> Parts:
    """Collect dimensions and contact laws of a design for the compiled contacts."""
    gear = tooth_profile(design)

    def law(kind: str) -> tuple[float, float]:
        return (laws[kind].stiffness, laws[kind].damping) if kind in laws else (0.0, 0.0)

    return Parts(
        E=gear.pin_circle_radius,
        c=gear.eccentricity,
        N=float(gear.ring_teeth),
        radius=gear.pin_radius,
        clearance=design.clearance.pin_gear,
        play=design.clearance.pin_socket,
        places=gear.pin_circle_radius * unit(pin_angles(gear)),
        tooth=law("pin_gear"),
        seat=law("pin_socket"),
        cam=law("cam"),
        friction=(friction, design.friction_of("pin_socket")),
        creep=Reducer(design).contacts.creep_speed,
        speed=design.drive.speed,
        load=LOAD,
        pin=int(free),
    )


def run_compiled(timestep: float, friction: float, end: float, pins: str = "fixed") -> Motion:
    """Simulate with Exudyn's integrator (RK44) and contacts compiled here: exact teeth, fixed or free pins.

    The parameters are those of `run_ours`.
    """
    import exudyn as exu
    from exudyn import itemInterface as item

    design = reduced_design(timestep, friction, pins)
    compiled, gear, free = build(design), tooth_profile(design), pins == "free"
    angles = pin_angles(gear)
    parts = _collect_parts(design, compiled.laws, friction, free)
    bodies = [compiled.model.body("gear"), *(compiled.model.body(f"pin_{i + 1}") for i in range(len(angles)) if free)]
    mass = np.concatenate([[body.mass[0], body.mass[0], inertia_about_axis(body)] for body in bodies])
    speeds = np.zeros(mass.size)
    speeds[:3] = -gear.eccentricity * parts.speed, 0.0, -parts.speed / gear.lobes
    start_coordinates = np.zeros(mass.size)
    start_coordinates[1] = gear.eccentricity
    parameters, out = np.array(angles), np.zeros(mass.size)

    def force(mbs: Any, time: float, number: int, q: Any, v: Any) -> Any:
        forces(parts, time, np.asarray(q), np.asarray(v), parameters, out)
        return out

    forces(parts, 0.0, start_coordinates, speeds, parameters.copy(), out)  # compiled before the clock starts
    mbs = exu.SystemContainer().AddSystem()
    node = mbs.AddNode(
        item.NodeGenericODE2(
            referenceCoordinates=[0.0] * mass.size,
            initialCoordinates=start_coordinates.tolist(),
            initialCoordinates_t=speeds.tolist(),
            numberOfODE2Coordinates=mass.size,
        )
    )
    mbs.AddObject(item.ObjectGenericODE2(nodeNumbers=[node], massMatrix=np.diag(mass), forceUserFunction=force))
    kinds = ("Coordinates", "Coordinates_t")
    sensors = [
        mbs.AddSensor(
            item.SensorNode(
                nodeNumber=node, storeInternal=True, outputVariableType=getattr(exu.OutputVariableType, kind)
            )
        )
        for kind in kinds
    ]
    mbs.Assemble()
    cpu = _solve(exu, mbs, end, timestep, exu.DynamicSolverType.RK44)
    stored = [mbs.GetSensorStoredData(number) for number in sensors]
    theta = parts.speed * stored[0][:, 0]
    (x, y, angle), (u, v, rate) = (sample[:, 1:4].T for sample in stored)
    force_x = parts.cam[0] * (x + parts.c * np.sin(theta)) + parts.cam[1] * (u + parts.c * parts.speed * np.cos(theta))
    force_y = parts.cam[0] * (y - parts.c * np.cos(theta)) + parts.cam[1] * (v + parts.c * parts.speed * np.sin(theta))
    torque = parts.c * (np.cos(theta) * force_x + np.sin(theta) * force_y)
    return Motion(theta, angle, rate, torque, cpu)


def inertia_about_axis(body: Any) -> float:
    """Compute the moment of inertia of a body about the axis of the crank [kg m2]."""
    axes = np.empty(9)
    mujoco.mju_quat2Mat(axes, body.iquat)
    return float(axes.reshape(3, 3)[2] ** 2 @ body.inertia)


def compute_figures(motion: Motion, lobes: int) -> tuple[float, float, float, float]:
    """Compute figures over the second half of a run.

    They are mean and peak-to-peak transmission error [arcsec], rms error of the gear's speed [rad/s], and efficiency.
    """
    half = slice(len(motion.crank) // 2, None)
    crank, gear, speed, torque = (values[half] for values in (motion.crank, motion.gear, motion.speed, motion.torque))
    error = np.degrees(gear + crank / lobes) * 3600.0
    steady = (crank[-1] - crank[0]) / ((len(crank) - 1) * SAMPLING)
    rms = math.sqrt(float(np.mean((speed + steady / lobes) ** 2)))
    return float(error.mean()), float(np.ptp(error)), rms, LOAD / lobes / abs(float(torque.mean()))


def main() -> None:
    """Run all models, and print a table of their CPU times and figures."""
    parser = argparse.ArgumentParser(description=str(__doc__).split("\n\n")[0])
    parser.add_argument("--end-ms", type=float, default=10.0, help="simulated time [ms]; its second half is judged")
    parser.add_argument("--friction", type=float, default=0.05, help="pin on gear")
    options = parser.parse_args()
    end, friction = 1e-3 * options.end_ms, options.friction
    runs: dict[str, Callable[[], Motion]] = {}
    for pins, ours, theirs in (("fixed", (1, 5, 10), (5, 10)), ("free", (1, 2), (1, 2))):
        runs |= {f"cycloid-mj, {pins}, {step} us": partial(run_ours, 1e-6 * step, friction, end, pins) for step in ours}
        runs |= {
            f"Exudyn, {pins}, compiled, {step} us": partial(run_compiled, 1e-6 * step, friction, end, pins)
            for step in theirs
        }
    for segments in (2800, 5600, 11200, 22400):
        runs[f"Exudyn, 10 us, {segments} segments"] = partial(run_exudyn, 1e-5, friction, end, segments)
    lobes = reduced_design(1e-6, friction).lobes
    print(f"{'':32}{'CPU s / s':>10}{'TE mean':>10}{'TE p-p':>10}{'speed rms':>11}{'efficiency':>12}")
    for name, run in runs.items():
        try:
            motion = run()
        except Exception as problem:  # Exudyn's solver fails: continue with the other rows
            print(f"{name:32}{type(problem).__name__}: {problem}", flush=True)
            continue
        mean, peak_to_peak, rms, efficiency = compute_figures(motion, lobes)
        print(f"{name:32}{motion.cpu:10.3g}{mean:10.3f}{peak_to_peak:10.3f}{rms:11.4f}{efficiency:12.4f}", flush=True)


if __name__ == "__main__":
    main()
