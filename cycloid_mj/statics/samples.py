"""Statics of many samples of a design that differ in clearances, manufacturing errors and modification.

Gaps are linear in the deviations of a sample, so the springs of all samples follow from those of ideal parts, which are
computed once. A displaced pin moves its contact like its disc in the opposite direction, a displaced hole like its
disc, and rotated flanks like a rotated disc.
"""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields, replace
from itertools import pairwise

import numpy as np

from cycloid_mj.base.array import Array, Integers
from cycloid_mj.base.compiling import announce_compilation
from cycloid_mj.base.interrupt import check_interrupt
from cycloid_mj.design import Errors, Measured, Modification
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.deviations import profile_error
from cycloid_mj.geometry.kinematics import gear_rotation
from cycloid_mj.geometry.measured import measured_deviations
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.gaps import cam_displacements
from cycloid_mj.statics import kernel
from cycloid_mj.statics.kernel import (
    FIGURES,
    RESIDUAL_RTOL,
    Effects,
    SampleDeviations,
    allocate_workspace,
    solve_few_samples,
    solve_many_samples,
)
from cycloid_mj.statics.springs import Springs, springs_of
from cycloid_mj.statics.structure import wind_up

MAX_UNCOMPILED = 2
"""Largest number of samples for which the loop over them is not compiled, as that would take longer."""


@dataclass(frozen=True, eq=False)
class Samples:
    """Deviations of s samples of a design [m]; pins (or lobes) and holes are numbered as in ``deviations``.

    Attributes
    ----------
    pin_displacement, pin_radius
        Position errors of ring pins (or lobes), shape (s, N, 2), and radius errors, shape (s, N).
    hole_displacement
        Position errors of the holes in each disc, shape (s, D, output pins, 2).
    disc_radius
        Offset of the flanks of each disc, positive outwards, shape (s, D).
    cam_displacement
        Position errors of the cams on the crank, at crank angle 0, shape (s, D, 2).
    eccentricity
        Error of the eccentricity of all cams, shape (s,).
    waves
        Waviness of the disc's profile, shape (s, N, 2), or of more orders if it is measured.
    mesh, seat, cam, output
        Clearances, shape (s,): between disc and ring, of pins or sleeves in their seats (0 if fixed), of the cam and of
        the output pins.
    equidistant, pin_circle, rotation
        Modification of the disc, shape (s,); `rotation` in [rad].
    """

    pin_displacement: Array
    pin_radius: Array
    hole_displacement: Array
    disc_radius: Array
    cam_displacement: Array
    eccentricity: Array
    waves: Array
    mesh: Array
    seat: Array
    cam: Array
    output: Array
    equidistant: Array
    pin_circle: Array
    rotation: Array

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self.cam)


def identical_samples(reducer: Reducer, count: int) -> Samples:
    """Return the manufacturing deviations of `count` identical drives, all with the errors of the design.

    They are read-only arrays; use `dataclasses.replace` to change them. They are an input of `solve_samples`.
    """
    design = reducer.design
    errors, clearance, modification = reducer.deviations, design.clearance, design.modification
    values = {
        **{field.name: getattr(errors, field.name) for field in fields(errors)},
        **{name: getattr(modification, name) for name in ("equidistant", "pin_circle", "rotation")},
        "mesh": getattr(clearance, design.tooth_pair),
        "seat": design.pin_play,
        "cam": clearance.cam,
        "output": clearance.output,
    }
    return Samples(**{name: np.broadcast_to(value, (count, *np.shape(value))) for name, value in values.items()})


@dataclass(frozen=True, eq=False)
class SampleFigures:
    """Figures of s samples under a torque, over the crank angles of a turn; arrays of shape (s,).

    Attributes
    ----------
    gear_mean, gear_range, output_mean, output_range
        Mean and peak-to-peak deviation of disc and output from their ideal angles [rad], in the frame of the ring.
    tooth, output_pin, cam
        Largest forces [N].
    carrying
        Mean number of teeth with at least 1 % of the largest force.
    tooth_pressure
        Largest Hertz pressure of a tooth [Pa].

    All figures of a sample without equilibrium are NaN.
    """

    gear_mean: Array
    gear_range: Array
    output_mean: Array
    output_range: Array
    tooth: Array
    output_pin: Array
    cam: Array
    carrying: Array
    tooth_pressure: Array


