"""``cycloid-mj design new``: write a design file from a preset, or find drives for a requirement."""

import itertools
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from cycloid_mj.base.errors import DesignError, UsageError, reason
from cycloid_mj.base.outcome import Outcome
from cycloid_mj.base.overwrite_guard import claim
from cycloid_mj.base.result import Table
from cycloid_mj.cli.delivery import Destination, claim_page, deliver
from cycloid_mj.cli.flags import FLAT, NAMES, Delivery, SetFlag, load_design, out_flag, whole, whole_number
from cycloid_mj.cli.outfile import folder
from cycloid_mj.cli.progress import show_activity
from cycloid_mj.cli.terminal import tell
from cycloid_mj.design import PRESETS, dump, reasons

if TYPE_CHECKING:
    from cycloid_mj.sizing.answer import Answer, FeasibleChange, SizedDrive
    from cycloid_mj.sizing.process import Process
    from cycloid_mj.sizing.requirement import Requirement

NewName = Annotated[
    str, Parameter(metavar="NAME", help="Name of the new design and of its runs; the file is NAME.toml.")
]
FromFlag = Annotated[
    str, Parameter(name="--from", metavar="NAME|FILE", help=f"Design to copy: a preset ({NAMES}) or a TOML file.")
]
RatioFlag = Annotated[
    int | None,
    Parameter(
        metavar="N", converter=whole, help="Reduction ratio of a new drive, an integer; the ring has one pin more."
    ),
]
RatioRangeFlag = Annotated[
    str, Parameter(metavar="LOW:HIGH", help="Range of ratios; the ratio with the highest torque is chosen.")
]
DiameterFlag = Annotated[
    float | None,
    Parameter(metavar="X", help="Outer diameter of the drive with its covers [mm]."),
]
LengthFlag = Annotated[
    float | None,
    Parameter(metavar="X", help="Maximum length including covers and output flange [mm]. Default: no limit."),
]
TorqueFlag = Annotated[
    float | None,
    Parameter(
        metavar="X",
        help="Continuous output torque for the required life [N m]; twice this torque is allowed as a peak.",
    ),
]
LifeFlag = Annotated[
    float | None,
    Parameter(metavar="X", help="Required life under the torque [h]. Default: 6000; 500 for printed drives."),
]
SpeedFlag = Annotated[
    float | None, Parameter(metavar="X", help="Crank speed [rpm]. Default: 1500; 300 for printed drives.")
]
OutputSpeedFlag = Annotated[
    float | None, Parameter(name="--output-rpm", metavar="X", help="Output speed [rpm], instead of --speed-rpm.")
]
DutyFlag = Annotated[
    str,
    Parameter(
        metavar="SHARE|FILE",
        help="Share of the time under load, 0.001 to 1, or CSV file of a duty cycle (as for `cycloid-mj rate --duty`), "
        "whose largest torque becomes --torque-nm. Default: 1; 0.25 for printed drives.",
    ),
]
CoolingFlag = Annotated[
    str,
    Parameter(
        metavar="still|mounted|fan|X",
        help="Cooling of the housing: still air, mounted on a machine, a fan, or a heat transfer coefficient "
        "[W/(m2 K)]. Default: still.",
    ),
]
AmbientFlag = Annotated[
    float, Parameter(name="--ambient-c", metavar="X", help="Temperature around the housing [°C]. Default: 20.")
]
MotorFlag = Annotated[
    str,
    Parameter(
        metavar="NAME|FILE",
        help="Motor frame (nema17, nema23, nema34) or CSV file of a motor's curve, columns speed_rpm and torque_nm: "
        "the crank turns as fast as the motor delivers the required torque (a frame by its usual power, and no faster "
        "than the default), instead of --speed-rpm.",
    ),
]
BacklashFlag = Annotated[
    float | None,
    Parameter(
        metavar="X", help="Maximum backlash of the output [arcmin]; it limits the clearances. Default: no limit."
    ),
]
MaterialFlag = Annotated[
    str,
    Parameter(
        metavar="NAME",
        help="Material of discs and housing, a name of the material library. Default: that of the process.",
    ),
]
ClearanceFlag = Annotated[
    float | None, Parameter(metavar="X", help="Clearance of each pair of parts [um]. Default: that of the process.")
]
FitFlag = Annotated[
    str,
    Parameter(
        metavar="H7/g6",
        help="Fit of each pair of parts at its own size (ISO 286-1), instead of a clearance; its mean "
        "clearance is used.",
    ),
]
CustomFlag = Annotated[
    bool, Parameter(negative=(), help="Allow any size, not only those of pins, bearings and screws in stock.")
]
ProcessFlag = Annotated[
    Literal["steel", "printed", "milled"],
    Parameter(
        help="Manufacturing process, which sets materials, clearances and the mounting of the pins. Default: steel."
    ),
]
DiscsFlag = Annotated[
    str,
    Parameter(
        metavar="N|auto", help="Number of discs, 1 to 4, or auto: two discs where one is not enough. Default: 1."
    ),
]


