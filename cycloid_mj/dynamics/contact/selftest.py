"""Self-tests of the contact code with the installed MuJoCo release.

The contact code accesses MuJoCo's own structures, which may change between releases without an error. It is therefore
tested on models with known results before its first use; a record of the success is kept for this code and release.
"""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import mujoco

from cycloid_mj.base.compile_cache import cache_folder
from cycloid_mj.dynamics.contact import sample_layout
from cycloid_mj.dynamics.contact.forces import PairIndex, pair_index
from cycloid_mj.dynamics.contact.gap import NO_WAVES, Flank, Trochoid
from cycloid_mj.dynamics.contact.library import (
    CYLINDER,
    TYPES,
    callback,
    collision_table,
    incompatible_error,
    set_callback,
)
from cycloid_mj.dynamics.contact.teeth import USER_DATA, Teeth, user_data
from cycloid_mj.reducer.bodies import Role


class SelfTestSettings(NamedTuple):
    """Dimensions of the test models, and the allowed error of their forces."""

    gravity: float = 9.81
    """Gravity [m/s2]."""
    settled: int = 500
    """Number of steps after which the parts are at rest."""
    rtol: float = 1e-6
    """Largest relative error of a force."""
    radius: float = 40e-3
    eccentricity: float = 1e-3
    teeth: int = 12
    pin_radius: float = 3e-3
    """Pin circle, eccentricity, teeth and pins of a ring [m]."""
    clearance: float = 1e-5
    """Gap between a disc and a pin in one of its valleys [m]."""
    friction: float = 0.5
    sliding_speed: float = 5.0
    """Friction [1] and speed [m/s] of feet that slide."""
    evaluations: int = 5
    """Evaluations of the sliding forces: each reduces their error to friction squared times the added mass, 0.25 % of
    the mass of a foot."""
    half_play: float = 0.5e-3
    """Half of the play of a cylinder in a bore [m]."""
    offset: tuple[float, float] = (0.3e-3, -0.2e-3)
    """Initial position of the cylinder, from which it slides on outwards [m]."""


TEST = SelfTestSettings()

_SOFT = 'solref="0.002 1" solimp="0.9 0.9 0.001"'
OPTION = f'<option timestep="1e-4" gravity="0 {-TEST.gravity} 0" tolerance="0"/>'


def require_passed(part: str, test: Callable[[], str]) -> None:
    """Run the self-test of a part of the contact code, unless a record shows that it has passed before.

    Parameters
    ----------
    part
        Name of the part; its record in the cache has the same name.
    test
        Function that runs the test and returns a description of the failure, "" for none.

    Raises
    ------
    ContactError
        The test failed; the message names the releases that are known to work.
    """
    record = _record(part)
    if record and record.exists():
        return
    if failure := test():
        raise incompatible_error(f"{part}: {failure}")
    if record:
        try:
            record.touch()
        except OSError:  # it is tried again by the next process
            return


def try_collider(address: int) -> str:
    """Test the collision function of pins and bores at an address with a small model; return the failure, "" for none.

    Gaps are compared with their known values, and the forces of parts at rest with their weights.
    """
    pin_data = f"{0.0} {1.0}" + " 0" * (USER_DATA - 2)
    trochoid = Trochoid(TEST.radius, TEST.eccentricity, float(TEST.teeth))
    flank = Flank(trochoid, TEST.pin_radius + TEST.clearance, 0.0, 0.0, 0.0, 0.0, 0.0, NO_WAVES)
    teeth_data = " ".join(map(repr, user_data(Teeth(flank, 0.0, 0.0, 0.0, trochoid))))
    core_offset = math.hypot(*TEST.offset)
    model = mujoco.MjModel.from_xml_string(f"""
<mujoco>{OPTION}<size nuser_geom="{USER_DATA}"/>
<default><geom type="cylinder" contype="0" conaffinity="0"/>
<pair condim="1" {_SOFT}/></default><worldbody>
<geom name="teeth" size="0.05 0.01" pos="0 {TEST.eccentricity} 0" priority="{int(Role.TEETH)}" user="{teeth_data}"/>
<body pos="0 {TEST.radius} 0"><joint type="slide" axis="0 1 0"/><geom name="pin" size="{TEST.pin_radius} 0.01" mass="1"
  priority="{int(Role.PIN)}" user="{pin_data}"/></body>
<geom name="bore" size="0.02 0.01" priority="{int(Role.OUTER)}"/>
<body pos="{TEST.offset[0]} {TEST.offset[1]} 0"><joint type="slide" axis="{TEST.offset[0]} {TEST.offset[1]} 0"/>
<geom name="core" size="{0.02 - TEST.half_play} 0.01" mass="2"
  priority="{int(Role.INNER)}"/></body>
</worldbody><contact>
<pair geom1="teeth" geom2="pin"/>
<pair geom1="bore" geom2="core"/>
</contact></mujoco>""")
    data, table, entry = mujoco.MjData(model), collision_table(), CYLINDER * TYPES + CYLINDER
    original_address = table[entry]
    table[entry] = address
    try:
        model.pair_margin[:] = 1e-3  # for gaps to be contacts
        mujoco.mj_forward(model, data)
        gaps = _values_by_mass(model, data, data.contact.dist.copy())
        expected_gaps = {1.0: TEST.clearance, 2.0: TEST.half_play - core_offset}
        if gaps.keys() != expected_gaps.keys() or any(
            abs(gaps[mass] - gap) > 1e-12 for mass, gap in expected_gaps.items()
        ):
            return f"gaps of {sorted(gaps.values())} m where {sorted(expected_gaps.values())} m are"
        model.pair_margin[:] = 0.0
        mujoco.mj_step(model, data, TEST.settled)
        mujoco.mj_forward(model, data)
        forces = _values_by_mass(model, data, data.efc_force.copy())
    finally:
        table[entry] = original_address
    return describe_difference(forces, {1.0: TEST.gravity, 2.0: -2.0 * TEST.gravity * TEST.offset[1] / core_offset})


