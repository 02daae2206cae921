"""Validation step "two-body": one contact under a static force, its frequency, an impact, and the secant stiffness.

A disc on a slide rests in a fixed circle; the gap is minus its height. Stiffness and damping are those of a pin on the
disc; the solver parameters come from ``solver_parameters``, as in the model.
"""

import math
from dataclasses import dataclass, replace
from typing import Any

import mujoco
import numpy as np

from cycloid_mj.base.validation import ValidationRow, relative
from cycloid_mj.design import PRESETS
from cycloid_mj.dynamics.contact.collider import install
from cycloid_mj.dynamics.law import ContactParameters, contact_law, solver_parameters
from cycloid_mj.dynamics.timestep import timestep
from cycloid_mj.geometry import ideal_loads
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bodies import Role

RATED = Reducer(PRESETS["pin"]).at_rated_load


@dataclass(frozen=True)
class ImpactConditions:
    """Conditions of the contact of two bodies."""

    mass: float = 0.05
    """Mass of the moving disc [kg]."""
    force: float = 400.0
    """Static force [N]."""
    speed: float = 0.01
    """Speed of the impact [m/s]."""
    short_step: float = 1e-6
    """Time step [s] that resolves the vibration of a contact."""
    static_bound: float = 1e-6
    """Allowed error of a body at rest [%]: the tolerance of the solver."""


TWO_BODIES = ImpactConditions()

_XML = """<mujoco>
  <option timestep="{timestep!r}" gravity="0 {gravity!r} 0" tolerance="1e-14" cone="elliptic"/>
  <worldbody>
    <geom name="outer" type="cylinder" size="0.0151 0.01" priority="{outer}"/>
    <body pos="0 0.0001 0"><joint name="y" type="slide" axis="0 1 0"/>
      <inertial pos="0 0 0" mass="{mass!r}" diaginertia="1 1 1"/>
      <geom name="inner" type="cylinder" size="0.015 0.01" priority="{inner}"/></body>
  </worldbody>
  <contact><pair geom1="outer" geom2="inner" condim="1" solref="{solref}" solimp="{solimp}"/></contact>
</mujoco>"""


def rows(quick: bool) -> list[ValidationRow]:
    """Compare static deflection, frequency and restitution of one contact in MuJoCo with closed forms.

    The last rows compare the secant stiffness and have no bounds. `quick` is ignored.
    """
    stiffness, damping_ratio = RATED.contacts.teeth.curvature_law.stiffness, RATED.design.contact.damping_ratio
    step = timestep(RATED)
    contact_parameters = contact_law(stiffness, damping_ratio, TWO_BODIES.mass, 0.0, 0.0, step)
    undamped_parameters = replace(contact_parameters, damping=0.0, added_mass=0.3 * TWO_BODIES.mass)
    depth, force = static_deflection(contact_parameters, step)
    return [
        relative(
            "penetration under a static force",
            1e6 * depth,
            1e6 * TWO_BODIES.force / stiffness,
            "um",
            "F/K",
            TWO_BODIES.static_bound,
        ),
        relative("static contact force", force, TWO_BODIES.force, "N", "equilibrium", TWO_BODIES.static_bound),
        relative(
            "frequency with an added mass of 0.3 m",
            measure_frequency(undamped_parameters, TWO_BODIES.short_step) / (2 * math.pi),
            math.sqrt(stiffness / (TWO_BODIES.mass + undamped_parameters.added_mass)) / (2 * math.pi),
            "Hz",
            "sqrt(K/(m + 1/R))",
            0.06,
        ),
        relative(
            "frequency at the default step",
            measure_frequency(contact_law(stiffness, 0.0, TWO_BODIES.mass, 0.0, 0.0, step), step) / (2 * math.pi),
            math.sqrt(stiffness / TWO_BODIES.mass) / (2 * math.pi),
            "Hz",
            "sqrt(K/m)",
            0.01,
        ),
        relative(
            f"restitution at {damping_ratio:g} of critical damping",
            measure_restitution(contact_law(stiffness, damping_ratio, TWO_BODIES.mass, 0.0, 0.0, 2e-7), 2e-7),
            linear_restitution(damping_ratio),
            "",
            "Nagurka and Huang 2004",
            0.3,
        ),
        *_secant_rows(stiffness),
    ]


def static_deflection(contact_parameters: ContactParameters, timestep: float) -> tuple[float, float]:
    """Simulate the disc until rest under `TWO_BODIES.force`; return its penetration [m] and the contact force [N].

    `contact_parameters` are the law of the contact; `timestep` is in [s].
    """
    model = two_body_model(contact_parameters, timestep, TWO_BODIES.force / TWO_BODIES.mass)
    data = mujoco.MjData(model)
    with install():
        mujoco.mj_step(model, data, math.ceil(4e-3 / timestep))
    return float(data.qpos[0]), float(data.efc_force[0])


