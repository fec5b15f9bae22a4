"""Stick-slip motion of a skin with bristle friction, solved by time stepping."""
