"""The reduced joint: its springs, friction and transmission error, and the time step of effects that MJCF lacks.

L is the output's angle less the ideal one at the crank's angle: the length of a fixed tendon over both. Between its
stops the joint is free; beyond them it winds up. All friction torques are on the crank.
"""

import json
import math
import zlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, NamedTuple, Self, get_args

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import CycloidError, UsageError, reason
from cycloid_mj.base.frame import Frame
from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.base.result import Quantity, quantity_frame
from cycloid_mj.base.units import RPM
from cycloid_mj.robot.friction import FrictionMap
from cycloid_mj.robot.ripple import Ripple
from cycloid_mj.robot.standalone import varied

Level = Literal["rigid", "backlash", "full"]
"""Level of detail: ratio, inertia and constant friction; additionally play and springs; additionally load-dependent
friction and transmission error, by `ReducedJoint.step`."""

LEVELS: tuple[Level, ...] = get_args(Level)

AT_REST = 1e-3
"""Speed of the crank [rad/s] below which the direction of friction follows from the torque on it."""

NUMBERS = ("ratio", "rated_torque", "rated_speed", "damping", "rotor_inertia", "output_inertia")
"""Values of a joint that are numbers above 0."""

JOINT = "joint"
"""Key of the joint's own values in its JSON file."""


@dataclass(frozen=True)
class Spring:
    """Spring that acts beyond a dead band: its start beyond the stops [rad], and stiffness [N m/rad]."""

    start: float
    stiffness: float


@dataclass(frozen=True)
class Slip:
    """Slip element on L: a spring [N m/rad] that slips at a limit [N m], which causes hysteresis."""

    limit: float
    stiffness: float


class JointAddresses(NamedTuple):
    """Addresses of a joint in a model: crank, output, and the tendons between them."""

    output_angle: int
    output_speed: int
    crank_angle: int
    crank_speed: int
    tendons: tuple[int, ...]


