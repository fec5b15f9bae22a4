"""Real instruments; nothing yet."""
