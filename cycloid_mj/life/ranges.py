"""The stress ranges that a study by finite elements has found, read from its result file."""

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cycloid_mj.base.errors import UsageError, reason
from cycloid_mj.base.overwrite_guard import as_input
from cycloid_mj.reducer import Reducer

RESULT = "stress.json"


@dataclass(frozen=True)
class StressRange:
    """Stress over a turn at the worst node of a part: `amplitude` and `mean` [Pa], under a `load` [N m]."""

    amplitude: float
    mean: float
    load: float


def read_ranges(path: Path, reducer: Reducer) -> dict[str, StressRange]:
    """Collect the stress ranges of a design's parts by part, from the folder or result file of ``cycloid-mj stress``.

    Raises
    ------
    UsageError
        There is no such file, it is no result of ``stress``, or it has no loaded study of that design.
    """
    design = reducer.design
    file = path / RESULT if path.is_dir() else path
    try:
        content = json.loads(as_input(file).read_text(encoding="utf-8"))
        studies = {str(one["design"]): one for one in content["designs"]}
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(
            f"cannot read {file}: {reason(error)}; give the folder that cycloid-mj stress wrote, which has {RESULT}"
        ) from error
    except (ValueError, KeyError, TypeError) as error:
        raise UsageError(f"{file} is no result of cycloid-mj stress: it has no designs") from error
    if design.name not in studies:
        raise UsageError(f"{file} has no study of {design.name}, but of {', '.join(studies) or 'none'}")
    study = studies[design.name]
    load = _number(study.get("load_nm"))
    if not load:
        raise UsageError(f"{file} is of a run without load, which wears nothing out: give stress a --load-nm")
    ranges = {
        str(part.get("part")): StressRange(1e6 * amplitude, 1e6 * mean, abs(load))
        for part in study.get("parts", [])
        if isinstance(part, dict)
        and (values := part.get("range"))
        and math.isfinite(amplitude := _number(values.get("amplitude_mpa")))
        and math.isfinite(mean := _number(values.get("mean_mpa")))
    }
    if not ranges:
        raise UsageError(f"{file} has no stress ranges: make it anew with cycloid-mj stress --design {design.name}")
    return ranges


def _number(value: Any) -> float:
    return float(value) if isinstance(value, int | float) else math.nan
