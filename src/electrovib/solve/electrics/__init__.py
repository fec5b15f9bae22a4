"""What the drive does to the stack over time: voltages, currents, fields and the attraction.

A leak is a second drive: the stack responds to it as linearly as to the first, and a law needs no nonlinear form. A current
is computed from the lag of each mode behind the drive, because a difference of large voltages would lose it. Where the area
grows with the force, the smallest equilibrium is used, which follows from the load alone, and a diagnostic names the others;
the circuit keeps the area under full load, because modes need a fixed one.
"""
