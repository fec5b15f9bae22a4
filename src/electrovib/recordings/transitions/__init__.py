"""Times between levels, relaxations and oscillations of recorded edges, without a model of the experiment."""

from electrovib.recordings.transitions.relaxation import Sensor as Sensor
from electrovib.recordings.transitions.ring import MeasuredRing as MeasuredRing
from electrovib.recordings.transitions.ring import MeasuredRings as MeasuredRings
from electrovib.recordings.transitions.ring import measure_ring as measure_ring
from electrovib.recordings.transitions.ring import measure_rings as measure_rings
from electrovib.recordings.transitions.times import MeasuredTimes as MeasuredTimes
from electrovib.recordings.transitions.times import measure_times as measure_times
