"""``Design`` -> ``MjSpec``: the mechanism's bodies and pairs with their contact physics, actuators and sensors.

Frame: +x right, +y up, z along the crank axis; crank angle counter-clockwise, zero with the gear centre at (0, +c).
The gear and the free pins move in the plane (two slides and a hinge); shaft and output turn on hinges. A pin of two
discs has two more hinges, so that it can tilt.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

import mujoco

from cycloid_mj.base import names
from cycloid_mj.base.arguments import require_choice
from cycloid_mj.base.array import significant
from cycloid_mj.base.errors import DesignError
from cycloid_mj.design import Named, resolve
from cycloid_mj.dynamics.contact import each_step
from cycloid_mj.dynamics.contact.forces import drag_rows
from cycloid_mj.dynamics.contact.library import exact_xml
from cycloid_mj.dynamics.contact.teeth import USER_DATA
from cycloid_mj.dynamics.law import ContactParameters, impratio, solver_parameters
from cycloid_mj.dynamics.mjcf.bodies import add_bodies, add_shapes, crank_inertia
from cycloid_mj.dynamics.mjcf.laws import Laws, laws_of_discs, stiffest
from cycloid_mj.dynamics.mjcf.sensors import add_sensors
from cycloid_mj.dynamics.mjcf.solver import set_solver
from cycloid_mj.dynamics.regime import model_warnings
from cycloid_mj.dynamics.timestep import timestep
from cycloid_mj.parts import VISUAL_CHORD_ERROR, Solid, mesh, moving_masses, output_inertia, parts
from cycloid_mj.reducer import Reducer, reducer_of
from cycloid_mj.reducer.bodies import Pair

Held = Literal["crank", "output", ""]
"""The shaft with a position servo; empty: both have a torque only."""

SERVO_BANDWIDTH = 2e4
"""Bandwidth [rad/s] of the position servo that makes a shaft follow its command (heuristic); critically damped."""


@dataclass(frozen=True)
class ReducerModel:
    """A model ready to run.

    Attributes
    ----------
    spec, model
        The editable and the compiled model.
    pairs
        Every mating pair, in the order of the log's force columns.
    laws
        The contact law of each kind of pair, on the disc where it is stiffest.
    servo_gains
        kp [N m/rad] and kv [N m s/rad] of the servo on the driven shaft.
    crank_inertia
        Inertia of the driven shaft and its rotor about their axis [kg m2].
    warnings
        Reasons why its figures may differ from those of its design, see ``dynamics.regime``.
    """

    spec: Any
    model: Any
    pairs: tuple[Pair, ...]
    laws: Mapping[str, ContactParameters]
    servo_gains: tuple[float, float]
    crank_inertia: float
    warnings: tuple[str, ...] = ()

    def __repr__(self) -> str:
        freedom_count, pair_count = self.model.nv, len(self.pairs)
        step = 1e6 * self.timestep
        return f"<ReducerModel: {freedom_count} freedoms, {pair_count} mating pairs, steps of {step:.3g} us>"

    @property
    def timestep(self) -> float:
        """Time step [s]."""
        return float(self.model.opt.timestep)

    @property
    def drags(self) -> tuple[str, ...]:
        """Names of the losses of seals and lubricant that it has."""
        return tuple(drag_rows(self.model, names.DRAGS))


def build(design: Named, held: Held = "crank") -> ReducerModel:
    """Build the contact model of a design.

    Parameters
    ----------
    design
        A design, or the name of a preset or a file.
    held
        The shaft with a position servo; the actuator of the other shaft is a torque. Empty: both are torques.

    Returns
    -------
    ReducerModel
        The editable and the compiled model, and its mating pairs.

    Raises
    ------
    UsageError
        `held` is not a shaft.
    DesignError
        A part of the design is not feasible, or ``contact.needles`` is "each".
    ContactError
        MuJoCo cannot represent a contact's stiffness at this time step.
    """
    require_choice("held", held, get_args(Held))
    reducer = reducer_of(resolve(design))
    if reducer.separate_needles or reducer.roller_needles.needles:
        raise DesignError(
            f'{reducer.design.name}: contact.needles = "each" is supported by statics and the planar solver, not by '
            'MuJoCo: use --solver planar, or set contact.needles = "lumped"'
        )
    masses = moving_masses(reducer)
    laws = laws_of_discs(reducer)
    spec = empty_spec(reducer, impratio(reducer, laws, timestep(reducer)))
    for name, solid in visible_solids(reducer).items():
        surface_mesh = mesh(solid)
        spec.add_mesh(
            name=name,
            uservert=surface_mesh.vertices.ravel().tolist(),
            userface=surface_mesh.faces.ravel().tolist(),
            inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_EXACT,
        )
    add_bodies(spec, reducer, masses, tilting_pins=reducer.design.has_tilting_pins)
    add_shapes(spec, reducer)
    driven_inertia = crank_inertia(reducer, masses)
    servo_inertias = {"crank": driven_inertia, "output": output_inertia(reducer), "": 0.0}
    gains = add_actuators(spec, servo_inertias[held], held, reducer.INPUT_JOINT)
    add_sensors(spec, reducer)
    each_step.add_sensor(spec, reducer.design.contact.law == "impact" or reducer.design.has_film)
    if reducer.design.ring.has_pin_bodies:
        set_solver(spec, stiffest(laws), loaded=reducer.design.load.torque != 0.0)
    model = _add_pairs(spec, reducer.mechanism.pairs, laws)
    return add_warnings(
        ReducerModel(spec, model, reducer.mechanism.pairs, stiffest(laws), gains, driven_inertia), reducer
    )


def add_warnings(compiled: ReducerModel, reducer: Reducer) -> ReducerModel:
    """Add a model's warnings to it."""
    return replace(compiled, warnings=model_warnings(reducer, compiled))


