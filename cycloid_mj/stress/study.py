"""Stress study of a run: stress of each part along a crank turn, its maximum, and its convergence with the grid."""

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.base.frame import Cell, Frame, make_frame
from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.base.record import Run
from cycloid_mj.base.units import MEGAPASCAL
from cycloid_mj.design import Design, override
from cycloid_mj.design.materials import SHAKEDOWN_PRESSURE
from cycloid_mj.parts.crank import shaft_dimensions
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.stress.bulk import DISTANCES_PER_OCTAVE, find_plateau, relative_drop
from cycloid_mj.stress.closed import LineStress, line_stress
from cycloid_mj.stress.field import (
    PartStress,
    StressMap,
    assemble_part,
    evaluate_map,
    solve,
    solve_maxima,
    vary_corner_distance,
)
from cycloid_mj.stress.findings import PartFindings, Peak, Reference, Refinement, StressFindings
from cycloid_mj.stress.grid import BULK_DISTANCE, Grid, GridSettings
from cycloid_mj.stress.loads import PartLoads, loads_in_turn, part_names, require_part, turn_of
from cycloid_mj.stress.notch import Notch, output_roots, shaft_shoulders
from cycloid_mj.stress.part import part_grid
from cycloid_mj.stress.region import material_of
from cycloid_mj.stress.stress_range import RANGE_PARTS, StressRange, critical_stress_range, sample_angles
from cycloid_mj.stress.turn import Turn

if TYPE_CHECKING:
    from cycloid_mj.stress.rv_strength import RvStrength

OnProgress = Callable[[str, int, int], None]

EXTRA_REFINEMENT = {"pin_1": 3.0}
"""Additional refinement of small parts, which cost little."""

SENSITIVITY = {0.5: 0, 2.0: 2 * DISTANCES_PER_OCTAVE}
"""Multiples of the start distance of the search for the bulk -> index of the search distance."""

SUPPORTS = {"shaft": ("shaft.mounting", ("overhang", "straddle")), "ring": ("housing.support", ("bolts", "rim"))}
"""Keys of the design for the support of a part, and their choices: the stress with the others is reported as well."""

ALWAYS_SOLID = ("shaft", "output")
"""Parts without a planar model: the output's pins are cantilevers on its disc."""


@dataclass(frozen=True)
class StudySettings:
    """Settings of a study: angles, grids and maps.

    Attributes
    ----------
    angles
        Number of crank angles in the turn.
    refinement
        Refinement of the grids; see `GridSettings`.
    step
        Refinement factor of the convergence study.
    checked
        Number of crank angles of the convergence study, that of the maximum first; no divisor of the mesh periods in a
        turn, so that they have many phases of the mesh.
    bulk_distance
        Distance from narrow patches at which the search for the bulk begins, as a share of the ring's pin radius.
    solid
        Whether disc, ring and pin 1 are solid bodies as well; shaft and output always are.
    map_angle
        Crank angle of the maps [rad], among those of the turn; None: that of the largest bulk stress of each part.
    """

    angles: int = 360
    refinement: float = 1.0
    step: float = 1.5
    checked: int = 23
    bulk_distance: float = BULK_DISTANCE
    solid: bool = False
    map_angle: float | None = None

    @property
    def turn(self) -> Array:
        """Crank angles in the turn [rad], including that of the maps or zero, shape (angles,)."""
        step = 2.0 * math.pi / self.angles
        steps = (self.map_angle or 0.0) / step
        first_angle = step * (steps - math.floor(steps + 1e-9))
        return first_angle + step * np.arange(self.angles, dtype=np.float64)

    def grid(self, part: str, factor: float = 1.0) -> GridSettings:
        """Return the settings of a part's grid, refined by a factor on top."""
        return GridSettings(
            refinement=self.refinement * factor * EXTRA_REFINEMENT.get(part, 1.0),
            bulk_distance=self.bulk_distance,
            solid=self.solid or part in ALWAYS_SOLID,
        )

    def finer(self, grid: Grid) -> float:
        """Return the refinement factor of the convergence study of a part."""
        return self.step if grid.section is None else min(self.step, 1.25)  # solids have more unknowns