@dataclass(frozen=True, kw_only=True)
class NewDelivery(Delivery):
    """The same; design files are always written."""

    out: Annotated[str | None, out_flag("NAME.toml", "this one")] = None


DELIVERED = NewDelivery()

COLUMNS = {
    "mass_kg": "mass [kg]",
    "drive_length_mm": "length [mm]",
    "rated_torque_nm": "rated [N m]",
    "momentary_torque_nm": "once [N m]",
    "life_h": "life [h]",
    "temperature_c": "housing [°C]",
    "stiffness_nm_per_arcmin": "stiffness [N m/arcmin]",
    "backlash_arcmin": "backlash [arcmin]",
    "yield_percent": "yield [%]",
}
"""Figures of a shortlist -> headings of its table."""


def new(
    name: NewName,
    /,
    *,
    source: FromFlag = "",
    ratio: RatioFlag = None,
    ratio_range: RatioRangeFlag = "",
    diameter_mm: DiameterFlag = None,
    length_mm: LengthFlag = None,
    torque_nm: TorqueFlag = None,
    life_h: LifeFlag = None,
    speed_rpm: SpeedFlag = None,
    output_rpm: OutputSpeedFlag = None,
    duty: DutyFlag = "",
    cooling: CoolingFlag = "still",
    ambient_c: AmbientFlag = 20.0,
    motor: MotorFlag = "",
    backlash_arcmin: BacklashFlag = None,
    process: ProcessFlag = "steel",
    material: MaterialFlag = "",
    clearance_um: ClearanceFlag = None,
    fit: FitFlag = "",
    custom: CustomFlag = False,
    discs: DiscsFlag = "",
    set_: SetFlag = (),
    delivery: Annotated[NewDelivery, FLAT] = DELIVERED,
) -> int:
    """Create NAME.toml, a complete, commented design file to edit.

    It is a copy of a preset or a file (--from; default: pin), or the result of a search from requirements: ratio,
    outer diameter and torque together, and optionally life, speed, length, backlash, material and clearance. The
    search varies pins, eccentricity, width, output pins, bore and shaft with statics and the checks of
    `cycloid-mj rate`, so that the data sheet of each drive meets the requirements, and at least 99 % of the samples
    of its tolerance study turn freely within the backlash. The lightest drive with its covers is NAME.toml, with a
    reason for each value; the stiffest and the longest-lived are NAME-stiffest.toml and NAME-longest-life.toml. If no
    drive meets the requirements, the maximum torque and verified alternatives are printed, and the exit code is 1.
    Changes by --set apply to every drive that the search tries. Printed drives are for 500 h at 300 rpm and 25 % of
    the time unless set otherwise.

    A new size has one stage, one central crank, pins (or lobes) in the ring, and one lobe fewer on the disc. For an
    RV reducer with a planetary stage, copy rv80e (--from rv80e). Tooth differences of 2 or more, and hypocycloid
    drives with the pins on the disc are not supported.
    """
    stem = name.removesuffix(".toml")
    if not re.fullmatch(r"\w[\w .-]{0,63}", stem):
        raise UsageError(f"NAME {name!r} is not allowed: use at most 64 letters, digits, spaces and . _ -, e.g. my")
    if stem in PRESETS:
        raise UsageError(f"NAME {name!r} is the name of a preset: choose another name, e.g. my-{stem}")
    asked = {"--ratio": ratio or ratio_range or None, "--diameter-mm": diameter_mm, "--torque-nm": torque_nm}
    if all(value is None for value in asked.values()):
        if discs:
            raise UsageError(
                f"--discs {discs} applies only when a new drive is sized: to change a copied design, use --set "
                f"gear.discs={discs}"
            )
        started = load_design(source or "pin", set_, ()).but(name=stem)
        files = {f"{stem}.toml": dump(started, reasons(source or "pin", started)).encode()}
        copied = {"figures": {}, "why": f"a copy of {source or 'pin'}"}
        return _write_designs(files, [copied], _claim_files(stem, delivery), delivery)
    if (ratio is None and not ratio_range) or diameter_mm is None or torque_nm is None:
        missing = " and ".join(flag for flag, value in asked.items() if value is None)
        verb = "are" if " and " in missing else "is"
        raise UsageError(
            f"{missing} {verb} missing: to size a new drive, give --ratio, --diameter-mm and --torque-nm together"
        )
    if source:
        raise UsageError(f"--from {source} copies a design, but --ratio sizes a new one: remove one of the two")
    if ratio is not None and ratio_range:
        raise UsageError(
            f"--ratio {ratio} and --ratio-range {ratio_range} cannot be used together: remove one of the two"
        )
    from cycloid_mj.sizing.answer import best_ratio
    from cycloid_mj.sizing.drives import size_drive
    from cycloid_mj.sizing.requirement import required

    low, high = _range(ratio_range) if ratio_range else (ratio or 0, ratio or 0)
    wanted = required(
        ratio=low,
        diameter_mm=diameter_mm,
        torque_nm=torque_nm,
        life_h=life_h,
        speed_rpm=_motor_speed(motor, torque_nm / low, process) if motor else speed_rpm,
        output_rpm=output_rpm,
        duty=duty or None,
        cooling=cooling,
        ambient_c=ambient_c,
        changes=set_,
        process=process,
        discs=_discs(discs),
        length_mm=length_mm,
        backlash_arcmin=backlash_arcmin,
        material=material,
        clearance_um=clearance_um,
        fit=fit,
        custom=custom,
    )
    if motor and (speed_rpm is not None or output_rpm is not None):
        raise UsageError("--motor determines the speed: remove --speed-rpm and --output-rpm, or remove --motor")
    if ratio_range:
        wanted = best_ratio(wanted, low, high)
    place = _claim_files(stem, delivery)
    with show_activity("searching for a drive", delivery.quiet):
        answer = size_drive(wanted, lambda found: None if delivery.quiet else tell(_best_so_far(found)))
    if answer.drives:
        return _sized_outcome(stem, answer, place, delivery)
    if delivery.json:
        refusal = _refusal(answer, wanted, bool(ratio_range))
        outcome = Outcome(title=f"no drive: {stem}", failures=[answer.refusal], result=refusal, filed=False, code=1)
        return deliver(outcome, place, delivery)
    best = f"of the ratios {ratio_range}, {wanted.ratio} allows the highest torque: " if ratio_range else ""
    raise DesignError(best + answer.refusal)


