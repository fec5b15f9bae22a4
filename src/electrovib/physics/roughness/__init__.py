"""Rough contact: a distribution of local gaps, and the attraction averaged over gaps and contact spots.

At each place the layers and the local gap are treated as parallel plates in series. That holds where the roughness
varies along the surface over lengths that are long compared with 2 pi T_i, T_i being the thickness of the insulator: on
a coating of a micrometre, not on a film of 90 um (0.57 mm, more than the period of a fingerprint).
"""

from electrovib.physics.roughness.pull import NODES, REACH, GaussianGaps, Pull, local_pull, mean_pull
from electrovib.physics.roughness.spots import ContactSpots, IdleSpots, LeakingSpots, PullingSpots
from electrovib.physics.roughness.touching import contact_fraction, contact_growth

__all__ = [
    "NODES",
    "REACH",
    "ContactSpots",
    "GaussianGaps",
    "IdleSpots",
    "LeakingSpots",
    "Pull",
    "PullingSpots",
    "contact_fraction",
    "contact_growth",
    "local_pull",
    "mean_pull",
]
