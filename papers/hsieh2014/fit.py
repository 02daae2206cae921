"""Which log fits a design: the name that a run of it has, and whether a log is that run."""

import hashlib
from collections.abc import Mapping

from cycloid_mj.design import Design, dump
from cycloid_mj.record import Run

DIGITS = 12


def digest(design: Design, provenance: Mapping[str, str]) -> str:
    """Give the hash of a design and of what a run of it stands on: contact, step, versions."""
    told = dump(design) + "".join(f"\n{key}={value}" for key, value in sorted(provenance.items()))
    return hashlib.sha256(told.encode()).hexdigest()[:DIGITS]


def log_name(design: Design, provenance: Mapping[str, str]) -> str:
    """Give the file name of a design's log."""
    load = f"{design.load.torque:g}Nm" if design.load.torque else "no-load"
    return f"{design.name}-{load}-{digest(design, provenance)}.mcap"


def fits(run: Run, design: Design, provenance: Mapping[str, str]) -> bool:
    """Whether a run reached its end, has this design, and stands on these versions and this step."""
    same = all(run.provenance.get(key) == value for key, value in provenance.items())
    return run.complete and same and run.attachments.get("design.toml") == dump(design).encode()
