"""Designs and runs of the validation steps: three kinds of ring, idealised where a closed form requires it."""

from typing import Any

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.names import TEETH
from cycloid_mj.base.record import Run
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.dynamics.contact.teeth import DEFLECTION
from cycloid_mj.dynamics.law import contact_law, solver_parameters
from cycloid_mj.dynamics.mjcf import ReducerModel
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.reducer import Reducer

FIXED, FREE, SLEEVED, NONPIN = "fixed pins", "free pins", "sleeved pins", "nonpin"
KINDS = (FIXED, FREE, NONPIN)
RATED_LOAD = 36.0
"""Load torque [N m]: the paper's 36.68 N m, rounded."""

SETTLED = 0.01
"""Time at which evaluation starts [s] (heuristic): rise of the load, and the decay of its transient."""

PERIODS = 36
"""Mesh periods per turn of the crank: ring teeth of the paper's designs."""

PAIR_KINDS = ("pin_gear", "pin_socket", "pin_sleeve", "tooth", "cam", "output")
_RING = {f"{kind} pins": ("pin", f'ring.pins="{kind}"') for kind in ("fixed", "free", "sleeved")}
_RING |= {NONPIN: ("nonpin", "ring.teeth=36")}


def design_of_kind(kind: str, *changes: str) -> Design:
    """Return the design of Hsieh 2014 with a kind of ring and ``table.key=value`` changes, without a ramp."""
    preset, ring = _RING[kind]
    return override(PRESETS[preset], [ring, "drive.ramp_s=0.0", *changes])


def with_changes(reducer: Reducer, *changes: str) -> Reducer:
    """Return the design with ``table.key=value`` changes."""
    return Reducer(override(reducer.design, changes))


def without_friction() -> list[str]:
    """List the changes that switch friction off."""
    return [
        "friction.law=coulomb",
        *(f"friction.{kind}=0.0" for kind in (*PAIR_KINDS, "cam_rolling", "output_rolling")),
    ]


def without_gravity() -> list[str]:
    """List the change that switches gravity off."""
    return ["environment.gravity_y_m_s2=0.0"]


def clearances(value_um: float) -> list[str]:
    """List the changes that make every clearance the same [um]."""
    return [f"clearance.{kind}_um={value_um!r}" for kind in PAIR_KINDS]


def stiffen_cam(compiled: ReducerModel, stiffness: float) -> None:
    """Change the normal stiffness [N/m] of the cam's contact in a compiled model in place.

    Its damping is half of critical. The added mass, which keeps MuJoCo's time step stable, follows (`contact_law`).
    """
    model = compiled.model
    disc_mass = float(model.body("gear").mass[0])
    contact_parameters = contact_law(stiffness, 0.5, disc_mass, 0.0, 0.0, float(model.opt.timestep))
    pair = next(pair for pair in compiled.pairs if pair.kind == "cam")
    parameters = solver_parameters(contact_parameters, inverse_weight(model, pair.on, pair.by))
    pair_id = model.pair(pair.name).id
    model.pair_solref[pair_id], model.pair_solimp[pair_id] = parameters.solref, parameters.solimp


def separate_patches(compiled: ReducerModel) -> None:
    """Make the contact lines of an arc and a root separate springs of full stiffness in a compiled model."""
    compiled.model.geom(TEETH).user[DEFLECTION] = 0.0


def inverse_weight(model: Any, *geoms: str) -> float:
    """Compute the sum of the ``body_invweight0`` of the bodies of two geoms [1/kg]."""
    return float(sum(model.body_invweight0[model.geom(name).bodyid[0], 0] for name in geoms))


def rated_design(kind: str, *changes: str) -> Design:
    """Return a kind of reducer at rated load."""
    return design_of_kind(kind, f"load.torque_nm={RATED_LOAD}", *changes)


def rated_run(kind: str, rpm: float, periods: int, *changes: str) -> tuple[Run, Design]:
    """Simulate the reducer of Hsieh 2014 with a kind of ring at rated load and a crank speed [rpm].

    `kind` is `FIXED`, `FREE`, `SLEEVED` or `NONPIN`; `changes` are settings of the form ``key=value``.

    Returns
    -------
    run
        The settled samples over `periods` mesh periods.
    design
        The design.
    """
    design = design_of_kind(
        kind,
        f"drive.speed_rpm={rpm!r}",
        f"load.torque_nm={RATED_LOAD}",
        f"drive.hold_s={SETTLED + periods * 60.0 / (abs(rpm) * PERIODS)!r}",
        "settings.log_rate_hz=20000.0",
        *changes,
    )
    run = simulate(design)
    return run.select(run.time >= SETTLED), design


def vector_lengths(vectors: Array) -> Array:
    """Compute the lengths of vectors (..., 2), shape (...)."""
    return np.hypot(vectors[..., 0], vectors[..., 1])
