"""Contact law, and its translation to MuJoCo's constraint parameters.

MuJoCo's normal force obeys ``R f + a + b v + k r = 0`` with relative acceleration a, velocity v and gap r. So k/R is
the stiffness K [N/m], b/R the damping C [N s/m], and 1/R an added mass [kg] that acts on the relative motion only.
K and C are physical; the added mass is as small as the time step allows.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from cycloid_mj.base import names
from cycloid_mj.base.array import significant
from cycloid_mj.base.errors import ContactError
from cycloid_mj.reducer import Reducer, RvReducer


@dataclass(frozen=True)
class FrictionSettings:
    """Settings of friction in MuJoCo's elliptic cone, all dimensionless."""

    max_coupling: float = 0.05
    """Largest share of the added mass by which tangential acceleration couples into the normal force, mu^2/impratio:
    from 0.25 to 0.0025 all mean values agree within 0.1 %."""
    impratio: float = 10.0
    """``impratio`` with the crank at rest, and the largest one for stock MuJoCo, which lifts sliding contacts: it adds
    friction * creep * speed / impratio to the normal force."""
    max_lead: float = 0.15
    """Largest lead of friction, see `stock_impratio`."""
    max_pin_lead: float = 0.05
    """That of moving pins on their seats, which reverse their spin."""


FRICTION = FrictionSettings()


MIN_IMPEDANCE, MAX_IMPEDANCE = 1e-4, 0.9999
"""Range to which MuJoCo limits the impedance of a constraint."""


@dataclass(frozen=True)
class ContactParameters:
    """Law of one contact.

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
        """MuJoCo's number of force directions of the contact."""
        return 3 if self.friction > 0.0 else 1


@dataclass(frozen=True)
class SolverParameters:
    """Attributes of a ``<pair>`` with which MuJoCo follows a contact law."""

    condim: int
    friction: tuple[float, float, float, float, float]
    solref: tuple[float, float]
    solreffriction: tuple[float, float]
    solimp: tuple[float, float, float, float, float]


def contact_law(
    stiffness: float, damping_ratio: float, effective_mass: float, friction: float, creep: float, timestep: float
) -> ContactParameters:
    """Compute the parameters of the law of a contact: a spring, a damper and friction between two bodies.

    Parameters
    ----------
    stiffness
        K [N/m].
    damping_ratio
        Fraction of the critical damping 2 sqrt(K m) [1].
    effective_mass
        m [kg]: the bodies' mass along the normal, divided by the number of contacts that share it, so that the body on
        all of them together is damped by this ratio.
    friction
        Coulomb friction coefficient [1].
    creep
        Friction per sliding speed below Coulomb's limit [N s/m].
    timestep
        Time step dt [s].

    Returns
    -------
    ContactParameters
        Stiffness, damping C [N s/m], added mass 1/R [kg], friction, creep and effective mass.

    Notes
    -----
    The added mass makes MuJoCo's explicit step of the contact that of Fox and Goodwin, with centred damping: 1/R = beta
    K dt^2 + C dt/2. With beta = 1/12 the frequency is right to fourth order in dt; from K dt^2/m = 3 on the added mass
    is larger, beta = 1/4 - m/(2 K dt^2), which is stable at any step (Hughes, The Finite Element Method, 9.1).
    """
    damping = 2.0 * damping_ratio * math.sqrt(stiffness * effective_mass)
    step_stiffness = stiffness * timestep**2
    beta = max(1.0 / 12.0, 0.25 - 0.5 * effective_mass / step_stiffness)
    added_mass = beta * step_stiffness + 0.5 * damping * timestep
    return ContactParameters(stiffness, damping, added_mass, friction, creep, effective_mass)


def settling_law(
    stiffness: float, damping_ratio: float, effective_mass: float, friction: float, creep: float, timestep: float
) -> ContactParameters:
    """Compute the parameters of the law of a contact for a time step that is too long to follow its oscillation.

    Parameters are those of `contact_law`: stiffness K [N/m], damping ratio [1], effective mass [kg], friction
    coefficient [1], creep [N s/m] and time step `timestep` dt [s]. The contact settles within a step. With such a step,
    the method of Fox and Goodwin would oscillate and lift light parts off their seats. This law is implicit Euler
    instead (Hairer and Wanner, Solving Ordinary Differential Equations II, IV.3). The force f at the end of the step
    follows from the gap r, speed v and acceleration a: f = -K (r + dt v + dt^2 a) - C (v + dt a). In MuJoCo's terms,
    the added mass 1/R is K dt^2 + C dt, the damping is C + K dt, and the stiffness stays K.
    """
    law = contact_law(stiffness, damping_ratio, effective_mass, friction, creep, timestep)
    damping = law.damping + stiffness * timestep
    return replace(law, damping=damping, added_mass=damping * timestep)


def impratio(reducer: Reducer, laws: Iterable[Mapping[str, ContactParameters]], timestep: float) -> float:
    """Compute MuJoCo's option ``impratio``, the ratio of frictional to normal impedance [1], for a model of a reducer.

    The reference accelerations of the model are corrected (`reference_correction`); without that, see `stock_impratio`.
    `laws` are the contact laws of each disc by kind of pair, `timestep` dt is in [s]. Below the Coulomb limit, friction
    is creep v + impratio/R dv/dt, with the sliding speed v and the added mass 1/R of the normal force. The result is
    the smallest value that meets two conditions for every kind of pair with friction. First, impratio/R is at least
    creep dt/2: with this value, friction is centred in the time step, like the damping; with a larger value, it is
    ahead of the sliding speed. Second, mu^2/impratio is at most `FRICTION.max_coupling`, with the friction coefficient
    mu. Without friction, or with the crank at rest, the result is `FRICTION.impratio`.
    """
    sliding_laws = [law for disc_laws in laws for law in disc_laws.values() if law.friction]
    if not (sliding_laws and reducer.design.drive.speed):
        return FRICTION.impratio
    min_ratios = [
        max(law.friction**2 / FRICTION.max_coupling, 0.5 * law.creep * timestep / law.added_mass)
        for law in sliding_laws
    ]
    return significant(max(min_ratios))


