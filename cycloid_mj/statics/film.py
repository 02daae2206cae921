"""Friction of all contacts of a reducer with the law ``film``: mixed friction by load and surface speeds.

Teeth and output pins without rollers are line contacts; free pins, sleeves, plain rollers and a plain cam turn in
journal bearings. A free pin rolls on the disc while its seat has less friction than the flank would have, otherwise it
stops. Rolling bearings have Palmgren's friction torques M0 and M1.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from cycloid_mj.base.array import Array, Integers, Mask
from cycloid_mj.base.names import CRANK_BEARING, PLANET_MESH
from cycloid_mj.design.lubricants import lubricant
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.kinematics import gear_centre
from cycloid_mj.geometry.surface_speeds import SurfaceSpeeds, hole_speeds, tooth_speeds
from cycloid_mj.lubrication.bearings import idle_torque, seal_torque
from cycloid_mj.lubrication.mixed import FilmLaw, MixedFriction, journal_friction, line_friction
from cycloid_mj.reducer import Reducer, RvReducer, once
from cycloid_mj.reducer.gaps import Gaps
from cycloid_mj.reducer.reducer import Drive


@dataclass(frozen=True)
class FilmAssumptions:
    """Assumed dimensions and factors of the film law.

    Attributes
    ----------
    min_curvature
        Smallest relative curvature of a line contact [1/m]: where a flank fits its pin closer, they are conformal.
    roller_play
        Radial clearance of a plain roller on its core over the radius, of a running fit.
    roller_load_factor, roller_idle_factor
        Palmgren's f1 of needle rollers, and f0 of rollers of unknown make (cylindrical 1 to 3, needle 5 to 12; Harris).
    """

    min_curvature: float = 1.0
    roller_play: float = 1e-3
    roller_load_factor: float = 0.0005
    roller_idle_factor: float = 3.0


ASSUMED = FilmAssumptions()

CRANK_TAPER, MAIN_BEARING = "crank_taper", "main_bearing"
"""Bearings of an RV reducer that are no mating pairs of their own: of a crank in the carrier, and of the carrier."""

PART_OF_PAIR = {
    "cam": ("crank", "disc"),
    "output": ("disc", "output"),
    CRANK_BEARING: ("crank", "disc"),
    CRANK_TAPER: ("crank", "output"),
    MAIN_BEARING: ("output", "housing"),
    PLANET_MESH: ("crank", "crank"),
}
"""Parts whose mean temperature is that of the lubricant in a pair; others are between disc and ring.

