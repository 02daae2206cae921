"""The frozen ``Design``: every input of the project, in SI units; the defaults are the paper's pin reducer."""

from typing import Literal

from pydantic import BaseModel, ConfigDict

from cycloid_mj.design import units as u
from cycloid_mj.design.units import PAPER, choice, quantity


class Section(BaseModel):
    """One table of the design file."""

    model_config = ConfigDict(frozen=True, extra="forbid", validate_default=False)


class Ring(Section):
    """The ring that the cycloid gear rolls in: free pins in a pinwheel, or a double-enveloping internal gear."""

    kind: Literal["pin", "nonpin"] = choice("pin", "pin: free pins in a pinwheel; nonpin: internal gear", PAPER)
    teeth: int = quantity(36, "ring teeth N (the gear has N - 1 lobes, the ratio is N - 1)", source=PAPER, ge=4, le=400)
    pin_circle_radius: float = quantity(40.75, "pin-circle radius E", u.MILLIMETRE, PAPER, ge=0.001, le=5000.0)
    pin_radius: float = quantity(2.25, "pin radius rho", u.MILLIMETRE, PAPER, ge=0.001, le=1000.0)
    pins: Literal["free", "fixed"] = choice(
        "free", "free: they float and turn in their sockets; fixed: pressed in", PAPER
    )


class Gear(Section):
    """The cycloid gear."""

    eccentricity: float = quantity(1.0, "eccentricity c of the cam", u.MILLIMETRE, PAPER, ge=0.001, le=500.0)
    face_width: float = quantity(10.0, "face width of gear, pins and ring", u.MILLIMETRE, ge=0.001, le=1000.0)
    bore_radius: float = quantity(
        15.0, "radius of the cam (the gear's bore adds the clearance)", u.MILLIMETRE, ge=0.001, le=5000.0
    )


class Output(Section):
    """The output disc, its pins and the holes of the gear that they run in."""

    pins: int = quantity(8, "number of output pins and holes", ge=2, le=100)
    pin_radius: float = quantity(4.0, "radius of an output pin", u.MILLIMETRE, ge=0.001, le=5000.0)
    pin_circle_radius: float = quantity(
        26.0, "radius of the circle of output pins and holes", u.MILLIMETRE, ge=0.001, le=5000.0
    )
    hole_radius: float = quantity(
        5.0, "radius of a hole without its clearance: output pin + eccentricity", u.MILLIMETRE, ge=0.001, le=5000.0
    )
    disc_thickness: float = quantity(8.0, "thickness of the output disc", u.MILLIMETRE, ge=0.001, le=5000.0)


class Shaft(Section):
    """The eccentric input shaft with its counterweight."""

    radius: float = quantity(8.0, "radius of the input shaft", u.MILLIMETRE, ge=0.001, le=5000.0)
    length: float = quantity(30.0, "length of the input shaft before the gear", u.MILLIMETRE, ge=0.001, le=5000.0)
    counterweight_radius: float = quantity(
        30.0, "outer radius of the half-disc counterweight", u.MILLIMETRE, ge=0.001, le=5000.0
    )


class Housing(Section):
    """The housing that carries the pinwheel or is the internal gear."""

    outer_radius: float = quantity(
        50.0, "outer radius of the pinwheel or internal gear", u.MILLIMETRE, ge=0.001, le=5000.0
    )


class Clearance(Section):
    """Normal clearance of each mating pair (the paper's tolerance of 0.001 mm)."""

    pin_gear: float = quantity(1.0, "between a centred pin and the gear", u.MICROMETRE, PAPER, gt=0.0, le=1000.0)
    pin_socket: float = quantity(1.0, "between a free pin and its socket", u.MICROMETRE, PAPER, gt=0.0, le=1000.0)
    tooth: float = quantity(1.0, "between the gear and the internal gear", u.MICROMETRE, PAPER, gt=0.0, le=1000.0)
    cam: float = quantity(1.0, "between the cam and the gear's bore", u.MICROMETRE, PAPER, gt=0.0, le=1000.0)
    output: float = quantity(1.0, "between an output pin and its hole", u.MICROMETRE, PAPER, gt=0.0, le=1000.0)


class Friction(Section):
    """Coulomb friction coefficient of each mating pair."""

    pin_gear: float = quantity(0.05, "pin on gear (lubricated steel)", ge=0.0, le=2.0)
    pin_socket: float = quantity(0.05, "pin in its socket", ge=0.0, le=2.0)
    tooth: float = quantity(0.05, "gear on internal gear", ge=0.0, le=2.0)
    cam: float = quantity(0.0, "cam in the gear's bore (a rolling bearing: its friction is left out)", ge=0.0, le=2.0)
    output: float = quantity(0.0, "output pin in its hole (with rollers: their friction is left out)", ge=0.0, le=2.0)


