"""The journal bearing of a half socket: its table against Reynolds' equation, and the published Sommerfeld table."""

import math

import numpy as np
import numpy.typing as npt
import pytest
from scipy.linalg import solve_banded
from scipy.optimize import brentq

from cycloid_mj.lubrication.journal import ECCENTRICITY, PRESSURE, SHEAR, SOMMERFELD, solve_journal

Array = npt.NDArray[np.float64]
PUBLISHED = (
    *((0.681, 0.05, 6.79), (0.347, 0.1, 3.56), (0.181, 0.2, 2.02), (0.090, 0.4, 1.29)),
    *((0.0522, 0.6, 0.99), (0.0253, 0.8, 0.75), (0.0128, 0.9, 0.58), (0.0065, 0.95, 0.44)),
)
"""S, eccentricity ratio and f r/c under a load at rest."""

STREAMERS = 0.3


def pressures(eccentricity: float, start: float, cells: int) -> tuple[Array, Array]:
    """Solve Reynolds' equation on half a circle by finite volumes, with the longest film without suction."""
    angle = np.linspace(start, start + math.pi, cells + 1)
    between = 1.0 + eccentricity * np.cos(0.5 * (angle[1:] + angle[:-1]))
    conductance, source = between**3 / (angle[1] - angle[0]), 6.0 * np.diff(between)

    def film(nodes: int) -> Array:
        bands = np.zeros((3, nodes))
        bands[1] = -(conductance[:nodes] + conductance[1 : nodes + 1])
        bands[0, 1:] = bands[2, :-1] = conductance[1:nodes]
        return np.concatenate([[0.0], solve_banded((1, 1), bands, source[:nodes]), np.zeros(cells - nodes)])

    shortest, longest = 1, cells
    while longest - shortest > 1:
        nodes = (shortest + longest) // 2
        shortest, longest = (nodes, longest) if np.all(film(nodes) >= 0.0) else (shortest, nodes)
    return angle, film(shortest)


def half_bearing(eccentricity: float, cells: int = 2000) -> tuple[float, float, float]:
    """Compute S, and friction f r/c by shear and by pressure, of a half bearing centred on its load."""

    def forces(middle: float) -> tuple[float, float, float, float]:
        angle, pressure = pressures(eccentricity, middle - 0.5 * math.pi, cells)
        shear = np.where(pressure > 0.0, 1.0, STREAMERS) / (1.0 + eccentricity * np.cos(angle))
        load, across = (np.trapezoid(pressure * part(angle - middle), angle) for part in (np.cos, np.sin))
        pushed = -0.5 * np.trapezoid(pressure * -eccentricity * np.sin(angle), angle)
        return float(load), float(across), float(np.trapezoid(shear, angle)), float(pushed)

    middle = brentq(lambda angle: forces(angle)[1], math.pi - 1.55, math.pi, xtol=1e-8)
    load, _, shear, pushed = forces(middle)
    return 1.0 / (math.pi * load), shear / load, pushed / load


@pytest.mark.parametrize("row", range(len(ECCENTRICITY)))
def test_table_solves_reynolds_equation(row: int) -> None:
    solution = half_bearing(float(ECCENTRICITY[row]))
    assert solution == pytest.approx((SOMMERFELD[row], SHEAR[row], PRESSURE[row]), rel=4e-3)


@pytest.mark.parametrize(("number", "eccentricity", "friction"), PUBLISHED)
def test_published_table(number: float, eccentricity: float, friction: float) -> None:
    radius, clearance, length, viscosity, speed = 2e-3, 2e-6, 1e-2, 0.1, 1.0
    force = viscosity * speed / (2.0 * math.pi * radius) * (radius / clearance) ** 2 * 2.0 * radius * length / number
    bearing = solve_journal(force, 0.5 * speed, speed, radius, clearance, length, viscosity)
    assert bearing.sommerfeld == pytest.approx(number)
    assert bearing.eccentricity == pytest.approx(eccentricity, rel=0.01)
    # the published friction has two decimals
    assert bearing.friction * radius / clearance == pytest.approx(friction, abs=0.01 * friction + 0.005)


@pytest.mark.parametrize(("clearance", "friction"), [(1e-6, 0.0093), (5e-6, 0.0028)])
def test_friction_of_a_pin_of_the_preset(clearance: float, friction: float) -> None:
    bearing = solve_journal(100.0, 0.075, 0.15, 2.25e-3, clearance, 0.01, 0.087)
    assert bearing.friction == pytest.approx(friction, abs=0.01 * friction + 5e-5)


def test_film_is_monotone_in_the_speed_and_bounded_by_the_clearance() -> None:
    speeds = np.geomspace(1e-9, 1e3, 200)
    bearing = solve_journal(100.0, speeds, 0.1, 2.25e-3, 1e-6, 0.01, 0.087)
    assert np.all(np.diff(bearing.film) >= 0.0)
    assert np.all((bearing.film > 0.0) & (bearing.film <= 1e-6))


def test_petroff_friction_of_a_light_load() -> None:
    """An unloaded half bearing shears a film of the thickness of the clearance over half of the circumference."""
    force, radius, clearance, length, viscosity, speed = 1e-3, 2e-3, 1e-6, 0.01, 0.1, 1.0
    drag = viscosity * speed / clearance * math.pi * radius * length
    bearing = solve_journal(force, 0.5 * speed, speed, radius, clearance, length, viscosity)
    assert bearing.friction * force == pytest.approx(drag, rel=1e-3)
