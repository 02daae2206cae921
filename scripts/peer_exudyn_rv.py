"""Compare an RV reducer in Exudyn with the static model and the planar solver: crank forces, wind-up, CPU time.

Exudyn is an open multibody code, and no dependency. Install it next to this project, then run this script::

    pip install exudyn==1.13.6
    python scripts/peer_exudyn_rv.py

The drive is the preset rv64 with the stiffnesses of the RV example for Exudyn: 1e7 N/m for a pin and for each of 16
needles, thus 16/4 1e7 N/m for a bearing, and clearances of 2 um at fixed pins. The output turns by a degree under
100 N m, with cranks at 2 rad/s. Exudyn's contacts of a curve have no friction, so nothing rubs. Without Exudyn, the
script prints the figures of this project only.

The first rows are statics with a single difference between both models changed: the contact law of Exudyn, the error of
its polygon, rigid planets, and stiffer bearings.

With ``contactModel=1``, the force of a contact is the sum over the segments of the curve: stiffness times the length of
the segment within the circle times the depth of the circle below the line of the segment. Exudyn 1.13.6 has this force
for a single circle on a flat and on polygons of circles, within 0.5 % for short segments.
"""

import time
from dataclasses import dataclass, replace
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.units import ARCSECOND
from cycloid_mj.design import PRESETS
from cycloid_mj.dynamics.planar.model import planar_model
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.geometry.kinematics import gear_centre
from cycloid_mj.geometry.profile import pin_angles, unit
from cycloid_mj.parts import moving_masses
from cycloid_mj.parts.rv import rv_parts
from cycloid_mj.reducer import RvReducer
from cycloid_mj.statics.rv import RvLoads, RvSprings, compute_rv_springs, solve_rv_loads

TORQUE, CRANK_SPEED, PIN_STIFFNESS = 100.0, 2.0, 1e7
"""Torque on the output [N m], speed of the cranks against the ring [rad/s], stiffness of a pin [N/m]."""

RISE, HOLD, STEP = 0.05, 0.4, 1e-4
"""Duration of the start, duration of the run, and time step of Exudyn [s]; a degree of the output takes 0.35 s."""

CHORD_ERROR = 5e-7
"""Largest distance of the segments of Exudyn's curve from the outline of a disc [m]."""

CAUSE_ANGLES = 171
"""Crank angles of statics with a changed model."""

MIN_CURVATURE, MIN_DEPTH = 1e-3, 1e-9
"""Smallest relative curvature [1/m] and depth [m] of contacts with Exudyn's law, which keep their springs finite."""

MAX_ITERATIONS, LAW_RTOL = 200, 1e-6
"""Iterations of Exudyn's law at most, and relative change of its springs at which they end."""

BEARING_DAMPING = 2e3
"""Damping of a crank bearing in Exudyn [N s/m], a few percent of the critical damping of a disc (heuristic)."""


@dataclass(frozen=True)
class Motion:
    """Angles of carrier and ring at a fixed sun [rad], shape (m,), crank forces [N], shape (m, D n), CPU time [s]."""

    carrier: Array
    ring: Array
    forces: Array
    cpu: float


def drive() -> RvReducer:
    """Return the drive without friction, with a rigid planet stage."""
    needles = PRESETS["rv64"].cranks
    assert needles
    bearing = needles.needles / 4.0 * PIN_STIFFNESS
    return RvReducer(
        PRESETS["rv64"].but(
            ring={"pins": "fixed"},
            load={"torque": TORQUE},
            clearance={"pin_gear": 2e-6},
            friction={"law": "coulomb", "pin_gear": 0.0, "pin_socket": 0.0, "cam_rolling": 0.0},
            planet={"friction": 0.0, "mesh_stiffness": 1e10, "sun_support": "fixed"},
            stiffness={"pin_gear": PIN_STIFFNESS},
            cranks={"needle_stiffness": bearing, "taper_stiffness": 2.0 * bearing},
        )
    )


def force_factor(curvature: Array, radius: float) -> Array:
    """Return the factor c [m^0.5] of Exudyn's contact force: stiffness times c times the depth^(3/2).

    A circle of the radius R touches a curve of short segments at the relative curvature k [1/m]. At the depth p, it
    contains the segments within sqrt(2 p/k) of the contact point. At the distance s, its depth below the line of a
    segment is p + k R (k - 1/R) s^2/2. The integral of the depth is c p^(3/2).
    """
    return np.asarray(2.0 * np.sqrt(2.0 / curvature) * (1.0 + (curvature * radius - 1.0) / 3.0))


