"""Vectors of numbers in compiled code: their type, their operations, and how kernels are compiled."""
