"""Formulas and models only, as in a textbook: no files, no plots, no fits.

Each layer has a role: of the plate, of the gap or of the finger. Laws, diagnostics and solvers find the interface by roles
and never by names, so a layer cut in two is the same layer. Conduction is declared apart from polarisation, because no
spectrum contains it; moisture sets the parameters that it affects when a scenario is made, so that every table shows the
values of the computation.

A family declares what the mechanics asks: a friction its `memory` and whether it `deflects`, a contact whether its area
`grows`, a time profile whether it `is_constant`. It never asks for the class of a model, so one of another package is never
computed as the one that it is derived from.
"""
