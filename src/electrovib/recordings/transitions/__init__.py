"""Times between levels, relaxations and oscillations of recorded edges, without a model of the experiment."""

from electrovib.recordings.transitions.relaxation import Sensor
from electrovib.recordings.transitions.ring import MeasuredRing, MeasuredRings, measure_ring, measure_rings
from electrovib.recordings.transitions.times import MeasuredTimes, measure_times

__all__ = [
    "MeasuredRing",
    "MeasuredRings",
    "MeasuredTimes",
    "Sensor",
    "measure_ring",
    "measure_rings",
    "measure_times",
]
