"""The releases of MuJoCo that are known to work, for the error of one that does not.

The contact reads and writes MuJoCo's own structures, which change without notice. Any release from the oldest on may be
installed: ``contact.selftest`` tries it.
"""

import mujoco

from cycloid_mj.base.errors import ContactError

KNOWN = ("3.17.0", "4.0.0", "4.0.1")
"""Those on which the tests of the contact pass, ``scripts/test_mujoco_versions.py``, the oldest first."""


def unfit(why: str) -> ContactError:
    """Return the error of a release that does not work."""
    return ContactError(
        f"MuJoCo {mujoco.__version__} does not work with this cycloid_mj ({why}); "
        f"known to work: {', '.join(KNOWN)}: pip install 'mujoco=={KNOWN[0]}'"
    )
