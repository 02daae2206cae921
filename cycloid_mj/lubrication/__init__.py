"""Lubricated contacts: film thickness, journal bearings and mixed friction, as pure functions of arrays."""
