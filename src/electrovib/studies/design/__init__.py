"""Inverse questions about a scenario: the value, the drive or the plate that gives what is wanted. Each is one function."""
