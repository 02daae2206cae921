"""Simulate cycloidal speed reducers in MuJoCo: geometry, contact dynamics, logs and comparison with closed forms.

>>> import cycloid_mj as cm
>>> design = cm.load("pin", ["drive.ramp_s=0", "drive.hold_s=0.05", "load.torque_nm=36"])
>>> run = cm.simulate(design)
>>> found = cm.analyze(run)

A name is imported when it is first used: `import cycloid_mj` alone takes no time.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from cycloid_mj.base import registry
from cycloid_mj.base.version import __version__ as __version__

if TYPE_CHECKING:
    from cycloid_mj import measure, stress, validate
    from cycloid_mj.analysis import Findings, analyze
    from cycloid_mj.analysis.spectrum import tapered_orders
    from cycloid_mj.base.record import Run
    from cycloid_mj.base.result import Curve, Quantity, Table
    from cycloid_mj.bench import calibrate, compare_bench, predict_loops, read_loop, read_te
    from cycloid_mj.bench import protocol_of as protocol
    from cycloid_mj.checks import Check
    from cycloid_mj.design import PRESETS, Design
    from cycloid_mj.design import resolve as load
    from cycloid_mj.dynamics.mjcf import build
    from cycloid_mj.dynamics.run import simulate
    from cycloid_mj.explore.compared import compare
    from cycloid_mj.explore.optimizer import optimize
    from cycloid_mj.explore.sweeps import sweep
    from cycloid_mj.explore.tolerances import tolerance
    from cycloid_mj.figures import FIGURES
    from cycloid_mj.life import rate
    from cycloid_mj.life.accuracy_life import wear
    from cycloid_mj.life.checks import check_design as check
    from cycloid_mj.life.datasheet import datasheet_of as datasheet
    from cycloid_mj.life.heat_and_strength import thermal_of as thermal
    from cycloid_mj.log import read as read_log
    from cycloid_mj.log import write as write_log
    from cycloid_mj.parts.export import export
    from cycloid_mj.plots.animation import animate
    from cycloid_mj.plots.rendered import render
    from cycloid_mj.reducer import Reducer
    from cycloid_mj.report import report
    from cycloid_mj.robot import ReducedJoint, attach_reducer, reduce
    from cycloid_mj.sizing import new
    from cycloid_mj.statics import main as statics
    from cycloid_mj.statics.preload import preloaded

__all__ = [
    "FIGURES",
    "PRESETS",
    "Check",
    "Curve",
    "Design",
    "Findings",
    "Quantity",
    "ReducedJoint",
    "Reducer",
    "Run",
    "Table",
    "analyze",
    "animate",
    "attach_reducer",
    "build",
    "calibrate",
    "check",
    "compare",
    "compare_bench",
    "datasheet",
    "export",
    "load",
    "measure",
    "new",
    "optimize",
    "predict_loops",
    "preloaded",
    "protocol",
    "rate",
    "read_log",
    "read_loop",
    "read_te",
    "reduce",
    "render",
    "report",
    "simulate",
    "statics",
    "stress",
    "sweep",
    "tapered_orders",
    "thermal",
    "tolerance",
    "validate",
    "wear",
    "write_log",
]

registry.register(
    draw_result="cycloid_mj.plots.result:figure_of",
    measure="cycloid_mj.measure:measure_quantity",
    upper_figures="cycloid_mj.upper_figures:UPPER_FIGURES",
    further_validation="cycloid_mj.life.witnesses:PARTS",
)

_ORIGINS = {
    "Check": "checks",
    "Curve": "base.result",
    "Design": "design",
    "FIGURES": "figures",
    "Findings": "analysis",
    "PRESETS": "design",
    "Quantity": "base.result",
    "ReducedJoint": "robot",
    "Reducer": "reducer",
    "Run": "base.record",
    "Table": "base.result",
    "analyze": "analysis",
    "animate": "plots.animation",
    "attach_reducer": "robot",
    "build": "dynamics.mjcf",
    "calibrate": "bench",
    "check": "life.checks:check_design",
    "compare": "explore.compared",
    "compare_bench": "bench",
    "datasheet": "life.datasheet:datasheet_of",
    "export": "parts.export",
    "load": "design:resolve",
    "measure": "",
    "new": "sizing",
    "optimize": "explore.optimizer",
    "predict_loops": "bench",
    "preloaded": "statics.preload",
    "protocol": "bench:protocol_of",
    "rate": "life",
    "read_log": "log:read",
    "read_loop": "bench",
    "read_te": "bench",
    "reduce": "robot",
    "render": "plots.rendered",
    "report": "",
    "simulate": "dynamics.run",
    "statics": "",
    "stress": "",
    "sweep": "explore.sweeps",
    "tapered_orders": "analysis.spectrum",
    "thermal": "life.heat_and_strength:thermal_of",
    "tolerance": "explore.tolerances",
    "validate": "",
    "wear": "life.accuracy_life",
    "write_log": "log:write",
}
"""Module of each public name, and its name there if it differs; empty for a package."""


def __getattr__(name: str) -> Any:
    """Import and return a public name when it is first used."""
    if name not in _ORIGINS:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}; it has {', '.join(__all__)}")
    origin = _ORIGINS[name]
    if not origin:
        return import_module(f"{__name__}.{name}")
    module, _, attribute_name = origin.partition(":")
    value = getattr(import_module(f"{__name__}.{module}"), attribute_name or name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """List the public names alone, for completion."""
    return sorted(__all__)
