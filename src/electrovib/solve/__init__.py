"""The scenario, and everything numerical."""
