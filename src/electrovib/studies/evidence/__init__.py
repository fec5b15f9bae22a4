"""Laws judged by what was measured; here is what a paper declares its measurements with, and the modules judge them."""

from electrovib.studies.evidence.measurement import Measurement as Measurement
from electrovib.studies.evidence.quantities import between as between
