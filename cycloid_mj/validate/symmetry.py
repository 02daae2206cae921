"""Validation steps "mirror" and "gravity": reversed motion is a mirror image, and gravity adds its own load only."""

from dataclasses import dataclass

import numpy as np

from cycloid_mj.analysis.transmission import gear_error
from cycloid_mj.base.array import Array
from cycloid_mj.base.powers import mean_powers
from cycloid_mj.base.record import Run
from cycloid_mj.base.units import ARCSECONDS
from cycloid_mj.base.validation import ValidationRow, absolute, deviation_row, relative
from cycloid_mj.parts import gear_solid, mass_properties
from cycloid_mj.reducer import Reducer
from cycloid_mj.validate import rig
from cycloid_mj.validate.rig import FREE, PERIODS, rated_run

SPEED, GRAVITY = 1640.0, 9.8
"""Crank speed of Hsieh 2014 [rpm], and gravity [m/s2]."""


@dataclass(frozen=True)
class Bounds:
    """Bounds of a kind of ring, about three times the observed differences [%, points of efficiency].

    Free pins chatter, which amplifies rounding errors; other kinds repeat to rounding. Unloaded free pins leave their
    open sockets by their weight, rest on the disc and rotate it by 0.0025 %, eight times as much as in closed sockets.
    `still` is relative to the weight of the disc.
    """

    mirrored_ripple: float
    mirrored_forces: float
    mirrored_efficiency: float
    upward: float
    sideward: float
    still: float
    ripple: float
    turn: float
    efficiency: float


CHATTERING = Bounds(5.0, 2.3, 4.1e-3, 4.0, 1.9, 0.05, 2.4, 7.5e-3, 5.1e-3)
REPEATING = Bounds(1e-5, 1e-6, 1e-9, 0.4, 1.1, 0.01, 0.22, 1e-4, 3e-5)

BINS = 16
"""Bins of the mesh period in which the ripple is averaged; chatter averages out."""


def mirror_rows(kind: str, quick: bool) -> list[ValidationRow]:
    """Compare a run with reversed speed with the mirror image of the run with forward speed.

    The rows are the transmission error of the disc over a mesh period (`mean_ripple`), the tooth forces and the
    efficiency. `kind` is the kind of ring.
    There is no gravity. With `quick` the runs last 4 mesh periods instead of 12.
    """
    periods = 4 if quick else 12
    forward_run, design = rated_run(kind, SPEED, periods, *rig.without_gravity())
    reducer = Reducer(design)
    backward_run, _ = rated_run(kind, -SPEED, periods, *rig.without_gravity())
    bounds, source = _bounds(kind), "mirror image"
    forward_ripple, backward_ripple = mean_ripple(forward_run, reducer, 1.0), -mean_ripple(backward_run, reducer, -1.0)
    ripple_pair = backward_ripple - float(np.mean(forward_ripple)), forward_ripple - float(np.mean(forward_ripple))
    forward_forces = forward_run.forces(design.tooth_pair)
    mirrored_index = -np.arange(design.ring.teeth) % design.ring.teeth
    backward_forces = backward_run.forces(design.tooth_pair)[:, mirrored_index] * [-1.0, 1.0]
    efficiencies = 100.0 * mean_powers(backward_run).efficiency, 100.0 * mean_powers(forward_run).efficiency
    return [
        deviation_row(f"reversed: ripple of the gear, {kind}", *ripple_pair, "arcsec", source, bounds.mirrored_ripple),
        deviation_row(
            f"reversed: forces of the teeth, {kind}",
            backward_forces,
            forward_forces,
            "N",
            source,
            bounds.mirrored_forces,
        ),
        absolute(f"reversed: efficiency, {kind}", *efficiencies, "%", source, bounds.mirrored_efficiency),
    ]