def try_correction(address: int) -> str:
    """Test the correction of sliding contacts (``mjcb_control``) at an address; return the failure, "" for none.

    Spheres at rest start to slide along the floor; they must press on it by their weights, as without friction.
    """
    soft_contact = 'solref="0.002 1" solimp="0.01 0.01 0.001"'
    weights = {mass: mass * TEST.gravity for mass in (1.0, 2.0, 3.0)}
    sphere_bodies = "".join(
        f'<body pos="{mass} 0.1 0"><joint type="slide" axis="0 1 0"/><joint type="slide" axis="1 0 0"/>'
        f'<geom name="foot{mass:g}" type="sphere" size="0.1" mass="{mass}"/></body>'
        for mass in weights
    )
    pairs = "".join(
        f'<pair geom1="floor" geom2="foot{mass:g}" condim="{1 if mass == 2.0 else 3}" '
        f'friction="{TEST.friction} {TEST.friction}" {soft_contact}/>'
        for mass in weights
    )
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="1e-4" gravity="0 {-TEST.gravity} 0" tolerance="0" cone="elliptic" impratio="2"/>'
        f'<size nuser_geom="{USER_DATA}" nuserdata="1"/><default><geom contype="0" conaffinity="0"/></default>'
        f'<worldbody><geom name="floor" type="plane" size="9 9 1" zaxis="0 1 0"/>{sphere_bodies}</worldbody>'
        f"<contact>{pairs}</contact></mujoco>"
    )
    data = mujoco.MjData(model)
    set_callback("mjcb_control", address)
    try:
        mujoco.mj_step(model, data, TEST.settled)
        data.qvel[1::2] = TEST.sliding_speed
        for _ in range(TEST.evaluations):  # each one knows the accelerations of that before
            mujoco.mj_forward(model, data)
    finally:
        callback("mjcb_control").value = None
    return describe_difference(_values_by_mass(model, data, data.efc_force[data.contact.efc_address]), weights)


def try_steps(add_sensor: Callable[[Any], None], each_step: Callable[[Any, Any, PairIndex, int], Any]) -> str:
    """Test the code that takes and samples the time steps of a run; return the failure in words, "" for none.

    The sampled forces on two balls at rest are compared with their weights. `add_sensor` and `each_step` are the tested
    function and class of the module ``each_step``; the latter is called with model, data, pairs and steps per sample.
    """
    weights = {"light": TEST.gravity, "heavy": 3.0 * TEST.gravity}
    balls = "".join(
        f'<body pos="{ball} 0.1 0"><joint type="slide" axis="0 1 0"/>'
        f'<geom name="{name}" type="sphere" size="0.1" mass="{weights[name] / TEST.gravity}" condim="1" '
        f"{_SOFT}/></body>"
        for ball, name in enumerate(weights)
    )
    spec = mujoco.MjSpec.from_string(
        f"<mujoco>{OPTION}<worldbody>"
        f'<geom name="floor" type="plane" size="9 9 1" zaxis="0 1 0" condim="1" {_SOFT}/>{balls}</worldbody></mujoco>'
    )
    add_sensor(spec)
    model = spec.compile()
    data, pairs = mujoco.MjData(model), [_Pair(name, "floor") for name in weights]
    run = each_step(model, data, pair_index(model, pairs), TEST.settled)
    sample = run.advance(3)[-1]
    pair_columns = sample[run.pairs].reshape(len(pairs), sample_layout.OF_PAIR)
    upward_forces, peak_forces = (
        {name: float(force) for name, force in zip(weights, pair_columns[:, column], strict=True)}
        for column in (sample_layout.FORCE_Y, sample_layout.PEAK_FORCE)
    )
    if sample[run.solver][0] != len(pairs):
        return f"{sample[run.solver][0]:g} contacts carry where {len(pairs)} do"
    return describe_difference(upward_forces, weights) or describe_difference(peak_forces, weights)


class _Pair(NamedTuple):
    on: str
    by: str


def describe_difference(forces: dict[Any, float], weights: dict[Any, float]) -> str:
    """Describe how forces differ from the weights that they carry [N]; "" if they agree."""
    if forces.keys() == weights.keys() and all(
        abs(forces[key] - weight) <= TEST.rtol * weight for key, weight in weights.items()
    ):
        return ""
    return f"forces of {sorted(forces.values())} N under weights of {sorted(weights.values())} N"


def _values_by_mass(model: Any, data: Any, values: Any) -> dict[float, float]:
    """Return the element of `values` that belongs to each contact in MuJoCo's `data`, by the mass of the body [kg].

    They are gaps or forces. The mass is that of the moving body in contact, in `model`. The result is empty if the
    number of `values` is not the number of contacts.
    """
    if len(values) != data.ncon:
        return {}
    return {
        float(model.body_mass[model.geom_bodyid[geoms].max()]): float(value)
        for geoms, value in zip(data.contact.geom, values, strict=True)
    }


def _record(part: str) -> Path | None:
    """Return the file that records a passed self-test of this code and this build of MuJoCo."""
    cache = cache_folder()
    if cache is None:
        return None
    library_status = Path(mujoco.__file__).stat()
    return cache / f"mujoco-{mujoco.__version__}-{part}-{library_status.st_mtime_ns}-{library_status.st_size}.passed"
