"""The reducer as rigid parts that meet in gaps: every gap near the ideal pose, stated once with its sign.

Owns the reducer as a value (`reducer`), its gaps (`gaps`), and what follows from them without inertia: whether the
parts go together and how far the output turns at a locked crank (`limits`), and the pose in which springs balance a
load (`kernel`).
"""
