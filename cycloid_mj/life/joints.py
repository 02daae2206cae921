"""Joints: the torque at which each connection of a drive slips, shears or yields at an emergency stop.

The records of ``parts.export.joints`` state screws, dowels, keys and fits; ``parts.joint_strength`` has the formulas.
"""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.design import Material, fits, stock
from cycloid_mj.life.item import RatedItem, torque_item
from cycloid_mj.life.loading import Loading
from cycloid_mj.life.output_loads import crossed_roller_loads, output_bearing_forces, pair_thrust, preload
from cycloid_mj.life.rolling import magnitudes
from cycloid_mj.life.strength import pin_moment
from cycloid_mj.parts import joint_strength as strength
from cycloid_mj.parts import sleeve_core_radius
from cycloid_mj.parts.export.bearings import adhesive_of, output_pin_fit, sleeve_pin_depth, sleeve_pin_fit
from cycloid_mj.parts.export.cam_clamp import CamClamp, cam_clamp
from cycloid_mj.parts.export.cam_splines import cam_spline
from cycloid_mj.parts.export.casing import Casing, casing
from cycloid_mj.parts.export.casing_rules import (
    core_radius,
    in_one_piece,
    insert_in,
    is_printed,
)
from cycloid_mj.parts.export.crank_joints import ShrinkFit, shrink_fit
from cycloid_mj.parts.export.drive import has_casing
from cycloid_mj.parts.export.joint import BoughtPart, Joint, JointKind
from cycloid_mj.parts.export.joints import FLANGE_CLASS, LOAD, MOTOR, USUAL_CLASS, drive_joints
from cycloid_mj.parts.export.printing import part_material
from cycloid_mj.parts.joint_strength import JOINTS
from cycloid_mj.reducer import Reducer

GLUE_SOURCE = "pi d l tau r, tau 25 N/mm2 at 23 °C (ISO 10123); half of it at about 120 °C"
PLASTIC_GLUE_SOURCE = "pi d l tau r, tau 3 N/mm2 at 23 °C (two-part epoxy on plastics)"

_ZONES = re.compile(r"([A-Z]+\d+)|([a-z]+\d+)")


@dataclass(frozen=True)
class JointTorques:
    """Torques [N m] on the carrier of the output pins, the ring and the crank, of which one is the output."""

    carrier: float
    ring: float
    crank: float

    @classmethod
    def at_output(cls, reducer: Reducer, torque: float) -> "JointTorques":
        """Return the torques at an output torque [N m], without losses: ring over carrier is N over N - 1."""
        design, carrier = reducer.design, torque * reducer.member.share
        return cls(carrier, carrier * design.ring.teeth / design.lobes, torque / design.reduction)

    def torque_between(self, parts: Sequence[str]) -> float:
        """Return the torque [N m] that mating parts transmit to each other; `parts` are their names.

        It is the torque on the crank for joints of motor, shaft or cams, the torque on the carrier for joints of
        output, flange or driven machine, and the torque on the ring for all others.
        """
        if MOTOR in parts or names.SHAFT in parts or any(names.family(part) == names.CAM for part in parts):
            return self.crank
        return self.carrier if {names.OUTPUT, names.FLANGE, LOAD} & {*parts} else self.ring


@dataclass(frozen=True)
class ScrewLimit:
    """The torque [N m] of a screwed joint at the preload of each screw [N] that one of its parts withstands."""

    mechanism: str
    description: str
    preload: float
    torque: float
    source: str
    note: str


@dataclass(frozen=True)
class ScrewedJoint:
    """A screwed joint: screws, their number and circle radius [m], and the limits of their preload."""

    joint: Joint
    thread: strength.Thread
    property_class: str
    count: int
    radius: float
    limits: tuple[ScrewLimit, ...]

    @property
    def torque(self) -> float:
        """Torque at which the clamped faces slip [N m]."""
        return min(limit.torque for limit in self.limits)

    @property
    def preload(self) -> float:
        """Preload of each screw [N]."""
        return min(limit.preload for limit in self.limits)

    @property
    def tightening_torque(self) -> float:
        """Tightening torque of that preload [N m]."""
        return self.tightening_for(self.preload)

    def tightening_for(self, preload: float, friction: float = JOINTS.thread_friction) -> float:
        """Compute the tightening torque [N m] of a preload [N]."""
        return self.thread.tightening_torque(preload, _mean_head(self.thread), friction)

    @property
    def designation(self) -> str:
        """Number, thread and property class."""
        return f"{self.count} x M{1e3 * self.thread.diameter:g} {self.property_class}"


def rate_joints(reducer: Reducer, peak_torque: float, loading: Loading) -> Iterator[RatedItem]:
    """Yield safety factors of all joints of a drive (screws, dowels, keys, glue, press fits) at the peak output torque.

    `peak_torque` is in [N m]. For each joint, the torque on it [N m] is compared with the torque at which it slips,
    shears or yields; for the holes of the output pins, pressures [MPa] are compared. Forces on pins are scaled from
    those of a solved `loading`, in proportion to the torque.
    """
    torques = JointTorques.at_output(reducer, peak_torque)
    force_scale = peak_torque / abs(loading.point.torque)
    if has_casing(reducer):
        yield from _rate_faces(reducer, torques)
        yield from _rate_crank(reducer, torques)
        yield from _rate_retainer(reducer, loading, force_scale)
        yield from _rate_second_disc(reducer, loading, force_scale)
    yield from _rate_output_pins(reducer, loading, force_scale)
    yield from _rate_ring_pins(reducer, loading, force_scale)


