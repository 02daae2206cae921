"""Layouts of reducers that are not supported, recognised by the keys and words that request them."""

from collections.abc import Mapping

TOOTH_DIFFERENCE = (
    "the disc always has one lobe fewer than the ring has teeth, so ring.teeth sets both; drives with a tooth "
    "difference of 2 or more are not supported"
)
TWO_STAGES = (
    'for an RV reducer, set layout = "rv", and its tables [planet] and [cranks]. Include any other first stage in '
    "drive.torque_nm and drive.speed_rpm"
)
PINS_ON_GEAR = (
    "the pins are in the ring and the disc has the lobes; hypocycloid drives, with the pins on the disc, are not "
    "supported"
)

_KEYS: Mapping[str, tuple[str, ...]] = {
    TOOTH_DIFFERENCE: (
        *("lobes", "gear.lobes", "gear.teeth", "ring.lobes", "gear.lobe_count", "ring.pins_count"),
        *("teeth_difference", "tooth_difference", "ring.teeth_difference", "ring.tooth_difference"),
        *("gear.teeth_difference", "gear.tooth_difference"),
    ),
    TWO_STAGES: (
        *("stage", "stages", "rv", "planets", "planetary", "sun", "crankshafts", "first_stage", "crank"),
        *("second_stage", "gear.stages", "drive.stages", "shaft.cranks", "shaft.count", "gear.cranks", "ring.stages"),
    ),
    PINS_ON_GEAR: (
        *("hypocycloid", "gear.pins", "gear.rollers", "gear.kind"),
        *("ring.hypocycloid", "gear.hypocycloid"),
    ),
}

_VALUES: Mapping[tuple[str, str], str] = {
    ("ring.kind", "hypocycloid"): PINS_ON_GEAR,
    ("ring.kind", "hypocycloidal"): PINS_ON_GEAR,
    ("ring.kind", "hypo"): PINS_ON_GEAR,
    ("ring.kind", "rv"): TWO_STAGES,
}


def unsupported_key(key: str) -> str:
    """Return why the layout of an unknown ``table.key`` or table is not supported; else an empty text."""
    return next((reason for reason, keys in _KEYS.items() if key in keys), "")


def unsupported_value(key: str, value: str) -> str:
    """Return why the layout of a word at ``table.key`` is not supported; else an empty text."""
    return _VALUES.get((key, value.casefold()), "")
