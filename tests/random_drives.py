"""Random drives that can be built: 1-3 discs, carrier and ring, every kind of ring, 0.5-300 um of clearance."""

from collections.abc import Iterator

import numpy as np

from cycloid_mj.base.errors import DesignError
from cycloid_mj.checks import soundness
from cycloid_mj.design import PRESETS, Design
from cycloid_mj.reducer import Reducer

KINDS = ("free", "fixed", "sleeved", "massless", "massless_sleeved", "nonpin")


def random_drives(count: int, seed: int) -> Iterator[Design]:
    """Iterate over designs without an error in ``design check``; the kinds take turns, all else is drawn."""
    draw = np.random.default_rng(seed)
    for number in range(count):
        yield _drive(draw, KINDS[number % len(KINDS)], number)


def _drive(draw: np.random.Generator, kind: str, number: int) -> Design:
    while True:
        design = drawn(draw, kind, number)
        try:
            if design and all(item.passed or item.severity == "warning" for item in soundness(Reducer(design))):
                return design
        except DesignError:
            pass


def drawn(draw: np.random.Generator, kind: str, number: int) -> Design | None:
    """Draw a design, which may well not be one that can be built; None where its values are not even allowed."""
    base = PRESETS["nonpin" if kind == "nonpin" else "pin"]
    teeth, discs, pins = int(draw.integers(6, 81)), int(draw.integers(1, 4)), int(draw.integers(5, 13))
    E = draw.uniform(0.02, 0.08)
    c = draw.uniform(0.4, 0.8) * E / teeth
    rho = draw.uniform(0.3, 0.7) * E * np.sin(np.pi / teeth)
    root = E - c - rho
    bore = draw.uniform(0.3, 0.45) * root
    circle = draw.uniform(0.45, 0.6) * (bore + root)
    hole = draw.uniform(0.4, 0.8) * min(root - circle, circle - bore, circle * np.sin(np.pi / pins))
    pins_of_ring = {} if kind == "nonpin" else {"pins": kind, "socket": draw.choice(["half_open", "closed"])}
    pairs = base.but(ring=pins_of_ring).pair_kinds
    size = np.exp(draw.uniform(np.log(0.5e-6), np.log(3e-4)))
    try:
        return base.but(
            name=f"drawn {number}",
            structure=draw.choice(["rigid", "springs"]),
            ring={
                "teeth": teeth,
                "pin_circle_radius": E,
                "pin_radius": rho,
                "sleeve_thickness": 0.3 * rho,
                **pins_of_ring,
            },
            gear={
                "eccentricity": c,
                "discs": discs,
                "bore_radius": bore,
                "face_width": draw.uniform(0.1, 0.4) * E,
                "bearing": draw.choice(["rolling", "plain"]),
            },
            output={
                "member": draw.choice(["carrier", "ring"]),
                "pins": pins,
                "pin_circle_radius": circle,
                "pin_radius": hole - c,
                "hole_radius": hole,
                "rollers": bool(draw.integers(2)),
            },
            shaft={"radius": 0.6 * bore, "counterweight_radius": 0.7 * E},
            housing={"outer_radius": 1.3 * E},
            clearance={pair: float(size * draw.uniform(0.3, 1.0)) for pair in pairs},
            friction={
                pair: float(draw.uniform(0.0, 0.3))
                for pair in ("pin_gear", "pin_socket", "pin_sleeve", "tooth", "cam", "output")
            },
            drive={
                "torque": float(10.0 ** draw.uniform(0.0, 1.0) * 500.0 * E**3 * discs),
                "speed": float(draw.uniform(10.0, 300.0)),
            },
        )
    except DesignError:
        return None
