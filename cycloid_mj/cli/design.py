"""``cycloid-mj design new``, ``show`` and ``check``."""

import tomllib
from collections.abc import Callable, Sequence
from dataclasses import replace
from math import degrees
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import App, Parameter

from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.outcome import Outcome
from cycloid_mj.cli.completion import CompletingApp
from cycloid_mj.cli.delivery import claim_destination, deliver
from cycloid_mj.cli.flags import DELIVERY, FLAT, MOTOR_TORQUE, Delivery, DesignOptions
from cycloid_mj.cli.kinematics import EXAMPLES as KINEMATICS_EXAMPLES
from cycloid_mj.cli.kinematics import kinematics
from cycloid_mj.cli.new import new
from cycloid_mj.cli.profile import EXAMPLES as PROFILE_EXAMPLES
from cycloid_mj.cli.profile import profile
from cycloid_mj.design import Design, Inheritance, dump, preset_reasons, value_of
from cycloid_mj.reducer import Reducer, RvReducer, reducer_of

if TYPE_CHECKING:
    from cycloid_mj.checks import Checks, Summary
    from cycloid_mj.life import Rating

EXAMPLES = """Examples:
  cycloid-mj design new mine --ratio 20 --diameter-mm 60 --torque-nm 4
  cycloid-mj design new two --ratio 9 --diameter-mm 80 --torque-nm 5 --discs 2 --life-h 20000
  cycloid-mj design new arm --ratio-range 25:35 --diameter-mm 90 --torque-nm 0.5 --process printed
  cycloid-mj design new my --from nonpin
  cycloid-mj design check my.toml --set ring.pin_radius_mm=2
  cycloid-mj design check nonpin --json
  cycloid-mj design check my.toml --strict
  cycloid-mj design show pin
  cycloid-mj design show twodisc --set gear.disc_gap_mm=5"""


def commands(sort_key: int) -> App:
    """Build the group of commands `design` (new, show, check, profile, kinematics).

    `sort_key` is its position in the help.
    """
    help_text = "Create, print and check design files."
    app = CompletingApp(name="design", help=help_text, help_epilogue=EXAMPLES, sort_key=sort_key)
    group_commands: tuple[Callable[..., int], ...] = (new, show, check)
    for order, command in enumerate(group_commands):
        app.command(command, sort_key=order)
    app.command(profile, help_epilogue=PROFILE_EXAMPLES, sort_key=len(group_commands))
    app.command(kinematics, help_epilogue=KINEMATICS_EXAMPLES, sort_key=len(group_commands) + 1)
    return app


def show(design_options: Annotated[DesignOptions, FLAT], *, output_flags: Annotated[Delivery, FLAT] = DELIVERY) -> int:
    """Print the complete, commented design file of a preset or a file, including changes by --set.

    Values that the paper (Hsieh 2014) does not state are marked as assumed. Keys that a file omits have the values of
    the preset in [base], or of pin. JSON has the tables and keys of the file; --out writes the file as well.
    """
    design = design_options.resolve()
    text, file = dump(design, preset_reasons(design_options.design, design)), f"{design.name}.toml"
    destination = claim_destination(output_flags, f"{design.name}-design", [file])
    outcome = Outcome(
        title=f"design: {design.name}",
        text=text.splitlines(),
        files={file: text.encode()},
        result=tomllib.loads(text),
    )
    return deliver(outcome, destination, output_flags)


StrictFlag = Annotated[bool, Parameter(name="--strict", negative="", help="Exit with code 1 if there are warnings.")]


