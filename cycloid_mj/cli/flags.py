"""Flags that several subcommands share: the design, values of the design with its own limits, a point of the gear."""

import math
import operator
from collections.abc import Callable, Iterable, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Annotated, Any, Literal

from cyclopts import Parameter, Token
from pydantic.fields import FieldInfo

from cycloid_mj.base.engine import Engine
from cycloid_mj.base.errors import DesignError, UsageError, warn
from cycloid_mj.cli.ranges import RANGES
from cycloid_mj.design import PRESETS, Design, Inheritance, find_inheritance, override, resolve
from cycloid_mj.design.model import HEATED
from cycloid_mj.design.units import BOUNDS, Unit, bounds_of, file_key, unit_of
from cycloid_mj.reducer import reducer_of

SYMBOLS = {"nm": "N m", "c": "°C"}

NAMES = ", ".join(PRESETS)
"""The presets, for help."""

DesignFlag = Annotated[
    str,
    Parameter(
        name="--design",
        metavar="NAME|FILE",
        help=f"Design: a preset ({NAMES}) or a TOML file; --design itself can be omitted.",
    ),
]
PresetFlag = Annotated[
    str,
    Parameter(
        name="--design",
        metavar="NAME|FILE",
        help=f"Design: a preset ({NAMES}) or a TOML file; --design itself can be omitted. Default: pin.",
    ),
]
DesignNames = Annotated[str, Parameter(metavar="NAME|FILE...", help=f"Designs: presets ({NAMES}) or TOML files.")]
SeveralFlag = Annotated[
    tuple[str, ...],
    Parameter(
        name="--design",
        metavar="NAME|FILE",
        consume_multiple=True,
        help="Designs, as an alternative to positional arguments. Repeatable.",
    ),
]
"""Flags of a command that takes several designs by position (`DesignNames`)."""

SetFlag = Annotated[
    tuple[str, ...],
    Parameter(
        name="--set",
        metavar="TABLE.KEY=VALUE",
        help="Change of one value of the design, named as in the design file, e.g. load.torque_nm=36. Repeatable.",
    ),
]
PointFlag = Annotated[
    str | None,
    Parameter(
        name="--q",
        metavar="X,Y",
        allow_leading_hyphen=True,
        help="Point q of the disc [mm], in the disc's frame, e.g. 26,0 or -3,4.5. Default: the centre of the "
        "hole on +y.",
    ),
]
JsonFlag = Annotated[bool, Parameter(name="--json", help="Print one JSON object on stdout, and nothing else.")]
ForceFlag = Annotated[
    bool,
    Parameter(
        name="--force",
        help="Overwrite existing results (never an input of this command or a file of another type).",
    ),
]
AllFlag = Annotated[bool, Parameter(name="--all", help="Print all tables and notes, not only the headline.")]
QuietFlag = Annotated[bool, Parameter(name="--quiet", help="Print errors only on stderr, no progress and no warnings.")]
"""`cycloid_mj.cli.app.main` keeps back what `note` writes, and warnings."""
HtmlFlag = Annotated[
    tuple[str, ...] | None,
    Parameter(
        name="--html",
        metavar="[FILE]",
        consume_multiple=True,
        help="Write an HTML page. Default of FILE: a page named after the design or the command, in the "
        "folder of --out or in runs.",
    ),
]
FollowFlag = Annotated[
    tuple[str, ...],
    Parameter(
        name="--follow",
        metavar="KEY=FORMULA",
        help="Key computed from the varied keys by a formula of numbers, keys, + - * / and parentheses: "
        "'output.hole_radius_mm=output.pin_radius_mm+gear.eccentricity_mm'. Without a formula, "
        "output.hole_radius_mm keeps the clearance around its pin, and drive.torque_nm keeps the rated "
        "torque on the output. Repeatable.",
    ),
]

FLAT = Parameter(name="*")
"""Marks a dataclass whose fields are flags of the command."""


def whole(_: Any, tokens: Sequence[Token]) -> int:
    """Convert the token of an integer flag; cyclopts itself would round 1.5 to 2."""
    return whole_number(tokens[0].value)