def screwed_joints(reducer: Reducer) -> tuple[ScrewedJoint, ...]:
    """Return the screwed joints of a drive with covers."""
    drive_casing = casing(reducer)
    joints = drive_joints(reducer, drive_casing)
    return tuple(
        _make_screwed_joint(reducer, drive_casing, joint) for joint in joints if joint.kind is JointKind.SCREWED
    )


def tightening_torques(reducer: Reducer) -> dict[str, float]:
    """Return the tightening torques [N m] of the screws of a drive, by bought part, such as "flange_screw"."""
    clamp = cam_clamp(reducer)
    torques = {names.CAM_SCREW: _clamp_tightening(reducer, clamp)} if clamp else {}
    for screwed_joint in screwed_joints(reducer):
        if MOTOR in screwed_joint.joint.parts:
            torques[names.MOTOR_SCREW] = screwed_joint.tightening_torque
    return torques | {
        part.item: screwed_joint.tightening_torque
        for screwed_joint in screwed_joints(reducer)
        for part in screwed_joint.joint.bought
        if "thread" in dict(part.dimensions)
    }


def _rate_faces(reducer: Reducer, torques: JointTorques) -> Iterator[RatedItem]:
    """Yield the safety factors of screws and dowels at each clamped face, and of a ring clamped between the covers.

    If a face has screws and dowels, the limit is the larger of their torques, not the sum. `torques` are the torques on
    crank, carrier and ring at the peak torque of the output.
    """
    joints, screw_joints = drive_joints(reducer, casing(reducer)), screwed_joints(reducer)
    dowel_torques = {joint: _dowel_torque(reducer, joint) for joint in joints if joint.kind is JointKind.DOWELLED}
    dowel_torque_by_face = {frozenset(joint.parts): dowel_limit for joint, dowel_limit in dowel_torques.items()}
    cover_names = {names.MOTOR_COVER, names.OUTPUT_COVER}
    cover_joint = next(
        (screwed_joint for screwed_joint in screw_joints if {*screwed_joint.joint.parts} == cover_names), None
    )
    ring_slip_torque = _ring_slip_torque(reducer, cover_joint) if cover_joint else 0.0
    for screwed_joint in screw_joints:
        parts = screwed_joint.joint.parts
        if names.RETAINER in parts:
            continue  # it transmits no torque
        part_chain = (names.MOTOR_COVER, names.HOUSING, names.OUTPUT_COVER) if {*parts} == cover_names else parts
        dowel_torque = min(dowel_torque_by_face.get(frozenset(face), 0.0) for face in pairwise(part_chain))
        common_note = f"; tighten with {screwed_joint.tightening_torque:.3g} N m"
        common_note += f"; dowels transmit {dowel_torque:.3g} N m without friction" if dowel_torque else ""
        for limit in screwed_joint.limits:
            yield torque_item(
                f"{_slug(screwed_joint.joint)}_{limit.mechanism}",
                f"{screwed_joint.joint.name}, {limit.description}",
                torques.torque_between(parts),
                max(limit.torque, dowel_torque),
                limit.source,
                limit.note + common_note,
            )
    for joint, dowel_limit in dowel_torques.items():
        (part,) = joint.bought
        friction_torques = [
            screwed_joint.torque for screwed_joint in screw_joints if {*joint.parts} <= {*screwed_joint.joint.parts}
        ]
        friction_torque = max(friction_torques, default=ring_slip_torque if names.HOUSING in joint.parts else 0.0)
        friction_note = f"; screws transmit {friction_torque:.3g} N m by friction" if friction_torque else ""
        yield torque_item(
            _slug(joint),
            joint.name,
            torques.torque_between(joint.parts),
            max(dowel_limit, friction_torque),
            f"n F r, F least of shear, pi d^2/4 x 896 MPa (ASME B18.8.2), and {_hole_source(reducer, joint)}",
            f"{len(part.origins)} x {part.designation}{friction_note}",
        )
    if cover_joint:
        ring_dowel_torques = [
            dowel_limit for joint, dowel_limit in dowel_torques.items() if names.HOUSING in joint.parts
        ]
        yield _rate_clamped_ring(reducer, torques.ring, cover_joint, max(ring_dowel_torques, default=0.0))


def retainer_joint(reducer: Reducer) -> ScrewedJoint:
    """Return the screwed joint of the retainer of a drive with a crossed roller bearing."""
    return next(
        screwed_joint for screwed_joint in screwed_joints(reducer) if names.RETAINER in screwed_joint.joint.parts
    )


def flange_joint(reducer: Reducer) -> ScrewedJoint:
    """Return the screwed joint of output flange and hub, through which a tilting moment on the flange passes."""
    return next(joint for joint in screwed_joints(reducer) if set(joint.joint.parts) == {names.OUTPUT, names.FLANGE})


def gaping_moment(screwed_joint: ScrewedJoint) -> float:
    """Compute the tilting moment [N m] at which the most loaded of n screws on a circle loses its preload: n F d/4."""
    return 0.5 * screwed_joint.count * screwed_joint.preload * screwed_joint.radius


