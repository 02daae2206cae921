"""Efficiency in closed form: ideal sharing with Coulomb's law, and the formula of Wang, Luo and Su 2016."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.design.layouts import Layout
from cycloid_mj.parts import moving_masses
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.statics.friction import ideal_losses
from cycloid_mj.statics.ideal import ideal_rv_losses

AS_BUILT: Mapping[Layout, str] = {
    "central": "compliance of the cam and clearances let the disc move sideways, so that contacts with larger sliding "
    "speeds carry more than ideally",
    "rv": "the deflection of the crank bearings lets the disc move sideways, so that other teeth carry more than "
    "ideally, and free pins turn in their sockets",
}
"""Why a design differs from ideal sharing: with a stiff cam alone the difference is below half a point."""


@dataclass(frozen=True)
class EfficiencyReference:
    """An efficiency by a closed form, and its source."""

    efficiency: float
    source: str


def ideal_efficiency(reducer: Reducer, load: float) -> EfficiencyReference:
    """Compute the efficiency under a load torque [N m] by ideal load sharing and Coulomb friction.

    Cam or crank bearings are rigid. Contacts are equally stiff and without clearance. Their load includes the drag of
    the output's seals. The result has the efficiency [1] and the name of the method.
    """
    design = reducer.design
    contact_torque = load + design.drag.output
    crank_angles = np.linspace(0.0, 2.0 * np.pi, 360, endpoint=False)
    relative_loss = sum(IDEAL_LOSSES[reducer.LAYOUT](reducer.but(load={"torque": contact_torque}), crank_angles))
    input_torque = contact_torque / efficiency_of_output_member(reducer, 1.0 / (1.0 + relative_loss))
    return EfficiencyReference(load / (input_torque + design.drag.crank * design.reduction), "ideal sharing, Coulomb")


def _central_losses(reducer: Reducer, crank: Array) -> tuple[float, ...]:
    return ideal_losses(reducer, crank, reducer.design.mesh_friction)


def _rv_losses(reducer: Reducer, crank: Array) -> tuple[float, ...]:
    assert isinstance(reducer, RvReducer)
    return ideal_rv_losses(reducer, crank, reducer.design.mesh_friction)


IDEAL_LOSSES: Mapping[Layout, Callable[[Reducer, Array], tuple[float, ...]]] = {
    "central": _central_losses,
    "rv": _rv_losses,
}
"""Function of each layout: losses of ideal sharing over the power of the carrier [1], at crank angles (n,) [rad]."""


def ideal_limit(reducer: Reducer) -> Reducer:
    """Return a copy of a reducer that approaches ideal load sharing, for comparison with closed forms.

    It has fixed pins, the mesh's friction coefficient on the teeth, clearances of 1 nm, a contact stiffness that does
    not depend on curvature, an automatic time step, and nearly rigid cams or crank bearings: the stiffest that the
    design file allows, which deflect by about a hundredth as much as the teeth.
    """
    design = reducer.design
    disc = reducer.mechanism.discs[0]
    # per mass of the disc [1/s2], and the limit of the design file
    stiffness = min(3e11 * moving_masses(reducer)[disc.part].mass, 1e12)
    return reducer.but(
        ring={} if design.ring.kind == "nonpin" else {"pins": "fixed"},
        friction={design.tooth_pair: design.mesh_friction},
        contact={"stiffness_law": "uniform"},
        settings={"timestep": 0.0},
        **RIGID_BEARINGS[reducer.LAYOUT](design.tooth_pair, stiffness),
    )


def _rigid_cam(tooth_pair: str, stiffness: float) -> dict[str, dict[str, float]]:
    return {"clearance": dict.fromkeys((tooth_pair, "cam", "output"), 1e-9), "stiffness": {"cam": stiffness}}


def _rigid_crank_bearings(tooth_pair: str, stiffness: float) -> dict[str, dict[str, float]]:
    clearances = dict.fromkeys(("needle_clearance", "taper_clearance"), 0.5e-9)
    stiffnesses = dict.fromkeys(("needle_stiffness", "taper_stiffness"), stiffness)
    return {"clearance": {tooth_pair: 1e-9}, "cranks": clearances | stiffnesses}


RIGID_BEARINGS: Mapping[Layout, Callable[[str, float], dict[str, dict[str, float]]]] = {
    "central": _rigid_cam,
    "rv": _rigid_crank_bearings,
}
"""Function of each layout that returns clearances of 1 nm and a stiffness of the bearings [N/m] as design values.

Its arguments are the kind of the teeth and the stiffness.
"""


def published_efficiency(reducer: Reducer) -> EfficiencyReference | None:
    """Compute the efficiency of the layout by a published formula; None for an RV reducer."""
    return None if isinstance(reducer, RvReducer) else wang_efficiency(reducer)


def wang_efficiency(reducer: Reducer) -> EfficiencyReference:
    """Compute the efficiency eta_x eta_sx of Wang, Luo and Su 2016, without the factors of their formula for bearings.

    eta_nx = 1 - 4 mu (Dp - d)/(K1 z Dp pi), eta_x = eta_nx/(1 + z (1 - eta_nx)), eta_sx = 1 - 4 f K1 Dp/(pi Dw), with
    the friction mu of the mesh, the diameters Dp of the pin circle, d of a pin and Dw of the circle of output pins, z
    lobes, and the friction f at the surface of the output pins. The shortened-width coefficient K1 is the eccentricity
    times the number of ring teeth over the radius of the pin circle.
    """
    design = reducer.design
    ring, lobes = design.ring, design.lobes
    shortening = design.gear.eccentricity * ring.teeth / ring.pin_circle_radius
    contact_radius_ratio = (ring.pin_circle_radius - ring.pin_radius) / ring.pin_circle_radius
    mesh_efficiency = 1.0 - 4.0 * design.mesh_friction * contact_radius_ratio / (shortening * lobes * math.pi)
    radius_ratio = shortening * ring.pin_circle_radius / design.output.pin_circle_radius
    output_efficiency = 1.0 - 4.0 * design.friction_of("output") * radius_ratio / math.pi
    efficiency = mesh_efficiency / (1.0 + lobes * (1.0 - mesh_efficiency)) * output_efficiency
    return EfficiencyReference(efficiency_of_output_member(reducer, efficiency), "Wang et al. 2016")


def efficiency_of_output_member(reducer: Reducer, carrier: float) -> float:
    """Compute the efficiency [1] of a drive from the efficiency `carrier` [1] that it has with the carrier as output.

    It is the same, or, if the ring is the output, 1 - (1 - carrier)(N-1)/N for N ring teeth: the carrier's torque has
    the share (N-1)/N of the power of the ring; the share of the crank passes no mesh.
    """
    return 1.0 - reducer.share * (1.0 - carrier)
