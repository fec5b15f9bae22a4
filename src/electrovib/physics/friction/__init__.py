"""From normal force to lateral force."""

from electrovib.physics.friction.base import AdhesiveShear as AdhesiveShear
from electrovib.physics.friction.base import Coulomb as Coulomb
from electrovib.physics.friction.base import Creep as Creep
from electrovib.physics.friction.base import FirstOrderLag as FirstOrderLag
from electrovib.physics.friction.base import FollowingFriction as FollowingFriction
from electrovib.physics.friction.base import Friction as Friction
from electrovib.physics.friction.base import Load as Load
from electrovib.physics.friction.base import PowerLaw as PowerLaw
from electrovib.physics.friction.base import SteadyFriction as SteadyFriction
from electrovib.physics.friction.bristle import BristleFriction as BristleFriction
from electrovib.physics.friction.bristle import Bristles as Bristles
from electrovib.physics.friction.bristle import Dahl as Dahl
from electrovib.physics.friction.bristle import LuGre as LuGre
