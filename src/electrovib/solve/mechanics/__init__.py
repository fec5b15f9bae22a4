"""Friction, skin, contact and sensor readings under the attraction."""
