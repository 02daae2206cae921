"""Hertz's pressures that a material bears, over its strength, and how far his strip reaches."""

import math

YIELD_PRESSURE = 1.79
"""Peak pressure at which a line contact first yields, over the yield strength (von Mises; Johnson 1985, 4.4)."""

SHAKEDOWN_PRESSURE = 4.0 / math.sqrt(3.0)
"""Peak pressure up to which rolling stays elastic after a first yield, 4 k (Johnson 1985, 9.2), over the same: 2.31."""

HARDNESS_PRESSURE = 9.807 / 3.45
"""Brinell hardness as a pressure over the tensile strength of steel: HB is 0.29 of the MPa (ISO 18265): 2.84."""

HERTZ_REACH = 0.3
"""Assumed: Hertz's strip, of half planes, holds up to this half width, over the radius of the thinner body.

Hertz takes b << R (Johnson 1985, 4.1); a strip of 0.3 R, 17 deg to each side, is where conformal solutions leave it."""
