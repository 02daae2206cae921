"""Statics of the full model, as the identification of a joint needs it: for a central crank, and for an RV reducer.

The crank is the driven shaft; that of an RV reducer is its sun.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.dynamics.drive_cycle import braking_sign
from cycloid_mj.dynamics.law import ContactParameters
from cycloid_mj.dynamics.mjcf.bodies import crank_inertia
from cycloid_mj.dynamics.mjcf.laws import contact_laws
from cycloid_mj.parts import input_inertia, moving_masses, turning_inertia
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.statics.balance import loads
from cycloid_mj.statics.rv import compute_rv_springs, solve_rv_loads
from cycloid_mj.statics.rv_film import running_friction
from cycloid_mj.statics.rv_sheet import (
    output_rotation,
    solve_rv_equilibrium,
    springs_over_turn,
    torque_on_carrier,
)
from cycloid_mj.statics.springs import POSES, at_rest, springs_of, turn_evenly
from cycloid_mj.statics.structure import wind_up
from cycloid_mj.statics.windup import STRAIGHT, solve_windups


class FullModel(ABC):
    """Static equilibrium of a reducer under a torque on its output.

    `POSES` is the number of crank angles of a mean, unless another is set. All methods raise RunError if there is no
    equilibrium.
    """

    crank_parts: str
    """Parts whose inertia is on the crank, in words."""
    no_load_note: str
    """Causes of friction without load, and causes that are not included."""

    @property
    @abstractmethod
    def parts(self) -> int:
        """Number of parts of a turn of the output in which `rotation_over_part` is computed."""

    @abstractmethod
    def locked_rotation(self, poses: int) -> Callable[[float], float]:
        """Return a function from a torque on the output [N m] to the mean rotation of the output [rad].

        The crank is locked; there is neither friction nor weight. Both are counter-clockwise. The mean is over `poses`
        crank angles.
        """

    @abstractmethod
    def rotation_over_part(self, torque: float, direction: int, part: int, samples: int) -> Array:
        """Compute the rotation of the output from its ideal angle [rad] over a part of its turn, with friction.

        Parameters
        ----------
        torque
            Torque on the output [N m] that brakes it.
        direction
            Direction of the crank, 1 or -1.
        part
            Part of the turn of the output, from 0 to `parts` - 1.
        samples
            Number of crank angles in a mesh period; they are evenly spaced and start with the part.

        Returns
        -------
        Array
            Rotations, positive counter-clockwise, at m crank angles in counter-clockwise order, shape (m,).
        """

    @abstractmethod
    def compliances(self) -> dict[str, float]:
        """Compute the compliance of the output due to each kind of spring [rad/(N m)]: kind -> mean over a turn."""

    @abstractmethod
    def time_constants(self) -> dict[str, float]:
        """Compute the damping over the stiffness of each kind of spring [s], by the keys of `compliances`."""

    @abstractmethod
    def inertias(self) -> tuple[float, float]:
        """Compute the inertia of what turns with the crank, and of what turns with the output [kg m2]."""

    def damping(self) -> float:
        """Compute the damping between output and housing [N m s/rad] as the drive winds up.

        Each contact is a spring (stiffness K) with a parallel damper (damping C), and all contacts are in series. For
        slow motion, their total damping is c = k^2 sum(s C/K), with the total stiffness k and the compliance s of each
        contact at the output.
        """
        compliances, time_constants = self.compliances(), self.time_constants()
        total_compliance = sum(compliances.values())
        return sum(time_constants[kind] * compliance for kind, compliance in compliances.items()) / total_compliance**2


class CentralModel(FullModel):
    """Statics of a reducer with a central crank."""

    crank_parts = "shaft, rotor and the discs' orbit"
    no_load_note = "weight and centrifugal force of the discs, and drag of seals and lubricant; no shaft bearings"

    def __init__(self, reducer: Reducer) -> None:
        self._reducer = reducer

    @property
    def parts(self) -> int:
        """Number of turns of the crank per turn of the output."""
        return round(self._reducer.design.reduction)

    def locked_rotation(self, poses: int) -> Callable[[float], float]:
        """Return a function from the torque on the output [N m] to the output's mean rotation [rad] at a locked crank.

        It is the mean over `poses` crank angles.
        """
        sense = self._reducer.member.sense
        resting_reducer = at_rest(self._reducer)
        springs = springs_of(resting_reducer, turn_evenly(self._reducer, poses), friction=False)

        def rotation(torque: float) -> float:
            return float(sense * loads(resting_reducer, springs, sense * torque).output_turn.mean())

        return rotation

    def rotation_over_part(self, torque: float, direction: int, part: int, samples: int) -> Array:
        """Compute the rotation of the output over a turn of the crank; see `FullModel`."""
        driven = self._reducer.but(drive={"speed": direction * abs(self._reducer.design.drive.speed)})
        count = self._reducer.mesh_periods * samples
        springs = springs_of(driven, 2.0 * np.pi * (np.arange(count) / count + part))
        return self._reducer.member.sense * loads(driven, springs, direction * torque, warm_start=True).output_turn

    def compliances(self) -> dict[str, float]:
        """Compute the torsional compliance of each kind of contact, of bending pins and of the structure [rad/(N m)].

        The values are means over a turn of the crank at the rated torque. The keys are "output" (contacts of the output
        pins), "cam", "mesh" (teeth), "bending" (of the output pins) and "twist" (of the structure).
        """
        reducer = self._reducer
        compliances = [
            windup.compliance_by_spring(reducer)
            for windup in solve_windups(reducer, turn_evenly(reducer), reducer.design.rated_torque)
        ]
        means = {kind: float(np.mean([values[kind] for values in compliances])) for kind in compliances[0]}
        return means | {"twist": wind_up(reducer)}

    def time_constants(self) -> dict[str, float]:
        """Compute the ratio of damping to stiffness of each kind of contact [s], by the keys of `compliances`.

        Bending of output pins and twist of the structure have that of the output contacts.
        """
        laws = contact_laws(self._reducer)
        cam_time, output_time = (laws[kind].damping / laws[kind].stiffness for kind in ("cam", "output"))
        return {
            "cam": cam_time,
            "mesh": _tooth_time_constant(self._reducer, laws),
            **dict.fromkeys(("output", "bending", "twist"), output_time),
        }

    def inertias(self) -> tuple[float, float]:
        """Compute the inertias of crank and output [kg m2], each with the parts that rotate with it.

        The crank has the inertia of shaft and rotor, and that of the orbiting masses of the discs. If the carrier is
        the output, the output also has the discs, which rotate with it. If the ring is the output, the discs do not
        rotate, and the output is the ring with its pins.
        """
        reducer, masses = self._reducer, moving_masses(self._reducer)
        discs = [masses[body.part] for body in reducer.mechanism.discs]
        orbit = sum(disc.mass for disc in discs) * reducer.design.gear.eccentricity**2
        return crank_inertia(reducer, masses) + orbit, turning_inertia(reducer)


class RvModel(FullModel):
    """Statics of an RV reducer, without weight and inertia; all means are over a turn of the carrier."""

    crank_parts = "sun, rotor, rotation of cranks and planets, and the discs' orbit"
    no_load_note = (
        "drag of seals and, with friction.law = film, of rolling bearings; weight of the discs is not included"
    )

    def __init__(self, reducer: RvReducer) -> None:
        self._reducer = reducer

    @property
    def parts(self) -> int:
        """Number of turns of the cranks against the ring per turn of the output."""
        return round(self._reducer.crank_turn / (2.0 * np.pi))

    def locked_rotation(self, poses: int) -> Callable[[float], float]:
        """Return a function from the torque on the output [N m] to the output's mean rotation [rad] at a locked sun.

        It is the mean over `poses` crank angles.
        """
        reducer, brake_sign = self._reducer, braking_sign(self._reducer)

        def rotation(torque: float) -> float:
            carrier_turn = solve_rv_equilibrium(reducer, brake_sign * torque, poses).carrier_turn
            return float(output_rotation(reducer, carrier_turn).mean())

        return rotation

    def rotation_over_part(self, torque: float, direction: int, part: int, samples: int) -> Array:
        """Compute the rotation of the output from its ideal angle [rad] over one of the `parts` of its turn.

        Friction is included. `torque` brakes the output [N m], `direction` is that of the crank, 1 or -1, `part` the
        index of the part, and `samples` the number of crank angles in a mesh period. The part is a turn of the cranks
        against the ring. The result has shape (m,) for m crank angles and is positive counter-clockwise.
        """
        turning_reducer = self._reducer.but(drive={"speed": direction * abs(self._reducer.design.drive.speed)})
        count = turning_reducer.design.ring.teeth * samples
        sun_angle = 2.0 * np.pi * turning_reducer.design.reduction * (np.arange(count) / count + part) / self.parts
        crank_angle, carrier_torque = (
            turning_reducer.member.against_ring(sun_angle),
            torque_on_carrier(turning_reducer, torque),
        )
        friction = running_friction(turning_reducer, crank_angle, np.sign(carrier_torque))
        equilibrium = solve_rv_loads(compute_rv_springs(turning_reducer, crank_angle), carrier_torque, friction)
        return output_rotation(turning_reducer, equilibrium.carrier_turn)

    def compliances(self) -> dict[str, float]:
        """Compute the compliance of teeth ("mesh"), crank bearings and planets at the output [rad/(N m)].

        The keys are "mesh", `names.CRANK_BEARING` and `names.PLANET_MESH`. The values are means over a turn of the
        carrier, valid between the ends of the straight part of the wind-up curve. The compliance of a spring is the
        work of the change of its force over the square of the change of the torque.
        """
        reducer, torques = self._reducer, [share * self._reducer.design.rated_torque for share in STRAIGHT]
        springs = springs_over_turn(reducer, POSES)
        low_loads, high_loads = (solve_rv_equilibrium(reducer, torque, POSES) for torque in torques)
        tooth_stiffness, flank_stiffness = np.split(springs.stiffness, [springs.pins], axis=1)
        work = {
            "mesh": (high_loads.pins - low_loads.pins) ** 2 / tooth_stiffness,
            names.CRANK_BEARING: (high_loads.cranks - low_loads.cranks) ** 2 / springs.bearing_stiffness,
            names.PLANET_MESH: (high_loads.flanks - low_loads.flanks) ** 2
            / flank_stiffness.reshape(high_loads.flanks.shape),
        }
        squared_torque_change = (torques[1] - torques[0]) ** 2 * len(springs.crank)
        return {kind: float(work_of_springs.sum()) / squared_torque_change for kind, work_of_springs in work.items()}

    def time_constants(self) -> dict[str, float]:
        """Compute the time constants of teeth, crank bearings and planets."""
        laws = contact_laws(self._reducer)
        pairs = (names.CRANK_BEARING, names.PLANET_MESH)
        return {kind: laws[kind].damping / laws[kind].stiffness for kind in pairs} | {
            "mesh": _tooth_time_constant(self._reducer, laws)
        }

    def inertias(self) -> tuple[float, float]:
        """Compute the inertias of sun and output [kg m2], each with the parts that rotate with it.

        If the carrier is the output, its inertia includes the discs, and the cranks as point masses on their circle.
        The sun has the remaining inertia of all parts at their ideal speeds.
        """
        design, output_inertia = self._reducer.design, turning_inertia(self._reducer)
        sun_inertia = input_inertia(self._reducer) + design.drive.rotor_inertia - output_inertia / design.reduction**2
        return sun_inertia, output_inertia


def _tooth_time_constant(reducer: Reducer, laws: Mapping[str, ContactParameters]) -> float:
    """Compute the time constant [s] of the contacts of a pin with disc and seat in series, weighted by compliance."""
    pairs = (reducer.design.tooth_pair, reducer.design.seat_pair)
    in_series = [laws[kind] for kind in pairs if kind in laws]
    return sum(law.damping / law.stiffness**2 for law in in_series) / sum(1.0 / law.stiffness for law in in_series)


def full_model(reducer: Reducer) -> FullModel:
    """Return the statics of a reducer of any layout."""
    return RvModel(reducer) if isinstance(reducer, RvReducer) else CentralModel(reducer)