def solve_samples(
    reducer: Reducer,
    samples: Samples,
    torques: Sequence[float],
    angles: int = 360,
    threads: int = 1,
    friction: bool = False,
) -> list[SampleFigures]:
    """Solve for static equilibrium of every sample of a tolerance study under each output torque, over a turn.

    A sample is a drive with its own manufacturing deviations. The result is the same to the last bit for any number of
    threads. All samples have the spring stiffnesses of the design.

    Parameters
    ----------
    reducer
        The nominal reducer; its errors and modification are ignored, and its clearances are replaced by those of the
        samples.
    samples
        Deviations of the samples.
    torques
        Output torques [N m], not 0. A positive torque brakes a crank that rotates counter-clockwise, as in
        `Member.sense`. For `backlash`, include a small torque and its negative.
    angles
        Number of crank angles, evenly over a turn in the frame of the ring.
    threads
        Number of threads.
    friction
        Whether the crank rotates at the design's speed, with the friction of all contacts.

    Returns
    -------
    list of SampleFigures
        Quantities under each torque; NaN for samples without equilibrium, for example because errors jam the parts.
    """
    without_errors = {"errors": Errors(), "measured": Measured(), "modification": Modification()}
    ideal_reducer = Reducer(reducer.design.model_copy(update=without_errors))
    springs = springs_of(ideal_reducer, np.linspace(0.0, reducer.mesh_turn, angles, endpoint=False), friction)
    common_profile = measured_deviations(reducer.design).waves
    own_waves = np.array(samples.waves)
    own_waves[:, : len(common_profile)] -= common_profile
    individual_samples = replace(samples, waves=own_waves)
    sample_figures = _solve_all_samples(
        ideal_reducer, springs, individual_samples, common_profile, reducer.share * np.array(torques), threads
    )
    sample_figures[~(sample_figures[..., -1] <= RESIDUAL_RTOL)] = np.nan
    return [
        _convert_figures(ideal_reducer, springs, torque, torque_rows)
        for torque, torque_rows in zip(torques, sample_figures, strict=True)
    ]


def _convert_figures(reducer: Reducer, springs: Springs, torque: float, rows: Array) -> SampleFigures:
    """Convert results of the kernel under a torque on the output [N m], shape (s, `FIGURES`), to those of s samples.

    The output is that of the reducer, with the torsion of the structure, instead of the carrier. `springs` are those of
    the `reducer` without errors.
    """
    figures = SampleFigures(*rows[:, :-1].T.copy())  # for the pressure, the kernel has force times curvature
    unit_pressure = reducer.contacts[reducer.design.tooth_pair].pressure(1.0, 1.0)
    return replace(
        figures,
        output_mean=reducer.share * figures.output_mean + wind_up(reducer) * torque,
        output_range=reducer.share * figures.output_range,
        cam=figures.cam / springs.cam_normal_share,  # with the friction force of a plain cam, as in `Loads`
        tooth_pressure=unit_pressure * np.sqrt(figures.tooth_pressure),
    )


