"""Where two rough surfaces touch: gap and pressure of a rough contact on a compliant body, with attraction.

The skin's heights and the plate's are one composite roughness on the body that yields, a grid of one period::

    heights, load, compliance of the waves        `physics.half_space`, in closed form; `cell`: transforms
    -> pressure where they touch, gap elsewhere   `pressed`: without attraction
    -> the same in equilibrium with the pull      `attracted`: local Maxwell stress of layers and gap, or any potential
    -> maps and what they add up to               `rest.Loaded.rest` -> `rest.Rest`
    -> over a voltage, up and down                `rest.follow`: each rest begins with the former
    -> over a rising voltage, kept in a table     `solved`: for runs, studies and fits of a scenario that declares the contact

Energies are those of the displacement g + h of a gap g over heights h: (g + h) K (g + h)/2 + load g + W(g), no gap below 0,
K(q) = 1/C(q) and K(0) = 0, so that the distance of the bodies is not an unknown. Its first derivative is the pressure of the
contact, which is 0 where the gap is open; its second one tells whether a state is stable. Without attraction the problem is
convex and the unknown is the pressure of the few points in contact; with attraction it is the gap of the many open ones. What
is solved in single precision is a correction; errors are those of double precision.

Inside, the unit of length is the rms height, and that of pressure what the longest wave needs to bend by it. Everything is
periodic. The bodies have no friction; slopes are small; the field at a place is that of parallel plates.
"""

from electrovib.solve.rough_contact.cell import Local as Local
from electrovib.solve.rough_contact.cell import MaxwellStress as MaxwellStress
from electrovib.solve.rough_contact.rest import Loaded as Loaded
from electrovib.solve.rough_contact.rest import Rest as Rest
from electrovib.solve.rough_contact.rest import doubts as doubts
from electrovib.solve.rough_contact.rest import follow as follow
from electrovib.solve.rough_contact.rest import follow_voltages as follow_voltages
from electrovib.solve.rough_contact.rest import refuse_beyond_budget as refuse_beyond_budget
from electrovib.solve.rough_contact.rest import words_of_spots as words_of_spots