def xml(spec: Any) -> str:
    """Write the MJCF of a compiled spec with every digit of every number."""
    with exact_xml():
        spec.compile()  # otherwise the pairs are those of the last compilation
        return str(spec.to_xml())


def empty_spec(reducer: Reducer, impratio: float) -> Any:
    """Return an editable model that has only a light, a camera, and the options that all models of a design share.

    The options are time step, gravity, integrator, constraint solver, elliptic friction cones and flags. `impratio` is
    MuJoCo's ratio of frictional to normal impedance [1], see `law.impratio`.
    """
    design = reducer.design
    spec = mujoco.MjSpec()
    spec.modelname = f"cycloid_{design.name}"
    spec.nuser_geom = USER_DATA + reducer.deviations.waves_in_use.size
    option = spec.option
    option.timestep = timestep(reducer)
    option.gravity = [design.environment.gravity_x, design.environment.gravity_y, 0.0]
    option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = impratio
    option.iterations = 100
    option.tolerance = 1e-10
    # Mostly one island holds everything in contact: looking for more costs time. `set_solver` knows where not.
    option.disableflags = int(mujoco.mjtDisableBit.mjDSBL_AUTORESET | mujoco.mjtDisableBit.mjDSBL_ISLAND)
    option.enableflags = int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    housing_radius = design.housing.outer_radius
    spec.stat.extent = 2.0 * housing_radius
    spec.stat.center = [0.0, 0.0, 0.0]
    spec.worldbody.add_light(pos=[housing_radius, 2 * housing_radius, 6 * housing_radius], dir=[-0.2, -0.3, -1.0])
    spec.worldbody.add_camera(name="front", pos=[0.0, 0.0, -4 * housing_radius], xyaxes=[-1, 0, 0, 0, 1, 0])
    return spec


def visible_solids(reducer: Reducer) -> dict[str, Solid]:
    """Return the solids of all parts for viewers, by name."""
    return parts(reducer, VISUAL_CHORD_ERROR)


def add_actuators(
    spec: Any, inertia: float, held: Held = "crank", driven: str = names.CRANK_JOINT
) -> tuple[float, float]:
    """Add the actuators of crank and output to the editable MuJoCo model `spec`: a position servo and a torque.

    Parameters
    ----------
    inertia
        Inertia that the servo moves [kg m2].
    held
        The shaft with the servo; the actuator of the other shaft is a torque.
    driven
        Joint of the crank, or of the sun of an RV reducer.

    Returns
    -------
    tuple of float
        Gains kp [N m/rad] and kv [N m s/rad] of the servo.
    """
    kp, kv = servo_gains(inertia)
    for shaft, name, joint in (("crank", names.DRIVE, driven), ("output", names.LOAD, names.OUTPUT_JOINT)):
        actuator = spec.add_actuator(name=name, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        if shaft == held:
            actuator.set_to_position(kp=kp, kv=kv)
        else:
            actuator.set_to_motor()
    return kp, kv


def servo_gains(inertia: float) -> tuple[float, float]:
    """Compute the gains [N m/rad], [N m s/rad] of a position servo on a shaft of this inertia [kg m2]."""
    return significant(inertia * SERVO_BANDWIDTH**2), significant(2.0 * inertia * SERVO_BANDWIDTH)


def _add_pairs(spec: Any, pairs: tuple[Pair, ...], laws: Sequence[Laws]) -> Any:
    """Add the contacts of all mating `pairs` with the law of each to the editable model `spec`; return it compiled.

    `laws` are the contact laws by disc and kind. The attributes of a pair depend on MuJoCo's inverse weights of its
    bodies, which are known after compilation. They are set in both the editable and the compiled model, which is faster
    than to compile again.
    """
    elements = []
    for pair in pairs:
        law = laws[pair.disc][pair.kind]
        elements.append(spec.add_pair(name=pair.name, geomname1=pair.on, geomname2=pair.by, condim=law.condim))
    model = spec.compile()
    for pair, element in zip(pairs, elements, strict=True):
        bodies = [model.geom(geom).bodyid[0] for geom in (pair.on, pair.by)]
        inverse_weight = float(sum(model.body_invweight0[body, 0] for body in bodies))
        parameters = solver_parameters(laws[pair.disc][pair.kind], inverse_weight, spec.option.impratio, pair.name)
        pair_id = model.pair(pair.name).id
        for attribute in ("friction", "solref", "solreffriction", "solimp"):
            numbers = getattr(parameters, attribute)
            setattr(element, attribute, list(numbers))
            getattr(model, f"pair_{attribute}")[pair_id] = numbers
    return model
