"""Reduction of recordings to forces, friction and release times, each with its uncertainty."""