def check(
    design_options: Annotated[DesignOptions, FLAT],
    *,
    strict: StrictFlag = False,
    output_flags: Annotated[Delivery, FLAT] = DELIVERY,
) -> int:
    """Check a design, and summarize it.

    Each failed check or warning is printed with its value, limit, reason and remedy; --all adds passed checks. The
    first checks decide whether the design can be built (errors). The others are warnings. They evaluate how well
    the design works at its nominal torque (drive torque times ratio), by statics with the real clearances, friction and
    errors. They also evaluate whether it withstands this torque for its required life: shortest life of a part,
    temperature, strength, and a peak of twice this torque.

    The summary lists ratio, size, mass, load sharing, backlash, capacity (torque at which a contact first yields),
    and the weakest item of `cycloid-mj rate` for service.life_h. The exit code is 1 if the design cannot be built,
    else 0; warnings count with --strict only.
    """
    from cycloid_mj.life.checks import check_reducer

    design = design_options.resolve()
    destination = claim_destination(output_flags, f"{design.name}-check")
    reducer, inheritance = reducer_of(design), design_options.inheritance()
    checks = check_reducer(reducer)
    if isinstance(reducer, RvReducer):
        outcome = replace(_outcome(design, checks, None, None, inheritance), summary=_rv_summary_lines(reducer, checks))
        return deliver(_strictly(outcome, strict), destination, output_flags)
    summary = None if checks.failures else _compute_summary(reducer)
    rating = _compute_rating(reducer) if summary else None
    return deliver(_strictly(_outcome(design, checks, summary, rating, inheritance), strict), destination, output_flags)


def _strictly(outcome: Outcome, strict: bool) -> Outcome:
    """Return an outcome whose warnings fail, if `strict` is set."""
    return replace(outcome, code=1) if strict and outcome.warnings else outcome


def _rv_summary_lines(reducer: RvReducer, checks: "Checks") -> list[str]:
    """Return the summary of an RV reducer as lines of text: ratio, cranks, size, mass, discs, number of checks.

    The mass is left out if the design cannot be built.
    """
    from cycloid_mj.geometry.rv import are_one_part, flip_clockings
    from cycloid_mj.parts.export.rv_assembly import rv_mass

    ring, lobe_count, disc_count = reducer.design.ring, reducer.design.lobes, reducer.design.gear.discs
    lines = [
        f"      ratio {float(reducer.kinematics.ratio):.6g}, {reducer.cranks.count} cranks on a radius of "
        f"{1e3 * reducer.crank_radius:.4g} mm; crank bearings turn {float(reducer.kinematics.bearing_turns):g} times "
        "per turn of the output",
        f"      bearings of the cranks in the flanges: {reducer.crank_bearing_text}",
        f"      outer diameter {2e3 * reducer.design.housing.outer_radius:.4g} mm, nominal torque "
        f"{reducer.design.rated_torque:.4g} N m",
    ]
    if not checks.failures:
        bearing = reducer.main_bearing
        bearing_text = f"with main bearings 2 x {bearing.designation}, without" if bearing else "without main bearings,"
        lines.append(f"      mass {rv_mass(reducer):.4g} kg, {bearing_text} screws and the shaft of the sun")
    if disc_count > 1:
        if are_one_part(ring.teeth, lobe_count, disc_count, reducer.cranks.count):
            disc_text = "one part, turned by a step of the crank bores"
        elif disc_count == 2:
            clocking_text = " or ".join(map(str, flip_clockings(ring.teeth, lobe_count, reducer.cranks.count)))
            disc_text = (
                f"different parts; they are one part, flipped, if a crank bore is {clocking_text} of a pitch off a lobe"
            )
        else:
            disc_text = "different parts"
        lines.append(f"      {disc_count} discs, {disc_text}")
    return [*lines, f"{len(checks)} checks: {checks.counts}"]


def _outcome(
    design: Design,
    checks: "Checks",
    summary: "Summary | None",
    rating: "Rating | None",
    inheritance: Inheritance | None,
) -> Outcome:
    """Convert checks, summary and rating of a design to printable results; the exit code is 1 if it cannot be built.

    `inheritance` are the values that the file takes from its preset. Summary, rating and inheritance are None if not
    available.
    """
    summary_values = _summary_json(summary, rating) if summary else None
    return Outcome(
        title=f"checks: {design.name}",
        condition=_describe_motor_defaults(design, inheritance.motor if inheritance else ()),
        failures=list(map(str, checks.failures)),
        warnings=list(map(str, checks.warnings)),
        passes=list(map(str, checks.passes)),
        summary=[
            *(f"      {line}" for line in (_summary_lines(design, summary, rating) if summary else [])),
            f"{len(checks)} checks: {checks.counts}",
            *(inheritance.remedy if inheritance and checks.failures else ()),
            *([inheritance.note] if inheritance and inheritance.note else []),
        ],
        frame=checks.frame,
        result={
            "design": design.name,
            "inherited": list(inheritance.values) if inheritance else [],
            "sound": not checks.failures,
            "checks": [check.as_json() for check in checks],
            "summary": summary_values,
        },
        code=1 if checks.failures else 0,
    )


