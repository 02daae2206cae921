"""Limits by heat next to the limits by strength and bearings, which a drive may reach first."""

import math
from contextlib import suppress
from dataclasses import replace

from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.units import RPM
from cycloid_mj.design import Named
from cycloid_mj.life.duty import Duty
from cycloid_mj.life.figures import largest_speed
from cycloid_mj.life.rated import momentary_torque
from cycloid_mj.life.steady_state import SETTINGS, ThermalSettings
from cycloid_mj.life.thermal import thermal
from cycloid_mj.life.thermal_state import ThermalState
from cycloid_mj.reducer import RvReducer


def thermal_of(design: Named, duty: Duty | None = None, settings: ThermalSettings = SETTINGS) -> ThermalState:
    """Compute temperatures, warm-up and limits of a drive; from Python as ``cm.thermal(design)``.

    Parameters
    ----------
    design, duty, settings
        As for `thermal`.

    Returns
    -------
    ThermalState
        That of `thermal`, with the momentary torque and the largest speed of the greased bearings; the text of a larger
        limit by heat adds "by heat alone".

    Raises
    ------
    DesignError, RunError, UsageError
        As `thermal`.
    """
    state = thermal(design, duty, settings)
    torque = speed = math.nan
    with suppress(CycloidError):  # the nominal torque may have no equilibrium, although that of the duty has
        torque = momentary_torque(state.reducer)[0]
    if not isinstance(state.reducer, RvReducer):
        speed = RPM * largest_speed(state.reducer)
    return replace(state, momentary_torque=torque, bearing_speed=speed)
