"""Several pieces of work at once: their order, what is told, and how they end together."""

import time

import pytest

from cycloid_mj.base.engine import each_in_threads
from cycloid_mj.base.errors import RunError
from cycloid_mj.base.interrupt import check_interrupt

LONG = 60.0


def test_results_are_in_order_and_progress_counts_every_item() -> None:
    told: list[tuple[int, int]] = []
    found = each_in_threads(
        lambda wait: (time.sleep(wait), wait)[1], [0.03, 0.0, 0.01], lambda *one: told.append(one), workers=3
    )
    assert found == [0.03, 0.0, 0.01]
    assert told == [(1, 3), (2, 3), (3, 3)]


@pytest.mark.parametrize("error", [RunError, KeyboardInterrupt])
def test_the_first_error_stops_the_pieces_under_way(error: type[BaseException]) -> None:
    stopped: list[type[BaseException]] = []

    def work(fails: bool) -> None:
        if fails:
            time.sleep(0.05)
            raise error("spoiled")
        try:
            for _ in range(int(1e3 * LONG)):
                time.sleep(1e-3)
                check_interrupt()
        except BaseException as reason:
            stopped.append(type(reason))
            raise

    start = time.monotonic()
    with pytest.raises(error, match="spoiled"):
        each_in_threads(work, [True, False, False, False], workers=2)
    # those under way ended long before their time, and of the last two one at the most was begun
    assert time.monotonic() - start < 0.2 * LONG
    assert set(stopped) == {KeyboardInterrupt}
    assert len(stopped) <= 2


def test_a_rigid_piece_ends() -> None:
    """It may hold a lock: nothing is raised in its midst."""
    ended: list[bool] = []

    def work(fails: bool) -> None:
        if fails:
            time.sleep(0.05)
            raise KeyboardInterrupt
        for _ in range(100):
            time.sleep(2e-3)
        ended.append(True)

    with pytest.raises(KeyboardInterrupt):
        each_in_threads(work, [True, False], workers=2)
    assert ended == [True]
