"""Thermal network of a drive: the temperature of each part from the losses, in the steady state and over time.

Five nodes (disc, ring, crank, output, housing) exchange heat through contacts, grease, bearings and clamped faces, and
the housing gives it to the air: C dT/dt = P - G (T - T_ambient). Losses depend on the clearances, and these on the
temperatures: a fixed point.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.design import Design
from cycloid_mj.design.model import HEATED, PARTNERS, Material
from cycloid_mj.figures.geometry import masses
from cycloid_mj.geometry.expansion import BODY_OF
from cycloid_mj.life.bearings import ASSUMED_ROLLERS, bearing_forces, bearings_of
from cycloid_mj.life.heat import cooled_end_area, cooling_area, heat_transfer_coefficient
from cycloid_mj.life.loading import Loading
from cycloid_mj.parts.crank import shaft_dimensions
from cycloid_mj.parts.export.casing import casing
from cycloid_mj.parts.export.drive import drive_mass, has_casing
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.statics.balance import Loads

NODE_OF_BODY = {"shaft": "crank", "disc": "disc", "output": "output", "housing": "housing"}
"""Body that a bearing joins -> node."""

HEAT_SOURCES: Mapping[str, tuple[str, ...]] = {
    **{"teeth": ("disc", "ring"), "cam": ("crank", "disc"), "output": ("disc", "output")},
    **{"crank bearings": ("crank", "crank", "disc", "output"), "planets": ("crank",)},
}
"""Loss of the contacts -> nodes that get equal shares of it; seals heat the housing.

