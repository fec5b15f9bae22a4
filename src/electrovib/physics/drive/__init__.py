"""Drives: the voltage or current over time that the amplifier is asked to deliver."""