def friction_leads(reducer: Reducer, laws: Mapping[str, ContactParameters], impratio: float) -> dict[str, float]:
    """Compute the tangent [1] of the angle by which MuJoCo's friction leads the sliding velocity, by kind of pair.

    On an orbiting disc, MuJoCo's friction follows the sliding velocity plus a term of its acceleration, which is
    perpendicular to it. `laws` are the contact laws by kind of pair, `impratio` [1] is MuJoCo's ratio of impedances.
    The kinds in the result are teeth, such as ``pin_gear``, cams (crank bearings of an RV reducer) and seats of moving
    pins; kinds without friction are omitted. Discs orbit at the eccentricity c with the angular speed w: teeth and
    seats slide at c w and accelerate by c w^2, a cam of radius r slides at r w. The tangent is impratio w m/creep; on
    the cam, it is multiplied by c/r. The creep of the law is the friction per sliding speed below Coulomb's limit
    [N s/m]; its added mass m [kg] acts on the relative motion only (MuJoCo's 1/R, see the module).
    """
    design = reducer.design
    gear, speed = design.gear, abs(reducer.orbit_speed)
    if isinstance(reducer, RvReducer):
        path_ratios = {design.tooth_pair: 1.0, names.CRANK_BEARING: gear.eccentricity / reducer.cranks.eccentric_radius}
    else:
        path_ratios = {design.tooth_pair: 1.0, "cam": gear.eccentricity / gear.bore_radius}
    if design.ring.has_pin_bodies:
        path_ratios[design.seat_pair] = 1.0
    pairs = {kind: (laws[kind], ratio) for kind, ratio in path_ratios.items() if kind in laws and laws[kind].friction}
    return {kind: ratio * impratio * law.added_mass * speed / law.creep for kind, (law, ratio) in pairs.items()}


def stock_impratio(reducer: Reducer, laws: Iterable[Mapping[str, ContactParameters]]) -> float:
    """Compute MuJoCo's option ``impratio`` [1], ratio of frictional to normal impedance, for runs without this package.

    There the convex friction cone lifts sliding contacts, which a large ratio reduces. `laws` are the contact laws of
    each disc by kind of pair. The result is the largest value up to `FRICTION.impratio` with which the angle by which
    friction is ahead of the sliding velocity (`friction_leads`) has at most the tangent `FRICTION.max_lead`, or
    `FRICTION.max_pin_lead` at seats.
    """
    max_ratios = [
        (FRICTION.max_pin_lead if kind == reducer.design.seat_pair else FRICTION.max_lead) / lead
        for disc_laws in laws
        for kind, lead in friction_leads(reducer, disc_laws, 1.0).items()
        if lead
    ]
    return significant(min([FRICTION.impratio, *max_ratios]))


def solver_parameters(
    law: ContactParameters, inverse_weight: float, impratio: float = FRICTION.impratio, contact: str = ""
) -> SolverParameters:
    """Translate a contact law to the attributes of a MuJoCo contact pair.

    Parameters
    ----------
    law
        The contact law.
    inverse_weight
        Sum of both bodies' translational ``body_invweight0`` [1/kg], MuJoCo's estimate of A in R = (1-d)/d A, with the
        impedance d.
    impratio
        Ratio of frictional to normal impedance of the model [1].
    contact
        Name of the contact, for an error message.

    Returns
    -------
    SolverParameters
        The attributes condim, friction, solref, solreffriction and solimp.

    Raises
    ------
    ContactError
        The added mass is larger than MuJoCo's impedance can represent.

    Notes
    -----
    MuJoCo allows impedances from 0.0001 to 0.9999. An added mass below 0.0001 of that of the bodies is raised to it;
    `regime` warns if this matters.
    """
    impedance = max(inverse_weight / (1.0 / law.added_mass + inverse_weight), MIN_IMPEDANCE)
    if not impedance <= MAX_IMPEDANCE:
        raise ContactError(
            f"{contact or 'a contact'} is too stiff ({law.stiffness:.3g} N/m) for this time step: it needs an added "
            f"mass (MuJoCo's regularisation) of {law.added_mass * inverse_weight:.3g} times the mass of its bodies, "
            f"but at most {MAX_IMPEDANCE / (1.0 - MAX_IMPEDANCE):.3g} times is possible. Reduce settings.timestep_us, "
            "or reduce gear.face_width_mm to make contacts less stiff"
        )
    regularisation = (1.0 - impedance) / impedance * inverse_weight
    scale = regularisation * impedance
    coefficients = (law.friction, law.friction, 0.0, 0.0, 0.0)
    return SolverParameters(
        condim=law.condim,
        friction=coefficients,
        solref=(significant(-law.stiffness * scale), significant(-law.damping * scale)),
        solreffriction=(-1.0, significant(-law.creep * scale / impratio)) if law.friction > 0.0 else (0.0, 0.0),
        solimp=(significant(impedance), significant(impedance), 1.0, 0.5, 1.0),
    )
