"""Simulate cycloidal speed reducers in MuJoCo: geometry, contact dynamics, logs and comparison with closed forms."""

__version__ = "0.1.0"
