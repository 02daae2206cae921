"""``Design`` -> the reducer in stock MuJoCo collision: the same bodies, in contact by the meshes of convex slices.

A surface's geoms are named ``<stem>/<member>/<number>``; the stem is the name that the same surface has in the model of
exact contact, and in its mating pairs. Round parts are capsules whose caps lie beyond the faces. Bits of ``contype``
and ``conaffinity`` restrict collisions to mating surfaces; the pieces behind them collide with other objects only.

A geom has no ``solreffriction``: MuJoCo takes the damping of the contact for that of its friction, and a fast slide
then separates the surfaces, with friction times damping times speed. The facets of a hole, which know their mate,
meet it by explicit pairs where they rub, and have none of it.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.errors import DesignError
from cycloid_mj.dynamics.contact import each_step
from cycloid_mj.dynamics.law import ContactParameters, SolverParameters, solver_parameters, stock_impratio
from cycloid_mj.dynamics.mjcf.bodies import (
    add_bodies,
    axial_extent,
    clockwise_quaternion,
    colour,
    crank_inertia,
    list_visible_parts,
    mujoco_position,
    set_inertia,
)
from cycloid_mj.dynamics.mjcf.foundation import slice_law
from cycloid_mj.dynamics.mjcf.laws import Laws, laws_of_discs, stiffest
from cycloid_mj.dynamics.mjcf.model import ReducerModel, add_actuators, add_warnings, empty_spec, visible_solids
from cycloid_mj.dynamics.mjcf.sensors import add_sensors
from cycloid_mj.dynamics.mjcf.springs import add_springs
from cycloid_mj.geometry import profile
from cycloid_mj.parts import mesh, moving_masses
from cycloid_mj.parts.convex import ConvexSettings, ConvexSurface, Rest, SlicePlacement, gear_holes, prism, surfaces
from cycloid_mj.parts.export.triangles import stl_bytes
from cycloid_mj.reducer import Reducer, RvReducer, reducer_of
from cycloid_mj.reducer.sockets import require_one_ring, require_open_sockets

VISUAL, COLLISION = "visual", "collision"
"""Default classes, in groups 2 and 3."""

OUTSIDE, TEETH, ROOTS, SOCKETS, HOLES, BORE = (1 << bit for bit in (0, 1, 2, 3, 5, 4))
"""Bits of contype and conaffinity; 1 is what every object has by default."""

BORES = (BORE, *(1 << bit for bit in (6, 7, 8)))
"""The same of the bore of each disc: the caps of its cam reach into the next one's."""


@dataclass(frozen=True)
class MeshContactSettings:
    """Settings of models for MuJoCo's own collision detection."""

    ccd_tolerance: float = 1e-9
    ccd_iterations: int = 60
    cap_share: float = 0.1
    """Length of a capsule's cylinder beyond each face, as a share of its width."""
    output_opacity: float = 0.4
    """Opacity of the output disc, which covers the gear."""
    slice_priority: int = 2
    hull_priority: int = 1


MESH_CONTACT = MeshContactSettings()


SPRINGS = (names.CRANK_BEARING, names.PLANET_MESH)
"""Kinds of pairs of an RV reducer that are springs instead of surfaces."""

_STEMS = {"lobe": names.LOBE, "socket": names.SOCKET, "hole": names.HOLE}
"""Surfaces of which a part has several, numbered."""

_OF_DISCS = (names.TEETH, names.BORE, names.HOLE)
"""Surfaces that every disc has; the ring's span all of them."""

_KINDS = {"lobe": "tooth", "socket": "pin_socket", "bore": "cam", "hole": "output"}


@dataclass(frozen=True)
class MeshSpec:
    """An editable mesh model with laws and inertia, see ``ReducerModel``; `surfaces` are its sliced surfaces."""

    spec: Any
    surfaces: tuple[ConvexSurface, ...]
    laws: Mapping[str, ContactParameters]
    crank_inertia: float


