"""A swipe of a finger over a plate: its record reduced to normal force, lateral force and friction."""
