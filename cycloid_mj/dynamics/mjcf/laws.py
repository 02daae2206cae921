"""The contact law of each kind of mating pair of a design, from its stiffness and the masses that move on it."""

from collections.abc import Sequence

from cycloid_mj.dynamics.law import ContactParameters, contact_law, settling_law
from cycloid_mj.dynamics.timestep import SETTINGS, effective_masses, may_settle, timestep
from cycloid_mj.reducer import Reducer

Laws = dict[str, ContactParameters]
"""Kind of pair -> its law."""


def laws_of_discs(reducer: Reducer) -> tuple[Laws, ...]:
    """List `contact_laws` of every disc."""
    return tuple(contact_laws(reducer, disc) for disc in range(reducer.design.gear.discs))


def stiffest(laws: Sequence[Laws]) -> Laws:
    """Compute the law of each kind on the disc where it is stiffest; elsewhere an output pin may bend more."""
    return {kind: max((law[kind] for law in laws), key=lambda law: law.stiffness) for kind in laws[0]}


def contact_laws(reducer: Reducer, disc: int = 0) -> Laws:
    """Compute the contact law of each kind of pair: line-contact stiffness, damping by the pair's own effective mass.

    With massless pins the pair of gear and pin is one of gear and housing: both contacts in series, rubbing as easily
    as the easier of the two. The bending of an output pin at its disc's plane is in series with its contact; what a
    disc's force bends it by at another disc's plane is left out (docs/decisions/11-bent-output-pins.md). Of the law
    IMPACT these are secants at the working force, which a run replaces at every step (`contact.each_step`). Contacts of
    moving pins that may settle, and which the step does not follow, do.
    """
    design, time = reducer.design, timestep(reducer)
    laws = {}
    for kind, mass in effective_masses(reducer).items():
        lines = design.lines(kind)  # each carries its share of force and mass
        through = kind == design.tooth_pair and design.ring.has_massless_pins
        friction = design.mesh_friction if through else design.friction_of(kind)
        contact, mass = reducer.contacts[kind], mass / lines
        force, impact = contact.force / lines, contact.impact
        stiffness = contact.series[disc] / lines
        followed = not may_settle(reducer, kind) or stiffness * time**2 <= SETTINGS.max_idle_seat_ratio * mass
        laws[kind] = (contact_law if followed else settling_law)(
            stiffness=stiffness,
            damping_ratio=impact.damping_ratio(force, mass) if impact else contact.damping_ratio,
            effective_mass=mass,
            friction=friction,
            creep=friction * force / reducer.contacts.creep_speed,
            timestep=time,
        )
    return laws
