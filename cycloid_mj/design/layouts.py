"""Layouts of reducers: the commands that support each, and the keys of the design file that do not apply to it."""

from collections.abc import Mapping
from typing import Literal

Layout = Literal["central", "rv"]

CENTRAL: tuple[Layout, ...] = ("central",)
RV: tuple[Layout, ...] = ("rv",)
BOTH: tuple[Layout, ...] = CENTRAL + RV
"""Layouts that have a figure."""

SUPPORTED: Mapping[Layout, tuple[str, ...]] = {
    "central": (),
    "rv": (
        "analyze",
        "animate",
        "app",
        "build",
        "calibrate",
        "compare",
        "compare-bench",
        "datasheet",
        "design new",
        "design show",
        "design check",
        "design kinematics",
        "design profile",
        "export",
        "figures",
        "log",
        *(
            f"measure {name}"
            for name in ("te", "backlash", "lost-motion", "loads", "torque", "efficiency", "vibration")
        ),
        "optimize",
        "protocol",
        "rate",
        "reduce",
        "render",
        "report",
        "simulate",
        "statics",
        "stress",
        "sweep",
        "thermal",
        "tolerance",
        "view",
        "wear",
    ),
}
"""The only commands that support a layout; empty: all of them."""

RV_TABLES = ("planet", "cranks", "crank_errors", "crank_tolerance")
"""Tables of the design file that apply to the layout "rv" only."""

_PAIRS_OF_CRANK = ("clearance", "stiffness", "damping", "working_force")

NOT_IN_RV = frozenset(
    (
        *("structure", "ring.halves", "ring.preload", "ring.preload_torque"),
        *("gear.bore_radius", "gear.bearing"),
        *(
            f"output.{name}"
            for name in (
                *("pins", "pin_radius", "pin_circle_radius", "hole_radius", "rollers", "roller_bearing"),
                *("core_radius", "fillet_radius", "disc_thickness", "support", "main_bearings"),
                "main_bearing_seat",
            )
        ),
        *(f"{table}.{pair}" for table in _PAIRS_OF_CRANK for pair in ("cam", "output")),
        *("friction.cam", "friction.output", "friction.output_rolling", "contact.cam_rollers"),
        *("errors.hole_position", "errors.hole_x", "errors.hole_y", "errors.eccentricity"),
        *("errors.cam_position", "errors.cam_x", "errors.cam_y"),
        *("bearing.output_dynamic_capacity", "bearing.output_static_capacity"),
    )
)
"""Keys, as ``table.name`` of the model, of parts that an RV reducer does not have: central crank and output pins."""

LISTED_IF_SET = frozenset(("contact.needles",))
"""Keys of common tables, as ``table.name``, that all RV reducers have. A drive with a central crank lists them only if
their value is not the default."""

_WITHOUT_RV = ("shaft", "springs", "tolerance", "measured")
"""Tables of such parts, and measured ones; the tolerances of an RV reducer are in a table of their own."""


def applies(layout: Layout, table: str, name: str) -> bool:
    """Return whether a value of the design, ``table.name`` or ``name`` outside of tables, applies to a layout."""
    if layout == "central":
        return table not in RV_TABLES and f"{table}.{name}" not in LISTED_IF_SET
    return table not in _WITHOUT_RV and (f"{table}.{name}" if table else name) not in NOT_IN_RV


def supports(layout: Layout, command: str) -> bool:
    """Return whether a command supports a layout."""
    return not SUPPORTED[layout] or command in SUPPORTED[layout]


def layouts_of(command: str) -> tuple[Layout, ...]:
    """Return the layouts that a command supports."""
    return tuple(layout for layout in SUPPORTED if supports(layout, command))


def unsupported_layout(name: str, layout: Layout) -> str:
    """Return a sentence that refuses a design of a layout where only the layout "central" is supported."""
    return (
        f'the design {name!r} has layout = "{layout}", which is not supported here: use a design with a central crank'
    )
