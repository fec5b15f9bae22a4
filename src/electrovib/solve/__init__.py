"""Numerical solution of scenarios."""
