"""``cycloid-mj measure``: catalogue figures, with a command for each row of `COMMANDS`.

The class of a measure's own options is the command: its docstring is the help, its fields are the flags. A field ends
in the flag's unit; the measure takes its value in SI, under the name without the unit.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from cyclopts import App, Parameter

from cycloid_mj.base.interrupt import unbroken
from cycloid_mj.base.outcome import Outcome, Picture, headline
from cycloid_mj.base.result import quantity_table
from cycloid_mj.cli.delivery import Destination, claimed, show_outcome, write
from cycloid_mj.cli.flags import (
    FLAT,
    LOAD,
    LOADED,
    NAMES,
    PRESET,
    RATED,
    SPEED,
    Delivery,
    DesignNames,
    DesignOptions,
    DesignValue,
    PresetOptions,
    SetFlag,
    SeveralFlag,
    StudySolverFlag,
    Values,
    out_flag,
    require_distinct,
    whole,
    within,
)
from cycloid_mj.cli.terminal import say_json
from cycloid_mj.design import Design
from cycloid_mj.reducer import Reducer

if TYPE_CHECKING:
    from cycloid_mj.measure import Measurement

ABOUT = "Measure one figure with its error and its closed form."
EXAMPLES = """Examples:
  cycloid-mj measure te --design pin
  cycloid-mj measure backlash --design nonpin --set clearance.tooth_um=5
  cycloid-mj measure torque pin nonpin --json"""

OUT = "runs/measure"
BOTH = ("pin", "nonpin")
TORQUE = DesignValue("drive", "torque")
AT_RATED = f". Default: the {RATED}."


@dataclass(frozen=True, kw_only=True)
class MeasureDelivery(Delivery):
    """Where a measurement goes, with the logs of its runs."""

    out: Annotated[str | None, out_flag("the JSON file, the logs and the figure", OUT)] = None
    figure: Annotated[
        bool, Parameter(help="Draw the figure (png, svg), too, which takes as long as a short measure. --html does.")
    ] = False
    no_log: Annotated[bool, Parameter(name="--no-log", help="Write no MCAP logs of the underlying runs.")] = False


@dataclass(frozen=True)
class MeasureOptions:
    """The options of one measure."""

    solver: StudySolverFlag = "planar"

    EXAMPLES: ClassVar[str] = ""
    PUBLISHED: ClassVar[bool] = False
    """Whether the measure sets torques that a paper gives for the design beside its own."""

    def values(self) -> Values:
        """Return the values that the options set in the design."""
        return ()

    def arguments(self) -> dict[str, Any]:
        """Collect the arguments of the measure, in SI."""
        options = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name.removesuffix("_nm").removesuffix("_rpm"): _in_si(name, value) for name, value in options.items()}


def _in_si(name: str, value: Any) -> Any:
    if not name.endswith("_rpm") or value is None:
        return value
    return [SPEED.unit.to_si(one) for one in value] if isinstance(value, tuple) else SPEED.unit.to_si(value)


def several(name: str, quantity: DesignValue, text: str, default: str) -> Parameter:
    """Declare a flag for one or more values above 0 that keep a quantity's limits; `text` says what they are."""

    def require(_: Any, values: tuple[float, ...] | None) -> None:
        for value in values or ():
            if not value > 0.0:
                raise ValueError(f"each must be more than 0 [{quantity.symbol}], not {value:g}")
            try:
                quantity.require(value)
            except ValueError as error:
                raise ValueError(f"each {error}, not {value:g}") from None

    return Parameter(
        name=name,
        metavar="X",
        consume_multiple=True,
        validator=require,
        help=f"{text} [{quantity.symbol}], each more than 0; one or more. {default}",
    )


LoadedFlag = Annotated[float | None, LOAD.flag("Torque of the loaded runs", AT_RATED)]
SpeedsFlag = Annotated[
    tuple[float, ...],
    several("--speed-rpm", SPEED, "Crank speeds", "Default: shares of the design's drive.speed_rpm from 0.5 to 1.5."),
]
TurnsFlag = Annotated[
    int,
    Parameter(
        metavar="N",
        converter=whole,
        validator=within(1, 1000),
        help="Crank turns of each run, from 1 to 1000; one turn of the output tells all orders apart. Default: 1.",
    ),
]


