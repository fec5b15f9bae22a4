"""From forces to what the skin does and what the rig reads."""

from electrovib.solve.chain.respond import respond_mechanically
from electrovib.solve.chain.rig import Measured, finger_filters, measured, refuse_readings

__all__ = ["Measured", "finger_filters", "measured", "refuse_readings", "respond_mechanically"]
