"""All parts of a reducer by name."""

from collections.abc import Mapping
from functools import lru_cache

from cycloid_mj import names
from cycloid_mj.design import Design
from cycloid_mj.solid.gear import gear_solid
from cycloid_mj.solid.housing import housing_solid, pin_solid
from cycloid_mj.solid.output import output_solid
from cycloid_mj.solid.prism import Prism, Solid
from cycloid_mj.solid.shaft import crank_parts, stretches

SHAPING_NOTHING = (
    *("name", "errors", "friction", "drag", "contact", "stiffness", "damping", "working_force"),
    *("drive", "load", "environment", "settings"),
)
"""What of a design no part depends on: runs at other loads and speeds have the same parts, which are drawn once."""


def parts(design: Design, chord_error: float | None = None) -> dict[str, Solid]:
    """Give housing, shaft, gear, pin (one of N; only where the ring has pins) and output, each in its own frame.

    The pin of a sleeved ring is the sleeve; the pressed-in pins are the housing's. With D discs there are ``gear_1`` to
    ``gear_D``, each in the frame of its disc, ``cam_1`` to ``cam_D`` in that of the shaft, and one ``spacer`` of D - 1.

    Parameters
    ----------
    design
        The design.
    chord_error
        Largest distance of a chord from its curve [m]; right for mass properties when left out.

    Raises
    ------
    DesignError
        A part cannot be made, or the parts do not fit into each other.
    """
    return dict(_parts(_shape(design), chord_error))


def body_solids(design: Design) -> dict[str, Solid]:
    """Give what moves together as one solid each, by the part that names it: as `parts`, but the whole crank as shaft.

    Raises
    ------
    DesignError
        As `parts`.
    """
    found = parts(design)
    if design.gear.discs == 1:
        return found
    whole = _whole_crank(_shape(design))
    on_crank = {part for part, _ in carried(design).values()}
    return {name: whole if name == names.SHAFT else solid for name, solid in found.items() if name not in on_crank}


def carried(design: Design) -> dict[str, tuple[str, float]]:
    """Give what a built-up crank carries on its shaft: name of each copy -> its part, and how far up z it is [m]."""
    gear = design.gear
    if gear.discs == 1:
        return {}
    cams = {name: (name, 0.0) for name in names.all_numbered(names.CAM, gear.discs)}
    middles = [plane + gear.disc_spacing / 2 for plane in gear.disc_planes[:-1]]
    spacers = zip(names.all_numbered(names.SPACER, len(middles)), middles, strict=True)
    return cams | {name: (names.SPACER, middle) for name, middle in spacers}


def _shape(design: Design) -> Design:
    """Give a design without what no part depends on."""
    return design.model_copy(update={name: Design.model_fields[name].default for name in SHAPING_NOTHING})


def crank_stretches(design: Design) -> Mapping[str, Prism]:
    """Give the stretches of the whole crank by name, as right as for its mass; see ``shaft.stretches``.

    Raises
    ------
    DesignError
        As `parts`.
    """
    return _stretches(_shape(design), None)


@lru_cache(maxsize=32)
def _whole_crank(design: Design) -> Solid:
    return Solid(names.SHAFT, tuple(_stretches(design, None).values()), design.material_of("shaft").density)


@lru_cache(maxsize=32)
def _stretches(design: Design, chord_error: float | None) -> Mapping[str, Prism]:
    return stretches(design, chord_error, _gears(design, chord_error)[0])


@lru_cache(maxsize=32)
def _gears(design: Design, chord_error: float | None) -> tuple[Solid, ...]:
    return tuple(gear_solid(design, chord_error, disc) for disc in range(design.gear.discs))


@lru_cache(maxsize=32)
def _parts(design: Design, chord_error: float | None) -> dict[str, Solid]:
    gears = _gears(design, chord_error)
    crank = crank_parts(design, chord_error) if len(gears) > 1 else (_single(design, chord_error),)
    solids = [housing_solid(design, chord_error), *crank, *gears]
    if design.ring.kind == "pin":
        solids.append(pin_solid(design, chord_error))
    solids.append(output_solid(design, chord_error))
    return {solid.name: solid for solid in solids}


def _single(design: Design, chord_error: float | None) -> Solid:
    prisms = tuple(_stretches(design, chord_error).values())
    return Solid(names.SHAFT, prisms, design.material_of("shaft").density)
