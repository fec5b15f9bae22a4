"""From the attraction to friction, skin, contact and what the sensors of a rig read."""
