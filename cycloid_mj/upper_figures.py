"""Figures of the layers above `figures`: checks, life and stress; each function is imported when it is first used."""

from cycloid_mj.figures.figure import Compute, Figure, Need
from cycloid_mj.reducer import Reducer

_RATED = "at the nominal torque and speed"

PARTS = {
    "shaft": "the shaft",
    "gear": "the discs",
    "ring": "the ring",
    "output": "the output",
    "pin": "ring pin 1",
}
"""Parts whose stress is computed -> words."""


def _has_covers(reducer: Reducer) -> bool:
    """Return whether covers and output bearings fit the design."""
    from cycloid_mj.parts.export.drive import has_casing

    return has_casing(reducer)


def _of_part(kind: str, name: str) -> Compute:
    """Return the function of a figure of the parts of a kind, by finite elements."""

    def compute(reducer: Reducer) -> float:
        from cycloid_mj.stress.figures import part_figure

        return part_figure(reducer, kind, name)

    return compute


UPPER_FIGURES = (
    Figure(
        key="pressure_angle_deg",
        name="pressure angle, averaged by force",
        unit="deg",
        definition="Pressure angle of the tooth forces, averaged by force under the nominal torque, with friction.",
        need=Need.STATICS,
        function="cycloid_mj.checks.rated_load:pressure_angle",
    ),
    Figure(
        key="loaded_teeth_per_disc",
        name="loaded teeth of a disc at the nominal torque, mean number",
        unit="1",
        definition="Contacts of one disc with the ring with at least 1 % of the largest force under the nominal "
        "torque, with friction: mean number.",
        need=Need.STATICS,
        function="cycloid_mj.checks.rated_load:loaded_teeth",
    ),
    Figure(
        key="input_inertia_kg_cm2",
        name="inertia at the input",
        unit="kg cm2",
        definition="Inertia at the crank: crank, discs on their orbit, all other parts over the ratio squared.",
        need=Need.GEOMETRY,
        function="cycloid_mj.life.figures:input_inertia",
        aliases=("inertia",),
    ),
    Figure(
        key="length_mm",
        name="length of the mechanism",
        unit="mm",
        definition="Distance along the axis from the input journal to the far side of the output disc.",
        need=Need.GEOMETRY,
        function="cycloid_mj.life.figures:length",
        aliases=("length",),
    ),
    Figure(
        key="drive_mass_kg",
        name="mass of the drive",
        unit="kg",
        definition="Mass including covers, bearings, screws, dowels and output flange, without motor and grease.",
        need=Need.GEOMETRY,
        function="cycloid_mj.life.figures:drive_mass",
        aliases=("drive_mass",),
        exists=_has_covers,
    ),
    Figure(
        key="drive_inertia_kg_cm2",
        name="inertia of the drive at the input",
        unit="kg cm2",
        definition="Inertia at the crank, including hub and flange of the output over the ratio squared.",
        need=Need.GEOMETRY,
        function="cycloid_mj.life.figures:drive_inertia",
        aliases=("drive_inertia",),
        exists=_has_covers,
    ),
    Figure(
        key="drive_length_mm",
        name="overall length",
        unit="mm",
        definition="Distance along the axis from the motor flange to the face of the output flange, with covers.",
        need=Need.GEOMETRY,
        function="cycloid_mj.life.figures:drive_length",
        aliases=("drive_length",),
        exists=_has_covers,
    ),
    Figure(
        key="drive_diameter_mm",
        name="overall diameter",
        unit="mm",
        definition="Diameter of the covers: that of the ring, or more if their screws do not fit into its wall.",
        need=Need.GEOMETRY,
        function="cycloid_mj.life.figures:drive_diameter",
        aliases=("drive_diameter",),
        exists=_has_covers,
    ),
    Figure(
        key="largest_speed_rpm",
        name="largest speed of the crank",
        unit="rpm",
        definition="Speed of the crank that the bearings of cams and shaft allow with grease: 300 000 over their mean "
        "diameter in mm, half of it for rollers without a cage.",
        need=Need.GEOMETRY,
        function="cycloid_mj.life.figures:largest_speed",
    ),
    *(
        Figure(
            key=f"{key}_speed_rpm",
            name=f"largest speed of the crank, {words}",
            unit="rpm",
            definition=f"Speed of the crank at which the housing reaches its limit under the nominal torque, {words}; "
            "at most the largest that its bearings allow.",
            need=Need.LIFE,
            function=f"cycloid_mj.life.figures:{key}_speed",
        )
        for key, words in {"continuous": "continuous", "intermittent": "for a quarter of the time"}.items()
    ),
    Figure(
        key="output_tilting_capacity_nm",
        name="tilting moment on the output",
        unit="N m",
        definition="Moment across the axis that the two bearings of the output's hub support next to the nominal "
        "torque, for the life of the design with its service factor (ISO 281) and standing (ISO 76).",
        need=Need.STATICS,
        function="cycloid_mj.life.output_bearing:tilting_moment",
        exists=_has_covers,
    ),
    Figure(
        key="output_tilting_stiffness_nm_per_arcmin",
        name="tilting stiffness of the output",
        unit="N m/arcmin",
        definition="Moment across the axis over the tilt by the balls of the hub's two bearings, at half their moment "
        "limit, without clearance; hub and covers rigid.",
        need=Need.STATICS,
        function="cycloid_mj.life.output_bearing:tilting_stiffness",
        exists=_has_covers,
    ),
    Figure(
        key="output_radial_load_n",
        name="radial load on the output",
        unit="N",
        definition="Force across the axis on the flange's face that the hub's bearings support next to the nominal "
        "torque, as the tilting moment.",
        need=Need.STATICS,
        function="cycloid_mj.life.output_bearing:radial_load",
        exists=_has_covers,
    ),
    Figure(
        key="output_axial_load_n",
        name="axial load on the output",
        unit="N",
        definition="Force along the axis on the flange without other loads: a quarter of a bearing's static rating.",
        need=Need.STATICS,
        function="cycloid_mj.life.output_bearing:axial_load",
        exists=_has_covers,
    ),
    Figure(
        key="life_h",
        name="life",
        unit="h",
        definition=f"Time until the first part fails, wear excluded, by `cycloid-mj rate`, {_RATED}.",
        need=Need.LIFE,
        function="cycloid_mj.life.figures:life",
    ),
    Figure(
        key="bearing_life_h",
        name="life of the bearings",
        unit="h",
        definition=f"Shortest life of the bearings by ISO 281, {_RATED}.",
        need=Need.LIFE,
        function="cycloid_mj.life.figures:bearing_life",
    ),
    Figure(
        key="least_safety",
        name="smallest safety factor",
        unit="1",
        definition=f"Smallest safety factor of `cycloid-mj rate`, {_RATED}.",
        need=Need.LIFE,
        function="cycloid_mj.life.figures:least_safety",
    ),
    Figure(
        key="drive_efficiency_percent",
        name="efficiency with all bearings",
        unit="%",
        definition=f"Power of the output over that of the crank, bearings of shaft and output included, {_RATED}.",
        need=Need.LIFE,
        function="cycloid_mj.life.figures:drive_efficiency",
    ),
    Figure(
        key="temperature_rise_k",
        name="temperature rise",
        unit="K",
        definition=f"Temperature of the housing above ambient, in still air, {_RATED}.",
        need=Need.LIFE,
        function="cycloid_mj.life.figures:temperature_rise",
        aliases=("temperature_rise",),
    ),
    Figure(
        key="momentary_torque_nm",
        name="momentary torque",
        unit="N m",
        definition="Torque on the output in an emergency stop with a safety factor of 1 of contacts, pins, bearings "
        "and joints.",
        need=Need.LIFE,
        function="cycloid_mj.life.figures:momentary",
        aliases=("momentary_torque",),
    ),
    Figure(
        key="torque_for_6000_h_nm",
        name="torque for 6000 h",
        unit="N m",
        definition="Rated torque on the output for service.life_h (by default 6000 h) at the design's speed; at most "
        "the momentary torque.",
        need=Need.LIFE,
        function="cycloid_mj.life.figures:torque_for_life",
    ),
    *(
        Figure(
            key=f"{kind}_stress_mpa",
            name=f"largest stress of {words}",
            unit="MPa",
            definition=f"Largest von Mises stress of {words} away from contacts, or at a fillet by its notch factor, "
            "over a turn of the crank under the load or else the nominal torque, by `cycloid-mj stress --quick`.",
            need=Need.STRESS,
            function=_of_part(kind, "stress_mpa"),
        )
        for kind, words in PARTS.items()
    ),
    *(
        Figure(
            key=f"{kind}_contact_pressure_mpa",
            name=f"largest contact pressure on {words}",
            unit="MPa",
            definition=f"Largest Hertz pressure on {words} over a turn of the crank under the load, or the "
            "nominal torque without one, by `cycloid-mj stress --quick`; none if every contact is conformal.",
            need=Need.STRESS,
            function=_of_part(kind, "contact_pressure_mpa"),
        )
        for kind, words in PARTS.items()
    ),
    *(
        Figure(
            key=f"{kind}_contact_safety",
            name=f"safety factor of the contact pressure on {words}",
            unit="1",
            definition=f"Shakedown limit 4 k of the surface over the largest Hertz pressure on {words}, by "
            "`cycloid-mj stress --quick`: below 1, rolling yields at every pass (pitting life: `cycloid-mj rate`).",
            need=Need.STRESS,
            function=_of_part(kind, "contact_safety"),
        )
        for kind, words in PARTS.items()
    ),
)
