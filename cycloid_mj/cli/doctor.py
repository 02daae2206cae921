"""``cycloid-mj doctor``: check this installation, and report missing components with their remedies."""

import platform
import subprocess
import sys
from collections.abc import Callable, Iterator
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from typing import Annotated, NamedTuple

from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.outcome import Outcome
from cycloid_mj.base.version import __version__
from cycloid_mj.cli.delivery import claim_destination, deliver
from cycloid_mj.cli.flags import DELIVERY, FLAT, Delivery

NEEDED = ("numpy", "scipy", "numba", "trimesh", "coacd", "mcap", "matplotlib", "pydantic", "cyclopts")
EXTRAS = {
    "cad": ("OCP",),
    "cluster": ("distributed",),
    "dxf": ("ezdxf",),
    "fem": ("gmsh", "skfem"),
    "optimize": ("cma",),
    "parquet": ("duckdb",),
    "rerun": ("rerun",),
    "video": ("av",),
}
"""Extra -> the modules that it installs."""

MOST_ERROR = 1e-3
"""Largest deviation of the disc's angle from the closed form in the self-test [rad]; a lobe has 0.18."""

EXAMPLES = """Examples:
  cycloid-mj doctor
  cycloid-mj doctor --json"""


class Finding(NamedTuple):
    """Result of one test of the installation: name, success, whether it is required, and the version or the remedy."""

    name: str
    well: bool
    needed: bool
    found: str

    def __str__(self) -> str:
        return f"{'ok' if self.well else 'FAIL' if self.needed else 'none':4}  {self.name}: {self.found}"


def doctor(*, output_flags: Annotated[Delivery, FLAT] = DELIVERY) -> int:
    """Check the installation and report missing components.

    The self-test simulates one millisecond of a reducer and compares it with the closed form; on first use it
    compiles the contact code, which takes some seconds. The exit code is 1 if a required component is missing.
    """
    from cycloid_mj.base.frame import make_frame

    destination = claim_destination(output_flags, "doctor")
    trials = (
        _run_test("self-test of MuJoCo", True, _test_contact),
        _run_test("contact and simulation", True, _simulate_self_test),
    )
    findings = [*_check_packages(), *_check_cache(), *trials, *_test_rendering(), *_check_extras()]
    rows = [finding._asdict() for finding in findings]
    title = f"cycloid-mj {__version__}, Python {platform.python_version()}, {platform.system()} {platform.machine()}"
    outcome = Outcome(
        title=title,
        text=[title, *map(str, findings)],
        frame=make_frame(rows, Finding._fields, {}),
        result={"version": __version__, "findings": rows},
        code=0 if all(finding.well for finding in findings if finding.needed) else 1,
    )
    return deliver(outcome, destination, output_flags)


def _check_packages() -> Iterator[Finding]:
    """Yield the result of the check of each required package: whether it is installed, and its version."""
    if find_spec("mujoco"):  # of the package mujoco or, from release 4 on, of mujoco-core alone
        import mujoco

        yield Finding("mujoco", True, True, mujoco.__version__)
    else:
        yield Finding("mujoco", False, True, "not installed: pip install mujoco")
    for name in NEEDED:
        try:
            yield Finding(name, True, True, version(name))
        except PackageNotFoundError:
            yield Finding(name, False, True, f"not installed: pip install {name}")


def _check_cache() -> Iterator[Finding]:
    from cycloid_mj.base.compiling import cacheable

    detail = (
        "compiled code is cached" if cacheable() else "no folder is writable: set NUMBA_CACHE_DIR to a folder that is"
    )
    yield Finding("compile cache", cacheable(), False, detail)


def _run_test(name: str, needed: bool, work: Callable[[], str]) -> Finding:
    try:
        return Finding(name, True, needed, work())
    except CycloidError as error:
        return Finding(name, False, needed, str(error))


def _test_contact() -> str:
    """Install the contact functions in MuJoCo; return a text for the report that states the release of MuJoCo.

    The installation tests memory layout, gaps and forces, once for each release of MuJoCo. Raises CycloidError if
    memory layout, gaps or forces differ from those expected.
    """
    import mujoco

    from cycloid_mj.dynamics.contact import collider, each_step

    with collider.install(), each_step.install():
        return f"release {mujoco.__version__} passes: memory layout, gaps and forces are as expected"


def _simulate_self_test() -> str:
    """Simulate a millisecond of a reducer with fixed pins, and compare the disc's angle with the closed form.

    Returns a text for the report: the number of samples and the largest difference of the angle [rad]. Raises
    CycloidError if the difference is too large.
    """
    from cycloid_mj.design import PRESETS, override
    from cycloid_mj.dynamics.run import simulate

    changes = ["ring.pins=fixed", "drive.ramp_s=0", "drive.hold_s=0.001", "load.torque_nm=5", "load.rise_s=0.0005"]
    design = override(PRESETS["pin"], changes)
    run = simulate(design)
    error = float(abs(run["gear_angle"] + run["crank_angle"] / design.lobes).max())
    if not error < MOST_ERROR:
        raise CycloidError(
            f"self-test: the angle of the disc differs by {error:.3g} rad from its closed-form value, but at most "
            f"{MOST_ERROR:.0e} rad is allowed. Reinstall cycloid-mj; report the problem if it persists"
        )
    return f"{len(run.time)} samples, disc angle within {error:.1g} rad of the closed form"


def _test_rendering() -> Iterator[Finding]:
    """Yield the result of the check whether OpenGL renders off-screen; rendering is optional.

    It is tried in a process of its own, because a driver that fails may end the process.
    """
    test_code = (
        "import mujoco; from cycloid_mj.scene.opengl import opengl\n"
        "model = mujoco.MjModel.from_xml_string('<mujoco/>')\n"
        "with opengl(model, 64, 64): pass"
    )
    process = subprocess.run([sys.executable, "-c", test_code], capture_output=True, text=True, check=False)
    reason = (
        process.stderr.strip().splitlines()[-1] if process.stderr.strip() else "the graphics driver ended the process"
    )
    is_working = process.returncode == 0
    yield Finding(
        "rendering (render, animate, view)", is_working, False, "off-screen OpenGL works" if is_working else reason
    )


def _check_extras() -> Iterator[Finding]:
    """Yield a finding for each optional extra of the package: whether all its modules are installed."""
    for extra, modules in EXTRAS.items():
        missing_modules = [module for module in modules if find_spec(module) is None]
        extra_text = (
            f"missing {', '.join(missing_modules)}: pip install 'cycloid-mj[{extra}]'"
            if missing_modules
            else "installed"
        )
        yield Finding(f"extra {extra}", not missing_modules, False, extra_text)
