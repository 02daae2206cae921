"""Convex pieces: slices against the true flanks, the play in polygons, areas, CoACD, and what is refused."""

import dataclasses

import numpy as np
import pytest
from designs import FEW_TEETH_CHANGES

from cycloid_mj.base.errors import DesignError
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.modification import tooth_profile
from cycloid_mj.parts import Prism, circle, mass_properties, mesh, parts
from cycloid_mj.parts.convex import (
    CoacdSettings,
    ConvexSettings,
    ConvexSurface,
    Sector,
    SlicePlacement,
    coacd_pieces,
    decompose,
    gear_bore,
    gear_holes,
    gear_teeth,
    hull_body,
    pin_sockets,
    placed_outline,
    plain_gear,
    polygon_body,
    require_convex_slices,
    ring_lobes,
    sectors,
    surface_quality,
    surfaces,
    union_heights,
)
from cycloid_mj.parts.convex.surface import convex_slice
from cycloid_mj.parts.export.clearance import flank_distance
from cycloid_mj.parts.inertia import region_moments
from cycloid_mj.parts.polygon import area_moments
from cycloid_mj.reducer import Reducer, reducer_of

PIN, NONPIN = PRESETS["pin"], PRESETS["nonpin"]
FEW_TEETH = override(NONPIN, FEW_TEETH_CHANGES)
SETTINGS = ConvexSettings()
SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
UP = np.array([[0.0, 1.0]])


def finer(chord_error: float) -> ConvexSettings:
    return dataclasses.replace(SETTINGS, chord_error=chord_error)


def top(*boxes: tuple[float, float]) -> float:
    """Where boxes of the given heights from and to end above y = 0, seen from y = -0.5 at x = 0.5."""
    bodies = [polygon_body(SQUARE * [1.0, high - low] + [0.0, low]) for low, high in boxes]
    return float(union_heights(np.array([[0.5, 0.0]]), UP, bodies, start=0.5, reach=3.0)[0])


def test_fill_follows_touching_bodies_and_stops_at_gaps() -> None:
    assert top((-1.0, 0.25)) == pytest.approx(0.25, abs=1e-15)
    assert top((-1.0, -0.25)) == pytest.approx(-0.25, abs=1e-15)
    assert top((0.0, 1.0), (-1.0, 0.0)) == pytest.approx(1.0, abs=1e-15)
    assert top((-1.0, -0.3), (-0.2, 1.0)) == pytest.approx(-0.3, abs=1e-15)
    assert top((-0.2, 1.0)) == -0.5


def test_fill_in_three_dimensions() -> None:
    """A sphere of hull points against its radius, along normals through its vertices and between them."""
    rng = np.random.default_rng(0)
    vertices = rng.normal(size=(400, 3))
    vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    ends = union_heights(vertices, vertices, [hull_body(vertices)], start=0.5, reach=0.5)
    assert np.abs(ends).max() < 1e-12
    between = rng.normal(size=(200, 3))
    between /= np.linalg.norm(between, axis=1, keepdims=True)
    inside = union_heights(between, between, [hull_body(vertices)], start=0.5, reach=0.5)
    assert (inside < 1e-12).all()
    assert inside.min() < -1e-3


@pytest.mark.slow
@pytest.mark.parametrize("design", [PIN, FEW_TEETH], ids=["pin", "few"])
def test_every_surface_keeps_its_bound(design: Design) -> None:
    for surface in surfaces(Reducer(design), SETTINGS):
        found = surface_quality(surface)
        assert found.parts == len(surface.places)
        if surface.name in ("teeth", "lobe"):
            assert found.samples == 5000
            assert max(found.max_overfill, found.max_underfill) < 0.12e-6
            assert abs(found.volume_error) < 1e-3


@pytest.mark.slow
def test_flanks_are_balanced_and_as_many_as_curvature_asks() -> None:
    """89 pieces to a lobe at 0.1 um (physics: 126 with the error to one side only), plus the cuts of the tip."""
    surface = gear_teeth(Reducer(PIN), SETTINGS)
    concave = sum(np.isfinite(part.width) for part in surface.slices)
    assert 2 * concave + 1 == 89
    found = surface_quality(surface)
    assert found.max_overfill == pytest.approx(found.max_underfill, rel=0.05)


@pytest.mark.slow
def test_the_error_is_of_second_order_in_the_width() -> None:
    """A chord's sagitta goes with its width squared: four times the error, half the slices."""
    coarse, fine = (ring_lobes(Reducer(NONPIN), finer(error)) for error in (4e-7, 1e-7))
    counts = [sum(np.isfinite(part.width) for part in surface.slices) for surface in (coarse, fine)]
    assert counts[1] == pytest.approx(2 * counts[0], abs=2)
    errors = [surface_quality(surface).max_overfill for surface in (coarse, fine)]
    assert errors[0] == pytest.approx(4 * errors[1], rel=0.1)


