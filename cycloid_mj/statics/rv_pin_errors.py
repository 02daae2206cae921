"""Rotation of an RV reducer's output due to position errors of its ring pins, by statics under the nominal torque.

Unlike errors of cranks and bores, those of pins have no closed form: errors of a few micrometres are as large as the
deflection of the loaded teeth, so that some pins lose contact and others carry more. In the frame of the ring, the
rotation repeats after each turn of the cranks.
"""

from dataclasses import dataclass, replace

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.design.rv import CrankErrors
from cycloid_mj.reducer import RvReducer, once
from cycloid_mj.statics.rv import RvLoads, RvSprings, compute_rv_springs, solve_rv_loads

ANGLES_PER_PIN = 2
"""Crank angles in a turn of the cranks, over the number of pins: peaks are within 1 % of those at 6 angles per pin."""


@dataclass(frozen=True)
class PinErrorEquilibrium:
    """Static equilibrium of an RV reducer with perfectly placed pins, and its change by errors of their positions.

    Attributes
    ----------
    reducer, torque
        Reducer whose N pins are at their nominal positions, and torque on its carrier [N m].
    springs, loads
        Springs at m crank angles over a turn of the cranks, and their equilibrium.
    """

    reducer: RvReducer
    torque: float
    springs: RvSprings
    loads: RvLoads

    def rotation(self, displacements: Array) -> Array:
        """Compute the rotation of the output [rad], (m,), at m crank angles due to displacements of N pins [m], (N, 2).

        A displaced pin changes gap and position along the flank as the opposite displacement of the disc does.

        Raises
        ------
        RunError
            The Newton method does not converge.
        """
        springs, gap = self.springs, self.springs.gap.copy()
        contact_displacements = np.tile(displacements, (springs.discs, 1))
        gap[:, : springs.pins] -= np.sum(springs.tooth_slope[..., :2] * contact_displacements, axis=-1)
        shift = springs.shift - np.sum(springs.shift_slope[..., :2] * contact_displacements, axis=-1)
        displaced_springs = replace(springs, gap=gap, shift=shift)
        loads = solve_rv_loads(displaced_springs, self.torque, start=self.loads.displacements)
        return self.reducer.share * (loads.carrier_turn - self.loads.carrier_turn)

    def interpolate(self, rotation: Array, crank: Array) -> Array:
        """Return a `rotation` (m,) [rad] at crank angles against the ring [rad], in the shape of `crank`."""
        return np.interp(crank, self.springs.crank, rotation, period=2.0 * np.pi)


@once
def pin_error_equilibrium(reducer: RvReducer, torque: float) -> PinErrorEquilibrium:
    """Compute the equilibrium of a reducer with perfectly placed pins under a torque on the carrier [N m].

    There are `ANGLES_PER_PIN` crank angles per pin over a turn of the cranks. Friction is left out; so are errors of
    cranks, bores and planets, which do not repeat after this turn.
    """
    pin_count = reducer.design.ring.teeth
    perfect_reducer = reducer.but(
        errors={"pin_x": (0.0,) * pin_count, "pin_y": (0.0,) * pin_count}, crank_errors=CrankErrors()
    )
    crank_angles = np.linspace(0.0, 2.0 * np.pi, ANGLES_PER_PIN * pin_count, endpoint=False)
    springs = compute_rv_springs(perfect_reducer, crank_angles)
    return PinErrorEquilibrium(perfect_reducer, torque, springs, solve_rv_loads(springs, torque))
