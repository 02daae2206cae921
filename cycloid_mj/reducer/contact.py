"""Contacts by kind of mating pair: working force, stiffness and pressure.

The stiffness of a line contact increases with its force. The model has a constant stiffness for each kind of pair: the
secant stiffness at a typical force, the working force. By default, the working force is the force on the most loaded
contact of the kind if the load torque is shared ideally.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, ClassVar, Literal, TypeVar

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.deprecated import deprecated_attribute
from cycloid_mj.base.errors import ContactError
from cycloid_mj.base.units import MILLIMETRE
from cycloid_mj.geometry import ideal_loads
from cycloid_mj.geometry.profile import CycloidGear
from cycloid_mj.reducer.bending import pin_flexibility
from cycloid_mj.reducer.impact import ImpactLaw

if TYPE_CHECKING:
    from cycloid_mj.reducer import Reducer

STRIBECK = 4.08
"""Load of the most loaded roller of a bearing without clearance, over the mean load per roller F/Z."""


@dataclass(frozen=True)
class ContactSettings:
    """Settings of contacts that a design file may leave open."""

    creep_share: float = 2e-3
    """Creep speed over the orbital speed of the disc's centre, c w; friction below it is too small. Efficiencies of six
    drives differ by 0.04 points from those at a tenth of it, and by 0.25 at five times it."""
    slow_creep: float = 1e-4
    """Creep speed if the crank is at rest [m/s]."""
    hertz_reach: float = 0.3
    """Largest half width of the strip of contact over the radius of the thinner body (assumed).

    Hertz takes b << R (Johnson 1985, 4.1); a strip of 0.3 R, 17 deg to each side, is where conformal solutions leave
    it."""
    cam_force_angles: int = 97
    """Number of crank angles over which the cam force is averaged: a prime, so that all phases of the mesh occur."""


CONTACT = ContactSettings()


Source = Literal["given", "working load", "load", "preload", "weight and inertia"]
"""Origin of a working force.

