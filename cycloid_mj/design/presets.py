"""The two designs of the paper by name."""

from cycloid_mj.design.model import Design, Ring

PRESETS = {
    "pin": Design(),
    "nonpin": Design(name="nonpin", ring=Ring(kind="nonpin")),
}