def build_mesh(reducer: Reducer, settings: ConvexSettings | None = None) -> ReducerModel:
    """Build the MuJoCo model of a design with convex slices of its surfaces, for MuJoCo's own collision detection.

    `settings` are those of the convex slices.

    Returns
    -------
    ReducerModel
        The compiled model, which runs like that of ``build``.

    Raises
    ------
    DesignError
        A part of the design is not feasible, or does not support convex meshes (see `mesh_spec`); the design is an RV
        reducer; or its contacts follow IMPACT or the friction law ``film``.
    ContactError
        MuJoCo cannot represent a contact's stiffness at this time step.
    """
    design = reducer.design
    if isinstance(reducer, RvReducer):
        raise DesignError(
            f"{design.name}: --contact mesh does not support RV reducers, because it cannot log the forces in their "
            "crank bearings. Use --contact profile, or `cycloid-mj build`, which writes a model "
            "that runs in MuJoCo without cycloid-mj"
        )
    if design.contact.law == "impact":
        raise DesignError(
            f'{design.name}: contact.law = "impact" needs exact profiles, not convex meshes. Use --contact profile, or '
            'set contact.law = "line"'
        )
    if design.has_film:
        raise DesignError(
            f'{design.name}: friction.law = "film" needs exact profiles, not convex meshes. Use --contact profile, or '
            'set friction.law = "coulomb"'
        )
    mesh_model = mesh_spec(reducer, settings or ConvexSettings())
    gains = add_actuators(mesh_model.spec, mesh_model.crank_inertia)
    add_sensors(mesh_model.spec, reducer)
    each_step.add_sensor(mesh_model.spec)
    return reducer_model(mesh_model, reducer, gains)


def reducer_model(mesh: MeshSpec, reducer: Reducer, gains: tuple[float, float]) -> ReducerModel:
    """Compile a mesh model that has its actuators, with the servo's gains, and judge it."""
    model, pairs = mesh.spec.compile(), reducer.mechanism.pairs
    return add_warnings(ReducerModel(mesh.spec, model, pairs, mesh.laws, gains, mesh.crank_inertia), reducer)


def mesh_spec(reducer: Reducer, settings: ConvexSettings) -> MeshSpec:
    """Build an editable MuJoCo model with convex meshes: bodies and geoms, without actuators and sensors.

    `settings` are those of the convex slices. There are geoms for viewers and for collisions. The result also has the
    sliced surfaces, the contact laws and the inertia of the crank. The convex pieces behind the working surfaces are
    not included. Slices have the stiffness of `Reducer.for_slices`.

    Raises
    ------
    DesignError
        The design has sleeves, massless pins, closed sockets or a ring in two halves, or a part of it is not feasible.
    ContactError
        MuJoCo cannot represent a contact's stiffness at this time step.
    """
    reducer = reducer.for_slices
    ring = reducer.design.ring
    if ring.has_sleeves or ring.has_massless_pins:
        unsupported = "sleeves that turn on their pins" if ring.has_sleeves else "massless pins"
        raise DesignError(
            f'ring.pins = "{ring.pins}" needs exact profiles, because convex meshes cannot represent {unsupported}. '
            'Use --contact profile, or set ring.pins = "free" or "fixed"'
        )
    require_open_sockets(reducer.design, "mesh contact")
    require_one_ring(reducer, "mesh contact")
    masses = moving_masses(reducer)
    all_laws = laws_of_discs(reducer)
    laws = [{kind: law for kind, law in disc_laws.items() if kind not in SPRINGS} for disc_laws in all_laws]
    spec = empty_spec(reducer, stock_impratio(reducer, laws))
    spec.nuser_geom = 0
    for element in (*spec.lights, *spec.cameras):
        spec.delete(element)
    add_bodies(spec, reducer, masses)
    set_inertia(spec.body(names.HOUSING), masses[names.HOUSING])
    _set_collision_options(spec)
    _add_visuals(spec, reducer)
    weights = _inverse_weights(spec)
    sliced_surfaces = surfaces(reducer, settings)
    collision_default = spec.add_default(COLLISION, spec.default)
    collision_default.geom.group, collision_default.geom.contype, collision_default.geom.conaffinity = 3, 0, 0
    discs_with_own_teeth = {surface.disc for surface in sliced_surfaces if surface.disc}
    for surface in sliced_surfaces:
        discs = range(reducer.design.gear.discs if surface.name in _OF_DISCS else 1)
        equal_discs = [disc for disc in discs if surface.name != names.TEETH or disc not in discs_with_own_teeth]
        _add_surface(spec, reducer, surface, [surface.disc] if surface.disc else equal_discs, laws, weights, settings)
    _add_round_parts(spec, reducer)
    if isinstance(reducer, RvReducer):
        add_springs(spec, reducer, stiffest(all_laws))
    return MeshSpec(spec, sliced_surfaces, stiffest(laws), crank_inertia(reducer, masses))


