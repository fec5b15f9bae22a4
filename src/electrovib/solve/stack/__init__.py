"""The stack of layers in numbers: over frequency, as relaxation modes, as physical states."""
