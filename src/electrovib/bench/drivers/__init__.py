"""Drivers of instruments, one file for each maker and model; a driver refuses every other model."""