"given" is the design file. The others name the load from which the force is computed: ``contact.working_load``, the
load torque, the nominal torque of a preloaded ring, or weight and inertia of the discs if these cause larger forces.
"""

Value = TypeVar("Value")


@dataclass(frozen=True)
class CurvatureLaw:
    """Stiffness of a tooth contact as a function of the local relative curvature kappa.

    The compliance is in proportion to ``constant + ln kappa`` and has the value ``reference`` for a pin on a flat; a
    ``reference`` of 0 switches the law off. At most the stiffness doubles: a contact that is more conformal than that
    is no line contact any more.

    Attributes
    ----------
    reference, constant
        Dimensionless; see ``ideal_loads.line_contact_constant``.
    stiffness
        Stiffness of a pin on a flat [N/m].
    deflection
        Deflection of a pin on a flat under the working force [m]. Contact lines with a smaller gap between them form a
        single contact area, a patch, and share a spring. 0 keeps all lines separate.
    """

    reference: float
    constant: float
    stiffness: float
    deflection: float

    def factor(self, relative_curvature: float) -> float:
        """Return the stiffness at a relative curvature [1/m], relative to that of a pin on a flat."""
        return float(self.factors(np.array(relative_curvature)))

    def factors(self, relative_curvature: Array) -> Array:
        """Return `factor` at many relative curvatures [1/m], in their shape."""
        if self.reference == 0.0:
            return np.ones(relative_curvature.shape)
        min_curvature = math.exp(0.5 * self.reference - self.constant)
        return np.asarray(self.reference / (self.constant + np.log(np.maximum(relative_curvature, min_curvature))))


class Contact:
    """A kind of mating pair of a reducer, such as ``"tooth"``; expensive values are cached on the reducer."""

    __slots__ = ("_reducer", "kind")

    HAS_PRESSURE: ClassVar[bool] = True
    """Whether the pair has a line contact, whose Hertz pressure follows from its force."""

    def __init__(self, reducer: "Reducer", kind: str) -> None:
        self._reducer = reducer
        self.kind = kind

    @property
    def force(self) -> float:
        """Return the working force of the pair [N], at which its secant stiffness is computed.

        For a cam it is the force on all rollers. The first of these values that exists is used:

        - ``working_force`` of this kind of pair in the design file;
        - ``contact.working_force`` in the design file, for all pairs. A rolling cam has this force on its most loaded
          roller. A plain cam has N/4 times this force, because ideal sharing among N teeth leads to this ratio of the
          cam's force to that of the most loaded tooth;
        - the largest force of the pair under ideal sharing of a disc's torque T, which is `Contacts.working_load`
          divided by the number of discs. It is 4 T/(N c (N-1)) for the N teeth, with the eccentricity c, and 4 T/(n R)
          for n output pins on a circle of radius R. A cam has the mean force over a turn that balances both.
        """
        design = self._reducer.design
        stated_force: float = getattr(design.working_force, self.kind)
        common_force = design.contact.working_force
        if stated_force:
            return stated_force
        if not common_force:
            return self._ideal_force(self._reducer.contacts.working_load / design.gear.discs)
        if self.kind != "cam":
            return common_force
        is_rolling = design.gear.bearing == "rolling"
        return common_force * (design.contact.cam_rollers / STRIBECK if is_rolling else design.ring.teeth / 4.0)

    @property
    def source(self) -> Source:
        """Return the origin of the working force (`force`), at which the stiffness of the pair is computed.

        It is "given" if the design file states the force. Otherwise it is the load from which the force is computed,
        one of the values of `Source`.
        """
        design = self._reducer.design
        if getattr(design.working_force, self.kind) or design.contact.working_force:
            return "given"
        if design.contact.working_load:
            return "working load"
        if abs(design.load.torque) >= self._reducer.contacts.working_load:
            return "load"
        return "preload" if design.ring.preload else "weight and inertia"

    @property
    def damping_ratio(self) -> float:
        """Damping ratio [1]."""
        design = self._reducer.design
        return float(getattr(design.damping, self.kind)) or design.contact.damping_ratio

    @property
    def modulus(self) -> float:
        """Modulus E* [Pa] of the materials of both parts."""
        first_part, second_part = self._reducer.design.partners(self.kind)
        return ideal_loads.contact_modulus(
            first_part.youngs_modulus, first_part.poisson, second_part.youngs_modulus, second_part.poisson
        )

    @property
    def strength(self) -> float:
        """Yield strength [Pa] of the weaker of the two surfaces."""
        return min(part.surface_strength for part in self._reducer.design.partners(self.kind))

    @property
    def weaker_is_plastic(self) -> bool:
        """True if the weaker surface is a plastic."""
        weaker = min(self._reducer.design.partners(self.kind), key=lambda part: part.surface_strength)
        return weaker.is_plastic

    @property
    def impact(self) -> ImpactLaw | None:
        """Return the parameters of the Adams contact law IMPACT for a line contact of the pair; None with another law.

        If a massless pin transmits the force, the parameters are those of its two contacts in series.
        """
        law, design = self._reducer.contacts.impact, self._reducer.design
        if law is None:
            return None
        return (law.in_series() if self._is_through_pin else law).of_lines(design.lines(self.kind))

    @property
    def curvature_law(self) -> CurvatureLaw:
        """Return the stiffness of a line contact of the pair as a function of its curvature.

        It is valid for the pair's material, width and working force. With the law IMPACT, or with another
        ``contact.stiffness_law`` than "local", the stiffness is constant.

        Raises
        ------
        ContactError
            The working force flattens a pin beyond a line contact.
        """
        return self._kept(Contact.curvature_law, self._compute_curvature_law)

    @property
    def stiffness(self) -> float:
        """Return the stiffness of the pair [N/m] in the design file, or else the secant stiffness at the working force.

        The secant stiffness depends on the kind of pair:

        - teeth: stiffness of a pin on a flat;
        - sockets, sleeves and holes: stiffness at their relative curvature;
        - rolling cam: stiffness at the load of the most loaded roller, which is 4.08/Z of the load of Z rollers
          (Stribeck; Harris, Rolling Bearing Analysis). It has two contacts in series, each as stiff as a pin on a flat;
        - plain cam: `ideal_loads.conformal_stiffness`.

        With the law IMPACT, all pairs have the secant stiffness of the spring of this law.
        """
        return self._kept(Contact.stiffness, self._compute_stiffness)

    @property
    def stiffness_by_disc(self) -> tuple[float, ...]:
        """Return the normal stiffness [N/m] of a contact on each of D discs, (D,), with parts in series with it.

        Parts in series are the seat of a ring pin without mass, the needles of an output roller and, with ``structure =
        "springs"``, an output pin, which bends.

        Raises
        ------
        ContactError
            The working force flattens a pin beyond a line contact.
        """
        contacts = self._reducer.contacts
        stiffness = contacts.mesh_stiffness if self._is_through_pin else self.stiffness
        compliance = np.zeros(self._reducer.design.gear.discs)
        if self.kind == "output":
            compliance = contacts.pin_flexibility.diagonal() + self._reducer.roller_compliance
        return tuple(
            1.0 / (1.0 / stiffness + flexibility) if flexibility else stiffness for flexibility in compliance.tolist()
        )

    series = deprecated_attribute("Contact", "series", "stiffness_by_disc")

    @property
    def relative_curvature(self) -> float:
        """Return the relative curvature [1/m] of all contacts of this kind; not defined for teeth, where it varies.

        A pin or a plain cam is a cylinder in a bore, whose curvatures are subtracted. With rollers, a roller and the
        cam are both convex, so that the pressure is higher than at the bore. The raceway of the cam is assumed to have
        the radius of the bore.
        """
        design = self._reducer.design
        if self.kind == "cam" and self._has_rollers:
            return 1.0 / self._reducer.contacts.roller_radius + 1.0 / design.gear.bore_radius
        ring, output, clearance = design.ring, design.output, design.clearance
        inner_radius, outer_radius = {
            "cam": (design.gear.bore_radius, design.gear.bore_radius + clearance.cam),
            "pin_socket": (ring.pin_radius, ring.pin_radius + clearance.pin_socket),
            "pin_sleeve": (ring.sleeve_bore_radius - clearance.pin_sleeve, ring.sleeve_bore_radius),
            "output": (output.pin_radius, output.hole_radius + clearance.output),
        }[self.kind]
        return 1.0 / inner_radius - 1.0 / outer_radius

    @property
    def line_share(self) -> float:
        """Share of the pair's force on its most loaded line contact [1]; of a rolling cam, on one roller."""
        rollers = self._reducer.design.contact.cam_rollers
        return STRIBECK / rollers if self.kind == "cam" and self._has_rollers else 1.0

    def pressure(self, force: npt.ArrayLike, curvature: npt.ArrayLike) -> Array:
        """Compute the peak Hertz pressure [Pa] of line contacts; conformal contacts count as flat on flat.

        `force` [N] and relative `curvature` [1/m] broadcast to the shape of the result.
        """
        return self._hertz(force, curvature).peak_pressure

    def half_width(self, force: npt.ArrayLike, curvature: npt.ArrayLike) -> Array:
        """Compute the half width of the strip of line contacts [m]; conformal contacts count as flat on flat.

        `force` [N] and relative `curvature` [1/m] broadcast to the shape of the result.
        """
        return self._hertz(force, curvature).half_width

    def hertz_holds(self, force: npt.ArrayLike, curvature: npt.ArrayLike) -> Mask:
        """Return whether each line contact is not conformal: its strip is narrow compared with the thinner body.

        `force` [N] on the line and relative `curvature` [1/m] broadcast to the shape of the result.
        """
        return np.asarray(self._hertz(force, curvature).half_width < CONTACT.hertz_reach * self._thinner_radius)

    def _hertz(self, force: npt.ArrayLike, curvature: npt.ArrayLike) -> ideal_loads.HertzContact:
        """Compute Hertz's line contact for forces [N] and relative curvatures [1/m]; conformal is flat."""
        curvature = np.maximum(curvature, np.finfo(float).tiny)
        return ideal_loads.hertz_line_contact(
            force, self._reducer.design.line_length(self.kind), curvature, self.modulus
        )

    def _kept(self, key: object, compute: Callable[[], Value]) -> Value:
        return self._reducer.kept((key, self.kind), compute)

    @property
    def _is_through_pin(self) -> bool:
        """True if disc and housing are in contact through a massless pin."""
        design = self._reducer.design
        return design.ring.has_massless_pins and self.kind == design.tooth_pair

    @property
    def _has_rollers(self) -> bool:
        return self._reducer.design.gear.bearing == "rolling"

    @property
    def _thinner_radius(self) -> float:
        """Return the radius of the smaller body of the pair [m]: roller, pin, or the bore of a sleeve."""
        design = self._reducer.design
        if self.kind == "cam":
            return self._reducer.contacts.roller_radius if self._has_rollers else design.gear.bore_radius
        return {"output": design.output.pin_radius, "pin_sleeve": design.ring.sleeve_bore_radius}.get(
            self.kind, design.ring.pin_radius
        )

    @property
    def _line_force(self) -> float:
        """Working force of a single line contact [N]; for any cam, that on the most loaded roller."""
        rollers = self._reducer.design.contact.cam_rollers
        return self.force * STRIBECK / rollers if self.kind == "cam" else self.force

    def _ideal_force(self, torque: float) -> float:
        """Compute the largest force [N] of the pair on a disc if the disc's output torque [N m] is shared ideally.

        For a cam it is the mean force over a turn.
        """
        reducer, design = self._reducer, self._reducer.design
        gear, output, torque = design.gear, design.output, reducer.share * torque
        if self.kind == "output":
            return 4.0 * torque / (output.pins * output.pin_circle_radius)
        if self.kind == "cam":
            return torque * _cam_force_per_torque(reducer.tooth_profile, output.pins, output.pin_circle_radius)
        return 4.0 * torque / (design.ring.teeth * gear.eccentricity * design.lobes)

    def _compute_stiffness(self) -> float:
        """Compute the stiffness of a contact of the pair [N/m], which the property `stiffness` caches.

        Raises
        ------
        ContactError
            The working force flattens a pin beyond a line contact.
        """
        design, kind = self._reducer.design, self.kind
        stated_stiffness: float = getattr(design.stiffness, kind)
        if stated_stiffness:
            return stated_stiffness
        if impact := self._reducer.contacts.impact:
            return impact.secant(self.force)
        if kind == "cam" and not self._has_rollers:
            face_width, clearance = design.gear.face_width, design.clearance.cam
            return ideal_loads.conformal_stiffness(self.force, face_width, self.modulus, clearance)
        law = self.curvature_law
        if kind == "cam":
            cam_stiffness = self._cam_roller_stiffness() or law.stiffness
            return law.stiffness / (1.0 + law.stiffness / cam_stiffness) * (design.contact.cam_rollers / STRIBECK)
        if kind in ("pin_gear", "tooth"):
            return law.stiffness
        return law.stiffness * law.factor(self.relative_curvature)

    def _cam_roller_stiffness(self) -> float:
        """Compute the stiffness [N/m] of the contact between the most loaded roller and the cam.

        Both have the material of the shaft. It is 0 if ``contact.stiffness`` sets the stiffness of all contacts.
        """
        design = self._reducer.design
        if design.contact.stiffness:
            return 0.0
        shaft, depth = design.material_of("shaft"), design.ring.pin_radius
        modulus = ideal_loads.contact_modulus(shaft.youngs_modulus, shaft.poisson)
        face_width, force = design.gear.face_width, self._line_force
        return float(ideal_loads.line_contact_stiffness(force, face_width, modulus, depth, 1.0 / depth))

    def _compute_curvature_law(self) -> CurvatureLaw:
        """Compute the stiffness of a line contact of the pair as a function of its curvature, for `curvature_law`.

        Raises
        ------
        ContactError
            The working force flattens a pin beyond a line contact.
        """
        design = self._reducer.design
        if impact := self._reducer.contacts.impact:
            return CurvatureLaw(0.0, 1.0, impact.secant(self.force), 0.0)
        force, depth, length, modulus = self._line_force, design.ring.pin_radius, design.gear.face_width, self.modulus
        constant = ideal_loads.line_contact_constant(force, length, modulus, depth)
        reference = constant - math.log(depth)
        if reference <= 1.0:
            raise ContactError(
                f"{self._force_key} is too large: {force:g} N on one pin of {1e3 * depth:g} mm radius is beyond the "
                "range of the line-contact model. Reduce it, or increase gear.face_width_mm or the elastic modulus "
                "of the material"
            )
        tooth_stiffness = getattr(design.stiffness, self.kind) if self.kind == design.tooth_pair else 0.0
        stated_stiffness = tooth_stiffness or design.contact.stiffness
        stiffness = stated_stiffness or float(
            ideal_loads.line_contact_stiffness(force, length, modulus, depth, 1.0 / depth)
        )
        is_local = design.contact.stiffness_law == "local"
        return CurvatureLaw(reference if is_local else 0.0, constant, stiffness, force / stiffness)

    @property
    def _force_key(self) -> str:
        """Return the keys of the design file that determine the working force, as a phrase for messages."""
        if self.source == "given":
            stated_force = getattr(self._reducer.design.working_force, self.kind)
            return f"working_force.{self.kind}_n" if stated_force else "contact.working_force_n"
        load_text = f"{self._reducer.contacts.working_load:.4g} N m"
        if self.source == "working load":
            return f"the load of {load_text} (--load-nm, or contact.working_load_nm of the design)"
        return f"load.torque_nm (a working load of {load_text})"


