"""Layouts that this project does not have, told by the keys with which a design file would ask for them."""

from collections.abc import Mapping

TOOTH_DIFFERENCE = (
    "the gear always has one lobe fewer than the ring has teeth (ring.teeth says both): drives with a tooth difference "
    "of 2 or more are not there"
)
TWO_STAGES = (
    "the drive has one stage and one crank, in the middle: RV reducers, with a planetary stage and several cranks, are "
    "not there; a stage before this one may be reckoned into drive.torque_nm and drive.speed_rpm"
)
PINS_ON_GEAR = (
    "pins stand on the ring, and the gear carries the lobes: hypocycloid drives, with the pins on the gear, are not "
    "there"
)

_ASKED_BY: Mapping[str, tuple[str, ...]] = {
    TOOTH_DIFFERENCE: (
        *("lobes", "gear.lobes", "gear.teeth", "ring.lobes", "gear.lobe_count", "ring.pins_count"),
        *("teeth_difference", "tooth_difference", "ring.teeth_difference", "ring.tooth_difference"),
        *("gear.teeth_difference", "gear.tooth_difference"),
    ),
    TWO_STAGES: (
        *("stage", "stages", "rv", "planet", "planets", "planetary", "sun", "cranks", "crankshafts", "first_stage"),
        *("second_stage", "gear.stages", "drive.stages", "shaft.cranks", "shaft.count", "gear.cranks", "ring.stages"),
    ),
    PINS_ON_GEAR: (
        *("hypocycloid", "gear.pins", "gear.rollers", "gear.kind"),
        *("ring.hypocycloid", "gear.hypocycloid"),
    ),
}


def absent_layout(key: str) -> str:
    """Return why there is no such key, where it asks for a layout that is not there; else nothing.

    `key` is ``table.key`` of a design file, or the name of a table.
    """
    return next((why for why, keys in _ASKED_BY.items() if key in keys), "")
