"""``cycloid-mj reduce``: a reducer as one joint of a robot's model."""

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from cycloid_mj.base.errors import UsageError, warn
from cycloid_mj.base.outcome import Outcome, headline
from cycloid_mj.base.result import to_json_values
from cycloid_mj.cli.delivery import claim_destination, deliver
from cycloid_mj.cli.flags import FLAT, Delivery, DesignOptions, integer_flag, out_flag
from cycloid_mj.cli.ranges import RANGES
from cycloid_mj.reducer import Reducer, reducer_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from cycloid_mj.robot import ReducedJoint
    from cycloid_mj.robot.comparison import ModelComparison
    from cycloid_mj.robot.description import Format
    from cycloid_mj.robot.population import Population
    from cycloid_mj.robot.stability import StepTrial

OUT = "runs/reduce"
LevelFlag = Annotated[
    Literal["rigid", "backlash", "full"],
    Parameter(
        help="Effects in the joint. rigid: ratio, inertia and constant friction; backlash: also play and "
        "springs; full: also load-dependent friction and transmission error, by ReducedJoint.step. "
        "Default: full."
    ),
]
StepFlag = Annotated[
    float | None,
    Parameter(
        metavar="X",
        help="Time step of the scene [ms], 0.01 to 10. Default: 1, or the longest step that reproduces an impact.",
    ),
]
IntegratorFlag = Annotated[
    Literal["implicitfast", "discrete"] | None,
    Parameter(
        help="MuJoCo integrator of the scene: implicitfast preserves the vibration of the joint, discrete is "
        "stable at any step but damps it. Default: the integrator that reproduces an impact at the "
        "longer time step."
    ),
]
InertiaFlag = Annotated[
    float | None,
    Parameter(
        metavar="X", help="Inertia on the output of the scene [kg m2]. Default: the reflected inertia of the reducer."
    ),
]
SpreadFlag = Annotated[
    bool,
    Parameter(
        negative="",
        help="Draw samples of the design within its tolerances and write the joint parameters as "
        "distributions, for domain randomization.",
    ),
]
SamplesFlag = Annotated[int | None, integer_flag("Number of samples that --spread draws. Default: 100.")]
SeedFlag = Annotated[
    int | None,
    integer_flag("Random seed of the samples. Default: 0."),
]
FormatFlag = Annotated[
    Literal["mjcf", "urdf", "sdf", "isaaclab", "mjx"],
    Parameter(
        name="--format",
        help="Format of the model. mjcf: joint.xml, scene.xml and bam.json; urdf, sdf: NAME.urdf or NAME.sdf with the "
        "play as a second joint; isaaclab: URDF and NAME_cfg.py with a BamActuatorCfg; mjx: joint.xml and scene.xml "
        "with an integrator and a time step of MJX. Default: mjcf.",
    ),
]
USUAL_SAMPLES = 100  # default number of drives of ``--spread``

STEM = "reducer"
SAMPLES = "samples.csv"
"""Written with ``--spread``."""

EXAMPLES = """Examples:
  cycloid-mj reduce --design pin --out joint
  cycloid-mj reduce --design my.toml --level backlash --load-inertia-kgm2 0.5 --timestep-ms 2 --out light
  cycloid-mj reduce --design my.toml --spread --samples 200 --seed 1 --out drives
  cycloid-mj reduce --design my.toml --format urdf --out joint
  python -m mujoco.viewer --mjcf=joint/scene.xml"""


@dataclass(frozen=True, kw_only=True)
class ReduceDelivery(Delivery):
    """Destination of the files of a joint."""

    out: Annotated[str | None, out_flag("the model, the figures as JSON and CSV, and the page", OUT)] = None


DELIVERED = ReduceDelivery()


