"""Massless pins: moving pins whose inertia is left out, each part of one contact between gear and housing.

A pin weighs a gram and lies between two contacts: what it does by itself, swaying and spinning in its seat, sets the
time step and carries next to nothing of what a loaded reducer transmits. Without inertia it is a two-force body: it
gives way by its play, its two compliances add up, and the easier of its two contacts slides. At the paper's rated load
means, forces and efficiency are those of real pins to 0.2 %; the gear's speed sways up to a fifth less.
"""

from cycloid_mj.contact.working import own_load
from cycloid_mj.design import Design
from cycloid_mj.errors import DesignError

WITHOUT = {"free": "massless", "sleeved": "massless_sleeved"}
"""``ring.pins`` of pins that move -> the same without their inertia."""

ASSUMPTION = (
    "pins (or their sleeves) without inertia: one contact of gear and housing through each, with both plays and both "
    "compliances; what gear, pin and seat lose stands under pin_gear"
)


def massless(design: Design) -> Design:
    """Give a design for loaded means: without the inertia of pins that move, else itself."""
    if not design.ring.has_pin_bodies:
        return design
    return design.but(ring={"pins": WITHOUT[design.ring.pins]})


def assumptions(design: Design, what: str) -> tuple[str, ...]:
    """Tell what of a measure stands on massless pins where the design's own pins move; nothing where none does."""
    return (f"{what}: {ASSUMPTION}",) if design.ring.has_pin_bodies else ()


def require_pin_bodies(design: Design, what: str) -> None:
    """Refuse massless pins for what they cannot tell.

    Raises
    ------
    DesignError
        The design has massless pins.
    """
    if design.ring.has_massless_pins:
        others = {ours: real for real, ours in WITHOUT.items()}
        raise DesignError(
            f'{design.name}: ring.pins = "{design.ring.pins}" tells loaded means alone, not {what}: '
            f'set ring.pins = "{others[design.ring.pins]}"'
        )


def idle(design: Design) -> tuple[str, ...]:
    """Tell where a run with massless pins has too small a load to press them into their seats; nothing where not."""
    if not design.ring.has_massless_pins or abs(design.load.torque) > own_load(design):
        return ()
    return (
        f"load.torque_nm = {design.load.torque:g} is less than the gear's own weight and inertia ask for, but massless "
        f"pins hold under load alone: raise it to more than {own_load(design):.3g}, or set ring.pins to free, sleeved",
    )
