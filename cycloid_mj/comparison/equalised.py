"""An internal gear with a pin design's total play and series stiffness: what is left to differ is the design itself.

A pin is a two-force body between gear and seat: play and compliance of its two contacts add up. At equal play and
series stiffness, free pins, fixed pins and an internal gear lose the same at equal friction.
"""

from cycloid_mj.contact.law import series_stiffness
from cycloid_mj.design import Design, override


def total_play(design: Design) -> float:
    """Give the clearance between the gear and the housing along a contact's normal [m]."""
    play = getattr(design.clearance, design.tooth_pair)
    return float(play + design.pin_play)


def with_play_of(nonpin: Design, pin: Design) -> Design:
    """Give an internal gear's design with the total play and the series stiffness of a pin design.

    The stiffness is the pin design's at its own load, and is kept under every other: one and the same design.
    """
    changes = [
        f'name="{nonpin.name}-like-{pin.name}"',
        f"clearance.tooth_um={1e6 * total_play(pin)!r}",
        f"stiffness.tooth_n_m={series_stiffness(pin)!r}",
    ]
    return override(nonpin, changes)