def curve_stiffness(reducer: RvReducer) -> float:
    """Compute Exudyn's contact stiffness [N/m2] that has `PIN_STIFFNESS` under the working force of a pin on a flat."""
    force, radius = float(reducer.at_rated_load.contacts.teeth.force), reducer.design.ring.pin_radius
    approach = force / PIN_STIFFNESS
    return float(force / (force_factor(np.array(1.0 / radius), radius) * approach**1.5))


def simulate_in_exudyn(reducer: RvReducer) -> Motion:
    """Simulate the drive in Exudyn with a fixed sun and a turning ring; return the motion after the torque's rise."""
    model = ExudynModel(reducer)
    sensors = [model.carrier_angle, model.ring_angle, *model.forces]
    settings = model.exudyn.SimulationSettings()
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = HOLD / 400
    settings.timeIntegration.numberOfSteps = round(HOLD / STEP)
    settings.timeIntegration.endTime = HOLD
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.6
    settings.timeIntegration.verboseMode = 0
    model.system.Assemble()
    start = time.process_time()
    model.system.SolveDynamic(settings)
    cpu = time.process_time() - start
    carrier, ring, *forces = (np.asarray(model.system.GetSensorStoredData(sensor)) for sensor in sensors)
    late = carrier[:, 0] > 1.2 * RISE
    sizes = np.stack([np.linalg.norm(force[late, 1:3], axis=1) for force in forces], axis=1)
    return Motion(carrier[late, 3], ring[late, 3], sizes, cpu)