def _best_so_far(found: "Answer") -> str:
    """Return the first drive, the last remedy, or the largest torque of an unfinished search."""
    if found.drives:
        return f"found: {found.line}"
    if found.remedies:
        return f"feasible with {found.remedies[-1].words}"
    return f"largest torque found: {found.most:g} N m ({found.limit}); searching for changes that are feasible"


def _claim_files(stem: str, wanted: NewDelivery) -> Destination:
    """Claim the file of the design and the page, before the work."""
    into = folder(wanted.out or ".", "the designs", [f"{stem}.toml"], wanted.force)
    return Destination(stem, into, claim_page(wanted, stem, into))


def _sized_outcome(stem: str, answer: "Answer", place: Destination, wanted: NewDelivery) -> int:
    """Write the design files of the drives of an answer, and print them."""
    files: dict[str, bytes] = {}
    for number, drive in enumerate(answer.drives):
        title = f"{stem}-{drive.title.replace(' ', '-')}" if number else stem
        files[f"{title}.toml"] = dump(drive.design.but(name=title), drive.reasons).encode()
    about = [
        {"title": drive.title, "figures": dict(drive.figures), "why": drive.why, "reasons": drive.reasons}
        for drive in answer.drives
    ]
    heading = f"{answer.drives[0].figures['ratio']:.0f}:1, {answer.requirement.torque:g} N m"
    table = Table(heading, ("drive", *COLUMNS.values()), tuple(map(_row, answer.drives)))
    notes = [
        f"  {drive.title}{'' if number else ' (to be taken)'}: {drive.why}"
        for number, drive in enumerate(answer.drives)
    ]
    return _write_designs(files, about, place, wanted, [table], notes)


def _write_designs(
    files: Mapping[str, bytes],
    about: Sequence[Mapping[str, Any]],
    place: Destination,
    wanted: NewDelivery,
    tables: Sequence[Table] = (),
    summary: Sequence[str] = (),
) -> int:
    """Write design files, and print their paths."""
    paths = place.paths(files)
    claim(*map(Path, paths), force=wanted.force)
    outcome = Outcome(
        title=f"new design: {place.stem}",
        text=paths,
        tables=tables,
        summary=summary,
        files=files,
        result={"designs": [{"file": path} | dict(item) for path, item in zip(paths, about, strict=True)]},
        filed=False,
    )
    return deliver(outcome, place, wanted)


