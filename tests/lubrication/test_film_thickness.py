"""Film thickness of line contacts against the worked example of a cylindrical roller bearing (Hamrock and Dowson)."""

import numpy as np
import pytest

from cycloid_mj.lubrication.film import FORMULAS, dowson_higginson, hamrock_dowson, line_contact_groups, pan_hamrock

INNER, OUTER = 64e-3, 96e-3
ROLLER, LENGTH, ROLLERS = 16e-3, 16e-3, 9
MODULUS, VISCOSITY, PRESSURE = 2.28e11, 0.01, 2.2e-8
FORCE = 4.0 * 10800.0 / ROLLERS


def entrainment() -> float:
    """Return the entrainment speed of both races [m/s] at 524 rad/s of the inner ring."""
    pitch = 0.5 * (INNER + OUTER)
    return 524.0 * (pitch**2 - ROLLER**2) / (4.0 * pitch)


@pytest.mark.parametrize(
    ("radius", "expected"),
    [
        (1.0 / (2.0 / ROLLER + 2.0 / INNER), (0.323, 0.393, 0.365)),
        (1.0 / (2.0 / ROLLER - 2.0 / OUTER), (0.390, 0.467, 0.435)),
    ],
)
def test_worked_example_of_a_roller_bearing(radius: float, expected: tuple[float, ...]) -> None:
    contact = line_contact_groups(FORCE, entrainment(), radius, LENGTH, VISCOSITY, PRESSURE, MODULUS)
    films = [formula(contact) for formula in (hamrock_dowson, dowson_higginson, pan_hamrock)]
    assert [1e6 * float(film) for film in films] == pytest.approx(expected, abs=6e-4)


def test_groups_of_the_worked_example() -> None:
    contact = line_contact_groups(
        FORCE, entrainment(), 1.0 / (2.0 / ROLLER + 2.0 / INNER), LENGTH, VISCOSITY, PRESSURE, MODULUS
    )
    assert entrainment() == pytest.approx(10.061, abs=5e-4)
    assert float(contact.speed) == pytest.approx(6.895e-11, rel=1e-3)
    assert contact.material == pytest.approx(5016.0)
    assert float(contact.load) == pytest.approx(2.056e-4, rel=1e-3)


@pytest.mark.parametrize("formula", FORMULAS)
def test_no_film_without_speed_viscosity_or_force(formula: str) -> None:
    still = line_contact_groups(100.0, [0.0, 1.0], 1e-3, 0.01, 0.1, 2e-8, 2.3e11)
    thin = line_contact_groups(100.0, 1.0, 1e-3, 0.01, 0.0, 2e-8, 2.3e11)
    unloaded = line_contact_groups(0.0, 1.0, 1e-3, 0.01, 0.1, 2e-8, 2.3e11)
    film = FORMULAS[formula](still)
    assert film[0] == 0.0 < film[1]
    assert not np.any([FORMULAS[formula](thin), FORMULAS[formula](unloaded)])


def test_the_sign_of_the_entrainment_has_no_effect() -> None:
    forward, back = (line_contact_groups(100.0, speed, 1e-3, 0.01, 0.1, 2e-8, 2.3e11) for speed in (0.3, -0.3))
    assert pan_hamrock(forward) == pan_hamrock(back) > 0.0