@dataclass(frozen=True)
class TransmissionErrorOptions(MeasureOptions):
    """Measure the transmission error of gear and output against crank angle.

    Over whole crank turns, in both directions, unloaded and loaded, slow and
    at speed: peak to peak, rms, what reversal and load shift, and the order
    spectrum, with the orders that errors of pins, holes and eccentricity give.
    Beside it stand the same figures from statics.
    """

    EXAMPLES: ClassVar[str] = """Examples:
  cycloid-mj measure te --design pin --set errors.pin_position_um=2
  cycloid-mj measure te --design nonpin --quick --json"""

    load_nm: LoadedFlag = None
    drag_nm: Annotated[
        float | None,
        LOAD.flag(
            "Torque of the unloaded runs", ". 0 lets the gear float in its backlash. Default: 1 % of the rated torque."
        ),
    ] = None
    slow_rpm: Annotated[
        float | None,
        SPEED.flag("Crank speed of the slow runs", "; both ways are run. Default: a quarter of the design's."),
    ] = None
    turns: TurnsFlag = 1
    quick: Annotated[bool, Parameter(help="At speed only, and no runs with half the step.")] = False


@dataclass(frozen=True)
class BacklashOptions(MeasureOptions):
    """Measure the backlash of the output at locked crank angles.

    A small torque presses the output to either stop, at 8 crank angles over
    the turn and over the mesh period, without friction and weight. Then the
    same with each clearance alone: teeth, pin sockets or sleeves, cam, output
    pins. Beside it stand the closed forms: for each clearance alone, and for
    all together a linear programme of rigid contacts, manufacturing errors
    included.
    """

    EXAMPLES: ClassVar[str] = """Examples:
  cycloid-mj measure backlash --design pin
  cycloid-mj measure backlash --design nonpin --set clearance.tooth_um=5
  cycloid-mj measure backlash --design pin --set errors.pin_position_um=0.3 --out placed --json"""

    quick: Annotated[bool, Parameter(help="2 crank angles instead of 8.")] = False


@dataclass(frozen=True)
class LostMotionOptions(MeasureOptions):
    """Measure hysteresis, lost motion and torsional stiffness at locked crank angles.

    A slow torque at the output goes up to the rated torque and back, both
    ways, at 6 crank angles over the turn and over the mesh period: the design
    as it is, then without friction and weight. Lost motion is read at +-3 % of
    the rated torque, as the makers of reducers do, stiffness from 50 to 100 %,
    backlash at zero. Beside them stands an independent static balance of all
    contacts. The share of output pins, cam and teeth is told apart.
    """

    EXAMPLES: ClassVar[str] = """Examples:
  cycloid-mj measure lost-motion --design pin
  cycloid-mj measure lost-motion --design nonpin --load-nm 30 --quick
  cycloid-mj measure lost-motion --design pin --set 'ring.pins="fixed"' --out fixed --json"""

    load_nm: Annotated[
        float | None, LOADED.flag("Largest torque of the loop, of which lost motion is read at 3 %", AT_RATED)
    ] = None
    quick: Annotated[bool, Parameter(help="2 crank angles instead of 6.")] = False


@dataclass(frozen=True)
class LoadsOptions(MeasureOptions):
    """Measure the force on each pin, tooth, output pin and the cam against crank angle.

    At a given output torque and the design's speed, over a turn of the crank:
    peaks, means, the angle of the peak, beside ideal sharing; Hertz pressure
    with the local relative curvature and the margin against the material's
    yield for each kind of contact; and the capacity: which part limits the
    torque, and at what torque.
    """

    EXAMPLES: ClassVar[str] = """Examples:
  cycloid-mj measure loads --design pin
  cycloid-mj measure loads --design nonpin --load-nm 20 --json"""

    load_nm: Annotated[float | None, LOADED.flag("Torque on the output", AT_RATED)] = None
    quick: Annotated[bool, Parameter(help="Two mesh periods instead of a whole turn of the crank.")] = False


