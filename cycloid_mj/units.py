"""Units that people read, as numbers: those of the design file are in ``design.units``."""

import math

RPM = math.pi / 30.0
"""One turn a minute [rad/s]."""

ARCMINUTE = math.pi / 180.0 / 60.0
ARCSECOND = ARCMINUTE / 60.0
"""[rad]."""

ARCSECONDS = 3600.0 * 180.0 / math.pi
"""Arc seconds in a radian."""

MILLIMETRES = 1e3
"""Millimetres in a metre."""

MILLIMETRE, MEGAPASCAL = 1e-3, 1e6
"""[m], [Pa]."""