def measure_frequency(contact_parameters: ContactParameters, timestep: float) -> float:
    """Measure the angular frequency [rad/s] at which a disc that gravity presses into a fixed circle vibrates.

    It is simulated in MuJoCo and follows from the zero crossings of the velocity. `contact_parameters` are the law of
    the contact; `timestep` is in [s].
    """
    model = two_body_model(contact_parameters, timestep, TWO_BODIES.force / TWO_BODIES.mass)
    data = mujoco.MjData(model)
    data.qpos[0] = 0.5 * TWO_BODIES.force / contact_parameters.stiffness
    period = 2.0 * math.pi * math.sqrt((TWO_BODIES.mass + contact_parameters.added_mass) / contact_parameters.stiffness)
    speeds = np.empty(math.ceil(20 * period / timestep))
    with install():
        for step_index in range(speeds.size):
            mujoco.mj_step(model, data)
            speeds[step_index] = data.qvel[0]
    zero_crossings = np.flatnonzero((speeds[:-1] < 0.0) & (speeds[1:] >= 0.0))
    crossings = zero_crossings + speeds[zero_crossings] / (speeds[zero_crossings] - speeds[zero_crossings + 1])
    return float(2.0 * math.pi / (np.mean(np.diff(crossings)) * timestep))


def measure_restitution(contact_parameters: ContactParameters, timestep: float) -> float:
    """Simulate the impact of a disc on a fixed circle in MuJoCo; return the coefficient of restitution [1].

    The speed of the impact is `TWO_BODIES.speed`. `contact_parameters` are the law of the contact; `timestep` is in
    [s].
    """
    model = two_body_model(contact_parameters, timestep, 0.0)
    data = mujoco.MjData(model)
    start_position = -1e-9
    data.qpos[0], data.qvel[0] = start_position, TWO_BODIES.speed
    with install():
        while data.qpos[0] >= start_position:
            mujoco.mj_step(model, data)
    return float(-data.qvel[0] / TWO_BODIES.speed)


def linear_restitution(ratio: float) -> float:
    """Compute the restitution of a linear contact that cannot pull, damped by `ratio` < 1 of critical.

    The force -(K r + C v) of the damped half wave vanishes before the gap opens (Nagurka and Huang 2004).
    """
    damped = math.sqrt(1.0 - ratio**2)
    return math.exp(-ratio / damped * math.atan2(2.0 * ratio * damped, 2.0 * ratio**2 - 1.0))


def two_body_model(contact_parameters: ContactParameters, timestep: float, gravity: float) -> Any:
    """Return the MuJoCo model (`MjModel`) of a disc in a fixed circle, into which `gravity` [m/s2] presses the disc.

    `contact_parameters` are the law of the contact; `timestep` is in [s].
    """
    parameters = solver_parameters(contact_parameters, 1.0 / TWO_BODIES.mass)
    xml = _XML.format(
        timestep=timestep,
        gravity=gravity,
        mass=TWO_BODIES.mass,
        outer=int(Role.OUTER),
        inner=int(Role.INNER),
        solref=" ".join(map(repr, parameters.solref)),
        solimp=" ".join(map(repr, parameters.solimp)),
    )
    return mujoco.MjModel.from_xml_string(xml)


def _secant_rows(stiffness: float) -> list[ValidationRow]:
    """Compare the constant normal `stiffness` of the model [N/m] with Hertz's at other forces, and with Palmgren's.

    All are secant stiffnesses of a line contact. The rows have no bound: they show the range of the secant stiffness.
    """
    rated_reducer = RATED
    working_force, length, radius = (
        rated_reducer.contacts["pin_gear"].force,
        rated_reducer.design.gear.face_width,
        rated_reducer.design.ring.pin_radius,
    )
    modulus = ideal_loads.contact_modulus(
        rated_reducer.design.material.youngs_modulus, rated_reducer.design.material.poisson
    )

    def hertz_stiffness(force: float) -> float:
        return float(ideal_loads.line_contact_stiffness(force, length, modulus, radius, 1.0 / radius))

    palmgren_stiffness = float(ideal_loads.palmgren_stiffness(working_force, length))
    secant_note = "the model uses the secant stiffness at the working force of ideal load sharing"

    def secant_row(force: float, reference: float, source: str, note: str) -> ValidationRow:
        return relative(
            f"stiffness used, at {force:g} N", 1e-6 * stiffness, 1e-6 * reference, "N/um", source, None, note
        )

    return [
        secant_row(0.2 * working_force, hertz_stiffness(0.2 * working_force), "Johnson 1985, 5.6", secant_note),
        secant_row(1.5 * working_force, hertz_stiffness(1.5 * working_force), "Johnson 1985, 5.6", secant_note),
        secant_row(
            working_force,
            palmgren_stiffness,
            "Palmgren",
            "Palmgren measured the approach of rollers and rings between distant points",
        ),
    ]
