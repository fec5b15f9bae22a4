"""Quantities of a scenario, requested by name."""
