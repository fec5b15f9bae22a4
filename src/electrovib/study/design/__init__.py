"""Inverse problems: parameters and drives that give a wanted force."""
