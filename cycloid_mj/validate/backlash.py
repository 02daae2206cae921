"""Validation step "backlash": rotation of the disc at a locked crank, 2 delta/(c (N-1)), for each kind of ring.

A small torque turns the disc from one stop to the other. delta is the normal clearance of the teeth; for free pins
that of the sockets is added. The cam has almost no clearance, the output so much that it does not touch.
"""

import mujoco

from cycloid_mj.base.validation import ValidationRow, relative
from cycloid_mj.dynamics.contact.collider import install
from cycloid_mj.dynamics.mjcf import ReducerModel, build
from cycloid_mj.reducer import Reducer
from cycloid_mj.validate.rig import FREE, KINDS, NONPIN, design_of_kind, without_friction, without_gravity

TORQUE = 0.01
"""Torque that presses the disc against its stop [N m]; it deflects the teeth by less than 0.1 % of a clearance."""


def rows(quick: bool) -> list[ValidationRow]:
    """Return the comparisons of this validation step, the rows of its table; `quick` has no effect."""
    return [_backlash_row(kind) for kind in KINDS]


def _backlash_row(kind: str) -> ValidationRow:
    """Compare the simulated backlash of one disc on a kind of ring with the closed form; the bound is 0.5 %.

    `kind` is a member of `rig.KINDS`. The design has no friction, no gravity and almost no clearance at the cam. The
    clearance at the output pins is so large that only the mesh stops the disc.
    """
    design = design_of_kind(
        kind,
        *without_friction(),
        *without_gravity(),
        "clearance.cam_um=0.0001",
        "clearance.output_um=100.0",
        "drive.rotor_inertia_kg_m2=10.0",
        "settings.timestep_us=2.0",
    )
    reducer = Reducer(design)
    min_angle, max_angle = stop_angles(reducer)
    measured_backlash, reference = 1e6 * (max_angle - min_angle), 1e6 * closed_form_backlash(reducer, kind)
    socket_term = " + delta of the sockets" if kind == FREE else ""
    return relative(
        f"backlash of the gear, {kind}",
        measured_backlash,
        reference,
        "urad",
        f"2 delta/(c (N-1)){socket_term}",
        bound=0.5,
    )


def closed_form_backlash(reducer: Reducer, kind: str) -> float:
    """Compute the backlash [rad]: the largest arm of a contact about the gear's centre is c (N-1)."""
    design = reducer.design
    clearance = design.clearance
    delta = {FREE: clearance.pin_gear + clearance.pin_socket, NONPIN: clearance.tooth}.get(kind, clearance.pin_gear)
    return 2.0 * delta / (design.gear.eccentricity * design.lobes)


def stop_angles(reducer: Reducer) -> tuple[float, float]:
    """Compute the angles of the disc [rad] at its stops, clockwise and counter-clockwise."""
    compiled = build(reducer.design)
    return turn_to_stop(compiled, -TORQUE), turn_to_stop(compiled, TORQUE)


def turn_to_stop(model: ReducerModel, torque: float, joint: str = "gear_angle") -> float:
    """Turn disc or output against its stop by a torque [N m] in MuJoCo; return the angle of its joint [rad].

    `joint` is the name of a hinge of the model. After 2000 steps, the speeds are set to zero eight times, 250 steps
    apart, so that the parts settle.
    """
    data = mujoco.MjData(model.model)
    data.joint(joint).qfrc_applied[0] = torque
    with install():
        mujoco.mj_step(model.model, data, 2000)
        for _ in range(8):
            data.qvel[:] = 0.0
            mujoco.mj_step(model.model, data, 250)
    return float(data.joint(joint).qpos[0])
