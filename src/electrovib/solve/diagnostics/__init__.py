"""Validity of a result."""
