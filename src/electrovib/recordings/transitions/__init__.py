"""Times between levels, relaxations and oscillations of recorded edges, without a model of the experiment."""

from electrovib.recordings.transitions.result import MeasuredTimes
from electrovib.recordings.transitions.ring import measure_ring, measure_rings
from electrovib.recordings.transitions.ring_result import MeasuredRing, MeasuredRings
from electrovib.recordings.transitions.sensor import Sensor
from electrovib.recordings.transitions.times import measure_times

__all__ = [
    "MeasuredRing",
    "MeasuredRings",
    "MeasuredTimes",
    "Sensor",
    "measure_ring",
    "measure_rings",
    "measure_times",
]
