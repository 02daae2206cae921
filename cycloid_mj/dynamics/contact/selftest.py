"""Self-tests of the contact code with the installed MuJoCo release.

The contact code accesses MuJoCo's own structures, which may change between releases without an error. It is therefore
tested on models with known results before its first use; a record of the success is kept for this code and release.
"""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import mujoco

from cycloid_mj.base.compile_cache import folder
from cycloid_mj.dynamics.contact import sample_layout
from cycloid_mj.dynamics.contact.forces import PairIndex, pair_index
from cycloid_mj.dynamics.contact.gap import NO_WAVES, Flank, Trochoid
from cycloid_mj.dynamics.contact.library import CYLINDER, TYPES, answer, callback, collision_table, unfit
from cycloid_mj.dynamics.contact.teeth import USER_DATA, Teeth, user_data
from cycloid_mj.reducer.bodies import Role

GRAVITY, SETTLED = 9.81, 500
"""Gravity [m/s2] of the test models, and the number of steps after which their parts are at rest."""

LARGEST_ERROR = 1e-6
"""Largest relative error of a force."""

_SOFT = 'solref="0.002 1" solimp="0.9 0.9 0.001"'
OPTION = f'<option timestep="1e-4" gravity="0 {-GRAVITY} 0" tolerance="0"/>'
_RADIUS, _CRANK, _TEETH, _PIN, _CLEARANCE = 40e-3, 1e-3, 12, 3e-3, 1e-5
"""Gap between a disc and a pin in one of its valleys [m]."""

_RUBBING, _SLIDING, _FORWARDS = 0.5, 5.0, 5
"""Friction and speed [m/s] of feet that slide, and how often their forces are computed: each time friction squared
times the added mass, 0.25 % of their mass, is left of what the time before was wrong by."""

_BORE, _ASIDE = 0.5e-3, (0.3e-3, -0.2e-3)
"""Half the play of a cylinder in a bore, and its place there, from which it slides on outwards [m]."""


def require_passed(part: str, trial: Callable[[], str]) -> None:
    """Run the self-test of a part of the contact code, unless it has passed before.

    Parameters
    ----------
    part
        Name of the part, and of its record.
    trial
        Returns a description of the failure; empty if there is none.

    Raises
    ------
    ContactError
        Something is wrong; the message names the releases that are known to work.
    """
    record = _record(part)
    if record and record.exists():
        return
    if wrong := trial():
        raise unfit(f"{part}: {wrong}")
    if record:
        try:
            record.touch()
        except OSError:  # it is tried again by the next process
            return


def try_collider(address: int) -> str:
    """Test the collider of pins and bores at an address; return the failure, "" for none."""
    pin = f"{0.0} {1.0}" + " 0" * (USER_DATA - 2)
    gear = Trochoid(_RADIUS, _CRANK, float(_TEETH))
    flank = Flank(gear, _PIN + _CLEARANCE, 0.0, 0.0, 0.0, 0.0, 0.0, NO_WAVES)
    numbers = " ".join(map(repr, user_data(Teeth(flank, 0.0, 0.0, 0.0, gear))))
    outwards = math.hypot(*_ASIDE)
    model = mujoco.MjModel.from_xml_string(f"""
<mujoco>{OPTION}<size nuser_geom="{USER_DATA}"/>
<default><geom type="cylinder" contype="0" conaffinity="0"/>
<pair condim="1" {_SOFT}/></default><worldbody>
<geom name="teeth" size="0.05 0.01" pos="0 {_CRANK} 0" priority="{int(Role.TEETH)}" user="{numbers}"/>
<body pos="0 {_RADIUS} 0"><joint type="slide" axis="0 1 0"/><geom name="pin" size="{_PIN} 0.01" mass="1"
  priority="{int(Role.PIN)}" user="{pin}"/></body>
<geom name="bore" size="0.02 0.01" priority="{int(Role.OUTER)}"/>
<body pos="{_ASIDE[0]} {_ASIDE[1]} 0"><joint type="slide" axis="{_ASIDE[0]} {_ASIDE[1]} 0"/>
<geom name="core" size="{0.02 - _BORE} 0.01" mass="2"
  priority="{int(Role.INNER)}"/></body>
</worldbody><contact>
<pair geom1="teeth" geom2="pin"/>
<pair geom1="bore" geom2="core"/>
</contact></mujoco>""")
    data, table, entry = mujoco.MjData(model), collision_table(), CYLINDER * TYPES + CYLINDER
    original = table[entry]
    table[entry] = address
    try:
        model.pair_margin[:] = 1e-3  # for gaps to be contacts
        mujoco.mj_forward(model, data)
        gaps = _by_mass(model, data, data.contact.dist.copy())
        wanted = {1.0: _CLEARANCE, 2.0: _BORE - outwards}
        if gaps.keys() != wanted.keys() or any(abs(gaps[mass] - gap) > 1e-12 for mass, gap in wanted.items()):
            return f"gaps of {sorted(gaps.values())} m where {sorted(wanted.values())} m are"
        model.pair_margin[:] = 0.0
        mujoco.mj_step(model, data, SETTLED)
        mujoco.mj_forward(model, data)
        forces = _by_mass(model, data, data.efc_force.copy())
    finally:
        table[entry] = original
    return differing(forces, {1.0: GRAVITY, 2.0: -2.0 * GRAVITY * _ASIDE[1] / outwards})


