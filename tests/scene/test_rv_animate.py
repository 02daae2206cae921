"""Animation of RV reducers: drawn gaps are the measured ones to scale, forces act on the drawn parts."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.record import Run
from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS
from cycloid_mj.dynamics.run import model_for, simulate
from cycloid_mj.log import write
from cycloid_mj.plots.animation import draw_frames, select_samples
from cycloid_mj.reducer import RvReducer
from cycloid_mj.reducer.member import view_columns_from_ring, view_from_ring
from cycloid_mj.scene import contact_forces, draw_rv_poses, ideal_forces, poses, transform

LARGEST = 1.0 + 0.6 * 4e-3 / 0.1e-6
"""Pins of 4 mm keep two fifths of their radius when their clearance of 0.1 um is magnified."""


@pytest.fixture(scope="module", params=["carrier", "ring"])
def run(request: pytest.FixtureRequest) -> Run:
    """The end of a run under load."""
    changes = {"drive": {"ramp": 0.0, "hold": 0.012}, "output": {"member": request.param}}
    design = PRESETS["rv80e"].but(ring={"pins": "fixed"}, **changes)
    whole = simulate(design, model_for("planar", RvReducer(design)))
    return whole.select(whole.time > 0.011)


def seen_from_ring(run: Run) -> tuple[RvReducer, dict[str, np.ndarray]]:
    """The reducer with a fixed ring, and the columns in its frame."""
    design = select_samples(run).motion.design
    return RvReducer(view_from_ring(design)), view_columns_from_ring(RvReducer(design), run.columns)


def test_eccentrics_are_displaced_to_scale(run: Run) -> None:
    """The displacement of an eccentric in its bore is the force of the crank over the stiffness of its bearing."""
    reducer, columns = seen_from_ring(run)
    forces = contact_forces(reducer, columns).of("crank_bearing").of_disc(1)
    for magnification in (1.0, 300.0):
        drawn = draw_rv_poses(reducer, columns, 1, magnification)
        bores = transform(drawn.gear[:, np.newaxis], reducer.stage.crank_positions([0.0])[0])
        displacement = np.linalg.norm(drawn.eccentrics - bores, axis=-1)
        expected = magnification * (forces.size / reducer.bearing_stiffness + reducer.bearing_clearance)
        np.testing.assert_allclose(displacement, expected, rtol=0.02)  # friction is part of the force


def test_gaps_of_loaded_pins_are_their_deflection(run: Run) -> None:
    """A drawn pin overlaps the disc by its force over the contact stiffness of 6e8 N/m; the clearance is 0.1 um."""
    reducer, columns = seen_from_ring(run)
    drawn = draw_rv_poses(reducer, columns)
    forces = contact_forces(reducer, columns).of("pin_gear").of_disc(0).size
    overlap = -(drawn.gaps.opening + 0.1e-6)
    loaded = forces > 0.2 * forces.max()
    np.testing.assert_allclose(6e8 * overlap[loaded], forces[loaded], rtol=0.02)  # friction adds to the force


def test_parts_are_at_their_measured_places_without_magnification(run: Run) -> None:
    reducer, columns = seen_from_ring(run)
    drawn, measured = draw_rv_poses(reducer, columns), poses(reducer, columns)
    # the disc is drawn in its ideal place: parts are displaced by its deviation, tens of micrometres
    for number, crank in enumerate(("crank_1", "crank_2", "crank_3")):
        assert np.abs(drawn.cranks[:, number] - measured[crank]).max() < 2e-4
    np.testing.assert_allclose(np.linalg.norm(drawn.posts, axis=-1), reducer.post_circle_radius, rtol=1e-12)
    forces = ideal_forces(RvReducer(select_samples(run).motion.design), run.columns, 0)
    assert forces is not None
    measured_forces = contact_forces(reducer, columns).of("pin_gear").of_disc(0).size
    share = np.sum(np.minimum(forces, measured_forces), axis=1) / forces.sum(axis=1)
    assert share.min() > 0.8, "the same pins carry the load as in the closed form"


def test_forces_start_on_the_drawn_eccentrics(run: Run) -> None:
    reducer, columns = seen_from_ring(run)
    drawn = draw_rv_poses(reducer, columns, 0, 50.0)
    forces = contact_forces(reducer, columns, drawn).of("crank_bearing").of_disc(0)
    distance = np.linalg.norm(forces.point - drawn.eccentrics, axis=-1)
    np.testing.assert_allclose(distance, drawn.eccentric_radius, rtol=0.02)


def test_pictures_change_with_the_motion(run: Run) -> None:
    pictures = list(draw_frames(select_samples(run, 100.0, frames=2, disc=1), 320))
    assert [picture.shape for picture in pictures] == [(400, 320, 3)] * 2
    assert np.any(pictures[0] != pictures[1])


def test_a_magnification_beyond_the_pins_is_refused(run: Run) -> None:
    assert select_samples(run, 0.999 * LARGEST).magnification == pytest.approx(0.999 * LARGEST)
    with pytest.raises(UsageError, match=f"choose a value from 1 to {int(LARGEST)}"):
        select_samples(run, 1.001 * LARGEST)


def test_animate_writes_a_film_of_an_rv_reducer(run: Run, tmp_path: Path) -> None:
    log, film = tmp_path / "rv80e.mcap", tmp_path / "rv80e.gif"
    write(run, log)
    assert main(["animate", str(log), str(film), "--frames", "3", "--width", "320", "--quiet"]) == 0
    with Image.open(film) as image:
        assert image.size == (320, 400)
