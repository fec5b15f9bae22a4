"""Perception of vibration: frequency weighting of the tactile channels, and thresholds.

A displacement is felt by the channel whose weighted level is the highest. Levels are relative to a sine of the same
amplitude at the best frequency, in decibels. They become levels above threshold by a threshold and a compliance: those of
the person at hand, or else published ones, as assumptions with their spread.
Summation over time and area, masking and motion are not modelled.
"""

from electrovib.physics.perception.channels import BEST_FREQUENCIES as BEST_FREQUENCIES
from electrovib.physics.perception.channels import RYU as RYU
from electrovib.physics.perception.channels import Channel as Channel
from electrovib.physics.perception.channels import DetectionThreshold as DetectionThreshold
from electrovib.physics.perception.channels import NonPacinian as NonPacinian
from electrovib.physics.perception.channels import Pacinian as Pacinian
from electrovib.physics.perception.person import COMPLIANCES as COMPLIANCES
from electrovib.physics.perception.person import MOTION as MOTION
from electrovib.physics.perception.person import UNVERIFIED_CORNER as UNVERIFIED_CORNER
from electrovib.physics.perception.person import ElasticSkin as ElasticSkin
from electrovib.physics.perception.person import ElasticViscousSkin as ElasticViscousSkin
from electrovib.physics.perception.person import Perception as Perception
from electrovib.physics.perception.person import SkinCompliance as SkinCompliance
from electrovib.physics.perception.person import decibels as decibels
from electrovib.physics.perception.person import felt_amplitude as felt_amplitude
from electrovib.physics.perception.person import strongest as strongest