@pytest.mark.slow
def test_a_slice_out_of_place_is_an_error() -> None:
    """One slice half a micrometre outwards, and some slices missing."""
    surface = gear_teeth(Reducer(PIN), SETTINGS)
    first, *others = surface.places
    moved = dataclasses.replace(first, centre=(0.0, 0.5e-6))
    with pytest.raises(DesignError, match=r"extend beyond its outline by 0\.[3-6]"):
        surface_quality(dataclasses.replace(surface, places=(moved, *others)))
    with pytest.raises(DesignError, match="fall short of its outline"):
        surface_quality(dataclasses.replace(surface, places=tuple(others[3:])))


@pytest.mark.parametrize("make", [gear_bore, gear_holes, pin_sockets])
def test_the_play_in_the_facets_is_that_of_the_circle(make: object) -> None:
    """Walk a round part against the facets in many directions: it stops where the true hole stops it."""
    surface = make(Reducer(PIN), SETTINGS)  # type: ignore[operator]
    part = surface.slices[0]
    inner = part.radius - part.play
    own = [place for place in surface.places if place.member == 1]
    outlines = [placed_outline(surface, place) - place.centre for place in own]
    middle = np.array([outline.mean(axis=0) for outline in outlines])
    facing = middle / np.linalg.norm(middle, axis=1, keepdims=True)
    distance = np.array([np.min(outline @ out) for outline, out in zip(outlines, facing, strict=True)])
    span = np.linspace(-0.9, 0.9, 1001) * (np.pi if surface.name != "socket" else 1.5)
    direction = profile.unit(span)
    along = direction @ facing.T
    stops = np.where(along > 1e-3, (distance - inner) / np.maximum(along, 1e-3), np.inf).min(axis=1)
    assert np.abs(stops - part.play).max() < 1.01 * SETTINGS.play_error
    coarse = dataclasses.replace(SETTINGS, play_error=1e-7)
    if surface.name == "hole":
        assert len(make(Reducer(PIN), coarse).places) < 0.5 * len(surface.places)  # type: ignore[operator]


def test_slices_and_rest_are_the_whole_gear() -> None:
    """Their regions share no area and miss none: the sum is the gear's, but for the rest's chord error."""
    working = [surface for surface in surfaces(Reducer(NONPIN), SETTINGS) if surface.name != "lobe"]
    sliced = sum(area_moments(placed_outline(surface, place)).area for surface in working for place in surface.places)
    behind = [sector for sector in sectors(Reducer(NONPIN), SETTINGS) if sector.part == "gear"]
    rest = sum(sector.count * region_moments(sector.region).area for sector in behind)
    volume = mass_properties(parts(Reducer(NONPIN))["gear"]).volume
    assert (sliced + rest) * NONPIN.gear.face_width == pytest.approx(volume, rel=1e-3)


@pytest.mark.slow
def test_coacd_keeps_convex_slices_and_divides_others() -> None:
    for surface in surfaces(Reducer(PIN), SETTINGS):
        require_convex_slices(surface, SETTINGS.coacd)
    corner = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]]) * 1e-3
    with pytest.raises(DesignError, match="not convex"):
        convex_slice("corner", corner, 1e-3, 1.0)
    teeth = gear_teeth(Reducer(PIN), SETTINGS)
    spoiled = dataclasses.replace(teeth, slices=(dataclasses.replace(teeth.slices[0], outline=corner),))
    with pytest.raises(DesignError, match="2 parts"):
        require_convex_slices(spoiled, SETTINGS.coacd)


@pytest.fixture(scope="module")
def band() -> Sector:
    return sectors(Reducer(PIN), SETTINGS)[1]


@pytest.mark.slow
def test_the_same_seed_has_the_same_parts(band: Sector) -> None:
    first, again = (decompose(band, SETTINGS) for _ in range(2))
    for one, other in zip(first.pieces, again.pieces, strict=True):
        np.testing.assert_array_equal(one.vertices, other.vertices)
        np.testing.assert_array_equal(one.faces, other.faces)


def bent_bar(bound: float) -> Sector:
    """Return a bar whose bend is 1 mm deep."""
    bent = np.array([[0.0, 0.0], [10.0, 1.0], [20.0, 0.0], [20.0, 2.0], [10.0, 3.0], [0.0, 2.0]]) * 1e-3
    return Sector("bar", Prism(bent, (), -1e-3, 1e-3), bound)


