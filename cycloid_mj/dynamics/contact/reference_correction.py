"""Corrections of MuJoCo's reference accelerations between the velocity and the force stage of every step.

MuJoCo's normal force of a contact obeys ``R f + a + b v + k r = 0`` (`law`): f = D (n - a), where n = -b v - k r is the
reference acceleration of the normal row, a = J qacc and D = 1/R. It differs from the contact law in two respects:

Convex friction cone
    In the elliptic cone a contact that slides has D/(1 + m^2) (n - a + mu |t - b|) instead, m = mu/sqrt(impratio); t
    and b are the reference acceleration and the acceleration J qacc of its tangential rows (MuJoCo, "Computation:
    elliptic cones"). While friction is below Coulomb's limit, mu |t - b| <= m^2 (n - a), it is D (n - a). Beyond, n is
    lowered by mu |t - b| - m^2 (n - a), so that the contact presses as it would without friction.

Discs that circle
    The added mass of `law.contact_law` is meant for the second derivative of the gap, J qacc + dJ/dt qvel; MuJoCo has
    the first term alone. Ideal conjugate motion keeps every gap constant, so that dJ/dt qvel is -J times the
    acceleration of that motion: the discs circle about the axis with the angular speed w, all else turns steadily. n is
    raised by that share of it that the damping leaves, 1 - b dt/2. The damping acts on the mean of the velocities half
    a step before and after. For a disc on its circle, this mean is smaller than the velocity v by v (w dt)^2/6: n is
    lowered by b J times this vector.
    Without both, two discs with 0.35 um of play at 15 000 rpm have their mean transmission error 3 % wrong at 10 us.

Both accelerations of the cone are those of the step before, which MuJoCo keeps. The corrections change
``efc_aref``: contacts that they alone open or close stay in the solver, where a changed gap would drop them.
"""

import math
from functools import cache
from typing import Any

import llvmlite.binding
from numba import types

from cycloid_mj.base import compiling
from cycloid_mj.base.compiling import cacheable, cfunc
from cycloid_mj.dynamics.contact.layout import StepLayout
from cycloid_mj.dynamics.contact.library import function_address
from cycloid_mj.dynamics.contact.memory import read_address, read_float, read_int, write_float
from cycloid_mj.dynamics.contact.step_state import StepState, step_state_at
from cycloid_mj.dynamics.contact.teeth import USER_DATA

_FRICTIONAL = 3
"""Dimensions of a contact with friction."""

_MULTIPLY = "cycloid_mj_mj_mulJacVec"
multiply_jacobian = types.ExternalFunction(_MULTIPLY, types.void(*[types.intp] * 4))
"""``mj_mulJacVec``: multiply the constraints' Jacobian by the vector at the fourth address, into the third."""


def bind_multiplication() -> None:
    """Bind `multiply_jacobian` to MuJoCo's function, for code that is compiled or loaded after this."""
    llvmlite.binding.add_symbol(_MULTIPLY, function_address("mj_mulJacVec"))


@cache
def compile_control_callback(layout: StepLayout) -> Any:
    """Compile or load the callback ``mjcb_control`` that corrects reference accelerations; return it as a ``cfunc``.

    MuJoCo calls it in each step after it has computed the velocities and before it computes the forces. `layout` has
    the offsets of MuJoCo's arrays.
    """
    bind_multiplication()

    @cfunc(types.void(types.intp, types.intp), cache=cacheable())
    def control_callback(model: int, data: int) -> None:
        correct_references(layout, model, data)

    return control_callback


@compiling.njit(inner=True)
def correct_references(layout: StepLayout, model: int, data: int) -> None:
    """Correct the reference accelerations of all contacts of a step; do nothing for models without exact contact.

    `model` and `data` are the memory addresses of ``mjModel`` and ``mjData``, `layout` the offsets of their arrays.
    ``efc_force``, which the solver computes later, serves as working memory.
    """
    if read_int(model + layout.nuserdata) != 1 or read_int(model + layout.nuser_geom) < USER_DATA:
        return
    if not read_int(data + layout.ncon):
        return
    run = int(read_float(read_address(data + layout.userdata)))
    if run:
        _correct_for_orbit(layout, model, data, step_state_at(run))
    _remove_cone_lift(layout, model, data)