Half of the loss of the crank bearings of an RV reducer is that of the tapered bearings in its carrier, the output."""


@dataclass(frozen=True)
class HeatProperties:
    """Thermal conductivity [W/(m K)] and specific heat [J/(kg K)] of a kind of material at 20 °C."""

    conductivity: float
    specific_heat: float


@dataclass(frozen=True)
class NetworkAssumptions:
    """Assumptions of the network.

    Attributes
    ----------
    lightest_steel
        Density [kg/m3] that separates steel and bronze from aluminium and titanium.
    shell_share
        Heat capacity of the housing of a drive without covers, relative to the other parts: keeps the network solvable.
    loaded_share
        Share of the rollers of a bearing that carry its load (Stribeck's load zone of 120 deg).
    """

    lightest_steel: float = 5000.0
    shell_share: float = 0.01
    loaded_share: float = 1.0 / 3.0


ASSUMED = NetworkAssumptions()

STEEL, ALUMINIUM, PLASTIC = HeatProperties(45.0, 470.0), HeatProperties(160.0, 900.0), HeatProperties(0.25, 1500.0)
"""Alloy steels 42 to 46 W/(m K) (EN 10088-1, 10083); wrought aluminium 130 to 200; unfilled plastics 0.2 to 0.3."""

PART_OF_STEM = {
    **{"gear": "gear", "pin": "pin", "sleeve": "pin", "housing": "housing", "ring": "housing"},
    **{"output": "output", "roller": "output", "carrier": "output", "": "shaft"},
}
"""First letters of a part's name -> part of its material; all else turns with the crank."""


def heat_properties(material: Material) -> HeatProperties:
    """Return conductivity and specific heat by the kind of a material: plastic, light metal or steel."""
    if material.is_plastic:
        return PLASTIC
    return STEEL if material.density > ASSUMED.lightest_steel else ALUMINIUM


@dataclass(frozen=True)
class Conductance:
    """Heat flow per kelvin between two nodes, or a node and the air [W/K], with its formula."""

    first: str
    second: str
    value: float
    source: str


def line_contact_conductance(force: Array, length: float, radius: float, partners: Sequence[Material]) -> Array:
    """Compute the heat conductance of Hertzian line contacts [W/K], in the shape of `force` [N]; 0 without force.

    Each side is a cylinder with the `radius` R [m] and the conductivity k that is heated over the contact's width 2 b:
    pi k L/ln(4 R/b). Both sides are in series. `length` [m] is the length L of the line, `partners` are both materials.
    """
    compliance = sum((1.0 - partner.poisson**2) / partner.youngs_modulus for partner in partners)
    half_width = np.sqrt(4.0 * np.maximum(force, 0.0) * radius * compliance / (math.pi * length))
    resistance = np.zeros_like(half_width)
    is_loaded = half_width > 0.0
    for material in partners:
        log_ratio = np.log(np.maximum(4.0 * radius / half_width[is_loaded], math.e))
        resistance[is_loaded] += log_ratio / (math.pi * heat_properties(material).conductivity * length)
    return np.divide(1.0, resistance, out=np.zeros_like(resistance), where=is_loaded)


@dataclass(frozen=True, eq=False)
class Network:
    """Conductances between nodes and heat capacity of each node [J/K].

    `air` is the node of the surroundings; temperatures are relative to it.
    """

    conductances: tuple[Conductance, ...]
    capacities: Mapping[str, float] = field(default_factory=lambda: dict.fromkeys(HEATED, 1.0))
    air: str = "ambient"

    @cached_property
    def matrix(self) -> Array:
        """Return the conductance matrix G of a thermal network of n nodes [W/K], (n, n), in their order.

        The heat into the nodes [W] is G (T - T_ambient) in the steady state, with the temperatures T of the nodes.
        """
        node_index = {name: index for index, name in enumerate(self.capacities)}
        matrix = np.zeros((len(node_index), len(node_index)))
        for conductance in self.conductances:
            node_indices = [node_index[name] for name in (conductance.first, conductance.second) if name != self.air]
            for row in node_indices:
                for column in node_indices:
                    matrix[row, column] += conductance.value if row == column else -conductance.value
        return matrix

    def rises(self, powers: Mapping[str, float]) -> dict[str, float]:
        """Solve the steady temperature rise of each node over the air [K] for the heat put into each [W]."""
        rise = np.linalg.solve(self.matrix, self._vector(powers))
        return dict(zip(self.capacities, rise.tolist(), strict=True))

    def heat_to_air(self, rises: Mapping[str, float]) -> float:
        """Compute the heat that flows to the air [W]; in the steady state that of all losses."""
        links = [item for item in self.conductances if self.air in (item.first, item.second)]
        return sum(item.value * rises[item.first if item.second == self.air else item.second] for item in links)

    @property
    def time_constant(self) -> float:
        """Slowest time constant [s], the last to settle: the inverse of the smallest eigenvalue of C^-1 G."""
        capacity = np.array(list(self.capacities.values()))
        root = np.sqrt(np.outer(capacity, capacity))
        return float(1.0 / np.linalg.eigvalsh(self.matrix / root)[0])

    def _vector(self, powers: Mapping[str, float]) -> Array:
        """Return the heat put into each node as a vector [W], shape (n,)."""
        return np.array([powers.get(name, 0.0) for name in self.capacities])


def heat_by_node(reducer: Reducer, losses: Mapping[str, float]) -> dict[str, float]:
    """Return the heat into each node of the thermal network [W]: half of each loss to each of the two parts in contact.

    `losses` [W] are by source; those of unknown sources, such as seals, heat the housing.
    """
    bearings = () if isinstance(reducer, RvReducer) else bearings_of(reducer)
    nodes_by_bearing = {bearing.key: tuple(NODE_OF_BODY[body] for body in bearing.joins) for bearing in bearings}
    heat = dict.fromkeys(HEATED, 0.0)
    for source, power in losses.items():
        nodes = HEAT_SOURCES.get(source) or nodes_by_bearing.get(source) or ("housing",)
        for node in nodes:
            heat[node] += power / len(nodes)
    return heat


def build_network(reducer: Reducer, loading: Loading, wall_temperature: float) -> Network:
    """Build the thermal network of a drive (heat conductances between its parts and to the air) under solved loads.

    `loading` has the solved forces. `wall_temperature` [°C] is the temperature of the housing's wall. The network
    serves for steady temperatures only: its heat capacities are 1 J/K (see `heat_capacities`).
    """
    links = (
        *_contact_links(loading.reducer, loading.contacts),
        *_bearing_links(reducer, loading),
        *_face_links(reducer.design),
        *outside_links(reducer, wall_temperature),
    )
    return Network(links)


def _contact_links(reducer: Reducer, contact_loads: Loads) -> Iterator[Conductance]:
    """Yield the heat conductances [W/K] through the contacts of disc and ring, disc and output, crank and disc.

    They are means over the crank angles of the contact loads.
    """
    design = reducer.design
    line_contacts = {
        design.tooth_pair: (contact_loads.teeth, design.ring.pin_radius),
        "output": (contact_loads.output, design.output.pin_radius),
    }
    for pair, (forces, radius) in line_contacts.items():
        length, partners = design.line_length(pair), design.partners(pair)
        conductance = line_contact_conductance(forces, length, radius, partners).sum(axis=1).mean()
        first_node, second_node = (BODY_OF[part] for part in PARTNERS[pair])
        yield Conductance(
            first_node, second_node, float(conductance), f"line contacts of {pair}, pi k L/ln(4 R/b), mean of a turn"
        )
    force = float(np.linalg.norm(contact_loads.cam, axis=-1).mean())
    if design.gear.bearing == "plain":
        bore_area = 2.0 * math.pi * design.gear.bore_radius * design.gear.face_width * design.gear.discs
        conductance = design.thermal.grease_conductivity * bore_area / design.clearance.cam
        yield Conductance("crank", "disc", conductance, "lubricant in the gap of the plain cam, k A/clearance")
        return
    rollers = design.contact.cam_rollers
    cam_conductance = roller_conductance(
        rollers, reducer.contacts.roller_radius, design.gear.face_width, force, design.partners("cam")
    )
    source = f"{rollers} rollers of each cam, a third of them loaded"
    yield Conductance("crank", "disc", design.gear.discs * cam_conductance, source)


def roller_conductance(rollers: int, radius: float, length: float, force: float, partners: Sequence[Material]) -> float:
    """Compute the heat conductance of a roller bearing [W/K] under a force [N].

    `rollers` is the number of rollers, a third of which is loaded. A loaded roller of a radius and length [m] conducts
    through its inner and outer contact in series; `partners` are the materials of rollers and rings.
    """
    loaded_rollers = max(1.0, ASSUMED.loaded_share * rollers)
    contact_conductance = line_contact_conductance(np.array([force / loaded_rollers]), length, radius, partners)
    return 0.5 * loaded_rollers * float(contact_conductance[0])


def _bearing_links(reducer: Reducer, loading: Loading) -> Iterator[Conductance]:
    """Yield the heat conductances [W/K] of the bearings of shaft and output, as roller bearings of the same size.

    Forces are means over the crank angles of `loading`.
    """
    bearing_start, bearing_end = shaft_dimensions(reducer).bearings[0]
    steel = reducer.design.material_of("shaft")
    for bearing in bearings_of(reducer):
        if not bearing.bore:
            continue
        width = casing(reducer).hub.width if bearing.key.startswith("output") else bearing_end - bearing_start
        force = float(bearing_forces(reducer, bearing.key, loading).mean())
        roller_radius = 0.5 * ASSUMED_ROLLERS.shaft_roller_share * 0.5 * bearing.bore
        conductance = roller_conductance(ASSUMED_ROLLERS.shaft_rollers, roller_radius, width, force, (steel, steel))
        first_node, second_node = (NODE_OF_BODY[body] for body in bearing.joins)
        yield Conductance(
            first_node,
            second_node,
            conductance,
            f"{bearing.name}: {ASSUMED_ROLLERS.shaft_rollers} rollers assumed, a third of them loaded",
        )


def _face_links(design: Design) -> Iterator[Conductance]:
    """Yield the heat conductances [W/K] through the grease between end faces of discs and housing or output."""
    root_radius = design.ring.pin_circle_radius - design.ring.pin_radius
    hole_radii_squared = design.output.pins * design.output.hole_radius**2
    area = math.pi * (root_radius**2 - design.gear.bore_radius**2 - hole_radii_squared)
    conductance = design.thermal.grease_conductivity * area / design.thermal.face_gap
    for node in ("housing", "output"):
        yield Conductance("disc", node, conductance, "grease on a face of the discs, k A/gap")


def outside_links(reducer: Reducer, wall_temperature: float) -> Iterator[Conductance]:
    """Yield the heat conductances [W/K] from the ring to the housing, and from housing and output to the air.

    The covers are the housing. `wall_temperature` [°C] is the temperature of the housing's wall.
    """
    design = reducer.design
    clamped_area = 2.0 * math.pi * (design.housing.outer_radius**2 - design.ring.pin_circle_radius**2)
    yield Conductance(
        "ring", "housing", design.thermal.joint_conductance * clamped_area, "clamped faces of the ring, h A"
    )
    coefficient, end_area = heat_transfer_coefficient(reducer, wall_temperature), cooled_end_area(reducer)
    source = "service.film_coefficient_w_m2_k" if design.service.film_coefficient else "ISO/TR 14179-2"
    for node, area in (("housing", cooling_area(reducer) - end_area), ("output", end_area)):
        if area:
            yield Conductance(node, "ambient", coefficient * area, f"h A, h = {coefficient:.3g} W/(m2 K) by {source}")


def heat_capacities(reducer: Reducer) -> dict[str, float]:
    """Compute the heat capacity of each node of the thermal network [J/K], mass times specific heat, by node.

    The housing has the capacity of the covers, but at least a share `shell_share` (1 %) of the capacity of all other
    nodes together. Without covers, it has this smallest capacity.
    """
    capacities = dict.fromkeys(HEATED, 0.0)
    part_masses = masses(reducer)
    for name, mass in part_masses.items():
        part = next(part for stem, part in PART_OF_STEM.items() if name.startswith(stem))
        capacities[BODY_OF[part]] += mass * heat_properties(reducer.design.material_of(part)).specific_heat
    cover_mass = drive_mass(reducer) - sum(part_masses.values()) if has_casing(reducer) else 0.0
    housing_specific_heat = heat_properties(reducer.design.material_of("housing")).specific_heat
    capacities["housing"] = max(cover_mass * housing_specific_heat, ASSUMED.shell_share * sum(capacities.values()))
    return capacities