Sun and planets of an RV reducer have the temperature of its cranks."""


@dataclass(frozen=True)
class FilmInputs:
    """Inputs of the film law that a design leaves open, relative to its own values; 1 is the design itself.

    Attributes
    ----------
    boundary, roughness, viscosity, play
        Coefficient of boundary friction, roughness, viscosity, and clearance of sockets and sleeves.
    film, share, shear
        Film thickness over that of its formula, load share of the film, and its limiting shear and Eyring stress.
    load_friction, idle_friction, seals
        Palmgren's factors f1 and f0 of rollers, and torque of the seals.
    """

    boundary: float = 1.0
    roughness: float = 1.0
    viscosity: float = 1.0
    play: float = 1.0
    film: float = 1.0
    share: float = 1.0
    shear: float = 1.0
    load_friction: float = 1.0
    idle_friction: float = 1.0
    seals: float = 1.0


DESIGN_INPUTS = FilmInputs()


@dataclass(frozen=True, eq=False)
class FilmFriction:
    """Friction of all contacts under known forces.

    Attributes
    ----------
    contacts
        Coefficient of each contact line with the ring and of each output pin [1], shape (m, n).
    cam
        Mean coefficient of the cams at their radius [1].
    teeth, output
        State of the contact that slides: of free pins the flank or the seat, whichever has less friction; None of
        output pins on needles.
    rolls
        Whether a free pin rolls on the disc, shape (m, teeth); false of fixed pins.
    """

    contacts: Array
    cam: float
    teeth: MixedFriction
    output: MixedFriction | None
    rolls: Mask

    def scaled(self, factor: float) -> "FilmFriction":
        """Return the friction with all coefficients times a factor."""
        return replace(self, contacts=factor * self.contacts, cam=factor * self.cam)


@dataclass(frozen=True, eq=False)
class FilmSurfaces:
    """Surfaces of all kinds of mating pairs of a reducer at its speed and temperatures, for the film law.

    Attributes
    ----------
    reducer
        The reducer.
    flank, seat
        Surface speeds of the disc on pins that do not turn, and in the seats of pins that roll (None without seats), at
        phases of any shape.
    radius
        Reduced radius of the contact lines with the ring at these phases [m].
    inputs
        Inputs other than those of the design.
    """

    reducer: Reducer
    flank: SurfaceSpeeds
    seat: SurfaceSpeeds | None
    radius: Array
    inputs: FilmInputs = DESIGN_INPUTS

    def select(self, selected: Mask) -> "FilmSurfaces":
        """Return the surfaces of the contact lines for which the mask `selected` is true.

        `selected` has the shape of the attribute `radius`.
        """
        flank, seat = (
            None if speeds is None else SurfaceSpeeds(speeds.moving[selected], speeds.fixed[selected])
            for speeds in (self.flank, self.seat)
        )
        assert flank is not None
        return replace(self, flank=flank, seat=seat, radius=self.radius[selected])

    @property
    def seat_scale(self) -> float:
        """Radius of the seat over that of the pin or sleeve [1]."""
        return _seat_radius(self.reducer) / self.reducer.design.ring.pin_radius

    def flank_friction(self, force: Array) -> MixedFriction:
        """Compute the friction of the disc on pins that do not turn; normal forces [N] have the shape of the phases."""
        design = self.reducer.design
        law, length = film_law(self.reducer, design.tooth_pair, self.inputs), design.line_length(design.tooth_pair)
        modulus = self.reducer.contacts.teeth.modulus
        return line_friction(law, force, self.flank.entrainment, self.flank.sliding, self.radius, length, modulus)

    def seat_friction(self, force: Array) -> MixedFriction | None:
        """Compute friction coefficients and film state of pins that roll in their seats; None without seats.

        The equivalent coefficient is the friction force at the flank that turns a pin in its seat, divided by the
        normal force. It is the coefficient of the seat times `seat_scale`. The film state is the film thickness over
        roughness and the load share of the asperities. `force` is the normal force of each contact [N], shape (m,
        teeth).
        """
        design, seat = self.reducer.design, self.seat
        if seat is None:
            return None
        law, length = film_law(self.reducer, design.tooth_pair, self.inputs), design.line_length(design.tooth_pair)
        play = self.inputs.play * design.pin_play
        seat_film = journal_friction(
            law, force, seat.entrainment, seat.sliding, _seat_radius(self.reducer), play, length
        )
        return seat_film.scaled(self.seat_scale)

    def smaller_friction(self, force: Array) -> tuple[MixedFriction, Mask]:
        """Compute the friction coefficient of each pin at its flank or in its seat, whichever is smaller.

        `force` is the normal force of each contact [N], shape (m, teeth).

        Returns
        -------
        tuple
            The smaller friction coefficient of each contact with its film state (`MixedFriction`), and a mask, shape
            (m, teeth): true where the seat has the smaller friction, so that the pin rolls on the disc.
        """
        flank_friction, seat_friction = self.flank_friction(force), self.seat_friction(force)
        if seat_friction is None:
            return flank_friction, np.zeros(flank_friction.coefficient.shape, dtype=bool)
        pin_rolls = seat_friction.coefficient < flank_friction.coefficient
        return MixedFriction(
            *(np.where(pin_rolls, getattr(seat_friction, name), value) for name, value in vars(flank_friction).items())
        ), pin_rolls

    @property
    def hole_speeds(self) -> SurfaceSpeeds:
        """Surface speeds of a hole and its output pin [m/s]."""
        output, gear = self.reducer.design.output, self.reducer.tooth_profile
        return hole_speeds(gear, output.pin_radius, output.hole_radius, self.reducer.speed_against_ring)

    def output_friction(self, force: Array) -> MixedFriction | None:
        """Compute friction coefficients and film state between holes and output pins; None for pins on needles.

        Plain rollers turn on their pins; their friction is converted to an equivalent coefficient at the rim of the
        roller. The film state is the film thickness over roughness and the load share of the asperities. `force` is the
        normal force of each contact [N], of any shape; the result has the same shape.
        """
        design = self.reducer.design
        output = design.output
        if output.has_needles:
            return None
        law, length = film_law(self.reducer, "output", self.inputs), design.line_length("output")
        speeds = self.hole_speeds
        if not output.rollers:
            contact = self.reducer.contacts["output"]
            radius = 1.0 / contact.relative_curvature
            return line_friction(law, force, speeds.entrainment, speeds.sliding, radius, length, contact.modulus)
        scale = output.root_radius / output.pin_radius
        core_speeds = speeds.scaled(scale)
        play = ASSUMED.roller_play * output.root_radius
        core_friction = journal_friction(
            law, force, core_speeds.entrainment, core_speeds.sliding, output.root_radius, play, length
        )
        return core_friction.scaled(scale)

    def cam_friction(self, force: Array) -> Array:
        """Compute the friction coefficients of the cams [1] under forces [N], at the bore radius of the disc.

        `force` has any shape; the result has the same shape.
        """
        design, force = self.reducer.design, np.asarray(force, float)
        radius = design.gear.bore_radius
        if design.gear.bearing == "rolling":
            coefficient = (
                self.inputs.load_friction * ASSUMED.roller_load_factor * cam_mean_diameter(self.reducer) / radius
            )
            return np.full(force.shape, coefficient)
        # the load turns with the cam, so only the disc's bore passes the contact
        speed = self.reducer.speed_against_ring * design.ring.teeth / design.lobes * radius
        law, play = film_law(self.reducer, "cam", self.inputs), design.clearance.cam
        return journal_friction(law, force, 0.5 * speed, speed, radius, play, design.line_length("cam")).coefficient

    def mean_cam_friction(self, force: Array) -> float:
        """Return the mean of `cam_friction` weighted by the forces of the cams [N]; 0 without forces."""
        total_force = max(float(np.sum(force)), np.finfo(float).tiny)
        return float(np.sum(self.cam_friction(force) * force) / total_force)


@dataclass(frozen=True, eq=False)
class FilmContacts:
    """Contacts with the ring and of output pins at m crank angles, for the film law.

    Attributes
    ----------
    surfaces
        Surfaces at the phases of the contact lines, shape (m, teeth).
    studs
        Number of contacts of output pins.
    unit_friction_per_force
        Generalised friction of each contact at a coefficient of 1, shape (m, n, u).
    phases, curvature
        Phases of the contact lines of ideally placed discs [rad] and their relative curvature [1/m], shape (m, teeth).
    disc, centres
        Disc of each contact line, shape (teeth,), and ideal centres of the discs [m], shape (m, D, 2).
    """

    surfaces: FilmSurfaces
    studs: int
    unit_friction_per_force: Array
    phases: Array
    curvature: Array
    disc: Integers
    centres: Array

    def displaced(self, departures: Array) -> "FilmContacts":
        """Return the lubricated contacts for discs that are displaced from their ideal pose.

        A displaced disc centre changes the phases of the pins, which are their angles from the direction of the
        eccentric: by 1.4 deg if a clearance of the cam of 25 um displaces a disc with an eccentricity of 1 mm.

        Parameters
        ----------
        departures
            Displacements from the ideal pose [m], shape (m, 3 D + 1) at m crank angles: x, y and rotation of each of D
            discs, then rotation of the output. Rotations are arc lengths at the radius of the circle of output pins.
        """
        moved_centres = self.centres + departures[:, :-1].reshape(len(departures), -1, 3)[..., :2]
        (x, y), (moved_x, moved_y) = np.moveaxis(self.centres, -1, 0), np.moveaxis(moved_centres, -1, 0)
        phase_change = np.arctan2(x * moved_y - y * moved_x, x * moved_x + y * moved_y)
        surfaces = build_film_surfaces(self.surfaces.reducer, self.phases + phase_change[:, self.disc], self.curvature)
        return replace(self, surfaces=replace(surfaces, inputs=self.surfaces.inputs))

    def friction(self, teeth: Array, output: Array, cam: Array) -> FilmFriction:
        """Compute the friction coefficients of all lubricated contacts under known normal forces.

        Parameters
        ----------
        teeth, output
            Normal forces of the contacts with the ring [N], shape (m, teeth) at m crank angles, and of the contacts of
            holes and output pins, shape (m, pins).
        cam
            Magnitude of the force of each of D cams [N], shape (m, D).

        Returns
        -------
        FilmFriction
            Coefficients [1] of the contacts with ring and output pins, shape (m, teeth + pins); the mean coefficient of
            the cams, weighted by their forces; the film state of the sliding contacts (`MixedFriction`); and which free
            pins roll on the disc, shape (m, teeth).
        """
        tooth_friction, pin_rolls = self.surfaces.smaller_friction(teeth)
        output_friction = self.surfaces.output_friction(output)
        roller_coefficient = self.surfaces.reducer.design.friction_of("output")
        output_coefficient = roller_coefficient if output_friction is None else output_friction.coefficient
        coefficients = np.concatenate(
            [tooth_friction.coefficient, np.broadcast_to(output_coefficient, output.shape)], axis=1
        )
        mean_cam_friction = self.surfaces.mean_cam_friction(cam)
        return FilmFriction(coefficients, mean_cam_friction, tooth_friction, output_friction, pin_rolls)

    def friction_at_working_forces(self) -> FilmFriction:
        """Compute the friction coefficients of all lubricated contacts under ideal peak forces at the design's load.

        Each contact has the ideal peak force of its kind (`reducer.contacts`); the halves of a divided ring share that
        of the teeth. The result is that of `friction`.
        """
        reducer, shape = self.surfaces.reducer, self.surfaces.radius.shape
        tooth_force, pin_force, cam_force = (
            reducer.contacts[kind].force for kind in (reducer.design.tooth_pair, "output", "cam")
        )
        return self.friction(
            np.full(shape, tooth_force / reducer.design.ring.halves),
            np.full((shape[0], self.studs), pin_force),
            np.full((shape[0], reducer.design.gear.discs), cam_force),
        )


def build_film_surfaces(reducer: Reducer, phases: Array, curvature: Array) -> FilmSurfaces:
    """Build the lubricated surfaces of the mesh at phases of the pins [rad] with their relative curvature [1/m].

    `phases` are angles from the direction of the eccentric, of any shape; `curvature` has the same shape.
    """
    gear = reducer.tooth_profile
    flank = tooth_speeds(gear, phases, reducer.speed_against_ring)
    return FilmSurfaces(
        reducer=reducer,
        flank=flank,
        seat=flank.scaled(_seat_radius(reducer) / gear.pin_radius) if reducer.design.seat_pair else None,
        radius=1.0 / np.maximum(curvature, ASSUMED.min_curvature),
    )


def build_film_contacts(reducer: Reducer, crank: Array, mesh_gaps: Gaps, teeth: int, motion: Array) -> FilmContacts:
    """Build the lubricated contacts of the discs with ring and output pins, for the friction law ``film``.

    Parameters
    ----------
    crank
        Crank angles in the frame of the ring [rad], shape (m,).
    mesh_gaps, teeth
        Gaps of all contacts, and the number of contact lines with the ring among them, which come first.
    motion
        Velocities [m/s] of the parts, shape (m, 3 D + 1), which determine the sliding directions: x, y and rotation of
        each of D discs, then rotation of the output. Rotations are multiplied by the radius of the circle of output
        pins.
    """
    gear = reducer.tooth_profile
    owner, disc = mesh_gaps.owner[:teeth] % gear.ring_teeth, mesh_gaps.disc[:teeth]
    phases = profile.pin_angles(gear)[owner] + np.array(reducer.phases)[disc] + crank[:, np.newaxis]
    sliding = np.einsum("...nu,...u->...n", mesh_gaps.slip_slope, motion)
    curvature = mesh_gaps.relative_curvature[:, :teeth]
    return FilmContacts(
        surfaces=build_film_surfaces(reducer, phases, curvature),
        studs=mesh_gaps.kind.size - teeth,
        unit_friction_per_force=-np.sign(sliding)[..., np.newaxis] * mesh_gaps.slip_slope,
        phases=phases,
        curvature=curvature,
        disc=disc,
        centres=np.stack([gear_centre(gear, crank + phase) for phase in reducer.phases], axis=1),
    )


def lubricant_temperature(reducer: Reducer, pair: str, temperatures: Mapping[str, float] | None = None) -> float:
    """Return the temperature of the lubricant in a kind of mating pair [°C]: the mean of both parts.

    `pair` is a kind such as "cam" (`PART_OF_PAIR`). `temperatures` are those of the parts [°C], by default those of the
    design.
    """
    thermal = vars(reducer.design.thermal) if temperatures is None else temperatures
    part, other_part = PART_OF_PAIR.get(pair, ("disc", "ring"))
    return 0.5 * float(thermal[part] + thermal[other_part])


@once
def film_law(reducer: Reducer, pair: str, inputs: FilmInputs = DESIGN_INPUTS) -> FilmLaw:
    """Return the friction law ``film`` (mixed lubrication) of a kind of mating pair at its lubricant's temperature.

    `pair` is "cam", "output" or the kind of the teeth, "pin_gear" or "tooth". `inputs` are factors on viscosity,
    roughness, boundary friction, film thickness, load share of the film and shear stresses; a factor of 1 keeps the
    value of the design.
    """
    friction, temperature = reducer.design.friction, lubricant_temperature(reducer, pair)
    oil = lubricant(friction.lubricant)
    law = FilmLaw(
        viscosity=inputs.viscosity * oil.viscosity(temperature),
        pressure_coefficient=oil.pressure_coefficient(temperature),
        roughness=inputs.roughness * friction.roughness,
        boundary=inputs.boundary * friction.boundary,
        formula=friction.film_formula,
        film_factor=inputs.film,
    )
    return replace(
        law,
        film_share=inputs.share * law.film_share,
        eyring_stress=inputs.shear * law.eyring_stress,
        limiting_shear=inputs.shear * law.limiting_shear,
    )


def film_text(reducer: Reducer) -> str:
    """Return the friction law as a condition of results, with the lubricant's temperature in the tooth contacts."""
    design = reducer.design
    if not design.has_film:
        return design.friction.words
    return f"{design.friction.words} at {lubricant_temperature(reducer, design.tooth_pair):.4g} °C"