def _rate_retainer(reducer: Reducer, loading: Loading, force_scale: float) -> Iterator[RatedItem]:
    """Rate the screws of a bearing retainer: tilting moment against that at which the outer ring lifts off.

    The retainer clamps the outer ring of the crossed roller bearing; discs and shaft exert the tilting moment on this
    bearing. `force_scale` [1] multiplies the forces of `loading`. Yields nothing for a pair of ball bearings.
    """
    if casing(reducer).retainer is None:
        return
    retainer = retainer_joint(reducer)
    _, moment = crossed_roller_loads(reducer, loading)
    yield torque_item(
        f"{_slug(retainer.joint)}_gap",
        f"{retainer.joint.name}, gaping of the clamped outer ring",
        force_scale * float(moment.max()),
        gaping_moment(retainer),
        "M = n F d/4 (VDI 2230, screws on a circle)",
        f"tilting moment of the drive's own forces; {retainer.designation} on a circle of "
        f"{2e3 * retainer.radius:.4g} mm with {1e-3 * retainer.preload:.3g} kN each; tighten with "
        f"{retainer.tightening_torque:.3g} N m",
    )


def _rate_clamped_ring(
    reducer: Reducer, ring_torque: float, cover_screws: ScrewedJoint, dowel_torque: float
) -> RatedItem:
    """Rate a ring that is clamped between covers whose screws are outside of it: torque on it against its slip torque.

    `ring_torque` acts on the ring; `dowel_torque` is the torque that its dowels transmit without friction, both [N m].
    `cover_screws` are the screws that clamp it.
    """
    slip_torque = _ring_slip_torque(reducer, cover_screws)
    dowel_note = f"; dowels transmit {dowel_torque:.3g} N m" if dowel_torque else ""
    return torque_item(
        "joint_ring",
        "ring between the covers, slip",
        ring_torque,
        max(slip_torque, dowel_torque),
        "T = n F mu r (VDI 2230, R2/2)",
        f"assumed: the rims of the covers stand back, so that {cover_screws.designation} clamp the ring with "
        f"{1e-3 * cover_screws.preload:.3g} kN each at its mean radius, friction "
        f"{JOINTS.interface_friction:g}{dowel_note}",
    )


def _ring_slip_torque(reducer: Reducer, cover_screws: ScrewedJoint) -> float:
    """Compute the torque [N m] at which a ring slips that screws outside of it clamp at its mean radius: n F mu r."""
    radius = 0.5 * (reducer.design.ring_root_radius + reducer.design.housing.outer_radius)
    return strength.friction_torque(cover_screws.count, cover_screws.preload, radius)


def _make_screwed_joint(reducer: Reducer, drive_casing: Casing, joint: Joint) -> ScrewedJoint:
    """Return a screwed joint with its thread, property class, circle radius [m] and preload limits.

    `joint` are the parts and screws, `drive_casing` are the covers of the drive. Screws of motor and driven machine are
    not in the bill of materials: their property classes are assumed.
    """
    screw = next((part for part in joint.bought if "thread" in dict(part.dimensions)), None)
    centres = np.array(screw.origins)[:, :2] if screw else np.atleast_2d(joint.holes[0][1][0])
    nominal_diameter = dict(screw.dimensions)["thread"] if screw else _foreign_thread(drive_casing, joint)
    thread = strength.Thread(nominal_diameter, stock.pitch(nominal_diameter))
    assumed_class = FLANGE_CLASS if LOAD in joint.parts else USUAL_CLASS
    property_class = screw.material.split()[-1] if screw else assumed_class
    screwed_joint = ScrewedJoint(joint, thread, property_class, len(centres), float(np.hypot(*centres.T).mean()), ())
    limits = (_screw_limit(screwed_joint), *_face_limits(reducer, screwed_joint, screw))
    return replace(screwed_joint, limits=limits)


def _foreign_thread(drive_casing: Casing, joint: Joint) -> float:
    return drive_casing.motor.thread if MOTOR in joint.parts else drive_casing.flange_bolt.thread


def _screw_limit(screwed_joint: ScrewedJoint) -> ScrewLimit:
    """Return the preload of each screw [N] and the slip torque [N m] of a joint, as its screws allow (VDI 2230).

    The preload is usual for their property class. The note of the result states the range of the torque over the
    assumed friction. `screwed_joint` has the dimensions of the joint.
    """
    preload = screwed_joint.thread.usual_preload(strength.PROOF_STRESS[screwed_joint.property_class])
    torque = strength.friction_torque(screwed_joint.count, preload, screwed_joint.radius)
    usual_tightening = screwed_joint.tightening_for(1.0)
    low_friction_factor, high_friction_factor = (
        usual_tightening / screwed_joint.tightening_for(1.0, friction) for friction in JOINTS.thread_friction_spread
    )
    low_face_factor, high_face_factor = (
        friction / JOINTS.interface_friction for friction in JOINTS.interface_friction_spread
    )
    return ScrewLimit(
        "slip",
        "slip",
        preload,
        torque,
        "T = n F mu r, F = 0.7 R_p A_s (VDI 2230, R2/2, R13)",
        f"{screwed_joint.designation} on a circle of {2e3 * screwed_joint.radius:.4g} mm, {1e-3 * preload:.3g} kN "
        f"each; assumed: friction {JOINTS.interface_friction:g} of the faces and {JOINTS.thread_friction:g} of "
        f"threads and heads; {torque * high_friction_factor * low_face_factor:.3g} to "
        f"{torque * low_friction_factor * high_face_factor:.3g} N m with "
        "0.10 to 0.20 for faces and 0.16 to 0.10 for threads and heads",
    )


