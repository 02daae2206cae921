"""Output member, and its angles and torques in terms of the drive as seen from its ring.

Either the ring is fixed and the carrier of the output pins rotates, against the crank, by 1/(N-1) of its rotation; or
the carrier is fixed and the ring rotates, with the crank, by 1/N. The mesh is the same: seen from the ring, the second
case is the first with a crank slower by (N-1)/N (Willis). Statics is solved there, for both cases. With the crank
locked, a free rotation psi of the carrier against the ring is one of -psi (N-1)/N of the ring; without losses a torque
T on the ring is balanced by (N-1)/N T on the carrier and T/N on the crank.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.design import Design

if TYPE_CHECKING:
    from cycloid_mj.reducer import Reducer


@dataclass(frozen=True)
class Member:
    """Kinematics of crank, disc, carrier, ring and output.

    Attributes
    ----------
    turns_ring
        Whether the ring is the output, and the carrier is fixed.
    teeth, lobes
        Number of teeth of the ring, N, and of lobes of the disc, N - 1.
    """

    turns_ring: bool
    teeth: int
    lobes: int

    def gear_angle(self, crank: npt.ArrayLike) -> Array:
        """Return the angle of disc and carrier [rad] at crank angles [rad]: -crank/lobes, or 0 for a fixed carrier.

        Speeds map to speeds.
        """
        crank = np.asarray(crank, dtype=np.float64)
        return np.zeros_like(crank) if self.turns_ring else -crank / self.lobes

    def ring_angle(self, crank: npt.ArrayLike) -> Array:
        """Return the angle of the ring [rad] at crank angles [rad]: 0, or theta/N; speeds map to speeds."""
        crank = np.asarray(crank, dtype=np.float64)
        return crank / self.teeth if self.turns_ring else np.zeros_like(crank)

    def output_angle(self, crank: npt.ArrayLike) -> Array:
        """Return the angle of the output [rad] at crank angles [rad]; speeds map to speeds."""
        return np.asarray(crank, dtype=np.float64) / (self.teeth if self.turns_ring else -self.lobes)

    def against_ring(self, crank: npt.ArrayLike) -> Array:
        """Return the crank angle relative to the ring [rad], which determines the mesh. Speeds map to speeds."""
        return np.asarray(np.asarray(crank, dtype=np.float64) - self.ring_angle(crank))

    def crank_angle(self, driven: npt.ArrayLike) -> Array:
        """Return the angle of the crank [rad] at angles of the driven shaft [rad]; speeds map to speeds."""
        return np.asarray(driven, dtype=np.float64)

    def driven_angle(self, crank: npt.ArrayLike) -> Array:
        """Return the angle of the driven shaft [rad] at angles of the crank [rad]; the inverse of `crank_angle`."""
        return np.asarray(crank, dtype=np.float64)

    def mesh_angle(self, driven: npt.ArrayLike, ring: npt.ArrayLike) -> Array:
        """Return the crank angle relative to the ring [rad] at angles of the driven shaft and the ring [rad]."""
        return np.asarray(np.asarray(driven, dtype=np.float64) - np.asarray(ring))

    def ring_and_carrier(self, output: npt.ArrayLike) -> tuple[Array, Array]:
        """Return the angles of ring and carrier [rad] at an angle of the output; likewise speeds at its speed.

        Returns
        -------
        tuple of Array
            Angles of ring and carrier, in the shape of `output`. The member that is the output has its angle; the other
            is fixed and has the angle 0.
        """
        output = np.asarray(output, dtype=np.float64)
        fixed_angle = np.zeros_like(output)
        return (output, fixed_angle) if self.turns_ring else (fixed_angle, output)

    @property
    def turning_and_held(self) -> tuple[str, str]:
        """Names of the loaded and the fixed body: carrier (``output``) and ring (``housing``), or vice versa."""
        return (names.HOUSING, names.OUTPUT) if self.turns_ring else (names.OUTPUT, names.HOUSING)

    @property
    def share(self) -> float:
        """Ratio of the torque on the carrier to that on the output, without losses: 1, or (N-1)/N if the ring rotates.

        At a locked crank, it is also the ratio of the output's rotation to that of the carrier relative to the ring. In
        statics both ratios are positive, by the sign convention of `sense`.
        """
        return self.lobes / self.teeth if self.turns_ring else 1.0

    @property
    def sense(self) -> int:
        """Direction of positive output torques and rotations in statics: 1 counter-clockwise, -1 clockwise.

        Positive torques brake a crank that rotates counter-clockwise: they act counter-clockwise on a carrier, and
        clockwise on a ring.
        """
        return -1 if self.turns_ring else 1


def member_of(design: Design) -> Member:
    """Return the output member of a design."""
    return Member(design.output.turns_ring, design.ring.teeth, design.lobes)


def view_from_ring(design: Design) -> Design:
    """Return the design of the same drive in the frame of its ring, in which the ring is fixed and the carrier rotates.

    Speed and torques are those of the carrier. A design with a fixed ring is returned unchanged. Gravity is not
    converted to the rotating frame, and inertia forces of the frame are not included: this is left to the caller.
    """
    if not design.output.turns_ring:
        return design
    speed_share = 1.0 - 1.0 / design.ratio
    return design.model_copy(
        update={
            "output": design.output.model_copy(update={"member": "carrier"}),
            "drive": design.drive.model_copy(update={"speed": design.drive.speed * speed_share}),
            "load": design.load.model_copy(update={"torque": design.load.torque * speed_share}),
            "contact": design.contact.model_copy(update={"working_load": design.contact.working_load * speed_share}),
        }
    )


def view_columns_from_ring(reducer: "Reducer", columns: Mapping[str, Array]) -> dict[str, Array]:
    """Convert the columns of a run to the frame of the ring (`view_from_ring`); unchanged if the ring is fixed.

    Angles, positions, speeds and forces are converted to the rotating frame; the columns of pins are in this frame
    already. The load torque becomes the torque on the carrier, which balances those on crank and ring.

    Parameters
    ----------
    reducer
        The reducer of the run.
    columns
        Columns of a run by name, shape (n,), in SI units. ``output_angle`` is required; a missing ``output_speed``
        counts as 0.
    """
    ring_data = dict(columns)
    if not reducer.member.turns_ring:
        return ring_data
    angle, speed = columns["output_angle"], columns.get("output_speed", np.zeros_like(columns["output_angle"]))
    input_angle, input_speed, input_torque = (
        names.column(reducer.INPUT, quantity) for quantity in ("angle", "speed", "torque")
    )
    frame_motions = {
        "output_angle": 2.0 * angle,
        "output_speed": 2.0 * speed,
        input_angle: angle,
        input_speed: speed,
    }
    sun_x, sun_y, _ = names.planar_joints(names.SUN)
    _turn_back(ring_data, sun_x, sun_y, angle)
    for disc_name in reducer.gears:
        x, y, rotation, vx, vy, angular_speed = (*names.planar_joints(disc_name), *names.planar_speeds(disc_name))
        frame_motions |= {rotation: angle, angular_speed: speed}
        _turn_back(ring_data, x, y, angle)
        _turn_back(ring_data, vx, vy, angle)
        if vx in ring_data:
            ring_data[vx], ring_data[vy] = ring_data[vx] + speed * ring_data[y], ring_data[vy] - speed * ring_data[x]
    for name in columns:
        if name.endswith(names.FORCE_X):
            _turn_back(ring_data, name, f"{name.removesuffix(names.FORCE_X)}{names.FORCE_Y}", angle)
    ring_data |= {
        name: ring_data[name] - frame_motion for name, frame_motion in frame_motions.items() if name in ring_data
    }
    if {"load_torque", input_torque} <= ring_data.keys():
        ring_data["load_torque"] = -(columns["load_torque"] + columns[input_torque])
    return ring_data


def _turn_back(columns: dict[str, Array], x: str, y: str, angle: Array) -> None:
    """Rotate vectors in two columns clockwise by angles [rad], if the columns exist."""
    if x in columns and y in columns:
        cos, sin, along, up = np.cos(angle), np.sin(angle), columns[x], columns[y]
        columns[x], columns[y] = cos * along + sin * up, cos * up - sin * along