def film_assumption(reducer: Reducer) -> str:
    """Return a sentence on the assumed mixed friction of a rotating crank: lubricant, film formula and roughness."""
    friction = reducer.design.friction
    return (
        f"mixed friction of a rotating crank with {friction.lubricant}: film thickness by {friction.film_formula}, "
        f"roughness Rq {1e6 * friction.roughness:g} um, boundary friction {friction.boundary:g}; cams and seals with "
        "drag by Palmgren and ISO/TR 14179-2; none in backlash, lost motion and stiffness"
    )


def cam_mean_diameter(reducer: Reducer) -> float:
    """Return the mean diameter of the rollers of a cam [m]."""
    return 2.0 * (reducer.design.gear.bore_radius - reducer.contacts.roller_radius)


def drag_torques(reducer: Reducer, inputs: FilmInputs = DESIGN_INPUTS) -> tuple[float, float]:
    """Return the load-independent drag torques of crank and output [N m].

    Without the law ``film``, they are the values `drag` of the design. With this law, the torques of the seals follow
    from ISO/TR 14179-2, unless the design sets `drag`. Palmgren's torque M0 of rolling bearings is added: of the cams
    on the crank, or in an RV reducer of the crank bearings on the crank and of the main bearings on the output.
    `inputs` are factors on the inputs of the law.

    Returns
    -------
    tuple of float
        Torques on crank and output [N m].
    """
    design = reducer.design
    crank_drag, output_drag = design.drag.crank, design.drag.output
    if not design.has_film:
        return crank_drag, output_drag
    if not (crank_drag or output_drag):
        crank_drag, output_drag = _seals_on_shafts(reducer)
    crank_drag, output_drag = inputs.seals * crank_drag, inputs.seals * output_drag
    if isinstance(reducer, RvReducer):
        needle_power, taper_power, main_power = (
            idle_power(reducer, bearings, inputs) for bearings in roller_bearings(reducer)
        )
        sun_speed, output_speed = abs(design.drive.speed), abs(reducer.output_speed)
        return (
            (crank_drag + (needle_power + taper_power) / sun_speed, output_drag + main_power / output_speed)
            if sun_speed
            else (crank_drag, output_drag)
        )
    if design.gear.bearing == "rolling":
        cam_speed = abs(reducer.speed_against_ring) * design.ring.teeth / design.lobes
        speed_ratio = cam_speed / abs(design.drive.speed) if design.drive.speed else 1.0
        cam_bearings = RollerBearings("cam", design.gear.discs, cam_mean_diameter(reducer), cam_speed)
        crank_drag += speed_ratio * idle_torque_of(reducer, cam_bearings, inputs)
    return crank_drag, output_drag


