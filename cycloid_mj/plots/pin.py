"""Motion of ring pin 1 in its socket (Fig. 9 of Hsieh 2014)."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cycloid_mj.analysis import MICROMETRE, SIGNALS, PinPath, Series
from cycloid_mj.base.array import Array
from cycloid_mj.geometry.profile import unit
from cycloid_mj.plots import style
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.sockets import socket_half_angle

CLEARANCE: dict[str, Any] = {"color": style.GREY, "linewidth": 1.0, "linestyle": "--"}


@style.with_style
def pin_figure(motion: Series, pin: PinPath) -> Figure:
    """Draw the motion of ring pin 1, or of its sleeve, over a crank turn; `pin` has its clearance.

    The panels have the path of its centre within the clearance, the distance of the centre from the middle of its seat,
    and its spin (speed of rotation).
    """
    figure = style.create_figure(3.2)
    axes = figure.subplot_mosaic("pr;ps", width_ratios=[1, 1.15])
    distance_axes, spin_axes, clearance = axes["r"], axes["s"], 1e6 * pin.clearance
    degrees = style.turn_degrees(motion)
    part_text = "sleeve 1 on its pin" if motion.design.ring.has_sleeves else "pin 1 in its socket"
    position, radial_distance, spin_speed = (
        SIGNALS[key].simulated(motion)[motion.one_turn] for key in ("pin_path", "pin_radial", "pin_spin")
    )
    _draw_path(
        axes["p"], position, _reachable_limit(motion.reducer, clearance, float(np.abs(position).max())), part_text
    )
    for panel, values, title in (
        (distance_axes, radial_distance, "Distance from the centre"),
        (spin_axes, spin_speed, "Spin"),
    ):
        panel.plot(degrees, values, color=style.BLUE, linewidth=0.9)
        panel.set_title(title)
        style.crank_axis(panel, degrees)
    distance_axes.axhline(clearance, **CLEARANCE)
    distance_axes.set_ylim(0.0, 1.15 * max(clearance, float(radial_distance.max())))
    distance_axes.set_ylabel(f"distance [{MICROMETRE}]")
    style.legend_above(distance_axes, ("clearance", CLEARANCE))
    distance_axes.tick_params(labelbottom=False)
    distance_axes.set_xlabel("")
    spin_axes.axhline(0.0, color=style.BLACK, linewidth=0.5)
    spin_axes.margins(y=0.1)
    style.add_degree_axis(spin_axes)
    spin_axes.set_ylabel(SIGNALS["pin_spin"].label)
    figure.align_ylabels([distance_axes, spin_axes])
    return figure


def _reachable_limit(reducer: Reducer, clearance: float, max_distance: float) -> Array:
    """Compute the limit of the positions that the centre of a pin can reach in its seat, (2, n) [um]: x and y.

    The origin is the centre of the seat, and y points away from the reducer's axis. Where the pin touches the arc of
    the seat, the curve is a circle with the radius `clearance` [um]. At either end of the arc of an open socket, the
    pin rolls over an edge, so that its centre moves on a circle about this edge, with the radius of the pin. The curve
    ends where the distance from the origin exceeds `max_distance` [um], or where the pin touches both edges.
    """
    design = reducer.design
    half_angle = socket_half_angle(design) if design.ring.has_sockets else np.pi
    limit_points = clearance * unit(np.linspace(0.0, half_angle, 100))
    if half_angle < np.pi:
        pin_radius = 1e6 * design.ring.pin_radius
        angles_of_rolling = half_angle - np.linspace(0.0, 3.0 * (max_distance + clearance) / pin_radius, 100)
        rolling_path = (pin_radius + clearance) * unit([half_angle]) - pin_radius * unit(angles_of_rolling)
        limit_points = np.concatenate([limit_points, rolling_path[np.minimum.accumulate(rolling_path[:, 0] > 0.0)]])
    return np.concatenate([(limit_points * [-1.0, 1.0])[::-1], limit_points]).T


def _draw_path(axes: Axes, position: Array, limit: Array, part: str) -> None:
    """Draw the path of a pin's centre at n samples [um] and the curve of m points that it can reach [um].

    The path is `position` (n, 2), the curve `limit` (2, m). `part` is the name of the pin in the title.
    """
    axes.plot(*limit, **CLEARANCE)
    axes.plot(*position.T, **style.SIMULATED)
    axes.plot(*position[0], marker="o", markersize=4, color=style.BLUE)
    axes.plot(0.0, 0.0, marker="+", markersize=7, color=style.BLACK, markeredgewidth=0.7)
    style.set_square_limits(axes, 1.12 * max(float(limit[1].max()), float(np.abs(position).max())))
    axes.set_title(f"Centre of {part} (dot: start)")
