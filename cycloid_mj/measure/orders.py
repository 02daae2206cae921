"""Which cause gives which orders of the crank in a periodic error.

An order is a number of cycles in a turn of the crank. The crank turns by theta against the ring and by theta N/(N-1)
against gear and output, which turn the other way by theta/(N-1). So what belongs to the ring repeats after a turn, at
whole orders; what belongs to gear or output at multiples of N/(N-1); and what all teeth have alike at the mesh order N.
Where the ring turns, by theta/N, its own repeats at multiples of (N-1)/N, that of gear and carrier at whole orders.
"""

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Literal

import numpy as np

from cycloid_mj.analysis.spectrum import Orders
from cycloid_mj.base.array import Array, Integers, Mask
from cycloid_mj.reducer import Reducer

Place = Literal["gear", "stage"]
"""Where an error shows: in the gear's turn, or in the output's turn against the gear's, the stage of output pins."""


@dataclass(frozen=True)
class Cause:
    """What gives an error of certain orders.

    Attributes
    ----------
    key, name
        For programs and for people.
    place
        Where it shows.
    base
        Its orders are multiples of this [1].
    takes
        Whether a multiple is one of them: multiples (n,), 1, 2, ..., to a mask (n,).
    why
        The orders, and the reason.
    """

    key: str
    name: str
    place: Place
    base: float
    takes: Callable[[Integers], Mask]
    why: str

    def rms(self, orders: Orders) -> float:
        """Compute the rms value of its orders in a spectrum of this base."""
        return orders.rms(self._mask(orders.order))

    def strongest(self, orders: Orders) -> tuple[float, float]:
        """Compute the strongest of its orders and its amplitude."""
        amplitude = np.where(self._mask(orders.order), orders.amplitude, 0.0)
        place = int(np.argmax(amplitude))
        return float(orders.order[place]), float(amplitude[place])

    def has(self, order: float) -> bool:
        """Tell whether an order is one of its own."""
        return bool(self._mask(np.array([order]))[0])

    def _mask(self, order: Array) -> Mask:
        multiple = order / self.base
        whole = np.rint(multiple).astype(np.int64)
        return np.isclose(multiple, whole, atol=1e-6) & (whole > 0) & self.takes(whole)

    def as_json(self) -> dict[str, Any]:
        """Convert the cause to JSON values."""
        return {"key": self.key, "name": self.name, "shows_in": self.place, "base_order": self.base, "why": self.why}


def base_orders(reducer: Reducer) -> tuple[Fraction, Fraction]:
    """Compute the base orders of errors that go with the ring, and with the holes, in cycles of a crank turn.

    They are 1 and N/(N-1), or (N-1)/N and 1 where the ring runs ahead of the crank.
    """
    teeth, lobes = reducer.design.ring.teeth, reducer.design.lobes
    return Fraction(reducer.mesh_periods, teeth), Fraction(reducer.mesh_periods, lobes)


def causes(reducer: Reducer) -> tuple[Cause, ...]:
    """List the causes of transmission error that a design can have, with the orders that they give."""
    design = reducer.design
    teeth, lobes, pins = design.ring.teeth, design.lobes, design.output.pins
    ring = "pins" if design.ring.kind == "pin" else "lobes"
    of_mesh: Place = "gear"
    of_holes: Place = "stage"
    mesh, holes = base_orders(reducer)
    times = "" if mesh == 1 else f"{mesh} times "
    if design.output.turns_ring:
        # The gear turns with the carrier, not at all, but by the errors of holes; the ring turns against it.
        of_mesh, of_holes = of_holes, of_mesh
    return (
        Cause(
            "mesh",
            "mesh",
            of_mesh,
            float(mesh),
            lambda k: k % teeth == 0,
            f"{times}{teeth}, {2 * teeth}, ...: the mesh itself, and what all teeth have alike (clearance, elasticity, "
            f"modification, the cam's eccentricity)",
        ),
        Cause(
            "ring",
            f"ring {ring}",
            of_mesh,
            float(mesh),
            lambda k: k % teeth > 0,
            f"{times}whole orders but multiples of {teeth}: an error of one ring {ring[:-1]} acts as a function of its "
            f"angle from the crank, so gives all of them; an error that goes m times round the ring gives m, "
            f"{teeth} - m, {teeth} + m, ...; the gear's weight gives 1",
        ),
        Cause(
            "holes",
            "holes and output pins",
            of_holes,
            float(holes),
            lambda k: (k % pins > 0) & (k % lobes > 0),
            f"multiples of {holes}: the eccentric's direction goes round the gear so often in a crank turn, "
            f"past each hole, each output pin and each of the gear's lobes",
        ),
        Cause(
            "eccentricity",
            "stage of output pins",
            of_holes,
            float(holes),
            lambda k: k % pins == 0,
            f"multiples of {pins} x {holes} = {pins * float(holes):.4g}: what all {pins} output pins have "
            f"alike (clearance, elasticity, the cam's eccentricity)",
        ),
    )
