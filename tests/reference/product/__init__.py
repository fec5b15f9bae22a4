"""Scenarios as a product of what their models may be, and what each has to answer."""