def reduce(
    design_options: Annotated[DesignOptions, FLAT],
    *,
    level: LevelFlag = "full",
    timestep_ms: StepFlag = None,
    integrator: IntegratorFlag = None,
    load_inertia_kgm2: InertiaFlag = None,
    spread: SpreadFlag = False,
    samples: SamplesFlag = None,
    seed: SeedFlag = None,
    format_: FormatFlag = "mjcf",
    output_flags: Annotated[ReduceDelivery, FLAT] = DELIVERED,
) -> int:
    """Reduce a drive to one joint for a robot model.

    The full model is evaluated by statics: backlash, stiffness as a function of torque, efficiency in both
    directions as a function of torque and speed, no-load torque, inertia, and transmission error in both directions.

    Include joint.xml in a robot, or open scene.xml in MuJoCo (a motor, the joint, an inertia). lossy_joint.xml and
    lossy_scene.xml are the same joint with load-dependent friction in MuJoCo alone. reducer.json has all values of the
    joint, and bam.json the friction models M3 and M5 of BAM. reducer.html compares the joint with the full model and
    lists suitable time steps. With these steps, the peak torque of an impact, in which the rated load drives the output
    across its backlash, is accurate to 5 %.

    In Python, attach_reducer adds the joint to any model. ReducedJoint.step adds load-dependent friction and
    transmission error, which MJCF cannot express; joint.py is this step with NumPy only.

    --spread draws many drives within the tolerances ([tolerance]), with friction and cam stiffness within the ranges
    that `measure efficiency` states. For an RV reducer, these are [crank_tolerance], friction and play of the teeth.
    samples.csv has the joint of each drive (Joint.varied of joint.py applies a row); "spread" in reducer.json has mean,
    standard deviation, percentiles and correlations. randomize_mjx.py, randomize_gymnasium.py and (--format isaaclab)
    randomize_isaaclab.py use these ranges for training.
    """
    from cycloid_mj.cli.progress import count_progress
    from cycloid_mj.robot.comparison import compare_with_full_model
    from cycloid_mj.robot.files import choose_scenes, without_slip
    from cycloid_mj.robot.identification import reduce as identify
    from cycloid_mj.robot.population import draw_population
    from cycloid_mj.robot.stability import study_time_steps

    _require_scene_values(timestep_ms, load_inertia_kgm2)
    samples, seed = _choose_samples(spread, samples, seed)
    design = design_options.resolve_checked()
    reducer = reducer_of(design)
    destination = claim_destination(output_flags, STEM, _list_files(design.name, format_, spread), OUT, with_page=True)
    joint = identify(design, level, count_progress("reduce", output_flags.quiet))
    drives = draw_population(reducer, samples, seed, count_progress("spread", output_flags.quiet)) if spread else None
    slip_free_joint = without_slip(joint)
    comparison, steps = compare_with_full_model(reducer, slip_free_joint), study_time_steps(slip_free_joint)
    timestep = None if timestep_ms is None else 1e-3 * timestep_ms
    scene, lossy = choose_scenes(joint, load_inertia_kgm2, timestep, integrator)
    deviation_warnings = [
        f"{name} of the joint differs from that of the full model" for name in comparison.outside_bounds
    ]
    warn(design.name, [*describe_inaccuracy(scene, timestep_ms, integrator), *deviation_warnings])
    files = _encode_files(reducer, joint, format_, (scene, lossy), drives)
    return deliver(_outcome(joint, comparison, steps, scene, lossy, drives, files), destination, output_flags)


def _list_files(name: str, file_format: "Format", spread: bool) -> list[str]:
    """List the names of all files that `reduce` can write in a format; with `spread`, also those for randomization."""
    from cycloid_mj.robot.description import list_description_files
    from cycloid_mj.robot.files import BASE_FILES, SPRING_FILES
    from cycloid_mj.robot.randomization import FILES

    model_files = (*BASE_FILES, *SPRING_FILES) if file_format == "mjcf" else list_description_files(name, file_format)
    return [*model_files, *((SAMPLES, *FILES[file_format]) if spread else ())]


def _encode_files(
    reducer: Reducer,
    joint: "ReducedJoint",
    file_format: "Format",
    scenes: "tuple[StepTrial, StepTrial | None]",
    drives: "Population | None",
) -> "Mapping[str, bytes]":
    """Return the contents of the files that describe a joint in a format, by file name.

    With `drives`, the joints of randomly drawn drives, files for domain randomization are included. `scenes` are the
    test simulations that determine time step and load of scene.xml and lossy_scene.xml (format ``mjcf`` only).
    """
    from cycloid_mj.robot.description import write_descriptions
    from cycloid_mj.robot.files import joint_files
    from cycloid_mj.robot.randomization import randomization_files

    is_mjcf = file_format == "mjcf"
    files = joint_files(joint, *scenes) if is_mjcf else write_descriptions(joint, reducer, file_format)
    return files | (randomization_files(joint, drives, file_format) if drives else {})


def _require_scene_values(timestep_ms: float | None, load_inertia: float | None) -> None:
    """Raise UsageError if the time step `timestep_ms` [ms] or the inertia of the load [kg m2] is out of range."""
    if timestep_ms is not None and not 0.01 <= timestep_ms <= 10.0:
        raise UsageError(f"--timestep-ms {timestep_ms:g} is out of range: give a time step from 0.01 to 10 ms")
    if load_inertia is not None and not 0.0 < load_inertia < float("inf"):
        raise UsageError(
            f"--load-inertia-kgm2 {load_inertia:g} is out of range: give a finite inertia greater than 0 kg m2"
        )