def _face_limits(reducer: Reducer, screwed_joint: ScrewedJoint, screw: BoughtPart | None) -> Iterator[ScrewLimit]:
    """Yield the limits of a screwed joint by its clamped parts: pressure under heads, and strength of threads.

    Each has the preload of a screw [N] and the slip torque of the joint [N m] that the part allows. `screw` is the
    bought screw of the joint; None if it is not in the bill of materials.
    """
    nominal_diameter, joint = screwed_joint.thread.diameter, screwed_joint.joint
    screw_top = screw.origins[0][2] if screw else math.inf
    screw_bottom = screw_top - dict(screw.dimensions)["length"] if screw else -math.inf
    washer = next((dict(part.dimensions)["length"] for part in joint.bought if part.item == names.FLANGE_WASHER), 0.0)
    for part, (_, radius, hole_start, hole_end) in joint.holes:
        material = _material(reducer, part)
        if math.isclose(radius, 0.5 * stock.bolt_hole(nominal_diameter)) and math.isclose(
            hole_end, screw_top - washer, abs_tol=1e-9
        ):
            yield _head_limit(screwed_joint, part, material, washer)
        elif math.isclose(radius, core_radius(reducer, nominal_diameter)):
            insert = insert_in(reducer, nominal_diameter)
            engaged_length = min(hole_end, screw_top) - max(hole_start, screw_bottom)
            yield _thread_limit(screwed_joint, part, material, insert, engaged_length)


def _head_limit(screwed_joint: ScrewedJoint, part: str, material: Material, washer_thickness: float) -> ScrewLimit:
    """Return the limit of a screwed joint by the pressure under the heads of its screws, or under washers.

    It has the preload of each screw [N] and the slip torque [N m]. `part` is the name of the part under the heads,
    `material` its material, `washer_thickness` [m] is 0 without washers.
    """
    nominal_diameter = screwed_joint.thread.diameter
    bearing_diameter, hole_diameter = stock.head_bearing(nominal_diameter), stock.bolt_hole(nominal_diameter)
    if washer_thickness:
        bearing_diameter = strength.washer_bearing(
            bearing_diameter, washer_thickness, stock.washer_of(nominal_diameter).outside
        )
    allowed_pressure = _permanent_share(material) * material.tensile_strength
    preload = allowed_pressure / strength.head_pressure(1.0, bearing_diameter, hole_diameter)
    return ScrewLimit(
        "heads",
        "pressure under the heads",
        preload,
        strength.friction_torque(screwed_joint.count, preload, screwed_joint.radius),
        "p = F/A <= R_m (VDI 2230, R10/1 and A9), T = n F mu r",
        f"{part} of {material.name or 'unnamed material'} withstands {1e-6 * allowed_pressure:.3g} MPa under a "
        f"{'washer' if washer_thickness else 'head'}, "
        f"{1e-3 * preload:.3g} kN{_creep_note(material)}",
    )


def _thread_limit(
    screwed_joint: ScrewedJoint, part: str, material: Material, insert: stock.Insert | None, engaged_length: float
) -> ScrewLimit:
    """Return the limit of a screwed joint by stripping of its threads, or by pull-out of an insert.

    It has the preload of each screw [N] and the slip torque [N m]. `part` is the name of the part with the threads,
    `material` its material; `insert` is None if they are cut in the part. `engaged_length` [m] is the engaged length of
    the threads.
    """
    shear_strength = (
        JOINTS.plastic_shear * material.yield_strength
        if material.is_plastic
        else JOINTS.metal_shear * material.tensile_strength
    )
    if insert:
        force = strength.pull_out_force(insert.hole, insert.length, shear_strength)
        description, source = "pull-out of the inserts", "F = pi D l tau around an insert"
        note = f"inserts {insert.designation} in {part}, solid around them (assumed)"
    else:
        force = screwed_joint.thread.stripping_force(engaged_length, shear_strength)
        description, source = "stripping of the threads", "F = pi d m (0.5 + (d - d2)/(P sqrt 3)) tau (VDI 2230, 5.5.5)"
        note = f"threads in {part}, {1e3 * engaged_length:.3g} mm engaged"
    preload = _permanent_share(material) * force
    return ScrewLimit(
        "threads",
        description,
        preload,
        strength.friction_torque(screwed_joint.count, preload, screwed_joint.radius),
        f"{source}, T = n F mu r",
        f"{note}, of {material.name or 'unnamed material'}, shear strength {1e-6 * shear_strength:.3g} MPa: "
        f"{1e-3 * preload:.3g} kN{_creep_note(material)}",
    )


def _permanent_share(material: Material) -> float:
    """Return the share of a short-time strength [1] that a preload may use permanently; plastics creep."""
    return JOINTS.plastic_preload if material.is_plastic else 1.0


