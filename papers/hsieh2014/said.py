"""What the paper says of stress, as numbers (Hsieh 2014, Figs 12-16); all of it at no load (section 3.3)."""

FIGURES = {"shaft": "Fig. 12", "gear": "Fig. 13", "ring": "Fig. 14", "output": "Fig. 15", "pin_1": "Fig. 16"}

HEIGHTS = {
    ("shaft", "pin"): 160.0,
    ("shaft", "nonpin"): 60.0,
    ("ring", "pin"): 65.0,
    ("ring", "nonpin"): 50.0,
    ("gear", "pin"): 20.0,
    ("gear", "nonpin"): 10.0,
}
"""Up to about where the curve of a part reaches in a design [MPa]."""

ORDER = ("shaft", "ring", "gear")
"""Parts from the most to the least stressed, in both designs."""

SHAFT_PEAKS = (75.0, 255.0)
"""Crank angles of the shaft's two peaks in the pin design [deg]; the maximum is at 74."""

PIN_1_LOADED = (350.0, 10.0)
"""Crank angles between which pin 1 is loaded, over 0 [deg]."""

LEAST, MOST = 0.5, 1.1
"""A height agrees from half of the paper's to a tenth above it."""

NEAR = 10.0
"""Crank angles this near each other agree [deg]: a mesh period."""
