"""A compiled model whose gear can be put anywhere in its internal gear, and that ring's surface by brute force."""

from collections.abc import Callable

import mujoco
import numpy as np

from cycloid_mj.design import Design
from cycloid_mj.dynamics.contact.collider import install
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.geometry import envelope
from cycloid_mj.geometry.profile import CycloidGear
from cycloid_mj.parts.gear import tooth_profile


class Rig:
    """A compiled model whose gear can be put anywhere, and what the collider then finds."""

    def __init__(self, design: Design, margin: float) -> None:
        self.design, self.gear = design, tooth_profile(design)
        self.compiled = build(design)
        self.model = self.compiled.model
        self.model.pair_margin[:] = margin
        self.data = mujoco.MjData(self.model)
        self.lobes = {
            self.model.geom(pair.by).id: k for k, pair in enumerate(self.compiled.pairs) if pair.kind == "tooth"
        }

    def contacts(self, crank: float, shift=(0.0, 0.0), turn: float = 0.0):
        """Lobe, gap, position and outward normal of the gear of every tooth contact; crank counter-clockwise."""
        x, y = self.centre(crank, shift)
        for joint, value in (("gear_x", x), ("gear_y", y), ("gear_angle", self.angle(crank, turn)), ("crank", crank)):
            self.data.joint(joint).qpos[0] = value
        with install():
            mujoco.mj_fwdPosition(self.model, self.data)
        found = []
        for k in range(self.data.ncon):
            contact = self.data.contact[k]
            first, second = contact.geom
            if first in self.lobes or second in self.lobes:
                sign = 1.0 if second in self.lobes else -1.0
                lobe = self.lobes[second if second in self.lobes else first]
                found.append((lobe, contact.dist, *contact.pos[:2], *(sign * contact.frame[:2])))
        return np.array(found).reshape(-1, 6)

    def centre(self, crank: float, shift) -> np.ndarray:
        c = self.design.gear.eccentricity
        return np.array([-c * np.sin(crank), c * np.cos(crank)]) + shift

    def angle(self, crank: float, turn: float) -> float:
        return -crank / self.design.lobes + turn


def chain_point(gear: CycloidGear, share: np.ndarray) -> np.ndarray:
    """Surface of lobe 1 from mid-root to mid-root, clockwise, for a share from -2 over -1 (junction) to 2."""
    low, alpha = gear.best_phase, envelope.largest_alpha(gear)
    flank = envelope.Sigma(gear, low + (np.pi - low) * np.clip(np.abs(share) - 1.0, 0.0, 1.0)).points
    flank[:, 0] *= np.where(share < 0.0, 1.0, -1.0)
    arc = envelope.arc_points(gear, alpha * np.clip(np.abs(share), 0.0, 1.0))
    arc[:, 0] = np.abs(arc[:, 0]) * np.sign(share)
    return np.where((np.abs(share) <= 1.0)[:, np.newaxis], arc, flank)


def turned(points: np.ndarray, clockwise: float) -> np.ndarray:
    cosine, sine = np.cos(clockwise), np.sin(clockwise)
    return points @ np.array([[cosine, -sine], [sine, cosine]])


def brute_minima(gaps, coarse: np.ndarray) -> list[float]:
    """Local minima of a gap function on a grid, each refined on ever finer grids around it."""
    values = gaps(coarse)
    found = []
    for k in np.flatnonzero((values[1:-1] < values[:-2]) & (values[1:-1] <= values[2:])) + 1:
        left, right = coarse[k - 1], coarse[k + 1]
        for _ in range(3):
            fine = np.linspace(left, right, 41)
            refined = gaps(fine)
            m = int(np.clip(np.argmin(refined), 1, 39))
            left, right = fine[m - 1], fine[m + 1]
        found.append(float(refined.min()))
    return found


def compare_gaps(rig: Rig, gap: Callable[[np.ndarray], np.ndarray], poses: int, reach: float, tolerance: float) -> int:
    """Compare the contacts of a gear with the minima of its `gap` in random poses within 5 um and 5e-5 rad.

    Every minimum below `reach` [m] along a lobe is found, and nothing else, within a `tolerance` [m]. Returns the
    number of poses with a contact on a flank.
    """
    rng, coarse = np.random.default_rng(3), np.linspace(-2.0, 2.0, 321)
    flanks = 0
    for _ in range(poses):
        crank, shift, turn = rng.uniform(0, 2 * np.pi), rng.uniform(-5e-6, 5e-6, 2), rng.uniform(-5e-5, 5e-5)
        lobe = round((-crank + rng.uniform(-0.7, 0.7)) * 36 / (2 * np.pi)) % 36
        centre, angle = rig.centre(crank, shift), rig.angle(crank, turn)

        def gaps(share: np.ndarray, lobe=lobe, centre=centre, angle=angle) -> np.ndarray:
            ring = turned(chain_point(rig.gear, share), 2 * np.pi * lobe / 36)
            return gap(turned(ring - centre, angle))

        found = rig.contacts(crank, shift, turn)
        mine = found[found[:, 0] == lobe]
        flanks += len(mine) > 1
        # twin minima with hardly a rise between them are one minimum to the grid: each value needs a partner only
        for value in brute_minima(gaps, coarse):
            assert value >= reach or np.abs(found[:, 1] - value).min() < tolerance
        on_ring = mine[:, 2:4] + 0.5 * mine[:, 1:2] * mine[:, 4:6]
        assert np.abs(gap(turned(on_ring - centre, angle)) - mine[:, 1]).max(initial=0.0) < tolerance
    return flanks
