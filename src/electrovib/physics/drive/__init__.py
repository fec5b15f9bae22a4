"""What the amplifier is asked for: voltage over time."""
