"""Drives whose predicted electrostatic force is a target, within declared limits."""
