"""From normal force to lateral force."""

from electrovib.physics.friction.base import FollowingFriction as FollowingFriction
from electrovib.physics.friction.base import Friction as Friction
from electrovib.physics.friction.base import Load as Load
from electrovib.physics.friction.base import SteadyFriction as SteadyFriction
from electrovib.physics.friction.bristle import BristleFriction as BristleFriction
from electrovib.physics.friction.bristle import Bristles as Bristles
from electrovib.physics.friction.bristle import Dahl as Dahl
from electrovib.physics.friction.bristle import LuGre as LuGre
from electrovib.physics.friction.steady import AdhesiveShear as AdhesiveShear
from electrovib.physics.friction.steady import Coulomb as Coulomb
from electrovib.physics.friction.steady import Creep as Creep
from electrovib.physics.friction.steady import FirstOrderLag as FirstOrderLag
from electrovib.physics.friction.steady import PowerLaw as PowerLaw