def whole_number(text: str) -> int:
    """Parse an integer; raise ValueError that names the nearest integers for any other text."""
    try:
        return int(text)
    except ValueError:
        raise ValueError(f"{text!r} is not a whole number{_suggest_integers(text)}") from None


def _suggest_integers(text: str) -> str:
    """Return a hint with the nearest integers of a number; empty for other text."""
    try:
        lower_integer, upper_integer = math.floor(float(text)), math.ceil(float(text))
    except (ValueError, OverflowError):
        return ""
    return f"; give {lower_integer}" if lower_integer == upper_integer else f"; give {lower_integer} or {upper_integer}"


def within(low: float, high: float) -> Callable[[Any, Any], None]:
    """Return a validator for Cyclopts that raises ValueError for a flag's value outside of `low` to `high`.

    Both ends, and None, are accepted.
    """

    def require(_: Any, value: float | None) -> None:
        if value is not None and not low <= value <= high:
            raise ValueError(f"must be from {low:.10g} to {high:.10g}")

    return require


def integer_flag(text: str, limits: tuple[int, int] | None = None, name: str | None = None) -> Parameter:
    """Declare a flag with an integer value within both limits; `text` is its help, `name` by default that in Python."""
    return Parameter(name=name, metavar="N", converter=whole, validator=within(*limits) if limits else None, help=text)


def number_flag(text: str, limits: tuple[float, float], name: str | None = None, metavar: str = "X") -> Parameter:
    """Declare a flag with a real value within both limits; `text` is its help, `name` by default that in Python."""
    is_signed = limits[0] < 0.0
    return Parameter(name=name, metavar=metavar, allow_leading_hyphen=is_signed, validator=within(*limits), help=text)


WorkersFlag = Annotated[
    int | None,
    integer_flag("Number of parallel workers. Default: number of CPU cores.", RANGES.workers),
]


@dataclass(frozen=True)
class DesignValue:
    """A flag that sets the value `table`.`name` of the design, with the limits of the design file."""

    table: str
    name: str
    nonzero: bool = False
    positive: bool = False

    @property
    def field(self) -> FieldInfo:
        """The declaration of the value."""
        section: Any = Design.model_fields[self.table].annotation
        field: FieldInfo = section.model_fields[self.name]
        return field

    @property
    def unit(self) -> Unit:
        """The unit of the flag and of the file."""
        return unit_of(self.field)

    @property
    def symbol(self) -> str:
        """The unit as it is written."""
        return SYMBOLS.get(self.unit.suffix, self.unit.suffix)

    @property
    def key(self) -> str:
        """The key in the design file, e.g. ``drive.speed_rpm``."""
        return f"{self.table}.{file_key(self.name, self.field)}"

    @property
    def range(self) -> str:
        """The limits in words, in the file's unit."""
        words = [f"{BOUNDS[side]} {self.unit.from_si(bound):.10g}" for side, bound in self._bounds.items()]
        return " and ".join(words) + (", not 0" if self.nonzero else "")

    def require(self, value: float | None) -> None:
        """Raise ValueError with the limits if a value [file's unit] is out of range; None is accepted."""
        if value is None:
            return
        si_value = self.unit.to_si(value)
        in_range = all(getattr(operator, comparison)(si_value, bound) for comparison, bound in self._bounds.items())
        if not (in_range and math.isfinite(si_value) and (si_value or not self.nonzero)):
            raise ValueError(f"must be {self.range} [{self.symbol}]")

    def flag(self, text: str, ending: str = "", name: str | None = None) -> Parameter:
        """Return the declaration of this value's command-line flag, whose help states meaning, unit and limits.

        `text` is the meaning; `ending` follows the limits (default: the value of the design). `name` is the flag's
        name, by default that of the Python argument.
        """
        default_text = f". Default: {self.key} of the design ({self.unit.from_si(self.field.default):g} for pin)."
        help_text = f"{text} [{self.symbol}], {self.range}{ending or default_text}"
        return Parameter(name=name, metavar="X", help=help_text, validator=self.require)

    @property
    def _bounds(self) -> dict[str, float]:
        """The limits [SI]; those of a positive value are 0 and the upper one."""
        bounds = bounds_of(self.field)
        if not self.positive:
            return bounds
        return {"gt": 0.0} | {side: bound for side, bound in bounds.items() if side in ("lt", "le")}


