"""A design as a folder that any MuJoCo user can open: MJCF, meshes, scene, design and manifest."""

import hashlib
import importlib.metadata
import json
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.atomic_write import write_files
from cycloid_mj.base.errors import CycloidError, reason, warn
from cycloid_mj.base.overwrite_guard import make_folder, remove_empty
from cycloid_mj.base.version import __version__
from cycloid_mj.design import dump
from cycloid_mj.dynamics.mjcf.keyframe import add_keyframes
from cycloid_mj.dynamics.mjcf.mesh import MeshSpec, add_remainder, mesh_spec, reducer_model
from cycloid_mj.dynamics.mjcf.model import xml
from cycloid_mj.dynamics.mjcf.scene import scene_xml
from cycloid_mj.dynamics.mjcf.sensors import add_sensors
from cycloid_mj.parts.convex import (
    ConvexSettings,
    ConvexSurface,
    Quality,
    Rest,
    decompose,
    require_convex_slices,
    sectors,
    surface_quality,
)
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.reducer.rv_bodies import crank_names

REDUCER, SCENE, MANIFEST, DESIGN = "reducer.xml", "scene.xml", "manifest.json", "design.toml"
ASSETS = "assets"


@dataclass(frozen=True)
class SpeedServo:
    """Speed servo of the crank in a model folder."""

    bandwidth: float = 2e3
    """[rad/s]."""
    torque_margin: float = 5.0
    """Largest torque, as a multiple of the design's rated input torque."""


SPEED_SERVO = SpeedServo()


FILM_WARNING = (
    'friction.law = "film" has no equivalent in stock MuJoCo: the sliding contacts of this model have the coefficient '
    "of boundary lubrication, so that it loses more power than the design"
)
"""Warning about the friction of a model folder."""


_NUMBER = re.compile(r"-?\d+\.\d{6,}(?:e[+-]?\d+)?")


def model_files(reducer: Reducer, settings: ConvexSettings | None = None) -> dict[str, bytes]:
    """Return every file of a MuJoCo model folder, by its path in the folder.

    `settings` are those of the convex meshes. Convex decomposition by CoACD takes about 10 s. The model differs from
    that of ``build_mesh``: the crank has a speed servo, whose ``ctrl`` is the speed [rad/s]; there are keyframes; and,
    except in an RV reducer, convex pieces behind the teeth collide with other objects.

    Raises
    ------
    DesignError
        A part of the design is not feasible, or does not support convex meshes; see ``mesh_spec``.
    ContactError
        MuJoCo cannot represent a contact's stiffness at this time step.

    Warns
    -----
    CycloidWarning
        Results of runs of this model may not be those of the design.
    """
    settings, reducer = settings or ConvexSettings(), reducer.for_slices
    mesh_model = mesh_spec(reducer, settings)
    surface_errors = {surface.key: _check_surface(surface, settings) for surface in mesh_model.surfaces}
    is_rv = isinstance(reducer, RvReducer)
    remainders = [] if is_rv else [decompose(sector, settings) for sector in sectors(reducer, settings)]
    for number, remainder in enumerate(remainders, start=1):
        add_remainder(mesh_model.spec, reducer, number, remainder)
    servo_gains = _add_servo_and_load(mesh_model, reducer)
    add_sensors(mesh_model.spec, reducer)
    add_keyframes(mesh_model.spec, reducer)
    mesh_model.spec.meshdir = ASSETS
    compiled = reducer_model(mesh_model, reducer, servo_gains)
    warn(reducer.design.name, compiled.warnings)
    if reducer.design.has_film:
        warn(reducer.design.name, (FILM_WARNING,))
    files = {f"{ASSETS}/{name}": content for name, content in sorted(mesh_model.spec.assets.items())}
    files[DESIGN] = dump(reducer.design).encode()
    files[REDUCER] = _reducer_xml(mesh_model.spec, reducer).encode()
    files[SCENE] = scene_xml(reducer, REDUCER).encode()
    files[MANIFEST] = _manifest_json(reducer, settings, compiled.model, surface_errors, remainders, files).encode()
    return files


def write_folder(files: Mapping[str, bytes], folder: Path) -> None:
    """Write the files of a model folder, all of them or none; other files in the folder stay.

    Raises
    ------
    CycloidError
        A file cannot be written.
    """
    assets = folder / ASSETS
    try:
        make_folder(assets)
    except OSError as error:
        raise CycloidError(
            f"cannot create the folder {assets}: {reason(error)}. Choose another folder with --out"
        ) from error
    try:
        write_files({folder / name: content for name, content in files.items()})
    except BaseException:
        remove_empty([assets])
        raise


