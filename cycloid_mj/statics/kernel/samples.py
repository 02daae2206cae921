"""Equilibria of many samples of a tolerance study in a call."""

import math
from typing import NamedTuple

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.compiling import cacheable, njit
from cycloid_mj.statics.kernel.contacts import FIRST, TRUE, KernelSprings
from cycloid_mj.statics.kernel.search import solve_equilibria_briefly, solve_equilibria_with_paths
from cycloid_mj.statics.kernel.system import System, allocate_system, cam_contact

CARRYING_SHARE = 0.01
"""Smallest force of a loaded tooth, relative to the largest over the turn (heuristic)."""


FIGURES = 10
"""Figures of a sample: mean and range of the rotations of disc and output; largest force of a tooth, an output pin and
the cam; mean number of loaded teeth; largest product of force and curvature of a tooth; residual."""


class Effects(NamedTuple):
    """Derivatives of the gaps and cam positions of ideal parts by the errors of the parts, at k crank angles.

    `distance` and `shift`, shape (k, n, 4), are those of the attributes of ``kernel.KernelSprings``, by four errors:
    the position of the contact's pin or hole in x and in y [1], the disc's pin circle [1], and the rotation of its
    flanks [m/rad]. `cam_position` (k, D, 2) [1] is the displacement of the cams per error of the eccentricity, and
    `turned` (k, 2) are cosine and sine of the crank angle. `waves` (k, n, w) is the effect of the profile's waves on
    `distance`: in the first column that of the waves of all samples together [m], then that of each amplitude [1].
    `curvature` (k, teeth) [1/m] is the relative curvature of the teeth, which come first among the contacts.
    """

    distance: Array
    shift: Array
    cam_position: Array
    turned: Array
    waves: Array
    curvature: Array


class SampleDeviations(NamedTuple):
    """Manufacturing errors of s samples, by contact (n), disc (D) and order of the profile waves (w).

    `clearance` (s, n) and `displacement` (s, n, 2) [m] are those of each contact, `cam_displacement` (s, D, 2) [m]
    those of the cams on the crank. `waves` (s, w) [m] are those of the profile, after a 1 for the waves of all samples.
    The others have shape (s,): `pin_circle` [m], `rotation` [rad], `eccentricity` [m], and clearance of the `cam` [m].
    """

    clearance: Array
    displacement: Array
    waves: Array
    cam_displacement: Array
    pin_circle: Array
    rotation: Array
    eccentricity: Array
    cam: Array


class SampleWorkspace(NamedTuple):
    """Workspace of a sample: arrays of `KernelSprings`, displacements `z`, forces, and a system.

    The initial values `start` (k, u) [m] have the discs on their cams.
    """

    distance: Array
    shift: Array
    cam_position: Array
    start: Array
    z: Array
    force: Array
    system: System


def allocate_workspace(ideal: KernelSprings) -> SampleWorkspace:
    """Allocate the workspace for the samples of a tolerance study; `ideal` are contact springs of ideal parts."""
    shape, unknowns = ideal.distance.shape, ideal.slope.shape[2]
    cam_positions = np.empty(ideal.cam_position.shape)
    start_values, z = np.zeros((shape[0], unknowns)), np.empty((shape[0], unknowns))
    return SampleWorkspace(
        np.empty(shape), np.empty(shape), cam_positions, start_values, z, np.empty(shape), allocate_system(ideal)
    )


def solve_few_samples(
    ideal: KernelSprings,
    effects: Effects,
    deviations: SampleDeviations,
    load: Array,
    first_sample: int,
    end_sample: int,
    rows: Array,
    use_paths: bool | None,
    workspace: SampleWorkspace,
) -> None:
    """Solve for the equilibria of samples `first_sample` to `end_sample` - 1 under t loads, at k crank angles.

    A sample is a drive with random errors within its tolerances. It has u unknowns.

    Parameters
    ----------
    ideal
        Contact springs of the parts without errors.
    effects, deviations
        Effects of unit errors on the contacts, and errors of the samples.
    load
        Generalised loads (t, k, u) [N].
    rows
        Output array (t, all samples, ``FIGURES``): quantities of each sample as in `_write_sample_quantities`, then the
        relative residual, above ``RESIDUAL_RTOL`` if a crank angle has no equilibrium.
    use_paths
        True: where Newton's method fails, follow continuation paths (`search`). None: do not. Compiled code requires
        None; False is not allowed.
    workspace
        From `allocate_workspace`; overwritten.
    """
    z, force, system = workspace.z, workspace.force, workspace.system
    for sample in range(first_sample, end_sample):
        _fill_sample(
            effects, deviations, sample, workspace.distance, workspace.shift, workspace.cam_position, workspace.start
        )
        springs = KernelSprings(
            ideal.radius,
            ideal.disc,
            ideal.rotates,
            deviations.clearance[sample],
            workspace.distance,
            ideal.slope,
            workspace.shift,
            ideal.shift_slope,
            ideal.curvature,
            ideal.curvature_rate,
            ideal.phase,
            ideal.trochoid,
            ideal.stiffness,
            workspace.cam_position,
            deviations.cam[sample],
            ideal.cam_stiffness,
            ideal.friction_per_force,
            ideal.cam_friction_per_force,
            ideal.cam_lateral,
            ideal.bending,
            ideal.pins,
        )
        for t in range(len(load)):
            for k in range(z.shape[0]):
                for j in range(z.shape[1]):
                    z[k, j] = workspace.start[k, j]
            if use_paths is None:
                residual = solve_equilibria_briefly(springs, load[t], z, force, TRUE, FIRST, system)
            else:
                residual = solve_equilibria_with_paths(springs, load[t], z, force, TRUE, system)
            _write_sample_quantities(
                ideal.radius,
                effects.curvature,
                workspace.cam_position,
                deviations.cam[sample],
                ideal.cam_stiffness,
                z,
                force,
                rows[t, sample],
            )
            rows[t, sample, FIGURES - 1] = residual.force