def _row(drive: "SizedDrive") -> tuple[str, ...]:
    from cycloid_mj.life.duration import format_life

    cells = {key: f"{drive.figures[key]:.3g}" for key in COLUMNS}
    return drive.title, *(cells | {"life_h": format_life(drive.figures["life_h"])}).values()


def _refusal(answer: "Answer", asked: "Requirement", ranged: bool) -> dict[str, Any]:
    ways = [{"words": way.words, "flags": _flags(way, asked, ranged)} for way in answer.remedies]
    return {"most": answer.most, "limit": answer.limit, "ways": ways, "why": answer.refusal}


def _flags(way: "FeasibleChange", asked: "Requirement", ranged: bool) -> list[str]:
    """Return the flags that request an alternative instead of the user's."""
    from cycloid_mj.base.units import RPM

    flags = {
        "diameter": ("--diameter-mm", 1e3 * way.requirement.diameter),
        "length": ("--length-mm", 1e3 * way.requirement.length),
        "life": ("--life-h", way.requirement.life),
        "duty_share": ("--duty", way.requirement.duty_share),
        "speed": ("--speed-rpm", way.requirement.speed / RPM),
        "film": ("--cooling", way.requirement.film),
        "clearance": ("--clearance-um", 1e6 * way.requirement.clearance),
        "fit": ("--fit", way.requirement.fit),
        "backlash": ("--backlash-arcmin", way.requirement.backlash),
        "discs": ("--discs", way.requirement.discs),
        "process": ("--process", way.requirement.process),
        "material": ("--material", way.requirement.material),
    }
    changed = [flags[key] for key in flags if getattr(way.requirement, key) != getattr(asked, key)]
    words = [word for flag, value in changed for word in (flag, value if isinstance(value, str) else f"{value:.10g}")]
    words += ["--ratio-range", f"{asked.ratio}:{asked.ratio}"] if ranged else []
    return [*words, "--custom"] if way.requirement.custom and not asked.custom else words


def _motor_speed(path: str, torque: float, process: "Process") -> float:
    """Return the largest speed [rpm] at which a motor, a frame or a curve in a CSV file, delivers a torque [N m]."""
    import csv

    from cycloid_mj.base.units import RPM
    from cycloid_mj.parts.export.motors import MOTORS
    from cycloid_mj.sizing.process import PROCESSES

    if (frame := MOTORS.get(path)) and frame.torque:
        if torque > frame.torque:
            raise UsageError(
                f"--motor {path}: the crank needs {torque:.4g} N m, but usual motors of this frame size have at most "
                f"{frame.torque:g} N m. Choose a larger frame, a larger ratio or less torque"
            )
        return min(PROCESSES[process].speed_rpm, frame.power / torque / RPM)
    try:
        with Path(path).open(newline="", encoding="utf-8-sig") as file:
            points = sorted((float(row["speed_rpm"]), float(row["torque_nm"])) for row in csv.DictReader(file))
    except (OSError, ValueError, KeyError, TypeError) as error:
        problem = reason(error) if isinstance(error, OSError) else "its rows are not pairs of speed and torque"
        raise UsageError(
            f"--motor {path}: {problem}. Choose one of {', '.join(key for key, one in MOTORS.items() if one.torque)}, "
            "or a CSV file with the columns speed_rpm and torque_nm"
        ) from error
    speeds = [speed for speed, delivered in points if delivered >= torque and speed > 0.0]
    for (low, more), (high, less) in itertools.pairwise(points):
        if less < torque <= more and more > less:
            speeds.append(low + (high - low) * (more - torque) / (more - less))
    if not speeds:
        most = max((delivered for _, delivered in points), default=0.0)
        raise UsageError(
            f"--motor {path}: the motor cannot deliver the {torque:.4g} N m that the crank needs at any speed (its "
            f"maximum is {most:.4g} N m). Choose a stronger motor, a larger ratio or less torque"
        )
    return max(speeds)


def _range(text: str) -> tuple[int, int]:
    """Read a range of ratios."""
    match = re.fullmatch(r"(\d+):(\d+)", text)
    if not match:
        raise UsageError(f"--ratio-range {text!r} is not a range: give LOW:HIGH, two integers, e.g. 18:22")
    return int(match[1]), int(match[2])


def _discs(text: str) -> int:
    """Read a number of discs; 0 for auto."""
    if text == "auto":
        return 0
    if not text:
        return 1
    try:
        number = whole_number(text)
    except ValueError as error:
        raise UsageError(f"--discs: {error}; give a number from 1 to 4, or auto") from None
    if number < 1:
        raise UsageError(f"--discs {number} is out of range: give a number from 1 to 4, or auto")
    return number
