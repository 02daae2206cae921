"""What of a reducer is made and what is bought, and how the parts that are made are drawn for a printer."""

from dataclasses import dataclass

from cycloid_mj.base import names
from cycloid_mj.base.errors import DesignError
from cycloid_mj.design.materials import SOFTEST_METAL
from cycloid_mj.parts import Prism, Solid, circle, crank_stretches, output_centres, parts, sleeve_core_radius
from cycloid_mj.parts.export.casing import FLANGE, MOTOR_COVER, OUTPUT_COVER, Casing, casing_parts, cut_solid
from cycloid_mj.parts.polygon import turned
from cycloid_mj.reducer import Reducer

SECOND_OUTPUT = "output_2"
"""The output disc on the motor's side, where both ends of the output pins are held."""

STANDS_OUT = 1e-5
"""By how much the cam of one disc stands out where it would be flush with the shaft [m]: outlines may not touch."""

OUTPUT_PIN, PRESSED_PIN = "output_pin", "pressed_pin"
"""Round parts that the solids of the mechanism have within output and housing."""


@dataclass(frozen=True)
class PrintedPart:
    """A part that is made, as it is printed, and how many there are of it."""

    count: int
    solid: Solid


def widened(reducer: Reducer, offset: float) -> Reducer:
    """Return a design with every clearance wider by an offset [m]; press fits stay, and so does what is bought.

    The pin in a sleeve keeps its size: the bore of the sleeve takes the offset.

    Raises
    ------
    DesignError
        A clearance would be wider than a design may have it, or no wall is left of the sleeves.
    """
    design = reducer.design
    if not offset:
        return reducer
    ring = {"sleeve_thickness": design.ring.sleeve_thickness - offset} if design.ring.has_sleeves else {}
    clearance = {pair: getattr(design.clearance, pair) + offset for pair in design.pair_kinds}
    try:
        return reducer.but(clearance=clearance, ring=ring)
    except DesignError as error:
        raise DesignError(
            f"an offset of {1e6 * offset:g} um is too much for the design: a clearance would be wider than a design "
            "may have it, or nothing left of the sleeves; give a smaller offset"
        ) from error


def is_printed(reducer: Reducer, part: str) -> bool:
    """Tell whether plain round parts of this material are printed: of a plastic; of a metal they are bought."""
    return reducer.design.material_of(part).youngs_modulus < SOFTEST_METAL


def in_one_piece(reducer: Reducer) -> bool:
    """Tell whether the output pins are printed with their disc: of a plastic, without rollers, held at one end."""
    output = reducer.design.output
    return is_printed(reducer, names.OUTPUT) and not output.rollers and output.support == "cantilever"


def material_part(reducer: Reducer, made: str) -> str:
    """Name the part of the mechanism that a part is made of the material of.

    Discs and flange of the output are printed with the housing, whatever its pins are of.
    """
    family = names.family(made)
    if family in (names.CAM, names.SPACER):
        return names.SHAFT
    if family == PRESSED_PIN:
        return names.PIN
    if family in (MOTOR_COVER, OUTPUT_COVER):
        return names.HOUSING
    if family in (names.OUTPUT, FLANGE):
        return names.HOUSING if is_printed(reducer, names.HOUSING) else names.OUTPUT
    return names.OUTPUT if family == OUTPUT_PIN else family


def printed_parts(
    reducer: Reducer, chord_error: float, cam_seat: float = 0.0, sizes: Casing | None = None
) -> dict[str, PrintedPart]:
    """Collect the parts that a printer makes: of `made_parts` those of a plastic, or all where none is of one."""
    made = made_parts(reducer, chord_error, cam_seat, sizes)
    plastic = {name: part for name, part in made.items() if is_printed(reducer, material_part(reducer, name))}
    return plastic or made


def made_parts(
    reducer: Reducer, chord_error: float, cam_seat: float = 0.0, sizes: Casing | None = None
) -> dict[str, PrintedPart]:
    """Collect every part that is made, in its own frame, by name.

    Housing, gears and output are made of whatever material; so is the crank of one disc, and cams and spacers on the
    shaft of several. Plain round parts (ring pins, sleeves, output pins, that shaft) are made if they are of a plastic.
    Output pins that are parts of their own have bores in their discs, to be pressed in.

    Parameters
    ----------
    reducer
        The reducer; its clearances are in the outlines.
    chord_error
        Largest distance of a chord from its curve [m].
    cam_seat
        Radius of cams as they are made, that of their bearing's bore [m]; 0: that of its outside, as drawn.
    sizes
        Those of covers and flanges, if these are to be made too.

    Raises
    ------
    DesignError
        A part cannot be made.
    """
    design = reducer.design
    solids, discs = parts(reducer, chord_error), design.gear.discs
    if cam_seat:
        solids |= _seated(reducer, solids, chord_error, cam_seat)
    housing = solids[names.HOUSING]
    wheel, *pressed = housing.prisms
    printed = {names.HOUSING: PrintedPart(1, Solid(housing.name, (wheel,), housing.density))}
    printed |= {name: PrintedPart(1, solids[name]) for name in names.gears(discs)}
    if discs > 1:
        printed |= {name: PrintedPart(1, solids[name]) for name in names.all_numbered(names.CAM, discs)}
        printed[names.SPACER] = PrintedPart(discs - 1, solids[names.SPACER])
    if discs == 1 or is_printed(reducer, names.SHAFT):
        printed[names.SHAFT] = PrintedPart(1, solids[names.SHAFT])
    if names.PIN in solids and is_printed(reducer, names.PIN):
        printed[names.PIN] = PrintedPart(design.ring.teeth, solids[names.PIN])
        if pressed:
            core, half = circle(sleeve_core_radius(reducer), chord_error), design.gear.stack_width / 2.0
            solid = Solid(PRESSED_PIN, (Prism(core, (), -half, half),), solids[names.PIN].density)
            printed[PRESSED_PIN] = PrintedPart(design.ring.teeth, solid)
    printed |= _output(reducer, solids[names.OUTPUT], chord_error)
    return _cased(reducer, printed, sizes, chord_error) if sizes else printed


