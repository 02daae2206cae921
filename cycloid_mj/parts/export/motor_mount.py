"""Choice of the motor's flange on its cover, and of the screws that hold the motor."""

from cycloid_mj.base.errors import DesignError
from cycloid_mj.design import stock
from cycloid_mj.parts.export.casing_rules import (
    RULES,
    counterbore,
    hole_depth,
    is_plastic,
    min_grip,
    stock_screw_length,
    thickest_bolt,
    thread_radius,
)
from cycloid_mj.parts.export.motors import MOTORS, MotorFlange, MotorName, frames_for
from cycloid_mj.reducer import Reducer

COAXIAL_REMEDY = "drive a hollow crank by a belt or a frameless motor around it, with --motor circle or auto"
"""What to choose instead of a motor on the axis of a hollow crank."""

Motor = MotorName | MotorFlange
"""The name of a motor's interface, or an interface of one's own."""


def choose_motor_flange(
    reducer: Reducer, motor: Motor, outer: float, seat: float, wall: float, max_cavity: float
) -> MotorFlange:
    """Choose the flange for a motor on its cover: the requested one, the smallest NEMA frame, or a bolt circle.

    Parameters
    ----------
    motor
        Motor; ``auto`` is the smallest NEMA frame that fits and is strong enough for torque and speed of the design, or
        a bolt circle if there is none.
    outer, seat, max_cavity
        Radii of the cover, of the seat of the shaft bearing, and of the largest cavity for the heads of screws from
        within [m].
    wall
        Minimum wall [m].

    Raises
    ------
    DesignError
        The requested flange does not fit.
    """

    def describe_misfits(flange: MotorFlange) -> list[str]:
        return _describe_misfits(reducer, flange, outer, seat, wall, max_cavity)

    drive = reducer.design.drive
    if motor == "auto":
        flange = next((frame for frame in frames_for(drive.torque, drive.speed) if not describe_misfits(frame)), None)
    else:
        flange = motor if isinstance(motor, MotorFlange) else MOTORS.get(motor)
    if flange and (problems := describe_misfits(flange)):
        raise DesignError(f"the motor flange {flange.name} does not fit: {'; '.join(problems)}. Choose another motor")
    if flange:
        return flange
    thread = thickest_bolt(RULES.thread_share * outer, inserted=is_plastic(reducer)).thread
    circle = outer - thread_radius(reducer, thread) - 2.0 * wall
    return MotorFlange("bolt circle", max(0.6 * circle, min(seat, circle - thread)), circle, thread)


def explain_bolt_circle(reducer: Reducer, outer: float, seat: float, wall: float, max_cavity: float) -> str:
    """Return why the smallest NEMA frame that is strong enough does not fit, in brackets; empty if one fits or none is.

    The arguments are those of `choose_motor_flange`.
    """
    drive = reducer.design.drive
    frames = frames_for(drive.torque, drive.speed)
    misfits = [_describe_misfits(reducer, frame, outer, seat, wall, max_cavity) for frame in frames]
    return f" ({frames[0].name}: {misfits[0][0]})" if misfits and all(misfits) else ""


def _describe_misfits(
    reducer: Reducer, flange: MotorFlange, outer: float, seat: float, wall: float, max_cavity: float
) -> list[str]:
    """Return the reasons why a motor flange does not fit, as clauses; empty if it fits.

    `outer`, `seat` and `max_cavity` are the radii of the cover, of the seat of the shaft bearing, and of the largest
    cavity for the heads of screws from within [m]; `wall` is the minimum wall [m].
    """
    problems, crank_radius = [], reducer.design.shaft.radius
    hole_radius = counterbore(thickest_bolt(flange.thread)) if flange.tapped else thread_radius(reducer, flange.thread)
    if reducer.design.shaft.bore_radius and (flange.shaft or flange in MOTORS.values()):
        problems.append(f"it closes the through bore of the crank: {COAXIAL_REMEDY}")
    if reducer.design.shaft.retaining_rings and flange.tapped:
        problems.append("it hides the retaining ring of the crank, which is put on after the cover")
    needed_radius, available_radius = (
        (motor_heads_end(flange), max_cavity) if flange.tapped else (flange.circle + hole_radius + wall, outer)
    )
    if needed_radius > available_radius:
        subject = "its screw heads need" if flange.tapped else "it needs a cover with"
        sizes = f"{1e3 * needed_radius:.4g} mm, but only {1e3 * available_radius:.4g} mm"
        problems.append(f"{subject} a radius of {sizes} is available")
    if flange.circle - hole_radius - wall < seat:
        sizes = f"{2e3 * (flange.circle - hole_radius - wall):.4g} mm, but the bearing has {2e3 * seat:.4g} mm"
        problems.append(f"it needs a shaft bearing with an outside diameter of at most {sizes}")
    if flange.shaft > crank_radius - 2.0 * wall:
        sizes = (
            f"{2e3 * (flange.shaft + 2.0 * wall):.4g} mm around the motor shaft, but it has {2e3 * crank_radius:.4g} mm"
        )
        problems.append(f"it needs a crank with a diameter of at least {sizes}")
    return problems


def motor_screw(motor: MotorFlange, wall: float) -> tuple[stock.Bolt, float]:
    """Return bolt and length [m] of screws from within the cover into a tapped motor, by one thread diameter."""
    bolt = thickest_bolt(motor.thread)
    return bolt, stock_screw_length(bolt, min_grip(bolt, wall) + motor.thread)


def motor_heads_end(motor: MotorFlange) -> float:
    """Compute the minimum radius of a cavity with the counterbores of the motor screws in its floor [m]."""
    return motor.circle + counterbore(thickest_bolt(motor.thread)) + RULES.head_play


def motor_grip(motor: MotorFlange, wall: float) -> float:
    """Compute the thickness of the cover under the heads of the motor screws [m]."""
    _, length = motor_screw(motor, wall)
    return length - motor.thread


def motor_floor_thickness(reducer: Reducer, motor: MotorFlange, wall: float) -> float:
    """Compute the thickness of the cover behind its cavity that the motor screws need [m]."""
    if motor.tapped:
        return motor_grip(motor, wall) + thickest_bolt(motor.thread).head_height
    return hole_depth(reducer, motor.thread, RULES.engagement * motor.thread) + wall
