"""How finely the parts are cut into convex pieces; every number that a decomposition depends on, the seed included."""

from dataclasses import dataclass

from cycloid_mj.base.errors import DesignError

TOLERANCE = 1.2
"""A decomposition may be worse than its asked error by this factor (float32 vertices, chords of the parallel curve)."""

OVERLAP = 0.1
"""Neighbouring slices overlap by this share of the chord error: single precision must not leave cracks between them."""


@dataclass(frozen=True)
class CoacdSettings:
    """CoACD's own settings and defaults, by its names; its preprocessing is always off (the meshes are watertight).

    Attributes
    ----------
    threshold
        Concavity at which CoACD stops cutting, relative to the size of the mesh.
    seed
        Of its tree search: the same seed gives the same parts, another one others.
    resolution, mcts_nodes, mcts_iterations, mcts_max_depth
        Samples of a mesh, and the width, length and depth of the tree search.
    """

    threshold: float = 0.05
    seed: int = 0
    resolution: int = 2000
    mcts_nodes: int = 20
    mcts_iterations: int = 150
    mcts_max_depth: int = 3


REST = CoacdSettings(threshold=0.03, mcts_nodes=10, mcts_iterations=60)
"""For sectors of a part: a finer threshold than CoACD's default, and a shorter search."""


@dataclass(frozen=True)
class ConvexSettings:
    """How the working surfaces are sliced, and the rest of the parts with them.

    Attributes
    ----------
    chord_error
        Largest distance of a slice of a concave flank from the profile [m], the same to both sides.
    hull_chord_error
        The same for a convex stretch of a flank, which is a single hull however many vertices it has [m].
    hulls
        Hulls that half a convex lobe is made of: more are quicker in collision, but where two meet both carry.
    play_error
        Largest error of the play between a round part and the facets of the hole around it [m].
    fewest_facets
        Facets to a full turn of a hole, at least; more where ``play_error`` asks for it.
    depth
        Thickness of the slices as a share of the pin radius; less where a wall is thin.
    rest_chord_error
        Chord error of what has no working surface [m].
    coacd
        CoACD's settings for that rest, and for the check that each slice is one convex body.

    Raises
    ------
    DesignError
        A length, or ``fewest_facets``, is out of range.
    """

    chord_error: float = 1e-7
    hull_chord_error: float = 5e-9
    hulls: int = 2
    play_error: float = 2e-8
    fewest_facets: int = 32
    depth: float = 0.2
    rest_chord_error: float = 2e-5
    coacd: CoacdSettings = REST

    def __post_init__(self) -> None:
        for name in ("chord_error", "hull_chord_error", "play_error", "rest_chord_error"):
            value = getattr(self, name)
            if not 1e-11 <= value <= 1e-3:
                raise DesignError(f"{name} is {value} m; it must be from 1e-11 to 1e-3 m: choose e.g. 1e-7")
        if self.fewest_facets < 8:
            raise DesignError(f"fewest_facets is {self.fewest_facets}; a hole needs at least 8: choose e.g. 32")
        if self.hulls < 1:
            raise DesignError(f"hulls is {self.hulls}; half a lobe needs at least 1: choose e.g. 2")
        if not 0.0 < self.depth <= 0.5:
            raise DesignError(f"depth is {self.depth}; it must be above 0 and at most 0.5 of the pin radius")
