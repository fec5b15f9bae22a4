"""Numerical forms of the stack of layers: over frequency, as relaxation modes, as physical states.

A law only adds and multiplies, so phasors and transfer functions run through the same one, and the responses over frequency
and over time cannot disagree. K^(-1/2) of the law of Vezzoli et al. 2014 is a Gauss quadrature of its spectral density, not a
fit.

Residues of the bound displacement are all positive, so nothing cancels. A vanishing gap keeps the charge that the plate
conducts up to it, the cause of the Johnsen-Rahbek effect: its field is an integral of the current and not the bound
displacement of the plate. An integrator is a mode of 1e-30/s, which solvers and filters treat as any other. Two electrodes
that a finger bridges are one stack in series with itself, scaled by the ratio of the areas.
"""
