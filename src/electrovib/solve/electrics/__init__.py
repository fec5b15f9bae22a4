"""What the drive does to the stack over time: voltages, currents, fields and the attraction."""
