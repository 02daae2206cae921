"""``cycloid-mj measure``: catalogue figures, with a command for each row of `COMMANDS`.

The class of a measure's own options is the command: its docstring is the help, its fields are the flags. A field ends
in the flag's unit; the measure takes its value in SI, under the name without the unit.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from cyclopts import App, Parameter

from cycloid_mj.base.interrupt import defer_signals
from cycloid_mj.base.outcome import Outcome, Picture, headline
from cycloid_mj.base.result import quantity_table
from cycloid_mj.cli import flags
from cycloid_mj.cli.completion import CompletingApp
from cycloid_mj.cli.delivery import Destination, claim_destination, show_outcome, write
from cycloid_mj.cli.terminal import say_json
from cycloid_mj.design import Design
from cycloid_mj.reducer import reducer_of

if TYPE_CHECKING:
    from cycloid_mj.measure import Measurement

ABOUT = "Measure one figure by simulation, with its numerical error and closed form."
EXAMPLES = """Examples:
  cycloid-mj measure te --design pin
  cycloid-mj measure backlash --design nonpin --set clearance.tooth_um=5
  cycloid-mj measure torque pin nonpin --json"""

OUT = "runs/measure"
BOTH = ("pin", "nonpin")
TORQUE = flags.DesignValue("drive", "torque")
RATED_DEFAULT = f". Default: the {flags.RATED}."


@dataclass(frozen=True, kw_only=True)
class MeasureDelivery(flags.Delivery):
    """Output flags of a measurement and of the logs of its runs."""

    out: Annotated[str | None, flags.out_flag("the JSON file, the logs and the figure", OUT)] = None
    figure: Annotated[
        bool,
        Parameter(help="Also draw the figure (PNG, SVG), which takes as long as a short measure. --html draws it too."),
    ] = False
    no_log: Annotated[bool, Parameter(name="--no-log", help="Do not write the MCAP logs of the runs.")] = False


@dataclass(frozen=True)
class MeasureOptions:
    """The options of one measure."""

    solver: flags.StudySolverFlag = "planar"

    EXAMPLES: ClassVar[str] = ""
    PUBLISHED: ClassVar[bool] = False
    """True if the measure compares its torques with those that a paper publishes for the design."""

    def values(self) -> flags.Values:
        """Return the values that the options set in the design."""
        return ()

    def arguments(self) -> dict[str, Any]:
        """Collect the arguments of the measure, in SI."""
        options = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name.removesuffix("_nm").removesuffix("_rpm"): _in_si(name, value) for name, value in options.items()}


def _in_si(name: str, value: Any) -> Any:
    if not name.endswith("_rpm") or value is None:
        return value
    return (
        [flags.SPEED.unit.to_si(item) for item in value] if isinstance(value, tuple) else flags.SPEED.unit.to_si(value)
    )


def positive_values_flag(name: str, quantity: flags.DesignValue, text: str, default: str) -> Parameter:
    """Declare the flag `name` for one or more positive values within the limits of a design value, for example speeds.

    `quantity` is the design value, `text` the help of the flag, `default` its default in words.
    """

    def require(_: Any, values: tuple[float, ...] | None) -> None:
        """Raise ValueError for a value that is not positive or out of range."""
        for value in values or ():
            if not value > 0.0:
                raise ValueError(f"each value must be greater than 0 [{quantity.symbol}], not {value:g}")
            try:
                quantity.require(value)
            except ValueError as error:
                raise ValueError(f"each {error}, not {value:g}") from None

    return Parameter(
        name=name,
        metavar="X",
        consume_multiple=True,
        validator=require,
        help=f"{text} [{quantity.symbol}], each greater than 0; one or more values. {default}",
    )


LoadedFlag = Annotated[float | None, flags.LOAD.flag("Torque of the loaded runs", RATED_DEFAULT)]
SpeedsFlag = Annotated[
    tuple[float, ...],
    positive_values_flag(
        "--speed-rpm", flags.SPEED, "Crank speeds", "Default: 0.5 to 1.5 times drive.speed_rpm of the design."
    ),
]
TurnsFlag = Annotated[
    int,
    flags.integer_flag(
        "Crank turns of each run, 1 to 1000. A full turn of the output separates all orders. Default: 1.", (1, 1000)
    ),
]


@dataclass(frozen=True)
class TransmissionErrorOptions(MeasureOptions):
    """Measure the transmission error of disc and output over the crank angle.

    The runs cover full crank turns in both directions, unloaded and loaded, slow and
    at the design's speed. Results: peak to peak, rms, the shifts by reversal and by
    load, and the order spectrum, with the orders that errors of pins, holes and
    eccentricity cause. Each figure is compared with its value by statics.
    """

    EXAMPLES: ClassVar[str] = """Examples:
  cycloid-mj measure te --design pin --set errors.pin_position_um=2
  cycloid-mj measure te --design nonpin --quick --json"""

    load_nm: LoadedFlag = None
    drag_nm: Annotated[
        float | None,
        flags.LOAD.flag(
            "Torque of the unloaded runs",
            ". With 0 the disc floats in its clearances. Default: 1 % of the nominal torque.",
        ),
    ] = None
    slow_rpm: Annotated[
        float | None,
        flags.SPEED.flag(
            "Crank speed of the slow runs", ", in both directions. Default: a quarter of drive.speed_rpm."
        ),
    ] = None
    turns: TurnsFlag = 1
    quick: Annotated[bool, Parameter(help="Skip the slow runs and those with half the time step.")] = False


@dataclass(frozen=True)
class BacklashOptions(MeasureOptions):
    """Measure the backlash of the output at locked crank angles.

    A small torque presses the output against both stops at 8 crank angles, spread over
    the turn and over the mesh period, without friction and weight. The measurement is
    repeated with each clearance alone: teeth, pin sockets or sleeves, cam, output pins.
    References: a closed form for each clearance alone, and for all together a linear
    programme of rigid contacts that includes manufacturing errors.
    """

    EXAMPLES: ClassVar[str] = """Examples:
  cycloid-mj measure backlash --design pin
  cycloid-mj measure backlash --design nonpin --set clearance.tooth_um=5
  cycloid-mj measure backlash --design pin --set errors.pin_position_um=0.3 --out placed --json"""

    quick: Annotated[bool, Parameter(help="Use 2 crank angles instead of 8.")] = False


@dataclass(frozen=True)
class LostMotionOptions(MeasureOptions):
    """Measure hysteresis, lost motion and torsional stiffness at locked crank angles.

    The output is loaded slowly to the nominal torque and back, in both directions, at 6
    crank angles spread over the turn and over the mesh period: the design as it is, then
    without friction and weight. Lost motion is read at +-3 % of the nominal torque, as
    makers of reducers do, the stiffness between 50 and 100 %, the backlash at zero.
    Reference: an independent static balance of all contacts. The compliances of output
    pins, cam and teeth are listed separately.
    """

    EXAMPLES: ClassVar[str] = """Examples:
  cycloid-mj measure lost-motion --design pin
  cycloid-mj measure lost-motion --design nonpin --load-nm 30 --quick
  cycloid-mj measure lost-motion --design pin --set 'ring.pins="fixed"' --out fixed --json"""

    load_nm: Annotated[
        float | None, flags.LOADED.flag("Largest torque of the loop; lost motion is read at 3 % of it", RATED_DEFAULT)
    ] = None
    quick: Annotated[bool, Parameter(help="Use 2 crank angles instead of 6.")] = False


@dataclass(frozen=True)
class LoadsOptions(MeasureOptions):
    """Measure the forces of ring pins or teeth, output pins and cam over the crank angle.

    The run covers a crank turn at the output torque and the design's speed. Results for
    each kind of contact: peak force, mean force and the angle of the peak, next to ideal
    load sharing; Hertz pressure with the local relative curvature, and the margin
    against yield. Capacity: the torque at which a contact first yields, and which.
    """

    EXAMPLES: ClassVar[str] = """Examples:
  cycloid-mj measure loads --design pin
  cycloid-mj measure loads --design nonpin --load-nm 20 --json"""

    load_nm: Annotated[float | None, flags.LOADED.flag("Torque on the output", RATED_DEFAULT)] = None
    quick: Annotated[bool, Parameter(help="Run two mesh periods instead of a full crank turn.")] = False


@dataclass(frozen=True)
class TorqueOptions(MeasureOptions):
    """Measure the output torque under the rated input torque.

    Test of Hsieh 2014: a motor of constant torque drives the crank, and a brake holds
    the output at its speed. Results: mean and ripple of the output torque; its ratio to
    the torque without losses ("rate"); the sensitivity of this rate to the friction of
    each pair, with pins free, fixed and sleeved; and the friction that would explain
    published torques. Each assumed input (clearances, cam, friction, creep speed,
    damping) is varied on its own; the resulting range of the rate is printed next to its
    numerical error. --set changes every design.
    """

    EXAMPLES: ClassVar[str] = """Examples:
  cycloid-mj measure torque pin nonpin
  cycloid-mj measure torque pin nonpin --set friction.pin_gear=0.02 --quick --out low
  cycloid-mj measure torque --torque-nm 0.5 --out half --json"""
    PUBLISHED: ClassVar[bool] = True

    torque_nm: Annotated[float | None, TORQUE.flag("Input torque")] = None
    speed_rpm: Annotated[float | None, flags.SPEED.flag("Crank speed")] = None
    quick: Annotated[
        bool,
        Parameter(
            help="Average over a shorter time, skip the run with half the time step, and vary only the friction of all "
            "sliding pairs together."
        ),
    ] = False

    def values(self) -> flags.Values:
        """Return the input torque and the speed, which are values of the design."""
        return (TORQUE, self.torque_nm), (flags.SPEED, self.speed_rpm)

    def arguments(self) -> dict[str, Any]:
        """Collect the arguments that are not values of the design."""
        return {"quick": self.quick, "solver": self.solver}


@dataclass(frozen=True)
class EfficiencyOptions(MeasureOptions):
    """Measure the efficiency over torque and speed, and the losses by kind of contact.

    Losses by kind of pair: friction, and the work of the normal forces. The residual of
    the power balance is printed. Further results: the no-load torque, and the torques
    that drive the output backwards from rest, at speed with a free crank, and against
    the nominal torque on the crank. References: ideal load sharing with Coulomb friction,
    and the formula of Wang et al. 2016 at the same friction. Each assumed input
    (clearances, cam, friction, creep speed, damping) is varied on its own; the resulting
    range of the efficiency is printed next to its numerical error.
    """

    EXAMPLES: ClassVar[str] = """Examples:
  cycloid-mj measure efficiency --design pin
  cycloid-mj measure efficiency --design nonpin --load-nm 5 20 36 --speed-rpm 500 3000
  cycloid-mj measure efficiency --design pin --quick --out quick --json"""
    PUBLISHED: ClassVar[bool] = True

    loads_nm: Annotated[
        tuple[float, ...],
        positive_values_flag(
            "--load-nm",
            flags.LOAD,
            "Output torques of the map",
            f"Default: 0.25, 0.5 and 1 times the {flags.RATED}.",
        ),
    ] = ()
    speeds_rpm: SpeedsFlag = ()
    quick: Annotated[
        bool,
        Parameter(
            help="Average over a shorter time, skip the run with half the time step, and measure only the rated point "
            "unless torques or speeds are given."
        ),
    ] = False


@dataclass(frozen=True)
class VibrationOptions(MeasureOptions):
    """Measure the vibration of disc, output and housing over crank speed.

    Results, unloaded and loaded: rms and spectrum of the accelerations of the disc's
    centre and of the output relative to the closed form, and of the force on the
    housing; the unbalance with and without the counterweight. The design's speed is
    always included.
    """

    EXAMPLES: ClassVar[str] = """Examples:
  cycloid-mj measure vibration --design nonpin
  cycloid-mj measure vibration --design pin --speed-rpm 500 3000 --json"""

    load_nm: LoadedFlag = None
    speeds_rpm: SpeedsFlag = ()
    turns: TurnsFlag = 1
    quick: Annotated[
        bool, Parameter(help="Measure only the design's speed, and skip the runs with half the time step.")
    ] = False


COMMANDS: Mapping[str, type[MeasureOptions]] = {
    "te": TransmissionErrorOptions,
    "backlash": BacklashOptions,
    "lost-motion": LostMotionOptions,
    "loads": LoadsOptions,
    "torque": TorqueOptions,
    "efficiency": EfficiencyOptions,
    "vibration": VibrationOptions,
}
"""Name, as in `cycloid_mj.measure.MEASURES`, -> options."""

WORDS = {"te": "transmission error", "lost-motion": "lost motion"}
"""Names of measures in progress lines, where they differ from the command's."""


