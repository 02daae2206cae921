"""``cycloid-mj design new``: write a design file from a preset, or find drives for a requirement."""

import itertools
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, cast

from cyclopts import Parameter

from cycloid_mj.base.errors import DesignError, UsageError, reason
from cycloid_mj.base.outcome import Outcome
from cycloid_mj.base.overwrite_guard import claim_outputs
from cycloid_mj.base.result import Table
from cycloid_mj.cli.delivery import Destination, claim_page, deliver
from cycloid_mj.cli.flags import (
    FLAT,
    NAMES,
    Delivery,
    SetFlag,
    integer_flag,
    load_design,
    out_flag,
    whole_number,
)
from cycloid_mj.cli.outfile import claim_folder
from cycloid_mj.cli.progress import show_activity
from cycloid_mj.cli.terminal import tell
from cycloid_mj.design import PRESETS, dump, dump_short, preset_reasons
from cycloid_mj.design.file import preset

if TYPE_CHECKING:
    from cycloid_mj.parts.export.motors import MotorName
    from cycloid_mj.sizing.answer import Answer, FeasibleChange, SizedDrive
    from cycloid_mj.sizing.requirement import Requirement

NewName = Annotated[
    str, Parameter(metavar="NAME", help="Name of the new design and of its runs; the file is NAME.toml.")
]
FromFlag = Annotated[
    str, Parameter(name="--from", metavar="NAME|FILE", help=f"Design to copy: a preset ({NAMES}) or a TOML file.")
]
RatioFlag = Annotated[
    int | None,
    integer_flag("Reduction ratio of a new drive, an integer; the ring has one pin more."),
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
        "whose largest torque becomes --torque-nm. Default: 1; 0.25 for printed drives; 0.4 for --layout rv.",
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
        help="Motor frame (nema17, nema23, nema34), bolt pattern (bldc16, bldc19, bldc25), or CSV file of a motor's "
        "torque curve with the columns speed_rpm and torque_nm. The crank turns at the highest speed at which the "
        "motor delivers the required torque, unless a lower speed is set. A frame is assumed to have the usual power "
        "of its size, and its speed is at most the default speed. Its shaft fits into the crank. A bolt pattern "
        "limits neither speed nor torque.",
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
ShortFlag = Annotated[
    bool,
    Parameter(
        negative=(),
        help="Write only name, number of teeth, pin circle and the values of --set; all other values are those of the "
        "preset, with its lengths scaled to the pin circle ([base] scaled).",
    ),
]

LayoutFlag = Annotated[
    Literal["central", "rv"],
    Parameter(
        help="Layout of a new drive: one central crank, or rv, an RV reducer with a planetary stage. Default: central."
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
    "rated_torque_nm": "rated torque [N m]",
    "momentary_torque_nm": "momentary torque [N m]",
    "life_h": "life [h]",
    "temperature_c": "housing [°C]",
    "stiffness_nm_per_arcmin": "stiffness [N m/arcmin]",
    "backlash_arcmin": "backlash [arcmin]",
    "yield_percent": "yield [%]",
}
"""Figures of a shortlist -> headings of its table."""


@dataclass(frozen=True, kw_only=True)
class SizeFlags:
    """Requirements that a new drive is sized for."""

    layout: LayoutFlag = "central"
    ratio: RatioFlag = None
    ratio_range: RatioRangeFlag = ""
    diameter_mm: DiameterFlag = None
    length_mm: LengthFlag = None
    torque_nm: TorqueFlag = None
    life_h: LifeFlag = None
    speed_rpm: SpeedFlag = None
    output_rpm: OutputSpeedFlag = None
    duty: DutyFlag = ""
    cooling: CoolingFlag = "still"
    ambient_c: AmbientFlag = 20.0
    motor: MotorFlag = ""
    backlash_arcmin: BacklashFlag = None
    process: ProcessFlag = "steel"
    material: MaterialFlag = ""
    clearance_um: ClearanceFlag = None
    fit: FitFlag = ""
    custom: CustomFlag = False
    discs: DiscsFlag = ""

    @property
    def missing(self) -> tuple[str, ...]:
        """Return the names of those flags among --ratio, --diameter-mm and --torque-nm that are not set.

        A size needs all three; a command that sets none of them copies a design.
        """
        values = {
            "--ratio": self.ratio_range or self.ratio,
            "--diameter-mm": self.diameter_mm,
            "--torque-nm": self.torque_nm,
        }
        return tuple(flag for flag, value in values.items() if value is None)

    @property
    def changed(self) -> tuple[str, ...]:
        """Return the names of all flags whose value is not the default."""
        return tuple(
            f"--{field.name.replace('_', '-')}" for field in fields(self) if getattr(self, field.name) != field.default
        )

    def requirement(self, changes: tuple[str, ...]) -> "Requirement":
        """Return the requirement that the flags describe; `changes` are the values of ``--set``.

        With ``--ratio-range``, the requirement has the ratio of this range with the largest estimated torque.

        Raises
        ------
        UsageError
            A required flag is missing, or flags contradict each other.
        """
        from cycloid_mj.sizing.requirement import Requirement, make_requirement
        from cycloid_mj.sizing.solve import best_ratio

        if self.missing or self.diameter_mm is None or self.torque_nm is None:
            raise UsageError(
                f"{' and '.join(self.missing)} {'are' if len(self.missing) > 1 else 'is'} missing: to size a new "
                "drive, give --ratio, --diameter-mm and --torque-nm together"
            )
        if self.ratio is not None and self.ratio_range:
            raise UsageError(
                f"--ratio {self.ratio} and --ratio-range {self.ratio_range} cannot be used together: remove one of the "
                "two"
            )
        duty: str | float | None = self.duty or None
        output_rpm, kind = None if self.motor else self.output_rpm, Requirement
        if self.layout == "rv":
            from cycloid_mj.sizing.rv import DUTY_SHARE, OUTPUT_RPM, RvRequirement

            self._refuse_unsupported_flags()
            kind, duty = RvRequirement, duty or DUTY_SHARE
            if self.speed_rpm is None and self.output_rpm is None:
                output_rpm = OUTPUT_RPM
        low, high = _parse_ratio_range(self.ratio_range) if self.ratio_range else (self.ratio or 0, self.ratio or 0)
        requirement = make_requirement(
            ratio=low,
            diameter_mm=self.diameter_mm,
            torque_nm=self.torque_nm,
            life_h=self.life_h,
            speed_rpm=self._crank_speed(low),
            output_rpm=output_rpm,
            duty=duty,
            cooling=self.cooling,
            ambient_c=self.ambient_c,
            motor=_frame(self.motor),
            changes=changes,
            process=self.process,
            discs=_parse_discs(self.discs),
            length_mm=self.length_mm,
            backlash_arcmin=self.backlash_arcmin,
            material=self.material,
            clearance_um=self.clearance_um,
            fit=self.fit,
            custom=self.custom,
            kind=kind,
        )
        return best_ratio(requirement, low, high) if self.ratio_range else requirement

    def _refuse_unsupported_flags(self) -> None:
        """Raise UsageError for a flag that the search for RV reducers does not support."""
        for flag in self.changed:
            if flag in UNSUPPORTED_BY_RV:
                raise UsageError(f"--layout rv does not support {flag}: remove {flag}")

    def _crank_speed(self, ratio: int) -> float | None:
        """Return the required crank speed [rpm] at a ratio; None if no speed is required and no motor is set.

        With a motor and no required speed, it is the largest speed at which the motor delivers the torque. If the motor
        is a frame size, the speed is limited to the usual crank speed of the manufacturing process. Raises UsageError
        if the motor is too weak, or too slow.
        """
        if not self.motor or ratio < 1 or not self.torque_nm or not 0.0 < self.torque_nm < math.inf:
            return self.speed_rpm  # the check of the requirement reports the wrong ratio or torque
        from cycloid_mj.design.processes import PROCESSES

        torque = self.torque_nm / ratio
        max_speed = _motor_speed(self.motor, torque)
        required_speed = self.output_rpm * ratio if self.output_rpm is not None else self.speed_rpm
        if required_speed is not None and required_speed > max_speed * (1.0 + 1e-9):
            raise UsageError(
                f"--motor {self.motor} delivers {torque:.4g} N m only up to a crank speed of {max_speed:.4g} rpm, but "
                f"{required_speed:.4g} rpm is required: reduce --speed-rpm or --output-rpm, or choose another motor"
            )
        speed_limit = PROCESSES[self.process].speed_rpm if _frame(self.motor) != "auto" else max_speed
        return min(max_speed, speed_limit) if required_speed is None else required_speed


SIZE = SizeFlags()

UNSUPPORTED_BY_RV = frozenset(
    {"--ratio-range", "--motor", "--backlash-arcmin", "--process", "--material", "--fit", "--custom", "--discs"}
)
"""Flags for a new drive that the search for RV reducers does not support."""


def new(
    name: NewName,
    /,
    *,
    source: FromFlag = "",
    short: ShortFlag = False,
    size: Annotated[SizeFlags, FLAT] = SIZE,
    set_: SetFlag = (),
    output_flags: Annotated[NewDelivery, FLAT] = DELIVERED,
) -> int:
    """Create NAME.toml, a complete, commented design file to edit.

    It is a copy of a preset or a file (--from; default: pin), a short file to extend (--short), or the result of a
    search from requirements: ratio, outer diameter and torque together, and optionally life, speed, length, backlash,
    material and clearance. The search varies pins, eccentricity, width, output pins, bore and shaft, and evaluates each
    drive by statics and the checks of `cycloid-mj rate`. The data sheet of each resulting drive meets the requirements,
    and in its tolerance study, at least 99 % of the samples turn freely and have the required backlash. NAME.toml is
    the drive with the lowest losses among those within 2 % of the lowest mass, covers included; comments give the
    reason for each value. The stiffest and the longest-lived drive are NAME-stiffest.toml and NAME-longest-life.toml.
    If no drive meets the requirements, the maximum torque and verified alternatives are printed, and the exit code is
    1. Changes by --set apply to every drive that the search tries. 3-D-printed drives are sized for 500 h at 300 rpm
    and 25 % of the time unless set otherwise.

    The search considers drives with one stage, one central crank, pins (or lobes) in the ring, and one lobe fewer on
    the disc. With --layout rv, it searches for an RV reducer with a planetary stage and two discs whose teeth can be
    assembled, and rates its crank bearings and widths by `cycloid-mj rate`. Its speed is that of the sun (default: 15
    rpm of the output). Tooth differences of 2 or more, and hypocycloid drives with the pins on the disc are not
    supported.
    """
    stem = _file_stem(name)
    if len(size.missing) == 3:
        return _copy_design(stem, source or "pin", size.changed, set_, short, output_flags)
    if short:
        raise UsageError("--short copies a preset, whereas --ratio sizes a new drive: remove one of the two flags")
    if source and not size.missing:
        raise UsageError(
            f"--from {source} copies a design, whereas --ratio sizes a new drive: remove one of the two flags"
        )
    requirement = size.requirement(set_)
    destination = _claim_files(stem, output_flags)
    with show_activity("searching for a drive", output_flags.quiet):
        answer = _size_drive(requirement, lambda drives: None if output_flags.quiet else tell(_best_so_far(drives)))
    if answer.drives:
        return _deliver_drives(stem, answer, destination, output_flags)
    if output_flags.json:
        refusal_json = _refusal_json(answer, requirement, bool(size.ratio_range))
        outcome = Outcome(
            title=f"no drive: {stem}", failures=[answer.refusal], result=refusal_json, filed=False, code=1
        )
        return deliver(outcome, destination, output_flags)
    ratio_text = f"of the ratios {size.ratio_range}, {requirement.ratio} allows the highest torque: "
    raise DesignError((ratio_text if size.ratio_range else "") + answer.refusal)


def _size_drive(requirement: "Requirement", on_progress: "Callable[[Answer], None]") -> "Answer":
    """Search for drives of the required layout that meet a requirement; return them, or feasible alternatives.

    `on_progress` is called with each intermediate result.
    """
    from cycloid_mj.sizing.drives import size_drive
    from cycloid_mj.sizing.rv import RvRequirement, size_rv

    if isinstance(requirement, RvRequirement):
        return size_rv(requirement, on_progress)
    return size_drive(requirement, on_progress)


def _file_stem(name: str) -> str:
    """Return the name of a new design without ``.toml``.

    Raises UsageError if it cannot be the name of a file, or is that of a preset.
    """
    stem = name.removesuffix(".toml")
    if not re.fullmatch(r"\w[\w .-]{0,63}", stem):
        raise UsageError(
            f"NAME {name!r} is not allowed: use at most 64 characters (letters, digits, spaces, '.', '_' and '-'), "
            "e.g. my_drive"
        )
    if stem in PRESETS:
        raise UsageError(f"NAME {name!r} is the name of a preset: choose another name, e.g. my-{stem}")
    return stem


def _copy_design(
    stem: str,
    source: str,
    size_flags: Sequence[str],
    changes: tuple[str, ...],
    short: bool,
    output_flags: NewDelivery,
) -> int:
    """Write a copy of a preset or a file, `source`, with the `changes` of ``--set``; return the exit code 0.

    `stem` is the name of the copy without ending, `output_flags` are those of the output (``--out``, ``--quiet``), and
    `size_flags` are names of flags for a new drive. With `short`, the copy of a preset lists few of its values. Raises
    UsageError if a flag for a new drive is set, or `short` with a file.
    """
    if size_flags:
        raise UsageError(
            f"{' and '.join(size_flags)} {'apply' if len(size_flags) > 1 else 'applies'} only when a new drive is "
            "sized: add --ratio, --diameter-mm and --torque-nm; or to copy a design, choose it with --from and change "
            "its values with --set"
        )
    design = load_design(source, changes, ()).but(name=stem)
    if short and not preset(source):
        raise UsageError(f"--short requires a preset (--from {NAMES}), but --from is {source}: remove --short")
    changed_keys = {change.partition("=")[0].strip() for change in changes}
    text = dump_short(design, source, changed_keys) if short else dump(design, preset_reasons(source, design))
    files = {f"{stem}.toml": text.encode()}
    return _write_designs(
        files, [{"figures": {}, "why": f"a copy of {source}"}], _claim_files(stem, output_flags), output_flags
    )


def _best_so_far(answer: "Answer") -> str:
    """Return a line on the state of a search: its first drive, its last remedy, or the largest torque so far."""
    if answer.drives:
        return f"found: {answer.line}"
    if answer.remedies:
        return f"feasible with {answer.remedies[-1].words}"
    return f"largest torque found: {answer.most:g} N m ({answer.limit}); searching for changes that are feasible"


def _claim_files(stem: str, output_flags: NewDelivery) -> Destination:
    """Claim the files of the design and of the page before the work; raise TakenError if one exists."""
    directory = claim_folder(output_flags.out or ".", "the designs", [f"{stem}.toml"], output_flags.force)
    return Destination(stem, directory, claim_page(output_flags, stem, directory))


def _deliver_drives(stem: str, answer: "Answer", destination: Destination, output_flags: NewDelivery) -> int:
    """Write the design files of the drives of a search, print them in a table, and return the exit code 0.

    `answer` has the drives, `destination` the folder, and `output_flags` those of the output, such as ``--quiet``. The
    file of the first drive is `stem`.toml. Files of other drives have the drive's title after the stem.
    """
    files: dict[str, bytes] = {}
    for index, drive in enumerate(answer.drives):
        drive_stem = f"{stem}-{drive.title.replace(' ', '-')}" if index else stem
        files[f"{drive_stem}.toml"] = dump(drive.design.but(name=drive_stem), drive.reasons).encode()
    descriptions = [
        {"title": drive.title, "figures": dict(drive.figures), "why": drive.why, "reasons": drive.reasons}
        for drive in answer.drives
    ]
    heading = f"{answer.drives[0].figures['ratio']:.0f}:1, {answer.requirement.torque:g} N m"
    columns = [text for key, text in COLUMNS.items() if key in answer.drives[0].figures]
    table = Table(heading, ("drive", *columns), tuple(map(_tabulate_drive, answer.drives)))
    reasons_for_choice = [
        f"  {drive.title}{'' if index else ' (default)'}: {drive.why}" for index, drive in enumerate(answer.drives)
    ]
    return _write_designs(files, descriptions, destination, output_flags, [table], reasons_for_choice)


def _write_designs(
    files: Mapping[str, bytes],
    descriptions: Sequence[Mapping[str, Any]],
    destination: Destination,
    output_flags: NewDelivery,
    tables: Sequence[Table] = (),
    summary: Sequence[str] = (),
) -> int:
    """Write design files, print their paths with tables and summary, and return the exit code 0.

    `files` maps names to contents. `descriptions` has the values that the JSON result states for each file.
    `destination` has the folder, `output_flags` those of the output, such as ``--quiet``. Raises TakenError if a file
    exists and must not be replaced.
    """
    paths = destination.paths(files)
    claim_outputs(*map(Path, paths), force=output_flags.force)
    outcome = Outcome(
        title=f"new design: {destination.stem}",
        text=paths,
        tables=tables,
        summary=summary,
        files=files,
        result={"designs": [{"file": path} | dict(item) for path, item in zip(paths, descriptions, strict=True)]},
        filed=False,
    )
    return deliver(outcome, destination, output_flags)


def _tabulate_drive(drive: "SizedDrive") -> tuple[str, ...]:
    """Format title and figures of a drive for the columns of `COLUMNS`."""
    from cycloid_mj.life.duration import format_life

    cells = {key: f"{drive.figures[key]:.3g}" for key in COLUMNS if key in drive.figures}
    return drive.title, *(cells | {"life_h": format_life(drive.figures["life_h"])}).values()


def _refusal_json(answer: "Answer", requirement: "Requirement", is_range: bool) -> dict[str, Any]:
    """Convert a search without a drive to JSON values: the largest torque, its limit, and the remedies with flags."""
    remedies = [
        {"words": remedy.words, "flags": _list_flags(remedy, requirement, is_range)} for remedy in answer.remedies
    ]
    return {"most": answer.most, "limit": answer.limit, "ways": remedies, "why": answer.refusal}


def _list_flags(remedy: "FeasibleChange", original: "Requirement", is_range: bool) -> list[str]:
    """Return the flags that change the `original` requirement to a feasible requirement, the `remedy`.

    Each flag is followed by its new value. If the ratio was chosen from a range (`is_range`),
    ``--ratio-range`` with the chosen ratio alone is added.
    """
    from cycloid_mj.sizing.requirement import QUANTITIES

    changed_requirement = remedy.requirement
    values = {quantity.flag: (key, quantity.scale) for key, quantity in QUANTITIES.items()}
    values |= {f"--{key}": (key, 1.0) for key in ("fit", "discs", "process", "material")}
    flag_words = []
    for flag, (key, scale) in values.items():
        if (value := getattr(changed_requirement, key)) != getattr(original, key):
            flag_words += [flag, value if isinstance(value, str) else f"{value / scale:.10g}"]
    flag_words += ["--ratio-range", f"{original.ratio}:{original.ratio}"] if is_range else []
    return [*flag_words, "--custom"] if changed_requirement.custom and not original.custom else flag_words


def _frame(motor: str) -> "MotorName":
    """Return the name of a motor frame; auto for a file with a motor's curve, which has no dimensions."""
    from cycloid_mj.parts.export.motors import MOTORS

    return cast("MotorName", motor) if motor in MOTORS else "auto"


def _motor_speed(motor: str, torque: float) -> float:
    """Return the largest speed [rpm] at which a motor delivers a torque [N m].

    `motor` is the name of a frame or bolt pattern, or a CSV file with the motor's curve, which is interpolated
    linearly. Motors of a bolt pattern differ too much for a limit: the result is infinite. Raises UsageError if the
    file cannot be read, or the motor is too weak.
    """
    import csv

    from cycloid_mj.base.units import RPM
    from cycloid_mj.parts.export.motors import MOTORS

    frame = MOTORS.get(motor)
    if frame and not frame.torque:
        return math.inf
    if frame:
        if torque > frame.torque:
            raise UsageError(
                f"--motor {motor}: the crank needs {torque:.4g} N m, but motors of this frame size typically deliver "
                f"at most {frame.torque:g} N m. Choose a larger frame, a larger ratio or less torque"
            )
        return frame.power / torque / RPM
    try:
        with Path(motor).open(newline="", encoding="utf-8-sig") as file:
            curve = sorted((float(row["speed_rpm"]), float(row["torque_nm"])) for row in csv.DictReader(file))
        if not curve or not all(map(math.isfinite, itertools.chain(*curve))):
            raise ValueError(motor)
    except (OSError, ValueError, KeyError, TypeError) as error:
        problem = reason(error) if isinstance(error, OSError) else "it has no rows of finite speed and torque"
        frame_text = ", ".join(MOTORS)
        raise UsageError(
            f"--motor {motor}: {problem}. Choose one of {frame_text}, or a CSV file with the columns speed_rpm and "
            "torque_nm"
        ) from error
    speeds = [
        previous_speed
        for previous_speed, available_torque in curve
        if available_torque >= torque and previous_speed > 0.0
    ]
    for (previous_speed, previous_torque), (next_speed, next_torque) in itertools.pairwise(curve):
        if next_torque < torque <= previous_torque:
            speeds.append(
                previous_speed
                + (next_speed - previous_speed) * (previous_torque - torque) / (previous_torque - next_torque)
            )
    if not speeds:
        max_torque = max(available_torque for _, available_torque in curve)
        raise UsageError(
            f"--motor {motor}: the crank needs {torque:.4g} N m, but the motor delivers at most {max_torque:.4g} N m "
            "at any speed. Choose a stronger motor, a larger ratio or less torque"
        )
    return max(speeds)


def _parse_ratio_range(text: str) -> tuple[int, int]:
    """Parse a range of ratios, ``LOW:HIGH``; raise UsageError for any other text."""
    match = re.fullmatch(r"(\d+):(\d+)", text)
    if not match:
        raise UsageError(f"--ratio-range {text!r} is not a range: give LOW:HIGH, two integers, e.g. 18:22")
    return int(match[1]), int(match[2])


def _parse_discs(text: str) -> int:
    """Parse the text of ``--discs``: a number; 1 for an empty text, 0 for ``auto``. Raise UsageError for any other."""
    if text == "auto":
        return 0
    if not text:
        return 1
    try:
        disc_count = whole_number(text)
    except ValueError as error:
        raise UsageError(f"--discs: {error}; give a number from 1 to 4, or auto") from None
    if disc_count < 1:
        raise UsageError(f"--discs {disc_count} is out of range: give a number from 1 to 4, or auto")
    return disc_count
