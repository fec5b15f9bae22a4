"""Times between levels, relaxations and oscillations of recorded edges, without a model of the experiment."""