def drag_power(reducer: Reducer, inputs: FilmInputs = DESIGN_INPUTS) -> float:
    """Compute the power of `drag_torques` [W] at the speed of the drive."""
    (crank_drag, output_drag), speed = drag_torques(reducer, inputs), abs(reducer.design.drive.speed)
    return crank_drag * speed + output_drag * speed / reducer.design.reduction


@dataclass(frozen=True)
class RollerBearings:
    """Equal rolling bearings.

    Attributes
    ----------
    pair
        Kind of pair, for the temperature of the lubricant.
    count
        Number of bearings.
    diameter
        Mean diameter [m].
    speed
        Speed of the rings against each other [rad/s].
    """

    pair: str
    count: int
    diameter: float
    speed: float


def roller_bearings(reducer: RvReducer) -> tuple[RollerBearings, RollerBearings, RollerBearings]:
    """Return the needles in the discs, the tapered bearings and the main bearings of an RV reducer, in this order.

    The mean diameter of a tapered bearing is the mean of journal and outer ring. If the design has no main bearings,
    one is assumed on each flange, with its rollers midway between flange and pin circle.
    """
    cranks, discs, speed = reducer.cranks, reducer.design.gear.discs, reducer.crank_speed
    taper_diameter = reducer.journal_radius + cranks.taper_radius
    main_bearing = reducer.main_bearing
    main_diameter = (
        0.5 * (main_bearing.bore + main_bearing.outside)
        if main_bearing
        else reducer.flange_radius + reducer.design.ring.pin_circle_radius
    )
    return (
        RollerBearings(CRANK_BEARING, cranks.count * discs, 2.0 * reducer.needle_circle_radius, speed),
        RollerBearings(CRANK_TAPER, 2 * cranks.count, taper_diameter, speed),
        RollerBearings(MAIN_BEARING, 2, main_diameter, abs(reducer.output_speed)),
    )


