"""Figs 1-4, the generation of the profiles, and the differences between the two designs."""

from cycloid_mj.base.result import Claim, Range, Removal, Table, Value, Verdict
from cycloid_mj.comparison import conditions, differences
from cycloid_mj.geometry import envelope, profile
from cycloid_mj.geometry.modification import tooth_profile
from cycloid_mj.reducer import Reducer
from hsieh2014.plan import Plan, designs
from hsieh2014.stage import PaperFigure, Progress, Runs, StageResult
from hsieh2014.statements import POISSON

CAPTIONS = {
    "fig1_rolling": "Generation: the gear's pitch circle rolls within the ring's; a pin's centre, fixed to the ring, "
    "traces a trochoid in the gear.",
    "fig2_gear": "The cycloid gear is the inner parallel of that trochoid at the pin's radius: the inner envelope of "
    "the pin in all its positions.",
    "fig3_meshing": "Pin design: at every crank angle all 36 pins touch the gear; common normals meet in the pitch "
    "point.",
    "fig4_ring": "Nonpin design: the gear on its orbit sweeps out the internal gear, arcs of the pins and two flanks "
    "beside each.",
}


def geometry(plan: Plan, runs: Runs, progress: Progress) -> StageResult:
    """Draw the generation of both profiles and tabulate their closed forms."""
    from hsieh2014.profile_figures import generation_figures

    gear = tooth_profile(designs()[0])
    drawn = generation_figures(gear)
    plates = tuple(PaperFigure(name, "Figs 1-4", words, drawn[name]) for name, words in CAPTIONS.items())
    root, tip = profile.radii(gear)
    ring_root, ring_tip = envelope.radii(gear)
    rows: tuple[tuple[str | float, ...], ...] = (
        ("root and tip radius of the gear [mm]", f"{1e3 * root:.6g}, {1e3 * tip:.6g}"),
        ("perimeter of the gear [mm]", f"{1e3 * profile.length(gear):.8g}"),
        ("area of the gear, without bore and holes [mm2]", f"{1e6 * profile.area(gear):.8g}"),
        ("pin radius from which the gear is undercut [mm]", f"{1e3 * profile.undercut_radius(gear):.7g}"),
        ("root and tip radius of the internal gear [mm]", f"{1e3 * ring_root:.6g}, {1e3 * ring_tip:.6g}"),
        ("perimeter of the internal gear [mm]", f"{1e3 * envelope.perimeter(gear):.8g}"),
        ("area of its bore [mm2]", f"{1e6 * envelope.area(gear):.8g}"),
        ("tightest concave radius of the internal gear [mm]", f"{1e3 * envelope.tightest_radius(gear):.6g}"),
    )
    note = (
        "The paper's frame of Eqs 8-11 is turned by half a ring pitch against that of its gear: its lobes lie between "
        "the pins' places."
    )
    return StageResult(plates, (Table("closed forms of both profiles", ("", "value"), rows),), notes=(note,))


def equal(plan: Plan, runs: Runs, progress: Progress) -> StageResult:
    """Return every value in which the two designs differ, and the conditions that they share."""
    both = designs()
    names = tuple(design.name for design in both)
    different = differences(both)
    rows = tuple((key, *map(str, each)) for key, each in different.items())
    shared = tuple((key, str(value)) for key, value in conditions(Reducer(both[0])).items())
    return StageResult(
        tables=(
            Table("differences between the designs", ("value", *names), rows),
            Table(
                "conditions of both designs (the runs below change ramp, hold and load equally)",
                ("value", "both"),
                shared,
            ),
        ),
        claims=(_judge_poisson_ratio(),),
        findings={"differences": {key: list(each) for key, each in different.items()}},
        notes=("Friction, clearance, stiffness law, damping, drive and step are the same for both designs.",),
    )


def _judge_poisson_ratio() -> Claim:
    """Judge whether our steel has Poisson's ratio by the E and G that the paper prints for it."""
    steel, stated = designs()[0].material, POISSON.stated.value
    assert stated is not None
    shear = steel.youngs_modulus / (2.0 * (1.0 + steel.poisson))
    stiffer = (1.0 - steel.poisson**2) / (1.0 - stated**2) - 1.0
    same = abs(steel.poisson - stated) < 0.005
    return POISSON.judge(
        ours=Value(
            f"E = {1e-6 * steel.youngs_modulus:.0f} N/mm2, ratio {steel.poisson:g}, so G = {1e-6 * shear:.0f} N/mm2",
            steel.poisson,
            "1",
        ),
        error=Value("input value", 0.0, "1"),
        verdict=Verdict.AGREES if same else Verdict.DEPENDS,
        decided_by="which two of E, G and Poisson's ratio the authors' program used (not stated): the steel of its "
        "library has 0.28, and a program for isotropic materials does not use G",
        searched=(Range("material.poisson", steel.poisson, stated, "1", "of the program's steel, to that of E and G"),),
        removals=[
            Removal(
                "0.28, for that of E and G", f"{stated:.3f}; contacts {100 * stiffer:.1f} % stiffer", Verdict.AGREES
            )
        ],
    )
