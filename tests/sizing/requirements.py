"""Random requirements, from 5:1 to 120:1, 30 to 300 mm and 0.2 to 500 N m, of steel, milled and printed drives."""

import numpy as np

from cycloid_mj.sizing.requirement import Requirement

RATIOS, DIAMETERS, TORQUES = (5.0, 120.0), (0.03, 0.3), (0.2, 500.0)


def drawn(count: int, seed: int) -> list[Requirement]:
    """Draw requirements, each size evenly by its logarithm; larger drives are asked for more torque."""
    generator = np.random.default_rng(seed)

    def between(low: float, high: float, share: float) -> float:
        return float(f"{low * (high / low) ** share:.3g}")

    found = []
    for _ in range(count):
        ratio, size, more = generator.uniform(size=3)
        torque = min(max(0.7 * size + 0.6 * (more - 0.35), 0.0), 1.0)
        found.append(
            Requirement(
                ratio=round(between(*RATIOS, ratio)),
                diameter=between(*DIAMETERS, size),
                torque=between(*TORQUES, torque),
                process=("steel", "printed", "steel", "milled")[len(found) % 4],
            )
        )
    return found