class ExudynModel:
    """The drive as planar rigid bodies of Exudyn: ring, carrier, cranks with their planets, discs."""

    def __init__(self, reducer: RvReducer) -> None:
        """Build all bodies, joints, contacts, loads and sensors."""
        self.exudyn, self.items = import_module("exudyn"), import_module("exudyn.itemInterface")
        self.reducer, masses = reducer, moving_masses(reducer)
        self.container = self.exudyn.SystemContainer()
        self.system = self.container.AddSystem()
        self.ground = self.system.AddObject(self.items.ObjectGround())
        ring, carrier = self._body(1.0, 1e-2, np.zeros(2)), self._body(1.0, 1e-3, np.zeros(2))
        for _, member in (ring, carrier):
            self._hinge(self.ground, member, np.zeros(2))
        self._drive_ring(ring[0])
        places = reducer.stage.crank_positions([0.0])[0]
        crank, disc = masses["crank"], masses[reducer.gears[0]]
        cranks = [self._body(crank.mass, float(crank.inertia[2, 2]), place) for place in places]
        for (node, body), place in zip(cranks, places, strict=True):
            self._hinge(carrier[1], body, place)
            # the planets roll on the fixed sun
            self._couple(self._angle(carrier[0]), self._angle(node), 1.0 / reducer.turn_ratio)
        self.forces = [
            force
            for number in range(reducer.design.gear.discs)
            for force in self._add_disc(number, disc.mass, float(disc.inertia[2, 2]), ring[1], cranks, places)
        ]
        self._load(carrier[1])
        self.carrier_angle, self.ring_angle = (self._sensor(member[0]) for member in (carrier, ring))

    def _body(self, mass: float, inertia: float, position: Array) -> tuple[Any, Any]:
        node = self.system.AddNode(self.items.NodeRigidBody2D(referenceCoordinates=[*position, 0.0]))
        return node, self.system.AddObject(self.items.ObjectRigidBody2D(mass=mass, inertia=inertia, nodeNumber=node))

    def _marker(self, body: Any, position: Array, kind: str = "MarkerBodyPosition") -> Any:
        return self.system.AddMarker(getattr(self.items, kind)(bodyNumber=body, localPosition=[*position, 0.0]))

    def _angle(self, node: Any) -> Any:
        return self.system.AddMarker(self.items.MarkerNodeCoordinate(nodeNumber=node, coordinate=2))

    def _hinge(self, first: Any, second: Any, position: Array) -> None:
        markers = [self._marker(first, position), self._marker(second, np.zeros(2))]
        self.system.AddObject(self.items.ObjectJointRevolute2D(markerNumbers=markers))

    def _couple(self, first: Any, second: Any, factor: float) -> None:
        joint = self.items.ObjectConnectorCoordinate(markerNumbers=[first, second], factor1=factor)
        self.system.AddObject(joint)

    def _drive_ring(self, ring: Any) -> None:
        """Prescribe the angle of the ring, at which the cranks turn at `CRANK_SPEED` against it."""
        turns = float(self.reducer.kinematics.to_carrier)
        speed = CRANK_SPEED / (self.reducer.turn_ratio * (turns - 1.0) / turns - 1.0)

        def angle(_: Any, now: float, *__: Any) -> float:
            return float(speed * (now**2 / (2.0 * RISE) if now < RISE else now - RISE / 2.0))

        node = self.system.AddNode(self.items.NodePointGround())
        fixed = self.system.AddMarker(self.items.MarkerNodeCoordinate(nodeNumber=node, coordinate=0))
        joint = self.items.ObjectConnectorCoordinate(markerNumbers=[fixed, self._angle(ring)], offsetUserFunction=angle)
        self.system.AddObject(joint)

    def _add_disc(
        self, number: int, mass: float, inertia: float, ring: Any, cranks: list[tuple[Any, Any]], places: Array
    ) -> list[Any]:
        """Add the disc with an index `number` and its contacts; return the sensors of the forces of its cranks.

        `ring` is the body of the ring, `cranks` the node and the body of each crank, and `places` (n, 2) [m] the crank
        bores in the frame of the disc.
        """
        reducer, items = self.reducer, self.items
        profile, phase = reducer.tooth_profile, reducer.phases[number]
        centre = gear_centre(profile, np.array([phase]))[0]
        _, body = self._body(mass, inertia, centre)
        pins = unit(pin_angles(profile)) * reducer.design.ring.pin_circle_radius
        outline = rv_parts(reducer)[reducer.gears[number]].solid(CHORD_ERROR).prisms[0].outline
        segments = np.hstack([outline, np.roll(outline, -1, axis=0)])
        state = items.NodeGenericData(
            initialCoordinates=[-1.0, 0.0, 0.0] * len(segments), numberOfDataCoordinates=3 * len(segments)
        )
        curve = self._marker(body, np.zeros(2), "MarkerBodyRigid")
        contact = items.ObjectContactCurveCircles(
            markerNumbers=[curve, *(self._marker(ring, pin, "MarkerBodyRigid") for pin in pins)],
            nodeNumber=self.system.AddNode(state),
            circlesRadii=[reducer.design.ring.pin_radius] * len(pins),
            segmentsData=self.exudyn.MatrixContainer(segments),
            contactStiffness=curve_stiffness(reducer),
            contactModel=1,
        )
        self.system.AddObject(contact)
        return [
            self._bearing(self._marker(crank, centre), self._marker(body, place))
            for (_, crank), place in zip(cranks, places, strict=True)
        ]

    def _bearing(self, crank: Any, disc: Any) -> Any:
        """Add a bearing as a spring and damper between the markers of crank and disc; return its force sensor."""
        spring = self.items.ObjectConnectorCartesianSpringDamper(
            markerNumbers=[crank, disc],
            stiffness=[self.reducer.bearing_stiffness] * 3,
            damping=[BEARING_DAMPING] * 3,
        )
        number = self.system.AddObject(spring)
        kind = self.exudyn.OutputVariableType.Force
        sensor = self.items.SensorObject(objectNumber=number, storeInternal=True, outputVariableType=kind)
        return self.system.AddSensor(sensor)

    def _load(self, carrier: Any) -> None:
        """Apply `TORQUE` [N m] to the carrier, with a linear rise over `RISE` [s]."""

        def torque(_: Any, now: float, full: list[float]) -> list[float]:
            return [0.0, 0.0, full[2] * min(1.0, now / RISE)]

        load = self.items.LoadTorqueVector(
            markerNumber=self._marker(carrier, np.zeros(2), "MarkerBodyRigid"),
            loadVector=[0.0, 0.0, TORQUE],
            loadVectorUserFunction=torque,
        )
        self.system.AddLoad(load)

    def _sensor(self, node: Any) -> Any:
        kind = self.exudyn.OutputVariableType.Coordinates
        sensor = self.items.SensorNode(nodeNumber=node, storeInternal=True, outputVariableType=kind)
        return self.system.AddSensor(sensor)


def balance(reducer: RvReducer, crank: Array, torque: float) -> tuple[Array, Array, float]:
    """Return wind-up [rad], crank forces [N] and CPU time [s] of the static model at crank angles [rad]."""
    start = time.process_time()
    loads = solve_rv_loads(compute_rv_springs(reducer, crank), torque)
    return loads.carrier_turn, loads.bearings.reshape(len(crank), -1), time.process_time() - start


