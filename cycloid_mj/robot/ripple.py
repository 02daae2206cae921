"""Transmission error about its mean as harmonics of the crank angle, at several loads.

A counter-clockwise load presses the output to its upper stop, a clockwise load to its lower stop. Each stop has its own
error.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, Self

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.units import ARCSECONDS

Rows = tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class Ripple:
    """Harmonics at several loads; at the order n, the error is a cos(n theta) + b sin(n theta)."""

    orders: tuple[float, ...]
    """Cycles in a turn of the crank, shape (k,)."""
    loads: tuple[float, ...]
    """Shares of the nominal torque, rising, shape (l,); errors are interpolated linearly."""
    low_cos: Rows
    low_sin: Rows
    high_cos: Rows
    high_sin: Rows
    """Factors a and b at the lower and at the upper stop [rad], shape (l, k)."""
    low_error: Rows
    high_error: Rows
    """Numerical errors of the amplitudes [rad], shape (l, k)."""

    def errors(self, angle: float, share: float) -> tuple[float, float]:
        """Compute the errors of both stops [rad] at a crank angle [rad], under a share of the nominal torque."""
        low, high = self.errors_at(angle)
        return float(np.interp(share, self.loads, low)), float(np.interp(share, self.loads, high))

    def errors_at(self, angle: float) -> Array:
        """Sum the harmonics at a crank angle [rad]: the errors of lower and upper stop [rad] by load, shape (2, l)."""
        if not self.orders:
            return np.zeros((2, len(self.loads)))
        orders, waves = self._arrays
        phases = orders * angle
        return np.asarray(waves @ np.concatenate([np.cos(phases), np.sin(phases)]))

    def harmonics(self, sense: int, rated: float) -> Iterator[dict[str, Any]]:
        """Yield the harmonics of the transmission error as JSON values: order, amplitude [arcsec], phase [deg].

        Amplitudes and phases are those in either direction of the crank and at each load. The error is the amplitude
        times cos(order * crank angle + phase). Under a braking load, the output is at the stop opposite to its
        rotation. `sense` is 1 if the output turns in the direction of the crank, else -1. `rated` is the nominal torque
        on the output [N m].
        """
        for direction, is_upper_stop in (("forward", sense < 0), ("reverse", sense > 0)):
            stop_name = "high" if is_upper_stop else "low"
            cosines, sines, errors = (
                np.array(getattr(self, f"{stop_name}_{term}")) for term in ("cos", "sin", "error")
            )
            for load_index, load in enumerate(self.loads):
                for order_index, order in enumerate(self.orders):
                    yield {
                        "order": order,
                        "way": direction,
                        "load_nm": load * rated,
                        "value": float(np.hypot(cosines[load_index, order_index], sines[load_index, order_index]))
                        * ARCSECONDS,
                        "unit": "arcsec",
                        "numerical_error": float(errors[load_index, order_index]) * ARCSECONDS,
                        "phase_deg": float(
                            np.degrees(np.arctan2(-sines[load_index, order_index], cosines[load_index, order_index]))
                        ),
                    }

    @classmethod
    def from_json(cls, content: Mapping[str, Any]) -> Self:
        """Create the ripple (transmission error of a joint) from the JSON object `content`."""
        orders, loads = (tuple(map(float, content[key])) for key in ("orders", "loads"))
        rows = {item.name: tuple(tuple(map(float, row)) for row in content[item.name]) for item in fields(cls)[2:]}
        return cls(orders, loads, **rows)

    @cached_property
    def _arrays(self) -> tuple[Array, Array]:
        """Orders, and a and b at both stops, shape (2, l, 2 k)."""
        waves = [np.concatenate([cos, sin], axis=1) for cos, sin in self._stops]
        return np.array(self.orders), np.array(waves)

    @property
    def _stops(self) -> tuple[tuple[Rows, Rows], tuple[Rows, Rows]]:
        return (self.low_cos, self.low_sin), (self.high_cos, self.high_sin)
