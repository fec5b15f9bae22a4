"""Numerical solution of scenarios.

Section of the stack over frequency -> materials as Debye sums -> modes -> law -> response in time -> attraction -> friction,
skin and sensors -> diagnostics (`simulate`). Values are exact at the output times, whatever these are; an interpolation, a
time stepping or a reduced material states its error in the Trace. A scenario needs no option for its solver: `choice.SOLVERS`
is ordered, the first that accepts the scenario is used, what each accepts and refuses is declared there alone, and the Trace
says which one and why.

Before anything is computed a solver has to accept the scenario, and what can be counted has to fit the budget (`effort`); the
rest is measured: a `Meter` in every loop of time steps or cases ends it once the budget is spent or foreseen to be (`meter`).
`nonlinear` is slow and general; the tests hold every fast solver against it.
"""
