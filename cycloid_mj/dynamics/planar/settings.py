"""Settings of the planar solver: the Newton method of a time step, and the fixed-point iteration of its contacts.

They are named tuples, which compiled code reads as constants.
"""

from typing import NamedTuple


class StepNewtonSettings(NamedTuple):
    """Settings of the semismooth Newton method of a step (``equations.solve``), an active-set method in stages."""

    max_iterations: int = 100
    """Largest number of iterations, after which a step ends with the contact states that it has."""
    block_iterations: int = 6
    """Iterations in which every contact without a moving pin may change its state; later ones change the first only.

    Block pivoting may cycle. Changing one contact at a time ends if the contact law has a P-matrix (Murty, Note on a
    Bard-type scheme for solving the complementarity problem, 1974). Of the two contacts of a moving pin the first one
    changes in every iteration; pins interact through the heavy discs only, so they may all change at once.
    """
    coupled_iterations: int = 25
    """Iterations in which sliding friction follows the current normal force; later ones use that of the last iteration.

    In a wedge friction and normal force may raise each other, so that states alternate. With a fixed friction force (a
    Tresca problem) the contact law has a P-matrix, and pivoting ends.
    """
    friction_rtol: float = 1e-6
    """Largest change of a sliding contact's normal force in the last Tresca iteration, over the largest one."""


NEWTON = StepNewtonSettings()


class ContactSearchSettings(NamedTuple):
    """Settings of the contact searches in a step (``stepper``), a fixed-point iteration of the midpoint speeds."""

    max_searches: int = 16
    unrelaxed_searches: int = 4
    """Searches after which the iteration is relaxed by one half, which ends oscillations between two sets of contacts.
    """
    pin_tolerance: float = 2e-2
    """Largest distance of a moving pin from the pose of its contact search, as a share of its clearance. The relative
    error of a circle that rolls in another is half of its square."""
    disc_tolerance: float = 1e-8
    """The same of a disc [m], including the motion of its teeth by rotation."""
    margin: float = 1e-7
    """Gap [m] up to which contacts are listed, as they may close within a step."""
    edge_tolerance: float = 1e-9
    """Relative deviation of a contact normal from the centre of the surrounding arc, beyond which it is at an edge."""


CONTACT_SEARCH = ContactSearchSettings()