def _creep_note(material: Material) -> str:
    return ", half of the strength, as plastics creep (assumed)" if material.is_plastic else ""


def _mean_head(thread: strength.Thread) -> float:
    """Return the mean diameter of the bearing face of a head [m]."""
    return 0.5 * (stock.head_bearing(thread.diameter) + stock.bolt_hole(thread.diameter))


def _hole_source(reducer: Reducer, joint: Joint) -> str:
    """Return the formula of the force at which the holes of a dowel yield, with its source."""
    if any(_material(reducer, part).is_plastic for part in joint.parts):
        return "tilting in holes of plastic, 0.414 d s R_e (Johansen, EN 1995-1-1, 8.6)"
    return "yield of the hole, d s R_e (Roloff/Matek)"


def _dowel_torque(reducer: Reducer, joint: Joint) -> float:
    """Compute the torque [N m] that the dowels of a `joint` transmit: the sum of dowel force times radius.

    The force is that at which a dowel shears or its hole yields; in plastic parts it is that at which the dowel shears,
    or tilts in both holes.
    """
    (part,) = joint.bought
    materials = [_material(reducer, name) for name in joint.parts]
    strengths = [material.yield_strength for material in materials]
    if any(material.is_plastic for material in materials):
        force = strength.tilting_dowel_force(joint.diameter, (joint.length, joint.length), (strengths[0], strengths[1]))
    else:
        force = strength.dowel_force(joint.diameter, joint.length, min(strengths))
    return force * float(np.hypot(*np.array(part.origins).T[:2]).sum())


def _rate_crank(reducer: Reducer, torques: JointTorques) -> Iterator[RatedItem]:
    """Rate the joints of the crank: the motor's shaft glued into its bore, and cams on the shaft.

    `torques` are the torques on crank, carrier and ring at the peak torque of the output.
    """
    drive_casing, shaft_diameter = casing(reducer), 2.0 * reducer.design.shaft.radius
    motor_bore, cam_shrink_fit = drive_casing.motor_bore, shrink_fit(reducer, drive_casing)
    if motor_bore:
        radius, bore_start, bore_end = motor_bore
        yield _rate_glued_shaft(
            reducer,
            ("joint_motor_shaft", "motor shaft in the crank, glued"),
            torques.crank,
            2.0 * radius,
            bore_end - bore_start,
        )
    for joint in drive_joints(reducer, drive_casing):
        if joint.kind is JointKind.KEYED:
            yield _rate_key(reducer, joint, torques.crank, shaft_diameter)
        elif cam_shrink_fit and joint.kind is JointKind.PRESSED and names.SHAFT in joint.parts:
            yield _rate_shrunk_cams(joint.name, torques.crank, cam_shrink_fit)
        elif joint.kind is JointKind.SPLINED:
            yield _rate_splined_cams(reducer, joint, torques.crank)
        elif joint.kind is JointKind.CLAMPED:
            yield _rate_clamped_cams(reducer, joint, torques.crank)
        elif joint.kind is JointKind.GLUED and names.SHAFT in joint.parts:
            key_and_name = "joint_cams", f"{joint.name}, glued"
            yield _rate_glued_shaft(reducer, key_and_name, torques.crank, joint.diameter, joint.length)


def _rate_glued_shaft(
    reducer: Reducer, key_and_name: tuple[str, str], torque: float, diameter: float, length: float
) -> RatedItem:
    """Rate a glued cylindrical joint of the crank: `torque` [N m] against the torque at which the glue shears.

    `key_and_name` are key and name of the rated item, `diameter` and `length` [m] are those of the joint.
    """
    on_plastic = _material(reducer, names.SHAFT).is_plastic
    slip_torque = 0.5 * diameter * strength.glued_force(diameter, length, on_plastic)
    size_text = f"{1e3 * diameter:.4g} x {1e3 * length:.4g} mm"
    note = f"assumed: {adhesive_of(on_plastic)} on {size_text}; no key or clamp is drawn"
    return torque_item(*key_and_name, torque, slip_torque, PLASTIC_GLUE_SOURCE if on_plastic else GLUE_SOURCE, note)


def _rate_shrunk_cams(name: str, torque: float, cam_fit: ShrinkFit) -> RatedItem:
    """Rate the shrink fit of the cams on the shaft: `torque` [N m] against the slip torque of a single cam.

    `cam_fit` has the dimensions of the shrink fit, `name` is the name of the item without the kind of fit.
    """
    press_fit = cam_fit.press
    item = _press_fit_item(("joint_cams", f"{name}, shrunk"), torque, press_fit, cam_fit.zones, cam_fit.yield_pressure)
    max_interference = -fits.clearances(cam_fit.zones, press_fit.diameter)[0]
    growth = press_fit.growth(min(press_fit.pressure(max_interference), cam_fit.yield_pressure))
    wall = 0.5 * (press_fit.outside - press_fit.diameter)
    note = (
        f"{item.note}; thinnest wall {1e3 * wall:.3g} mm; the cam grows by up to {1e6 * growth:.2g} um in diameter: "
        "grind it smaller by as much; assumed: one cam carries the whole torque"
    )
    return replace(item, note=note)


