"""Friction, skin, contact and sensor readings under the attraction.

Behind a friction without memory all elements are linear, and their input is a square: under a drive of few straight pieces they
have a closed form; else a grid is halved until the outputs have converged, and the Trace states the change
(`mechanics_error`). Bristles are stepped; a kink ends a step, which is solved
again until its end is the root, because a state read inside a step is of lower order. Contact and sliding are declared and
never inferred: off the plate friction is 0, at rest it is NaN unless a spring holds it, and NaN enters no filter.

The sensor under the plate reads the load alone while the finger touches, because the contact pressure balances the
attraction.
"""
