"""Contact of finger and plate: areas, response of the surface topography to pressure, attraction against the gap."""

from electrovib.physics.contact.area import Closing, Contact, FixedArea, GrowingArea
from electrovib.physics.contact.attraction import Attraction, PlateAttraction, RoughAttraction
from electrovib.physics.contact.rough_surface import PerssonSurface, RoughSurface
from electrovib.physics.contact.surface import LinearSpring, Surface

__all__ = [
    "Attraction",
    "Closing",
    "Contact",
    "FixedArea",
    "GrowingArea",
    "LinearSpring",
    "PerssonSurface",
    "PlateAttraction",
    "RoughAttraction",
    "RoughSurface",
    "Surface",
]