def commands(sort_key: int) -> App:
    """Build the group of commands `measure`, one for each measure; `sort_key` is its position in the help."""
    app = CompletingApp(name="measure", help=ABOUT, help_epilogue=EXAMPLES, sort_key=sort_key)
    for order, (name, options) in enumerate(COMMANDS.items()):
        app.command(_create_command(name, options), name=name, sort_key=order, help_epilogue=options.EXAMPLES)
    return app


def _create_command(name: str, options: type[MeasureOptions]) -> Callable[..., int]:
    """Return the function of the command of the measure `name`, with the flags of `options` and those of all measures.

    Cyclopts reads flags and help from the signature and docstring of this function.
    """

    def measure_design(
        design_options: flags.PresetOptions = flags.PRESET, *, options: MeasureOptions, output_flags: MeasureDelivery
    ) -> int:
        return _measure_designs(name, [design_options.resolve_checked(options.values())], options, output_flags)

    def measure_designs(
        *designs: Annotated[
            flags.DesignNames,
            Parameter(help=f"Designs: presets ({flags.NAMES}) or TOML files. Default: pin and nonpin."),
        ],
        design: flags.SeveralFlag = (),
        changes: flags.SetFlag = (),
        at_c: flags.TemperatureFlag = None,
        options: MeasureOptions,
        output_flags: MeasureDelivery,
    ) -> int:
        """Measure the `designs` by position, or those of the flag ``--design``, and return the exit code 0.

        The other arguments are flags: changes of all designs by ``--set``, temperature of all parts ``--at-c`` [°C],
        settings of the measure, and settings of the output.
        """
        design_choices = [flags.DesignOptions(name, set_=changes, at_c=at_c) for name in (*designs, *design) or BOTH]
        resolved_designs = [choice.resolve_checked(options.values()) for choice in design_choices]
        return _measure_designs(name, resolved_designs, options, output_flags)

    command: Any = measure_designs if options is TorqueOptions else measure_design
    option_types: dict[str, type[Any]] = {
        "design_options": flags.PresetOptions,
        "options": options,
        "output_flags": MeasureDelivery,
    }
    flat_types = {
        argument: Annotated[argument_type, flags.FLAT]
        for argument, argument_type in option_types.items()
        if argument in command.__annotations__
    }
    command.__doc__ = options.__doc__
    command.__annotations__ |= flat_types
    command.__kwdefaults__ = (command.__kwdefaults__ or {}) | {"options": options(), "output_flags": MeasureDelivery()}
    typed_command: Callable[..., int] = command
    return typed_command