def _rate_splined_cams(reducer: Reducer, joint: Joint, torque: float) -> RatedItem:
    """Rate the `joint` of cams on a splined shaft: `torque` [N m] on a cam against the limit of the spline's flanks.

    The limit is by Roloff/Matek.
    """
    spline = cam_spline(reducer)
    assert spline is not None
    spline_hub = strength.StraightSpline(spline.count, spline.minor, spline.major, joint.length)
    min_yield_strength = min(_material(reducer, part).yield_strength for part in joint.parts)
    return torque_item(
        "joint_cams",
        f"{joint.name}, splined",
        torque,
        spline_hub.torque(min_yield_strength),
        "p = 2 T/(d_m h l 0.75 n) <= R_e (Roloff/Matek 12.8)",
        f"{spline.designation}, h = {1e3 * spline_hub.flank_height:.3g} mm, {1e3 * joint.length:.3g} mm long, R_e "
        f"{1e-6 * min_yield_strength:.4g} MPa; assumed: one cam carries the whole torque",
    )


def _rate_clamped_cams(reducer: Reducer, joint: Joint, torque: float) -> RatedItem:
    """Rate the `joint` of cams clamped on the shaft by screws: `torque` [N m] on a cam against its slip torque."""
    clamp = cam_clamp(reducer)
    assert clamp is not None
    preload, limit_text = _clamp_preload(reducer, clamp)
    clearance = 0.5 * sum(fits.clearances(fit_code(joint.fit), joint.diameter))
    force, hub = clamp.count * preload, clamp.hub
    lost_share = hub.closing_moment(clearance) / (force * hub.screw_arm)
    return torque_item(
        "joint_cams",
        f"{joint.name}, clamped, slip",
        torque,
        hub.torque(force, clearance),
        "T = mu d (F l1 - M)/l2 (Roloff/Matek 12.3.4), F = 0.7 R_p A_s (VDI 2230)",
        f"{clamp.count} x {clamp.bolt.designation} 8.8 in each cam, {1e-3 * preload:.3g} kN each by {limit_text}; l1 = "
        f"{1e3 * hub.screw_arm:.3g} mm, l2 = {1e3 * hub.shaft_arm:.3g} mm; M = E I c/(2 l2^2) closes the mean "
        f"clearance c of {1e6 * clearance:.2g} um and takes {100.0 * lost_share:.2g} % of F; friction "
        f"{JOINTS.interface_friction:g} on two lines (assumed); tighten with {_clamp_tightening(reducer, clamp):.3g} "
        "N m; assumed: one cam carries the whole torque",
    )


def _clamp_thread(clamp: CamClamp) -> strength.Thread:
    return strength.Thread(clamp.bolt.thread, stock.pitch(clamp.bolt.thread))


def _clamp_tightening(reducer: Reducer, clamp: CamClamp) -> float:
    """Compute the tightening torque [N m] of a clamping screw at its preload."""
    thread = _clamp_thread(clamp)
    return thread.tightening_torque(_clamp_preload(reducer, clamp)[0], _mean_head(thread))


def _clamp_preload(reducer: Reducer, clamp: CamClamp) -> tuple[float, str]:
    """Return the preload of a clamping screw [N], limited by screw, thread or face, and which of them limits it."""
    thread, material = _clamp_thread(clamp), reducer.design.material_of(names.SHAFT)
    nominal_diameter = clamp.bolt.thread
    shear_strength = JOINTS.metal_shear * material.tensile_strength
    pressure_per_force = strength.head_pressure(
        1.0, stock.head_bearing(nominal_diameter), stock.bolt_hole(nominal_diameter)
    )
    limits = (
        (thread.usual_preload(strength.PROOF_STRESS[USUAL_CLASS]), "the screw"),
        (thread.stripping_force(clamp.engaged_length, shear_strength), "its thread in the cam"),
        (material.tensile_strength / pressure_per_force, "the face under its head"),
    )
    return min(limits)


def _rate_key(reducer: Reducer, joint: Joint, torque: float, shaft_diameter: float) -> RatedItem:
    """Rate the `joint` by a parallel key: `torque` [N m] against that of its permissible side pressure (DIN 6892 C).

    `shaft_diameter` is in [m].
    """
    (part,) = joint.bought
    key_sizes = dict(part.dimensions)
    key = strength.ParallelKey(key_sizes["height"], key_sizes["depth"], key_sizes["length"])
    min_yield_strength = min(_material(reducer, part_name).yield_strength for part_name in joint.parts)
    return torque_item(
        _slug(joint),
        joint.name,
        torque,
        key.torque(shaft_diameter, min_yield_strength),
        "p = 2 T/(d (h - t1) l) <= 0.9 R_e (DIN 6892, method C)",
        f"{part.designation}, {1e3 * key.carrying_length:.3g} mm carry, R_e {1e-6 * min_yield_strength:.4g} MPa",
    )


