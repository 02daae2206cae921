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
from cycloid_mj.robot.standalone import AT_REST, varied

Level = Literal["rigid", "backlash", "full"]
"""Level of detail: ratio, inertia and constant friction; additionally play and springs; additionally load-dependent
friction and transmission error, by `ReducedJoint.step`."""

LEVELS: tuple[Level, ...] = get_args(Level)

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
    """Model of a reducer as a robot joint: springs, backlash, losses and inertias instead of its parts.

    Attributes
    ----------
    name
        Name of the design.
    level
        Level of detail in a model, see `Level`.
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
        """Identified quantities, one row each."""
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

    @property
    def no_load_damping_at_output(self) -> float:
        """Rise of the no-load friction with the speed by centrifugal force, at the output [N m s/rad]."""
        lowest_speed, highest_speed = self.friction.speeds[0], self.friction.speeds[-1]
        torque_at_lowest_speed, torque_at_highest_speed = (
            self.friction.torque(0.0, speed, driving=True) for speed in (lowest_speed, highest_speed)
        )
        return max(
            0.0, self.ratio**2 * (torque_at_highest_speed - torque_at_lowest_speed) / (highest_speed - lowest_speed)
        )

    @cached_property
    def fingerprint(self) -> int:
        """Number that identifies the joints of a model with this reducer, at any level; MJCF keeps all its digits."""
        values = {key: value for key, value in self._values().items() if key not in ("level", "slips")}
        return 1 + zlib.crc32(json.dumps(values, sort_keys=True).encode()) % 999_999

    def stiffness(self, torque: float) -> float:
        """Compute the slope of the springs' torque over the output's deviation at a torque of this size [N m/rad]."""
        wind_up = self.wind_up(torque)
        return sum(spring.stiffness for spring in self.springs if spring.start <= wind_up)

    def wind_up(self, torque: float) -> float:
        """Compute how far [rad] a torque [N m] of either sign turns the joint's output beyond the stop (>= 0)."""
        previous_start, torque_at_previous_start, slope = 0.0, 0.0, 0.0
        for spring in self.springs:
            if torque_at_previous_start + slope * (spring.start - previous_start) > abs(torque):
                break
            torque_at_previous_start += slope * (spring.start - previous_start)
            previous_start, slope = spring.start, slope + spring.stiffness
        return previous_start + (abs(torque) - torque_at_previous_start) / slope

    def torque(self, deviation: float, stops: tuple[float, float] | None = None) -> float:
        """Compute the torque of the springs on the output [N m] at its deviation L [rad].

        L is the output's angle minus its ideal angle at the crank's angle. The torque acts towards the play. `stops`
        are the deviations at the ends of the play [rad], by default their means over the crank angle.
        """
        lower_stop, upper_stop = stops or self.stops
        wind_up = max(deviation - upper_stop, lower_stop - deviation)
        magnitude = sum(spring.stiffness * max(wind_up - spring.start, 0.0) for spring in self.springs)
        return -magnitude if deviation > upper_stop else magnitude

    def stops_at(self, angle: float, deviation: float) -> tuple[float, float]:
        """Compute the deviations at both stops [rad] at a crank angle [rad], with the transmission error under load.

        The load is that of the springs at the output's `deviation` L [rad].
        """
        return self.moving_stops(angle)(deviation)

    def moving_stops(self, angle: float) -> Callable[[float], tuple[float, float]]:
        """Return a function that computes the positions of both stops at one crank angle [rad].

        The transmission error moves the stops, depending on the load. The argument of the function is the deviation L
        of the output, and its results are the deviations at the lower and the upper stop, all in rad. It is faster than
        `stops_at` for several deviations at one crank angle. The load at L is interpolated, since L is piecewise linear
        in the torque. Several torques can have the same L, if the error falls faster with the load than the springs
        wind up; the largest is used.
        """
        load_shares, _ = self._bend_points
        (lower_errors, lower_deviation), (upper_errors, upper_deviation) = self._stop_deviations(angle)

        def stops(deviation: float) -> tuple[float, float]:
            """Return the deviations L at the lower and the upper stop [rad], under the load at the output's deviation.

            `deviation` is L [rad], the output's angle minus its ideal angle. It determines the torque, and so the
            transmission errors that move both stops.
            """
            share_below, share_above = (
                np.interp(-deviation, lower_deviation, load_shares),
                np.interp(deviation, upper_deviation, load_shares),
            )
            return (
                self.stops[0] + float(np.interp(share_below, load_shares, lower_errors)),
                self.stops[1] + float(np.interp(share_above, load_shares, upper_errors)),
            )

        return stops

    def bends(self, angle: float) -> Array:
        """Return n deviations L of the output [rad], (n,), at which the slope of the springs' torque changes.

        L is the output's angle minus its ideal angle at the crank's angle. The bends are the stops, and the points
        beyond them at which further springs come into contact, in increasing order. At the level `full`, the
        transmission error at the crank angle `angle` [rad] moves them.
        """
        if self.level == "full":
            (_, lower_deviations), (_, upper_deviations) = self._stop_deviations(angle)
            return np.unique([*-lower_deviations, *upper_deviations])
        starts = [spring.start for spring in self.springs]
        return np.unique(
            [
                sign * start + stop_angle
                for start in starts
                for sign, stop_angle in zip((-1, 1), self.stops, strict=True)
            ]
        )

    def _stop_deviations(self, angle: float) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        """Compute transmission errors and deviations of the output under load at both stops, at a crank angle [rad].

        A deviation L is the output's angle minus its ideal angle.

        Returns
        -------
        tuple
            For the lower stop, errors (n,) [rad] and -L (n,) [rad]; for the upper stop, errors and L. The n loads are
            those of `_bend_points`. Neither -L nor L falls with the load.
        """
        load_shares, wind_ups = self._bend_points
        lower_errors, upper_errors = (
            np.interp(load_shares, self.ripple.loads, error_at_loads) for error_at_loads in self.ripple.errors_at(angle)
        )
        return (lower_errors, _lower_envelope(wind_ups - lower_errors - self.stops[0])), (
            upper_errors,
            _lower_envelope(wind_ups + upper_errors + self.stops[1]),
        )

    @cached_property
    def _bend_points(self) -> tuple[Array, Array]:
        """Return n loads between which transmission errors and spring torques are linear, and their wind-ups.

        The loads are shares of the nominal torque [1], the wind-ups are in rad; shape (n,) each, in increasing order.
        """
        torques_at_starts = [
            sum(spring.stiffness * max(reached_spring.start - spring.start, 0.0) for spring in self.springs)
            for reached_spring in self.springs
        ]
        shares = np.unique([0.0, *self.ripple.loads, *(torque / self.rated_torque for torque in torques_at_starts)])
        return shares, np.array([self.wind_up(share * self.rated_torque) for share in shares.tolist()])

    def at(self, level: Level) -> Self:
        """Return the reducer at another level of detail."""
        if level not in LEVELS:
            raise UsageError(f"unknown level of detail {level!r} of the reducer: choose one of {', '.join(LEVELS)}")
        return replace(self, level=level)

    def varied(self, factors: Mapping[str, float]) -> Self:
        """Return the joint with its parameters scaled by factors, by the keys of `robot.standalone.PARAMETERS`."""
        return self.from_json({JOINT: varied(self._values(), factors)})

    def step(self, model: Any, data: Any) -> None:
        """Write load-dependent friction and transmission error into a MuJoCo model; call it before each ``mj_step``.

        All joints of the model with this reducer are updated, each at the level of detail at which it was attached.

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
                self._step_with_springs(model, data, addresses)
            else:
                self._step_rigid(model, data, addresses)

    def settle(self, model: Any, data: Any) -> None:
        """Set the cranks of all joints with this reducer to the middle of the play, turning along with their outputs.

        `model` is the ``MjModel``. Call it after you set joint angles and speeds in `data` (``MjData``); otherwise the
        springs start loaded.
        """
        for addresses in self.places(model):
            if addresses.tendons:
                data.qpos[addresses.crank_angle] = (self.middle - data.qpos[addresses.output_angle]) / self.coefficient
                data.qvel[addresses.crank_speed] = -data.qvel[addresses.output_speed] / self.coefficient

    def places(self, model: Any) -> Iterator[JointAddresses]:
        """Yield, for each joint of a MuJoCo model with this reducer, the indices of its crank, output and tendons.

        Raises
        ------
        UsageError
            The model has no joint with this reducer.
        """
        tuples = zip(model.tuple_adr.tolist(), model.tuple_size.tolist(), strict=True)
        matching_tuples = [
            (start, size) for start, size in tuples if size and model.tuple_objprm[start] == self.fingerprint
        ]
        if not matching_tuples:
            raise UsageError(
                f"no joint of the model has the reducer {self.name!r}: attach it first with attach_reducer"
            )
        for start, size in matching_tuples:
            output_joint, *other_objects = model.tuple_objid[start : start + size].tolist()
            crank_joint, *tendons = other_objects or [output_joint]
            output_addresses, crank_addresses = (
                (int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])) for joint in (output_joint, crank_joint)
            )
            yield JointAddresses(*output_addresses, *crank_addresses, tuple(tendons))

    def _step_with_springs(self, model: Any, data: Any, addresses: JointAddresses) -> None:
        """Update the joint's load-dependent friction and the dead bands of its springs in a MuJoCo model.

        It is called before each step, because the transmission error moves the dead bands. `addresses` are those of the
        joint in `model` and `data`.
        """
        angle, dof = float(data.qpos[addresses.crank_angle]), addresses.crank_speed
        deviation = float(data.qpos[addresses.output_angle]) + self.coefficient * angle
        lower_stop, upper_stop = self.stops_at(angle, deviation)
        for spring, tendon in zip(self.springs, addresses.tendons, strict=True):
            model.tendon_lengthspring[tendon] = lower_stop - spring.start, upper_stop + spring.start
        torque = self.torque(deviation, (lower_stop, upper_stop))
        model.tendon_damping[addresses.tendons[0]] = self.damping if torque else 0.0
        torque_on_crank = self.coefficient * torque
        speed = float(data.qvel[dof])
        direction = (
            speed if abs(speed) > AT_REST else torque_on_crank + data.qfrc_actuator[dof] + data.qfrc_applied[dof]
        )
        model.dof_frictionloss[dof] = self.friction.torque(torque, speed, driving=torque_on_crank * direction < 0.0)

    def _step_rigid(self, model: Any, data: Any, addresses: JointAddresses) -> None:
        """Write the friction of a joint without springs to a MuJoCo model, for the torque of the last step.

        `addresses` are those of the joint in `model` and `data`.
        """
        import mujoco

        dof = addresses.output_speed
        rows = (data.efc_type == int(mujoco.mjtConstraint.mjCNSTR_FRICTION_DOF)) & (data.efc_id == dof)
        friction = float(data.efc_force[rows].sum())
        inertia = self.ratio**2 * self.rotor_inertia
        torque = float(data.qfrc_actuator[dof] + friction - inertia * data.qacc[dof])
        speed = float(data.qvel[dof])
        direction = speed if abs(speed) * self.ratio > AT_REST else data.qfrc_actuator[dof] - torque
        friction_on_crank = self.friction.torque(torque, self.ratio * speed, driving=torque * direction > 0.0)
        model.dof_frictionloss[dof] = self.ratio * friction_on_crank

    def as_json(self) -> dict[str, Any]:
        """Convert a reduced joint to JSON values: quantities by key, efficiency maps, and all SI values (key `joint`).

        ``stiffness_polynomial`` has the coefficients of the wind-up curve, ``te_harmonics`` the result of
        `Ripple.harmonics`.
        """
        quantities = {key: quantity.as_json() for key, quantity in self.quantities.items()}
        for key, is_driving in (("efficiency", True), ("back_driving_efficiency", False)):
            quantities.setdefault(key, {})["map"] = self._efficiency_map(is_driving)
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
    def from_json(cls, content: Mapping[str, Any], origin: str = "the reducer") -> Self:
        """Create a joint from the result of `as_json`; its `quantities` are left empty.

        `origin` is the name of the content in messages.

        Raises
        ------
        UsageError
            The content does not describe a joint.
        """
        try:
            values = dict(content[JOINT])
            values |= {key: float(values[key]) for key in NUMBERS}
            for key in ("stops", "polynomial", "polynomial_error"):
                values[key] = tuple(map(float, values[key]))
            values["springs"] = tuple(
                Spring(float(entry["start"]), float(entry["stiffness"])) for entry in values["springs"]
            )
            values["slips"] = tuple(
                Slip(float(entry["limit"]), float(entry["stiffness"])) for entry in values.get("slips", ())
            )
            values["friction"] = FrictionMap.from_json(values["friction"])
            values["ripple"] = Ripple.from_json(values["ripple"])
            joint = cls(**values)
        except (KeyError, TypeError, ValueError) as problem:
            raise UsageError(
                f"{origin} does not describe a joint ({type(problem).__name__}: {problem}): use a reducer.json written "
                "by `cycloid-mj reduce`"
            ) from None
        for key, is_valid, allowed_text in (
            ("level", joint.level in LEVELS, f"one of {', '.join(LEVELS)}"),
            ("way", joint.way in (-1, 1), "1 (the output turns as the crank) or -1 (opposite)"),
            ("springs", bool(joint.springs), "a list of at least one spring"),
            *((key, 0.0 < values[key] < math.inf, "finite and greater than 0") for key in NUMBERS),
        ):
            if not is_valid:
                raise UsageError(
                    f"{origin}: the value of {JOINT}.{key} must be {allowed_text}, but is {content[JOINT][key]!r:.60}: "
                    "use a reducer.json written by `cycloid-mj reduce`"
                )
        return joint

    @classmethod
    def read(cls, path: str | Path) -> Self:
        """Read a reduced joint from the file ``reducer.json`` that ``cycloid-mj reduce`` writes.

        Raises
        ------
        CycloidError
            The file cannot be read, or is not JSON.
        UsageError
            It does not describe a joint.
        """
        try:
            content = json.loads(Path(path).read_text(encoding="utf-8"))
        except (OSError, ValueError) as problem:
            raise CycloidError(
                f"cannot read {path}: {reason(problem)}. Use a reducer.json written by `cycloid-mj reduce`"
            ) from None
        return cls.from_json(content if isinstance(content, dict) else {}, str(path))

    def _efficiency_map(self, driving: bool) -> dict[str, Any]:
        """Return the efficiency [%] at output torques and crank speeds as JSON values.

        `driving` is True for the efficiency with the crank driving, False for that with the output driving. ``percent``
        has a row for each of ``speeds_rpm``, with a value for each of ``torques_nm``.
        """
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


def _lower_envelope(values: Array) -> Array:
    """Replace each value by the smallest of this and all later values, shape (n,), so that the values never fall."""
    return np.minimum.accumulate(values[::-1])[::-1]
