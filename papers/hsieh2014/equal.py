"""What differs between the two designs: nothing but the ring."""

from cycloid_mj.comparison import conditions, differences
from cycloid_mj.result import Table
from hsieh2014.plan import Plan, designs
from hsieh2014.stage import Found, Runs, Told


def equal(plan: Plan, runs: Runs, told: Told) -> Found:
    """Give every value in which the two designs differ, and the conditions that they share."""
    both = designs()
    names = tuple(design.name for design in both)
    found = differences(both)
    rows = tuple((key, *map(str, each)) for key, each in found.items())
    shared = tuple((key, str(value)) for key, value in conditions(both[0]).items())
    return Found(
        tables=(
            Table("all that differs between the designs", ("value", *names), rows),
            Table("conditions of both (the runs below change ramp, hold and load, alike)", ("value", "both"), shared),
        ),
        findings={"differences": {key: list(each) for key, each in found.items()}},
        notes=("Friction, clearance, stiffness law, damping, drive and step are the same for both designs.",),
    )
