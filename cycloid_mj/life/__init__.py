"""Life of bearings and surfaces, fatigue, wear and heat of a reducer, by standard formulas with sources."""

from cycloid_mj.life.duty import Duty, DutyPoint, read_duty
from cycloid_mj.life.item import RatedItem, Rating
from cycloid_mj.life.items import rate
from cycloid_mj.life.ranges import StressRange, read_ranges

__all__ = ["Duty", "DutyPoint", "RatedItem", "Rating", "StressRange", "rate", "read_duty", "read_ranges"]
