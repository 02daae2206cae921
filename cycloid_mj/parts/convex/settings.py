"""Settings of the convex decomposition: all numbers that it depends on, including the seed."""

from dataclasses import dataclass

from cycloid_mj.base.errors import DesignError


@dataclass(frozen=True)
class SliceMethod:
    """Numbers of the decomposition beyond its settings: sampling, tolerances and limits; lengths in metres."""

    tolerance: float = 1.2  # allowed ratio of measured to requested error: float32 vertices, chords of parallels
    overlap: float = 0.1  # overlap of slices relative to the chord error, against cracks in float32
    samples: int = 5000  # points of a surface at which its slices are measured
    flank_samples: int = 512  # points of a flank from which its slices are chosen
    wall_share: float = 0.25  # thickness relative to the thinnest wall: slices of both sides leave half of it
    decompositions: int = 4  # attempts of CoACD for a sector, each with half the threshold
    spacing: float = 1e-4  # spacing of the measured points on the walls of a prism
    depth: float = 1e-4  # start of the search along a normal, below the wall
    reach: float = 5e-2  # end of the search along a normal, above the wall
    coacd_grid: float = 1e-4  # grid of CoACD relative to the size of the mesh; cracks that wide are no gaps
    seam: float = 1e-11  # width of gaps that are due to rounding
    parallel: float = 1e-12  # slope of a plane along a normal below which both are parallel


METHOD = SliceMethod()


@dataclass(frozen=True)
class CoacdSettings:
    """Settings of CoACD with its names and defaults; preprocessing is off, as the meshes are watertight.

    Attributes
    ----------
    threshold
        Concavity at which CoACD stops cutting, relative to the size of the mesh.
    seed
        Random seed of the tree search.
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
"""Settings for sectors of a part: a finer threshold than the default, and a shorter search."""


@dataclass(frozen=True)
class ConvexSettings:
    """Settings of the slices of working surfaces and of the remaining material.

    Attributes
    ----------
    chord_error
        Largest distance of a slice of a concave flank from the profile [m], the same to both sides.
    hull_chord_error
        The same for a convex part of a flank, which is one hull with any number of vertices [m].
    hulls
        Number of hulls of half a convex lobe: more are faster in collision, but adjacent hulls share contacts.
    play_error
        Largest error of the play between a round part and the facets of the hole around it [m].
    fewest_facets
        Minimum number of facets per turn of a hole; ``play_error`` can require more.
    depth
        Thickness of the slices relative to the pin radius; less for thin walls.
    rest_chord_error
        Chord error of the remaining material [m].
    coacd
        Settings of CoACD for the remaining material and for the check that slices are convex.

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
        """Raise DesignError unless all lengths and counts of the settings of a convex decomposition are in range."""
        for name in ("chord_error", "hull_chord_error", "play_error", "rest_chord_error"):
            length = getattr(self, name)
            if not 1e-11 <= length <= 1e-3:
                raise DesignError(
                    f"{name} of ConvexSettings is {length} m, which is out of range: choose a length from 1e-11 to "
                    "1e-3 m, e.g. 1e-7"
                )
        if self.fewest_facets < 8:
            raise DesignError(
                f"fewest_facets of ConvexSettings is {self.fewest_facets}, which is too few for a hole: choose 8 or "
                "more, e.g. 32"
            )
        if self.hulls < 1:
            raise DesignError(
                f"hulls of ConvexSettings is {self.hulls}, but half a lobe needs at least 1: choose 1 or more, e.g. 2"
            )
        if not 0.0 < self.depth <= 0.5:
            raise DesignError(
                f"depth of ConvexSettings is {self.depth}, which is out of range: choose a fraction of the pin radius "
                "greater than 0 and at most 0.5"
            )
