"""Creep and temperature caveats of materials, added to every result that depends on their values."""

from cycloid_mj.design.materials import MATERIALS, SOFTEST_METAL
from cycloid_mj.design.model import PARTS, Design, Material


def material_limits(design: Design) -> tuple[str, ...]:
    """Tell up to which temperature the plastics of a design may be used, and that they creep; of metals nothing."""
    by_material: dict[Material, list[str]] = {}
    for part in PARTS:
        by_material.setdefault(design.material_of(part), []).append(part)
    limits = []
    for material, parts_of in by_material.items():
        entry = MATERIALS.get(material.name)
        if material.youngs_modulus < SOFTEST_METAL:
            what = f"{material.name or 'a plastic'} ({', '.join(parts_of)})"
            hottest = f" and holds up to {entry.hottest:g} °C ({entry.source})" if entry else ""
            limits.append(f"{what} creeps{hottest}: stiffness and strength here are those of a short load at 23 °C")
    return tuple(limits)