TIMESTEP = DesignValue("settings", "timestep")
SPEED = DesignValue("drive", "speed", nonzero=True)
RAMP = DesignValue("drive", "ramp")
HOLD = DesignValue("drive", "hold")
LOAD = DesignValue("load", "torque")
LOADED = DesignValue("load", "torque", positive=True)
"""The same for what is computed under a load alone."""
TemperatureFlag = Annotated[
    float | None,
    DesignValue("thermal", HEATED[0]).flag(
        "Temperature of all parts",
        "; dimensions are valid at 20. Single parts: --set thermal.disc_c.",
        name="--at-c",
    ),
]

RATED = "nominal torque, drive.torque_nm times the ratio (36.68 of pin)"
STEP = "; 0: the longest step at which the results are accurate"


MOTOR_TORQUE = "drive.torque_nm"
"""Key of the torque of the motor."""

Values = Sequence[tuple[DesignValue, float | None]]
"""Values of the design that flags set; None where the flag is absent."""


def load_design(name_or_file: str, changes: Sequence[str], values: Values, temperature: float | None = None) -> Design:
    """Return the design of a command line: a file or preset, changed by ``--set``, then by other flags.

    A preload that is stated as a torque is converted to an angle by statics. A warning is issued if the temperatures
    are outside the range of the lubricant.

    Parameters
    ----------
    name_or_file
        Name of a preset, or path of a design file.
    changes
        Texts of ``--set``, such as ``ring.teeth=36``.
    values
        Pairs of a design value and the number that another flag sets for it [file's unit]; None if it is not set.
    temperature
        Temperature of all parts [°C], before ``--set`` changes single parts.

    Raises
    ------
    UsageError
        There is no such design, or it does not accept a change.
    DesignError
        The file is not a valid design.
    """
    design = resolve(name_or_file)
    try:
        if temperature is not None:
            design = override(design, [f"thermal.{part}_c={temperature!r}" for part in HEATED])
        design = override(design, changes)
    except DesignError as error:
        raise UsageError(error.message, error.details) from error
    design = override(design, [f"{quantity.key}={value!r}" for quantity, value in values if value is not None])
    if design.has_film:
        from cycloid_mj.design.lubricants import lubricant_warnings

        warn(design.name, lubricant_warnings(design))
    if not design.ring.preload_torque:
        return design
    from cycloid_mj.statics.preload import preloaded

    return preloaded(design)


@dataclass(frozen=True)
class DesignOptions:
    """The design of a command, by position or by ``--design``, and its changes."""

    design: DesignFlag
    _: KW_ONLY
    set_: SetFlag = ()
    at_c: TemperatureFlag = None

    def resolve(self, values: Values = ()) -> Design:
        """Return the design, with `values` of other flags; see `load_design` for the errors."""
        return load_design(self.design, self.set_, values, self.at_c)

    def resolve_checked(self, values: Values = ()) -> Design:
        """Return the design after its checks; raise DesignError if one fails.

        `values` are pairs of a design value and the number that another flag sets for it, or None.
        """
        from cycloid_mj.checks import require_sound

        design = self.resolve(values)
        try:
            require_sound(reducer_of(design))
        except DesignError as error:
            inheritance = self.inheritance()
            raise DesignError(error.message, (*error.details, *(inheritance.remedy if inheritance else ()))) from error
        self.warn_of_inherited_motor(design)
        return design

    def inheritance(self) -> Inheritance | None:
        """Return what the design takes from a preset; None for a preset."""
        return find_inheritance(self.design, self.set_)

    def warn_of_inherited_motor(self, design: Design) -> None:
        """Warn if the design file states neither motor torque nor load, so that the motor of its preset applies."""
        inheritance = self.inheritance()
        if inheritance and MOTOR_TORQUE in inheritance.motor:
            warn(
                design.name,
                [
                    f"the nominal torque of {design.rated_torque:.4g} N m is that of the motor of the preset "
                    f"{inheritance.preset}, {design.drive.torque:.4g} N m times the ratio, because {self.design} "
                    "states "
                    f'neither {MOTOR_TORQUE} nor load.torque_nm: set one, or [base] preset = "{inheritance.preset}"'
                ],
            )


