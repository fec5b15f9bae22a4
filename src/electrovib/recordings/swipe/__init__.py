"""A swipe of a finger over a plate: its record reduced to normal force, lateral force and friction."""

from electrovib.recordings.swipe.reduce import SwipeResult, reduce_swipe, reduce_swipes

__all__ = ["SwipeResult", "reduce_swipe", "reduce_swipes"]
