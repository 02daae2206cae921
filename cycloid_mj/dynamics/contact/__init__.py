"""Exact conjugate contact: gaps, the collider that passes them to MuJoCo, and the force law of each contact."""
