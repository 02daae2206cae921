"""Default lengths and settings of the runs of a comparison, which help texts state without loading a solver."""

TURNS = 6
IDLE_TURNS = 2
"""Settled crank turns of a loaded run, and of each start at no load, unless the user says how long (heuristic)."""

QUICK_STARTS = 2
"""Starts of each design at no load in a quick comparison (heuristic): too few to rank designs by, and the verdicts
say so."""

DEFAULTS = ("drive.ramp_s=0.0", "settings.log_rate_hz=20000.0")
"""Changes of the first design, whose conditions all runs share: full speed from the start, vibration up to 10 kHz."""