class Contacts:
    """The contacts of a reducer by kind of pair, ``contacts["cam"]``, and their common properties."""

    __slots__ = ("_reducer",)

    def __init__(self, reducer: "Reducer") -> None:
        self._reducer = reducer

    def __getitem__(self, kind: str) -> Contact:
        return Contact(self._reducer, kind)

    @property
    def teeth(self) -> Contact:
        """Contact of the teeth: pin and disc, or disc and internal gear."""
        return self[self._reducer.design.tooth_pair]

    @property
    def working_load(self) -> float:
        """Return the output torque [N m] whose ideal sharing among the contacts determines the working forces.

        It is ``contact.working_load`` if the design sets it. Otherwise it is the larger one of the load and `own_load`,
        the torque that corresponds to weight and inertia of the discs. A preloaded ring, whose contacts are loaded at
        any torque, has at least the nominal torque.
        """
        design = self._reducer.design
        preload_torque = design.rated_torque if design.ring.preload else 0.0
        return design.contact.working_load or max(abs(design.load.torque), self.own_load, preload_torque)

    @property
    def own_load(self) -> float:
        """Return the output torque [N m] that causes contact forces as large as those of the discs' weight and inertia.

        A disc of mass m presses on its cam by weight and inertia force W = m (g + c w^2), with the gravity g, the crank
        speed w and the eccentricity c. A load torque T on N ring teeth presses the disc on its cam by T/(c (N-1)). So W
        corresponds to a torque of W c (N-1) for each disc, or W c N if the ring is the output. The mass is that of a
        round disc, whose radius is the radius of the pin circle minus that of a pin.
        """
        design = self._reducer.design
        gear, ring, output = design.gear, design.ring, design.output
        squared_radii = (ring.pin_circle_radius - ring.pin_radius) ** 2 - gear.bore_radius**2
        area = math.pi * (squared_radii - output.pins * output.hole_radius**2)
        return self._weight_torque(area) * design.reduction

    def _weight_torque(self, area: float) -> float:
        """Compute the weight and inertia force of all discs times the eccentricity [N m].

        `area` is the section of a disc [m2].
        """
        design = self._reducer.design
        gear = design.gear
        gravity = math.hypot(design.environment.gravity_x, design.environment.gravity_y)
        centripetal = gear.eccentricity * self._reducer.orbit_speed**2
        force = design.material_of("gear").density * gear.face_width * area * (gravity + centripetal)
        return gear.discs * force * gear.eccentricity

    @property
    def creep_speed(self) -> float:
        """Return the sliding speed [m/s] at which friction under the working force reaches Coulomb's limit.

        Below it, friction is proportional to the speed (regularised Coulomb friction). If the design file does not set
        this speed, it is `CONTACT.creep_share` times the orbital speed of the disc's centre or, if the crank is at
        rest, `CONTACT.slow_creep`.
        """
        design = self._reducer.design
        return (
            design.contact.creep_speed
            or CONTACT.creep_share * design.gear.eccentricity * abs(self._reducer.orbit_speed)
            or CONTACT.slow_creep
        )

    @property
    def impact(self) -> ImpactLaw | None:
        """Return the parameters of the Adams contact law IMPACT for the full width of a disc; None with another law.

        `ImpactLaw` is in SI units. In a design file, the stiffness is in N/mm^e, with the exponent e of the law: its
        value is the force [N] at a depth of 1 mm.
        """
        contact = self._reducer.design.contact
        if contact.law != "impact":
            return None
        stiffness = contact.impact_stiffness / MILLIMETRE**contact.impact_exponent
        return ImpactLaw(stiffness, contact.impact_exponent, contact.impact_damping, contact.impact_depth)

    @property
    def mesh_stiffness(self) -> float:
        """Stiffness between disc and housing [N/m]: a pin on a flat in series with its seat.

        A pin transmits its force through two contacts, whose clearances and compliances add up.
        """
        kinds = [kind for kind in (self._reducer.design.tooth_pair, self._reducer.design.seat_pair) if kind]
        return 1.0 / sum(1.0 / self[kind].stiffness for kind in kinds)

    @property
    def pin_flexibility(self) -> Array:
        """Flexibility of an output pin at the planes of the discs [m/N], shape (D, D); see `bending`."""
        return pin_flexibility(self._reducer)

    @property
    def roller_radius(self) -> float:
        """Radius of the cam's rollers [m], which fill its circumference."""
        design = self._reducer.design
        return design.gear.bore_radius * math.sin(math.pi / design.contact.cam_rollers)

    def working_forces_text(self, kinds: Iterable[str]) -> str:
        """Describe the working forces of kinds of pairs and the source of each."""
        forces = [f"{kind} {self[kind].force:.3g} N ({self._describe_source(self[kind].source)})" for kind in kinds]
        return ", ".join(forces)

    def _describe_source(self, source: Source) -> str:
        """Describe in words from which load working forces are computed, with its torque.

        `source` is the load (`Contact.source`).
        """
        return {
            "given": "given",
            "working load": f"ideal sharing of {self.working_load:.4g} N m",
            "load": f"ideal sharing of the load, {self.working_load:.4g} N m",
            "preload": f"ideal sharing of the nominal torque, {self.working_load:.4g} N m, as the ring is preloaded",
            "weight and inertia": "weight and inertia of the disc, because there is no larger load",
        }[source]


