"""CoACD: the convex pieces of a mesh, and its check that a slice is convex."""

import numpy as np

from cycloid_mj.base.errors import DesignError
from cycloid_mj.parts import Mesh, mesh
from cycloid_mj.parts.convex.settings import CoacdSettings
from cycloid_mj.parts.convex.surface import ConvexSurface, prism


def coacd_pieces(shape: Mesh, settings: CoacdSettings) -> tuple[Mesh, ...]:
    """Decompose a watertight mesh `shape` into convex hulls by CoACD, in the order of their centroids.

    CoACD keeps vertices in single precision and rounds them to about 1e-4 of the extent of the mesh. `settings` are
    the parameters of CoACD.
    """
    import coacd

    coacd.set_log_level("error")
    hulls = coacd.run_coacd(
        coacd.Mesh(shape.vertices, shape.faces),
        threshold=settings.threshold,
        preprocess_mode="off",
        seed=settings.seed,
        resolution=settings.resolution,
        mcts_nodes=settings.mcts_nodes,
        mcts_iterations=settings.mcts_iterations,
        mcts_max_depth=settings.mcts_max_depth,
    )
    pieces = [Mesh(np.asarray(vertices, np.float64), np.asarray(faces, np.int32)) for vertices, faces in hulls]
    return tuple(sorted(pieces, key=lambda piece: tuple(piece.vertices.mean(axis=0).round(9))))


def require_convex_slices(surface: ConvexSurface, settings: CoacdSettings) -> None:
    """Raise DesignError unless CoACD keeps each slice of a surface as one convex body.

    `settings` are the parameters of CoACD.
    """
    for index in range(len(surface.slices)):
        piece_count = len(coacd_pieces(mesh(prism(surface, index)), settings))
        if piece_count != 1:
            raise DesignError(
                f"slice {index + 1} of the {surface.name} is not convex (CoACD splits it into {piece_count} parts): "
                "reduce ConvexSettings.depth"
            )
