"""Contact of finger and plate: areas, response of the surface topography to pressure, attraction against the gap."""

from electrovib.physics.contact.area import Closing as Closing
from electrovib.physics.contact.area import Contact as Contact
from electrovib.physics.contact.area import FixedArea as FixedArea
from electrovib.physics.contact.area import GrowingArea as GrowingArea
from electrovib.physics.contact.attraction import Attraction as Attraction
from electrovib.physics.contact.attraction import PlateAttraction as PlateAttraction
from electrovib.physics.contact.attraction import RoughAttraction as RoughAttraction
from electrovib.physics.contact.rough_contact import RoughContact as RoughContact
from electrovib.physics.contact.surface import FittedSurface as FittedSurface
from electrovib.physics.contact.surface import LinearSpring as LinearSpring
from electrovib.physics.contact.surface import PerssonSurface as PerssonSurface
from electrovib.physics.contact.surface import RoughSurface as RoughSurface
from electrovib.physics.contact.surface import Surface as Surface
