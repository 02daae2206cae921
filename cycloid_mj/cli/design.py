"""``cycloid-mj design new``, ``show`` and ``check``."""

import re
from collections.abc import Callable, Sequence
from dataclasses import asdict
from math import degrees
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import App, Parameter

from cycloid_mj.base.errors import CycloidError, UsageError
from cycloid_mj.base.outcome import Outcome
from cycloid_mj.base.replacing import claim
from cycloid_mj.base.whole import write_whole
from cycloid_mj.cli.delivery import claimed, deliver
from cycloid_mj.cli.flags import DELIVERY, FLAT, NAMES, Delivery, DesignOptions, ForceFlag, SetFlag, designed, whole
from cycloid_mj.cli.terminal import say
from cycloid_mj.design import PRESETS, Design, dump, override, reasons
from cycloid_mj.reducer import Reducer

if TYPE_CHECKING:
    from cycloid_mj.checks import Check, Summary
    from cycloid_mj.life import Rating

NewName = Annotated[
    str, Parameter(metavar="NAME", help="Name of the new design and of its runs; the file is NAME.toml.")
]
FromFlag = Annotated[
    str, Parameter(name="--from", metavar="NAME|FILE", help=f"Design to start from: {NAMES}, or a TOML file.")
]

RatioFlag = Annotated[
    int | None,
    Parameter(converter=whole, help="Reduction ratio of a new size, whole: one pin more than that."),
]
DiameterFlag = Annotated[float | None, Parameter(help="Outer diameter of a new size [mm].")]
TorqueFlag = Annotated[float | None, Parameter(help="Rated torque on the output of a new size [N m].")]
ProcessFlag = Annotated[
    Literal["steel", "printed"], Parameter(help="How a new size is made: materials, clearances, how the pins are held.")
]

DiscsFlag = Annotated[
    int | None, Parameter(converter=whole, help="Discs on the crank of a new size, 1 to 4. Default: 1.")
]

EXAMPLES = """Examples:
  cycloid-mj design new mine --ratio 20 --diameter-mm 60 --torque-nm 5
  cycloid-mj design new two --ratio 9 --diameter-mm 80 --torque-nm 9 --discs 2
  cycloid-mj design new my --from nonpin
  cycloid-mj design check my.toml --set ring.pin_radius_mm=2
  cycloid-mj design check nonpin --json
  cycloid-mj design show pin
  cycloid-mj design show twodisc --set gear.disc_gap_mm=5"""


def commands(sort_key: int) -> App:
    """Build the commands about design files; `sort_key` is their place in the help."""
    about = "Make a design file, print one, or check one."
    app = App(name="design", help=about, help_epilogue=EXAMPLES, sort_key=sort_key)
    parts: tuple[Callable[..., int], ...] = (new, show, check)
    for place, command in enumerate(parts):
        app.command(command, sort_key=place)
    return app


def new(
    name: NewName,
    /,
    *,
    source: FromFlag = "",
    ratio: RatioFlag = None,
    diameter_mm: DiameterFlag = None,
    torque_nm: TorqueFlag = None,
    process: ProcessFlag = "steel",
    discs: DiscsFlag = None,
    set_: SetFlag = (),
    force: ForceFlag = False,
) -> int:
    """Write NAME.toml, a complete, commented design file to edit.

    It starts from a preset or a file (--from; default: pin), or from a ratio, an
    outer diameter and a rated torque, which are to be given together: then each
    value that was chosen has its reason beside it, the checks pass, and what the
    design carries at the rated torque is printed. The changes of --set come
    last. The file carries the new name, so that its runs do not meet those of
    another design. The path of the file is printed.

    A design has one stage, one crank in the middle, pins (or lobes) on the ring,
    and one lobe fewer on the gear. RV reducers with a planetary stage, tooth
    differences of 2 or more, and hypocycloid drives with the pins on the gear
    are not there.
    """
    stem = name.removesuffix(".toml")
    if not re.fullmatch(r"\w[\w .-]{0,63}", stem):
        raise UsageError(f"NAME {name!r}: expected letters, digits, space . _ -, at most 64, e.g. my")
    if stem in PRESETS:
        raise UsageError(f"NAME {name!r} is a preset; give a design of your own another name, e.g. my-{stem}")
    file = Path(f"{stem}.toml")
    claim(file, force=force)
    asked = {"--ratio": ratio, "--diameter-mm": diameter_mm, "--torque-nm": torque_nm}
    if all(value is None for value in asked.values()):
        if discs is not None:
            raise UsageError(f"--discs {discs} is for a new size; of another design it is --set gear.discs={discs}")
        source = source or "pin"
        started = designed(source, set_, ()).but(name=stem)
        write_whole({file: dump(started, reasons(source, started)).encode()})
        say(str(file))
        return 0
    if ratio is None or diameter_mm is None or torque_nm is None:
        missing = " and ".join(flag for flag, value in asked.items() if value is None)
        raise UsageError(f"{missing} is missing: a new size takes --ratio, --diameter-mm and --torque-nm together")
    if source:
        raise UsageError(f"--from {source} starts from a design, --ratio from none: leave one of them out")
    from cycloid_mj.explore.sizing import sized

    sizing = sized(stem, ratio, 1e-3 * diameter_mm, torque_nm, process, 1 if discs is None else discs)
    design = override(sizing.design, set_)
    write_whole({file: dump(design, sizing.reasons).encode()})
    say(str(file))
    for line in _carried(design):
        say(f"  {line}")
    return 0