def _choose_samples(spread: bool, samples: int | None, seed: int | None) -> tuple[int, int]:
    """Return number and seed of the drawn drives: values of the flags `samples` and `seed`, or the defaults for None.

    Raises UsageError if a value is out of range, or set although ``--spread`` is not (`spread`).
    """
    if not spread and (samples, seed) != (None, None):
        flag = "--seed" if samples is None else "--samples"
        raise UsageError(f"{flag} applies only with --spread: add --spread, or remove {flag}")
    samples, seed = USUAL_SAMPLES if samples is None else samples, seed or 0
    low, high = RANGES.joint_samples
    if not low <= samples <= high:
        raise UsageError(f"--samples {samples} is out of range: give a number from {low} to {high}")
    if seed < 0:
        raise UsageError(f"--seed {seed} is out of range: give an integer of 0 or more")
    return samples, seed


def _outcome(
    joint: "ReducedJoint",
    comparison: "ModelComparison",
    steps: "tuple[StepTrial, ...]",
    scene: "StepTrial",
    lossy: "StepTrial | None",
    drives: "Population | None",
    files: "Mapping[str, bytes]",
) -> Outcome:
    """Convert a reduced joint to printable results: quantities, comparison with the full model, time steps, files.

    `steps` are the trials of the study of time steps. `scene` and `lossy` are the trials with the time steps of
    scene.xml and lossy_scene.xml; `lossy` is None without the latter. `drives` has the joints of the drawn drives; None
    without ``--spread``. `files` has the contents of all other files by name.
    """
    from cycloid_mj.base.result import quantity_frame, quantity_table
    from cycloid_mj.report.joint import joint_page
    from cycloid_mj.robot.bam import fit_bam_models
    from cycloid_mj.robot.lossy import lossy_efficiencies, lossy_table
    from cycloid_mj.robot.stability import recommend_time_steps, recommended_table, trials_table

    quantities = joint.quantities
    efficiencies = lossy_efficiencies(joint) if lossy else []
    sample_files = {SAMPLES: drives.frame.as_csv().encode()} if drives else {}
    return Outcome(
        title=f"reduce: {joint.name}",
        condition=f"level {joint.level}",
        headline=headline(quantities.values()),
        summary=[
            f"scene: {scene.integrator}, time step {1e3 * scene.timestep:g} ms, {scene.inertia:.4g} kg m2 on the "
            f"output: {scene.sentence}"
        ],
        tables=[
            quantity_table(f"reduce: {joint.name}, level {joint.level}", quantities.values()),
            comparison.table(),
            *([lossy_table(efficiencies)] if efficiencies else []),
            recommended_table(steps),
            trials_table(steps),
            *(drives.tables() if drives else ()),
        ],
        notes=[
            *(f"{item.name}: {item.note}" for item in quantities.values() if item.note),
            *(drives.notes if drives else ()),
        ],
        frame=quantity_frame(quantities),
        files={**files, **sample_files},
        page=partial(joint_page, joint, comparison, steps, scene, fit_bam_models(joint), drives),
        result=to_json_values(
            {
                **joint.as_json(),
                "scene": scene.as_json(),
                "comparison": comparison.as_json(),
                "stock_efficiency": [item._asdict() for item in efficiencies],
                "te_holds_to_rpm": comparison.highest_speed_rpm,
                "recommended": recommend_time_steps(steps),
                "steps": [item.as_json() for item in steps],
                **({"spread": drives.as_json()} if drives else {}),
            }
        ),
    )


def describe_inaccuracy(scene: "StepTrial", timestep_ms: float | None, integrator: str | None) -> list[str]:
    """Describe the error of a test scene with too long a time step, and its remedy, in a list of one sentence.

    `scene` is the trial simulation; if it is accurate, the list is empty. The remedy is to leave out the flags that are
    set, or to increase the inertia of the load. `timestep_ms` and `integrator` are the values of these flags, None if
    they are not set.
    """
    if scene.accurate:
        return []
    flags = {"--timestep-ms": timestep_ms, "--integrator": integrator}
    flag_text = " and ".join(flag for flag, value in flags.items() if value is not None)
    remedies = [f"leave out {flag_text}"] * bool(flag_text) + ["use a larger --load-inertia-kgm2"]
    return [
        f"{scene.integrator} at {1e3 * scene.timestep:g} ms with {scene.inertia:.4g} kg m2 on the output: "
        f"{scene.sentence}; {', or '.join(remedies)}"
    ]