solve_many_samples = njit(cache=cacheable(), allocates=False, nogil=True, error_model="numpy")(solve_few_samples)
"""`solve_few_samples` compiled for many samples."""


@njit(cache=cacheable(), allocates=False, nogil=True, error_model="numpy")
def _fill_sample(
    effects: Effects,
    deviations: SampleDeviations,
    sample: int,
    distance: Array,
    shift: Array,
    cam_position: Array,
    start_values: Array,
) -> None:
    """Write contact offsets, cam positions and start values of a tolerance sample: the summed effects of its errors.

    There are k crank angles, n contacts, D discs and u unknowns.

    Parameters
    ----------
    effects, deviations
        Effects of unit errors, and errors of all samples.
    sample
        Index of the sample.
    distance, shift
        Output arrays for the normal distance and the tangential shift of each contact (k, n) [m].
    cam_position
        Output array for the positions of the cams (k, D, 2) [m].
    start_values
        Output array for the initial displacements (k, u) [m]: x and y of each disc, which is centred on its cam.
    """
    circle, rotation = deviations.pin_circle[sample], deviations.rotation[sample]
    for k in range(distance.shape[0]):
        for i in range(distance.shape[1]):
            distance_change = shift_change = 0.0
            for j, error in enumerate(
                (deviations.displacement[sample, i, 0], deviations.displacement[sample, i, 1], circle, rotation)
            ):
                distance_change += effects.distance[k, i, j] * error
                shift_change += effects.shift[k, i, j] * error
            for j in range(deviations.waves.shape[1]):
                distance_change += effects.waves[k, i, j] * deviations.waves[sample, j]
            distance[k, i], shift[k, i] = distance_change, shift_change
        cosine, sine = effects.turned[k, 0], effects.turned[k, 1]
        for disc in range(cam_position.shape[1]):
            x, y = deviations.cam_displacement[sample, disc, 0], deviations.cam_displacement[sample, disc, 1]
            radial_x, radial_y = effects.cam_position[k, disc, 0], effects.cam_position[k, disc, 1]
            cam_position[k, disc, 0] = deviations.eccentricity[sample] * radial_x + (cosine * x - sine * y)
            cam_position[k, disc, 1] = deviations.eccentricity[sample] * radial_y + (sine * x + cosine * y)
            start_values[k, 3 * disc], start_values[k, 3 * disc + 1] = (
                cam_position[k, disc, 0],
                cam_position[k, disc, 1],
            )


@njit(cache=cacheable(), allocates=False, nogil=True, error_model="numpy")
def _write_sample_quantities(
    radius: float,
    curvature: Array,
    cam_position: Array,
    cam_clearance: float,
    cam_stiffness: float,
    z: Array,
    force: Array,
    row: Array,
) -> None:
    """Write the quantities of a tolerance sample to a `row`: means, ranges and maxima over its crank angles.

    Attributes of the springs are separate arguments, because the conversion of all springs from Python takes long to
    compile. There are k crank angles, n contacts, D discs and u unknowns.

    Parameters
    ----------
    radius, curvature
        Radius of the circle of output pins [m], and relative curvature of the teeth, the first contacts (k, teeth)
        [1/m].
    cam_position, cam_clearance, cam_stiffness
        Positions (k, D, 2) [m], clearance [m] and stiffness [N/m] of the cams.
    z
        Displacements at each crank angle, shape (k, u) [m].
    force
        Contact forces (k, n) [N].
    row
        Output array. 0, 1: mean and range, over the crank angles, of the average rotation of the discs [rad]. 2, 3:
        mean and range of the rotation of the output [rad]. 4 to 6: largest force on a tooth, an output pin and a cam
        [N]. 7: mean number of loaded teeth. 8: largest product of force and curvature of a tooth [N/m].
    """
    angles, disc_count = len(z), cam_position.shape[1]
    for is_output in range(2):
        rotation_sum, min_turn, max_turn = 0.0, math.inf, -math.inf
        for k in range(angles):
            rotation = z[k, 3 * disc_count] if is_output else 0.0
            for disc in range(0 if is_output else disc_count):
                rotation += z[k, 3 * disc + 2] / disc_count
            rotation_sum, min_turn, max_turn = rotation_sum + rotation, min(min_turn, rotation), max(max_turn, rotation)
        row[2 * is_output], row[2 * is_output + 1] = rotation_sum / angles / radius, (max_turn - min_turn) / radius
    teeth = curvature.shape[1]
    tooth_force = pin_force = cam_force = curved_force = 0.0
    for k in range(angles):
        for i in range(force.shape[1]):
            if i < teeth:
                tooth_force = max(tooth_force, force[k, i])
                curved_force = max(curved_force, force[k, i] * curvature[k, i])
            else:
                pin_force = max(pin_force, force[k, i])
        for disc in range(disc_count):
            x, y = z[k, 3 * disc] - cam_position[k, disc, 0], z[k, 3 * disc + 1] - cam_position[k, disc, 1]
            contact = cam_contact(x, y, cam_clearance)
            # with contact on both sides, the larger force: `depth` is the difference, `total_depth` the sum
            cam_force = max(cam_force, 0.5 * cam_stiffness * (contact.depth + contact.total_depth))
    loaded_teeth = 0
    for k in range(angles):
        for i in range(teeth):
            if force[k, i] > CARRYING_SHARE * tooth_force:
                loaded_teeth += 1
    row[4], row[5], row[6], row[7], row[8] = tooth_force, pin_force, cam_force, loaded_teeth / angles, curved_force
