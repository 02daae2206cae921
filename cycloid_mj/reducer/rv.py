"""Reducer of an RV design: planet stage, two or three cranks, no output pins."""

import math
from functools import lru_cache
from typing import TYPE_CHECKING, NoReturn, Self, TypeVar

from cycloid_mj.base import names
from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.units import in_mm
from cycloid_mj.design import Design
from cycloid_mj.design.layouts import Layout, unsupported_layout
from cycloid_mj.design.model import BEARING_CORNER, SHARES
from cycloid_mj.design.rv import CrankErrors, Cranks, CrankTolerance, Planet
from cycloid_mj.reducer.reducer import CACHED_DESIGNS, Reducer

if TYPE_CHECKING:
    from cycloid_mj.design.stock import StockBearing
    from cycloid_mj.geometry.involute import InvoluteGear
    from cycloid_mj.geometry.rv import RvKinematics
    from cycloid_mj.geometry.rv_loads import RvStage
    from cycloid_mj.reducer.bodies import Mechanism
    from cycloid_mj.reducer.rv_bodies import PlanetMesh
    from cycloid_mj.reducer.rv_contact import RvContacts
    from cycloid_mj.reducer.rv_member import RvMember

Table = TypeVar("Table")

WINDOW_MARGIN = 0.5e-3
"""Gap between a post and its window where they are closest, if the design leaves the window open [m] (heuristic)."""


FLANGE_WALL = 0.05
"""Wall of the flanges outside of the tapered bearings and the posts, per radius of the pin circle (heuristic)."""


