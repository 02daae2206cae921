"""What holds for every test."""

import signal

import pytest


@pytest.fixture(scope="session", autouse=True)
def interruptible():
    """Take Ctrl-C as a terminal's shell hands it on: what a script starts in the background ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture(scope="session", autouse=True)
def compiled():
    """Have the contact code compiled: in a new installation the first command takes longer, and says so."""
    from cycloid_mj.contact.collider import installed

    with installed():
        pass