def _solve_all_samples(
    ideal_reducer: Reducer, springs: Springs, samples: Samples, common_waves: Array, torques: Array, threads: int
) -> Array:
    """Solve for the equilibria of all samples by the compiled kernel.

    Parameters
    ----------
    ideal_reducer, springs
        The reducer without errors, and its contact springs at k crank angles.
    samples
        Deviations of the samples; their waves are added to `common_waves`.
    common_waves
        Cosine and sine amplitudes of the profile error that all samples have, shape (orders, 2) [m].
    torques
        Torques on the carrier [N m].
    threads
        Number of threads, which solve chunks of samples in parallel.

    Returns
    -------
    Array
        Shape (torques, samples, `FIGURES`): the fields of `SampleFigures`, with the carrier as output and without
        torsion of the structure; then the relative residual.
    """
    orders = np.flatnonzero(np.any(samples.waves != 0.0, axis=(0, 2))) + 1
    effects = _error_effects(ideal_reducer, springs, orders, common_waves)
    deviations = _sample_deviations(ideal_reducer, springs, samples, orders)
    load = np.array([springs.load(torque) for torque in torques])
    sample_figures = np.zeros((len(torques), len(samples), FIGURES))
    # samples take different times, and a job can be stopped between chunks
    chunk_ends = np.linspace(0, len(samples), min(8 * threads, len(samples)) + 1).astype(int).tolist()

    def solve_chunk(first_sample: int, end_sample: int) -> None:
        """Solve the equilibria of samples `first_sample` to `end_sample` - 1; repeat failures with continuation."""
        inputs = springs.contacts, effects, deviations, load
        workspace = allocate_workspace(springs.contacts)
        solve_kernel = solve_few_samples if len(samples) <= MAX_UNCOMPILED else solve_many_samples
        solve_kernel(*inputs, first_sample, end_sample, sample_figures, None, workspace)
        has_equilibrium = (sample_figures[:, first_sample:end_sample, -1] <= RESIDUAL_RTOL).all(axis=0)
        for sample in (first_sample + np.flatnonzero(~has_equilibrium)).tolist():
            solve_few_samples(*inputs, sample, sample + 1, sample_figures, True, workspace)

    if threads == 1:
        for chunk_start, chunk_end in pairwise(chunk_ends):
            check_interrupt()
            with announce_compilation():
                solve_chunk(chunk_start, chunk_end)
    else:
        with announce_compilation(), ThreadPoolExecutor(threads) as pool:
            list(pool.map(solve_chunk, chunk_ends[:-1], chunk_ends[1:]))
    return sample_figures


def backlash(counter_clockwise: SampleFigures, clockwise: SampleFigures) -> Array:
    """Compute the mean backlash of samples [rad], shape (s,), from a small torque and its opposite."""
    return counter_clockwise.output_mean - clockwise.output_mean


def _error_effects(reducer: Reducer, springs: Springs, orders: Integers, common_waves: Array) -> Effects:
    """Compute the derivatives of the gaps and cam positions of ideal parts by manufacturing errors.

    A pin that is displaced opens its gap like a disc that is displaced in the opposite direction, so the derivatives
    follow from the gradients of the springs.

    Parameters
    ----------
    reducer, springs
        The reducer without errors, and its contact springs at k crank angles.
    orders
        Orders of the profile waves that differ between samples; each has an effect for cosine and one for sine.
    common_waves
        Amplitudes of the waves that all samples have (orders, 2) [m]; together they have one effect [m].

    Returns
    -------
    Effects
        Six arrays, with k crank angles and n contacts, first those of the teeth, then those of the output pins.
        `distance` and `shift` (k, n, 4) are the derivatives of the gaps along the normals, and of the displacements
        along the tangents, by position of pin or hole in x and in y [1], pin circle [1] and flank rotation [m/rad].
        `cam_position` (k, D, 2) [1] is the derivative of the D cams' positions by the eccentricity. `turned` (k, 2) has
        cosine and sine of the crank angle. `waves` (k, n, 1 + 2 orders) has in its first column the change of the gaps
        by `common_waves` [m], and in the others the derivative of the gaps by each cosine and each sine amplitude [1].
        `curvature` (k, teeth) [1/m] is the relative curvature of the teeth.
    """
    contacts, teeth, gear, discs = springs.contacts, springs.teeth, reducer.tooth_profile, reducer.design.gear.discs
    disc_rotation = gear_rotation(gear, springs.crank)
    disc_axes = (
        np.stack([np.cos(disc_rotation), np.sin(disc_rotation)], axis=-1),
        np.stack([-np.sin(disc_rotation), np.cos(disc_rotation)], axis=-1),
    )
    outward_direction = np.tile(profile.unit(profile.pin_angles(gear)), (discs * reducer.design.ring.halves, 1))
    rotation_sign = np.sign(_own_disc_gradients(contacts, contacts.slope)[:, :teeth, 2])

    def contact_effects(all_gradients: Array) -> Array:
        """Compute the derivatives of distances or shifts of n contacts by four manufacturing errors, shape (k, n, 4).

        The errors are the position of the pin or hole in x and in y, the pin circle of the disc, and the rotation of
        its flanks. `all_gradients` (k, n, u) [1] are the gradients of the distances or shifts by all u unknowns at k
        crank angles.
        """
        gradients = _own_disc_gradients(contacts, all_gradients)
        effects = np.zeros((*gradients.shape[:2], 4))
        effects[:, :teeth, :2] = -gradients[:, :teeth, :2]
        for axis in (0, 1):
            effects[:, teeth:, axis] = np.einsum("kni,ki->kn", gradients[:, teeth:, :2], disc_axes[axis])
        effects[:, :teeth, 2] = np.einsum("kni,ni->kn", gradients[:, :teeth, :2], outward_direction)
        effects[:, :teeth, 3] = gradients[:, :teeth, 2] * rotation_sign * contacts.radius
        return effects

    unit_reducer = reducer.but(errors={"eccentricity": 1e-6})
    return Effects(
        contact_effects(contacts.slope),
        contact_effects(contacts.shift_slope),
        cam_displacements(unit_reducer, springs.crank) / 1e-6,
        np.stack([np.cos(springs.crank), np.sin(springs.crank)], axis=-1),
        _wave_effects(reducer, springs, orders, common_waves),
        springs.curvature,
    )


