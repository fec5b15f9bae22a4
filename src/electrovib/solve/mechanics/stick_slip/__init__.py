"""Skin that sticks and slips behind bristles, marched step by step."""
