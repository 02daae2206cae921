"""The contact law of each kind of mating pair of a design, from its stiffness and the masses that move on it."""

from collections.abc import Mapping

from cycloid_mj import names
from cycloid_mj.contact.law import ContactLaw, contact_law, damping_ratio, pair_stiffness, series_stiffness
from cycloid_mj.contact.working import working_force
from cycloid_mj.design import Design
from cycloid_mj.solid import MassProperties


def contact_laws(design: Design, masses: Mapping[str, MassProperties]) -> dict[str, ContactLaw]:
    """Give the contact law of each kind of pair: line-contact stiffness, damping by the pair's own effective mass.

    With massless pins the pair of gear and pin is one of gear and housing: both contacts in series, rubbing as easily
    as the easier of the two.
    """
    laws = {}
    for kind, mass in effective_masses(design, masses).items():
        through = kind == "pin_gear" and design.ring.has_massless_pins
        friction = design.mesh_friction if through else design.friction_of(kind)
        laws[kind] = contact_law(
            stiffness=series_stiffness(design) if through else pair_stiffness(design, kind),
            damping_ratio=damping_ratio(design, kind),
            effective_mass=mass,
            friction=friction,
            creep=friction * working_force(design, kind) / design.contact.creep_speed,
            timestep=design.settings.timestep,
        )
    return laws


def effective_masses(design: Design, masses: Mapping[str, MassProperties]) -> dict[str, float]:
    """Give the mass [kg] that moves on a contact of each kind of pair.

    Half of the ring's and of the output's contacts carry at a time; a free pin, or a sleeve, lies between two.
    """
    gear = 1.0 / masses[names.GEAR].mass
    output = design.output.pin_circle_radius**2 / masses[names.OUTPUT].inertia[2, 2]
    mobility = {"cam": gear, "output": (gear + output) * design.output.pins / 2.0}
    if design.ring.has_pin_bodies:
        pin = 1.0 / masses[names.PIN].mass
        mobility |= {"pin_gear": 2.0 * (gear + pin)}
        mobility |= {"pin_socket" if design.ring.has_sockets else "pin_sleeve": 2.0 * pin}
    else:
        mobility[design.tooth_pair] = gear * design.ring.teeth / 2.0
    return {kind: float(1.0 / mobile) for kind, mobile in mobility.items()}