def tooth_stiffness(reducer: "Reducer", curvature: Array) -> Array:
    """Compute the stiffness of contact lines with the ring [N/m], including sockets or sleeves in series.

    `curvature` is the relative curvature of each line [1/m], of any shape; the result has the same shape. If the ring
    has two halves, each line is half as long and has half of the stiffness.
    """
    law = reducer.contacts.teeth.curvature_law
    stiffness = law.stiffness * law.factors(curvature)
    kind = reducer.design.seat_pair
    series_stiffness = 1.0 / (1.0 / stiffness + 1.0 / reducer.contacts[kind].stiffness) if kind else stiffness
    return np.asarray(series_stiffness / reducer.design.ring.halves)


@lru_cache(maxsize=64)
def _cam_force_per_torque(gear: CycloidGear, pin_count: int, pin_circle_radius: float) -> float:
    """Compute the magnitude of the cam's force on a disc per output torque of the disc [1/m], the mean over a turn.

    Load sharing is ideal. `gear` is the profile of the disc, `pin_count` and `pin_circle_radius` [m] are the number of
    output pins and the radius of their circle.
    """
    crank_angles = np.linspace(0.0, 2.0 * np.pi, CONTACT.cam_force_angles, endpoint=False)
    ring_loads = ideal_loads.ideal_load_sharing(gear, 1.0, crank_angles)
    pin_forces = ideal_loads.ideal_output_forces(gear, pin_count, pin_circle_radius, 1.0, crank_angles)
    return float(np.mean(np.linalg.norm(ideal_loads.cam_force(ring_loads, pin_forces, crank_angles), axis=1)))
