"""Every name of the model, of the log and of parts: bodies, joints, surfaces, mating pairs, topics and columns.

Like things are numbered from 1 on +y, clockwise. What a drive has of each disc is named after the disc where it has
several: ``gear_2_cam``; a drive of one disc has a ``gear`` and a ``cam``.
"""

import re
from functools import cache

REDUCER, PINS, FORCES = "/reducer", "/pins", "/forces"
"""Topics of a log."""

FRICTION_POWER, NORMAL_POWER = "friction_power", "normal_power"
"""Powers lost in a kind of pair, or by a drag: by sliding, and by normal forces (damping) [W]."""

FORCE_X, FORCE_Y, MOMENT, PEAK_FORCE = "force_x", "force_y", "moment", "peak_force"
"""Force of a pair: the wrench about the origin of the loaded body [N], [N m], and the largest force since the previous
sample [N]."""

CRANK_BEARING, PLANET_MESH = "crank_bearing", "planet_mesh"
"""Kinds of mating pairs that only an RV reducer has."""

KINDS = {
    "pin": "pin_gear",
    "lobe": "tooth",
    "socket": "pin_socket",
    "sleeve": "pin_sleeve",
    "cam": "cam",
    "output_pin": "output",
    "crank": CRANK_BEARING,
    "planet": PLANET_MESH,
}
"""First word of the name of a mating pair, before its number -> kind of the pair."""

SOLVERS = {"planar": "by the planar solver", "mujoco": "by MuJoCo"}
"""Solver -> words for the condition of what it ran."""

SHAFT, GEAR, OUTPUT, HOUSING, PIN = "shaft", "gear", "output", "housing", "pin"
"""Bodies, and the parts that they are."""

SUN, CRANK, PLANET = "sun", "crank", "planet"
"""Bodies and parts of an RV reducer; a crank carries a planet."""

CRANK_JOINT, OUTPUT_JOINT = "crank", "output"
DRIVE, LOAD = "drive", "load"

SPACER = "spacer"
"""The ring on the crank between two discs, a part of the shaft."""

ROLLER = "output_roller"
"""The roller on an output pin in the hole of a disc, a part of the output."""

ROLLER_BEARING = "roller_bearing"
"""The drawn-cup needle bearing between an output pin and its roller."""

TEETH, BORE, CAM, HOLE, OUTPUT_PIN = "teeth", "bore", "cam", "hole", "output_pin"
ECCENTRIC = "eccentric"
LOBE, SOCKET, SLEEVE, CORE = "lobe", "socket", "sleeve", "core"
"""Surfaces, with those of ``PIN``; a mating pair is named after one of its two."""

MOTOR_COVER, OUTPUT_COVER, FLANGE, RETAINER = "motor_cover", "output_cover", "output_flange", "bearing_retainer"
COVERS = MOTOR_COVER, OUTPUT_COVER, RETAINER
"""Parts of the casing that are fixed to the ring."""

SCREW, FLANGE_SCREW, MOTOR_SCREW, DOWEL = "screw", "flange_screw", "motor_screw", "dowel"
FLANGE_WASHER, FLANGE_DOWEL, RETAINER_SCREW = "flange_washer", "flange_dowel", "retainer_screw"
SCREW_INSERT, FLANGE_INSERT = "screw_insert", "flange_screw_insert"
LOAD_INSERT, MOTOR_INSERT = "load_screw_insert", "motor_screw_insert"
RETAINER_INSERT = "retainer_screw_insert"
INSERTS = SCREW_INSERT, FLANGE_INSERT, LOAD_INSERT, MOTOR_INSERT, RETAINER_INSERT

CAM_BEARING, SHAFT_BEARING, OUTPUT_BEARING = "cam_bearing", "shaft_bearing", "output_bearing"

SHAFT_RING, BORE_RING, SHAFT_SEAL = "shaft_ring", "bore_ring", "shaft_seal"
"""Retaining rings on the crank and in the motor cover, and seal ring in the motor cover."""

RETAINING_RINGS = SHAFT_RING, BORE_RING

CRANK_RING = "crank_ring"
"""Family of the rings: 1 on the side of the motor, 2 beyond the discs."""

