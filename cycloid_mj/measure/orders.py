"""Orders of the crank in a periodic error, by cause.

An order is a number of cycles in a crank turn. The crank turns by theta relative to the ring and by theta N/(N-1)
relative to disc and output, which turn in the opposite direction by theta/(N-1). Errors of the ring therefore repeat at
whole orders, errors of disc or output at multiples of N/(N-1), and those common to all teeth at the mesh order N. Where
the ring turns, by theta/N, its errors repeat at multiples of (N-1)/N, those of disc and carrier at whole orders.
The cranks of an RV reducer turn relative to ring and carrier in the same way. The run-out of its output repeats with
the rotation of the output.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Literal, cast

import numpy as np

from cycloid_mj.analysis.spectrum import Orders
from cycloid_mj.base.array import Array, Integers, Mask
from cycloid_mj.base.deprecated import deprecated_attribute
from cycloid_mj.design.layouts import Layout
from cycloid_mj.reducer import Reducer, RvReducer

Signal = Literal["gear", "stage", "output"]
"""Signal of an error: the rotation of the disc, that of the output relative to the disc (stage of output pins), or that
of the output."""

OUTPUT_RUNOUT = "output_runout"
"""Key of the cause with a single order, that of a turn of the output."""


@dataclass(frozen=True)
class Cause:
    """A cause of errors with certain orders."""

    key: str
    name: str
    """Key for programs, and name for people."""
    signal: Signal
    """Signal in which it appears."""
    base: float
    """Base of its orders [1]."""
    takes: Callable[[Integers], Mask]
    """Function from multiples of the base, shape (n,), to a mask of those that are its orders."""
    why: str
    """The orders, and the reason, in words."""

    place = deprecated_attribute("Cause", "place", "signal")

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
        ratio = order / self.base
        nearest = np.rint(ratio).astype(np.int64)
        return np.isclose(ratio, nearest, atol=1e-6) & (nearest > 0) & self.takes(nearest)

    def as_json(self) -> dict[str, Any]:
        """Convert the cause to JSON values; ``shows_in`` is its signal, ``base_order`` the base of its orders."""
        return {"key": self.key, "name": self.name, "shows_in": self.signal, "base_order": self.base, "why": self.why}


def base_orders(reducer: Reducer) -> tuple[Fraction, Fraction]:
    """Compute the base orders of errors of the ring and of the holes, in cycles per crank turn.

    They are 1 and N/(N-1), or (N-1)/N and 1 where the ring turns.
    """
    ring_teeth, lobes = reducer.design.ring.teeth, reducer.design.lobes
    return Fraction(reducer.mesh_periods, ring_teeth), Fraction(reducer.mesh_periods, lobes)


def output_order(reducer: Reducer) -> Fraction:
    """Compute the order of a turn of the output, in cycles per crank turn: 1/(N-1), or 1/N where the ring turns."""
    return Fraction(reducer.mesh_periods, reducer.design.ring.teeth * reducer.design.lobes)


def causes(reducer: Reducer) -> tuple[Cause, ...]:
    """Return the causes of transmission error of a design, with the crank orders that each of them excites."""
    return CAUSES[reducer.LAYOUT](reducer)


def _ring_causes(reducer: Reducer, signal: Signal, shared_properties: str) -> tuple[Cause, Cause]:
    """Return the causes of transmission error at the ring: properties that all teeth share, and errors of single teeth.

    Each has the orders that it excites, in cycles per crank turn. `signal` is the rotation in which they appear, such
    as "gear" (the disc); `shared_properties` names, for the explanation, what all teeth have in common besides the
    clearance, such as "profile".
    """
    design, (mesh_base, _) = reducer.design, base_orders(reducer)
    ring_teeth, ring_word = design.ring.teeth, "pins" if design.ring.kind == "pin" else "lobes"
    factor_text = "" if mesh_base == 1 else f"{mesh_base} times "
    return (
        Cause(
            "mesh",
            "mesh",
            signal,
            float(mesh_base),
            lambda multiple: multiple % ring_teeth == 0,
            f"{factor_text}{ring_teeth}, {2 * ring_teeth}, ...: the mesh, and properties common to all teeth "
            f"(clearance, {shared_properties})",
        ),
        Cause(
            "ring",
            f"ring {ring_word}",
            signal,
            float(mesh_base),
            lambda multiple: multiple % ring_teeth > 0,
            f"{factor_text}whole orders except multiples of {ring_teeth}: an error of one ring {ring_word[:-1]} acts "
            f"as a function of its angle to the crank, so it causes all of them; an error with m periods around the "
            f"ring causes m, {ring_teeth} - m, {ring_teeth} + m, ...; the weight of the disc causes 1",
        ),
    )


def _central_causes(reducer: Reducer) -> tuple[Cause, ...]:
    """Return the causes of transmission error with a central crank: mesh, ring, output pins and holes, eccentricity.

    Each has the orders that it excites, in cycles per crank turn.
    """
    design = reducer.design
    lobes, pin_count, (_, holes_base) = design.lobes, design.output.pins, base_orders(reducer)
    mesh_signal: Signal = "gear"
    holes_signal: Signal = "stage"
    if design.output.turns_ring:
        # The gear turns with the carrier, not at all, but by the errors of holes; the ring turns against it.
        mesh_signal, holes_signal = holes_signal, mesh_signal
    return (
        *_ring_causes(reducer, mesh_signal, "elasticity, modification, the cam's eccentricity"),
        Cause(
            "holes",
            "holes and output pins",
            holes_signal,
            float(holes_base),
            lambda multiple: (multiple % pin_count > 0) & (multiple % lobes > 0),
            f"multiples of {holes_base}: number of turns of the eccentric relative to the disc in a crank turn, past "
            f"each hole, each output pin and each lobe",
        ),
        Cause(
            "eccentricity",
            "stage of output pins",
            holes_signal,
            float(holes_base),
            lambda multiple: multiple % pin_count == 0,
            f"multiples of {pin_count} x {holes_base} = {pin_count * float(holes_base):.4g}: properties common to "
            f"all {pin_count} output pins (clearance, elasticity, the cam's eccentricity)",
        ),
    )


def _rv_causes(reducer: Reducer) -> tuple[Cause, ...]:
    """Return the causes of transmission error of an RV reducer: mesh, ring, cranks, planet mesh, run-out of the output.

    Each has the orders that it excites, in cycles per crank turn. All appear in the rotation of the output.
    """
    lobes, planet_teeth, (_, base) = (
        reducer.design.lobes,
        cast(RvReducer, reducer).planet.planet_teeth,
        base_orders(reducer),
    )
    runout_order = output_order(reducer)
    return (
        *_ring_causes(reducer, "output", "elasticity, modification"),
        Cause(
            "cranks",
            "cranks, bores and planets",
            "output",
            float(base),
            lambda multiple: (multiple % planet_teeth > 0) & (multiple % lobes > 0),
            f"multiples of {base}: number of turns of the cranks relative to disc and carrier in a crank turn; an "
            f"error of an eccentric, of a bore in disc or carrier, or the run-out of a planet causes {base}",
        ),
        Cause(
            "planet_mesh",
            "planet mesh",
            "output",
            float(base),
            lambda multiple: multiple % planet_teeth == 0,
            f"multiples of {planet_teeth} x {base} = {planet_teeth * float(base):.4g}: transmission error of the "
            "planets",
        ),
        Cause(
            OUTPUT_RUNOUT,
            "run-out of the output",
            "output",
            float(runout_order),
            lambda multiple: multiple == 1,
            f"{runout_order}, a cycle per turn of the output: an eccentric output hole or flange, or the run-out of "
            f"main bearings; only runs over at least {runout_order.denominator} crank turns resolve it",
        ),
    )


CAUSES: Mapping[Layout, Callable[[Reducer], tuple[Cause, ...]]] = {"central": _central_causes, "rv": _rv_causes}
"""Function that returns the causes of each layout."""