QUICK = StudySettings(angles=36, refinement=0.5, checked=5)
"""Settings of a quick study: fewer crank angles and coarser grids."""


@dataclass(frozen=True, eq=False)
class PartStudy:
    """Study of a part: its grid, loads, stress by finite elements, map and findings."""

    grid: Grid
    loads: PartLoads
    stress: PartStress
    map: StressMap
    findings: PartFindings


@dataclass(frozen=True, eq=False, repr=False)
class StressStudy(Presented):
    """All parts of one design, and the findings about them."""

    design: Design
    parts: tuple[PartStudy, ...]
    findings: StressFindings

    @property
    def frame(self) -> Frame:
        """Return a table with a row per part: stresses [MPa], largest contact force [N] and yield strength [MPa].

        The stresses are the largest away from contacts and the largest below a contact.
        """
        rows: list[dict[str, Cell]] = [
            {
                "part": findings.part,
                "bulk_mpa": findings.bulk_peak.stress / MEGAPASCAL,
                "contact_mpa": findings.contact_peak.stress / MEGAPASCAL,
                "largest_force_n": findings.largest_force,
                "yield_strength_mpa": findings.yield_strength / MEGAPASCAL,
            }
            for findings in self.findings.parts
        ]
        units = {"bulk_mpa": "MPa", "contact_mpa": "MPa", "largest_force_n": "N", "yield_strength_mpa": "MPa"}
        return make_frame(rows, ("part", *units), units)

    @property
    def line(self) -> str:
        """Design, load, and the largest stress of each part away from its contacts."""
        stresses = ", ".join(f"{item.part} {item.bulk_peak.stress / MEGAPASCAL:.4g}" for item in self.findings.parts)
        return f"{self.design.name}, {self.findings.load:.4g} N m; away from contacts, MPa: {stresses}"

    def __getitem__(self, part: str) -> PartStudy:
        """Return the study of a part."""
        return next(study for study in self.parts if study.findings.part == part)


def stress_study(
    run: Run | None,
    reducer: Reducer,
    parts: Sequence[str] = (),
    settings: StudySettings | None = None,
    log: str | None = None,
    on_part: OnProgress = lambda part, done, total: None,
    grids: Mapping[str, Grid] | None = None,
    references: Mapping[str, Reference] | None = None,
) -> StressStudy:
    """Compute the stress of each part over a crank turn by finite elements; return loads, stress maps and findings.

    Parameters
    ----------
    run, reducer
        The run, whose logged forces act on the parts, and the reducer that ran. For an RV reducer, which has no run
        (None), forces follow from the static equilibrium.
    parts
        Names of parts; by default every part of the design.
    settings
        Settings; by default the settings of a full study.
    log
        Name of the run's log file, for the texts of the result.
    on_part
        Called before each part with its name, the number of finished parts, and the number of all parts.
    grids, references
        Existing finite-element grids (from `study_grids`) and published stresses, by the names of their parts.

    Raises
    ------
    UsageError
        The design has no such part, or is not the design that ran.
    LogError
        The run contains no design or no forces, or too few samples at constant speed and load.
    CycloidError
        A part does not mesh, its support is singular, or a package of the extra ``fem`` is missing.
    """
    design = reducer.design
    settings = settings or StudySettings()
    names = tuple(dict.fromkeys(parts)) or part_names(reducer)
    for part in names:
        require_part(reducer, part)
    start_time, part_studies, turn = time.perf_counter(), [], turn_of(run, reducer, settings.turn)
    for index, part in enumerate(in_order(names)):
        on_part(part, index, len(names))
        part_studies.append(part_study(turn, reducer, part, settings, (grids or {}).get(part)))
    part_order = part_names(reducer)
    studies = tuple(sorted(part_studies, key=lambda study: part_order.index(study.findings.part)))
    findings = StressFindings(
        design=design.name,
        ring=design.ring.kind,
        load=float(turn["load_torque"][-1]),
        log=log,
        yield_strength=design.material.yield_strength,
        parts=tuple(study.findings for study in studies),
        wall=time.perf_counter() - start_time,
        references=references or {},
        strength=_strength_of(reducer, settings),
    )
    return StressStudy(design, studies, findings)


