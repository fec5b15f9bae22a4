"""A simulated bench: instruments that answer the commands of the real ones, an amplifier, and a finger of our own model."""
