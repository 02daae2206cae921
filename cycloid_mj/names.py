"""Every name of the model and of the log: bodies, joints, geoms, mating pairs, sensors, topics and columns."""

from collections.abc import Iterator
from dataclasses import dataclass

from cycloid_mj.design import Design

REDUCER, PINS, FORCES = "/reducer", "/pins", "/forces"
"""Topics of a log."""

FRICTION_POWER, NORMAL_POWER = "friction_power", "normal_power"
"""What a kind of pair, or a drag, takes by sliding and by its normal forces (damping) [W]."""

FORCE_X, FORCE_Y, MOMENT, PEAK_FORCE = "force_x", "force_y", "moment", "peak_force"
"""What acts in a pair: the wrench about the origin of the body that feels it [N], [N m], and the largest force since
the sample before [N]."""

KINDS = {
    "pin": "pin_gear",
    "lobe": "tooth",
    "socket": "pin_socket",
    "sleeve": "pin_sleeve",
    "cam": "cam",
    "output_pin": "output",
}
"""What a mating pair is named by, before its number -> its kind."""

SHAFT, GEAR, OUTPUT, HOUSING = "shaft", "gear", "output", "housing"
CRANK_JOINT, OUTPUT_JOINT = "crank", "output"
DRIVE, LOAD = "drive", "load"
TEETH, BORE, CAM = "teeth", "bore", "cam"
DRAGS = {"crank_drag": CRANK_JOINT, "output_drag": OUTPUT_JOINT}
"""Loss of seals and lubricant -> the joint that it brakes; a design without has neither."""


def column(stem: str, quantity: str) -> str:
    """Name the column of a quantity of a pair, a kind of pair or a pin."""
    return f"{stem}_{quantity}"


def kind_of(pair: str) -> str | None:
    """Give the kind of a mating pair by its name; None of any other name."""
    return KINDS.get(pair.rstrip("0123456789").rstrip("_"))


def number_of(pair: str) -> int:
    """Give the number of a pin, lobe or mating pair by its name: 1, 2, ...; 1 of the cam, which has none."""
    return int(pair.rpartition("_")[2]) if pair[-1].isdigit() else 1


def pin(number: int) -> str:
    """Name ring pin 1, 2, ... (1 at +y, clockwise)."""
    return f"pin_{number}"


def lobe(number: int) -> str:
    """Name lobe 1, 2, ... of the internal gear (1 at +y, clockwise)."""
    return f"lobe_{number}"


def socket(number: int) -> str:
    """Name the socket of a ring pin."""
    return f"socket_{number}"


def sleeve(number: int) -> str:
    """Name the bore of the sleeve on a pressed-in ring pin."""
    return f"sleeve_{number}"


def core(number: int) -> str:
    """Name the pressed-in pin inside a sleeve."""
    return f"core_{number}"


def hole(number: int) -> str:
    """Name the gear's hole of an output pin."""
    return f"hole_{number}"


def output_pin(number: int) -> str:
    """Name output pin 1, 2, ... (1 at +y, clockwise)."""
    return f"output_pin_{number}"


@dataclass(frozen=True)
class Pair:
    """One mating pair.

    Attributes
    ----------
    name
        Name of the ``<pair>`` and stem of its columns in the log.
    kind
        ``pin_gear``, ``pin_socket``, ``pin_sleeve``, ``tooth``, ``cam`` or ``output``: the key of its clearance,
        friction, stiffness, damping and working force.
    on
        Geom whose body feels the logged force: the gear, the pin in its socket, or the sleeve on its pin.
    by
        Geom that exerts it.
    """

    name: str
    kind: str
    on: str
    by: str


def pairs(design: Design) -> tuple[Pair, ...]:
    """Give every mating pair of a design."""
    return tuple(_pairs(design))


def _pairs(design: Design) -> Iterator[Pair]:
    ring = range(1, design.ring.teeth + 1)
    if design.ring.kind == "nonpin":
        yield from (Pair(lobe(i), "tooth", TEETH, lobe(i)) for i in ring)
    else:
        yield from (Pair(pin(i), "pin_gear", TEETH, pin(i)) for i in ring)
    if design.ring.has_sockets and design.ring.has_pin_bodies:
        yield from (Pair(socket(i), "pin_socket", pin(i), socket(i)) for i in ring)
    if design.ring.has_sleeves and design.ring.has_pin_bodies:
        yield from (Pair(sleeve(i), "pin_sleeve", sleeve(i), core(i)) for i in ring)
    yield Pair(CAM, "cam", BORE, CAM)
    yield from (Pair(output_pin(i), "output", hole(i), output_pin(i)) for i in range(1, design.output.pins + 1))


def sensors(design: Design) -> dict[str, dict[str, str]]:
    """Give the sensors as groups of column name and unit, in the order of the model."""
    reducer = {
        "crank_angle": "rad",
        "crank_speed": "rad/s",
        "crank_torque": "N m",
        "gear_x": "m",
        "gear_y": "m",
        "gear_angle": "rad",
        "gear_vx": "m/s",
        "gear_vy": "m/s",
        "gear_speed": "rad/s",
        "output_angle": "rad",
        "output_speed": "rad/s",
        "load_torque": "N m",
    }
    pins: dict[str, str] = {}
    if design.ring.has_pin_bodies:
        units = {"x": "m", "y": "m", "angle": "rad", "speed": "rad/s"}
        for i in range(1, design.ring.teeth + 1):
            pins |= {column(pin(i), quantity): unit for quantity, unit in units.items()}
    return {REDUCER: reducer, PINS: pins} if pins else {REDUCER: reducer}
