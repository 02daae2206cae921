"""Exact conjugate contact: gaps, the collider that hands them to MuJoCo, and the law of force in each contact."""