class RvReducer(Reducer):
    """The reducer of a `design` with ``layout = "rv"``.

    It has the discs and the ring of a `Reducer`; its bodies are not those of a central crank (`rv_bodies`).
    """

    LAYOUT: Layout = "rv"
    INPUT = names.SUN
    INPUT_JOINT = names.planar_joints(names.SUN)[-1]
    BEARING_PAIRS = (names.CRANK_BEARING,)
    RIGID_BEARING = "rigid crank bearings"

    @staticmethod
    def _expanded(design: Design) -> Design:
        """Return a design as it is at the temperatures of ``[thermal]``; teeth without clearance are preloaded."""
        return _warm_design(design)

    @property
    def planet(self) -> Planet:
        """The table `planet` of the design."""
        return _required(self.design.planet)

    @property
    def cranks(self) -> Cranks:
        """The table `cranks` of the design."""
        return _required(self.design.cranks)

    @property
    def crank_errors(self) -> CrankErrors:
        """The table `crank_errors` of the design."""
        return _required(self.design.crank_errors)

    @property
    def crank_tolerance(self) -> CrankTolerance:
        """The table `crank_tolerance` of the design."""
        return _required(self.design.crank_tolerance)

    @property
    def has_errors(self) -> bool:
        """Whether any part has a manufacturing error, with those of cranks, bores, carrier, planets and output."""
        errors = self.crank_errors.model_dump(exclude={"output_radius"}).values()
        return super().has_errors or any(any(error) if isinstance(error, tuple) else error for error in errors)

    @property
    def has_runout(self) -> bool:
        """Whether the output has a run-out."""
        return bool(self.crank_errors.output_x or self.crank_errors.output_y)

    @property
    def output_radius(self) -> float:
        """Radius at which the rotation of the output is transmitted or measured [m]."""
        return self.crank_errors.output_radius or self.design.ring.pin_circle_radius

    @property
    def kinematics(self) -> "RvKinematics":
        """Return speed ratios of an RV reducer, and orders of periodic errors, from the numbers of teeth."""
        from cycloid_mj.geometry.rv import RvKinematics

        design, planet = self.design, self.planet
        return RvKinematics(
            planet.sun_teeth, planet.planet_teeth, design.ring.teeth, design.lobes, design.output.turns_ring
        )

    @property
    def crank_radius(self) -> float:
        """Radius of the circle of crank axes [m]."""
        planet = self.planet
        return self.cranks.radius or planet.module * (planet.sun_teeth + planet.planet_teeth) / 2.0

    @property
    def turn_ratio(self) -> float:
        """Turn of a crank per turn of the carrier at a fixed sun, both against the ring: 1 + z_s/z_p."""
        return 1.0 + self.planet.sun_teeth / self.planet.planet_teeth

    @property
    def stage(self) -> "RvStage":
        """Return the cycloidal stage (discs on their cranks), for closed forms in `geometry.rv_loads`."""
        from cycloid_mj.geometry.rv_loads import RvStage

        return RvStage(
            gear=self.tooth_profile,
            phases=self.phases,
            cranks=self.cranks.count,
            radius=self.crank_radius,
            to_carrier=float(self.kinematics.to_carrier),
            turn_ratio=self.turn_ratio,
        )

    @property
    def crank_turn(self) -> float:
        """Rotation of the cranks against the ring while the carrier turns once [rad]: all loads repeat after it."""
        return 2.0 * math.pi * abs(float(self.kinematics.crank_per_carrier))

    @property
    def crank_speed(self) -> float:
        """Speed of the crank bearings, the cranks' against the carrier [rad/s], at the speed of the drive."""
        return float(self.kinematics.bearing_turns) * abs(self.output_speed)

    @property
    def planet_mesh_speed(self) -> float:
        """Speed of the planets against the sun [rad/s], at the speed of the drive.

        The flanks slide with this speed times the distance of their contact from the pitch point.
        """
        return self.crank_speed * (1.0 + self.planet.planet_teeth / self.planet.sun_teeth)

    @property
    def output_speed(self) -> float:
        """Speed of the output at the speed of the drive [rad/s]."""
        return self.design.drive.speed / self.design.ratio

    @property
    def bore_radius(self) -> float:
        """Radius of the crank bores in the discs [m]: eccentric, needles and clearance."""
        return self.cranks.eccentric_radius + 2.0 * self.cranks.needle_radius + self.cranks.needle_clearance

    @property
    def needle_circle_radius(self) -> float:
        """Radius of the circle of the needles' axes around that of their eccentric [m]."""
        return self.cranks.eccentric_radius + self.cranks.needle_radius

    @property
    def post_circle_radius(self) -> float:
        """Radius of the circle of the carrier's posts [m]."""
        return self.cranks.post_circle_radius or self.crank_radius

    @property
    def window_radius(self) -> float:
        """Radius of the windows of the discs for the posts [m]."""
        return self.cranks.window_radius or self.cranks.post_radius + self.design.gear.eccentricity + WINDOW_MARGIN

    @property
    def journal_radius(self) -> float:
        """Radius of a crank's journals [m]: the largest over which the needle cages reach the eccentrics."""
        return self.cranks.eccentric_radius - self.design.gear.eccentricity

    @property
    def journal_fillet(self) -> float:
        """Radius of the fillets between journals and eccentrics [m], by the rule for the shoulders of a shaft."""
        return min(SHARES.fillet * self.journal_radius, BEARING_CORNER)

    @property
    def flange_wall(self) -> float:
        """Wall of the flanges outside of the tapered bearings and the posts [m]."""
        return FLANGE_WALL * self.design.ring.pin_circle_radius

    @property
    def main_bearing(self) -> "StockBearing | None":
        """Main bearing on each flange of the carrier; None without main bearings, or if none in stock fits."""
        from cycloid_mj.reducer.rv_main_bearings import choose_main_bearing

        if self.cranks.main_bearings == "none":
            return None
        return self.kept("main_bearing", lambda: choose_main_bearing(self))

    @property
    def crank_bearing(self) -> "StockBearing | None":
        """Tapered roller bearing in stock at each end of a crank; None if its dimensions are special, by drawing."""
        from cycloid_mj.design import stock

        sizes = 2.0 * self.journal_radius, 2.0 * self.cranks.taper_radius
        fitting_bearings = (
            bearing
            for bearing in stock.crank_bearings()
            if abs(bearing.bore - sizes[0]) + abs(bearing.outside - sizes[1]) < stock.ROUNDING
            and bearing.width < self.cranks.flange_thickness + stock.ROUNDING
        )
        return next(fitting_bearings, None)

    @property
    def crank_bearing_text(self) -> str:
        """Designation of the tapered bearings of the cranks, or that they are special, and their dimensions."""
        bearing = self.crank_bearing
        width = bearing.width if bearing else self.cranks.flange_thickness
        sizes = " x ".join(in_mm(size) for size in (2.0 * self.journal_radius, 2.0 * self.cranks.taper_radius, width))
        return f"{bearing.designation if bearing else names.SPECIAL}, {sizes} mm"

    @property
    def crank_support(self) -> float:
        """Distance of a crank's supports from the inner faces of the flanges [m].

        A bearing in stock has its outer ring away from the discs, and supports the crank in its load centre. A special
        bearing is as wide as the flange, and supports it in the middle.
        """
        bearing = self.crank_bearing
        return bearing.width - bearing.load_centre if bearing else 0.5 * self.cranks.flange_thickness

    @property
    def flange_radius(self) -> float:
        """Radius of the carrier's flanges next to the discs [m]: that of the seats of the main bearings, if any."""
        bearing = self.main_bearing
        return 0.5 * bearing.bore if bearing else self.min_flange_radius

    @property
    def flange_outer_radius(self) -> float:
        """Largest radius of the carrier's flanges [m]: that of the shoulders of the main bearings, if any."""
        bearing = self.main_bearing
        return bearing.shoulders[0] if bearing else self.min_flange_radius

    @property
    def min_flange_radius(self) -> float:
        """Smallest radius of the carrier's flanges [m]: bearings of the cranks and posts, and a wall around them."""
        inner_radius = max(
            self.crank_radius + self.cranks.taper_radius, self.post_circle_radius + self.cranks.post_radius
        )
        return inner_radius + self.flange_wall

    @property
    def bearing_stiffness(self) -> float:
        """Stiffness of the bearings of a crank under the force of one disc [N/m]: needles and taper in series."""
        return 1.0 / (1.0 / self.cranks.needle_stiffness + 1.0 / self.cranks.taper_stiffness)

    @property
    def bearing_clearance(self) -> float:
        """Radial clearance of a crank against a disc's bore [m]: that of needles and taper together."""
        return self.cranks.needle_clearance + self.cranks.taper_clearance

    @property
    def separate_needles(self) -> int:
        """Number of needles of an eccentric that are springs of their own; 0: the bearing is a single spring."""
        return self.cranks.needles if self.design.contact.needles == "each" else 0

    @property
    def cage_ratio(self) -> float:
        """Turns of the cage of needles per turn of their eccentric, both relative to the disc, by rolling."""
        inner_radius = self.cranks.eccentric_radius
        return inner_radius / (inner_radius + self.bore_radius)

    @property
    def mesh_stiffness(self) -> float:
        """Return the stiffness of a planet mesh along its line of action [N/m].

        It is that of the design file, else the estimate of ISO 6336-1 for steel (`geometry.rv.mesh_stiffness`).
        """
        from cycloid_mj.geometry.rv import mesh_stiffness

        planet = self.planet
        return planet.mesh_stiffness or mesh_stiffness(
            planet.sun_teeth, planet.planet_teeth, planet.pressure_angle, planet.face_width
        )

    @property
    def lever(self) -> float:
        """Lever arm that converts rotations to displacements in statics [m]: radius of the circle of crank axes."""
        return self.crank_radius

    @property
    def share(self) -> float:
        """Torque on the carrier, seen from the ring, per torque on the output, without losses."""
        return self.kinematics.share

    @property
    def stage_gears(self) -> "tuple[InvoluteGear, InvoluteGear]":
        """Sun and planet of the first stage; their `fault` says whether they can be manufactured."""
        from cycloid_mj.geometry.involute import gear_pair

        planet = self.planet
        tooth_counts = planet.sun_teeth, planet.planet_teeth
        return gear_pair(tooth_counts, planet.module, planet.pressure_angle, self.crank_radius, planet.backlash)

    @property
    def disc_section(self) -> float:
        """Cross-section area of a disc [m2]: outline less middle hole, crank bores and windows."""
        from cycloid_mj.geometry import profile

        cut = self.cranks.middle_hole_radius**2
        cut += self.cranks.count * (self.bore_radius**2 + self.window_radius**2)
        return profile.area(self.gear_profile, self.profile_offset) - math.pi * cut

    @property
    def mechanism(self) -> "Mechanism":
        """Bodies, surfaces and mating pairs."""
        from cycloid_mj.reducer.rv_bodies import build_rv_mechanism

        return self.kept("mechanism", lambda: build_rv_mechanism(self))

    @property
    def planet_mesh(self) -> "PlanetMesh":
        """Mesh of the sun with the planets."""
        from cycloid_mj.reducer.rv_bodies import compute_planet_mesh

        return self.kept("planet_mesh", lambda: compute_planet_mesh(self))

    @property
    def contacts(self) -> "RvContacts":
        """Working force, stiffness and pressure of the contacts, by kind of pair."""
        from cycloid_mj.reducer.rv_contact import RvContacts

        return RvContacts(self)

    @property
    def member(self) -> "RvMember":
        """Output member and the kinematics of all members, in terms of the sun."""
        from cycloid_mj.reducer.rv_member import RvMember

        design = self.design
        return RvMember(design.output.turns_ring, design.ring.teeth, design.lobes, self.kinematics)

    @property
    def for_slices(self) -> Self:
        """Reducer for a model in stock MuJoCo: as that of a central crank, with a sun that is centred by bearings."""
        return super().for_slices.but(planet={"sun_support": "fixed"})

    @property
    def orbit_speed(self) -> float:
        """Speed of the cranks against the ground [rad/s], with which discs orbit, at the speed of the drive."""
        return float(self.member.crank_angle(self.design.drive.speed))

    @property
    def clearance_keys(self) -> dict[str, tuple[tuple[str, str], ...]]:
        """Return, by kind of mating pair, table and key in the design file of its clearances, from ring to sun.

        An entry is "planet_mesh": (("planet", "backlash"),). Crank bearings have two clearances, those of the needle
        and of the tapered bearing; others have one.
        """
        ring_kinds = [kind for kind in (self.design.tooth_pair, self.design.seat_pair) if kind]
        return {
            **{kind: (("clearance", kind),) for kind in ring_kinds},
            names.CRANK_BEARING: (("cranks", "needle_clearance"), ("cranks", "taper_clearance")),
            names.PLANET_MESH: (("planet", "backlash"),),
        }

    def play_at(self, crank: float) -> float:
        """Compute the backlash of the output [rad] at a fixed sun, with rigid parts without errors, at any angle.

        It is the sum of the backlash of the planets, the clearance of the crank bearings and the clearance of the
        teeth, each converted to the output (principle of virtual work). The clearance of the crank bearings contributes
        twice: along the circle of the crank axes, and perpendicular to the eccentricity. `crank` has no effect.
        """
        design, bearing_clearance = self.design, self.bearing_clearance
        tooth_clearance = getattr(design.clearance, design.tooth_pair) + design.pin_play
        planet = self.planet
        pitch_radius = self.crank_radius * planet.planet_teeth / (planet.sun_teeth + planet.planet_teeth)
        eccentricity = design.gear.eccentricity
        crank_play = (
            planet.backlash / pitch_radius + 2.0 * (max(bearing_clearance, 0.0) + tooth_clearance) / eccentricity
        )
        rotation_play = 2.0 * design.lobes * max(bearing_clearance, 0.0) / self.crank_radius
        return float((crank_play + rotation_play) / self.stage.speed_up * self.share)

    @property
    def carrying_parts(self) -> tuple[str, int]:
        """Name and number of the equal parts that transmit the torque between discs and carrier."""
        return "cranks", self.cranks.count

    @property
    def near_face(self) -> float:
        """Not available: there is no output disc."""
        self._refuse()

    def _refuse(self) -> NoReturn:
        raise DesignError(unsupported_layout(self.design.name, self.design.layout))


@lru_cache(maxsize=CACHED_DESIGNS)
def _warm_design(design: Design) -> Design:
    """Return a design as it is at the temperatures of ``[thermal]``, with the elastic deformation of ring and discs.

    If the teeth interfere, housing and discs yield: only a fraction of the interference (`rv_preload.preload_share`)
    remains as the deflection of the contacts.
    """
    from cycloid_mj.geometry.expansion import expand, tooth_play
    from cycloid_mj.reducer.rv_preload import preload_share

    warm_design, interference = expand(design), max(0.0, -tooth_play(design))
    if not interference:
        return warm_design
    relief = (1.0 - preload_share(RvReducer(warm_design))) * interference
    return warm_design.but(modification={"equidistant": warm_design.modification.equidistant + relief})


def _required(table: Table | None) -> Table:
    """Return a table of the design, which every design with the layout has."""
    assert table is not None
    return table


def reducer_of(design: Design) -> Reducer:
    """Create the reducer of a design of any layout, for functions that support all; errors as in `Reducer`."""
    return RvReducer(design) if design.layout == RvReducer.LAYOUT else Reducer(design)
