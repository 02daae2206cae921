"""Random drives balance under every load, and a jam is told where ideal teeth would jam."""

from pathlib import Path

import numpy as np
import pytest
from coulomb import friction_borne, left_over
from random_drives import random_drives

from cycloid_mj.base.errors import RunError
from cycloid_mj.design import PRESETS, Design, load, override
from cycloid_mj.design.model import NO_FRICTION
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.ideal_loads import ideal_load_sharing
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics import balance, jam, loads, springs_of
from cycloid_mj.statics.balance import powers

SHARES = (0.001, 0.01, 0.03, 0.1, 0.3, 1.0, 1.5)
WAYS = ((1.0, 1.0), (-1.0, -1.0), (1.0, -1.0))
"""Signs of the crank's speed and of the torque on the output: forward, reversed and back-driven."""


NEAR_JAM = 1.1
"""Multiple of its friction that jams a drive without play, up to which its play may jam it."""


def require_equilibrium(design: Design, crank: float, way: float, sign: float, share: float) -> None:
    """Hold a balance to its equilibrium on exact normals, or a jam to what ideal parts without play can bear."""
    reducer = Reducer(design.but(drive={"speed": way * design.drive.speed}))
    springs, torque = springs_of(reducer, [crank]), sign * share * design.rated_torque
    load = springs.load(reducer.share * torque)[0]
    case = f"{design.name}, crank {way:+g}, load {sign * share:+g}"
    found, told = None, ""
    try:
        found = loads(reducer, springs, torque)
    except RunError as error:
        told = str(error)
    if found is None:
        assert "friction jams the drive" in told, f"{case}: {told}"
        assert friction_borne(reducer, springs, load, 2.0) < NEAR_JAM, case
        return
    forces = np.concatenate([found.teeth[0], found.output[0]])
    most = max(forces.max(), np.linalg.norm(found.cam[0], axis=-1).max(), np.abs(load).max())
    left = left_over(reducer, springs, found.departures[0], forces, load)
    if design.output.turns_ring:
        left = left[:-1]  # the carrier's torque follows from the losses
    assert np.abs(left).max() < 0.02 * most, case


def require_all_balanced(count: int, seed: int) -> None:
    """Hold random drives, each at a crank angle drawn by the seed, to a balance under every load."""
    draw = np.random.default_rng(seed)
    for design in random_drives(count, seed):
        crank = float(draw.uniform(0.0, 2.0 * np.pi))
        for way, sign in WAYS:
            for share in SHARES:
                require_equilibrium(design, crank, way, sign, share)


@pytest.mark.slow
def test_twelve_random_drives_have_an_equilibrium() -> None:
    require_all_balanced(12, 1)


@pytest.mark.slow
def test_two_hundred_random_drives_have_an_equilibrium() -> None:
    require_all_balanced(200, 2)


def test_wedged_cams_are_no_equilibrium() -> None:
    """Without inertia, parts pressed together by 150 000 times the load would also balance: such a result is wrong."""
    design = load(Path(__file__).parents[1] / "data" / "wedged_cams.toml")
    for share in (0.001, 1.5):
        require_equilibrium(design, 6.169354995327815, 1.0, 1.0, share)


MOST_FRICTION = 2.0
"""Largest coefficient that a design may have."""


def borne(reducer: Reducer, crank: float, torque: float) -> float:
    """Compute which multiple of its friction parts without play carry a torque on the output with, up to 2."""
    springs = springs_of(reducer, [crank])
    return friction_borne(reducer, springs, springs.load(reducer.share * torque)[0], 2.0)


def scaled(design: Design, scale: float) -> Design:
    """Return the design with all friction as many times as large."""
    return design.but(friction={name: scale * value for name, value in coefficients(design).items()})


def coefficients(design: Design) -> dict[str, float]:
    """Return the Coulomb coefficients of a design by name."""
    return {name: value for name, value in dict(design.friction).items() if name in NO_FRICTION and name != "law"}