def add_remainder(spec: Any, reducer: Reducer, number: int, remainder: Rest) -> None:
    """Add the convex pieces of a part that lie behind its working surfaces to the editable model `spec` (``MjSpec``).

    They collide with objects outside the reducer only. `remainder` has the pieces of one sector, which are repeated
    around the part, those of a disc on every disc. `number`, counted from 1, identifies the remainder in the names of
    its meshes.
    """
    sector, phases = remainder.sector, reducer.phases
    bodies = reducer.gears if sector.part == names.GEAR else (sector.part,)
    for index, piece in enumerate(remainder.pieces, start=1):
        name = f"{sector.part}_rest_{number}_{index}"
        _add_stl(spec, name, stl_bytes(piece))
        default = _sub_default(spec, name)
        default.geom.type, default.geom.meshname = mujoco.mjtGeom.mjGEOM_MESH, name
        default.geom.conaffinity = OUTSIDE
        for body, phase in zip(bodies, phases, strict=False):
            teeth_rotation = phase / reducer.design.lobes if sector.of_teeth else 0.0
            for copy in range(sector.count):
                spec.body(body).add_geom(
                    default, quat=clockwise_quaternion(teeth_rotation + 2.0 * np.pi * copy / sector.count)
                )


def surface_stem(surface: str, member: int) -> str:
    """Name a member of a surface as its mating pairs do."""
    return names.numbered_name(_STEMS[surface], member) if surface in _STEMS else surface


def _set_collision_options(spec: Any) -> None:
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_MULTICCD)
    spec.option.ccd_tolerance = MESH_CONTACT.ccd_tolerance
    spec.option.ccd_iterations = MESH_CONTACT.ccd_iterations


def _inverse_weights(spec: Any) -> dict[str, float]:
    """Compute MuJoCo's translational inverse weight of every body [1/kg]."""
    model = spec.copy().compile()
    return {model.body(i).name: float(model.body_invweight0[i, 0]) for i in range(model.nbody)}


def _add_visuals(spec: Any, reducer: Reducer) -> None:
    """Add meshes and materials of all parts to the editable model `spec`, for viewers, at all their positions."""
    visual_default = spec.add_default(VISUAL, spec.default)
    visual_default.geom.group, visual_default.geom.contype, visual_default.geom.conaffinity = 2, 0, 0
    visual_default.geom.type = mujoco.mjtGeom.mjGEOM_MESH
    for part, solid in visible_solids(reducer).items():
        _add_stl(spec, part, stl_bytes(mesh(solid)), mujoco.mjtMeshInertia.mjMESH_INERTIA_EXACT)
        opacity = MESH_CONTACT.output_opacity if part == names.OUTPUT else 1.0
        spec.add_material(name=part, rgba=[*colour(part)[:3], opacity], specular=0.4, shininess=0.4)
        for body, position in _part_positions(reducer, part):
            spec.body(body).add_geom(visual_default, meshname=part, material=part, pos=position)


def _part_positions(reducer: Reducer, part: str) -> Iterator[tuple[str, list[float]]]:
    """Yield body and position of every copy of a part in the model; `part` is the name of the part.

    Yields
    ------
    tuple
        Name of the body, and position of the copy in its frame (x, y, z) [m].
    """
    visible_copies = [
        (body.name, position)
        for body in reducer.mechanism.bodies
        for shown_part, position in list_visible_parts(reducer, body)
        if shown_part == part
    ]
    for body, position in visible_copies:
        yield body, mujoco_position(position[:2], float(position[2]))
    if not visible_copies:  # pins that do not move belong to the housing
        tooth_profile = reducer.tooth_profile
        for position in tooth_profile.pin_circle_radius * profile.unit(profile.pin_angles(tooth_profile)):
            yield names.HOUSING, mujoco_position(position)


