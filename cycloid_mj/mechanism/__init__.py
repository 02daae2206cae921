"""The reducer as rigid parts that meet in gaps: every gap near the ideal pose, stated once with its sign.

Owns the gaps and what follows from them without friction or inertia: whether the parts go together (`fit`), how far the
output turns at a locked crank (`play`), and the pose in which springs balance a load (`kernel`).
"""
