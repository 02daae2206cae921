"""What a calibration can fit: names for the values that a loop depends on, beside every number of the design file."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import Any

from pydantic.fields import FieldInfo

from cycloid_mj.base.errors import DesignError, UsageError
from cycloid_mj.base.units import DEGREE
from cycloid_mj.bench.loop import MeasuredLoop
from cycloid_mj.bench.loop_figures import coulomb_of
from cycloid_mj.design import Design, override
from cycloid_mj.design.units import MICROMETRE, file_key, section_of, unit_of
from cycloid_mj.explore.sampling import tolerances
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.friction_path import Losses
from cycloid_mj.statics.structure import twisting_compliance, twisting_stiffness

MOST_PLAY = 900.0
"""Largest clearance that is looked for [um]."""

MOST_DRAG = 0.9
"""Constant friction that is looked for at most, over the largest torque of the loops."""

SOONEST = 0.01
"""Turn over which friction comes on at least, over the height of the lowest loop: what is sooner no loop shows, and in
MuJoCo a spring as stiff would need an armature that makes the joint slow."""

STIFFEST = 0.95
"""Stiffness of the structure that is looked for at most, over that of carrier and shaft alone."""


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
"""Tolerances that move a clearance, and which."""


@dataclass(frozen=True)
class Model:
    """A design, and the losses of a loop that a design file does not hold.

    Attributes
    ----------
    reducer
        As the values that are fitted make it.
    losses
        Beside those of contacts that rub.
    rubs
        Whether the contacts' own friction is followed (`statics.friction_path`); else the friction of the wind-up
        stands for all of it (`statics.locked`).
    """

    reducer: Reducer
    losses: Losses
    rubs: bool = True


@dataclass(frozen=True)
class Parameter:
    """One fitted value, in the unit in which it is printed.

    Attributes
    ----------
    key, unit, meaning
        Its name on the command line and in JSON, its unit, and what it is.
    start, scale
        Where the search begins, and a step that matters.
    least, most
        Its bounds.
    put
        A model with another value of it.
    by_factor
        Whether it is looked for by factors, as what is known to within a decade at first; `scale` is then one of them.
    deviation, source
        Standard deviation about `start` that is known without the loops, and what says so; inf where nothing does.
    """

    key: str
    unit: str
    meaning: str
    start: float
    scale: float
    least: float
    most: float
    put: Callable[[Model, float], Model]
    by_factor: bool = False
    deviation: float = math.inf
    source: str = ""

    @property
    def place_deviation(self) -> float:
        """How far it may be from where the search begins, without the loops: standard deviation on its scale."""
        return self.deviation / self.scale

    def place(self, value: float) -> float:
        """Compute where a value is on the scale on which it is looked for."""
        return math.log(value) / self.scale if self.by_factor else value / self.scale

    def value(self, place: float) -> float:
        """Compute the value at a place, or the bound that is nearest to it."""
        value = math.exp(self.scale * place) if self.by_factor else self.scale * place
        return min(max(value, self.least), self.most)


DEFAULT = ("play", "structure_stiffness", "drag", "drag_travel", "hysteresis", "hysteresis_travel")
"""What is fitted unless something else is asked for: a loop shows the sum of the clearances, not each of them."""

RUBBING = ("friction", "material_loss")
"""Names that need contacts that rub."""

STANDS_FOR_RUBBING = ("hysteresis", "hysteresis_travel", "load_friction")
"""Names that stand for the friction of the contacts."""

MAX_LOAD_FRICTION = 0.8
"""Largest `load_friction` that is fitted [1]: at 1 a loaded drive would lock itself."""

NAMED = (*DEFAULT, "load_friction", *RUBBING, "tooth_stiffness", "mesh_play", "output_play", "cam_play")
"""Every name that is no key of the design file."""


def rub(keys: Sequence[str]) -> bool:
    """Tell whether values are those of contacts that rub.

    Raises
    ------
    UsageError
        Others of them stand for what such contacts hold back.
    """
    rubbing = [key for key in keys if key in RUBBING or key.startswith("friction.")]
    standing = [key for key in keys if key in STANDS_FOR_RUBBING]
    if rubbing and standing:
        raise UsageError(
            f"--fit: {standing[0]} stands for what {rubbing[0]} would hold back, so that one loop tells neither: "
            "leave one of them out"
        )
    return bool(rubbing)


def parameters(reducer: Reducer, keys: Sequence[str], loops: Sequence[MeasuredLoop]) -> tuple[Parameter, ...]:
    """List the parameters of some keys: where the search for them begins, on which scale and between which bounds.

    Raises
    ------
    UsageError
        A key is unknown, is no number, or is given twice.
    """
    if not keys:
        raise UsageError(f"--fit: give what to fit, such as {','.join(DEFAULT)}")
    if twice := next((key for place, key in enumerate(keys) if key in keys[:place]), None):
        raise UsageError(f"--fit: {twice} is given twice")
    known = _named(reducer, loops)
    return tuple(known[key] if key in known else _of_file(reducer, key) for key in keys)


def _named(reducer: Reducer, loops: Sequence[MeasuredLoop]) -> Mapping[str, Parameter]:
    design = reducer.design
    loaded, lowest = max(loops, key=attrgetter("most")), min(loops, key=attrgetter("height"))
    most, widest = loaded.most, loaded.height / DEGREE
    turn, coulomb = lowest.height / DEGREE, coulomb_of(lowest).value
    drag = coulomb if 0.0 < coulomb < MOST_DRAG * most else 0.02 * most
    tooth, clearance = design.tooth_pair, design.clearance
    mesh = getattr(clearance, tooth) + design.pin_play
    um = MICROMETRE.from_si

    zones = tolerances(reducer)

    def play(key: str, meaning: str, start: float, *kinds: str) -> Parameter:
        shifting = [
            one for one in SHIFTING if one in zones and {"teeth": tooth}.get(SHIFTING[one], SHIFTING[one]) in kinds
        ]
        parameter = Parameter(key, "um", meaning, um(start), max(0.3 * um(start), 0.1), 1e-3, MOST_PLAY, _plays(kinds))
        if not shifting:
            return parameter
        squares = sum(zones[one].deviation ** 2 + zones[one].middle ** 2 for one in shifting)
        source = f"tolerance: {', '.join(shifting)}"
        return replace(parameter, deviation=um(math.sqrt(squares)), source=source)

    mated = (tooth, *([design.seat_pair] if design.seat_pair else []))
    friction = design.friction_of(tooth) or 0.05
    stiffness, most_stiff = 2.0 * loaded.most / loaded.height, _most_structure(reducer)
    named = (
        play("mesh_play", "clearance between gear and ring, that of pins in their seats counted in", mesh, *mated),
        play("output_play", "clearance of the output pins in their holes", clearance.output, "output"),
        play("cam_play", "clearance of the cam in the gear's bore", clearance.cam, "cam"),
        play("play", "one clearance for teeth and holes alike", mesh, *mated, "output"),
        Parameter(
            "tooth_stiffness",
            "1",
            "stiffness of the teeth and of what carries them, over that of their contacts alone",
            1.0,
            0.1,
            1e-3,
            20.0,
            _stiffness(mated),
            by_factor=True,
        ),
        Parameter(
            "structure_stiffness",
            "N m/rad",
            "torsional stiffness at the output of what carries the contacts: housing, discs, shafts, mounting",
            min(stiffness, 0.5 * most_stiff),
            0.1,
            1e-2 * stiffness,
            most_stiff,
            _structure,
            by_factor=True,
        ),
        Parameter(
            "friction",
            "1",
            "coefficient of friction of all that slides: teeth, seats of pins, and holes and cam without rollers",
            friction,
            max(0.2 * friction, 0.01),
            0.0,
            1.5,
            _friction,
        ),
        Parameter("drag", "N m", "constant friction, at the output", drag, 0.02 * most, 0.0, MOST_DRAG * most, _drag),
        Parameter(
            "drag_travel",
            "deg",
            "turn of the output over which the constant friction comes on",
            0.05 * turn,
            0.05 * turn,
            SOONEST * turn,
            turn,
            _drag_travel,
        ),
        Parameter(
            "hysteresis",
            "N m",
            "friction at the output that comes on little by little, as of loaded seats and of plastics",
            0.1 * most,
            0.02 * most,
            0.0,
            2.0 * most,
            lambda model, value: _of_springs(model, "hysteresis", value),
        ),
        Parameter(
            "hysteresis_travel",
            "deg",
            "turn of the output over which that comes on",
            0.2 * widest,
            0.05 * widest,
            0.2 * turn,
            2.0 * widest,
            lambda model, value: _of_springs(model, "hysteresis_travel", DEGREE * value),
        ),
        Parameter(
            "load_friction",
            "1",
            "friction over the torque that the contacts carry; it comes on over drag_travel",
            0.2,
            0.05,
            0.0,
            MAX_LOAD_FRICTION,
            lambda model, value: replace(model, losses=replace(model.losses, load=value)),
        ),
        Parameter(
            "material_loss",
            "1",
            "share of every contact's force that its material holds back while it is let go",
            0.05,
            0.05,
            0.0,
            0.95,
            lambda model, value: replace(model, losses=replace(model.losses, material=value)),
        ),
    )
    return {one.key: one for one in named}


def _plays(kinds: Sequence[str]) -> Callable[[Model, float], Model]:
    """Share a clearance out to kinds of pairs: to teeth and seats in the proportion that they have, all to others."""

    def put(model: Model, value: float) -> Model:
        clearance, total = model.reducer.design.clearance, MICROMETRE.to_si(value)
        mated = [kind for kind in kinds if kind != "output"]
        whole = sum(getattr(clearance, kind) for kind in mated)
        change = {kind: total * getattr(clearance, kind) / whole for kind in mated}
        change |= {"output": total} if "output" in kinds else {}
        return replace(model, reducer=Reducer(model.reducer.design.but(clearance=change)))

    return put


def _stiffness(kinds: Sequence[str]) -> Callable[[Model, float], Model]:
    def put(model: Model, value: float) -> Model:
        rated = model.reducer.at_rated_load
        change = {kind: value * rated.contacts[kind].stiffness for kind in kinds}
        return replace(model, reducer=Reducer(model.reducer.design.but(stiffness=change)))

    return put


def _structure(model: Model, value: float) -> Model:
    """Put into the housing what the structure gives beyond carrier and shaft: all that twists turns the output."""
    reducer = Reducer(model.reducer.design.model_copy(update={"structure": "springs"}))
    stiffness, compliance = twisting_stiffness(reducer), twisting_compliance(reducer)
    rest = 1.0 / value - compliance["carrier"] - compliance["shaft"]
    housing = stiffness["housing"] * compliance["housing"] / rest
    return _of_springs(replace(model, reducer=reducer), "housing", housing)


def _most_structure(reducer: Reducer) -> float:
    """Compute the stiffness [N m/rad] that a structure has whose housing hardly gives."""
    compliance = twisting_compliance(Reducer(reducer.design.but(structure="springs")))
    return STIFFEST / (compliance["carrier"] + compliance["shaft"])


def _friction(model: Model, value: float) -> Model:
    kinds = [kind for kind in model.reducer.design.pair_kinds if kind not in _rolling(model.reducer)]
    return replace(model, reducer=Reducer(model.reducer.design.but(friction=dict.fromkeys(kinds, value))))


def _rolling(reducer: Reducer) -> set[str]:
    rolls = {"cam": reducer.design.gear.bearing == "rolling", "output": reducer.design.output.has_needles}
    return {kind for kind, rolling in rolls.items() if rolling}


def _drag(model: Model, value: float) -> Model:
    if not model.rubs:
        return _of_springs(model, "friction", value)
    design = model.reducer.design.but(drag={"output": value})
    return replace(model, reducer=Reducer(design), losses=replace(model.losses, drag=value))


def _drag_travel(model: Model, value: float) -> Model:
    if not model.rubs:
        return _of_springs(model, "friction_travel", DEGREE * value)
    return replace(model, losses=replace(model.losses, travel=DEGREE * value))


def _of_springs(model: Model, name: str, value: float) -> Model:
    """Put a value that is within the bounds of its key: a search does so at each step, so that nothing is checked."""
    design = model.reducer.design
    springs = design.springs.model_copy(update={name: value})
    return replace(model, reducer=Reducer(design.model_copy(update={"springs": springs})))


def _of_file(reducer: Reducer, key: str) -> Parameter:
    """Read a number of the design file as a parameter."""
    table, _, name = key.partition(".")
    field = Design.model_fields.get(table)
    section: Any = section_of(field) if field else None
    names = {file_key(one, declared): one for one, declared in section.model_fields.items()} if section else {}
    if name not in names:
        raise UsageError(
            f"--fit: there is nothing to fit called {key!r}; give {', '.join(NAMED)}, or a key of the design file, "
            "such as clearance.output_um"
        )
    declared: FieldInfo = section.model_fields[names[name]]
    value = getattr(getattr(reducer.design, table) or reducer.design.material, names[name])
    if not isinstance(value, float):
        raise UsageError(f"--fit: {key} is {value!r}: only a number that can change little by little can be fitted")
    unit = unit_of(declared)
    start = unit.from_si(value)
    bounds = {
        side: getattr(one, side) for one in declared.metadata for side in ("gt", "ge", "lt", "le") if hasattr(one, side)
    }
    least = unit.from_si(bounds.get("ge", bounds.get("gt", -1e12)))
    most = unit.from_si(bounds.get("le", bounds.get("lt", 1e12)))
    scale = 0.2 * abs(start) or 1e-3 * min(abs(most), 1e3)

    def put(model: Model, value: float) -> Model:
        try:
            return replace(model, reducer=Reducer(override(model.reducer.design, {key: value})))
        except DesignError as error:
            raise UsageError(f"--fit {key}: {error}") from error

    return Parameter(key, unit.suffix or "1", str(declared.description), start, scale, least, most, put)
