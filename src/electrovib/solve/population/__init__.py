"""Signals of many fingers: one scenario with other values of a few parameters for each finger.

The linear chain is one text for a scenario and for many: a number may be a column of shape (cases, 1), and arrays of what
depends on it have a leading axis of cases; what all share has no such axis. A pole that differs has a slot of its own, as the
order of rates differs between cases; cases with a 0 that others do not have, such as a conductivity, have fewer modes and
form their own group. Before arrays are used, two fingers are compared with the same two one by one, which finds a formula
that mixes fingers. What marches through time (limits, leaks, moving gaps, bristles) runs one case after the other, and the
result says why.
"""

from electrovib.solve.population.fingers import Population as Population