def design_hash(reducer: Reducer) -> str:
    """Return the SHA-256 of a design's complete file."""
    return hashlib.sha256(dump(reducer.design).encode()).hexdigest()


def _check_surface(surface: ConvexSurface, settings: ConvexSettings) -> Quality:
    require_convex_slices(surface, settings.coacd)
    return surface_quality(surface)


def _add_servo_and_load(mesh_model: MeshSpec, reducer: Reducer) -> tuple[float, float]:
    """Add two actuators to an editable `mesh_model`: the speed servo of the crank, and the torque on the output.

    Returns
    -------
    tuple of float
        Gains of the servo: kp, which is 0, and kv [N m s/rad].
    """
    joint_transmission = mujoco.mjtTrn.mjTRN_JOINT
    drive_actuator = mesh_model.spec.add_actuator(
        name=names.DRIVE, target=reducer.INPUT_JOINT, trntype=joint_transmission
    )
    gain = mesh_model.crank_inertia * SPEED_SERVO.bandwidth
    drive_actuator.set_to_velocity(kv=gain)
    drive_actuator.forcelimited = True
    drive_actuator.forcerange = np.array([-1.0, 1.0]) * SPEED_SERVO.torque_margin * reducer.design.drive.torque
    load_actuator = mesh_model.spec.add_actuator(name=names.LOAD, target=names.OUTPUT_JOINT, trntype=joint_transmission)
    load_actuator.set_to_motor()
    return 0.0, gain


def _reducer_xml(spec: Any, reducer: Reducer) -> str:
    """Write the MJCF, each number as the shortest that reads back the same."""
    text = _NUMBER.sub(lambda match: repr(float(match.group())), xml(spec))
    name = reducer.design.name
    note = f"<!-- {name}: made by `cycloid-mj build` (cycloid_mj {__version__}); change the design, not this. -->\n"
    return note + text.rstrip() + "\n"


def _manifest_json(
    reducer: Reducer,
    settings: ConvexSettings,
    model: Any,
    surface_errors: Mapping[str, Quality],
    remainders: list[Rest],
    files: Mapping[str, bytes],
) -> str:
    """Return the manifest of a MuJoCo model folder as JSON text: versions, hashes, settings, masses and mesh errors.

    `model` is the compiled model. `surface_errors` are the errors of the sliced surfaces by key, such as ``teeth``,
    `remainders` the convex pieces behind them, `files` the contents of the other files by path, for their hashes.
    """
    design = reducer.design
    shafts = [names.SUN, *crank_names(reducer)] if isinstance(reducer, RvReducer) else [names.SHAFT]
    moving_bodies = [
        *shafts,
        *reducer.gears,
        names.OUTPUT,
        *([names.numbered_name(names.PIN, 1)] if design.ring.has_pin_bodies else []),
    ]
    manifest = {
        "design": {"name": design.name, "sha256": design_hash(reducer)},
        "versions": {
            "cycloid_mj": __version__,
            "mujoco": mujoco.__version__,
            "numpy": np.__version__,
            "coacd": importlib.metadata.version("coacd"),
        },
        "settings": asdict(settings),
        "timestep_s": model.opt.timestep,
        "geoms": model.ngeom,
        "meshes": model.nmesh,
        "mass_kg": {body: float(model.body(body).mass[0]) for body in (names.HOUSING, *moving_bodies)},
        "surfaces": {name: quality_um(quality) for name, quality in surface_errors.items()},
        "rest": [
            {"part": remainder.sector.part, "copies": remainder.sector.count, **quality_um(remainder.quality)}
            for remainder in remainders
        ],
        "sha256": {name: hashlib.sha256(content).hexdigest() for name, content in sorted(files.items())},
    }
    return json.dumps(manifest, indent=2) + "\n"


def quality_um(quality: Quality) -> dict[str, float]:
    """Return the errors of the convex decomposition of a part, rounded, by the keys of the manifest.

    ``max_overfill_um``, ``rms_overfill_um`` and the same of ``underfill`` are the largest and the rms distance [um] by
    which the convex parts extend beyond the surface or fall short of it. ``volume_error`` [1] is relative, ``parts``
    the number of convex parts, ``normals`` that of the sampled points. `quality` has the errors in SI units.
    """
    return {
        "parts": quality.parts,
        "max_overfill_um": round(1e6 * quality.max_overfill, 4),
        "rms_overfill_um": round(1e6 * quality.rms_overfill, 4),
        "max_underfill_um": round(1e6 * quality.max_underfill, 4),
        "rms_underfill_um": round(1e6 * quality.rms_underfill, 4),
        "volume_error": round(quality.volume_error, 7),
        "normals": quality.samples,
    }