@pytest.mark.slow
def test_all_drives_balance_just_below_the_friction_limit_without_play() -> None:
    """Friction of which they bear 1.03 lets every drive turn; beyond, play lets some, whose balances are held too."""
    draw, tried = np.random.default_rng(31), 0
    for drive in random_drives(18, 31):
        crank, torque = float(draw.uniform(0.0, 2.0 * np.pi)), drive.rated_torque
        most = MOST_FRICTION / max(coefficients(drive).values())
        scale = next(
            (s for s in np.geomspace(1.0, most, 8) if borne(Reducer(scaled(drive, s)), crank, torque) < 1.9), most
        )
        limit = scale * borne(Reducer(scaled(drive, scale)), crank, torque)
        if limit / 0.9 > most:
            continue
        tried += 1
        reducer = Reducer(scaled(drive, limit / 1.03))
        loads(reducer, springs_of(reducer, [crank]), torque)
        for multiple in (0.9, 0.97, 1.03, 1.1):
            require_equilibrium(scaled(drive, limit / multiple), crank, 1.0, 1.0, 1.0)
    assert tried >= 8


@pytest.mark.slow
def test_a_ring_whose_losses_are_many_times_its_load_balances(monkeypatch: pytest.MonkeyPatch) -> None:
    """A drive near its jam, at half of the drawn friction of its plain cams: at all of it no equilibrium is found."""
    seed, drawn = 40925, 140
    *_, design = random_drives(drawn + 1, seed)
    design = design.but(friction={"cam": 0.5 * design.friction.cam})
    crank = float(np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, drawn + 1)[drawn])
    assert design.output.turns_ring
    for way, sign in WAYS:
        for share in SHARES:
            require_equilibrium(design, crank, way, sign, share)
    found = powers(Reducer(design), design.rated_torque, [crank])
    monkeypatch.setattr(balance, "RING_TORQUE", balance.RingTorqueSettings(max_iterations=30, rtol=0.0))
    assert found.lost == pytest.approx(powers(Reducer(design), design.rated_torque, [crank]).lost, rel=1e-3)
    assert 0.01 < found.efficiency < 0.05


def test_a_jam_is_reported_if_friction_exceeds_the_torque_of_ideal_teeth() -> None:
    """Under ideal sharing normal forces rise by 1/(1 - mu a), a the loss of the mesh alone, to infinity."""
    design = override(PRESETS["pin"], ["ring.pins=fixed"])
    cranks = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    gear = Reducer(design).tooth_profile
    B = profile.pin_angles(gear) + cranks[:, np.newaxis]
    reach = profile.pitch_distance(gear, B) - gear.pin_radius
    arm = reach + gear.eccentricity * gear.lobes * np.cos(B - profile.conjugate_alpha(gear, B))
    forces = ideal_load_sharing(gear, design.rated_torque, cranks).forces
    most = design.rated_torque / np.sum(forces * arm, axis=1)
    for crank, limit in zip(cranks, most, strict=True):
        for share, jams in ((0.7, False), (1.4, True)):
            reducer = Reducer(override(design, [f"friction.pin_gear={share * limit}"]))
            springs = springs_of(reducer, [crank])
            assert (jam.friction_limit(springs.contacts, 0, springs.load(design.rated_torque)[0]) < 1.0) == jams
            if jams:
                with pytest.raises(RunError, match="friction jams the drive"):
                    loads(reducer, springs, design.rated_torque)
            else:
                assert np.isfinite(loads(reducer, springs, design.rated_torque).teeth).all()


def test_friction_limit_is_that_of_parts_without_clearance() -> None:
    """Two ways to the largest friction under which the preset turns, here with its play of some micrometres."""
    fixed, crank = override(PRESETS["pin"], ["ring.pins=fixed", "friction.pin_gear=1.2"]), 0.7
    springs = springs_of(Reducer(fixed), [crank])
    borne = jam.friction_limit(springs.contacts, 0, springs.load(fixed.rated_torque)[0])
    assert 0.5 < borne < 0.9
    for times, turns in ((0.97, True), (1.04, False)):
        frictions = {pair: times * borne * fixed.friction_of(pair) for pair in ("pin_gear", "output")}
        reducer = Reducer(fixed.but(friction=frictions))
        found = springs_of(reducer, [crank])
        if turns:
            assert np.isfinite(loads(reducer, found, fixed.rated_torque).teeth).all()
        else:
            with pytest.raises(RunError, match=r"friction jams .* at most 9[5-7]% of those of the design"):
                loads(reducer, found, fixed.rated_torque)
