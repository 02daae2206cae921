"""``Design`` -> the reducer in stock MuJoCo collision: the same bodies, in contact by the meshes of convex slices.

A surface's geoms are named ``<stem>/<member>/<number>``; the stem is the name that the same surface has in the model of
exact contact, and in its mating pairs. Round parts are capsules whose caps lie beyond the faces. Bits of ``contype``
and ``conaffinity`` let mating surfaces meet and nothing else; what is behind them only meets objects from outside.

A geom has no ``solreffriction``: MuJoCo takes the damping of the contact for that of its friction, and a fast slide
then pushes the surfaces apart, with friction times damping times speed. The facets of a hole, which know their mate,
meet it by explicit pairs where they rub, and have none of it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from cycloid_mj import names
from cycloid_mj.contact.law import ContactLaw, SolverParameters, curvature_law, solver_parameters
from cycloid_mj.contact.working import for_slices, working_force
from cycloid_mj.convex import ConvexSettings, Place, Rest, Surface, prism, surfaces
from cycloid_mj.design import Design
from cycloid_mj.deviations import deviations
from cycloid_mj.digits import on_grid
from cycloid_mj.errors import DesignError
from cycloid_mj.export.stl import stl_bytes
from cycloid_mj.mjcf import model as exact
from cycloid_mj.mjcf.foundation import slice_law
from cycloid_mj.mjcf.model import ReducerModel
from cycloid_mj.solid import VISUAL_CHORD_ERROR, MassProperties, mass_properties, mesh, parts

VISUAL, COLLISION = "visual", "collision"
"""Default classes, in groups 2 and 3."""

OUTSIDE, TEETH, ROOTS, SOCKETS, BORE, HOLES = (1 << bit for bit in range(6))
"""Bits of contype and conaffinity; 1 is what every object has by default."""

CCD_TOLERANCE, CCD_ITERATIONS = 1e-9, 60

CAP = 0.1
"""How far the cylinder of a capsule reaches beyond the faces, as a share of the face width."""

OUTPUT_OPACITY = 0.4
"""The output disc covers the gear: it is drawn translucent."""

_KINDS = {"teeth": "", "lobe": "tooth", "socket": "pin_socket", "bore": "cam", "hole": "output"}
_BODIES = {"teeth": names.GEAR, "bore": names.GEAR, "hole": names.GEAR, "lobe": names.HOUSING, "socket": names.HOUSING}
_MATES: Mapping[str, Callable[[int], str]] = {
    "bore": lambda _: names.CAM,
    "hole": names.output_pin,
    "socket": names.pin,
}
_SLICE_PRIORITY, _HULL_PRIORITY = 2, 1


@dataclass(frozen=True)
class MeshSpec:
    """An editable mesh model with what its makers know: see ``ReducerModel``; `surfaces` are its sliced surfaces."""

    spec: Any
    surfaces: tuple[Surface, ...]
    laws: Mapping[str, ContactLaw]
    crank_inertia: float


def build_mesh(design: Design, settings: ConvexSettings | None = None) -> ReducerModel:
    """Build the model of a design for stock MuJoCo collision; to be run as that of ``build``.

    Raises
    ------
    DesignError
        A part of the design cannot be made, or sliced; or its pins carry sleeves.
    ContactError
        MuJoCo cannot represent a contact's stiffness at this time step.
    """
    made = mesh_spec(design, settings or ConvexSettings())
    gains = exact._add_actuators(made.spec, made.crank_inertia)
    exact._add_sensors(made.spec, design)
    model = made.spec.compile()
    reducer = ReducerModel(made.spec, model, names.pairs(design), made.laws, gains, made.crank_inertia)
    return exact.judged(reducer, design)


def mesh_spec(design: Design, settings: ConvexSettings) -> MeshSpec:
    """Give the bodies of a design with their visual and their colliding geoms: no actuators, no sensors, no rest.

    The slices are as stiff as `for_slices` says.
    """
    design = for_slices(design)
    if design.ring.has_sleeves or design.ring.has_massless_pins:
        what = "a sleeve turns on its pin" if design.ring.has_sleeves else "a massless pin gives way"
        raise DesignError(
            f'ring.pins = "{design.ring.pins}" has no meshes for stock collision: {what} by exact contact only; '
            'choose ring.pins = "free" or "fixed", or the contact profile'
        )
    masses = {name: mass_properties(solid) for name, solid in parts(design).items()}
    spec = exact._empty(design)
    inertia = _bodies_only(spec, design, masses)
    _options(spec)
    _add_visuals(spec, design)
    weights = _inverse_weights(spec)
    laws = exact.contact_laws(design, masses)
    working = surfaces(design, settings)
    collision = spec.add_default(COLLISION, spec.default)
    collision.geom.group, collision.geom.contype, collision.geom.conaffinity = 3, 0, 0
    for surface in working:
        _add_surface(spec, design, surface, laws, weights)
    _add_round_parts(spec, design)
    return MeshSpec(spec, working, laws, inertia)


def add_rest(spec: Any, number: int, rest: Rest) -> None:
    """Add the convex pieces behind the working surfaces of a part, which meet objects from outside."""
    sector = rest.sector
    for index, piece in enumerate(rest.pieces, start=1):
        name = f"{sector.part}_rest_{number}_{index}"
        _add_stl(spec, name, stl_bytes(piece))
        part = _sub_default(spec, name)
        part.geom.type, part.geom.meshname = mujoco.mjtGeom.mjGEOM_MESH, name
        part.geom.conaffinity = OUTSIDE
        for copy in range(sector.count):
            turn = 2.0 * np.pi * copy / sector.count
            spec.body(sector.part).add_geom(part, quat=_turn(turn))


def stem(surface: str, member: int) -> str:
    """Name a member of a surface as its mating pairs do."""
    called = {"lobe": names.lobe, "socket": names.socket, "hole": names.hole}
    return called[surface](member) if surface in called else surface


def _bodies_only(spec: Any, design: Design, masses: Mapping[str, MassProperties]) -> float:
    """Add the bodies of the exact model with joints and inertias; their geoms give way to this model's."""
    inertia = exact._add_bodies(spec, design, masses)
    for item in (*spec.geoms, *spec.lights, *spec.cameras):
        spec.delete(item)
    exact._inertial(spec.body(names.HOUSING), masses[names.HOUSING])
    spec.nuser_geom = 0
    return inertia


