"""The law of one contact, stiffness and damping, and its translation to MuJoCo's constraint parameters.

MuJoCo's normal force obeys ``R f + a + b v + k r = 0`` with relative acceleration a, velocity v and gap r. So k/R is
the stiffness K [N/m], b/R the damping C [N s/m], and 1/R an added mass [kg] that acts on the relative motion only.
K and C come from physics; the added mass is as small as the time step allows.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array, significant
from cycloid_mj.base.errors import ContactError
from cycloid_mj.geometry import ideal_loads
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.impact import impact_of
from cycloid_mj.statics.pressure import pair_modulus
from cycloid_mj.statics.structure import pin_flexibility
from cycloid_mj.statics.working import STRIBECK, working_force, working_load, working_source

COUPLED = 0.05
"""Share of the added mass that acceleration along a sliding contact may take from its normal force, mu^2/impratio.

From 0.25 to 0.0025 every mean figure of fixed and free pins, at 1 N m and at the rated load, agrees within 0.1 %.
"""

IMPRATIO = 10.0
"""``impratio`` of a model whose crank stands still; and the largest where MuJoCo's friction lifts what slides.

There, by stock MuJoCo, friction * creep * speed / impratio adds to the normal force. At 1 the teeth would push each
other apart at every touch: under the rated load the rms of the gear's speed would be 25 % more than at 10.
"""

LEAD, LEAD_OF_PINS = 0.15, 0.05
"""Most lead of friction, see `stock_impratio`; and that of moving pins on their seats, which change their spin."""

CREEP = 2e-3
"""Creep speed as a share of the speed at which the gear's centre circles, c w.

Friction below it is too small. Of six drives of 8 to 70 pins with plays up to 0.25 mm, at 3 % of the rated load and 100
rpm, and at 30 % and 1000 rpm, the efficiency is that of a tenth of it within 0.04 points; at five times it within 0.25.
"""

SLOW_CREEP = 1e-4
"""The same where the crank stands [m/s]."""

LEAST_IMPEDANCE, MOST_IMPEDANCE = 1e-4, 0.9999
"""What MuJoCo clamps a constraint's impedance to."""


@dataclass(frozen=True)
class ContactParameters:
    """The law of one contact.

    Attributes
    ----------
    stiffness, damping
        K [N/m] and C [N s/m] along the normal.
    added_mass
        1/R [kg].
    friction
        Coulomb's coefficient [1].
    creep
        Friction per sliding speed [N s/m] as long as it is below Coulomb's limit.
    effective_mass
        m [kg] of the bodies along the normal, their other contacts counted in; 0 where it is not known.
    """

    stiffness: float
    damping: float
    added_mass: float
    friction: float
    creep: float = 0.0
    effective_mass: float = 0.0

    @property
    def condim(self) -> int:
        """MuJoCo's number of directions that the contact has a force in."""
        return 3 if self.friction > 0.0 else 1


@dataclass(frozen=True)
class CurvatureLaw:
    """How the stiffness of a tooth contact follows the local relative curvature kappa.

    The compliance is in proportion to ``constant + ln kappa`` and has the value ``reference`` for a pin on a flat; a
    ``reference`` of 0 switches the law off. At most the stiffness doubles: a contact that is more conformal than that
    is no line contact any more.

    Attributes
    ----------
    reference, constant
        Dimensionless; see ``ideal_loads.line_contact_constant``.
    stiffness
        Of a pin on a flat [N/m].
    deflection
        Of a pin on a flat under the working force [m]: lines with less of a gap between them are one patch; 0: each
        line is a contact of its own.
    """

    reference: float
    constant: float
    stiffness: float
    deflection: float

    def factor(self, relative_curvature: float) -> float:
        """Compute the stiffness at a relative curvature [1/m] as a share of that of a pin on a flat."""
        return float(self.factors(np.array(relative_curvature)))

    def factors(self, relative_curvature: Array) -> Array:
        """Compute `factor` at many relative curvatures, in their shape."""
        if self.reference == 0.0:
            return np.ones(relative_curvature.shape)
        least = math.exp(0.5 * self.reference - self.constant)
        return np.asarray(self.reference / (self.constant + np.log(np.maximum(relative_curvature, least))))