def _strength_of(reducer: Reducer, settings: StudySettings) -> "RvStrength | None":
    """Return the stress of cranks and gears of an RV reducer; None for other reducers."""
    if not isinstance(reducer, RvReducer):
        return None
    from cycloid_mj.stress.rv_strength import compute_rv_strength

    return compute_rv_strength(reducer, settings.turn)


def study_grids(reducer: Reducer, parts: Sequence[str], settings: StudySettings) -> dict[str, Grid]:
    """Mesh the parts of a study, in the order in which it takes them."""
    return {part: part_grid(reducer.design, part, settings.grid(part)) for part in in_order(parts)}


def in_order(parts: Sequence[str]) -> list[str]:
    """Sort parts into the order in which they are studied: the output first, whose grids need the most memory."""
    return sorted(parts, key=lambda part: part != "output")


def part_study(turn: Turn, reducer: Reducer, part: str, settings: StudySettings, grid: Grid | None = None) -> PartStudy:
    """Compute the stress of one part over a turn by finite elements; return mesh, loads, maxima, map and results.

    `turn` has positions and contact forces over a crank turn. If `grid` is None, the part is meshed with the
    `settings`.

    Raises
    ------
    UsageError
        The design has no such part.
    CycloidError
        The part does not mesh, its support is singular, or a package of the extra ``fem`` is missing.
    """
    start_time = time.perf_counter()
    loads = loads_in_turn(turn, part)
    grid = grid or part_grid(reducer.design, part, settings.grid(part))
    (stress, stress_map, stress_range, corner_stresses), contact_lines = (
        _solve_part(reducer, grid, loads, settings.map_angle),
        line_stress(loads, reducer),
    )
    material = material_of(reducer, part)
    pressure = float(_largest(contact_lines.peak_pressure.reshape(1, -1))[0])
    bulk_index = int(np.argmin(np.abs(stress.distances - stress.bulk_distance)))
    plateau_drop = relative_drop(stress.stress_by_distance.max(axis=1), bulk_index)
    findings = PartFindings(
        part=part,
        unknowns=grid.unknowns,
        dimension=grid.dimension,
        teeth=reducer.design.ring.teeth,
        angle=loads.angle,
        bulk=stress.bulk_stress,
        bulk_peak=_bulk_peak(loads, stress, reducer),
        bulk_distance=stress.bulk_distance,
        sensitivity=_sensitivity(stress, grid),
        choice=max(plateau_drop, corner_distance_change(corner_stresses)),
        by_distance=(stress.distances, stress.stress_by_distance.max(axis=1)),
        contact=_largest(contact_lines.von_mises),
        contact_peak=_contact_peak(loads, contact_lines, reducer),
        largest_pressure=pressure,
        shakedown=SHAKEDOWN_PRESSURE * _safety(pressure, material.surface_strength),
        largest_force=float(np.linalg.norm(loads.force, axis=-1).max()),
        near_field=_near_field(loads, reducer, stress.bulk_distance),
        imbalance=_imbalance(stress, grid),
        notches=notches_of(reducer, loads, stress),
        stress_range=stress_range,
        variants=_stress_with_other_supports(reducer, part, settings, loads, stress),
        yield_strength=material.yield_strength,
        refinement=_compare_with_finer_grid(reducer, grid, settings, loads, stress),
        wall=time.perf_counter() - start_time,
        by_corner=corner_stresses,
    )
    return PartStudy(grid, loads, stress, stress_map, findings)


