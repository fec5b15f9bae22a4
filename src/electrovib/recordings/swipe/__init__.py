"""A swipe of a finger over a plate: its record reduced to normal force, lateral force and friction."""

from electrovib.recordings.swipe.reduce import reduce_swipe, reduce_swipes
from electrovib.recordings.swipe.result import SwipeResult, Swipes

__all__ = ["SwipeResult", "Swipes", "reduce_swipe", "reduce_swipes"]