def _rate_output_pins(reducer: Reducer, loading: Loading, force_scale: float) -> Iterator[RatedItem]:
    """Rate the seats of the output pins in the output disc: pressure in the holes, and press fits against turning.

    `force_scale` [1] multiplies the forces of `loading`. Yields nothing for pins in one piece with the disc.
    """
    design, output = reducer.design, reducer.design.output
    if in_one_piece(reducer):
        return
    disc_material = _material(reducer, names.OUTPUT)
    force = force_scale * float(loading.output.sum(axis=1).max())
    moment = force_scale * float(pin_moment(reducer, loading.output).max())
    diameter, depth, yield_strength = 2.0 * output.root_radius, output.disc_thickness, disc_material.yield_strength
    if output.support == "cantilever":
        pressure, support_text = strength.clamped_pin_pressure(force, moment, diameter, depth), "clamped in its hole"
    else:
        pressure, support_text = 0.5 * force / (diameter * depth), "on two supports, half of the force on each"
    yield RatedItem(
        "joint_output_pin_hole",
        "output pin in its disc, pressure of the hole",
        1e-6 * pressure,
        1e-6 * yield_strength,
        "MPa",
        yield_strength / pressure if pressure else math.inf,
        None,
        "p = F/(d s) + 6 (M + F s/2)/(d s^2) <= R_e (Roloff/Matek 9.19)",
        f"pin of {1e3 * diameter:.4g} mm, {1e3 * depth:.4g} mm deep in {disc_material.name or 'the disc'}, "
        f"{support_text}; forces in proportion to the torque",
    )
    if not is_printed(reducer, names.OUTPUT):
        friction_torque = design.friction_of("output") * force * output.root_radius
        yield _rate_press_fit(
            reducer,
            ("joint_output_pin_press", "output pin in its disc, press fit against turning"),
            friction_torque,
            (output.root_radius, output.disc_thickness, names.OUTPUT, disc_material),
            output_pin_fit(reducer),
        )


def _rate_second_disc(reducer: Reducer, loading: Loading, force_scale: float) -> Iterator[RatedItem]:
    """Rate the press fits of all output pins in the second disc, which clamps a pair of bearings back to back.

    The axial force is the preload of the pair, or that of the radial forces of discs and shaft on its bearings, if this
    is larger. `force_scale` [1] multiplies the forces of `loading`. Yields nothing without a stop ring.
    """
    drive_casing, output = casing(reducer), reducer.design.output
    if drive_casing.stop_ring is None:
        return
    radial_load = force_scale * max(float(magnitudes(force).max()) for force in output_bearing_forces(reducer, loading))
    force, seat = pair_thrust(drive_casing.hub, radial_load), second_disc_seat(reducer)
    yield RatedItem(
        "joint_second_disc_axial",
        "second output disc on its pins, press fits against the bearings' axial force",
        force,
        seat.force,
        "N",
        seat.force / force,
        None,
        "F = n mu p pi d l (DIN 7190-1); preload, or F_r tan(a) J_a/J_r (Harris)",
        f"{output.pins} pins, {seat.description}; without a load on the flange; preload "
        f"{preload(drive_casing.hub):.3g} N, radial force {radial_load:.3g} N",
    )


@dataclass(frozen=True)
class AxialSeat:
    """Press fits under an axial force: the force that they transmit at mean interference [N], and the fit in words."""

    force: float
    description: str


def second_disc_seat(reducer: Reducer) -> AxialSeat:
    """Return the axial force at which the press fits of all output pins in the second disc slip, at mean interference.

    The description states the fit, and the range of the force over its tolerance zones.
    """
    output, zones = reducer.design.output, output_pin_fit(reducer)
    disc_material = _material(reducer, names.SECOND_OUTPUT)
    fit, max_pressure = _pin_press_fit(
        reducer, (output.root_radius, output.disc_thickness, names.OUTPUT, disc_material)
    )
    interference, (pressure, *end_pressures) = _fit_pressures(fit, zones, max_pressure)
    least_force, largest_force = (output.pins * fit.force(end_pressure) for end_pressure in end_pressures)
    return AxialSeat(
        output.pins * fit.force(pressure),
        f"{_describe_fit(zones, interference, pressure)}; {least_force:.3g} to {largest_force:.3g} N within the "
        f"tolerance zones; friction {JOINTS.interface_friction:g} (assumed)",
    )


def _rate_ring_pins(reducer: Reducer, loading: Loading, force_scale: float) -> Iterator[RatedItem]:
    """Rate the pressed or glued seat of a ring pin: friction torque on the pin against the torque at which it turns.

    `force_scale` [1] multiplies the forces of `loading`. Yields nothing for pins that turn in sockets or are printed.
    """
    design, ring = reducer.design, reducer.design.ring
    if ring.kind != "pin" or ring.has_sockets or is_printed(reducer, names.PIN):
        return
    force, seat_length = force_scale * loading.teeth, design.gear.stack_width / ring.halves
    if ring.has_sleeves:
        pin_core_radius, seat_length = sleeve_core_radius(reducer), 2.0 * sleeve_pin_depth(reducer)
        friction_torque = design.friction_of("pin_sleeve") * force * pin_core_radius
        yield _rate_press_fit(
            reducer,
            ("joint_ring_pin_press", "ring pin in both covers, press fit against turning"),
            friction_torque,
            (pin_core_radius, seat_length, names.PIN, _material(reducer, names.HOUSING)),
            sleeve_pin_fit(reducer),
        )
        return
    friction_torque = design.friction_of("pin_gear") * force * ring.pin_radius
    on_plastic = _material(reducer, names.HOUSING).is_plastic
    half_pin_torque = 0.5 * strength.glued_force(2.0 * ring.pin_radius, seat_length, on_plastic) * ring.pin_radius
    yield torque_item(
        "joint_ring_pin_glue",
        "fixed ring pin in its half-open socket, glued against turning",
        friction_torque,
        half_pin_torque,
        f"half of {PLASTIC_GLUE_SOURCE if on_plastic else GLUE_SOURCE}",
        f"friction {design.friction_of('pin_gear'):g} of the disc turns the pin; assumed: {adhesive_of(on_plastic)} "
        f"on half of its surface, {2e3 * ring.pin_radius:.4g} x {1e3 * seat_length:.4g} mm, as a press fit needs a "
        "closed bore",
    )


