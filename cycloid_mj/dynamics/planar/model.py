"""Model of a design for the planar solver, the counterpart of ``mjcf.ReducerModel``."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from cycloid_mj.dynamics.drive_cycle import DriveCycle
from cycloid_mj.dynamics.law import ContactParameters
from cycloid_mj.dynamics.mjcf import Held
from cycloid_mj.dynamics.mjcf.laws import laws_of_discs, stiffest
from cycloid_mj.dynamics.planar.crank_train import CrankTrain
from cycloid_mj.dynamics.planar.rv_system import input_inertia, make_crank_train, make_rv_system
from cycloid_mj.dynamics.planar.state import start_state
from cycloid_mj.dynamics.planar.stepper import Stepper
from cycloid_mj.dynamics.planar.system import System, make_system
from cycloid_mj.dynamics.planar.timestep import choose_step, resolves_pins
from cycloid_mj.dynamics.regime import static_warnings
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.reducer.bodies import Pair
from cycloid_mj.statics.film import drag_torques


@dataclass(frozen=True, eq=False)
class PlanarModel:
    """A reducer for the planar solver.

    Attributes
    ----------
    system
        Its arrays for the solver.
    train
        The cranks of an RV reducer as arrays; None with a central crank.
    timestep
        Time step [s].
    laws
        The contact law of each kind of pair, on the disc where it is stiffest.
    servo_gains
        kp [N m/rad] and kv [N m s/rad] of the servo on the driven shaft.
    crank_inertia
        Inertia of shaft and rotor about the crank axis [kg m2]; of an RV reducer that of all parts, seen from the sun.
    drags
        Names of its losses of seals and lubricant.
    warnings
        Warnings about its results.
    """

    reducer: Reducer
    system: System
    train: CrankTrain | None
    timestep: float
    laws: Mapping[str, ContactParameters]
    servo_gains: tuple[float, float]
    crank_inertia: float
    drags: tuple[str, ...]
    warnings: tuple[str, ...]

    @property
    def pairs(self) -> tuple[Pair, ...]:
        """Every mating pair, in the order of the log's force columns."""
        return self.reducer.mechanism.pairs

    def with_slope(self, slope: float) -> "PlanarModel":
        """Return the model with a crank torque that falls with the crank speed by `slope` [N m s/rad]."""
        servo = self.system.servo.copy()
        servo[1] = 0.0, slope
        return replace(self, system=self.system._replace(servo=servo))

    def stepper(self, cycle: DriveCycle, stride: int) -> Stepper:
        """Return a stepper at the start of a drive cycle, with one sample in `stride` steps."""
        positions, speeds = start_state(self.reducer, cycle.angle, cycle.speed)
        midpoint_pins = resolves_pins(self.reducer, self.timestep)
        return Stepper(self.system, self.timestep, positions, speeds, stride, midpoint_pins, self.train)


def planar_model(reducer: Reducer, held: Held = "crank", timestep: float = 0.0) -> PlanarModel:
    """Return a reducer prepared for the planar solver: arrays, contact laws, servo gains, warnings, time step [s].

    The default `timestep` of 0 stands for an automatic choice. `held` is the shaft with a position servo, "crank" or
    "output"; a torque acts on the other shaft.

    Raises
    ------
    DesignError
        A part of the design is not feasible.
    """
    laws = stiffest(laws_of_discs(reducer))
    if isinstance(reducer, RvReducer):
        system, train, crank_inertia = make_rv_system(reducer, held), make_crank_train(reducer), input_inertia(reducer)
    else:
        system, train = make_system(reducer, held), None
        crank_inertia = float(system.inertia[-1])
    servo_shaft = ("output", "crank").index(held) if held else 0
    losses = dict(zip((f"{reducer.INPUT}_drag", "output_drag"), drag_torques(reducer), strict=True))
    return PlanarModel(
        reducer=reducer,
        system=system,
        train=train,
        timestep=timestep or choose_step(reducer).seconds,
        laws=laws,
        servo_gains=(float(system.servo[servo_shaft, 0]), float(system.servo[servo_shaft, 1])),
        crank_inertia=crank_inertia,
        drags=tuple(name for name, loss in losses.items() if loss),
        warnings=static_warnings(reducer, laws),
    )