class ContactLaw(Section):
    """Stiffness and damping of the line contacts."""

    stiffness_law: Literal["local", "uniform"] = choice(
        "local", "local: follows the relative curvature along the tooth; uniform: a pin on a flat everywhere"
    )
    stiffness: float = quantity(
        0.0, "stiffness of a pin on a flat; 0: from material and working force", u.NEWTON_PER_METRE, ge=0.0, le=1e12
    )
    working_force: float = quantity(
        100.0, "force at which a line contact has its secant stiffness", u.NEWTON, gt=0.0, le=1e6
    )
    cam_rollers: int = quantity(20, "rollers of the cam's bearing, which share its load (Stribeck)", ge=3, le=1000)
    damping_ratio: float = quantity(
        0.5, "damping of a contact as a share of critical (0.5: restitution 0.3, lubricated)", gt=0.0, le=2.0
    )
    creep_speed: float = quantity(
        20.0,
        "sliding speed at which friction is whole under the working force",
        u.MILLIMETRE_PER_SECOND,
        gt=0.0,
        le=1e4,
    )
    max_penetration: float = quantity(50.0, "a contact deeper than this ends the run", u.MICROMETRE, gt=0.0, le=1000.0)


class Material(Section):
    """The steel of every part (the paper's Table 1)."""

    youngs_modulus: float = quantity(210000.0, "Young's modulus", u.MEGAPASCAL, PAPER, ge=100.0, le=2e6)
    poisson: float = quantity(0.3, "Poisson's ratio", ge=0.0, lt=0.5)
    density: float = quantity(7850.0, "density", u.DENSITY, gt=100.0, le=25000.0)
    tensile_strength: float = quantity(723.1, "tensile strength", u.MEGAPASCAL, PAPER, gt=0.0, le=1e5)
    yield_strength: float = quantity(620.4, "yield strength", u.MEGAPASCAL, PAPER, gt=0.0, le=1e5)


class Drive(Section):
    """The motor and the law of the crank: a linear ramp, then constant speed."""

    power: float = quantity(0.18, "rated input power", u.KILOWATT, PAPER, gt=0.0, le=1e5)
    torque: float = quantity(1.048, "rated input torque", u.NEWTON_METRE, PAPER, gt=0.0, le=1e6)
    speed: float = quantity(1640.0, "crank speed after the ramp", u.RPM, PAPER, gt=-1e5, lt=1e5)
    ramp: float = quantity(1.0, "duration of the linear ramp from rest", u.SECOND, ge=0.0, le=1000.0)
    hold: float = quantity(0.25, "duration at constant speed after the ramp", u.SECOND, gt=0.0, le=1000.0)
    rotor_inertia: float = quantity(1e-4, "inertia of the motor's rotor on the crank", u.INERTIA, ge=0.0, le=100.0)


class Load(Section):
    """The load on the output disc."""

    torque: float = quantity(0.0, "constant torque against the output's rotation", u.NEWTON_METRE, ge=-1e6, le=1e6)
    rise: float = quantity(0.005, "time over which the load comes on, without a jolt", u.SECOND, gt=0.0, le=1000.0)


class Environment(Section):
    """What acts on every part."""

    gravity_x: float = quantity(0.0, "gravity along x", u.ACCELERATION, PAPER, ge=-1000.0, le=1000.0)
    gravity_y: float = quantity(-9.8, "gravity along y", u.ACCELERATION, PAPER, ge=-1000.0, le=1000.0)


class Settings(Section):
    """How the design is simulated and logged."""

    timestep: float = quantity(1.0, "time step", u.MICROSECOND, gt=0.0, le=1000.0)
    log_rate: float = quantity(10000.0, "samples of every signal per second", u.HERTZ, gt=0.0, le=1e6)
    scene_rate: float = quantity(60.0, "3-D frames per second for viewers", u.HERTZ, gt=0.0, le=1e5)


class Design(Section):
    """One cycloidal reducer with its drive and load; all values in SI.

    The defaults are the paper's pin reducer (Hsieh 2014, section 3.1 and Table 1); what the paper leaves open
    is marked as assumed in the design file.
    """

    name: str = choice(
        "pin", "name of the design and its runs: letters, digits, space . _ -", source="", pattern=r"^\w[\w .-]{0,63}$"
    )
    ring: Ring = Ring()
    gear: Gear = Gear()
    output: Output = Output()
    shaft: Shaft = Shaft()
    housing: Housing = Housing()
    clearance: Clearance = Clearance()
    friction: Friction = Friction()
    contact: ContactLaw = ContactLaw()
    material: Material = Material()
    drive: Drive = Drive()
    load: Load = Load()
    environment: Environment = Environment()
    settings: Settings = Settings()

    @property
    def lobes(self) -> int:
        """Lobes of the cycloid gear, N - 1: the reduction ratio."""
        return self.ring.teeth - 1
