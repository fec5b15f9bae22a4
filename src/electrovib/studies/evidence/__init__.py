"""Laws judged by what was measured; `files` reads measurements, and other modules judge."""

from electrovib.studies.evidence.measurement import Measurement as Measurement
