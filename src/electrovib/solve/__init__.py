"""Numerical solution of scenarios.

One chain, from top to bottom; every number may be a column of shape (cases, 1), and what depends on it has that axis first::

    scenario                                                    a frozen model, checked           `choice`, `effort`, `meter`
    -> Debye terms, modes    rates (modes,), gains (modes,)     of every linear quantity          `stack`
    -> response in time      (quantities, n) or with cases      straight pieces, sines, marches   `electrics`, `recursion`
    -> pull, attraction      (n,)                               law of the force, contact area    `electrics.attraction`
    -> friction, skin, rig   (n,)                               filters: exact, or in steps       `mechanics`
    -> diagnostics           largest values, errors of memory   over the whole run                `diagnostics`

    `expanded.Expanded.at(times, wanted=...)`  this chain for one scenario, at any times; keeps what has not changed
        <- `simulate`                      all signals, judged, as a Trace
        <- `one_by_one.ParametricScenario` a few signals for values of a few parameters, one point after the other: fits
        <- `quantities.resolve`            means and extremes: polynomials on pieces that are halved until they resolve it
    `population.Population.signals(columns)`   the same text for columns (cases, 1)            rows (cases, n)
        linear quantities   rates, gains (modes,) or (cases, modes)                            `electrics.transient.Response`
        drive               sum of factor (cases, 1) times the parts of a drive                `population.drive`
    `quantities.cases`                         cases on a mesh: rows (cases, n) -> (cases, pieces, nodes) -> numbers (cases,)
        <- `prepare.Prepared`              many points in columns on common meshes
        <- `answers`                       a sweep; scenarios under tones at once, each on pieces of its own period

Values are exact at the output times, whatever these are; an interpolation, a time stepping or a reduced material states its
error in the Trace. A scenario needs no option for its solver: `choice.SOLVERS` is ordered, the first that accepts the scenario
is used, what each accepts and refuses is declared there alone, and the Trace says which one and why.

Before anything is computed a solver has to accept the scenario, and what can be counted has to fit the budget (`effort`); the
rest is measured: a `Meter` in every loop of time steps or cases ends it once the budget is spent or foreseen to be (`meter`).
`nonlinear` is slow and general; the tests hold every fast solver against it.
"""
