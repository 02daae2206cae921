"""Figures of the rooms above: each names the function there that computes it, and imports it with its first use."""

from cycloid_mj.figures.figure import Figure, Need

_RATED = "at the rated torque and speed"

PARTS = {
    "shaft": "the shaft",
    "gear": "the discs",
    "ring": "the ring",
    "output": "the output",
    "pin": "ring pin 1",
}
"""Kinds of parts whose stress is known, in words."""

OF_ROOMS_ABOVE = (
    Figure(
        key="pressure_angle_deg",
        name="pressure angle, mean by force",
        unit="deg",
        definition="Angle of the tooth forces to the way that they turn the gear, mean by force under the rated "
        "torque, with friction.",
        need=Need.STATICS,
        function="cycloid_mj.checks.rated:pressure_angle",
    ),
    Figure(
        key="loaded_teeth_per_disc",
        name="teeth of a disc that carry at the rated torque, on average",
        unit="1",
        definition="Contacts of one disc with the ring that carry 1 % of the largest force or more under the rated "
        "torque, with friction: their mean.",
        need=Need.STATICS,
        function="cycloid_mj.checks.rated:loaded_teeth",
    ),
    Figure(
        key="input_inertia_kg_cm2",
        name="inertia at the input",
        unit="kg cm2",
        definition="Inertia that the motor feels: crank, discs on their orbit, the rest over the ratio squared.",
        need=Need.GEOMETRY,
        function="cycloid_mj.life.figures:input_inertia",
        aliases=("inertia",),
    ),
    Figure(
        key="length_mm",
        name="length over all",
        unit="mm",
        definition="Distance along the axis from the input journal to the far side of the output disc.",
        need=Need.GEOMETRY,
        function="cycloid_mj.life.figures:length",
        aliases=("length",),
    ),
    Figure(
        key="life_h",
        name="life",
        unit="h",
        definition=f"Hours until the first part reaches the end of its life by `cycloid-mj rate`, {_RATED}.",
        need=Need.LIFE,
        function="cycloid_mj.life.figures:life",
    ),
    Figure(
        key="bearing_life_h",
        name="life of the bearings",
        unit="h",
        definition=f"Hours until the first bearing reaches the end of its life by ISO 281, {_RATED}.",
        need=Need.LIFE,
        function="cycloid_mj.life.figures:bearing_life",
    ),
    Figure(
        key="least_safety",
        name="least safety",
        unit="1",
        definition=f"Least of the safeties of `cycloid-mj rate`, {_RATED}.",
        need=Need.LIFE,
        function="cycloid_mj.life.figures:least_safety",
    ),
    Figure(
        key="temperature_rise_k",
        name="temperature rise",
        unit="K",
        definition=f"Temperature of the housing over the surroundings, in still air, {_RATED}.",
        need=Need.LIFE,
        function="cycloid_mj.life.figures:temperature_rise",
        aliases=("temperature_rise",),
    ),
    Figure(
        key="momentary_torque_nm",
        name="momentary torque",
        unit="N m",
        definition="Torque on the output that is held once with a safety of 1.",
        need=Need.LIFE,
        function="cycloid_mj.life.figures:momentary",
        aliases=("momentary_torque",),
    ),
    Figure(
        key="torque_for_6000_h_nm",
        name="torque for 6000 h",
        unit="N m",
        definition="Torque on the output that all parts bear for 6000 h at the rated speed, and that is held once.",
        need=Need.LIFE,
        function="cycloid_mj.life.figures:torque_for_life",
    ),
    *(
        Figure(
            key=f"{kind}_stress_mpa",
            name=f"largest stress of {words}",
            unit="MPa",
            definition=f"Largest von Mises stress of {words} away from contacts, or at a fillet by its notch factor, "
            "over a turn of the crank under the load, else the rated torque, by `cycloid-mj stress --quick`.",
            need=Need.STRESS,
            function=f"cycloid_mj.stress.figures:{kind}_stress",
        )
        for kind, words in PARTS.items()
    ),
)