def damping_ratio(reducer: Reducer, kind: str) -> float:
    """Compute the damping of a kind of pair as a share of critical [1]."""
    return float(getattr(reducer.design.damping, kind)) or reducer.design.contact.damping_ratio


def creep_speed(reducer: Reducer) -> float:
    """Compute the sliding speed at which friction is whole under the working force [m/s].

    The one given, or `CREEP` of the speed c w at which the gear's centre circles; of a crank that stands `SLOW_CREEP`.
    """
    design = reducer.design
    return design.contact.creep_speed or CREEP * design.gear.eccentricity * abs(design.drive.speed) or SLOW_CREEP


def pair_stiffness(reducer: Reducer, kind: str) -> float:
    """Compute the stiffness of a kind of pair [N/m]: the one given, or the secant stiffness at its working force.

    Of teeth it is that of a pin on a flat; in sockets, sleeves and holes it follows the relative curvature. In a
    rolling cam the roller in the middle of the loaded half carries 4.08/Z of the load (Stribeck; Harris, Rolling
    Bearing Analysis) through two contacts in series, each as stiff as a pin on a flat. A plain cam is
    `statics.conformal_stiffness`. Of the law IMPACT it is the secant of its spring, wherever the parts touch.
    """
    design = reducer.design
    value: float = getattr(design.stiffness, kind)
    if value:
        return value
    if impact := impact_of(reducer):
        return impact.secant(working_force(reducer, kind))
    if kind == "cam" and design.gear.bearing == "plain":
        modulus = pair_modulus(reducer, kind)
        force = working_force(reducer, "cam")
        return ideal_loads.conformal_stiffness(force, design.gear.face_width, modulus, design.clearance.cam)
    law, play = curvature_law(reducer, kind), design.clearance
    if kind == "cam":
        on_cam = _roller_on_cam(reducer) or law.stiffness
        return law.stiffness / (1.0 + law.stiffness / on_cam) * (design.contact.cam_rollers / STRIBECK)
    if kind in ("pin_gear", "tooth"):
        return law.stiffness
    inner, outer = {
        "pin_socket": (design.ring.pin_radius, design.ring.pin_radius + play.pin_socket),
        "pin_sleeve": (design.ring.sleeve_bore_radius - play.pin_sleeve, design.ring.sleeve_bore_radius),
        "output": (design.output.pin_radius, design.output.hole_radius + play.output),
    }[kind]
    return law.stiffness * law.factor(1.0 / inner - 1.0 / outer)


def series_stiffness(reducer: Reducer) -> float:
    """Compute the stiffness between gear and housing [N/m]: that of a pin on a flat, and that of its seat, in series.

    A pin is a two-force body: play and compliance of its two contacts add up.
    """
    kinds = [kind for kind in (reducer.design.tooth_pair, reducer.design.seat_pair) if kind]
    return 1.0 / sum(1.0 / pair_stiffness(reducer, kind) for kind in kinds)


def contact_stiffness(reducer: Reducer, kind: str, disc: int = 0) -> float:
    """Compute the stiffness of a kind of pair as the simulation has it [N/m].

    Of a massless pin, its seat is in series; of an output pin, its bending at a `disc` in a structure of springs.
    """
    through = kind == reducer.design.tooth_pair and reducer.design.ring.has_massless_pins
    stiffness = series_stiffness(reducer) if through else pair_stiffness(reducer, kind)
    bent = float(pin_flexibility(reducer)[disc, disc]) if kind == "output" else 0.0
    return 1.0 / (1.0 / stiffness + bent) if bent else stiffness


def stiffest(reducer: Reducer, kind: str) -> float:
    """Compute `contact_stiffness` on the disc where it is largest [N/m]."""
    return max(contact_stiffness(reducer, kind, disc) for disc in range(reducer.design.gear.discs))


def _roller_on_cam(reducer: Reducer) -> float:
    """Find the stiffness of a roller, of the shaft's material, on the cam [N/m]; 0 where it is given for all pairs."""
    design = reducer.design
    if design.contact.stiffness:
        return 0.0
    shaft, depth = design.material_of("shaft"), design.ring.pin_radius
    modulus = ideal_loads.contact_modulus(shaft.youngs_modulus, shaft.poisson)
    force = _line_force(reducer, "cam")
    return float(ideal_loads.line_contact_stiffness(force, design.gear.face_width, modulus, depth, 1.0 / depth))


