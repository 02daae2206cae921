"""``cycloid-mj design kinematics``: the closed-form motion of a point of the gear as CSV."""

import math
from typing import Annotated

from cycloid_mj.base.errors import UsageError
from cycloid_mj.cli import flags
from cycloid_mj.cli.delivery import claim_page, deliver_columns
from cycloid_mj.cli.outfile import Columns, CsvFlag, claim_csv
from cycloid_mj.cli.ranges import RANGES
from cycloid_mj.design import Design

EXAMPLES = """Examples:
  cycloid-mj design kinematics --design pin --q 0,24 --csv q.csv
  cycloid-mj design kinematics --design pin --q 26,0 --until-s 0.1 --csv -
  cycloid-mj design kinematics --design twodisc --set output.member=ring --csv ring.csv"""

ROUNDING = 1e-6
"""Share of a step by which the last sample may lie beyond the end: T/DT is a rounded quotient."""

SPAN = "from {:g} to {:g}".format(*RANGES.time_s)

UntilFlag = Annotated[
    float | None,
    flags.number_flag(
        f"Time of the last sample [s], {SPAN}. Default: ramp and hold of the design.", RANGES.time_s, metavar="T"
    ),
]
StepFlag = Annotated[
    float | None,
    flags.number_flag(
        f"Time between samples [s], {SPAN}. Default: one degree of crank at full speed (0.000101626 s at 1640 rpm).",
        RANGES.time_s,
        metavar="DT",
    ),
]


def kinematics(
    design_options: Annotated[flags.DesignOptions, flags.FLAT],
    *,
    q: flags.PointFlag = None,
    csv: CsvFlag,
    ramp_s: Annotated[
        float | None, flags.RAMP.flag("Duration of the linear ramp from rest; 0: constant speed from the start")
    ] = None,
    until_s: UntilFlag = None,
    step_s: StepFlag = None,
    speed_rpm: Annotated[float | None, flags.SPEED.flag("Crank speed after the ramp")] = None,
    output_flags: Annotated[flags.CommonFlags, flags.FLAT] = flags.COMMON,
) -> int:
    """Write the ideal motion of a point q of the disc as CSV.

    Columns: t_s, crank_rad, x_mm, y_mm, vx_mm_s, vy_mm_s, ax_mm_s2, ay_mm_s2 (Hsieh 2014, Eqs 16, 17, 19, corrected;
    if the ring is the output, the disc does not turn). x points to the right, y up, and the crank turns
    counter-clockwise. The origin is that of Eq. 16, the initial centre of the disc: add the eccentricity to y_mm for
    positions from the axis of the reducer. Samples are at the times k DT, k = 0, 1, ..., up to T. Numbers are written
    with all digits.
    """
    design = design_options.resolve([(flags.RAMP, ramp_s), (flags.SPEED, speed_rpm)])
    columns = _compute_motion(design, flags.parse_point(q), until_s, step_s)
    claim_csv(csv, output_flags.force)
    page = claim_page(output_flags, f"{design.name}-kinematics")
    return deliver_columns(f"ideal motion: {design.name}", columns, csv, page, output_flags)


def _compute_motion(
    design: Design, q: tuple[float, float] | None, until: float | None, interval: float | None
) -> Columns:
    """Compute the motion of a point of the disc as columns of n samples in the units of their names.

    They are time [s], crank angle [rad], position [mm], velocity [mm/s] and acceleration [mm/s2].

    Parameters
    ----------
    q
        The point in the frame of the disc [m]; None: on +y, on the circle of output pins or cranks.
    until, interval
        End and interval of the samples [s]; None: defaults of the flags.
    """
    import numpy as np

    from cycloid_mj.analysis.series import point_path
    from cycloid_mj.geometry.kinematics import CrankLaw
    from cycloid_mj.reducer import reducer_of

    reducer, crank_law = reducer_of(design), CrankLaw(design.drive.speed, design.drive.ramp)
    until = design.drive.ramp + design.drive.hold if until is None else until
    interval = _choose_sample_interval(design, interval)
    time = interval * np.arange(_count_samples(until, interval))
    crank_angle, speed, acceleration = map(
        reducer.member.crank_angle,
        (crank_law.angle_at(time), crank_law.speed_at(time), crank_law.acceleration_at(time)),
    )
    path = point_path(reducer, np.array(q or (0.0, reducer.lever)), 0, crank_angle, speed, acceleration)
    (x, y), (vx, vy), (ax, ay) = (1e3 * vectors.T for vectors in (path.position, path.velocity, path.acceleration))
    column_names = ("t_s", "crank_rad", "x_mm", "y_mm", "vx_mm_s", "vy_mm_s", "ax_mm_s2", "ay_mm_s2")
    return dict(zip(column_names, (time, crank_angle, x, y, vx, vy, ax, ay), strict=True))


def _choose_sample_interval(design: Design, interval: float | None) -> float:
    """Return the interval between samples [s]: ``--step-s``, or the time of one degree of crank at full speed.

    Raises UsageError if ``--step-s`` is not set, and the speed is 0.
    """
    if interval is not None:
        return interval
    if design.drive.speed == 0.0:
        raise UsageError(
            f"{design.name}: drive.speed_rpm is 0, so the default time step (one degree of crank rotation) is "
            "undefined: set the step with --step-s, or a speed with --speed-rpm"
        )
    return math.radians(1.0) / abs(design.drive.speed)


def _count_samples(until: float, interval: float) -> int:
    """Return the number of samples from 0 to `until` at intervals of `interval` [s].

    Raises UsageError if there are too many samples.
    """
    sample_count = math.floor(until / interval + ROUNDING) + 1
    if sample_count > RANGES.rows[1]:
        raise UsageError(
            f"--until-s {until:g} with a step of {interval:g} s needs {sample_count:.3g} rows, but at most "
            f"{RANGES.rows[1]} are allowed: increase --step-s or reduce --until-s"
        )
    return sample_count
