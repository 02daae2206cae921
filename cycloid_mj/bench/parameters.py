"""Parameters of a calibration: named values on which a loop depends, and every number of the design file."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import Any, NamedTuple

from pydantic.fields import FieldInfo

from cycloid_mj.base.errors import DesignError, UsageError
from cycloid_mj.base.units import DEGREE
from cycloid_mj.bench.loop import MeasuredLoop
from cycloid_mj.bench.loop_figures import loop_coulomb_torque
from cycloid_mj.design import Design, override
from cycloid_mj.design.layouts import Layout
from cycloid_mj.design.units import MICROMETRE, bounds_of, file_key, section_of, unit_of
from cycloid_mj.explore.sampling import tolerance_zones
from cycloid_mj.reducer import Reducer, RvReducer, reducer_of
from cycloid_mj.statics.friction_path import Losses
from cycloid_mj.statics.structure import twisting_compliance, twisting_stiffness


@dataclass(frozen=True)
class SearchBounds:
    """Bounds of the fitted values (heuristic)."""

    max_play_um: float = 900.0
    """Largest clearance [um]."""
    max_drag: float = 0.9
    """Largest constant friction, over the largest torque of the loops."""
    min_travel: float = 0.01
    """Smallest turn over which friction comes on, over the height of the lowest loop. No loop shows a smaller one, and
    in MuJoCo a spring that stiff would need an armature that makes the joint slow."""
    max_structure: float = 0.95
    """Largest stiffness of the structure, over that of carrier and shaft alone."""
    max_load_friction: float = 0.8
    """Largest `load_friction` [1]: at 1 a loaded drive would lock itself."""
    max_friction: float = 1.5
    """Largest coefficient of friction."""


BOUNDS = SearchBounds()


SHIFTING = {
    "mesh": "teeth",
    "seat": "teeth",
    "pin_position": "teeth",
    "pin_radius": "teeth",
    "pin_circle": "teeth",
    "disc_size": "teeth",
    "output": "output",
    "hole_position": "output",
    "cam": "cam",
}
"""Tolerances that change a clearance -> that clearance."""


@dataclass(frozen=True)
class Model:
    """A design, and losses of a loop that a design file does not contain."""

    reducer: Reducer
    """The reducer of the design with the fitted values."""
    losses: Losses
    """Losses in addition to the friction of the contacts."""
    contact_friction: bool = True
    """Whether the friction of the contacts is computed (`statics.friction_path`); else friction of the wind-up
    represents all of it (`statics.locked`)."""


@dataclass(frozen=True)
class Parameter:
    """Fitted value, in the unit in which it is printed."""

    key: str
    unit: str
    meaning: str
    """Its name on the command line and in JSON, its unit, and its definition."""
    start: float
    scale: float
    """Start of the search, and a change that matters."""
    lower: float
    upper: float
    """Bounds of the search."""
    apply: Callable[[Model, float], Model]
    """Function from a model and a value to the model with that value."""
    logarithmic: bool = False
    """Whether its logarithm is searched, as of a value that is known to within a decade; `scale` is then a change of
    the logarithm."""
    deviation: float = math.inf
    source: str = ""
    """Standard deviation of its prior about `start`, and the source of that; inf without a prior."""

    @property
    def scaled_deviation(self) -> float:
        """Standard deviation of the prior of the scaled value."""
        return self.deviation / self.scale

    def to_scale(self, value: float) -> float:
        """Compute the scaled value, of which a change of 1 matters."""
        return math.log(value) / self.scale if self.logarithmic else value / self.scale

    def from_scale(self, scaled: float) -> float:
        """Compute the value from a scaled one, clipped to the bounds."""
        value = math.exp(self.scale * scaled) if self.logarithmic else self.scale * scaled
        return min(max(value, self.lower), self.upper)


DEFAULT = ("play", "structure_stiffness", "drag", "drag_travel", "hysteresis", "hysteresis_travel")
"""Parameters that are fitted by default: a loop shows the sum of the clearances, not each of them."""

RV_DEFAULT = ("play", "bearing_stiffness", *DEFAULT[2:])
"""The same for an RV reducer, whose crank bearings cause most of the deflection."""

CONTACT_FRICTION = ("friction", "material_loss")
"""Parameters of the friction of the contacts."""

WIND_UP_FRICTION = ("hysteresis", "hysteresis_travel", "load_friction")
"""Parameters that represent the friction of the contacts."""

NAMED = (*DEFAULT, "load_friction", *CONTACT_FRICTION, "tooth_stiffness", "mesh_play", "output_play", "cam_play")
"""All parameters that are no key of the design file."""


RV_NAMED = (*RV_DEFAULT, "load_friction", "tooth_stiffness")
"""The same for an RV reducer."""


def names_of(reducer: Reducer) -> tuple[str, ...]:
    """Return the names of all parameters of a reducer that are no key of the design file."""
    return FITS[reducer.LAYOUT].named


def _example_key(reducer: Reducer) -> str:
    """Return a key of the design file that can be fitted."""
    return FITS[reducer.LAYOUT].example_key


def default_keys(reducer: Reducer) -> tuple[str, ...]:
    """Return the keys of the parameters that are fitted by default."""
    return FITS[reducer.LAYOUT].default


def needs_contact_friction(reducer: Reducer, keys: Sequence[str]) -> bool:
    """Return whether fitting the parameters `keys` requires a model with friction in the contacts.

    Raises
    ------
    UsageError
        Some keys need friction in the contacts, and others (`WIND_UP_FRICTION`) represent the same friction; or the
        reducer is an RV reducer, for which there is no model with friction in the contacts at a locked sun.
    """
    contact_keys = [key for key in keys if key in CONTACT_FRICTION or key.partition(".")[0] == "friction"]
    if contact_keys and not FITS[reducer.LAYOUT].has_contact_friction:
        raise UsageError(
            f"--fit: {contact_keys[0]} cannot be fitted for an RV reducer ({reducer.design.name}), because its loops "
            "are computed without friction of the contacts. Fit hysteresis and hysteresis_travel, or load_friction"
        )
    wind_up_keys = [key for key in keys if key in WIND_UP_FRICTION]
    if contact_keys and wind_up_keys:
        raise UsageError(
            f"--fit: {wind_up_keys[0]} and {contact_keys[0]} describe the same friction, and a loop can identify only "
            "one of them. Remove one of the two"
        )
    return bool(contact_keys)


def fit_parameters(reducer: Reducer, keys: Sequence[str], loops: Sequence[MeasuredLoop]) -> tuple[Parameter, ...]:
    """Return the parameters to fit by their keys: names such as "play" (`names_of`), or numbers of the design file.

    Named parameters of stiffness, friction and hysteresis have start, scale and bounds from the measured `loops`.

    Raises
    ------
    UsageError
        There is no key, or a key is unknown, not a number, or repeated.
    """
    if not keys:
        raise UsageError(f"--fit is empty: name at least one parameter, such as {','.join(DEFAULT)}")
    if repeated_key := next((key for index, key in enumerate(keys) if key in keys[:index]), None):
        raise UsageError(f"--fit: {repeated_key} is listed twice. List each parameter once")
    parameters = _named_parameters(reducer, loops)
    names = names_of(reducer)
    return tuple(parameters[key] if key in names else _file_parameter(reducer, key) for key in keys)


def _named_parameters(reducer: Reducer, loops: Sequence[MeasuredLoop]) -> Mapping[str, Parameter]:
    """Return the parameters that are no key of the design file, by name such as "play" (`names_of`).

    They are play, stiffness, friction and hysteresis. Start, scale and bounds of the last three follow from the
    measured loops.
    """
    parameters_by_name = (
        *FITS[reducer.LAYOUT].own_parameters(reducer, loops),
        _tooth_stiffness_parameter(reducer),
        *_friction_parameters(reducer, loops),
        *_hysteresis_parameters(loops),
    )
    return {parameter.key: parameter for parameter in parameters_by_name}


def _rv_parameters(reducer: RvReducer, _loops: Sequence[MeasuredLoop]) -> tuple[Parameter, ...]:
    """Return the parameters to fit of an RV reducer: play of the teeth [um] and stiffness of the crank bearings [1].

    The play represents all clearances that differ from those of the design, because a loop shows only their sum. The
    stiffness is a factor.
    """
    clearance, tooth_kinds = reducer.design.clearance, _tooth_pairs(reducer)
    design_play = MICROMETRE.from_si(getattr(clearance, reducer.design.tooth_pair) + reducer.design.pin_play)
    bearing_stiffness = reducer.cranks.needle_stiffness, reducer.cranks.taper_stiffness

    def set_bearing_stiffness(model: Model, value: float) -> Model:
        """Return a model whose crank bearings have the stiffness of the design times a factor."""
        cranks = {"needle_stiffness": value * bearing_stiffness[0], "taper_stiffness": value * bearing_stiffness[1]}
        return replace(model, reducer=reducer_of(model.reducer.design.but(cranks=cranks)))

    return (
        Parameter(
            "play",
            "um",
            "clearance between disc and ring, including that of pins in their seats; other clearances as in the design",
            design_play,
            max(0.3 * design_play, 0.1),
            1e-3,
            BOUNDS.max_play_um,
            _play_setter(tooth_kinds),
        ),
        Parameter(
            "bearing_stiffness",
            "1",
            "stiffness of the crank bearings, relative to that of the design",
            1.0,
            0.1,
            1e-2,
            20.0,
            set_bearing_stiffness,
            logarithmic=True,
        ),
    )


def _central_parameters(reducer: Reducer, loops: Sequence[MeasuredLoop]) -> tuple[Parameter, ...]:
    """Return the parameters to fit of a drive with a central crank: clearances [um] and stiffness of the structure."""
    return (*_play_parameters(reducer), *_stiffness_parameters(reducer, loops))


class FitOfLayout(NamedTuple):
    """What can be fitted for the reducers of a layout.

    Attributes
    ----------
    named, default
        Names of all parameters that are no key of the design file, and of those that are fitted by default.
    example_key
        A key of the design file that can be fitted.
    has_contact_friction
        Whether the model of a loop can have friction in the contacts.
    own_parameters
        Function that returns the parameters of play and stiffness, from the reducer and the measured loops.
    """

    named: tuple[str, ...]
    default: tuple[str, ...]
    example_key: str
    has_contact_friction: bool
    own_parameters: Callable[[Any, Sequence[MeasuredLoop]], tuple[Parameter, ...]]


FITS: Mapping[Layout, FitOfLayout] = {
    "central": FitOfLayout(NAMED, DEFAULT, "clearance.output_um", True, _central_parameters),
    "rv": FitOfLayout(RV_NAMED, RV_DEFAULT, "planet.backlash_um", False, _rv_parameters),
}
"""Layout -> what can be fitted."""


def _tooth_pairs(reducer: Reducer) -> tuple[str, ...]:
    """Return the kinds of pairs between disc and ring: teeth, and seats of pins where they have play."""
    design = reducer.design
    return (design.tooth_pair, *([design.seat_pair] if design.seat_pair else []))


def _play_parameters(reducer: Reducer) -> tuple[Parameter, ...]:
    """Return the clearances that can be fitted [um]: of mesh, output pins and cam, and of mesh and output together.

    The last parameter sets mesh and output to a common value. The mesh includes the play of ring pins in their sockets.
    The tolerances of the design are the priors.
    """
    design = reducer.design
    tooth_pair, clearance, tooth_kinds = design.tooth_pair, design.clearance, _tooth_pairs(reducer)
    mesh_play = getattr(clearance, tooth_pair) + design.pin_play
    to_micrometres, zones = MICROMETRE.from_si, tolerance_zones(reducer)

    def make_play(key: str, meaning: str, start: float, *kinds: str) -> Parameter:
        """Return the clearance of the `kinds` of mating pairs as a fit parameter [um], with its tolerances as prior.

        `key` and `meaning` are those of the parameter, `start` is the design's clearance [m].
        """
        zone_keys = [
            zone_key
            for zone_key in SHIFTING
            if zone_key in zones and {"teeth": tooth_pair}.get(SHIFTING[zone_key], SHIFTING[zone_key]) in kinds
        ]
        scale, set_play = max(0.3 * to_micrometres(start), 0.1), _play_setter(kinds)
        parameter = Parameter(key, "um", meaning, to_micrometres(start), scale, 1e-3, BOUNDS.max_play_um, set_play)
        if not zone_keys:
            return parameter
        mean_square = sum(
            zones[zone_key].standard_deviation ** 2 + zones[zone_key].middle ** 2 for zone_key in zone_keys
        )
        source = f"tolerance: {', '.join(zone_keys)}"
        return replace(parameter, deviation=to_micrometres(math.sqrt(mean_square)), source=source)

    return (
        make_play(
            "mesh_play",
            "clearance between disc and ring, including that of pins in their seats",
            mesh_play,
            *tooth_kinds,
        ),
        make_play("output_play", "clearance of the output pins in their holes", clearance.output, "output"),
        make_play("cam_play", "clearance of the cam in the disc's bore", clearance.cam, "cam"),
        make_play("play", "clearance of teeth and holes, the same for both", mesh_play, *tooth_kinds, "output"),
    )


def _stiffness_parameters(reducer: Reducer, loops: Sequence[MeasuredLoop]) -> tuple[Parameter, ...]:
    """Return the parameter of the structure's torsional stiffness at the output [N m/rad] for a fit, a tuple of one.

    Its search starts from twice the largest torque of all `loops`, divided by the range of deflection of the loop with
    this torque. It starts from half of the largest possible stiffness if that is lower.
    """
    largest_loop = max(loops, key=attrgetter("most"))
    stiffness, max_stiffness = 2.0 * largest_loop.most / largest_loop.height, _max_structure_stiffness(reducer)
    return (
        Parameter(
            "structure_stiffness",
            "N m/rad",
            "torsional stiffness at the output of housing, discs, shafts and mounting",
            min(stiffness, 0.5 * max_stiffness),
            0.1,
            1e-2 * stiffness,
            max_stiffness,
            _set_structure_stiffness,
            logarithmic=True,
        ),
    )


def _tooth_stiffness_parameter(reducer: Reducer) -> Parameter:
    """Return the factor on the stiffness of the tooth contacts [1], as a parameter to fit."""
    return Parameter(
        "tooth_stiffness",
        "1",
        "stiffness of the teeth and their support, relative to that of their contacts alone",
        1.0,
        0.1,
        1e-3,
        20.0,
        _stiffness_setter(_tooth_pairs(reducer)),
        logarithmic=True,
    )


def _friction_parameters(reducer: Reducer, loops: Sequence[MeasuredLoop]) -> tuple[Parameter, ...]:
    """Return the four parameters of friction that can be fitted to loops.

    They are the coefficient of friction of the contacts [1], friction in proportion to the load [1], constant friction
    [N m], and the rotation over which the constant friction builds up [deg]. The search for the constant friction
    starts from the Coulomb torque of the loop with the smallest range of deflection, that for the rotation from 5 % of
    that range.
    """
    max_torque, smallest_loop = max(loop.most for loop in loops), min(loops, key=attrgetter("height"))
    height_deg, coulomb_torque = smallest_loop.height / DEGREE, loop_coulomb_torque(smallest_loop).value
    start_drag = coulomb_torque if 0.0 < coulomb_torque < BOUNDS.max_drag * max_torque else 0.02 * max_torque
    friction = reducer.design.friction_of(reducer.design.tooth_pair) or 0.05
    return (
        Parameter(
            "friction",
            "1",
            "coefficient of friction of all sliding contacts: teeth, seats of pins, and holes and cam without rollers",
            friction,
            max(0.2 * friction, 0.01),
            0.0,
            BOUNDS.max_friction,
            _set_friction,
        ),
        Parameter(
            "load_friction",
            "1",
            "friction relative to the torque that the contacts carry; it builds up over drag_travel",
            0.2,
            0.05,
            0.0,
            BOUNDS.max_load_friction,
            lambda model, value: replace(model, losses=replace(model.losses, load=value)),
        ),
        Parameter(
            "drag",
            "N m",
            "constant friction, at the output",
            start_drag,
            0.02 * max_torque,
            0.0,
            BOUNDS.max_drag * max_torque,
            _set_drag,
        ),
        Parameter(
            "drag_travel",
            "deg",
            "rotation of the output over which the constant friction builds up",
            0.05 * height_deg,
            0.05 * height_deg,
            BOUNDS.min_travel * height_deg,
            height_deg,
            _set_drag_travel,
        ),
    )


def _hysteresis_parameters(loops: Sequence[MeasuredLoop]) -> tuple[Parameter, ...]:
    """Return the three parameters of hysteresis that can be fitted to loops, by friction or by the material.

    They are the friction torque [N m] that builds up gradually with the wind-up; its travel [deg], which is the
    rotation over which it builds up; and the material loss, which is the fraction [1] of each contact's force that its
    material loses while it is unloaded. Start and scale of the first two are fractions of torque and range of
    deflection of the loop with the largest torque.
    """
    largest_loop = max(loops, key=attrgetter("most"))
    max_torque, largest_height, smallest_height = (
        largest_loop.most,
        largest_loop.height / DEGREE,
        min(loop.height for loop in loops) / DEGREE,
    )
    return (
        Parameter(
            "hysteresis",
            "N m",
            "friction at the output that builds up gradually, as in loaded seats and plastics",
            0.1 * max_torque,
            0.02 * max_torque,
            0.0,
            2.0 * max_torque,
            lambda model, value: _with_spring(model, "hysteresis", value),
        ),
        Parameter(
            "hysteresis_travel",
            "deg",
            "rotation of the output over which the hysteresis builds up",
            0.2 * largest_height,
            0.05 * largest_height,
            0.2 * smallest_height,
            2.0 * largest_height,
            lambda model, value: _with_spring(model, "hysteresis_travel", DEGREE * value),
        ),
        Parameter(
            "material_loss",
            "1",
            "share of each contact's force that its material loses while it is unloaded",
            0.05,
            0.05,
            0.0,
            0.95,
            lambda model, value: replace(model, losses=replace(model.losses, material=value)),
        ),
    )


def _play_setter(kinds: Sequence[str]) -> Callable[[Model, float], Model]:
    """Return a function that sets the clearance of the `kinds` of mating pairs in a model.

    Its arguments are a model and the clearance [um], its result is the new model. Teeth and seats of pins together have
    this clearance, divided in the ratio of the design; output holes have all of it.
    """

    def set_clearance(model: Model, value: float) -> Model:
        clearance, new_clearance = model.reducer.design.clearance, MICROMETRE.to_si(value)
        tooth_kinds = [kind for kind in kinds if kind != "output"]
        total_clearance = sum(getattr(clearance, kind) for kind in tooth_kinds)
        clearance_changes = {kind: new_clearance * getattr(clearance, kind) / total_clearance for kind in tooth_kinds}
        clearance_changes |= {"output": new_clearance} if "output" in kinds else {}
        return replace(model, reducer=reducer_of(model.reducer.design.but(clearance=clearance_changes)))

    return set_clearance


def _stiffness_setter(kinds: Sequence[str]) -> Callable[[Model, float], Model]:
    """Return a function that multiplies the stiffness of the `kinds` of mating pairs in a model by a factor.

    Its arguments are a model and the factor [1], its result is the new model. The factor refers to the stiffness at the
    rated load.
    """

    def set_stiffness(model: Model, value: float) -> Model:
        rated_reducer = model.reducer.at_rated_load
        stiffness_changes = {kind: value * rated_reducer.contacts[kind].stiffness for kind in kinds}
        return replace(model, reducer=reducer_of(model.reducer.design.but(stiffness=stiffness_changes)))

    return set_stiffness


def _set_structure_stiffness(model: Model, value: float) -> Model:
    """Return a model whose structure has the torsional stiffness `value` at the output [N m/rad].

    Housing, carrier and shaft are in series; the stiffness of the housing is changed. `value` must be below the
    stiffness of carrier and shaft alone.
    """
    reducer = Reducer(model.reducer.design.model_copy(update={"structure": "springs"}))
    stiffness, compliance = twisting_stiffness(reducer), twisting_compliance(reducer)
    housing_compliance = 1.0 / value - compliance["carrier"] - compliance["shaft"]
    housing_stiffness = stiffness["housing"] * compliance["housing"] / housing_compliance
    return _with_spring(replace(model, reducer=reducer), "housing", housing_stiffness)


def _max_structure_stiffness(reducer: Reducer) -> float:
    """Compute the stiffness [N m/rad] of the structure with a housing that is nearly rigid."""
    compliance = twisting_compliance(Reducer(reducer.design.but(structure="springs")))
    return BOUNDS.max_structure / (compliance["carrier"] + compliance["shaft"])


def _set_friction(model: Model, value: float) -> Model:
    """Return a model with a Coulomb coefficient of all sliding pairs; rolling cams and output pins keep theirs."""
    kinds = [kind for kind in model.reducer.design.pair_kinds if kind not in _rolling_pairs(model.reducer)]
    friction = {"law": "coulomb", **dict.fromkeys(kinds, value)}
    return replace(model, reducer=reducer_of(model.reducer.design.but(friction=friction)))


def _rolling_pairs(reducer: Reducer) -> set[str]:
    is_rolling_by_kind = {"cam": reducer.design.gear.bearing == "rolling", "output": reducer.design.output.has_needles}
    return {kind for kind, is_rolling in is_rolling_by_kind.items() if is_rolling}


def _set_drag(model: Model, value: float) -> Model:
    if not model.contact_friction:
        return _with_spring(model, "friction", value)
    design = model.reducer.design.but(drag={"output": value})
    return replace(model, reducer=reducer_of(design), losses=replace(model.losses, drag=value))


def _set_drag_travel(model: Model, value: float) -> Model:
    if not model.contact_friction:
        return _with_spring(model, "friction_travel", DEGREE * value)
    return replace(model, losses=replace(model.losses, travel=DEGREE * value))


def _with_spring(model: Model, name: str, value: float) -> Model:
    """Set a value of `springs` without validation, for speed: a search stays within the bounds of the key."""
    design = model.reducer.design
    springs = design.springs.model_copy(update={name: value})
    return replace(model, reducer=reducer_of(design.model_copy(update={"springs": springs})))


def _file_parameter(reducer: Reducer, key: str) -> Parameter:
    """Return a number of the design file, by its key ``table.key``, as a parameter of a fit.

    It has the unit and the bounds of the file. Its scale in the search is a fifth of the design's value. Raises
    UsageError if there is no such key, or it is no real number.
    """
    table, _, name = key.partition(".")
    field = Design.model_fields.get(table)
    section: Any = section_of(field) if field else None
    model_names = (
        {file_key(field_name, field_info): field_name for field_name, field_info in section.model_fields.items()}
        if section
        else {}
    )
    if name not in model_names:
        raise UsageError(
            f"--fit: unknown parameter {key!r}. Choose from {', '.join(names_of(reducer))}, or any numeric key of the "
            f"design file, such as {_example_key(reducer)}"
        )
    field_info: FieldInfo = section.model_fields[model_names[name]]
    value = getattr(getattr(reducer.design, table) or reducer.design.material, model_names[name])
    if not isinstance(value, float):
        raise UsageError(
            f"--fit: {key} is {value!r}, but only keys with a single real (non-integer) value can be fitted. Choose "
            f"another key, such as {_example_key(reducer)}"
        )
    unit = unit_of(field_info)
    start = unit.from_si(value)
    bounds = bounds_of(field_info)
    lower_bound = unit.from_si(bounds.get("ge", bounds.get("gt", -1e12)))
    upper_bound = unit.from_si(bounds.get("le", bounds.get("lt", 1e12)))
    scale = 0.2 * abs(start) or 1e-3 * min(abs(upper_bound), 1e3)

    def set_value(model: Model, value: float) -> Model:
        try:
            return replace(model, reducer=reducer_of(override(model.reducer.design, {key: value})))
        except DesignError as error:
            raise UsageError(f"--fit {key}: {error}") from error

    return Parameter(
        key, unit.suffix or "1", str(field_info.description), start, scale, lower_bound, upper_bound, set_value
    )
