"""The joint of `reducer.json` with NumPy only: load-dependent friction and transmission error for each MuJoCo step.

`cycloid-mj reduce` writes this file as joint.py next to joint.xml. It needs no package except NumPy:

    model = mujoco.MjModel.from_xml_path("joint/scene.xml")
    joint = joint.Joint("joint/reducer.json")
    joint.step(model, data)  # before each mujoco.mj_step(model, data)

With `--spread`, a row of samples.csv changes it to another drive of the same design:

    other = joint.varied(rows[7])
    other.write(model)  # play, stiffness and friction without a load, as MJCF has them

For MJX, `terms` is a pure function of arrays: call it with ``xp=jax.numpy``, and write its result into the model.
"""

import copy
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

AT_REST = 1e-3
"""Speed of the crank [rad/s] below which the direction of friction follows from the torque on it."""


VALUES_FILE = Path(__file__).with_name("reducer.json")
"""Default file of the values."""


class Terms(NamedTuple):
    """Values for a model: dead bands of the springs [rad], shape (springs, 2), damping [N m s/rad], friction [N m]."""

    springlength: Any
    damping: Any
    frictionloss: Any


PARAMETERS = (
    "backlash_arcmin",
    "stiffness_nm_per_arcmin",
    "no_load_torque_nm",
    "loss_percent",
    "te_loaded_forward_arcsec",
)
"""Parameters of the joint of a drive: play, stiffness, friction on the crank, loss, transmission error."""


def varied(values: Mapping[str, Any], factors: Mapping[str, float]) -> dict[str, Any]:
    """Return a copy of a joint's values with its parameters scaled by factors.

    `factors` are by the keys of `PARAMETERS`, such as ``backlash_arcmin``. `values` are those of the key `joint` in
    reducer.json. The middle of the play, and the torques at which further springs come into contact, are unchanged.
    Load-dependent friction is scaled by the factor of the loss.
    """
    play_factor, stiffness_factor, friction_factor, loss_factor, error_factor = (
        float(factors[key]) for key in PARAMETERS
    )
    scaled_values = copy.deepcopy(dict(values))
    lower_stop, upper_stop = values["stops"]
    middle, half_play = 0.5 * (lower_stop + upper_stop), 0.5 * play_factor * (upper_stop - lower_stop)
    scaled_values["stops"] = [middle - half_play, middle + half_play]
    for spring in scaled_values["springs"]:
        spring["start"] /= stiffness_factor
        spring["stiffness"] *= stiffness_factor
    scaled_values["polynomial"] = [
        coefficient * stiffness_factor ** (index + 1) for index, coefficient in enumerate(values["polynomial"])
    ]
    scaled_values["damping"] = values["damping"] * stiffness_factor
    for direction in ("driving", "driven"):
        scaled_values["friction"][direction] = [
            [friction_factor * row[0] + loss_factor * (torque - row[0]) for torque in row]
            for row in values["friction"][direction]
        ]
    for key in [key for key in values["ripple"] if key.endswith(("_cos", "_sin", "_error"))]:
        scaled_values["ripple"][key] = [
            [error_factor * coefficient for coefficient in row] for row in values["ripple"][key]
        ]
    return scaled_values