def _describe_motor_defaults(design: Design, motor: Sequence[str]) -> str:
    """Return a sentence on the motor torque and speed that apply by default; empty if the design file states both.

    `motor` are the keys of motor torque and speed that the file leaves out, such as "drive.torque_nm".
    """
    if not motor:
        return ""
    value_text = " and ".join(f"{key} = {value_of(design, key):.4g}" for key in motor)
    alternative_text = ", or load.torque_nm" if MOTOR_TORQUE in motor else ""
    return (
        f"at a nominal torque of {design.rated_torque:.4g} N m by the default{'s' * (len(motor) > 1)} {value_text}, "
        f"which the design file does not set: set what your motor has{alternative_text}; "
        "`cycloid-mj datasheet` computes the rated output torque"
    )


def _compute_summary(reducer: Reducer) -> "Summary | None":
    """Compute ratio, size, mass, loads and backlash of a reducer (`Summary`); None without a static equilibrium.

    A check reports the missing equilibrium.
    """
    from cycloid_mj.checks import summarize

    try:
        return summarize(reducer)
    except CycloidError:
        return None


def _compute_rating(reducer: Reducer) -> "Rating | None":
    """Rate the life of a reducer at nominal torque and speed; None if this fails, as for a crank at rest."""
    from cycloid_mj.life.items import rate_for_verdict

    try:
        return rate_for_verdict(reducer)
    except CycloidError:
        return None


def _summary_json(summary: "Summary", rating: "Rating | None") -> dict[str, Any]:
    """Convert the summary of a design to JSON values, such as ``ratio``, ``mass_kg`` and ``backlash_arcmin``.

    `rating` adds the weakest part under the key ``weakest_item``, which is None if the design could not be rated.
    """
    return {
        "ratio": summary.ratio,
        "outer_diameter_mm": 1e3 * summary.outer_diameter,
        "mass_kg": summary.mass,
        "nominal_torque_nm": summary.rated_torque,
        "rated_torque_nm": summary.rated_torque,  # the former key of the nominal torque, for one release
        "loaded_teeth": summary.loaded_teeth,
        "loaded_teeth_per_disc": summary.loaded_teeth,
        "pressure_angle_deg": degrees(summary.pressure_angle),
        "backlash_arcmin": 60.0 * degrees(summary.backlash),
        "capacity_nm": summary.capacity,
        "weakest": summary.weakest,
        "material_limits": list(summary.material_limits),
        "weakest_item": None if rating is None else {"key": rating.weakest.key, **rating.weakest.as_json()},
    }


def _summary_lines(design: Design, summary: "Summary", rating: "Rating | None") -> list[str]:
    """Return the summary of a design as lines of text: discs, size, loaded teeth, backlash and capacity.

    If `rating` has been computed, a line on the weakest part is added; notes on measured parts follow.
    """
    from cycloid_mj.geometry.measured import part_notes

    pressure_angle, backlash = degrees(summary.pressure_angle), 60.0 * degrees(summary.backlash)
    disc_text = " of each disc" if summary.discs > 1 else ""
    part_text = "identical parts" if summary.one_part else "different parts"
    return [
        *([f"{summary.discs} discs, {part_text}"] if summary.discs > 1 else []),
        f"ratio {summary.ratio}:1, outer diameter {1e3 * summary.outer_diameter:.4g} mm, mass {summary.mass:.3g} kg",
        f"at the nominal torque of {summary.rated_torque:.4g} N m: {summary.loaded_teeth:.1f} teeth{disc_text} "
        f"carry load on average, mean pressure angle {pressure_angle:.1f} deg",
        f"backlash {backlash:.3g} arcmin; capacity {summary.capacity:.3g} N m (first yield at {summary.weakest})",
        *([f"weakest: {rating.weakest_line()}"] if rating else []),
        *part_notes(design),
    ]
