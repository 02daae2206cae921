"""Figures from runs: quantities of `cycloid-mj measure` at the default conditions of the measures."""

from cycloid_mj.base.registry import get_provider
from cycloid_mj.design.layouts import CENTRAL, Layout, layouts_of
from cycloid_mj.figures.figure import Figure, Need
from cycloid_mj.reducer import Reducer


def _make_entry(
    key: str, unit: str, name: str, definition: str, measure: str, quantity: str, layouts: tuple[Layout, ...] = ()
) -> Figure:
    """Return the catalogue entry (`Figure`) of a quantity that ``cycloid-mj measure`` determines by simulation.

    `name`, `definition` and `unit` are texts for the user. `measure` is the name of the measurement and `quantity` that
    of its result, such as ``loads`` and ``capacity``; the alias of the quantity is ``measure/quantity``. Its key is
    ``simulated_`` and `key`. `layouts` are the types of reducer (central crank, RV) that have the quantity, by default
    those that the measurement supports.
    """

    def compute(reducer: Reducer) -> float:
        measured_value: float = get_provider("measure")(reducer, measure, quantity)
        return measured_value

    return Figure(
        key=f"simulated_{key}",
        name=name,
        unit=unit,
        definition=definition,
        need=Need.RUN,
        function=compute,
        aliases=(f"{measure}/{quantity}",),
        layouts=layouts or layouts_of(f"measure {measure}"),
    )


# fmt: off
OF_RUNS = (
    _make_entry("backlash_arcmin", "arcmin", "backlash of the output, simulated",
            "Rotation of the output from stop to stop at locked crank angles, by `cycloid-mj measure backlash`.",
            "backlash", "backlash"),
    _make_entry("lost_motion_arcmin", "arcmin", "lost motion, simulated",
            "Rotation of the output between -3 and 3 % of the nominal torque with friction, by `measure lost-motion`.",
            "lost-motion", "lost_motion"),
    _make_entry("stiffness_nm_per_arcmin", "N m/arcmin", "torsional stiffness, simulated",
            "Change of torque per rotation of the output, from 50 to 100 % of the nominal torque, by `measure "
            "lost-motion`.",
            "lost-motion", "stiffness"),
    _make_entry("te_loaded_arcsec", "arcsec", "transmission error of the output, peak to peak, loaded, simulated",
            "Range of the output's angle minus its ideal angle under the nominal torque at speed, by `measure te`.",
            "te", "output_peak_to_peak_loaded_forward_speed"),
    _make_entry("te_unloaded_arcsec", "arcsec", "transmission error of the output, peak to peak, unloaded, simulated",
            "Range of the output's angle minus its ideal angle under 1 % of the nominal torque at speed, by "
            "`measure te`.",
            "te", "output_peak_to_peak_unloaded_forward_speed"),
    _make_entry("output_torque_nm", "N m", "output torque, simulated",
            "Mean torque of the output under the nominal torque on the crank, by `cycloid-mj measure torque`.",
            "torque", "output_torque"),
    _make_entry("efficiency_percent", "%", "efficiency, simulated",
            "Output power divided by power of the crank under the nominal torque at speed, by `measure efficiency`.",
            "efficiency", "efficiency"),
    _make_entry("capacity_nm", "N m", "capacity, simulated",
            "Torque on the output at which the first contact yields below its surface, by `cycloid-mj measure loads`.",
            "loads", "capacity"),
    _make_entry("cam_force_n", "N", "largest force of the cam, simulated",
            "Largest force of one cam on its disc under the nominal torque at speed, by `cycloid-mj measure loads`.",
            "loads", "cam_peak_force", CENTRAL),
    _make_entry("output_pin_force_n", "N", "largest force on an output pin, simulated",
            "Largest normal force of one disc on one output pin under the nominal torque at speed, by `measure loads`.",
            "loads", "output_peak_force", CENTRAL),
)
# fmt: on