@dataclass(frozen=True)
class TorqueOptions(MeasureOptions):
    """Measure the output torque under the rated input torque.

    The paper's test: the crank feels a given torque, a brake holds the
    output at its speed. Mean and ripple of the output torque, its rate
    against the torque without losses, how the rate answers to the friction
    of each pair with pins free, fixed and sleeved, and which friction would
    give the paper's figures. Each input that is assumed (play, the cam,
    friction, creep speed, damping) is varied alone: how far the rate moves
    with them stands beside its numerical error. --set changes every design.
    """

    EXAMPLES: ClassVar[str] = """Examples:
  cycloid-mj measure torque pin nonpin
  cycloid-mj measure torque pin nonpin --set friction.pin_gear=0.02 --quick --out low
  cycloid-mj measure torque --torque-nm 0.5 --out half --json"""
    PUBLISHED: ClassVar[bool] = True

    torque_nm: Annotated[float | None, TORQUE.flag("Input torque")] = None
    speed_rpm: Annotated[float | None, SPEED.flag("Crank speed")] = None
    quick: Annotated[
        bool,
        Parameter(
            help="A shorter average, no run with half the step, and only the friction of all sliding pairs varied."
        ),
    ] = False

    def values(self) -> Values:
        """Return the input torque and the speed: they are the design's."""
        return (TORQUE, self.torque_nm), (SPEED, self.speed_rpm)

    def arguments(self) -> dict[str, Any]:
        """Collect what the design does not hold."""
        return {"quick": self.quick, "solver": self.solver}


@dataclass(frozen=True)
class EfficiencyOptions(MeasureOptions):
    """Measure the efficiency over torque and speed, and where the losses go.

    Friction by kind of pair and the work of the normal forces, which add up
    with input and output power to the residual that is told. Then the torque
    without a load, and from the output: from rest, at speed with the crank
    free, and against the rated torque on the crank. Beside the efficiency
    stand ideal load sharing with Coulomb friction, and the formula of Wang et
    al. 2016 at the same friction. The efficiency builds up from teeth, cam,
    output and seals, and each input that is assumed (play, the cam, friction,
    creep speed, damping) is varied alone: how far the efficiency moves with
    them stands beside its numerical error.
    """

    EXAMPLES: ClassVar[str] = """Examples:
  cycloid-mj measure efficiency --design pin
  cycloid-mj measure efficiency --design nonpin --load-nm 5 20 36 --speed-rpm 500 3000
  cycloid-mj measure efficiency --design pin --quick --out quick --json"""
    PUBLISHED: ClassVar[bool] = True

    loads_nm: Annotated[
        tuple[float, ...],
        several(
            "--load-nm",
            LOAD,
            "Output torques of the map",
            f"Default: a quarter, half and all of the {RATED}.",
        ),
    ] = ()
    speeds_rpm: SpeedsFlag = ()
    quick: Annotated[
        bool, Parameter(help="Shorter averages, no run with half the step, and by default the rated point alone.")
    ] = False


@dataclass(frozen=True)
class VibrationOptions(MeasureOptions):
    """Measure the vibration of gear, output and housing over crank speed.

    The rms and the spectrum of the accelerations of the gear's centre and the
    output about the closed form, and of the force on the housing, unloaded and
    loaded; the unbalance with and without the counterweight. The design's own
    speed is always run.
    """

    EXAMPLES: ClassVar[str] = """Examples:
  cycloid-mj measure vibration --design nonpin
  cycloid-mj measure vibration --design pin --speed-rpm 500 3000 --json"""

    load_nm: LoadedFlag = None
    speeds_rpm: SpeedsFlag = ()
    turns: TurnsFlag = 1
    quick: Annotated[bool, Parameter(help="At the design's speed only, and no runs with half the step.")] = False


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
"""What progress calls a measure, where it is not its name."""


