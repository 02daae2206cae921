"""What holds for every test."""

import pytest


@pytest.fixture(scope="session", autouse=True)
def compiled():
    """Have the contact code compiled: in a new installation the first command takes longer, and says so."""
    from cycloid_mj.contact.collider import installed

    with installed():
        pass
