"""From forces to what the skin does and what the rig reads."""

from electrovib.solve.mechanics.chain.respond import respond_mechanically
from electrovib.solve.mechanics.chain.rig import Measured, finger_filters, measured, refuse_readings

__all__ = ["Measured", "finger_filters", "measured", "refuse_readings", "respond_mechanically"]
