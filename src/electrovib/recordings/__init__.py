"""Reduction of recordings to forces, friction and release times, each with its uncertainty.

A number has one shape, an `Interval` (`interval`), with what it is from; a search is that of `fit.least_squares`, and what is
linear in its amplitudes is fitted by `Separable` (`transitions.modes`), so errors are judged in one place.
"""
