"""The value of a parameter at which a quantity is as wanted for a share of a population."""