def _measure_designs(
    name: str, designs: Sequence[Design], options: MeasureOptions, output_flags: MeasureDelivery
) -> int:
    """Measure designs one after another, write and print the results, and return the exit code 0.

    `name` is the name of the measure, `options` are its settings. Files are written after the last measurement. With
    several designs, the printed JSON is an object whose ``measurements`` is the list of results. Raises UsageError if
    two designs have the same name.
    """
    from cycloid_mj.cli.progress import count_progress
    from cycloid_mj.measure import MEASURES
    from cycloid_mj.papers import published_torques

    flags.require_distinct_names(designs)
    stems = [f"{name}-{design.name}" for design in designs]
    endings = [f".{file_format}" for file_format in Outcome.formats] if _is_drawn(output_flags) else []
    destinations = [claim_destination(output_flags, stem, [stem + ending for ending in endings], OUT) for stem in stems]
    measurements = []
    for design in designs:
        name_in_progress = WORDS.get(name, name) + (f" of {design.name}" if options.values() else "")
        progress = count_progress(name_in_progress, output_flags.quiet)
        published_values = {"published": published_torques(reducer_of(design))} if options.PUBLISHED else {}
        measurements.append(MEASURES[name](design, **options.arguments(), **published_values, progress=progress))
    for measurement, destination in zip(measurements, destinations, strict=True):
        _deliver_measurement(measurement, destination, output_flags)
    if output_flags.json:
        say_json(
            measurements[0].as_json()
            if len(measurements) == 1
            else {"measurements": [item.as_json() for item in measurements]}
        )
    return 0


