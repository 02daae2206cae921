"""Rung 3, the gear's backlash at a locked crank: 2 delta/(c (N-1)), for each kind of ring.

A small torque turns the gear from one stop to the other. delta is the normal clearance of the teeth; for free pins
that of the sockets comes on top. The cam has next to no clearance, the output's is too large to touch.
"""

import mujoco

from cycloid_mj.base.validation import ValidationRow, relative
from cycloid_mj.dynamics.contact.collider import installed
from cycloid_mj.dynamics.mjcf import ReducerModel, build
from cycloid_mj.reducer import Reducer
from cycloid_mj.validate.rig import FREE, KINDS, NONPIN, reducer_of, without_friction, without_gravity

TORQUE = 0.01
"""Torque that holds the gear at its stop [N m]: it presses the teeth in by less than a thousandth of a clearance."""
_TRAVEL, _SETTLE, _STOPS = 2000, 250, 8


def rows(quick: bool) -> list[ValidationRow]:
    """List the rows of this rung."""
    return [_row(kind) for kind in KINDS]


def _row(kind: str) -> ValidationRow:
    design = reducer_of(
        kind,
        *without_friction(),
        *without_gravity(),
        "clearance.cam_um=0.0001",
        "clearance.output_um=100.0",
        "drive.rotor_inertia_kg_m2=10.0",
        "settings.timestep_us=2.0",
    )
    reducer = Reducer(design)
    low, high = stops(reducer)
    measured, closed = 1e6 * (high - low), 1e6 * expected(reducer, kind)
    series = " + delta of the sockets" if kind == FREE else ""
    return relative(f"backlash of the gear, {kind}", measured, closed, "urad", f"2 delta/(c (N-1)){series}", 0.5)


def expected(reducer: Reducer, kind: str) -> float:
    """Compute the backlash [rad]: the largest arm of a contact about the gear's centre is c (N-1)."""
    design = reducer.design
    room = design.clearance
    delta = {FREE: room.pin_gear + room.pin_socket, NONPIN: room.tooth}.get(kind, room.pin_gear)
    return 2.0 * delta / (design.gear.eccentricity * design.lobes)


def stops(reducer: Reducer) -> tuple[float, float]:
    """Compute the gear's angles [rad] at its stops, clockwise and counter-clockwise."""
    compiled = build(reducer.design)
    return stop(compiled, -TORQUE), stop(compiled, TORQUE)


def stop(compiled: ReducerModel, torque: float, joint: str = "gear_angle") -> float:
    """Turn gear or output to its stop by a torque [N m] and give its angle; it settles by being halted now and then."""
    data = mujoco.MjData(compiled.model)
    data.joint(joint).qfrc_applied[0] = torque
    with installed():
        mujoco.mj_step(compiled.model, data, _TRAVEL)
        for _ in range(_STOPS):
            data.qvel[:] = 0.0
            mujoco.mj_step(compiled.model, data, _SETTLE)
    return float(data.joint(joint).qpos[0])