def _wave_effects(reducer: Reducer, springs: Springs, orders: Integers, common_waves: Array) -> Array:
    """Compute the changes of the gaps of n contacts at k crank angles by waves of the profile, shape (k, n, 1 + 2 w).

    The first column is the change by `common_waves` [m], amplitudes that all samples have; the others are the
    derivatives by the amplitude of the cosine, then of the sine, of each of the w `orders` [1]. `springs` are the
    contact springs at k crank angles. Gaps of output pins do not change.
    """
    phase, tooth_count = springs.contacts.phase, springs.teeth
    profile_angle = phase[:, :tooth_count, np.newaxis] / reducer.tooth_profile.lobes
    waves = np.zeros((*phase.shape, 1 + 2 * orders.size))
    waves[:, :tooth_count] = np.concatenate(
        [profile_error(common_waves, profile_angle), np.cos(profile_angle * orders), np.sin(profile_angle * orders)],
        axis=2,
    )
    return waves


def _own_disc_gradients(contacts: kernel.KernelSprings, slopes: Array) -> Array:
    """Select the gradients by x, y and rotation of each contact's own disc, (k, n, 3), from `slopes` (k, n, u)."""
    return np.stack([slopes[:, np.arange(contacts.disc.size), 3 * contacts.disc + axis] for axis in range(3)], axis=-1)


def _sample_deviations(reducer: Reducer, springs: Springs, samples: Samples, orders: Integers) -> SampleDeviations:
    """Convert the deviations of the parts of each sample drive to deviations of each contact, for the compiled kernel.

    Parameters
    ----------
    reducer, springs
        The reducer, and its contact springs with the clearances of the design.
    samples
        Deviations of the samples.
    orders
        Orders of the w profile waves that differ between samples, shape (w,).
    """
    design = reducer.design
    discs, sample_count = design.gear.discs, len(samples)
    clearance_change = samples.mesh - getattr(design.clearance, design.tooth_pair) + samples.seat - design.pin_play
    pin_errors = (2.0 if design.ring.has_sockets else 1.0) * samples.pin_radius
    # both halves of a ring have the same errors
    halves = design.ring.halves
    tooth_clearance = np.tile((clearance_change + samples.equidistant)[:, np.newaxis] - pin_errors, (1, halves))
    tooth_clearances = (tooth_clearance[:, np.newaxis] - samples.disc_radius[..., np.newaxis]).reshape(sample_count, -1)
    hole_displacements = samples.hole_displacement.reshape(sample_count, -1, 2)
    pin_clearances = np.broadcast_to(
        (samples.output - design.clearance.output)[:, np.newaxis], hole_displacements.shape[:2]
    )
    deviations = {
        "clearance": springs.contacts.clearance + np.concatenate([tooth_clearances, pin_clearances], axis=1),
        "displacement": np.concatenate(
            [np.tile(samples.pin_displacement, (1, discs * halves, 1)), hole_displacements], axis=1
        ),
        "waves": np.concatenate([np.ones((sample_count, 1)), *np.moveaxis(samples.waves[:, orders - 1], 2, 0)], axis=1),
    } | {name: getattr(samples, name) for name in SampleDeviations._fields[3:]}
    # numba compiles everything again for each memory layout, and for read-only arrays
    return SampleDeviations(**{name: np.array(values, order="C") for name, values in deviations.items()})
