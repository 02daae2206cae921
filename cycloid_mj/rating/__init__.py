"""Whether a reducer lasts: life of bearings and surfaces, fatigue, wear and heat, by standard formulas with sources."""

from cycloid_mj.rating.duty import Duty, DutyPoint, read_duty
from cycloid_mj.rating.item import Item, Rating
from cycloid_mj.rating.items import rate

__all__ = ["Duty", "DutyPoint", "Item", "Rating", "rate", "read_duty"]