def _options(spec: Any) -> None:
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_MULTICCD)
    spec.option.ccd_tolerance = CCD_TOLERANCE
    spec.option.ccd_iterations = CCD_ITERATIONS


def _inverse_weights(spec: Any) -> dict[str, float]:
    """Give MuJoCo's translational inverse weight of every body [1/kg]."""
    model = spec.copy().compile()
    return {model.body(i).name: float(model.body_invweight0[i, 0]) for i in range(model.nbody)}


def _add_visuals(spec: Any, design: Design) -> None:
    visual = spec.add_default(VISUAL, spec.default)
    visual.geom.group, visual.geom.contype, visual.geom.conaffinity = 2, 0, 0
    visual.geom.type = mujoco.mjtGeom.mjGEOM_MESH
    for part, solid in parts(design, VISUAL_CHORD_ERROR).items():
        _add_stl(spec, part, stl_bytes(mesh(solid)), mujoco.mjtMeshInertia.mjMESH_INERTIA_EXACT)
        opacity = OUTPUT_OPACITY if part == names.OUTPUT else 1.0
        spec.add_material(name=part, rgba=[*exact._COLOURS[part][:3], opacity], specular=0.4, shininess=0.4)
        for body in _bearers(spec, design, part):
            for place in _visual_places(design, part):
                body.add_geom(visual, meshname=part, material=part, pos=place)


def _bearers(spec: Any, design: Design, part: str) -> list[Any]:
    """Give the bodies that a part is seen on."""
    if part == "pin" and design.ring.has_pin_bodies:
        return [spec.body(names.pin(number)) for number in range(1, design.ring.teeth + 1)]
    return [spec.body(names.HOUSING if part == "pin" else part)]


def _visual_places(design: Design, part: str) -> list[list[float]]:
    """Give where a part is seen on each of its bodies."""
    if part == "pin" and not design.ring.has_pin_bodies:
        return [exact._at(design.ring.pin_circle_radius, angle) for angle in exact.ring_angles(design)]
    return [[0.0, 0.0, 0.0]]


def _add_stl(spec: Any, name: str, content: bytes, inertia: Any = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX) -> None:
    file = f"{name}.stl"
    spec.assets[file] = content
    spec.add_mesh(name=name, file=file, inertia=inertia)


def _sub_default(spec: Any, name: str) -> Any:
    return spec.add_default(name, spec.find_default(COLLISION))


def _add_surface(
    spec: Any, design: Design, surface: Surface, laws: Mapping[str, ContactLaw], weights: Mapping[str, float]
) -> None:
    """Add one class for each slice of a surface, with mesh and contact physics, and its geoms at every place."""
    kind = _KINDS[surface.name] or ("tooth" if design.ring.kind == "nonpin" else "pin_gear")
    curve, force = curvature_law(design), working_force(design, kind)
    weight = sum(weights[body] for body in _mating_bodies(design, surface.name))
    rubs = surface.name in _MATES and laws[kind].friction > 0.0
    classes = []
    for number, part in enumerate(surface.slices):
        name = f"{surface.name}_{number + 1}"
        _add_stl(spec, name, stl_bytes(mesh(prism(surface, number))))
        factor = curve.factor(part.curvature) if kind in ("pin_gear", "tooth") else 1.0
        parameters = solver_parameters(slice_law(laws[kind], factor, part, force), weight)
        default = _sub_default(spec, name)
        default.geom.type, default.geom.meshname = mujoco.mjtGeom.mjGEOM_MESH, name
        if rubs:
            _meet_by_pair(default.pair, parameters)
        else:
            _meet_by_bits(default.geom, parameters, surface.name, part.width)
        classes.append(default)
    body = spec.body(_BODIES[surface.name])
    counts: dict[int, int] = {}
    for place in surface.places:
        counts[place.member] = counts.get(place.member, 0) + 1
        name = f"{stem(surface.name, place.member)}/{place.member}/{counts[place.member]}"
        body.add_geom(classes[place.slice], name=name, pos=[*place.centre, 0.0], quat=_pose(place))
        if rubs:
            spec.add_pair(classes[place.slice], geomname1=name, geomname2=_MATES[surface.name](place.member))


