"""Studies of many designs: comparison, sweeps, tolerances with error budget, and optimisation.

The package imports none of its modules: ratings need only the samples, without the studies.
"""