class Joint:
    """A reduced joint.

    Attributes
    ----------
    values
        Values of `joint` in reducer.json, in SI.
    timestep, integrator
        Longest time step at which the peak of an impact is accurate within 5 % [s], and its integrator.
    nominal
        With ``--spread``, the parameters of the nominal design, by the keys of `PARAMETERS`.
    """

    def __init__(self, path: str | Path = VALUES_FILE) -> None:
        content = json.loads(Path(path).read_text(encoding="utf-8"))
        self.values = content["joint"]
        self.timestep = content["scene"]["timestep_s"]
        self.integrator = content["scene"]["integrator"]
        parameters = (content.get("spread") or {}).get("parameters", {})
        self.nominal = {key: item["nominal"] for key, item in parameters.items()}

    @property
    def coefficient(self) -> float:
        """Coefficient of the crank's angle in L, the output's angle less the ideal one; that of the output is 1."""
        return -self.values["way"] / self.values["ratio"]

    def varied(self, sample: Mapping[str, Any]) -> "Joint":
        """Return a copy of the joint with the parameters of a random drive, one of those in samples.csv.

        `sample` is a row of this file: column, such as ``backlash_arcmin`` (`PARAMETERS`), -> value. A parameter that
        is 0 in the nominal design, such as the error of ideal parts, is not changed.

        Raises
        ------
        ValueError
            reducer.json has no distributions of the parameters (``--spread``).
        """
        if not self.nominal:
            raise ValueError("reducer.json has no distributions; create it with `cycloid-mj reduce --spread`")
        joint = copy.copy(self)
        factors = {key: float(sample[key]) / nominal if nominal else 1.0 for key, nominal in self.nominal.items()}
        joint.values = varied(self.values, factors)
        return joint

    def write(self, model: Any, joint: str = "output") -> None:
        """Set play, stiffness, damping and no-load friction of the reducer in a compiled MuJoCo model, in place.

        `model` is an ``MjModel`` of an MJCF file that ``reduce`` wrote: it has the rotor and the tendons of the reducer
        at the hinge with the name `joint`.
        """
        values, dof = self.values, int(model.joint(f"{joint}_rotor").dofadr[0])
        lower_stop, upper_stop = values["stops"]
        for number, spring in enumerate(values["springs"]):
            tendon = model.tendon(f"{joint}_reducer" + (f"_{number + 1}" if number else "")).id
            model.tendon_lengthspring[tendon] = lower_stop - spring["start"], upper_stop + spring["start"]
            model.tendon_stiffness[tendon] = spring["stiffness"]
            model.tendon_damping[tendon] = 0.0 if number else values["damping"]
        model.dof_frictionloss[dof] = self._interpolate_friction("driving", 0.0, values["rated_speed"], np)

    def step(self, model: Any, data: Any, joint: str = "output") -> None:
        """Update friction and transmission error of a hinge in a ``MjModel`` for the state in `data` (``MjData``).

        Call it before each time step; `joint` is the name of the hinge.
        """
        output_joint, crank_joint = model.joint(joint), model.joint(f"{joint}_rotor")
        springs = [
            f"{joint}_reducer" + (f"_{spring_index + 1}" if spring_index else "")
            for spring_index in range(len(self.values["springs"]))
        ]
        tendons, dof = [model.tendon(name).id for name in springs], int(crank_joint.dofadr[0])
        output_angle, crank_angle = (data.qpos[int(hinge.qposadr[0])] for hinge in (output_joint, crank_joint))
        terms = self.terms(output_angle, crank_angle, data.qvel[dof], data.qfrc_actuator[dof] + data.qfrc_applied[dof])
        model.tendon_lengthspring[tendons] = terms.springlength
        model.tendon_damping[tendons[0]] = terms.damping
        model.dof_frictionloss[dof] = terms.frictionloss

    def terms(self, output: Any, crank: Any, speed: Any, driven_by: Any, xp: Any = np) -> Terms:
        """Compute the springs' dead bands, the damping and the friction of a hinge at its state, in MuJoCo or MJX.

        No branch depends on an argument: with ``xp=jax.numpy`` the function can be compiled and vectorised.

        Parameters
        ----------
        output, crank
            Angles of output and crank [rad].
        speed
            Speed of the crank [rad/s].
        driven_by
            Torque of motor and other loads on the crank [N m].
        xp
            NumPy, or a module with its functions.
        """
        values, ripple = self.values, self.values["ripple"]
        deviation = output + self.coefficient * crank
        starts = xp.array([spring["start"] for spring in values["springs"]])
        stiffness = xp.array([spring["stiffness"] for spring in values["springs"]])
        rated_torque = values["rated_torque"]
        # shares of the nominal torque between which errors and springs are linear, and the wind-up there
        torques = (stiffness * xp.maximum(starts[:, None] - starts, 0.0)).sum(axis=1)
        bends = xp.sort(xp.concatenate([xp.array([0.0]), xp.array(ripple["loads"]), torques / rated_torque]))
        # beyond the last start the last slope continues
        wind_up_of_last_spring = starts[-1] + xp.maximum(bends * rated_torque - torques[-1], 0.0) / stiffness.sum()
        wind_up_at_bends = xp.where(
            bends * rated_torque > torques[-1], wind_up_of_last_spring, xp.interp(bends * rated_torque, torques, starts)
        )
        phase = xp.array(ripple["orders"]) * crank
        low_stop, high_stop = values["stops"]
        stops = []
        for side, sign, stop_angle in (("low", -1.0, low_stop), ("high", 1.0, high_stop)):
            cos, sin = (xp.array(ripple[f"{side}_{part}"]) for part in ("cos", "sin"))
            error = xp.interp(bends, xp.array(ripple["loads"]), cos @ xp.cos(phase) + sin @ xp.sin(phase))
            deviation_at_bends = wind_up_at_bends + sign * (error + stop_angle)
            # where the error falls faster than the springs wind up, the largest torque with that L
            is_later = xp.arange(len(deviation_at_bends))[:, None] <= xp.arange(len(deviation_at_bends))
            next_deviation = xp.where(is_later, deviation_at_bends, xp.inf).min(axis=1)
            share = xp.interp(sign * deviation, next_deviation, bends)
            stops.append(stop_angle + xp.interp(share, bends, error))
        lower_stop, upper_stop = stops
        wind_up = xp.maximum(deviation - upper_stop, lower_stop - deviation)
        magnitude = (stiffness * xp.maximum(wind_up - starts, 0.0)).sum()
        torque = xp.where(deviation > upper_stop, -magnitude, magnitude)
        torque_on_crank = self.coefficient * torque
        direction = xp.where(xp.abs(speed) > AT_REST, speed, torque_on_crank + driven_by)
        driving_friction, driven_friction = (
            self._interpolate_friction(key, magnitude, speed, xp) for key in ("driving", "driven")
        )
        return Terms(
            xp.stack([lower_stop - starts, upper_stop + starts], axis=1),
            xp.where(magnitude > 0.0, values["damping"], 0.0),
            xp.where(torque_on_crank * direction < 0.0, driving_friction, driven_friction),
        )

    def _interpolate_friction(self, key: str, torque: Any, speed: Any, xp: Any) -> Any:
        """Interpolate the friction torque on the crank [N m] at an output torque [N m] and a crank speed [rad/s].

        `key` is "driving" (the crank drives) or "driven" (the output drives), and `xp` is the array module, NumPy or
        a module like it. Above the largest torque, the last segment is extrapolated.
        """
        table = self.values["friction"]
        torques, rows = xp.array(table["torques"]), xp.array(table[key])
        index = xp.clip(xp.searchsorted(torques, torque) - 1, 0, len(table["torques"]) - 2)
        share = (torque - torques[index]) / (torques[index + 1] - torques[index])
        friction_by_speed = rows[:, index] + share * (rows[:, index + 1] - rows[:, index])
        return xp.interp(xp.abs(speed), xp.array(table["speeds"]), friction_by_speed)
