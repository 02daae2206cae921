"""How several discs are told from each other in pictures: each is lighter than the one before."""

from cycloid_mj.base import names

LIGHTER = 0.25
"""Share of the way to white from one disc to the next."""

Colour = tuple[float, float, float, float]
"""Red, green, blue and opacity from 0 to 1."""


def tinted(colour: Colour, part: str) -> Colour:
    """Return the colour of a part by its name, from that of all its like."""
    if names.family(part) != names.GEAR:
        return colour
    red, green, blue, opacity = colour
    share = LIGHTER * (names.number_of(part) - 1)
    return red + share * (1.0 - red), green + share * (1.0 - green), blue + share * (1.0 - blue), opacity
