"""Exudyn side by side with this project: the same gear, ring of fixed pins, cam and load, the cost and the results.

Exudyn is no dependency: put it into an environment of its own beside this project, then run this script there.

    pip install exudyn==1.13.6
    python scripts/peer_exudyn.py

Both have one planar gear on a cam that turns at constant speed, with the load on the gear itself (Exudyn's model has
no pins in holes), uniform contact stiffness and no play in the cam. Exudyn's settings are the best of those tried on
version 1.13.6: generalised alpha at 10 us (20 us fails), contact model 0 (model 1 does not converge), no contact
damping (with it the efficiency without friction leaves 1), and as many segments as it takes, since ``polynomialData``
is refused. A segment is a bed of springs per length: they are made as stiff as our contact at the working force, so
mean transmission errors may differ by some percent.
"""

import argparse
import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from cycloid_mj.contact.collider import installed
from cycloid_mj.contact.working import working_force
from cycloid_mj.course import initial_state, ramp_and_hold
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.mjcf import build
from cycloid_mj.modification import gear_profile, profile_offset, tooth_profile
from cycloid_mj.profile import pin_angles, sample
from cycloid_mj.types import Array

SAMPLING = 1e-4
LOAD = 36.0


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


def design_of(step: float, friction: float) -> Design:
    """Give the reducer without what Exudyn's model leaves out."""
    changes = [
        'ring.pins="fixed"',
        'contact.stiffness_law="uniform"',
        "clearance.cam_um=0.001",
        "clearance.output_um=500.0",
        "drive.ramp_s=0.0",
        "drive.rotor_inertia_kg_m2=10.0",
        f"settings.timestep_us={step * 1e6!r}",
        f"friction.pin_gear={friction}",
    ]
    return override(PRESETS["pin"], changes)


def run_ours(step: float, friction: float, end: float) -> Motion:
    """Run this project's model, with the load on the gear."""
    design = design_of(step, friction)
    reducer = build(design)
    data = initial_state(reducer, design)
    data.joint("gear_angle").qfrc_applied[0] = LOAD
    commands = ramp_and_hold(reducer, design).commands(step * np.arange(round(end / step), dtype=np.float64))
    every, rows = round(SAMPLING / step), []
    crank, gear, drive = data.joint("crank"), data.joint("gear_angle"), data.actuator("drive")
    with installed():
        start = time.process_time()
        for number, command in enumerate(commands):
            data.ctrl[:] = command
            mujoco.mj_step(reducer.model, data)
            if number % every == 0:
                rows.append((crank.qpos[0], gear.qpos[0], gear.qvel[0], drive.force[0]))
        cpu = (time.process_time() - start) / end
    theta, gamma, speed, torque = np.array(rows).T
    return Motion(theta, gamma, speed, torque, cpu)


def bedding(design: Design, stiffness: float) -> float:
    """Give the stiffness [N/m2] of a bed of springs that a pin enters as deep as it enters our contact.

    A circle of radius rho, p deep in the bed, meets a force of 4/3 sqrt(2 rho) p^(3/2) times it.
    """
    force = working_force(design, design.tooth_pair)
    return force / (4.0 / 3.0 * math.sqrt(2.0 * design.ring.pin_radius) * (force / stiffness) ** 1.5)


def run_exudyn(step: float, friction: float, end: float, segments: int) -> Motion:
    """Run Exudyn's model."""
    import exudyn as exu  # type: ignore[import-not-found]
    from exudyn import itemInterface as item

    design = design_of(step, friction)
    reducer = build(design)
    tooth, cam, gear = reducer.laws["pin_gear"], reducer.laws["cam"], reducer.model.body("gear")
    speed, eccentricity = design.drive.speed, design.gear.eccentricity
    # Going along a segment, Exudyn has the outside on the right.
    corners = sample(gear_profile(design), segments, profile_offset(design)).points[::-1]
    edges = np.hstack([corners, np.roll(corners, -1, axis=0)])

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
    radius, count = design.ring.pin_circle_radius, design.ring.teeth
    pins = [
        marker(ring, radius * math.sin(angle), radius * math.cos(angle)) for angle in pin_angles(tooth_profile(design))
    ]
    active = mbs.AddNode(
        item.NodeGenericData(initialCoordinates=[-1, 0, 0] * segments, numberOfDataCoordinates=3 * segments)
    )
    mbs.AddObject(
        item.ObjectContactCurveCircles(
            markerNumbers=[on_gear, *pins],
            nodeNumber=active,
            circlesRadii=[design.ring.pin_radius] * count,
            segmentsData=exu.MatrixContainer(edges),
            contactStiffness=bedding(design, tooth.stiffness),
            dynamicFriction=friction,
            frictionProportionalZone=design.contact.creep_speed,
        )
    )
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
    settings = exu.SimulationSettings()
    settings.timeIntegration.endTime, settings.timeIntegration.numberOfSteps = end, round(end / step)
    settings.timeIntegration.automaticStepSize = settings.timeIntegration.adaptiveStep = False
    settings.timeIntegration.verboseMode = 0
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = SAMPLING
    begin = time.process_time()
    mbs.SolveDynamic(settings, solverType=exu.DynamicSolverType.GeneralizedAlpha)
    cpu = (time.process_time() - begin) / end
    turned, moved, velocity, force = (mbs.GetSensorStoredData(number)[:, 1:] for number in sensors)
    theta = turned[:, 0]
    torque = eccentricity * (np.sin(theta) * force[:, 1] + np.cos(theta) * force[:, 0])
    return Motion(theta, moved[:, 2], velocity[:, 2], torque, cpu)


def judged(motion: Motion, lobes: int) -> tuple[float, float, float, float]:
    """Give mean and peak-to-peak transmission error [arcsec], rms error of the gear's speed [rad/s], efficiency."""
    half = slice(len(motion.crank) // 2, None)
    crank, gear, speed, torque = (values[half] for values in (motion.crank, motion.gear, motion.speed, motion.torque))
    error = np.degrees(gear + crank / lobes) * 3600.0
    steady = (crank[-1] - crank[0]) / ((len(crank) - 1) * SAMPLING)
    rms = math.sqrt(float(np.mean((speed + steady / lobes) ** 2)))
    return float(error.mean()), float(np.ptp(error)), rms, LOAD / lobes / abs(float(torque.mean()))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=str(__doc__).split("\n\n")[0])
    parser.add_argument("--end-ms", type=float, default=10.0, help="simulated time [ms]; its second half is judged")
    parser.add_argument("--friction", type=float, default=0.05, help="pin on gear")
    options = parser.parse_args()
    end, friction = 1e-3 * options.end_ms, options.friction
    runs: dict[str, Callable[[], Motion]] = {
        f"cycloid-mj, {step} us": lambda step=step: run_ours(1e-6 * step, friction, end)  # type: ignore[misc]
        for step in (1, 5, 10)
    }
    for segments in (2800, 5600, 11200, 22400):
        runs[f"Exudyn, 10 us, {segments} segments"] = lambda n=segments: run_exudyn(  # type: ignore[misc]
            1e-5, friction, end, n
        )
    lobes = design_of(1e-6, friction).lobes
    print(f"{'':32}{'CPU s / s':>10}{'TE mean':>10}{'TE p-p':>10}{'speed rms':>11}{'efficiency':>12}")
    for name, run in runs.items():
        motion = run()
        mean, swing, rms, efficiency = judged(motion, lobes)
        print(f"{name:32}{motion.cpu:10.3g}{mean:10.3f}{swing:10.3f}{rms:11.4f}{efficiency:12.4f}", flush=True)


if __name__ == "__main__":
    main()
