"""The contact law of each kind of mating pair of a design, from its stiffness and the masses that move on it."""

from cycloid_mj.contact.law import ContactLaw, contact_law, contact_stiffness, damping_ratio
from cycloid_mj.contact.timestep import effective_masses, timestep
from cycloid_mj.contact.working import working_force
from cycloid_mj.design import Design


def contact_laws(design: Design) -> dict[str, ContactLaw]:
    """Give the contact law of each kind of pair: line-contact stiffness, damping by the pair's own effective mass.

    With massless pins the pair of gear and pin is one of gear and housing: both contacts in series, rubbing as easily
    as the easier of the two.
    """
    laws = {}
    for kind, mass in effective_masses(design).items():
        through = kind == design.tooth_pair and design.ring.has_massless_pins
        friction = design.mesh_friction if through else design.friction_of(kind)
        laws[kind] = contact_law(
            stiffness=contact_stiffness(design, kind),
            damping_ratio=damping_ratio(design, kind),
            effective_mass=mass,
            friction=friction,
            creep=friction * working_force(design, kind) / design.contact.creep_speed,
            timestep=timestep(design),
        )
    return laws
