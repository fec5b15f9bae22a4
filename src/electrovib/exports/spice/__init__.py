"""A scenario as a netlist for ngspice."""