def _cased(reducer: Reducer, made: dict[str, PrintedPart], sizes: Casing, chord_error: float) -> dict[str, PrintedPart]:
    """Add covers and flange, and to the parts of the mechanism what these need: holes, the hub, seats."""
    cased = dict(made)
    for name, part in casing_parts(reducer, sizes).items():
        if part.bought or (name == names.SHAFT and name not in made):
            continue
        base = made[name].solid.prisms if name in made else ()
        density = reducer.design.material_of(material_part(reducer, name)).density
        cased[name] = PrintedPart(1, cut_solid(name, part, chord_error, density, base))
    return cased


def output_pin_span(reducer: Reducer) -> tuple[float, float]:
    """Compute from where to where an output pin reaches [m], with what is pressed into each output disc."""
    output, drawn = reducer.design.output, parts(reducer)[names.OUTPUT].prisms[1]
    return drawn.z0 - output.disc_thickness * (output.support == "both_ends"), drawn.z1 + output.disc_thickness


def output_pin_length(reducer: Reducer) -> float:
    """Compute the length of an output pin through discs and gaps, with what is pressed into each output disc [m]."""
    low, high = output_pin_span(reducer)
    return high - low


def _seated(reducer: Reducer, solids: dict[str, Solid], chord_error: float, seat: float) -> dict[str, Solid]:
    """Build the parts of the crank that have cams, with cams of the radius `seat` [m]."""
    design = reducer.design
    gear, discs = design.gear, design.gear.discs
    flush = gear.eccentricity + design.shaft.radius
    if gear.bearing != "rolling":
        raise DesignError("the cam slides in the gear (gear.bearing = 'plain'): it has no bearing with a bore")
    if not (flush < seat or (discs == 1 and seat == round(flush, 9))) or not seat < gear.bore_radius:
        raise DesignError(
            f"a cam's bearing with a bore of {2e3 * seat:g} mm does not fit: it must be more than {2e3 * flush:g} mm, "
            f"for the shaft in the eccentric cam, and less than {2e3 * gear.bore_radius:g} mm, its outside "
            "(gear.bore_radius_mm)"
        )
    cam = circle(max(seat, flush + STANDS_OUT), chord_error, (0.0, gear.eccentricity))
    if discs == 1:
        stretches = zip(crank_stretches(reducer), solids[names.SHAFT].prisms, strict=True)
        prisms = [Prism(cam, (), one.z0, one.z1) if name == names.CAM else one for name, one in stretches]
        return {names.SHAFT: Solid(names.SHAFT, tuple(prisms), solids[names.SHAFT].density)}
    seated = {}
    for name, phase in zip(names.all_numbered(names.CAM, discs), reducer.phases, strict=True):
        (one,) = solids[name].prisms
        seated[name] = Solid(name, (Prism(turned(cam, phase), one.holes, one.z0, one.z1),), solids[name].density)
    return seated


def _output(reducer: Reducer, drawn: Solid, chord_error: float) -> dict[str, PrintedPart]:
    """List the output as it is printed: in one piece, or its discs with bores, and the pins where they are printed."""
    if in_one_piece(reducer):
        return {names.OUTPUT: PrintedPart(1, drawn)}
    output, density = reducer.design.output, drawn.density
    discs = {names.OUTPUT: drawn.prisms[0]}
    if output.support == "both_ends":
        discs[SECOND_OUTPUT] = drawn.prisms[-1]
    pin = circle(output.root_radius, chord_error)
    bores = tuple(pin + centre for centre in output_centres(reducer))
    printed = {
        name: PrintedPart(1, Solid(name, (Prism(disc.outline, (*disc.holes, *bores), disc.z0, disc.z1),), density))
        for name, disc in discs.items()
    }
    if is_printed(reducer, names.OUTPUT):
        solid = Solid(OUTPUT_PIN, (Prism(pin, (), 0.0, output_pin_length(reducer)),), density)
        printed[OUTPUT_PIN] = PrintedPart(output.pins, solid)
    return printed
