"""Signals of many fingers: one scenario with other values of a few parameters for each finger."""
