"""``cycloid-mj reduce``: a reducer as one joint of a robot's model."""

from dataclasses import dataclass, replace
from functools import partial
from inspect import getsource
from json import dumps
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from cycloid_mj.base.errors import UsageError, warn
from cycloid_mj.base.outcome import Outcome, headline
from cycloid_mj.cli.delivery import claimed, deliver
from cycloid_mj.cli.flags import FLAT, Delivery, DesignOptions, out_flag, whole
from cycloid_mj.reducer import Reducer

if TYPE_CHECKING:
    from cycloid_mj.robot import ReducedJoint
    from cycloid_mj.robot.against import Against
    from cycloid_mj.robot.population import Population
    from cycloid_mj.robot.study import Tried

OUT = "runs/reduce"
LevelFlag = Annotated[
    Literal["rigid", "backlash", "full"],
    Parameter(
        help="What the joint has: ratio, inertia and constant friction; play and springs too; friction under load and "
        "transmission error as well, by ReducedJoint.step. Default: full."
    ),
]
StepFlag = Annotated[
    float | None,
    Parameter(
        metavar="X",
        help="Time step of the scene [ms], 0.01 to 10. Default: 1, or the longest at which an impact is right.",
    ),
]
IntegratorFlag = Annotated[
    Literal["implicitfast", "discrete"] | None,
    Parameter(
        help="MuJoCo's integrator of the scene: implicitfast keeps the joint's vibration, discrete is stable at any "
        "step but damps it. Default: the one that gets an impact right at the longer step."
    ),
]
InertiaFlag = Annotated[
    float | None,
    Parameter(metavar="X", help="Inertia on the output of the scene [kg m2]. Default: the reducer's own, reflected."),
]
SpreadFlag = Annotated[
    bool,
    Parameter(
        negative="",
        help="Draw drives of the design and write their joints' parameters as distributions, for training on all of "
        "them.",
    ),
]
SamplesFlag = Annotated[int, Parameter(converter=whole, help="Drives that --spread draws.")]
SeedFlag = Annotated[int, Parameter(converter=whole, help="Of the draws: the same seed gives the same drives.")]
MOST_SAMPLES = 100_000

STEM = "reducer"
FILES = ("joint.xml", "scene.xml", "bam.json")
BESIDE = ("lossy_joint.xml", "lossy_scene.xml", "joint.py")
"""Written at the levels that have springs."""
SAMPLES = "samples.csv"
"""Written with ``--spread``."""

EXAMPLES = """Examples:
  cycloid-mj reduce --design pin --out joint
  cycloid-mj reduce --design my.toml --level backlash --load-inertia-kgm2 0.5 --timestep-ms 2 --out joint
  cycloid-mj reduce --design my.toml --spread --samples 200 --seed 1 --out joint
  python -m mujoco.viewer --mjcf=joint/scene.xml"""


@dataclass(frozen=True, kw_only=True)
class ReduceDelivery(Delivery):
    """Where the files of a joint go."""

    out: Annotated[str | None, out_flag("the model, the figures as JSON and CSV, and the page", OUT)] = None


DELIVERED = ReduceDelivery()


def reduce(
    chosen: Annotated[DesignOptions, FLAT],
    *,
    level: LevelFlag = "full",
    timestep_ms: StepFlag = None,
    integrator: IntegratorFlag = None,
    load_inertia_kgm2: InertiaFlag = None,
    spread: SpreadFlag = False,
    samples: SamplesFlag = 100,
    seed: SeedFlag = 0,
    delivery: Annotated[ReduceDelivery, FLAT] = DELIVERED,
) -> int:
    """Reduce a reducer to one joint for a robot's model.

    The full model is measured by statics: backlash, stiffness over torque,
    efficiency both ways over torque and speed, no-load torque, inertia,
    transmission error both ways. Written are joint.xml to include, scene.xml to
    open in any MuJoCo (a motor, the joint, an inertia), reducer.json, bam.json
    (the friction models M3 and M5 of BAM), and reducer.html, which shows the
    joint against the full model and which time steps it bears: those at which an
    impact, the output swung across its play by the rated load, is right within 5 %.
    What MJCF cannot say is ReducedJoint.step in Python; attach_reducer puts the joint on
    any model. lossy_joint.xml and lossy_scene.xml are the same joint with a loss that grows
    with the load in MuJoCo alone, without that step; joint.py is that step by numpy alone.

    --spread draws drives within the design's [tolerance], and friction and stiffness of the
    cam within the ranges that measure efficiency states: samples.csv has play, stiffness,
    friction, loss and transmission error of each, "spread" of reducer.json their mean,
    spread, percentiles and correlation. Joint.varied of joint.py makes a joint of a row.
    """
    from cycloid_mj.cli.progress import counted
    from cycloid_mj.robot.against import against
    from cycloid_mj.robot.measured import reduce as measured
    from cycloid_mj.robot.population import population
    from cycloid_mj.robot.study import scene, study

    if timestep_ms is not None and not 0.01 <= timestep_ms <= 10.0:
        raise UsageError(f"--timestep-ms {timestep_ms:g}: give from 0.01 to 10")
    if load_inertia_kgm2 is not None and not 0.0 < load_inertia_kgm2 < float("inf"):
        raise UsageError(f"--load-inertia-kgm2 {load_inertia_kgm2:g}: give a number more than 0")
    if not 2 <= samples <= MOST_SAMPLES:
        raise UsageError(f"--samples {samples}: give from 2 to {MOST_SAMPLES}")
    if seed < 0:
        raise UsageError(f"--seed {seed}: give 0 or more")
    design = chosen.sound()
    place = claimed(delivery, STEM, (*FILES, *BESIDE, *([SAMPLES] if spread else [])), OUT, paged=True)
    reduced = measured(design, level, counted("reduce", delivery.quiet))
    drives = population(Reducer(design), samples, seed, counted("spread", delivery.quiet)) if spread else None
    inertia = reduced.reflected_inertia if load_inertia_kgm2 is None else load_inertia_kgm2
    # the full model has no friction that holds the wind-up, nor does what an impact is held against
    without = replace(reduced, slips=())
    comparison, steps = against(Reducer(design), without), study(without)
    step = None if timestep_ms is None else 1e-3 * timestep_ms
    if reduced.slips:
        # under the other one what slips does not hold still
        integrator = "implicitfast"
    asked = scene(without, inertia, step, *([] if integrator is None else [(integrator,)]))
    warn(
        design.name,
        [*_inaccurate(asked), *(f"{name} of the joint is off the full model's" for name in comparison.missed)],
    )
    lossy = reduced.level != "rigid"
    slow = asked if asked.integrator == "discrete" or not lossy else scene(without, inertia, step, ("discrete",))
    return deliver(_outcome(reduced, comparison, steps, asked, slow if lossy else None, drives), place, delivery)


