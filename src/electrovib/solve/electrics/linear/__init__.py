"""Linear layers under a voltage or a current: exact over time, from rest or in the periodic state."""
