"""``cycloid-mj build``: a model folder for any MuJoCo installation, with convex meshes in contact."""

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.outcome import Outcome
from cycloid_mj.base.overwrite_guard import claim_outputs
from cycloid_mj.base.result import Table
from cycloid_mj.cli.delivery import Destination, claim_page, deliver
from cycloid_mj.cli.flags import (
    COMMON,
    FLAT,
    STEP,
    TIMESTEP,
    CommonFlags,
    DesignOptions,
    integer_flag,
    number_flag,
)
from cycloid_mj.cli.outfile import claim_folder
from cycloid_mj.cli.terminal import note
from cycloid_mj.reducer import Reducer, reducer_of

if TYPE_CHECKING:
    from cycloid_mj.parts.convex import Plain

EXAMPLES = """Examples:
  cycloid-mj build --design pin --out models/pin
  cycloid-mj build --design nonpin --timestep-us 5 --out nonpin
  cycloid-mj build --design pin --out pin --plain-coacd"""

HEADER = ("surface", "parts", "overfill max", "rms", "underfill max", "rms", "volume error")

OutFlag = Annotated[
    str, Parameter(metavar="DIR", help="Output folder of the model; it is created if it does not exist.")
]
ChordFlag = Annotated[
    float,
    number_flag("Maximum distance between the slices of a flank and the profile [um]. Default: 0.1.", (0.001, 10.0)),
]
SeedFlag = Annotated[int, integer_flag("Seed of CoACD. Default: 0.", (0, 2**31 - 1))]
PlainFlag = Annotated[
    bool,
    Parameter(
        name="--plain-coacd",
        help="Also decompose the toothed parts by CoACD alone, at thresholds 0.05 and 0.02, and print its errors for "
        "comparison. Takes minutes and writes no files.",
    ),
]


def build(
    design_options: Annotated[DesignOptions, FLAT],
    *,
    out: OutFlag,
    timestep_us: Annotated[float | None, TIMESTEP.flag(f"Time step of the model{STEP}")] = None,
    chord_error_um: ChordFlag = 0.1,
    seed: SeedFlag = 0,
    plain_coacd: PlainFlag = False,
    output_flags: Annotated[CommonFlags, FLAT] = COMMON,
) -> int:
    """Write a model folder for any MuJoCo installation: DIR/scene.xml.

    The parts collide by convex meshes: working surfaces are divided into slices by their curvature, the rest is
    decomposed by CoACD. The model has keyframes (home, rest_90, ..., 1640rpm_0, ...), sensors, a speed servo on the
    crank and the load torque on the output. In an RV reducer only the teeth of the discs collide; crank bearings and
    planet meshes are springs without friction.

    manifest.json lists versions, settings and the deviation of each convex surface from the true surface, along its
    normals. If a decomposition exceeds its error bound, the command fails and writes nothing. The same design and
    settings produce identical files. With --plain-coacd, the deviations of a decomposition by CoACD alone are printed,
    too; the model is the same.
    """
    from dataclasses import replace

    from cycloid_mj.dynamics.mjcf.folder import MANIFEST, SCENE, model_files, write_folder
    from cycloid_mj.parts.convex import ConvexSettings

    reducer = reducer_of(design_options.resolve_checked([(TIMESTEP, timestep_us)]))
    _require_writable(out)
    claim_outputs(Path(out) / SCENE, Path(out) / MANIFEST, force=output_flags.force)
    page = claim_page(output_flags, f"{reducer.design.name}-model")
    settings = ConvexSettings(chord_error=chord_error_um * 1e-6)
    settings = replace(settings, coacd=replace(settings.coacd, seed=seed))
    note(f"decomposing the parts of {reducer.design.name} into convex pieces")
    files = model_files(reducer, settings)
    directory = claim_folder(out, "the model", files, output_flags.force)
    write_folder(files, directory)
    deviations = _surface_deviations(files[MANIFEST])
    if plain_coacd:
        deviations |= _measure_plain_coacd(reducer, seed)
    rows = tuple(_tabulate_deviations(*item) for item in deviations.items())
    outcome = Outcome(
        title=f"model: {reducer.design.name}",
        text=[str(directory / SCENE)],
        tables=[Table("convex pieces against the true surfaces [um]", HEADER, rows)],
        result={"scene": str(directory / SCENE), "files": sorted(files), "quality": deviations},
    )
    return deliver(outcome, Destination("model", None, page), output_flags)


def _require_writable(out: str) -> None:
    """Raise CycloidError if the output folder `out` cannot be created or written to; do not create it."""
    existing_folder = Path(out)
    while not existing_folder.exists() and existing_folder != existing_folder.parent:
        existing_folder = existing_folder.parent
    if not existing_folder.is_dir() or not os.access(existing_folder, os.W_OK):
        reason = "is not writable" if existing_folder.is_dir() else "is a file"
        raise CycloidError(
            f"cannot write the model to {out}: {existing_folder} {reason}. Choose another folder with --out"
        )


def _surface_deviations(manifest: bytes) -> dict[str, dict[str, Any]]:
    """Read the deviations of the convex pieces from the true surfaces in the manifest (`quality_um`), by surface."""
    from json import loads

    content = loads(manifest)
    remaining_pieces = {f"{item['part']} rest {value}": item for value, item in enumerate(content["rest"], start=1)}
    return {**content["surfaces"], **remaining_pieces}


def _measure_plain_coacd(reducer: Reducer, seed: int) -> dict[str, dict[str, Any]]:
    """Decompose the toothed parts by CoACD alone, for comparison; return how far the pieces miss the true surfaces.

    The model instead divides the working surfaces into slices. A key of the result is a text with the part and the
    threshold of CoACD, such as "gear, plain CoACD 0.05". A value is that of `quality_um`: largest and rms overfill and
    underfill along the normals [um], error of the volume [1], and number of pieces. `seed` is the random seed of CoACD.
    """
    from cycloid_mj.dynamics.mjcf.folder import quality_um
    from cycloid_mj.parts.convex import CoacdSettings, plain_gear, plain_ring

    deviations: dict[str, dict[str, Any]] = {}
    for threshold in (0.05, 0.02):
        settings = CoacdSettings(threshold=threshold, seed=seed)
        note(f"decomposing the parts by CoACD alone, for comparison (threshold {threshold:g})")
        decompositions: list[Plain] = [plain_gear(reducer, settings)]
        if reducer.design.ring.kind == "nonpin":
            decompositions.append(plain_ring(reducer, settings))
        deviations |= {
            f"{decomposition.part}, plain CoACD {threshold:g}": quality_um(decomposition.quality)
            for decomposition in decompositions
        }
    return deviations


def _tabulate_deviations(name: str, deviations: dict[str, Any]) -> tuple[str, ...]:
    lengths = [f"{deviations[key]:.3f}" for key in ("max_overfill_um", "rms_overfill_um")]
    lengths += [f"{deviations[key]:.3f}" for key in ("max_underfill_um", "rms_underfill_um")]
    return (name, str(deviations["parts"]), *lengths, f"{deviations['volume_error']:.1e}")
