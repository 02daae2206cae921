"""The list of figures that differ between two revisions."""

import moved


def test_a_figure_moves_when_its_printed_digits_do() -> None:
    old, new = {"same": 1.0, "moved": 2.0, "gone": 3.0, "from_zero": 0.0}, {"same": 1.000001, "moved": 2.1, "new": 4.0}
    listed = {move.key: move.change for move in moved.moves("pin", "statics", old, {**new, "from_zero": 1.0})}
    assert listed == {"moved": "+5 %", "gone": "gone", "from_zero": "from 0", "new": "new"}


def test_values_of_only_one_revision_are_counted_but_not_listed() -> None:
    of = [moved.Move("pin", "rate", "life", 1.0, None), moved.Move("pin", "rate", "heat", 1.0, 1.5)]
    assert moved.table(of).cells == [["pin", "rate", "heat", "1", "1.5", "+50 %"]]
    assert moved.come_and_gone(of) == "Printed by one revision alone: 0 new, 1 gone."
