"""The penetration that is logged and limited is geometric: how deep outlines are in each other, by brute force."""

import mujoco
import numpy as np
import pytest
from designs import unlike
from scipy.spatial import cKDTree
from stepped import stepped

from cycloid_mj.base.errors import RunError
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.dynamics.contact.collider import install
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.geometry import envelope
from cycloid_mj.geometry.modification import tooth_profile
from cycloid_mj.parts.gear import gear_outline
from cycloid_mj.parts.polygon import area_moments
from cycloid_mj.reducer import Reducer

CHORD_ERROR = 1e-9
FINE = 200_000

DESIGNS = {
    "fixed": override(PRESETS["pin"], ["ring.pins=fixed"]),
    "free": PRESETS["pin"],
    "nonpin": PRESETS["nonpin"],
    "turned": override(PRESETS["pin"], ["ring.pins=fixed", "modification.rotation_arcsec=20"]),
    "uniform": override(PRESETS["nonpin"], ["contact.stiffness_law=uniform"]),
    "large": unlike("large"),
}


def signed_distance(polygon: np.ndarray, tree: cKDTree, points: np.ndarray) -> np.ndarray:
    """Distance of points from a counter-clockwise polygon, positive outside: to the segments beside the next corner."""
    corners = len(polygon)
    _, nearest = tree.query(points)
    found = np.full(len(points), np.inf)
    for first in (nearest - 1, nearest):
        start, end = polygon[first % corners], polygon[(first + 1) % corners]
        along = end - start
        share = np.clip(np.sum((points - start) * along, axis=1) / np.sum(along**2, axis=1), 0.0, 1.0)
        away = points - start - share[:, np.newaxis] * along
        size = np.linalg.norm(away, axis=1)
        outside = np.sign(along[:, 1] * away[:, 0] - along[:, 0] * away[:, 1])
        found = np.where(size < np.abs(found), outside * size, found)
    return found


class Outlines:
    """The outlines of gear and ring by dense points."""

    def __init__(self, design: Design) -> None:
        polygon = gear_outline(Reducer(design), CHORD_ERROR)
        self.polygon = polygon if area_moments(polygon).area > 0.0 else polygon[::-1]
        self.tree = cKDTree(self.polygon)
        if design.ring.kind == "nonpin":
            self.ring, self.radius = envelope.sample_ring(tooth_profile(design), FINE).points, 0.0
            self.coarse = 5
        else:
            angle = 2.0 * np.pi * np.arange(design.ring.teeth) / design.ring.teeth
            self.ring = design.ring.pin_circle_radius * np.stack([np.sin(angle), np.cos(angle)], axis=1)
            self.radius, self.coarse = design.ring.pin_radius, 1

    def deepest(self, x: float, y: float, turn: float) -> float:
        """How deep they are in each other, the gear's centre at x, y and turned counter-clockwise [m]."""
        cosine, sine = np.cos(turn), np.sin(turn)
        points = (self.ring - [x, y]) @ np.array([[cosine, -sine], [sine, cosine]])
        found = signed_distance(self.polygon, self.tree, points[:: self.coarse])
        # what lies less deep by all that a point may miss between its neighbours need not be looked at closely
        near = np.flatnonzero(found < found.min() + 1e-6)[:, np.newaxis] * self.coarse
        close = np.unique(near + np.arange(-self.coarse, self.coarse + 1)) % len(points)
        return float(self.radius - signed_distance(self.polygon, self.tree, points[close]).min())


@pytest.mark.slow
@pytest.mark.parametrize("name", DESIGNS)
def test_penetration_is_how_deep_the_outlines_are_in_each_other(name: str) -> None:
    # So much play in cam and output that nothing but the teeth is in touch.
    design = override(DESIGNS[name], ["clearance.cam_um=100", "clearance.output_um=300"])
    compiled = build(design)
    outlines, rng, factors = Outlines(design), np.random.default_rng(1), []
    play, c = getattr(design.clearance, design.tooth_pair), design.gear.eccentricity
    for crank in (0.0, 0.4, 2.0, 4.4):
        data = mujoco.MjData(compiled.model)
        lead = -crank / design.lobes
        x, y = c * np.array([-np.sin(crank), np.cos(crank)]) + rng.uniform(-4e-6, 4e-6, 2)
        turn = lead + (play + 8e-6) / (c * design.lobes) * rng.choice([-1.0, 1.0])
        pose = {"crank": crank, "gear_x": x, "gear_y": y, "gear_angle": turn, "output": lead}
        for joint, value in pose.items():
            data.joint(joint).qpos[0] = value
        with install():
            found = stepped(compiled.model, data, compiled.pairs).penetration
        expected = outlines.deepest(x, y, turn)
        assert expected > 2e-6
        assert found == pytest.approx(expected, abs=3e-9)
        factors.append(-data.contact.dist.min() / found)
    # MuJoCo's own distance is scaled, unless the stiffness is the same everywhere.
    assert (max(abs(factor - 1.0) for factor in factors) > 0.01) == (name != "uniform")


def test_the_limit_is_of_the_geometric_depth() -> None:
    """A run ends between its largest depth and that times the factor which MuJoCo's distance has there."""
    design = override(PRESETS["nonpin"], ["drive.ramp_s=0", "drive.hold_s=0.003", "settings.timestep_us=5"])
    design = override(design, ["load.torque_nm=36", "load.rise_s=0.001", "settings.log_rate_hz=200000"])
    depth = float(simulate(design)["penetration"].max())
    simulate(override(design, [f"contact.max_penetration_um={1.001e6 * depth!r}"]))
    with pytest.raises(RunError, match="max_penetration_um"):
        simulate(override(design, [f"contact.max_penetration_um={0.999e6 * depth!r}"]))
