"""Massless pins: moving pins whose inertia is left out, each part of one contact between gear and housing.

A pin weighs a gram and lies between two contacts: what it does by itself, swaying and spinning in its seat, sets the
time step and carries next to nothing of what a loaded reducer transmits. Without inertia it is a two-force body: it
gives way by its play, its two compliances add up, and the easier of its two contacts slides. At the paper's rated load
means, forces and efficiency are those of real pins to 0.2 %; the gear's speed sways up to a fifth less.
"""

from cycloid_mj.base.errors import DesignError
from cycloid_mj.reducer import Reducer

WITHOUT = {"free": "massless", "sleeved": "massless_sleeved"}
"""``ring.pins`` of pins that move -> the same without their inertia."""

ASSUMPTION = (
    "pins (or their sleeves) are massless: each is one contact of disc and housing with both clearances and both "
    "compliances; the losses at disc, pin and seat are all listed under pin_gear"
)


def massless(reducer: Reducer) -> Reducer:
    """Return a design for loaded means: without the inertia of pins that move, else itself."""
    if not reducer.design.ring.has_pin_bodies:
        return reducer
    return reducer.but(ring={"pins": WITHOUT[reducer.design.ring.pins]})


def assumptions(reducer: Reducer, what: str) -> tuple[str, ...]:
    """Tell what of a measure stands on massless pins where the design's own pins move; nothing where none does."""
    return (f"{what}: {ASSUMPTION}",) if reducer.design.ring.has_pin_bodies else ()


def require_pin_bodies(reducer: Reducer, what: str) -> None:
    """Refuse massless pins for what they cannot tell.

    Raises
    ------
    DesignError
        The design has massless pins.
    """
    design = reducer.design
    if design.ring.has_massless_pins:
        others = {ours: real for real, ours in WITHOUT.items()}
        raise DesignError(
            f'{design.name}: ring.pins = "{design.ring.pins}" is valid for mean values under load only and does not '
            f'support {what}: set ring.pins = "{others[design.ring.pins]}"'
        )


def idle(reducer: Reducer) -> tuple[str, ...]:
    """Tell where a run with massless pins has too small a load to press them into their seats; nothing where not."""
    design = reducer.design
    least = reducer.contacts.own_load
    if not design.ring.has_massless_pins or abs(design.load.torque) > least:
        return ()
    return (
        f"load.torque_nm = {design.load.torque:g} is too small for massless pins, which are valid under load only: "
        f"weight and inertia of the disc outweigh it; raise it above {least:.3g}, or set ring.pins to free or sleeved",
    )
