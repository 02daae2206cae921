"""Orders of the crank in a periodic error, by cause.

An order is a number of cycles in a crank turn. The crank turns by theta relative to the ring and by theta N/(N-1)
relative to disc and output, which turn in the opposite direction by theta/(N-1). Errors of the ring therefore repeat at
whole orders, errors of disc or output at multiples of N/(N-1), and those common to all teeth at the mesh order N. Where
the ring turns, by theta/N, its errors repeat at multiples of (N-1)/N, those of disc and carrier at whole orders.
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
"""Signal of an error: the rotation of the disc, or that of the output relative to the disc (stage of output pins)."""


@dataclass(frozen=True)
class Cause:
    """A cause of errors with certain orders."""

    key: str
    name: str
    """For programs and for people."""
    place: Place
    """Signal in which it appears."""
    base: float
    """Base of its orders [1]."""
    takes: Callable[[Integers], Mask]
    """Function from multiples of the base, shape (n,), to a mask of those that are its orders."""
    why: str
    """The orders, and the reason, in words."""

    def rms(self, orders: Orders) -> float:
        """Compute the rms value of its orders in a spectrum of this base."""
        return orders.rms(self._mask(orders.order))

    def strongest(self, orders: Orders) -> tuple[float, float]:
        """Return the strongest of its orders and the amplitude."""
        amplitude = np.where(self._mask(orders.order), orders.amplitude, 0.0)
        index = int(np.argmax(amplitude))
        return float(orders.order[index]), float(amplitude[index])

    def has(self, order: float) -> bool:
        """Return whether the cause has an order."""
        return bool(self._mask(np.array([order]))[0])

    def _mask(self, order: Array) -> Mask:
        multiple = order / self.base
        whole = np.rint(multiple).astype(np.int64)
        return np.isclose(multiple, whole, atol=1e-6) & (whole > 0) & self.takes(whole)

    def as_json(self) -> dict[str, Any]:
        """Convert the cause to JSON values."""
        return {"key": self.key, "name": self.name, "shows_in": self.place, "base_order": self.base, "why": self.why}


def base_orders(reducer: Reducer) -> tuple[Fraction, Fraction]:
    """Compute the base orders of errors of the ring and of the holes, in cycles per crank turn.

    They are 1 and N/(N-1), or (N-1)/N and 1 where the ring turns.
    """
    teeth, lobes = reducer.design.ring.teeth, reducer.design.lobes
    return Fraction(reducer.mesh_periods, teeth), Fraction(reducer.mesh_periods, lobes)


def causes(reducer: Reducer) -> tuple[Cause, ...]:
    """List the causes of transmission error of a design, with their orders."""
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
            f"{times}{teeth}, {2 * teeth}, ...: the mesh, and properties common to all teeth (clearance, elasticity, "
            f"modification, the cam's eccentricity)",
        ),
        Cause(
            "ring",
            f"ring {ring}",
            of_mesh,
            float(mesh),
            lambda k: k % teeth > 0,
            f"{times}whole orders except multiples of {teeth}: an error of one ring {ring[:-1]} acts as a function of "
            f"its angle to the crank, so it causes all of them; an error with m periods around the ring causes m, "
            f"{teeth} - m, {teeth} + m, ...; the weight of the disc causes 1",
        ),
        Cause(
            "holes",
            "holes and output pins",
            of_holes,
            float(holes),
            lambda k: (k % pins > 0) & (k % lobes > 0),
            f"multiples of {holes}: number of turns of the eccentric relative to the disc in a crank turn, past each "
            f"hole, each output pin and each lobe",
        ),
        Cause(
            "eccentricity",
            "stage of output pins",
            of_holes,
            float(holes),
            lambda k: k % pins == 0,
            f"multiples of {pins} x {holes} = {pins * float(holes):.4g}: properties common to all {pins} output "
            f"pins (clearance, elasticity, the cam's eccentricity)",
        ),
    )
