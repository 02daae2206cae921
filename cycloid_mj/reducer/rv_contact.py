"""Contacts of an RV reducer by kind of pair: those of a ring with discs, crank bearings, and planet meshes."""

from typing import TYPE_CHECKING

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.geometry.rv_loads import ideal_rv_loads
from cycloid_mj.reducer.contact import CONTACT, Contact, Contacts, Source

if TYPE_CHECKING:
    from cycloid_mj.reducer.rv import RvReducer


class SpringContact(Contact):
    """Crank bearing or planet mesh: a spring whose stiffness the design states."""

    __slots__ = ("_rv",)

    HAS_PRESSURE = False

    def __init__(self, reducer: "RvReducer", kind: str) -> None:
        super().__init__(reducer, kind)
        self._rv = reducer

    @property
    def force(self) -> float:
        """Working force [N]: the mean force of the pair under `Contacts.working_load`, by ideal sharing."""
        return self._kept(SpringContact.force, self._compute_force)

    @property
    def source(self) -> Source:
        """Load from which the working force is computed, one of the values of `Source`."""
        if self._rv.design.contact.working_load:
            return "working load"
        return "load" if abs(self._rv.design.load.torque) >= self._rv.contacts.working_load else "weight and inertia"

    @property
    def damping_ratio(self) -> float:
        """Damping ratio [1]."""
        return float(self._rv.design.contact.damping_ratio)

    @property
    def impact(self) -> None:
        """None: the law IMPACT is that of line contacts."""
        return None

    @property
    def stiffness(self) -> float:
        """Stiffness of the pair [N/m]: of needles and taper in series, or of the mesh along its line of action."""
        return self._rv.bearing_stiffness if self.kind == names.CRANK_BEARING else self._rv.mesh_stiffness

    def _compute_force(self) -> float:
        """Compute the working force [N], which the property `force` caches.

        For crank bearings it is the mean force over all bearings and over a turn, for a planet mesh the force along its
        line of action.
        """
        reducer = self._rv
        torque = reducer.contacts.working_load * reducer.share
        if self.kind == names.CRANK_BEARING:
            crank_angles = np.linspace(0.0, reducer.crank_turn, CONTACT.cam_force_angles, endpoint=False)
            return float(ideal_rv_loads(reducer.stage, torque, crank_angles).bearings.mean())
        sun_torque = torque / reducer.stage.to_carrier
        sun_gear, _ = reducer.stage_gears
        return float(sun_torque / (reducer.cranks.count * sun_gear.base_radius))


class RvContacts(Contacts):
    """The contacts of an RV reducer by kind of pair, and their common properties."""

    __slots__ = ("_rv",)

    def __init__(self, reducer: "RvReducer") -> None:
        super().__init__(reducer)
        self._rv = reducer

    def __getitem__(self, kind: str) -> Contact:
        if kind in (names.CRANK_BEARING, names.PLANET_MESH):
            return SpringContact(self._rv, kind)
        return Contact(self._rv, kind)

    @property
    def own_load(self) -> float:
        """Output torque [N m] that causes the same contact forces as weight and inertia of the discs."""
        reducer = self._rv
        return self._weight_torque(reducer.disc_section) * reducer.design.ring.teeth / reducer.share
