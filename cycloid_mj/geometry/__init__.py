"""Exact tooth geometry and kinematics in closed form: pure functions of a mesh, and of the design's deviations."""
