"""Numerical forms of the stack of layers: over frequency, as relaxation modes, as physical states."""