def _is_drawn(output_flags: MeasureDelivery) -> bool:
    """Return whether the figure is requested, as a file or in the page."""
    return output_flags.figure or output_flags.html is not None


def _deliver_measurement(measurement: "Measurement", destination: Destination, output_flags: MeasureDelivery) -> None:
    """Write the files of a measurement and the logs of its runs, and print it unless JSON is requested.

    `destination` has the paths, `output_flags` those of the output, such as ``--quiet``.
    """
    from cycloid_mj.log import write as write_log

    outcome = _outcome(measurement, _figure_encoders(measurement, destination.stem) if _is_drawn(output_flags) else {})
    with defer_signals():
        write(outcome, destination, output_flags)
        if destination.folder and not output_flags.no_log:
            for run_name, run in measurement.runs.items():
                write_log(run, destination.folder / f"{destination.stem}-{run_name}.mcap", force=output_flags.force)
    if not output_flags.json:
        show_outcome(outcome, output_flags.all)


def _figure_encoders(measurement: "Measurement", stem: str) -> dict[str, Picture]:
    from cycloid_mj.plots.measure import measurement_figure
    from cycloid_mj.plots.save import encode_figure

    return {stem: partial(encode_figure, measurement_figure(measurement))}


def _outcome(measurement: "Measurement", pictures: Mapping[str, Picture]) -> Outcome:
    """Convert a measurement to printable results: measured quantities, tables, notes and diagrams.

    `pictures` has for each diagram, by its name, the function that encodes it in a file format.
    """
    quantities = measurement.quantities.values()
    title = f"{measurement.measure}: {measurement.design.name}"
    return Outcome(
        title=title,
        headline=headline(quantities),
        tables=[quantity_table(title, quantities), *measurement.tables],
        notes=[
            *(f"{quantity.name}: {quantity.note}" for quantity in quantities if quantity.note),
            *(f"assumed: {sentence}" for sentence in measurement.assumptions),
        ],
        pictures=pictures,
        result=measurement.as_json(),
    )
