"""Reducer of a design: derived values, computed on first use and cached.

A ``Design`` is the input; a ``Reducer`` is created from it once, and all packages above work with it. The modules that
compute a property are imported on its first use, so that the help of a command line loads no numpy.
"""

import math
from collections.abc import Callable, Hashable, Mapping
from functools import lru_cache, wraps
from typing import TYPE_CHECKING, Any, Concatenate, ParamSpec, Self, TypeVar, cast

from cycloid_mj.base import names
from cycloid_mj.base.errors import DesignError
from cycloid_mj.design import Design
from cycloid_mj.design.layouts import Layout, unsupported_layout

if TYPE_CHECKING:
    from cycloid_mj.geometry.deviations import Deviations
    from cycloid_mj.geometry.profile import CycloidGear
    from cycloid_mj.reducer.bodies import Mechanism
    from cycloid_mj.reducer.contact import Contacts
    from cycloid_mj.reducer.member import Member
    from cycloid_mj.reducer.roller_needles import RollerNeedles
    from cycloid_mj.reducer.worn import WornGaps

Given = ParamSpec("Given")
Value = TypeVar("Value")

CACHED_DESIGNS = 24
"""Number of designs whose derived values are cached."""

SLICES_CREEP = 0.02
"""Creep speed of slices [m/s] (heuristic): stock MuJoCo lifts sliding contacts by mu^2 v/(v0 impratio), more at a low
creep speed v0."""

SHAPING_NOTHING = (
    *("name", "errors", "measured", "friction", "drag", "contact", "stiffness", "damping", "working_force"),
    *("drive", "load", "environment", "settings"),
)
"""Design tables that no part depends on: runs at other loads and speeds share the same parts."""


@lru_cache(maxsize=CACHED_DESIGNS)
def _cache_of(design: Design) -> dict[Hashable, Any]:
    """Return the cache of the derived values of a design."""
    return {}