@dataclass(frozen=True)
class PresetOptions(DesignOptions):
    """The same; the preset pin, unless something else is chosen."""

    design: PresetFlag = "pin"


PRESET = PresetOptions()


def out_flag(files: str, default_folder: str = "") -> Parameter:
    """Declare ``--out``: the folder of `files`, by default `default_folder`, or none."""
    default_text = f"Default: {default_folder}." if default_folder else "Default: no files are written."
    return Parameter(metavar="DIR", help=f"Folder of {files}; it is created if it does not exist. {default_text}")


@dataclass(frozen=True, kw_only=True)
class CommonFlags:
    """Output flags of every command."""

    html: HtmlFlag = None
    json: JsonFlag = False
    all: AllFlag = False
    force: ForceFlag = False
    quiet: QuietFlag = False
    workers: WorkersFlag = None


COMMON = CommonFlags()


@dataclass(frozen=True, kw_only=True)
class Delivery(CommonFlags):
    """The same, and the folder of the results; commands that make one file have ``--out`` for its name."""

    out: Annotated[str | None, out_flag("the results as JSON and CSV")] = None


DELIVERY = Delivery()


@dataclass(frozen=True, kw_only=True)
class ClusterDelivery(Delivery):
    """The same for many pieces of work, which may be done elsewhere."""

    scheduler: Annotated[
        str | None,
        Parameter(
            metavar="HOST:PORT",
            help="Address of the scheduler of a Dask cluster that does the work; its workers need the same "
            "package versions. Requires pip install 'cycloid-mj[cluster]'.",
        ),
    ] = None

    def engine(self, kind: Literal["processes", "threads"] = "processes") -> Engine:
        """Return the engine that runs the tasks of the command: workers of this machine, of `kind`, or a Dask cluster.

        Raises
        ------
        UsageError
            ``--workers`` and ``--scheduler`` are both set.
        """
        if self.workers and self.scheduler is not None:
            raise UsageError(
                "--scheduler and --workers cannot be used together, because a cluster has its own workers: remove one "
                "of the two"
            )
        return Engine(self.workers or 0, kind, self.scheduler or "")


def require_distinct_names(designs: Iterable[Design]) -> None:
    """Raise UsageError if two designs have the same name, as one's files would overwrite the other's."""
    names = [design.name for design in designs]
    repeated_name = next((name for name in names if names.count(name) > 1), None)
    if repeated_name is not None:
        raise UsageError(
            f"two designs have the name {repeated_name!r}, so they would overwrite each other's files: change the key "
            "`name` in one of the design files"
        )


def parse_point(text: str | None) -> tuple[float, float] | None:
    """Parse the point q of the disc, a text ``X,Y`` in mm, to x and y [m]; return None for None.

    Raises UsageError if the text is not two numbers in range.
    """
    if text is None:
        return None
    try:
        x, y = (float(word) for word in text.split(","))
    except ValueError:
        raise UsageError(f"--q {text!r} is not a point: give two coordinates X,Y in mm, e.g. --q 26,0") from None
    low, high = RANGES.point_q_mm
    if not (low <= x <= high and low <= y <= high):
        raise UsageError(f"--q {text} is out of range: give coordinates from {low:g} to {high:g} mm, e.g. --q 26,0")
    return x / 1e3, y / 1e3


StudySolverFlag = Annotated[
    Literal["planar", "mujoco"],
    Parameter(
        help="Solver of the simulations: planar (fast, compiled, planar equations of motion) or mujoco. "
        "Default: planar."
    ),
]
