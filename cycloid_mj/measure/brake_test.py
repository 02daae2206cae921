"""The paper's test stand: a motor of constant torque on the crank, a brake that keeps the output's speed constant.

The crank's inertia oscillates on the stiffness of the mesh for some 100 ms at about 100 Hz. The torque of a motor falls
with its speed, which damps this; the mean torque is the given one, as the output determines the mean crank speed.

The motor first crosses the play of the reducer, at the speed at which this slope consumes all of its torque. That may
take longer than all else.
"""

import math
from dataclasses import replace

from cycloid_mj.base.names import DRIVE
from cycloid_mj.base.record import Run
from cycloid_mj.dynamics.drive_cycle import braked_output, rising
from cycloid_mj.dynamics.planar.model import PlanarModel
from cycloid_mj.dynamics.run import Model, Solver, model_for
from cycloid_mj.dynamics.settling import slowness
from cycloid_mj.measure.steady import run_steady
from cycloid_mj.reducer import Reducer

DECAY = 2e-3
"""Time [s] in which the motor's slope damps the oscillation to 1/e (heuristic): with the paper's motor, 5 % of its
speed consume all of its torque, as with induction motors (2 to 10 %)."""


def run_brake_test(reducer: Reducer, torque: float, periods: int, solver: Solver = "planar") -> Run:
    """Simulate a motor `torque` on the crank [N m] against a brake at constant output speed.

    The returned run covers `periods` mesh periods after the oscillation has decayed. Contact stiffnesses are valid at
    the output torque without losses, `torque` times the ratio. With a torque of 0 the crank is free, and the output
    drives it. `solver` is the solver of the runs, MuJoCo or the planar solver.
    """
    reducer = reducer.working_at(torque * reducer.design.reduction) if torque else reducer
    speed = reducer.design.drive.speed
    model = model_for(solver, reducer, held="output")
    speed_slope = 2.0 * model.crank_inertia / DECAY if torque else 0.0
    model = with_speed_slope(model, speed_slope)
    motor_torque = rising(math.copysign(torque, torque * speed), 2e-3)
    cycle = braked_output(model, reducer, lambda time: motor_torque(time) + speed_slope * speed)
    # the oscillation is below 0.2 % of the torque then
    # the motor turns the crank across all of its play, at the speed at which the slope consumes its torque
    crossing_turn = reducer.play * reducer.design.reduction * speed_slope / abs(torque) if torque else 0.0
    settling_time = max(15e-3, crossing_turn / slowness(reducer))
    return run_steady(reducer, settling_time, periods, solver, model, cycle)


def with_speed_slope(compiled: Model, speed_slope: float) -> Model:
    """Return a `compiled` model with an additional crank torque of -`speed_slope` [N m s/rad] times the crank speed.

    The editable model of a MuJoCo model is changed in place.
    """
    if isinstance(compiled, PlanarModel):
        return compiled.with_slope(speed_slope)
    import mujoco

    motor = compiled.spec.actuator(DRIVE)
    motor.biastype = mujoco.mjtBias.mjBIAS_AFFINE
    motor.biasprm = [0.0, 0.0, -speed_slope, *[0.0] * (len(motor.biasprm) - 3)]
    return replace(compiled, model=compiled.spec.compile())