def _outcome(
    reduced: "ReducedJoint",
    comparison: "Against",
    steps: "tuple[Tried, ...]",
    asked: "Tried",
    slow: "Tried | None",
    drives: "Population | None",
) -> Outcome:
    from cycloid_mj.base.frame import quantity_frame
    from cycloid_mj.base.result import plain, quantity_table
    from cycloid_mj.report.joint import joint_page
    from cycloid_mj.robot import standalone
    from cycloid_mj.robot.bam import bam
    from cycloid_mj.robot.lossy import lossy_efficiencies, lossy_joint_xml, lossy_scene_xml, lossy_table
    from cycloid_mj.robot.mjcf import joint_xml, scene_xml
    from cycloid_mj.robot.study import recommended, recommended_table, table

    bammed, quantities = bam(reduced), reduced.quantities
    lossy, efficiencies = {}, []
    drawn = {SAMPLES: drives.frame.as_csv()} if drives else {}
    if slow:
        scene = lossy_scene_xml(reduced, slow.inertia, slow.timestep)
        lossy = dict(zip(BESIDE, (lossy_joint_xml(reduced), scene, getsource(standalone)), strict=True))
        efficiencies = lossy_efficiencies(reduced)
    texts = (
        joint_xml(reduced),
        scene_xml(reduced, asked.inertia, asked.timestep, asked.integrator),
        f"{dumps(plain(bammed), indent=2)}\n",
    )
    return Outcome(
        title=f"reduce: {reduced.name}",
        condition=f"level {reduced.level}",
        headline=headline(quantities.values()),
        summary=[
            f"scene: {asked.integrator}, {1e3 * asked.timestep:g} ms, {asked.inertia:.4g} kg m2 on the output: "
            f"{asked.sentence}"
        ],
        tables=[
            quantity_table(f"reduce: {reduced.name}, level {reduced.level}", quantities.values()),
            comparison.table(),
            *([lossy_table(efficiencies)] if efficiencies else []),
            recommended_table(steps),
            table(steps),
            *(drives.tables() if drives else ()),
        ],
        notes=[
            *(f"{one.name}: {one.note}" for one in quantities.values() if one.note),
            *(drives.notes if drives else ()),
        ],
        frame=quantity_frame(quantities),
        files={name: text.encode() for name, text in (*zip(FILES, texts, strict=True), *lossy.items(), *drawn.items())},
        page=partial(joint_page, reduced, comparison, steps, asked, bammed, drives),
        result=plain(
            {
                **reduced.as_json(),
                "scene": asked.as_json(),
                "comparison": comparison.as_json(),
                "stock_efficiency": [one._asdict() for one in efficiencies],
                "te_holds_to_rpm": comparison.highest_speed_rpm,
                "recommended": recommended(steps),
                "steps": [one.as_json() for one in steps],
                **({"spread": drives.as_json()} if drives else {}),
            }
        ),
    )


def _inaccurate(asked: "Tried") -> list[str]:
    if asked.accurate:
        return []
    return [
        f"{asked.integrator} at {1e3 * asked.timestep:g} ms with {asked.inertia:.4g} kg m2 on the output: "
        f"{asked.sentence}; leave out --timestep-ms and --integrator, or give a larger --load-inertia-kgm2"
    ]