@dataclass(frozen=True, repr=False)
class ReducedJoint(Presented):
    """A reducer as a joint.

    Attributes
    ----------
    name
        Name of the design.
    level
        Level of detail in a model.
    ratio, way
        Turns of the crank per turn of the output, and -1 where the output turns against the crank.
    rated_torque, rated_speed
        Nominal torque on the output [N m], and speed of the crank [rad/s].
    stops
        L at both ends of the play [rad].
    springs
        Springs whose sum is the torque beyond a stop, the same on both sides; the first starts at the stop.
    polynomial, polynomial_error
        Factors a, b, c of that torque as a x + b x^2 + c x^3 up to the rated one [N m/rad, N m/rad^2, N m/rad^3], and
        their numerical errors.
    damping
        Damping of L while a spring is loaded [N m s/rad].
    rotor_inertia, output_inertia
        Inertia of the parts that turn with the crank and with the output, about their own axes [kg m2].
    friction, ripple
        Map of the friction torque on the crank; transmission error about its mean.
    slips
        Slip elements in parallel with the springs, at every L: friction of the wind-up.
    quantities
        Identified figures by key, for people and programs.
    """

    name: str
    level: Level
    ratio: float
    way: int
    rated_torque: float
    rated_speed: float
    stops: tuple[float, float]
    springs: tuple[Spring, ...]
    polynomial: tuple[float, ...]
    polynomial_error: tuple[float, ...]
    damping: float
    rotor_inertia: float
    output_inertia: float
    friction: FrictionMap
    ripple: Ripple
    slips: tuple[Slip, ...] = ()
    quantities: Mapping[str, Quantity] = field(default_factory=dict, compare=False, repr=False)

    @property
    def frame(self) -> Frame:
        """Identified figures, one row each."""
        return quantity_frame(self.quantities)

    @property
    def line(self) -> str:
        """Name, level, ratio and nominal torque."""
        return f"{self.name}, {self.level}, {abs(self.ratio):g}:1, {self.rated_torque:.4g} N m"

    @property
    def coefficient(self) -> float:
        """Coefficient of the crank's angle in L [1]; that of the output's angle is 1."""
        return -self.way / self.ratio

    @property
    def reflected_inertia(self) -> float:
        """Total inertia of the reducer at its output [kg m2]."""
        return self.output_inertia + self.ratio**2 * self.rotor_inertia

    @property
    def middle(self) -> float:
        """L in the middle of the play [rad]."""
        return 0.5 * sum(self.stops)

    @property
    def backlash(self) -> float:
        """Angle between the stops [rad]."""
        return self.stops[1] - self.stops[0]

    @property
    def no_load_torque(self) -> float:
        """Friction on the crank without a load, at the rated speed [N m]."""
        return self.friction.torque(0.0, self.rated_speed, driving=True)

    @property
    def no_load_torque_at_output(self) -> float:
        """That friction at the output [N m], for a joint without a crank."""
        return self.ratio * self.no_load_torque

    @cached_property
    def fingerprint(self) -> int:
        """Number that identifies the joints of a model with this reducer, at any level; MJCF keeps all its digits."""
        values = {key: value for key, value in self._values().items() if key not in ("level", "slips")}
        return 1 + zlib.crc32(json.dumps(values, sort_keys=True).encode()) % 999_999

    def stiffness(self, torque: float) -> float:
        """Compute the slope of the torque over L at a torque of this size [N m/rad]."""
        beyond = self.wind_up(torque)
        return sum(spring.stiffness for spring in self.springs if spring.start <= beyond)

    def wind_up(self, torque: float) -> float:
        """Compute L beyond the stop under a torque of this size [rad]."""
        low, reached, slope = 0.0, 0.0, 0.0
        for spring in self.springs:
            if reached + slope * (spring.start - low) > abs(torque):
                break
            reached += slope * (spring.start - low)
            low, slope = spring.start, slope + spring.stiffness
        return low + (abs(torque) - reached) / slope

    def torque(self, length: float, stops: tuple[float, float] | None = None) -> float:
        """Compute the torque of the springs at L = `length` [rad], towards the stops [N m]."""
        low, high = stops or self.stops
        beyond = max(length - high, low - length)
        size = sum(spring.stiffness * max(beyond - spring.start, 0.0) for spring in self.springs)
        return -size if length > high else size

    def stops_at(self, angle: float, length: float) -> tuple[float, float]:
        """Compute the stops at a crank angle [rad], with the error under the torque at L = `length` [rad]."""
        return self.moving_stops(angle)(length)

    def moving_stops(self, angle: float) -> Callable[[float], tuple[float, float]]:
        """Return the function from L [rad] to the stops [rad] at a crank angle [rad], as `stops_at`.

        L is piecewise linear in the torque between the loads of the errors and the starts of the springs, and is
        inverted. Where the error falls faster with the load than the springs wind up, several torques have the same L,
        and the largest is used.
        """
        shares, _ = self._bend_points
        (low, lower), (high, upper) = self._bends(angle)

        def stops(length: float) -> tuple[float, float]:
            below, above = np.interp(-length, lower, shares), np.interp(length, upper, shares)
            return (
                self.stops[0] + float(np.interp(below, shares, low)),
                self.stops[1] + float(np.interp(above, shares, high)),
            )

        return stops

    def bends(self, angle: float) -> Array:
        """Return the L [rad] between which the torque is linear, at a crank angle [rad]."""
        if self.level == "full":
            (_, lower), (_, upper) = self._bends(angle)
            return np.unique([*-lower, *upper])
        starts = [spring.start for spring in self.springs]
        return np.unique(
            [side * start + stop for start in starts for side, stop in zip((-1, 1), self.stops, strict=True)]
        )

    def _bends(self, angle: float) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        """Compute errors and L beyond zero at the shares of `_bend_points` [rad], of the lower and the upper stop."""
        shares, wound = self._bend_points
        low, high = (np.interp(shares, self.ripple.loads, error) for error in self.ripple.errors_at(angle))
        return (low, _rising(wound - low - self.stops[0])), (high, _rising(wound + high + self.stops[1]))

    @cached_property
    def _bend_points(self) -> tuple[Array, Array]:
        """Shares of the nominal torque between which errors and springs are linear, and the wind-up there [rad]."""
        starts = [
            sum(spring.stiffness * max(item.start - spring.start, 0.0) for spring in self.springs)
            for item in self.springs
        ]
        shares = np.unique([0.0, *self.ripple.loads, *(torque / self.rated_torque for torque in starts)])
        return shares, np.array([self.wind_up(share * self.rated_torque) for share in shares.tolist()])

    def at(self, level: Level) -> Self:
        """Return the reducer at another level of detail."""
        if level not in LEVELS:
            raise UsageError(f"unknown level {level!r}: choose one of {', '.join(LEVELS)}")
        return replace(self, level=level)

    def varied(self, factors: Mapping[str, float]) -> Self:
        """Return the joint with its parameters scaled by factors, by the keys of `robot.standalone.PARAMETERS`."""
        return self.from_json({JOINT: varied(self._values(), factors)})

    def step(self, model: Any, data: Any) -> None:
        """Write load-dependent friction and transmission error into a model; call it before each ``mj_step``.

        All joints with this reducer are updated, each at the level at which it was attached.

        Parameters
        ----------
        model
            ``MjModel``; friction losses, spring lengths and damping of the reducer's joints are changed.
        data
            ``MjData`` after the last time step.

        Raises
        ------
        UsageError
            No joint of the model has this reducer.
        """
        for addresses in self.places(model):
            if addresses.tendons:
                self._step_between(model, data, addresses)
            else:
                self._step_rigid(model, data, addresses)

    def settle(self, model: Any, data: Any) -> None:
        """Set the cranks of all joints with this reducer to the middle of the play, with the speed of the output.

        Call it after joint angles were set; otherwise the reducer starts wound up.
        """
        for addresses in self.places(model):
            if addresses.tendons:
                data.qpos[addresses.crank_angle] = (self.middle - data.qpos[addresses.output_angle]) / self.coefficient
                data.qvel[addresses.crank_speed] = -data.qvel[addresses.output_speed] / self.coefficient

    def places(self, model: Any) -> Iterator[JointAddresses]:
        """Yield the addresses of a model's joints with this reducer.

        Raises
        ------
        UsageError
            There is none.
        """
        tuples = zip(model.tuple_adr.tolist(), model.tuple_size.tolist(), strict=True)
        starts = [(start, size) for start, size in tuples if size and model.tuple_objprm[start] == self.fingerprint]
        if not starts:
            raise UsageError(
                f"no joint of the model has the reducer {self.name!r}: attach it first with attach_reducer"
            )
        for start, size in starts:
            output, *others = model.tuple_objid[start : start + size].tolist()
            crank, *tendons = others or [output]
            driven, motor = ((int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])) for joint in (output, crank))
            yield JointAddresses(*driven, *motor, tuple(tendons))

    def _step_between(self, model: Any, data: Any, addresses: JointAddresses) -> None:
        """Update a joint with springs: its tendons follow the error, its crank has the friction of their torque."""
        angle, dof = float(data.qpos[addresses.crank_angle]), addresses.crank_speed
        length = float(data.qpos[addresses.output_angle]) + self.coefficient * angle
        low, high = self.stops_at(angle, length)
        for spring, tendon in zip(self.springs, addresses.tendons, strict=True):
            model.tendon_lengthspring[tendon] = low - spring.start, high + spring.start
        torque = self.torque(length, (low, high))
        model.tendon_damping[addresses.tendons[0]] = self.damping if torque else 0.0
        pulled = self.coefficient * torque
        speed = float(data.qvel[dof])
        turning = speed if abs(speed) > AT_REST else pulled + data.qfrc_actuator[dof] + data.qfrc_applied[dof]
        model.dof_frictionloss[dof] = self.friction.torque(torque, speed, driving=pulled * turning < 0.0)

    def _step_rigid(self, model: Any, data: Any, addresses: JointAddresses) -> None:
        """Update a joint without springs by the torque that it transmitted in the last time step."""
        import mujoco

        dof = addresses.output_speed
        rows = (data.efc_type == int(mujoco.mjtConstraint.mjCNSTR_FRICTION_DOF)) & (data.efc_id == dof)
        friction = float(data.efc_force[rows].sum())
        inertia = self.ratio**2 * self.rotor_inertia
        torque = float(data.qfrc_actuator[dof] + friction - inertia * data.qacc[dof])
        speed = float(data.qvel[dof])
        turning = speed if abs(speed) * self.ratio > AT_REST else data.qfrc_actuator[dof] - torque
        lost = self.friction.torque(torque, self.ratio * speed, driving=torque * turning > 0.0)
        model.dof_frictionloss[dof] = self.ratio * lost

    def as_json(self) -> dict[str, Any]:
        """Convert the quantities, and all values in SI as `joint`, to JSON values."""
        quantities = {key: quantity.as_json() for key, quantity in self.quantities.items()}
        for key, driving in (("efficiency", True), ("back_driving_efficiency", False)):
            quantities.setdefault(key, {})["map"] = self._efficiency_map(driving)
        return {
            "design": self.name,
            "level": self.level,
            **quantities,
            "stiffness_polynomial": {
                "value": list(self.polynomial),
                "unit": "N m/rad, N m/rad^2, N m/rad^3",
                "numerical_error": list(self.polynomial_error),
                "note": f"torque a x + b x^2 + c x^3, x [rad] beyond the stop, up to {self.rated_torque:.4g} N m",
            },
            "te_harmonics": list(self.ripple.harmonics(self.way, self.rated_torque)),
            JOINT: self._values(),
        }

    @classmethod
    def from_json(cls, content: Mapping[str, Any]) -> Self:
        """Read a joint from the output of `as_json`, without the quantities.

        Raises
        ------
        UsageError
            The content is no joint.
        """
        try:
            values = dict(content[JOINT])
            values |= {key: float(values[key]) for key in NUMBERS}
            for key in ("stops", "polynomial", "polynomial_error"):
                values[key] = tuple(map(float, values[key]))
            values["springs"] = tuple(
                Spring(float(item["start"]), float(item["stiffness"])) for item in values["springs"]
            )
            values["slips"] = tuple(
                Slip(float(item["limit"]), float(item["stiffness"])) for item in values.get("slips", ())
            )
            values["friction"] = FrictionMap.from_json(values["friction"])
            values["ripple"] = Ripple.from_json(values["ripple"])
            joint = cls(**values)
        except (KeyError, TypeError, ValueError) as problem:
            reason = f"{type(problem).__name__}: {problem}"
            raise UsageError(
                f"the file does not describe a reducer ({reason}): use a reducer.json written by `cycloid-mj reduce`"
            ) from None
        sound = all(math.isfinite(values[key]) and values[key] > 0.0 for key in NUMBERS)
        if joint.level not in LEVELS or joint.way not in (-1, 1) or not sound or not joint.springs:
            raise UsageError(
                "the reducer file is not valid, because the value of level, way, springs or a number is not allowed: "
                "use a reducer.json written by `cycloid-mj reduce`"
            )
        return joint

    @classmethod
    def read(cls, path: str | Path) -> Self:
        """Read a reducer from its ``reducer.json``.

        Raises
        ------
        CycloidError
            The file cannot be read, or is no JSON.
        UsageError
            It contains no joint.
        """
        try:
            content = json.loads(Path(path).read_text(encoding="utf-8"))
        except (OSError, ValueError) as problem:
            raise CycloidError(
                f"cannot read {path}: {reason(problem)}. Use a reducer.json written by `cycloid-mj reduce`"
            ) from None
        return cls.from_json(content if isinstance(content, dict) else {})

    def _efficiency_map(self, driving: bool) -> dict[str, Any]:
        """Return the map of the efficiency [%] over torque and speed as JSON values."""
        torques = self.friction.torques[1:]
        return {
            "torques_nm": list(torques),
            "speeds_rpm": [speed / RPM for speed in self.friction.speeds],
            "percent": [
                [100.0 * self.friction.efficiency(torque, speed, self.ratio, driving) for torque in torques]
                for speed in self.friction.speeds
            ],
        }

    def _values(self) -> dict[str, Any]:
        """Return all values in SI except the quantities."""
        values = asdict(replace(self, quantities={}))
        del values["quantities"]
        return values


def _rising(values: Array) -> Array:
    """Lower each of some values to the least that follows, shape (n,)."""
    return np.minimum.accumulate(values[::-1])[::-1]