def idle_torque_of(reducer: Reducer, bearings: RollerBearings, inputs: FilmInputs = DESIGN_INPUTS) -> float:
    """Compute the sum of Palmgren's load-independent torques M0 of equal rolling bearings [N m]."""
    temperature = lubricant_temperature(reducer, bearings.pair)
    viscosity = inputs.viscosity * lubricant(reducer.design.friction.lubricant).kinematic_viscosity(temperature)
    factor = inputs.idle_friction * ASSUMED.roller_idle_factor
    return bearings.count * idle_torque(factor, bearings.diameter, bearings.speed, viscosity)


def idle_power(reducer: Reducer, bearings: RollerBearings, inputs: FilmInputs = DESIGN_INPUTS) -> float:
    """Compute the power of `idle_torque_of` [W]."""
    return idle_torque_of(reducer, bearings, inputs) * bearings.speed


def state_seals(reducer: Drive) -> Drive:
    """Return the reducer with the seal torques of the law ``film`` as `drag.crank` and `drag.output` of its design.

    A reducer with another law, or whose design sets `drag`, is returned unchanged. The seal torques depend on the
    covers of the drive, which take 0.05 s to design. Copies of the result at other speeds and temperatures reuse these
    torques.
    """
    drag = reducer.design.drag
    if not reducer.design.has_film or drag.crank or drag.output:
        return reducer
    crank_torque, output_torque = _seals_on_shafts(reducer)
    return reducer.but(drag={"crank": crank_torque, "output": output_torque})