def _solve_part(
    reducer: Reducer, grid: Grid, loads: PartLoads, map_angle: float | None
) -> tuple[PartStress, StressMap, StressRange | None, tuple[tuple[float, float], ...]]:
    """Solve a part at all crank angles; return largest stresses, map, stress range, and effect of corner distance.

    `grid` is the finite-element mesh of the part, `loads` are the loads on it. `map_angle` is the crank angle of the
    map [rad]; None: the angle of the largest bulk stress. The stress range is None for parts other than `RANGE_PARTS`.
    The last result has pairs of the distance from sharp corners [m] and the largest bulk stress beyond it [Pa], at the
    crank angle of the largest bulk stress; it is empty for parts without corners.
    """
    part = assemble_part(reducer, grid, loads)
    has_range = names.family(grid.part) in RANGE_PARTS
    states = dict.fromkeys(sample_angles(len(loads.angle)).tolist() if has_range else (), np.zeros(0))

    def store_state(index: int, state: Array) -> None:
        if index in states:
            states[index] = state.copy()

    stress = solve_maxima(part, on_state=store_state)
    angle = loads.angle[stress.bulk_stress.argmax()] if map_angle is None else map_angle
    map_index = int(np.argmax(np.cos(loads.angle - angle)))
    stress_range = critical_stress_range(part, states, stress.bulk_distance) if has_range else None
    corner_stresses = vary_corner_distance(part, int(stress.bulk_stress.argmax()), stress.bulk_distance)
    return stress, evaluate_map(part, map_index, stress.bulk_distance), stress_range, corner_stresses


def select_angles(loads: PartLoads, indices: npt.ArrayLike) -> PartLoads:
    """Return the loads of a part at only the crank angles with the `indices`, in their order."""
    index_array = np.asarray(indices)
    angle_count = len(loads.angle)
    selected_fields: dict[str, Any] = {
        field.name: getattr(loads, field.name)[index_array]
        for field in fields(loads)
        if isinstance(getattr(loads, field.name), np.ndarray) and len(getattr(loads, field.name)) == angle_count
    }
    return replace(loads, **selected_fields)


def _compare_with_finer_grid(
    reducer: Reducer, grid: Grid, settings: StudySettings, loads: PartLoads, stress: PartStress
) -> Refinement:
    """Solve some crank angles on a finer mesh, too; return the bulk stresses [Pa] of both meshes.

    There are `settings.checked` angles. Bulk stress is the largest stress beyond a distance from contacts and sharp
    corners. `stress` is the solution under `loads` on the mesh `grid`; its largest bulk stress occurs at the first of
    the angles.
    """
    angle_indices = _checked_rows(stress.bulk_stress, settings.checked)
    finer_grid = part_grid(reducer.design, grid.part, settings.grid(grid.part, settings.finer(grid)))
    finer_stress = solve(reducer.design, finer_grid, select_angles(loads, angle_indices), distance=stress.bulk_distance)
    return Refinement(
        unknowns=(stress.unknowns, finer_stress.unknowns),
        angle=loads.angle[angle_indices],
        stress=np.stack([stress.bulk_stress[angle_indices], finer_stress.bulk_stress]),
    )


def _checked_rows(stress: Array, count: int) -> npt.NDArray[np.intp]:
    """Return `count` indices of crank angles at equal distances around the turn, that of the largest stress first."""
    steps = np.arange(min(count, stress.size)) * stress.size // max(min(count, stress.size), 1)
    return (int(np.argmax(stress)) + steps) % stress.size


def notches_of(reducer: Reducer, loads: PartLoads, stress: PartStress) -> tuple[Notch, ...]:
    """Compute the stress at the fillets of a part, nominal times notch factor, under the loads it was solved for."""
    if stress.part == "shaft":
        return shaft_shoulders(reducer, shaft_dimensions(reducer), stress.moments, loads.angle)
    return output_roots(reducer, loads) if stress.part == "output" else ()


def _stress_with_other_supports(
    reducer: Reducer, part: str, settings: StudySettings, loads: PartLoads, stress: PartStress
) -> tuple[tuple[str, float], ...]:
    """Compute the bulk stress [Pa] of a part with other supports than the design's, such as a clamped rim.

    `settings` determine the finite-element mesh, `loads` are those on the part. Returns pairs of the support as text,
    "key = value", and the stress; none for parts without a choice of supports (`SUPPORTS`). The stress is the largest
    at five crank angles; the first of them is the angle at which the bulk stress in `stress` is largest.
    """
    if part not in SUPPORTS:
        return ()
    key, choices = SUPPORTS[part]
    table, name = key.split(".")
    checked_loads = select_angles(loads, _checked_rows(stress.bulk_stress, 5))
    variants = []
    for choice in choices:
        if choice != getattr(getattr(reducer.design, table), name):
            changed_design = override(reducer.design, [f'{key}="{choice}"'])
            changed_stress = solve(changed_design, part_grid(changed_design, part, settings.grid(part)), checked_loads)
            variants.append((f"{key} = {choice}", float(changed_stress.bulk_stress.max())))
    return tuple(variants)


