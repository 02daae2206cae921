"""Massless pins: moving pins without inertia, each part of one contact between disc and housing.

A pin weighs a gram and lies between two contacts. Its own motion in the seat limits the time step but hardly
contributes to the results under load. Without inertia it is a two-force body: it moves by its clearance, its two
compliances add up, and the contact with the lower friction slides. At the rated load mean values, forces and efficiency
agree with those of real pins to 0.2 %; the speed ripple of the disc is up to a fifth smaller.
"""

from cycloid_mj.base.errors import DesignError
from cycloid_mj.reducer import Reducer

MASSLESS = {"free": "massless", "sleeved": "massless_sleeved"}
"""``ring.pins`` of moving pins -> the same without inertia."""

ASSUMPTION = (
    "pins (or their sleeves) are massless: each is one contact of disc and housing with both clearances and both "
    "compliances; the losses at disc, pin and seat are all listed under pin_gear"
)


def massless(reducer: Reducer) -> Reducer:
    """Return a design with massless pins if its pins move, else the design itself."""
    if not reducer.design.ring.has_pin_bodies:
        return reducer
    return reducer.but(ring={"pins": MASSLESS[reducer.design.ring.pins]})


def assumptions(reducer: Reducer, what: str) -> tuple[str, ...]:
    """Return the assumption of massless pins that a measure (`what`) makes if the design's own pins move."""
    return (f"{what}: {ASSUMPTION}",) if reducer.design.ring.has_pin_bodies else ()


def require_pin_bodies(reducer: Reducer, unsupported: str) -> None:
    """Raise an error if a design has massless pins, for which `unsupported` results ("vibration") are invalid.

    Raises
    ------
    DesignError
        The design has massless pins.
    """
    design = reducer.design
    if design.ring.has_massless_pins:
        moving_pins = {massless_kind: real_kind for real_kind, massless_kind in MASSLESS.items()}[design.ring.pins]
        raise DesignError(
            f'{design.name}: ring.pins = "{design.ring.pins}" neglects the inertia of the pins, so it is valid only '
            f'for averages over a crank turn under load, not for {unsupported}. Set ring.pins = "{moving_pins}"'
        )


def idle_warning(reducer: Reducer) -> tuple[str, ...]:
    """Return a warning if the load is too small to press massless pins into their seats, else an empty tuple.

    The limit is the output torque that presses as hard as weight and inertia of the discs (`Contacts.own_load`).
    """
    design = reducer.design
    min_load = reducer.contacts.own_load
    if not design.ring.has_massless_pins or abs(design.load.torque) > min_load:
        return ()
    return (
        f"load.torque_nm = {design.load.torque:g} is too small for massless pins, which are valid under load only: "
        f"weight and inertia of the disc outweigh it; raise it above {min_load:.3g}, or set ring.pins to free or "
        "sleeved",
    )