BEARING_SPACER = "bearing_spacer"
"""Family of the rings between the bearings of an overhung crank: 1 between the outer rings, 2 between the inner."""

STOP_RING = "stop_ring"
"""The ring between the ring of the drive and the outer ring of the bearing around the second output disc."""

KEY = "key"
"""The key of the cams on the shaft of several discs."""

CAM_SCREW = "cam_screw"
"""Screws across the slots of clamped cams."""

SECOND_OUTPUT = "output_2"
"""The output disc on the motor side, if both ends of the output pins are supported."""

PRESSED_PIN = "pressed_pin"
"""Round part within the housing in the solids of the mechanism, as `OUTPUT_PIN` is within the output."""

DRAGS = {"crank_drag": CRANK_JOINT, "sun_drag": "sun_angle", "output_drag": OUTPUT_JOINT}
"""Loss of seals and lubricant -> the joint that it brakes; a design without has none. An RV reducer is driven by its
sun."""


POINT_Q = {"q_x": "m", "q_y": "m", "q_vx": "m/s", "q_vy": "m/s"}
"""Columns of the point q with their units: where the (first) disc has the middle of its first output hole."""

_OF_DISC = re.compile(r"^gear_(\d+)_")

SPECIAL = "special, by drawing"
"""Designation of a bought part that is not in stock."""


def column(stem: str, quantity: str) -> str:
    """Name the column of a quantity of a pair, a kind of pair or a pin."""
    return f"{stem}_{quantity}"


def kind_of(pair: str) -> str | None:
    """Return the kind of a mating pair by its name; None of any other name."""
    return KINDS.get(_OF_DISC.sub("", pair).rstrip("0123456789").rstrip("_"))


def number_of(pair: str) -> int:
    """Return the number of a pin, lobe or mating pair by its name: 1, 2, ...; 1 of the cam, which has none."""
    return int(pair.rpartition("_")[2]) if pair[-1].isdigit() else 1


@cache
def disc_of(pair: str) -> int:
    """Return the index of the disc of a mating pair by its name: 0, 1, ...; 0 if the pair has no disc."""
    match = _OF_DISC.match(pair)
    return int(match.group(1)) - 1 if match else 0


def family(part: str) -> str:
    """Return the kind of a part from its name: ``gear_2`` is a ``gear``, ``cam_1`` a ``cam``."""
    return part.rstrip("0123456789").rstrip("_")


def pin(number: int) -> str:
    """Name ring pin 1, 2, ... (1 at +y, clockwise)."""
    return numbered_name(PIN, number)


def numbered_name(stem: str, number: int) -> str:
    """Return the name of a numbered part: ``pin_1``."""
    return f"{stem}_{number}"


def all_numbered(stem: str, count: int) -> tuple[str, ...]:
    """Return the names of the parts with the numbers 1 to `count`: ``pin_1``, ``pin_2``, ..."""
    return tuple(numbered_name(stem, number) for number in range(1, count + 1))


def of_disc(name: str, disc: int, discs: int) -> str:
    """Return the name of a part of a disc (from 0): ``gear_2``, ``gear_2_cam``; of a single disc, `name`."""
    if discs == 1:
        return name
    gear = numbered_name(GEAR, disc + 1)
    return gear if name == GEAR else column(gear, name)


def gears(discs: int) -> tuple[str, ...]:
    """Name the bodies of all discs: ``gear_1``, ``gear_2``, ...; a single one is the ``gear``."""
    return tuple(of_disc(GEAR, disc, discs) for disc in range(discs))


def planar_joints(body: str) -> tuple[str, str, str]:
    """Name the joints of a body that moves in the plane: x, y and its rotation. They are columns of the log, too."""
    return column(body, "x"), column(body, "y"), column(body, "angle")


def tilt_joints(body: str) -> tuple[str, str]:
    """Name the joints of a pin that tilts: about x and y. They are not columns of the log."""
    return column(body, "tilt_x"), column(body, "tilt_y")


def planar_speeds(body: str) -> tuple[str, str, str]:
    """Name the columns of the speeds of a body that moves in the plane: along x and y, and of its rotation."""
    return column(body, "vx"), column(body, "vy"), column(body, "speed")