def _add_stl(spec: Any, name: str, content: bytes, inertia: Any = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX) -> None:
    file_name = f"{name}.stl"
    spec.assets[file_name] = content
    spec.add_mesh(name=name, file=file_name, inertia=inertia)


def _sub_default(spec: Any, name: str) -> Any:
    return spec.add_default(name, spec.find_default(COLLISION))


def _add_surface(
    spec: Any,
    reducer: Reducer,
    surface: ConvexSurface,
    discs: Sequence[int],
    laws: Sequence[Laws],
    weights: Mapping[str, float],
    settings: ConvexSettings,
) -> None:
    """Add the meshes of a surface's convex slices, and their geoms on each disc, to the editable model `spec`.

    `discs` are the indices of the discs; surfaces of the ring have the index 0 only. `laws` are the contact laws by
    disc, `weights` MuJoCo's inverse weights by body [1/kg], and `settings` those of the slices.
    """
    for index in range(len(surface.slices)):
        _add_stl(spec, f"{surface.key}_{index + 1}", stl_bytes(mesh(prism(surface, index))))
    for disc in discs:
        # the holes of each disc have errors of their own
        disc_surface = gear_holes(reducer, settings, disc) if surface.name == "hole" and disc else surface
        _add_slices(spec, reducer, disc_surface, disc, laws, weights)


def _add_slices(
    spec: Any, reducer: Reducer, surface: ConvexSurface, disc: int, laws: Sequence[Laws], weights: Mapping[str, float]
) -> None:
    """Add a default class for each convex slice of a `surface` on a disc to the model `spec`, and the slices' geoms.

    The class has the contact parameters of the slice. Slices of surfaces with friction, except teeth, collide by
    explicit pairs, all others by the bits of contype and conaffinity. `laws` are the contact laws by disc, `weights`
    MuJoCo's inverse weights by body [1/kg].
    """
    design, carriers, disc_count = reducer.design, reducer.mechanism.carriers, reducer.design.gear.discs
    reducer = reducer_of(design)
    kind = _KINDS.get(surface.name, design.tooth_pair)
    copy_count = disc_count if surface.name in _OF_DISCS else 1
    curvature_law, force = reducer.contacts.teeth.curvature_law, reducer.contacts[kind].force
    mating = reducer.mechanism.mating(kind, disc)
    mates = {name: mate for pair in mating.pairs for name, mate in ((pair.on, pair.by), (pair.by, pair.on))}
    first_pair = next(mating.pairs)
    inverse_weight = weights[carriers[first_pair.on]] + weights[carriers[first_pair.by]]
    law = laws[disc][kind]
    has_friction = kind != design.tooth_pair and law.friction > 0.0
    slice_defaults = []
    for number, surface_slice in enumerate(surface.slices, start=1):
        name = f"{surface.name}_{number}"
        factor = curvature_law.factor(surface_slice.curvature) if kind == design.tooth_pair else 1.0
        parameters = solver_parameters(
            slice_law(law, factor, surface_slice, force), inverse_weight, spec.option.impratio, name
        )
        slice_default = _sub_default(spec, names.of_disc(name, disc, copy_count))
        slice_default.geom.type, slice_default.geom.meshname = mujoco.mjtGeom.mjGEOM_MESH, f"{surface.key}_{number}"
        if has_friction:
            _set_pair_contact(slice_default.pair, parameters)
        else:
            _set_geom_contact(slice_default.geom, parameters, surface.name, surface_slice.width, disc)
        slice_defaults.append(slice_default)
    phase = reducer.mechanism.phases[disc] / design.lobes if surface.name == names.TEETH else 0.0
    slice_counts: dict[int, int] = {}
    for placement in surface.places:
        slice_counts[placement.member] = slice_counts.get(placement.member, 0) + 1
        surface_name = names.of_disc(surface_stem(surface.name, placement.member), disc, copy_count)
        name = f"{surface_name}/{placement.member}/{slice_counts[placement.member]}"
        pose = {"pos": [*placement.centre, 0.0], "quat": _slice_quaternion(placement, phase)}
        spec.body(carriers[surface_name]).add_geom(slice_defaults[placement.slice], name=name, **pose)
        if has_friction:
            spec.add_pair(slice_defaults[placement.slice], geomname1=name, geomname2=mates[surface_name])