def _meet_by_bits(geom: Any, parameters: SolverParameters, surface: str, width: float) -> None:
    geom.contype, geom.conaffinity = _bits(surface, width)
    geom.priority = _SLICE_PRIORITY if np.isfinite(width) else _HULL_PRIORITY
    geom.condim, geom.solref, geom.solimp = parameters.condim, parameters.solref, parameters.solimp
    geom.friction = [parameters.friction[0], 0.0, 0.0]


def _meet_by_pair(pair: Any, parameters: SolverParameters) -> None:
    pair.condim, pair.solref, pair.solimp = parameters.condim, parameters.solref, parameters.solimp
    pair.friction, pair.solreffriction = parameters.friction, parameters.solreffriction
    pair.margin, pair.gap = 0.0, 0.0


def _mating_bodies(design: Design, surface: str) -> tuple[str, ...]:
    """Name the bodies whose contact a surface takes part in."""
    pin = (names.pin(1),) if design.ring.has_pin_bodies else ()
    return {
        "teeth": (names.GEAR, *pin),
        "lobe": (names.GEAR,),
        "socket": pin,
        "bore": (names.GEAR, names.SHAFT),
        "hole": (names.GEAR, names.OUTPUT),
    }[surface]


def _bits(surface: str, width: float) -> tuple[int, int]:
    """Give contype and conaffinity of a slice, or of the hull that is a convex tip.

    Tips of the gear meet the roots of an internal gear, its valleys do not. The arc of an internal gear's lobe meets
    the gear as a capsule, which is exact and quicker than its hull.
    """
    hull = not np.isfinite(width)
    if surface == "lobe":
        return (0, OUTSIDE) if hull else (0, ROOTS)
    if surface == "teeth":
        return (ROOTS if hull else 0, TEETH)
    return 0, {"socket": SOCKETS, "bore": BORE, "hole": HOLES}[surface]


def _add_round_parts(spec: Any, design: Design) -> None:
    """Add pins, or the arcs of an internal gear's lobes (the same circles), cam and output pins as capsules."""
    ring, output, made = design.ring, design.output, deviations(design)
    half = 0.5 * design.gear.face_width * (1.0 + 2.0 * CAP)
    collision = spec.find_default(COLLISION)

    def add(body: str, name: str, radius: float, bits: int, place: list[float]) -> None:
        kind = mujoco.mjtGeom.mjGEOM_CAPSULE
        spec.body(body).add_geom(collision, name=name, type=kind, size=[radius, half, 0.0], contype=bits, pos=place)

    departures = zip(exact.ring_angles(design), made.pin_place, made.pin_radius, strict=True)
    for number, (angle, deviation, larger) in enumerate(departures, start=1):
        name = names.pin(number) if ring.kind == "pin" else names.lobe(number)
        body = name if ring.has_pin_bodies else names.HOUSING
        place = [0.0, 0.0, 0.0] if ring.has_pin_bodies else exact._at(ring.pin_circle_radius, angle, deviation)
        add(body, name, ring.pin_radius + larger, TEETH | SOCKETS, place)
    cam = [0.0, design.gear.eccentricity + made.eccentricity, 0.0]
    add(names.SHAFT, names.CAM, design.gear.bore_radius, BORE, cam)
    for number, angle in enumerate(exact.output_angles(design), start=1):
        place = exact._at(output.pin_circle_radius, angle)
        add(names.OUTPUT, names.output_pin(number), output.pin_radius, HOLES, place)


def _turn(angle: float) -> list[float]:
    """Quaternion of a clockwise turn about z [rad]."""
    turned: list[float] = on_grid([np.cos(0.5 * angle), 0.0, 0.0, -np.sin(0.5 * angle)]).tolist()
    return turned


def _pose(place: Place) -> list[float]:
    """Quaternion of a place; the mirror image of a prism is half a turn about its own y axis."""
    w, _, _, z = _turn(place.angle)
    return [0.0, -z, w, 0.0] if place.mirrored else [w, 0.0, 0.0, z]
