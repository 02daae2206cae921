"""CoACD without slicing, measured, which shows why the teeth are sliced."""

from dataclasses import dataclass

from cycloid_mj.geometry import envelope, profile
from cycloid_mj.parts import VISUAL_CHORD_ERROR, Mesh, Solid, gear_solid, housing_solid, mesh
from cycloid_mj.parts.convex.decompose import coacd_pieces
from cycloid_mj.parts.convex.measure import pieces_quality
from cycloid_mj.parts.convex.quality import Quality
from cycloid_mj.parts.convex.settings import METHOD, CoacdSettings
from cycloid_mj.parts.rv import rv_parts
from cycloid_mj.reducer import Reducer, RvReducer


@dataclass(frozen=True)
class Plain:
    """The pieces of an entire part by CoACD, and their quality along the normals of its teeth."""

    part: str
    pieces: tuple[Mesh, ...]
    quality: Quality


def plain_gear(reducer: Reducer, settings: CoacdSettings) -> Plain:
    """Decompose the entire cycloid disc by CoACD; takes about a minute."""
    wall = profile.sample(reducer.gear_profile, METHOD.samples, reducer.profile_offset)
    if isinstance(reducer, RvReducer):
        return _decompose_part(rv_parts(reducer)[reducer.gears[0]].solid(VISUAL_CHORD_ERROR), wall, settings)
    return _decompose_part(gear_solid(reducer, VISUAL_CHORD_ERROR), wall, settings)


def plain_ring(reducer: Reducer, settings: CoacdSettings) -> Plain:
    """Decompose the entire internal gear of a nonpin design by CoACD; takes about a minute."""
    wall = envelope.sample_ring(reducer.tooth_profile, METHOD.samples)
    return _decompose_part(housing_solid(reducer, VISUAL_CHORD_ERROR), wall, settings)


def _decompose_part(part: Solid, wall: profile.Outline | envelope.RingOutline, settings: CoacdSettings) -> Plain:
    (region,) = part.prisms
    pieces = coacd_pieces(mesh(part), settings)
    return Plain(part.name, pieces, pieces_quality(region, pieces, wall.points, wall.normals))