def curvature_law(reducer: Reducer, kind: str = "") -> CurvatureLaw:
    """Compute the stiffness of a kind of line contacts from material, face width, pin radius and working force.

    By default it is that of the teeth, pin on gear or gear on internal gear; of the cam, that of a roller.

    Raises
    ------
    ContactError
        The working force flattens a pin beyond a line contact.
    """
    design = reducer.design
    kind = kind or design.tooth_pair
    if impact := impact_of(reducer):
        return CurvatureLaw(0.0, 1.0, impact.secant(working_force(reducer, kind)), 0.0)
    force, depth = _line_force(reducer, kind), design.ring.pin_radius
    length = design.gear.face_width
    modulus = pair_modulus(reducer, kind)
    constant = ideal_loads.line_contact_constant(force, length, modulus, depth)
    reference = constant - math.log(depth)
    if reference <= 1.0:
        raise ContactError(
            f"{_blamed(reducer, kind)} flattens a pin of radius {1e3 * depth:g} mm beyond a line contact "
            f"({force:g} N on one); lower it, or use a wider face or a stiffer material"
        )
    of_teeth = getattr(design.stiffness, kind) if kind == design.tooth_pair else 0.0
    stated = of_teeth or design.contact.stiffness
    stiffness = stated or float(ideal_loads.line_contact_stiffness(force, length, modulus, depth, 1.0 / depth))
    local = design.contact.stiffness_law == "local"
    return CurvatureLaw(reference if local else 0.0, constant, stiffness, force / stiffness)


def _line_force(reducer: Reducer, kind: str) -> float:
    """Compute the working force of one line contact [N]; of a rolling cam, on its most loaded roller."""
    force = working_force(reducer, kind)
    return force * STRIBECK / reducer.design.contact.cam_rollers if kind == "cam" else force


def _blamed(reducer: Reducer, kind: str) -> str:
    """Name the value of the design that a working force comes from."""
    source = working_source(reducer, kind)
    if source == "given":
        return f"working_force.{kind}_n" if getattr(reducer.design.working_force, kind) else "contact.working_force_n"
    key = "contact.working_load_nm" if source == "working load" else "load.torque_nm"
    return f"{key} (a working load of {working_load(reducer):.4g} N m)"


@dataclass(frozen=True)
class SolverParameters:
    """The attributes of a ``<pair>`` that make MuJoCo follow a contact law."""

    condim: int
    friction: tuple[float, float, float, float, float]
    solref: tuple[float, float]
    solreffriction: tuple[float, float]
    solimp: tuple[float, float, float, float, float]


def contact_law(
    stiffness: float, damping_ratio: float, effective_mass: float, friction: float, creep: float, timestep: float
) -> ContactParameters:
    """Compute the law of a contact between two bodies of a given effective mass.

    Parameters
    ----------
    stiffness
        K [N/m].
    damping_ratio
        Share of the critical damping 2 sqrt(K m).
    effective_mass
        m [kg]: the bodies' mass along the normal, divided by the number of contacts that share it, so that the body
        on all of them together is damped by this ratio.
    friction
        Coulomb friction coefficient [1].
    creep
        Friction per sliding speed below Coulomb's limit [N s/m].
    timestep
        Time step dt [s].

    The added mass makes MuJoCo's explicit step of the contact that of Fox and Goodwin, with centred damping:
    1/R = beta K dt^2 + C dt/2. With beta = 1/12 the frequency is right to fourth order in dt; from K dt^2/m = 3 on more
    is taken, beta = 1/4 - m/(2 K dt^2), which is stable at any step (Hughes, The Finite Element Method, 9.1).
    """
    damping = 2.0 * damping_ratio * math.sqrt(stiffness * effective_mass)
    squared = stiffness * timestep**2
    beta = max(1.0 / 12.0, 0.25 - 0.5 * effective_mass / squared)
    added = beta * squared + 0.5 * damping * timestep
    return ContactParameters(stiffness, damping, added, friction, creep, effective_mass)


