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
    """Compute the contact law of each kind of pair on a `disc`, for one line of contact at the working force.

    A law consists of stiffness, damping, added mass and friction (`ContactParameters`). `disc` is the index of the
    disc. With massless pins the pair of gear and pin has the stiffness of both contacts of a pin in series, and the
    smaller friction. The bending of an output pin at its disc's plane is in series with its contact; its bending at
    another disc's plane is neglected (docs/decisions.md). Laws of the kind IMPACT have the secant stiffness and damping
    at the working force, which a run replaces at every step (`contact.each_step`). If the time step is too long for the
    oscillation of moving pins, their contacts have `law.settling_law`, where `may_settle` allows it.
    """
    design, step = reducer.design, timestep(reducer)
    laws = {}
    for kind, mass in effective_masses(reducer).items():
        contact_lines = design.lines(kind)  # each carries its share of force and mass
        is_massless = kind == design.tooth_pair and design.ring.has_massless_pins
        friction = design.mesh_friction if is_massless else design.friction_of(kind)
        contact, mass = reducer.contacts[kind], mass / contact_lines
        force, impact = contact.force / contact_lines, contact.impact
        stiffness = contact.stiffness_by_disc[disc] / contact_lines
        is_followed = not may_settle(reducer, kind) or stiffness * step**2 <= SETTINGS.max_idle_seat_ratio * mass
        laws[kind] = (contact_law if is_followed else settling_law)(
            stiffness=stiffness,
            damping_ratio=impact.damping_ratio(force, mass) if impact else contact.damping_ratio,
            effective_mass=mass,
            friction=friction,
            creep=friction * force / reducer.contacts.creep_speed,
            timestep=step,
        )
    return laws