@pytest.mark.slow
def test_a_remainder_that_protrudes_from_its_slices_is_an_error(band: Sector) -> None:
    found = decompose(band, SETTINGS).quality
    assert 0.0 < found.max_overfill < band.bound
    assert found.max_underfill < 5e-6
    assert found.volume_error > 0.0
    with pytest.raises(DesignError, match="extend beyond its outline"):
        decompose(bent_bar(1e-12), dataclasses.replace(SETTINGS, coacd=CoacdSettings(threshold=0.9)))


def test_coacd_fills_what_is_not_convex() -> None:
    """At a coarse threshold the measured overfill of a bent bar is the depth of its bend."""
    rest = decompose(bent_bar(2e-3), dataclasses.replace(SETTINGS, coacd=CoacdSettings(threshold=0.9)))
    assert rest.quality.parts == 1
    assert rest.quality.max_overfill == pytest.approx(1e-3, rel=0.02)
    assert rest.quality.volume_error == pytest.approx(0.25, rel=0.01)


def test_lobes_too_wide_for_their_hub_are_refused() -> None:
    with pytest.raises(DesignError, match=r"ring\.teeth = 5, the pieces of the teeth reach inwards"):
        sectors(Reducer(override(PIN, ["ring.teeth=5"])), SETTINGS)


def test_settings_out_of_range_are_refused() -> None:
    for wrong in ({"chord_error": 0.0}, {"play_error": 1.0}, {"fewest_facets": 4}, {"depth": 0.6}, {"hulls": 0}):
        with pytest.raises(DesignError, match=next(iter(wrong))):
            ConvexSettings(**wrong)  # type: ignore[arg-type]


def test_mirrored_places_are_mirror_images() -> None:
    surface = gear_teeth(Reducer(PIN), SETTINGS)
    plain, mirrored = SlicePlacement(0, 1, 0.0), SlicePlacement(0, 1, 0.0, mirrored=True)
    one, other = placed_outline(surface, plain), placed_outline(surface, mirrored)
    np.testing.assert_array_equal(one * [-1.0, 1.0], other[::-1])
    assert area_moments(other).area > 0.0


def test_pieces_are_hulls_of_their_vertices() -> None:
    """Of a circle, which is convex: one piece, with the mesh's volume to CoACD's grid."""
    shape = mesh(Prism(circle(5e-3, 2e-5), (), 0.0, 1e-3))
    (piece,) = coacd_pieces(shape, SETTINGS.coacd)
    assert np.abs(piece.vertices).max() == pytest.approx(5e-3, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "depth", "max_underfill"), [("pin", 2e-3, 1e-5), ("rv80e", 3e-3, 3e-5)])
def test_plain_coacd_fills_the_valleys(name: str, depth: float, max_underfill: float) -> None:
    """By nearly the whole depth, two eccentricities: this is why flanks are sliced. At 0.05 too, in a minute.

    The single piece of rv80e is underfilled by up to 19 um, because the grid of CoACD is a share of the size of the
    part, which is twice that of pin (7.6 um).
    """
    found = plain_gear(reducer_of(PRESETS[name]), CoacdSettings(threshold=0.3)).quality
    assert found.max_overfill > 0.75 * depth
    assert found.max_underfill < max_underfill
    assert found.volume_error > 0.05


@pytest.mark.slow
def test_surfaces_follow_the_kind_of_ring() -> None:
    def names(design: Design) -> list[str]:
        return [surface.name for surface in surfaces(Reducer(design), SETTINGS)]

    assert names(PIN) == ["teeth", "bore", "hole", "socket"]
    assert names(NONPIN) == ["teeth", "bore", "hole", "lobe"]
    assert names(override(PIN, ["ring.pins=fixed"])) == ["teeth", "bore", "hole"]


@pytest.mark.slow
def test_discs_of_unlike_size_have_teeth_of_their_own() -> None:
    """Those of a disc larger by 2 um stand out by that; the discs that are alike share what they are."""
    design = override(PIN, ["gear.discs=3", "errors.disc_dr_um={2=2.0}"])
    found = {surface.key: surface for surface in surfaces(Reducer(design), SETTINGS)}
    assert list(found) == ["teeth", "gear_2_teeth", "bore", "hole", "socket"]
    larger = found["gear_2_teeth"]
    beyond = flank_distance(tooth_profile(PIN), larger.points) - PIN.ring.pin_radius - PIN.clearance.pin_gear
    np.testing.assert_allclose(beyond, -2e-6, atol=1e-12)
    assert surface_quality(larger).max_overfill < larger.overfill_bound


def test_a_surface_is_a_value() -> None:
    first, second = (gear_teeth(Reducer(PIN), SETTINGS) for _ in range(2))
    assert isinstance(first, ConvexSurface)
    for one, other in zip(first.slices, second.slices, strict=True):
        np.testing.assert_array_equal(one.outline, other.outline)
