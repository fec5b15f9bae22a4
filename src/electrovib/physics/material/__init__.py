"""Dielectrics: relative permittivity over frequency, with conduction declared separately."""

from electrovib.physics.material.base import Material as Material
from electrovib.physics.material.relaxations import ColeCole as ColeCole
from electrovib.physics.material.relaxations import ColeColeTerm as ColeColeTerm
from electrovib.physics.material.relaxations import Constant as Constant
from electrovib.physics.material.relaxations import ConstantPhase as ConstantPhase
from electrovib.physics.material.relaxations import Debye as Debye
from electrovib.physics.material.relaxations import DebyeTerm as DebyeTerm
from electrovib.physics.material.relaxations import HavriliakNegami as HavriliakNegami
from electrovib.physics.material.relaxations import Prony as Prony