def _bulk_peak(loads: PartLoads, stress: PartStress, reducer: Reducer) -> Peak:
    """Return the largest stress [Pa] away from contacts over the turn, with crank angle, position and safety factor.

    `stress` is the solution for a part under `loads`.
    """
    angle_index = int(np.argmax(stress.bulk_stress))
    largest_stress = float(stress.bulk_stress[angle_index])
    return Peak(
        largest_stress,
        float(loads.angle[angle_index]),
        stress.bulk_place[angle_index],
        "",
        _safety(largest_stress, material_of(reducer, loads.part).yield_strength),
    )


def _sensitivity(stress: PartStress, grid: Grid) -> tuple[tuple[float, float], ...]:
    """Return pairs of start distance [m] of the search for the bulk, and the bulk stress [Pa] that it finds."""
    sizes = stress.stress_by_distance.max(axis=1)
    return tuple(
        (factor * grid.bulk_distance, float(sizes[find_plateau(sizes, index)])) for factor, index in SENSITIVITY.items()
    )


def corner_distance_change(corners: Sequence[tuple[float, float]]) -> float:
    """Compute how much the bulk stress depends on the distance from sharp corners within which stress is ignored.

    The result is the larger relative change [1] of the bulk stress, the largest stress away from contacts and corners,
    if this distance is halved or doubled; 0 for a part without corners. `corners` are pairs of distance [m] and bulk
    stress [Pa], from `field.vary_corner_distance`.
    """
    stresses = [stress for _, stress in corners]
    base_stress = stresses[len(stresses) // 2] if stresses else 0.0
    return max(abs(stress / base_stress - 1.0) for stress in stresses) if base_stress > 0.0 else 0.0


def _largest(values: Array) -> Array:
    """Compute the largest number in each row of an array (k, m); NaN for rows of NaN only."""
    row_maxima = np.max(values, axis=1, initial=-np.inf, where=~np.isnan(values))
    return np.where(np.isfinite(row_maxima), row_maxima, np.nan)


def _contact_peak(loads: PartLoads, lines: LineStress, reducer: Reducer) -> Peak:
    """Return the largest von Mises stress [Pa] below a contact over the turn, with angle, position and safety factor.

    `lines` are the stresses of the contacts under `loads`. The stress is NaN if all contacts are conformal.
    """
    stresses = np.where(np.isnan(lines.von_mises), -1.0, lines.von_mises)
    angle_index, contact = np.unravel_index(int(np.argmax(stresses)), stresses.shape)
    largest_stress = float(lines.von_mises[angle_index, contact])
    position = loads.position[angle_index, contact]
    return Peak(
        largest_stress,
        float(loads.angle[angle_index]),
        position,
        loads.labels[contact],
        _safety(largest_stress, material_of(reducer, loads.part).yield_strength),
    )


def _imbalance(stress: PartStress, grid: Grid) -> float:
    """Compute the larger imbalance [1]: of forces over the largest force, or of moments over its moment at the rim."""
    forces, moments = stress.imbalance[:, : grid.dimension], stress.imbalance[:, grid.dimension :]
    reach = float(np.linalg.norm(grid.points[:, :2], axis=1).max())
    largest_load = max(float(np.abs(forces).max()), float(np.abs(moments).max()) / reach)
    return largest_load / max(float(stress.load.max()), np.finfo(float).tiny)


def _near_field(loads: PartLoads, reducer: Reducer, distance: float) -> float:
    """Compute Flamant's stress 2 F/(pi L d) [Pa] of a line force F at a `distance` d [m] from it.

    F is the largest force on a patch narrower than d, and L the face width of the disc. d is the distance from which
    stress counts as bulk stress.
    """
    is_narrow = loads.half_width < distance / 2.0
    force = np.where(is_narrow, np.linalg.norm(loads.force, axis=-1), 0.0).max()
    return float(2.0 * force / (np.pi * reducer.design.gear.face_width * distance))


def _safety(stress: float, strength: float) -> float:
    return strength / stress if stress != 0.0 else float("inf")
