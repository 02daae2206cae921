"""The reducer in motion: contact as MuJoCo solves it, the model, its course and its run."""