def _rate_press_fit(
    reducer: Reducer,
    key_and_name: tuple[str, str],
    turning_torque: float,
    seat: tuple[float, float, str, Material],
    zones: str,
) -> RatedItem:
    """Rate the press fit of a pin in its hole: `turning_torque` [N m] against its slip torque (DIN 7190-1, Lame).

    `key_and_name` are key and name of the rated item. `seat` contains radius and length of the joint [m], the name of
    the part that the pin belongs to (which determines its material), and the material around the hole. `zones` are the
    tolerance zones of pin and hole, such as ``m6 in N7``.
    """
    fit, max_pressure = _pin_press_fit(reducer, seat)
    return _press_fit_item(key_and_name, turning_torque, fit, zones, max_pressure)


def _pin_press_fit(reducer: Reducer, seat: tuple[float, float, str, Material]) -> tuple[strength.PressFit, float]:
    """Return the press fit of a pin in its hole, and the largest pressure [Pa] that the material around it withstands.

    `seat` has radius and length of the fit [m], the name of the part that the pin is, and the material of the hole.
    """
    radius, length, part, hub_material = seat
    pin_material = reducer.design.material_of(part)
    fit = strength.PressFit(
        2.0 * radius,
        length,
        JOINTS.wall_ratio * 2.0 * radius,
        (hub_material.youngs_modulus, hub_material.poisson),
        (pin_material.youngs_modulus, pin_material.poisson),
    )
    return fit, fit.yield_pressure(hub_material.yield_strength) * _permanent_share(hub_material)


def _press_fit_item(
    key_and_name: tuple[str, str], torque: float, fit: strength.PressFit, zones: str, max_pressure: float
) -> RatedItem:
    """Rate a press fit: the `torque` on it [N m] against the torque at which it slips at its mean interference.

    `key_and_name` are key and name of the rated item. `zones` are the tolerance zones of pin and hole, such as ``m6 in
    N7``. At `max_pressure` [Pa], a part yields.
    """
    interference, (mean_pressure, *end_pressures) = _fit_pressures(fit, zones, max_pressure)
    least_torque, largest_torque = map(fit.torque, end_pressures)
    key, name = key_and_name
    return torque_item(
        key,
        name,
        torque,
        fit.torque(mean_pressure),
        "Lame, p = Z/(d K), T = mu p pi d^2 l/2 (DIN 7190-1)",
        f"{_describe_fit(zones, interference, mean_pressure)}; {least_torque:.3g} to {largest_torque:.3g} N m within "
        f"the tolerance zones; friction {JOINTS.interface_friction:g} (assumed)",
    )


def _fit_pressures(fit: strength.PressFit, zones: str, max_pressure: float) -> tuple[float, tuple[float, float, float]]:
    """Compute the mean effective interference [m] of a press fit, and its mean, least and largest pressure [Pa].

    `zones` are the tolerance zones of pin and hole, such as ``m6 in N7``. At `max_pressure` [Pa], a part yields.
    """
    least_interference, largest_interference = (
        -clearance for clearance in reversed(fits.clearances(fit_code(zones), fit.diameter))
    )
    mean_effective_interference, least_effective_interference, largest_effective_interference = (
        strength.effective_interference(interference, JOINTS.hole_roughness, JOINTS.pin_roughness)
        for interference in (
            0.5 * (least_interference + largest_interference),
            least_interference,
            largest_interference,
        )
    )
    return mean_effective_interference, (
        min(fit.pressure(mean_effective_interference), max_pressure),
        min(fit.pressure(least_effective_interference), max_pressure),
        min(fit.pressure(largest_effective_interference), max_pressure),
    )


def _describe_fit(zones: str, interference: float, pressure: float) -> str:
    """Return zones, mean `interference` [m] and `pressure` [Pa] of a press fit in words."""
    return f"{zones}, mean interference after smoothing {1e6 * interference:.3g} um: {1e-6 * pressure:.3g} MPa"


def fit_code(fit_text: str) -> str:
    """Return the fit code of a hole and a shaft, such as ``H7/m6``, from a text such as ``m6 in H7``."""
    pairs = _ZONES.findall(fit_text)
    hole_zone, shaft_zone = (next(pair[side] for pair in pairs if pair[side]) for side in (0, 1))
    return f"{hole_zone}/{shaft_zone}"


def _material(reducer: Reducer, part: str) -> Material:
    return part_material(reducer, part, casing(reducer) if has_casing(reducer) else None)


def _slug(joint: Joint) -> str:
    """Return the beginning of the keys of a joint's items."""
    return "joint_" + joint.name.replace(" ", "_")
