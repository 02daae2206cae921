"""What becomes of a design as it is made: tolerances, their yield, and which of them to tighten first."""

from cycloid_mj.explore.tolerances import Tolerances, tolerance

__all__ = ["Tolerances", "tolerance"]