def _seals_on_shafts(reducer: Reducer) -> tuple[float, float]:
    """Return the torques of the seals on crank and output [N m]; the seal on the shaft turns against the ring."""
    crank_torque, output_torque = seal_torques(reducer)
    crank_speed = reducer.design.drive.speed
    return crank_torque * (abs(reducer.speed_against_ring / crank_speed) if crank_speed else 1.0), output_torque


@once
def seal_torques(reducer: Reducer) -> tuple[float, float]:
    """Compute the friction torques of the radial seals.

    The output has no seal, and a torque of 0, if the reducer has no covers or its hub has angular contact bearings. An
    RV reducer has a seal on the flange of its carrier only, because the motor seals the shaft of the sun. A hollow
    shaft has a second seal in the hub, around its other end.

    Returns
    -------
    tuple of float
        Torques of the seals on the shaft and on the hub of the output [N m].
    """
    if isinstance(reducer, RvReducer):
        return 0.0, seal_torque(2.0 * reducer.flange_outer_radius)
    from cycloid_mj.parts.export.casing import casing
    from cycloid_mj.parts.export.drive import has_casing

    hub = casing(reducer).hub if has_casing(reducer) else None
    hub_torque = seal_torque(hub.bore) if hub and not hub.contact_angle else 0.0
    shaft = reducer.design.shaft
    return (2.0 if shaft.bore_radius else 1.0) * seal_torque(2.0 * shaft.radius), hub_torque


def _seat_radius(reducer: Reducer) -> float:
    """Return the radius at which a moving pin or sleeve turns in its seat [m]."""
    design = reducer.design
    return design.ring.sleeve_bore_radius if design.ring.has_sleeves else design.ring.pin_radius