def _set_geom_contact(geom: Any, parameters: SolverParameters, surface: str, width: float, disc: int) -> None:
    geom.contype, geom.conaffinity = _collision_bits(surface, width, disc)
    geom.priority = MESH_CONTACT.slice_priority if np.isfinite(width) else MESH_CONTACT.hull_priority
    geom.condim, geom.solref, geom.solimp = parameters.condim, parameters.solref, parameters.solimp
    geom.friction = [parameters.friction[0], 0.0, 0.0]


def _set_pair_contact(pair: Any, parameters: SolverParameters) -> None:
    pair.condim, pair.solref, pair.solimp = parameters.condim, parameters.solref, parameters.solimp
    pair.friction, pair.solreffriction = parameters.friction, parameters.solreffriction
    pair.margin, pair.gap = 0.0, 0.0


def _collision_bits(surface: str, width: float, disc: int) -> tuple[int, int]:
    """Return MuJoCo's contype and conaffinity of a slice of a surface, or of the convex hull of a tooth or lobe tip.

    Both consist of bits such as `ROOTS`. Hulls of the gear's tips collide with the roots of an internal gear, slices of
    its valleys do not. The hull of a lobe's tip collides with objects outside the reducer only: for the gear, the
    capsule with the arc of the lobe is exact and quicker. `surface` is ``teeth``, ``lobe``, ``socket``, ``bore`` or
    ``hole``, `width` [m] that of the slice, infinite for a hull, and `disc` the index of the disc.
    """
    is_hull = not np.isfinite(width)
    if surface == "lobe":
        return (0, OUTSIDE) if is_hull else (0, ROOTS)
    if surface == "teeth":
        return (ROOTS if is_hull else 0, TEETH)
    return 0, {"socket": SOCKETS, "bore": BORES[disc], "hole": HOLES}[surface]


def _add_round_parts(spec: Any, reducer: Reducer) -> None:
    """Add cams, output pins, and ring pins or the arcs of lobes to the editable model `spec`, as capsules."""
    design, collision_default = reducer.design, spec.find_default(COLLISION)
    bits_by_kind = [(design.tooth_pair, TEETH | SOCKETS, 0)]
    if not isinstance(reducer, RvReducer):
        bits_by_kind += [*(("cam", BORES[disc], disc) for disc in range(design.gear.discs)), ("output", HOLES, 0)]
    for kind, bits, disc in bits_by_kind:
        round_parts = reducer.mechanism.mating(kind, disc).by
        centre_z, half_width = axial_extent(reducer, round_parts)
        half_length = half_width * (1.0 + 2.0 * MESH_CONTACT.cap_share)
        for index, name in enumerate(round_parts.names):
            spec.body(round_parts.bodies[index]).add_geom(
                collision_default,
                name=name,
                type=mujoco.mjtGeom.mjGEOM_CAPSULE,
                size=[round_parts.radius[index], half_length, 0.0],
                contype=bits,
                pos=mujoco_position(round_parts.position[index], centre_z),
            )


def _slice_quaternion(placement: SlicePlacement, rotation: float) -> list[float]:
    """Return the quaternion of a slice on teeth that are rotated clockwise by `rotation` [rad].

    A mirrored slice is rotated by half a turn about its y axis in addition.
    """
    w, _, _, z = clockwise_quaternion(placement.angle + rotation)
    return [0.0, -z, w, 0.0] if placement.mirrored else [w, 0.0, 0.0, z]