class Reducer:
    """The reducer of a `design`, with new parts or `worn` ones; only statics takes wear into account.

    Reducers of equal designs with new parts are equal, and share their cached values.

    Raises
    ------
    DesignError
        The design has another layout than `LAYOUT` (`reducer_of` creates the reducer of any layout), or its parts jam
        at the temperatures of ``[thermal]``.
    """

    LAYOUT: Layout = "central"

    INPUT = names.CRANK
    """Stem of the log's columns of the driven shaft: ``crank_angle``, ``crank_speed``, ``crank_torque``."""

    INPUT_JOINT = names.CRANK_JOINT
    """Joint of the driven shaft."""

    BEARING_PAIRS: tuple[str, ...] = ("cam", "output")
    """Kinds of pairs with rolling bearings."""

    RIGID_BEARING = "a rigid cam"
    """Bearing between crank and disc in the limit of ideal load sharing, for texts."""

    def __init__(self, design: Design, worn: "WornGaps | None" = None) -> None:
        """Create the reducer of a design, with parts expanded to their temperatures and the wear `worn`, if any.

        Reducers of equal designs without wear share a cache.

        Raises
        ------
        DesignError
            The design has another layout than `LAYOUT`, or its parts jam at its temperatures.
        """
        if design.layout != self.LAYOUT:
            raise DesignError(unsupported_layout(design.name, design.layout))
        self.design = design if design.thermal.is_reference else self._expanded(design)
        self.worn = worn
        self._kept = _cache_of(design) if worn is None else {}

    @staticmethod
    def _expanded(design: Design) -> Design:
        """Return a design as it is at the temperatures of ``[thermal]``."""
        from cycloid_mj.geometry.expansion import expand

        return expand(design)

    def but(self, **changes: Any) -> Self:
        """Return the reducer of the design with changed values, in SI units, as ``Design.but``; errors as there."""
        return type(self)(self.design.but(**changes), self.worn)

    def turning_at(self, speed: float) -> Self:
        """Return the reducer with a speed of its input [rad/s], in the direction of the design's own speed."""
        return self.but(drive={"speed": math.copysign(speed, self.design.drive.speed)})

    def at_temperatures(self, temperatures: Mapping[str, float]) -> Self:
        """Return the reducer with other temperatures [°C], by part name, which may exceed those of a design file.

        Raises
        ------
        DesignError
            The parts jam at these temperatures.
        """
        from cycloid_mj.geometry.expansion import at_temperatures

        return type(self)(at_temperatures(self.design, temperatures), self.worn)

    def with_nominal_torque(self, torque: float) -> Self:
        """Return the reducer whose motor has a nominal torque at the output [N m], with the same reserve of power."""
        drive, needed = self.design.drive, torque / self.design.reduction
        return self.but(drive={"torque": needed, "power": drive.power * needed / drive.torque})

    def steady(self, settled: float, turns: float, samples: float = 0.0, **changes: Mapping[str, Any]) -> Self:
        """Return the reducer for a run at full speed from its start, over some crank turns, as ``Design.steady``."""
        driven_turns = turns * abs(float(self.member.driven_angle(1.0)))
        return type(self)(self.design.steady(settled, driven_turns, samples, **changes), self.worn)

    def working_at(self, torque: float) -> Self:
        """Return the same reducer with contact stiffnesses at an output torque [N m] instead of at its load.

        If the design sets a working load, or a working force for all pairs, the reducer is returned unchanged.
        """
        contact = self.design.contact
        if contact.working_load or contact.working_force:
            return self
        return self.but(contact={"working_load": abs(torque)})

    @property
    def at_rated_load(self) -> Self:
        """Return the reducer with contact stiffnesses at its own load, or at the nominal torque if it has no load.

        With a preloaded ring, the larger of both torques is used; see `working_at`. The result is cached.
        """

        def build() -> Reducer | None:
            own_load, nominal = abs(self.design.load.torque), self.design.rated_torque
            reducer = self.working_at(max(own_load, nominal) if self.design.ring.preload else own_load or nominal)
            return None if reducer.design == self.design else reducer

        return cast("Self", self.kept("at_rated_load", build) or self)  # not cached on itself, as in `shape`

    @property
    def for_slices(self) -> Self:
        """Return the reducer for simulations with triangle meshes, in which surfaces are divided into convex slices.

        Its contact stiffnesses are those at the nominal torque, or at its load if that is larger. A smaller load does
        not reduce them, because the contact of slices becomes softer at a small depth anyway. Its creep speed is
        `SLICES_CREEP` unless the design sets one.
        """
        stiffened_reducer = self.working_at(max(abs(self.design.load.torque), self.design.rated_torque))
        creep_speed = self.design.contact.creep_speed or SLICES_CREEP
        return stiffened_reducer.but(contact={"creep_speed": creep_speed, "needles": "lumped"})

    @property
    def separate_needles(self) -> int:
        """Number of rollers of a cam that are springs of their own; 0: the bearing is a single spring."""
        contact, gear = self.design.contact, self.design.gear
        return contact.cam_rollers if contact.needles == "each" and gear.bearing == "rolling" else 0

    @property
    def roller_needles(self) -> "RollerNeedles":
        """Needles of the rollers of output pins that are springs of their own."""
        from cycloid_mj.reducer.roller_needles import roller_needles

        return self.kept("roller_needles", lambda: roller_needles(self))

    @property
    def roller_compliance(self) -> float:
        """Compliance of the needles of an output roller [m/N]; 0 if there are none, or if they are separate springs."""
        from cycloid_mj.reducer.roller_needles import lumped_compliance

        return self.kept("roller_compliance", lambda: lumped_compliance(self))

    @property
    def output_clearance(self) -> float:
        """Gap between an output pin and its hole in the ideal pose [m]: clearance and differences of nominal sizes."""
        design = self.design
        output = design.output
        return design.clearance.output + output.hole_radius - output.pin_radius - design.gear.eccentricity

    @property
    def cage_ratio(self) -> float:
        """Turns of the cage of separate rollers of a cam per turn of the cam, both relative to the disc, by rolling.

        The rollers fill the bore of the disc, as in `Contacts.roller_radius`: their radius is sin(pi/Z) of that of
        their circle.
        """
        return 0.5 * (1.0 - math.sin(math.pi / self.design.contact.cam_rollers))

    def kept(self, key: Hashable, compute: Callable[[], Value]) -> Value:
        """Return the cached value of a key, computed on first use."""
        if key not in self._kept:
            self._kept[key] = compute()
        value: Value = self._kept[key]
        return value

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Reducer):
            return NotImplemented
        return self.design == other.design and self.worn is other.worn

    def __hash__(self) -> int:
        return hash(self.design)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.design, self.worn)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.design!r})"

    @property
    def shape(self) -> Self:
        """Return the reducer with the same parts, but without load, speed and contact law.

        Results that depend on the parts only are cached on it, so that reducers with equal parts share them.
        """

        def build() -> Reducer | None:
            fields = Design.model_fields
            design = self.design.model_copy(update={name: fields[name].default for name in SHAPING_NOTHING})
            return None if design == self.design else type(self)(design)

        # the reducer is not cached on itself: such a cycle would keep the cache until the next garbage collection
        return cast("Self", self.kept("shape", build) or self)

    @property
    def phases(self) -> tuple[float, ...]:
        """Phase of each disc on the crank [rad], counter-clockwise: evenly spaced, the first with the crank."""
        from cycloid_mj.reducer.bodies import phases

        return self.shape.kept("phases", lambda: phases(self.design))

    @property
    def speed_against_ring(self) -> float:
        """Speed of the crank or cranks against the ring [rad/s], at the speed of the drive."""
        return float(self.member.against_ring(self.design.drive.speed))

    @property
    def play(self) -> float:
        """Largest backlash of the output with rigid parts [rad], at crank angle 0; errors as in ``limits.stops``."""
        return self.kept("play", lambda: self.play_at(0.0))

    def play_at(self, crank: float) -> float:
        """Compute the largest backlash of the output with rigid parts [rad] at a crank angle [rad]; see `play`."""
        from cycloid_mj.reducer.limits import widest_play

        return widest_play(self, crank)

    @property
    def clearance_keys(self) -> dict[str, tuple[tuple[str, str], ...]]:
        """Kind of mating pair -> table and key of its clearances in the design, from the ring to the output."""
        return {kind: (("clearance", kind),) for kind in self.design.pair_kinds}

    @property
    def gears(self) -> tuple[str, ...]:
        """Names of the bodies of all discs."""
        return names.gears(self.design.gear.discs)

    @property
    def tooth_profile(self) -> "CycloidGear":
        """Ideal mesh without clearance and modification."""
        from cycloid_mj.geometry.modification import tooth_profile

        return self.shape.kept("tooth_profile", lambda: tooth_profile(self.design))

    @property
    def gear_profile(self) -> "CycloidGear":
        """Mesh of the disc's profile, without clearance but with the modified pin circle."""
        from cycloid_mj.geometry.modification import gear_profile

        return self.shape.kept("gear_profile", lambda: gear_profile(self.design))

    @property
    def profile_offset(self) -> float:
        """Distance of the disc's profile from its trochoid [m]: pin radius, clearance and equidistant modification."""
        from cycloid_mj.geometry.modification import profile_offset

        return self.shape.kept("profile_offset", lambda: profile_offset(self.design))

    @property
    def deviations(self) -> "Deviations":
        """Manufacturing errors of the parts, from lists or drawn at random."""
        from cycloid_mj.geometry.deviations import deviations

        return self.kept("deviations", lambda: deviations(self.design))

    @property
    def parts_text(self) -> str:
        """Manufacturing errors of the parts in words, for figures that depend on them."""
        if not self.design.measured.is_empty:
            return "as measured, with the errors of the design"
        return "with the errors of the design" if self.has_errors else "perfect"

    @property
    def has_errors(self) -> bool:
        """Whether any part has a manufacturing error."""
        return self.deviations.largest > 0.0

    @property
    def is_ideal(self) -> bool:
        """True if all parts are ideal: no errors, no modification, no preloaded ring."""
        modification = self.design.modification
        modified = modification.equidistant or modification.pin_circle or modification.rotation
        return not (modified or self.design.ring.preload) and self.deviations.largest == 0.0

    @property
    def mechanism(self) -> "Mechanism":
        """Bodies, surfaces and mating pairs."""
        from cycloid_mj.reducer.bodies import build_mechanism

        return self.kept("mechanism", lambda: build_mechanism(self.design))

    @property
    def orbit_speed(self) -> float:
        """Speed of the crank [rad/s], with which the discs orbit, at the speed of the drive."""
        return self.design.drive.speed

    @property
    def contacts(self) -> "Contacts":
        """Working force, stiffness and pressure of the contacts, by kind of pair."""
        from cycloid_mj.reducer.contact import Contacts

        return Contacts(self)

    @property
    def member(self) -> "Member":
        """Output member and the kinematics of all members."""
        from cycloid_mj.reducer.member import member_of

        return self.shape.kept("member", lambda: member_of(self.design))

    @property
    def lever(self) -> float:
        """Lever arm that converts rotations to displacements in statics [m]: radius of the circle of output pins."""
        return self.design.output.pin_circle_radius

    @property
    def disc_section(self) -> float:
        """Return the cross-section area of a disc [m2]: area within its outline minus bore and holes.

        Outline, bore and holes include the clearances. A flank rotation of the outline is not included.
        """
        from cycloid_mj.geometry import profile

        gear, output, clearance = self.design.gear, self.design.output, self.design.clearance
        squared_hole_radii = output.pins * (output.hole_radius + clearance.output) ** 2
        bored_area = math.pi * ((gear.bore_radius + clearance.cam) ** 2 + squared_hole_radii)
        return profile.area(self.gear_profile, self.profile_offset) - bored_area

    @property
    def carrying_parts(self) -> tuple[str, int]:
        """Name and number of the equal parts that transmit the torque between discs and carrier."""
        return "output pins", self.design.output.pins

    @property
    def near_face(self) -> float:
        """Axial end of the parts on the input side of the discs [m], including the second output disc."""
        from cycloid_mj.reducer.bending import AXIAL_GAP

        output, near = self.design.output, -self.design.gear.stack_width / 2 - AXIAL_GAP
        return near - output.disc_thickness - AXIAL_GAP if output.support == "both_ends" else near

    @property
    def share(self) -> float:
        """Torque on the carrier per torque on the output, without losses; `Member.share`."""
        return self.shape.kept("share", lambda: self.member.share)

    @property
    def mesh_turn(self) -> float:
        """Crank rotation after which it has passed all of the ring [rad]: 2 pi, or 2 pi N/(N-1) if the ring rotates."""
        return 2.0 * math.pi * self.design.ring.teeth / self.mesh_periods

    @property
    def mesh_periods(self) -> int:
        """Number of mesh periods per crank revolution: N, or N - 1 if the ring rotates."""
        return self.design.lobes if self.design.output.turns_ring else self.design.ring.teeth


Drive = TypeVar("Drive", bound=Reducer)


def once(function: Callable[Concatenate[Drive, Given], Value]) -> Callable[Concatenate[Drive, Given], Value]:
    """Decorate a function of a reducer so that its result is cached for each value of its other arguments.

    The cache belongs to the reducer and is shared by reducers of equal designs, so the function runs once for all of
    them. Callers must not change a result.
    """

    @wraps(function)
    def cached_function(reducer: Drive, /, *arguments: Given.args, **keywords: Given.kwargs) -> Value:
        """Return the cached result for these arguments, or compute it."""
        key = (function, arguments, *sorted(keywords.items()))
        return reducer.kept(key, lambda: function(reducer, *arguments, **keywords))

    return cached_function