def _carried(design: Design) -> list[str]:
    """Tell what a new design carries, and what its checks warn of."""
    from cycloid_mj.checks import check as checks

    failures = [item for item in checks(design) if not item.passed]
    summed = _summed(design)
    return [*(_lines(summed, _rated(design)) if summed else []), *(f"{_word(item)}  {item}" for item in failures)]


def show(chosen: Annotated[DesignOptions, FLAT]) -> int:
    """Print the complete, commented design file of a preset or of a file, with the changes of --set.

    Each value that the paper (Hsieh 2014) does not give is marked as
    assumed. A file may leave keys out: they keep the values of the preset pin.
    """
    design = chosen.resolved()
    say(dump(design, reasons(chosen.design, design)).rstrip("\n"))
    return 0


def check(chosen: Annotated[DesignOptions, FLAT], *, delivery: Annotated[Delivery, FLAT] = DELIVERY) -> int:
    """Make every check of a design, and sum the design up.

    For each check that fails or warns: the value, its limit, the reason, and what
    to change; --all lists the others too. First come those of whether it can be built, then those that decide
    how well it works at its rated torque (drive torque times the ratio), by
    statics with the real clearances, friction and errors; these only warn.

    The summary tells ratio, size, mass, what carries, backlash, the capacity (the
    torque at which a contact first yields), and what fails first: the weakest item
    of `cycloid-mj rate`, for 10 000 h. The exit code is 1 if the design cannot be
    built, else 0: warnings do not count.
    """
    from cycloid_mj.checks import check as checks

    design = chosen.resolved()
    place = claimed(delivery, f"{design.name}-check")
    results = checks(design)
    sound = not any(_word(item) == "FAIL" for item in results)
    summed = _summed(design) if sound else None
    rating = _rated(design) if summed else None
    return deliver(_outcome(design.name, results, summed, rating), place, delivery)


def _outcome(design: str, found: "Sequence[Check]", summed: "Summary | None", rating: "Rating | None") -> Outcome:
    from cycloid_mj.base.frame import framed

    failed, warned, passed = ([item for item in found if _word(item) == word] for word in ("FAIL", "warn", "ok"))
    numbers = _in_file_units(summed, rating) if summed else None
    rows = [asdict(item) for item in found]
    count = f"{len(warned)} {'warning' if len(warned) == 1 else 'warnings'}"
    return Outcome(
        title=f"checks: {design}",
        failures=list(map(str, failed)),
        warnings=list(map(str, warned)),
        passes=list(map(str, passed)),
        summary=[
            *(f"      {line}" for line in (_lines(summed, rating) if summed else [])),
            f"{len(found)} checks: {len(failed)} failed, {count}",
        ],
        frame=framed(rows, rows[0], {}),
        result={"design": design, "sound": not failed, "checks": rows, "summary": numbers},
        code=1 if failed else 0,
    )


def _summed(design: Design) -> "Summary | None":
    """Sum a design up; nothing where its statics have no solution, which a check has told."""
    from cycloid_mj.checks import summary

    try:
        return summary(Reducer(design))
    except CycloidError:
        return None


def _rated(design: Design) -> "Rating | None":
    """Rate a design at its rated torque and speed; nothing where its crank stands still."""
    from cycloid_mj.life.items import rate

    try:
        return rate(design)
    except CycloidError:
        return None


def _in_file_units(summed: "Summary", rating: "Rating | None") -> dict[str, Any]:
    return {
        "ratio": summed.ratio,
        "outer_diameter_mm": 1e3 * summed.outer_diameter,
        "mass_kg": summed.mass,
        "rated_torque_nm": summed.rated_torque,
        "loaded_teeth": summed.loaded_teeth,
        "loaded_teeth_per_disc": summed.loaded_teeth,
        "pressure_angle_deg": degrees(summed.pressure_angle),
        "backlash_arcmin": 60.0 * degrees(summed.backlash),
        "capacity_nm": summed.capacity,
        "weakest": summed.weakest,
        "material_limits": list(summed.material_limits),
        "weakest_item": None if rating is None else {"key": rating.weakest.key, **rating.weakest.as_json()},
    }


def _lines(summed: "Summary", rating: "Rating | None") -> list[str]:
    angle, play = degrees(summed.pressure_angle), 60.0 * degrees(summed.backlash)
    of = " of each disc" if summed.discs > 1 else ""
    part = "one and the same part" if summed.one_part else "each a part of its own"
    return [
        *([f"{summed.discs} discs, {part}"] if summed.discs > 1 else []),
        f"ratio {summed.ratio}:1, outer diameter {1e3 * summed.outer_diameter:.4g} mm, mass {summed.mass:.3g} kg",
        f"at the rated {summed.rated_torque:.4g} N m: {summed.loaded_teeth:.1f} teeth{of} carry on average,"
        f" mean pressure angle {angle:.1f} deg",
        f"backlash {play:.3g} arcmin; capacity {summed.capacity:.3g} N m, at which {summed.weakest} first yields",
        *([f"weakest: {rating.weakest_line()}"] if rating else []),
        *summed.material_limits,
    ]


def _word(item: "Check") -> str:
    if item.passed:
        return "ok"
    return "FAIL" if item.severity == "error" else "warn"
