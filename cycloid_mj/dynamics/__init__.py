"""Motion of the reducer: contact in MuJoCo, the model, its drive cycle and its run."""
