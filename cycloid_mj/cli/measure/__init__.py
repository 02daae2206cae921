"""``cycloid-mj measure``: the figures by which a reducer is bought."""

from collections.abc import Callable

from cyclopts import App

from cycloid_mj.cli.measure import backlash, efficiency, loads, lost_motion, te, torque, vibration

EXAMPLES = """Examples:
  cycloid-mj measure te --design pin
  cycloid-mj measure backlash --design nonpin --set clearance.tooth_um=5
  cycloid-mj measure torque pin nonpin --json"""


def commands(sort_key: int) -> App:
    """Give the measures; `sort_key` is their place in the help."""
    about = "Measure transmission error, backlash, lost motion, torque, efficiency, loads or vibration."
    app = App(name="measure", help=about, help_epilogue=EXAMPLES, sort_key=sort_key)
    measures: dict[Callable[..., int], str] = {
        te.te: te.EXAMPLES,
        backlash.backlash: backlash.EXAMPLES,
        lost_motion.lost_motion: lost_motion.EXAMPLES,
        loads.loads: loads.EXAMPLES,
        torque.torque: torque.EXAMPLES,
        efficiency.efficiency: efficiency.EXAMPLES,
        vibration.vibration: vibration.EXAMPLES,
    }
    for place, (command, examples) in enumerate(measures.items()):
        app.command(command, sort_key=place, help_epilogue=examples)
    return app