def gravity_rows(kind: str, quick: bool) -> list[ValidationRow]:
    """Compare runs of one crank turn with gravity off, downward, and sideways (rotated by a right angle).

    Except for the positions of the output pins, the mechanism under sideways gravity behaves as that under downward
    gravity a quarter of a crank turn earlier. The rows are mean forces on the disc, first harmonic of the change of the
    transmission error by gravity, mean rotation of the disc and efficiency. `kind` is the kind of ring; `quick` is
    ignored.
    """
    # what gravity adds to the efficiency of pins that do not chatter is no more than steps of 10 us take away
    step_changes = [] if kind == FREE else ["settings.timestep_us=5.0"]
    run_without_gravity, design = rated_run(kind, SPEED, PERIODS, *step_changes, *rig.without_gravity())
    reducer = Reducer(design)
    downward_run, _ = rated_run(kind, SPEED, PERIODS, *step_changes, f"environment.gravity_y_m_s2={-GRAVITY}")
    sideways_changes = [*rig.without_gravity(), f"environment.gravity_x_m_s2={GRAVITY}"]
    sideways_run, _ = rated_run(kind, SPEED, PERIODS, *step_changes, *sideways_changes)
    bounds = _bounds(kind)
    weight = mass_properties(gear_solid(reducer)).mass * GRAVITY
    forces = {
        name: mean_force(run, reducer)
        for name, run in (("off", run_without_gravity), ("down", downward_run), ("turned", sideways_run))
    }
    harmonics = (
        first_harmonic(downward_run, run_without_gravity, reducer) * -1j,
        first_harmonic(sideways_run, run_without_gravity, reducer),
    )
    harmonic_down, harmonic_sideways = (np.array([[harmonic.real, harmonic.imag]]) for harmonic in harmonics)
    mean_errors = [float(np.mean(gear_arcsec(run, reducer))) for run in (downward_run, run_without_gravity)]
    efficiencies = 100.0 * mean_powers(downward_run).efficiency, 100.0 * mean_powers(run_without_gravity).efficiency
    return [
        relative(f"gravity: upward force on the gear, {kind}", forces["down"][1], weight, "N", "m g", bounds.upward),
        relative(f"gravity turned: sideward force, {kind}", -forces["turned"][0], weight, "N", "m g", bounds.sideward),
        absolute(
            f"gravity off: force, {kind}", float(np.hypot(*forces["off"])), 0.0, "N", "nothing", bounds.still * weight
        ),
        deviation_row(
            f"gravity turned: its ripple, {kind}",
            harmonic_sideways,
            harmonic_down,
            "arcsec",
            "a quarter turn later",
            bounds.ripple,
        ),
        relative(
            f"gravity: mean turn of the gear, {kind}",
            mean_errors[0],
            mean_errors[1],
            "arcsec",
            "gravity off",
            bounds.turn,
        ),
        absolute(f"gravity: efficiency, {kind}", *efficiencies, "%", "gravity off", bounds.efficiency),
    ]


def _bounds(kind: str) -> Bounds:
    return CHATTERING if kind == FREE else REPEATING


def gear_arcsec(run: Run, reducer: Reducer) -> Array:
    """Compute the transmission error of the disc [arcsec], shape (n,)."""
    return ARCSECONDS * gear_error(run, reducer)


def mean_ripple(run: Run, reducer: Reducer, direction: float) -> Array:
    """Compute the ripple of a run: the transmission error of the disc [arcsec] over a mesh period, shape (BINS,).

    The period is divided into bins; each value is the mean over all samples of the run in a bin. `direction` is the
    sign of the crank speed.
    """
    phase = np.mod(direction * run["crank_angle"] * reducer.design.ring.teeth / (2.0 * np.pi), 1.0)
    bin_indices = np.minimum((BINS * phase).astype(int), BINS - 1)
    error = gear_arcsec(run, reducer)
    return np.asarray(np.bincount(bin_indices, error, BINS) / np.bincount(bin_indices, minlength=BINS))


def mean_force(run: Run, reducer: Reducer) -> Array:
    """Compute the mean force of all contacts on the disc [N], shape (2,)."""
    forces_by_kind = [run.forces(kind) for kind in (reducer.design.tooth_pair, "output", "cam")]
    return np.asarray(np.mean(sum(forces.sum(axis=1) for forces in forces_by_kind), axis=0))


def first_harmonic(run: Run, run_without_gravity: Run, reducer: Reducer) -> complex:
    """Compute the first harmonic over a crank turn of the effect of gravity on the transmission error [arcsec]."""
    difference = gear_arcsec(run, reducer) - gear_arcsec(run_without_gravity, reducer)
    return complex(2.0 * np.mean(difference * np.exp(-1j * run["crank_angle"])))