def try_lift(address: int) -> str:
    """Test the correction of sliding contacts (``mjcb_control``) at an address; return the failure, "" for none.

    Feet at rest start to slide along the floor; they must press on it by their weights, as without friction.
    """
    soft = 'solref="0.002 1" solimp="0.01 0.01 0.001"'
    weights = {mass: mass * GRAVITY for mass in (1.0, 2.0, 3.0)}
    feet = "".join(
        f'<body pos="{mass} 0.1 0"><joint type="slide" axis="0 1 0"/><joint type="slide" axis="1 0 0"/>'
        f'<geom name="foot{mass:g}" type="sphere" size="0.1" mass="{mass}"/></body>'
        for mass in weights
    )
    pairs = "".join(
        f'<pair geom1="floor" geom2="foot{mass:g}" condim="{1 if mass == 2.0 else 3}" '
        f'friction="{_RUBBING} {_RUBBING}" {soft}/>'
        for mass in weights
    )
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="1e-4" gravity="0 {-GRAVITY} 0" tolerance="0" cone="elliptic" impratio="2"/>'
        f'<size nuser_geom="{USER_DATA}" nuserdata="1"/><default><geom contype="0" conaffinity="0"/></default>'
        f'<worldbody><geom name="floor" type="plane" size="9 9 1" zaxis="0 1 0"/>{feet}</worldbody>'
        f"<contact>{pairs}</contact></mujoco>"
    )
    data = mujoco.MjData(model)
    answer("mjcb_control", address)
    try:
        mujoco.mj_step(model, data, SETTLED)
        data.qvel[1::2] = _SLIDING
        for _ in range(_FORWARDS):  # each one knows the accelerations of that before
            mujoco.mj_forward(model, data)
    finally:
        callback("mjcb_control").value = None
    return differing(_by_mass(model, data, data.efc_force[data.contact.efc_address]), weights)


def try_steps(add_sensor: Callable[[Any], None], each_step: Callable[[Any, Any, PairIndex, int], Any]) -> str:
    """Return the failure of the stepper of a run (``EachStep``, with its callback), "" for none.

    The sampled forces on two balls at rest are compared with their weights.
    """
    weights = {"light": GRAVITY, "heavy": 3.0 * GRAVITY}
    balls = "".join(
        f'<body pos="{x} 0.1 0"><joint type="slide" axis="0 1 0"/>'
        f'<geom name="{name}" type="sphere" size="0.1" mass="{weights[name] / GRAVITY}" condim="1" {_SOFT}/></body>'
        for x, name in enumerate(weights)
    )
    spec = mujoco.MjSpec.from_string(
        f"<mujoco>{OPTION}<worldbody>"
        f'<geom name="floor" type="plane" size="9 9 1" zaxis="0 1 0" condim="1" {_SOFT}/>{balls}</worldbody></mujoco>'
    )
    add_sensor(spec)
    model = spec.compile()
    data, pairs = mujoco.MjData(model), [_Pair(name, "floor") for name in weights]
    run = each_step(model, data, pair_index(model, pairs), SETTLED)
    row = run.advance(3)[-1]
    samples = row[run.pairs].reshape(len(pairs), sample_layout.OF_PAIR)
    upward, largest = (
        {name: float(force) for name, force in zip(weights, samples[:, column], strict=True)}
        for column in (sample_layout.FORCE_Y, sample_layout.PEAK_FORCE)
    )
    if row[run.solver][0] != len(pairs):
        return f"{row[run.solver][0]:g} contacts carry where {len(pairs)} do"
    return differing(upward, weights) or differing(largest, weights)


class _Pair(NamedTuple):
    on: str
    by: str


def differing(forces: dict[Any, float], weights: dict[Any, float], share: float = LARGEST_ERROR) -> str:
    """Describe how forces differ from the weights that they carry [N]; "" if they agree."""
    if forces.keys() == weights.keys() and all(
        abs(forces[key] - weight) <= share * weight for key, weight in weights.items()
    ):
        return ""
    return f"forces of {sorted(forces.values())} N under weights of {sorted(weights.values())} N"


def _by_mass(model: Any, data: Any, values: Any) -> dict[float, float]:
    """Map the mass of the moving body of each contact to a value; empty if their numbers differ."""
    if len(values) != data.ncon:
        return {}
    return {
        float(model.body_mass[model.geom_bodyid[geoms].max()]): float(value)
        for geoms, value in zip(data.contact.geom, values, strict=True)
    }


def _record(part: str) -> Path | None:
    """Return the file that records a passed self-test of this code and this build of MuJoCo."""
    cache = folder()
    if cache is None:
        return None
    built = Path(mujoco.__file__).stat()
    return cache / f"mujoco-{mujoco.__version__}-{part}-{built.st_mtime_ns}-{built.st_size}.passed"
