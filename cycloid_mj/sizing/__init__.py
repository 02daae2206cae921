"""Sizing: from what is asked of a drive to designs that do it, or to the most that goes and what would help."""
