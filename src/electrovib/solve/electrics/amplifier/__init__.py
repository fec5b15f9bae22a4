"""The amplifier before the stack: gain, bandwidth, and limits of voltage, slope and current."""