@compiling.njit(inner=True)
def _correct_for_orbit(layout: StepLayout, model: int, data: int, run: StepState) -> None:
    """Correct MuJoCo's normal reference accelerations of all contacts for the circular orbit of the discs.

    `model` and `data` are the memory addresses of MuJoCo's structures, `layout` the offsets of their arrays, and `run`
    the state of the run. MuJoCo neglects the change of the Jacobian along the orbit; the module describes both
    corrections. In the following, b is the damping of a contact, the second of the four numbers of a row of
    ``efc_KBIP``, and dt the time step. The first pass adds the centripetal acceleration of the orbit along the normal,
    times 1 - b dt/2. MuJoCo's damping acts on the mean of the velocities half a step before and after, which is too
    small on a circle. The second pass therefore subtracts b times this error along the normal.
    """
    _multiply_orbit(layout, model, data, run, False)
    products, constants, references = (
        read_address(data + layout.efc_force),
        read_address(data + layout.efc_KBIP),
        read_address(data + layout.efc_aref),
    )
    contacts_address, half_timestep = read_address(data + layout.contact), read_float(run.half_timestep)
    for contact_index in range(read_int(data + layout.ncon)):
        row = read_int(contacts_address + layout.stride * contact_index + layout.efc_address)
        if row >= 0:
            undamped_share = 1.0 - half_timestep * read_float(constants + 32 * row + 8)
            reference = references + 8 * row
            write_float(reference, read_float(reference) + undamped_share * read_float(products + 8 * row))
    _multiply_orbit(layout, model, data, run, True)
    for contact_index in range(read_int(data + layout.ncon)):
        row = read_int(contacts_address + layout.stride * contact_index + layout.efc_address)
        if row >= 0:
            damping, reference = read_float(constants + 32 * row + 8), references + 8 * row
            write_float(reference, read_float(reference) - damping * read_float(products + 8 * row))


@compiling.njit(inner=True)
def _multiply_orbit(layout: StepLayout, model: int, data: int, run: StepState, use_velocity_errors: bool) -> None:
    """Multiply the constraint Jacobian by the centripetal accelerations of orbiting discs, or by errors of velocity.

    A disc orbits the axis at the velocity v, with the angular speed w. MuJoCo's velocities half a time step before and
    after are differences of positions over the time step dt, so that their mean is v sin(w dt)/(w dt). With
    `use_velocity_errors`, the Jacobian is multiplied by the shortfall of this mean, v (w dt)^2/6 in the direction of v.
    The product is written to ``efc_force``. `model` and `data` are the addresses of MuJoCo's structures, `layout` the
    offsets of their arrays, and `run` the state of the run.
    """
    half_timestep = read_float(run.half_timestep)
    for disc in range(run.discs):
        dof_offset = 8 * read_int(run.orbits + 4 * disc)
        x, y = read_float(run.qpos + dof_offset), read_float(run.qpos + dof_offset + 8)
        vx, vy = read_float(run.qvel + dof_offset), read_float(run.qvel + dof_offset + 8)
        angular_speed = (x * vy - y * vx) / (x * x + y * y)
        squared_angular_speed = angular_speed * angular_speed
        operand_x, operand_y = -squared_angular_speed * x, -squared_angular_speed * y
        if use_velocity_errors:
            angular_speed_error = 2.0 / 3.0 * half_timestep * half_timestep * squared_angular_speed * angular_speed
            operand_x, operand_y = -angular_speed_error * y, angular_speed_error * x
        write_float(run.circling + dof_offset, operand_x)
        write_float(run.circling + dof_offset + 8, operand_y)
    multiply_jacobian(model, data, read_address(data + layout.efc_force), run.circling)


@compiling.njit(inner=True)
def _remove_cone_lift(layout: StepLayout, model: int, data: int) -> None:
    """Lower the normal reference accelerations of sliding contacts by the lift of the convex friction cone.

    MuJoCo's elliptic friction cone presses sliding contacts too hard. `model` and `data` are the memory addresses of
    its structures, `layout` the offsets of their arrays. The lift is mu |t - b| - m^2 (n - a), or 0 if this is
    negative. n and a are the reference and the actual acceleration along the normal, t and b those along the tangents.
    mu is the friction coefficient, and m = mu/sqrt(impratio). Contacts without friction are not changed.
    """
    contacts_address, references = read_address(data + layout.contact), read_address(data + layout.efc_aref)
    accelerations = read_address(data + layout.efc_force)
    multiply_jacobian(model, data, accelerations, read_address(data + layout.qacc))
    for contact_index in range(read_int(data + layout.ncon)):
        contact = contacts_address + layout.stride * contact_index
        row = read_int(contact + layout.efc_address)
        if row < 0 or read_int(contact + layout.dim) != _FRICTIONAL:
            continue
        reference, acceleration = references + 8 * row, accelerations + 8 * row
        normal_reference, cone_ratio = read_float(reference), read_float(contact + layout.mu)
        sliding_excess = math.hypot(
            read_float(reference + 8) - read_float(acceleration + 8),
            read_float(reference + 16) - read_float(acceleration + 16),
        )
        normal_excess = max(normal_reference - read_float(acceleration), 0.0)
        lift = read_float(contact + layout.friction) * sliding_excess - cone_ratio * cone_ratio * normal_excess
        if lift > 0.0:
            write_float(reference, normal_reference - lift)
