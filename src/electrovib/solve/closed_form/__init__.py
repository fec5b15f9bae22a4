"""Signals under a drive of straight pieces in closed form: sums of polynomials and exponentials on each piece."""