def impratio(reducer: Reducer, laws: Iterable[Mapping[str, ContactParameters]], timestep: float) -> float:
    """Compute the ``impratio`` of a model that MuJoCo's lift is taken off (`lift`), for the laws of a design's discs.

    As the normal force has the added mass 1/R, friction has impratio/R, which acts on the acceleration along the
    contact: below Coulomb's limit it is creep v + impratio/R dv/dt. At creep dt/2 it is centred in the step, as damping
    is; more would let friction lead its sliding. Every kind of pair has that at least, and no more coupling than
    `COUPLED`.
    """
    rubbing = [law for of_disc in laws for law in of_disc.values() if law.friction]
    if not (rubbing and reducer.design.drive.speed):
        return IMPRATIO
    least = [max(law.friction**2 / COUPLED, 0.5 * law.creep * timestep / law.added_mass) for law in rubbing]
    return significant(max(least))


def leads(reducer: Reducer, laws: Mapping[str, ContactParameters], impratio: float) -> dict[str, float]:
    """Compute the tangent of the angle by which friction leads its sliding, on teeth, cam and the seats of moving pins.

    Parts that circle on the eccentricity c at w slide with c w and accelerate by c w^2; on the cam, of radius r, they
    slide with r w. So it is impratio w/(R creep), on the cam c/r of it. Creep is in proportion to the working force:
    under a light load friction would come to point against the sliding.
    """
    design = reducer.design
    gear, speed = design.gear, abs(design.drive.speed)
    shares = {design.tooth_pair: 1.0, "cam": gear.eccentricity / gear.bore_radius}
    if design.ring.has_pin_bodies:
        shares[design.seat_pair] = 1.0
    pairs = {kind: (laws[kind], share) for kind, share in shares.items() if laws[kind].friction}
    return {kind: share * impratio * law.added_mass * speed / law.creep for kind, (law, share) in pairs.items()}


def stock_impratio(reducer: Reducer, laws: Iterable[Mapping[str, ContactParameters]]) -> float:
    """Find the ``impratio`` of a model for stock MuJoCo, which lifts what slides: `IMPRATIO`, or what `LEAD` allows."""
    allowed = [
        (LEAD_OF_PINS if kind == reducer.design.seat_pair else LEAD) / lead
        for of_disc in laws
        for kind, lead in leads(reducer, of_disc, 1.0).items()
        if lead
    ]
    return significant(min([IMPRATIO, *allowed]))


def solver_parameters(law: ContactParameters, inverse_weight: float, impratio: float = IMPRATIO) -> SolverParameters:
    """Translate a contact law for MuJoCo.

    Parameters
    ----------
    law
        What the contact shall do.
    inverse_weight
        Sum of both bodies' translational ``body_invweight0`` [1/kg], MuJoCo's estimate of A in R = (1-d)/d A.
    impratio
        That of the model.

    MuJoCo allows impedances from 0.0001 to 0.9999: an added mass below 0.0001 of the bodies' own is raised to that,
    which `regime` tells where it matters.

    Raises
    ------
    ContactError
        The added mass is larger than MuJoCo's impedance can represent.
    """
    high = MOST_IMPEDANCE
    impedance = max(inverse_weight / (1.0 / law.added_mass + inverse_weight), LEAST_IMPEDANCE)
    if not impedance <= high:
        raise ContactError(
            f"a contact of stiffness {law.stiffness:.3g} N/m needs an added mass of {law.added_mass:.3g} kg at this "
            f"time step, {law.added_mass * inverse_weight:.3g} times that of its bodies; MuJoCo allows "
            f"{high / (1.0 - high):.3g} times: shorten settings.timestep_us or lower the contact's stiffness"
        )
    regularisation = (1.0 - impedance) / impedance * inverse_weight
    scale = regularisation * impedance
    slide = (law.friction, law.friction, 0.0, 0.0, 0.0)
    return SolverParameters(
        condim=law.condim,
        friction=slide,
        solref=(significant(-law.stiffness * scale), significant(-law.damping * scale)),
        solreffriction=(-1.0, significant(-law.creep * scale / impratio)) if law.friction > 0.0 else (0.0, 0.0),
        solimp=(significant(impedance), significant(impedance), 1.0, 0.5, 1.0),
    )