def simulate_in_plane(reducer: RvReducer) -> tuple[Array, Array, Array, float]:
    """Return crank angles [rad], wind-up [rad], crank forces [N] and CPU time [s] of the planar solver."""
    speed = CRANK_SPEED / abs(float(reducer.kinematics.crank_per_sun))
    slow = reducer.but(drive={"speed": speed, "ramp": 0.0, "hold": HOLD})
    model = planar_model(slow)
    start = time.process_time()
    run = simulate(slow.design, model)
    cpu = time.process_time() - start
    run = run.select(run.time > 1.2 * RISE).select(slice(0, None, 10))
    wind_up = run["output_angle"] - slow.member.output_angle(run["sun_angle"])
    forces = np.linalg.norm(run.forces("crank_bearing"), axis=2)
    return slow.member.against_ring(run["sun_angle"]), wind_up, forces, cpu


def print_row(name: str, wind_up: Array, forces: Array, cpu: float) -> None:
    """Print wind-up [arcsec], mean and largest crank force [N], and CPU time [s]."""
    size = abs(float(wind_up.mean())) / ARCSECOND
    print(f"{name:28s} {size:12.2f} {forces.mean():12.1f} {forces.max():12.1f} {cpu:10.2f}")


def solve_with_exudyn_law(reducer: RvReducer, springs: RvSprings) -> RvLoads:
    """Solve for equilibrium under `TORQUE` with Exudyn's contact law, as secant springs by fixed-point iteration.

    The force of a pin follows from `curve_stiffness` and `force_factor`.
    """
    pins, curvature = springs.pins, np.maximum(springs.curvature, MIN_CURVATURE)
    factor = curve_stiffness(reducer) * force_factor(curvature, reducer.design.ring.pin_radius)
    for _ in range(MAX_ITERATIONS):
        loads, secant = solve_rv_loads(springs, -TORQUE), springs.stiffness[:, :pins]
        depth = np.maximum(loads.pins / secant, MIN_DEPTH)
        change = factor * np.sqrt(depth) / secant
        if np.abs(change - 1.0)[loads.pins > 1.0].max() < LAW_RTOL:
            return loads
        # half of the change on a logarithmic scale: full changes oscillate, as the force depends on the depth^1.5
        updated = springs.stiffness.copy()
        updated[:, :pins] *= np.sqrt(change)
        springs = replace(springs, stiffness=updated)
    raise RuntimeError("the contact law of Exudyn does not converge")


def print_causes(reducer: RvReducer) -> None:
    """Print statics with a single difference to Exudyn's model changed."""
    crank = np.linspace(0.0, CRANK_SPEED * (HOLD - RISE), CAUSE_ANGLES)
    springs = compute_rv_springs(reducer, crank)
    pins, flank = springs.pins, np.sign(springs.curvature - 1.0 / reducer.design.ring.pin_radius)
    polygon, planets = springs.gap.copy(), springs.stiffness.copy()
    # chords are inside of convex flanks and outside of concave ones, by two thirds of their sagitta on average
    polygon[:, :pins] += flank * CHORD_ERROR * 2.0 / 3.0
    planets[:, pins:] *= 100.0
    cases = {
        "statics": solve_rv_loads(springs, -TORQUE),
        "contact law of Exudyn": solve_with_exudyn_law(reducer, springs),
        "polygon of the disc": solve_rv_loads(replace(springs, gap=polygon), -TORQUE),
        "both": solve_with_exudyn_law(reducer, replace(springs, gap=polygon)),
        "planets 100 times as stiff": solve_rv_loads(replace(springs, stiffness=planets), -TORQUE),
        "bearings 1 % stiffer": solve_rv_loads(
            replace(springs, bearing_stiffness=1.01 * springs.bearing_stiffness), -TORQUE
        ),
    }
    for name, loads in cases.items():
        print_row(name, loads.carrier_turn, loads.bearings.reshape(len(crank), -1), 0.0)


def main() -> None:
    """Print the comparison."""
    reducer = drive()
    print(f"{'':28s} {'wind-up [arcsec]':>16s} {'mean [N]':>12s} {'largest [N]':>12s} {'CPU [s]':>10s}")
    crank, wind_up, forces, cpu = simulate_in_plane(reducer)
    print_row("planar solver", wind_up, forces, cpu)
    print_row("statics at its angles", *balance(reducer, crank, -TORQUE))
    print_causes(reducer)
    if not find_spec("exudyn"):
        print("Exudyn is not installed: pip install exudyn")
        return
    motion = simulate_in_exudyn(reducer)
    turns = float(reducer.kinematics.to_carrier)
    print_row("Exudyn", motion.carrier - (turns - 1.0) / turns * motion.ring, motion.forces, motion.cpu)
    crank = reducer.turn_ratio * motion.carrier - motion.ring
    print_row("statics at its angles", *balance(reducer, crank, TORQUE))


if __name__ == "__main__":
    main()
