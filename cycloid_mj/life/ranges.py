"""Stress ranges from the result file of a finite-element study."""

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cycloid_mj.base.errors import UsageError, reason
from cycloid_mj.base.overwrite_guard import note_input
from cycloid_mj.reducer import Reducer

RESULT = "stress.json"


@dataclass(frozen=True)
class StressRange:
    """Stress at the worst node of a part over a turn: `amplitude` and `mean` [Pa], under a `load` [N m]."""

    amplitude: float
    mean: float
    load: float


def read_ranges(path: Path, reducer: Reducer) -> dict[str, StressRange]:
    """Read the stress range of each part of a design, by name, from folder or result file of ``cycloid-mj stress``.

    A range is the amplitude and mean over a turn of the stress at the worst node [Pa], with the load of the study [N
    m]. A name is that of a part in the study, such as "ring".

    Raises
    ------
    UsageError
        The file does not exist, is no result of ``stress``, or has no study of that design under load.
    """
    design = reducer.design
    file = path / RESULT if path.is_dir() else path
    try:
        content = json.loads(note_input(file).read_text(encoding="utf-8"))
        studies = {str(study["design"]): study for study in content["designs"]}
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(
            f"cannot read {file}: {reason(error)}. Give the output folder of `cycloid-mj stress`, which contains "
            f"{RESULT}"
        ) from error
    except (ValueError, KeyError, TypeError) as error:
        raise UsageError(
            f"{file} is not a result of `cycloid-mj stress`, because it contains no designs. Give the output folder of "
            "`cycloid-mj stress`"
        ) from error
    if design.name not in studies:
        raise UsageError(
            f"{file} contains no results for the design {design.name}, only for: {', '.join(studies) or 'none'}. Run "
            "`cycloid-mj stress` for this design"
        )
    study = studies[design.name]
    load = _number(study.get("load_nm"))
    if not load:
        raise UsageError(
            f"{file} contains results without a load, but stress ranges need one. Run `cycloid-mj stress` again with "
            "--load-nm"
        )
    ranges = {
        str(part.get("part")): StressRange(1e6 * amplitude, 1e6 * mean, abs(load))
        for part in study.get("parts", [])
        if isinstance(part, dict)
        and (range_values := part.get("range"))
        and math.isfinite(amplitude := _number(range_values.get("amplitude_mpa")))
        and math.isfinite(mean := _number(range_values.get("mean_mpa")))
    }
    if not ranges:
        raise UsageError(f"{file} contains no stress ranges. Run `cycloid-mj stress --design {design.name}` again")
    return ranges


def _number(value: Any) -> float:
    """Convert a JSON value to a number; NaN if it is none."""
    return float(value) if isinstance(value, int | float) else math.nan
