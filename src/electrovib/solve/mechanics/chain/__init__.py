"""Motion of the skin and readings of the rig under given forces."""

from electrovib.solve.mechanics.chain.respond import respond_mechanically
from electrovib.solve.mechanics.chain.rig import Measured, finger_filters, measured, refuse_readings

__all__ = ["Measured", "finger_filters", "measured", "refuse_readings", "respond_mechanically"]