def commands(sort_key: int) -> App:
    """Build the measures; `sort_key` is their place in the help."""
    app = App(name="measure", help=ABOUT, help_epilogue=EXAMPLES, sort_key=sort_key)
    for place, (name, options) in enumerate(COMMANDS.items()):
        app.command(_command(name, options), name=name, sort_key=place, help_epilogue=options.EXAMPLES)
    return app


def _command(name: str, options: type[MeasureOptions]) -> Callable[..., int]:
    """Make the command of a measure: its design, its own options, and what all measures share."""

    def one(chosen: PresetOptions = PRESET, *, options: MeasureOptions, delivered: MeasureDelivery) -> int:
        return _measure(name, [chosen.sound(options.values())], options, delivered)

    def many(
        *designs: Annotated[DesignNames, Parameter(help=f"Designs: {NAMES}, or TOML files. Default: pin and nonpin.")],
        design: SeveralFlag = (),
        set_: SetFlag = (),
        options: MeasureOptions,
        delivered: MeasureDelivery,
    ) -> int:
        sound = [DesignOptions(one, set_=set_).sound(options.values()) for one in (*designs, *design) or BOTH]
        return _measure(name, sound, options, delivered)

    command: Any = many if options is TorqueOptions else one
    shared: dict[str, type[Any]] = {"chosen": PresetOptions, "options": options, "delivered": MeasureDelivery}
    flat = {word: Annotated[kind, FLAT] for word, kind in shared.items() if word in command.__annotations__}
    command.__doc__ = options.__doc__
    command.__annotations__ |= flat
    command.__kwdefaults__ = (command.__kwdefaults__ or {}) | {"options": options(), "delivered": MeasureDelivery()}
    made: Callable[..., int] = command
    return made


def _measure(name: str, designs: Sequence[Design], options: MeasureOptions, delivered: MeasureDelivery) -> int:
    """Measure designs, and print and write what was measurement."""
    from cycloid_mj.cli.progress import counted
    from cycloid_mj.measure import MEASURES
    from cycloid_mj.papers import published_torques

    require_distinct(designs)
    stems = [f"{name}-{design.name}" for design in designs]
    drawn = [f".{form}" for form in Outcome.formats] if _is_drawn(delivered) else []
    places = [claimed(delivered, stem, [stem + ending for ending in drawn], OUT) for stem in stems]
    measurements = []
    for design in designs:
        words = WORDS.get(name, name) + (f" of {design.name}" if options.values() else "")
        progress = counted(words, delivered.quiet)
        published = {"published": published_torques(Reducer(design))} if options.PUBLISHED else {}
        measurements.append(MEASURES[name](design, **options.arguments(), **published, progress=progress))
    for measurement, place in zip(measurements, places, strict=True):
        _deliver(measurement, place, delivered)
    if delivered.json:
        say_json(
            measurements[0].as_json()
            if len(measurements) == 1
            else {"measurements": [one.as_json() for one in measurements]}
        )
    return 0


def _is_drawn(delivered: MeasureDelivery) -> bool:
    """Tell whether the figure is asked for, by itself or in the page."""
    return delivered.figure or delivered.html is not None


def _deliver(measurement: "Measurement", place: Destination, delivered: MeasureDelivery) -> None:
    """Write a measurement with the logs of its runs, and print it unless JSON is asked for."""
    from cycloid_mj.log import write as write_log

    outcome = _outcome(measurement, _pictures(measurement, place.stem) if _is_drawn(delivered) else {})
    with unbroken():
        write(outcome, place, delivered)
        if place.folder and not delivered.no_log:
            for run_name, run in measurement.runs.items():
                write_log(run, place.folder / f"{place.stem}-{run_name}.mcap", force=delivered.force)
    if not delivered.json:
        show_outcome(outcome, delivered.all)


def _pictures(measurement: "Measurement", stem: str) -> dict[str, Picture]:
    from cycloid_mj.plots.measure import measurement_figure
    from cycloid_mj.plots.save import drawn

    return {stem: partial(drawn, measurement_figure(measurement))}


def _outcome(measurement: "Measurement", pictures: Mapping[str, Picture]) -> Outcome:
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
