"""The statistical laws of rough contact beside contact and attraction solved together, on twelve surfaces.

Run from the root of the repository with ``python -m benchmarks.rough_laws``. A law is one of those that `run`, `study` and
`evidence` use; every ratio is that of the law over the solver. Nothing that is fitted here is used by a law.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from benchmarks.table import surroundings, write_page

from electrovib.core.constants import eps0
from electrovib.physics.contact.rough_surface import MOST_TOUCHING, gaussian_gaps
from electrovib.physics.roughness import PullingSpots, contact_fraction, local_pull, mean_pull
from electrovib.physics.topography import SelfAffine
from electrovib.solve.rough_contact import Elastic, Loaded, MaxwellStress, Rest

POINTS, SURFACES = 256, 12
LOADS = (1e3, 7e3, 50e3)
BETWEEN = (2.6e3, 19e3)
"""Further loads [Pa] without attraction, for the mean gap over load."""
PULLS = (0.0, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0)
"""Attraction of a closed gap over the load, which sets the voltage."""
LEAST = 1e-3
"""Contact share below which a grid has too few points of contact for a comparison."""
GOAL = 0.15
PREDICTED = (
    "Predicted before the first run: contact share without voltage 0.75 (0.55 to 0.9), with voltage 0.7 (0.4 to 1.1);"
    " attraction of plates 0.5 (0.1 to 1), of Gaussian gaps with the law's share 0.85 (0.6 to 1), with the solver's share"
    " 1.0 (0.8 to 1.2); decay factor 0.5 (0.4 to 0.7), pressure factor 0.4 of the roll-off wave number times the rms height;"
    " exponential within 20 % of the load; with attraction the mean gap 0.95 of that at load plus attraction."
)


class Surface(NamedTuple):
    """Roughness, effective modulus [Pa], electrical thickness [m] of what lies on it, and the seed of its phases."""

    roughness: SelfAffine
    modulus: float
    electrical_thickness: float
    seed: int

    @property
    def periods(self):
        return (self.roughness.longest,) * 2

    def loaded(self, load):
        heights = self.roughness.heights((POINTS, POINTS), self.periods, seed=self.seed)
        body = Elastic(modulus=self.modulus * 0.75, poisson=0.5)
        return Loaded(heights=heights, periods=self.periods, compliance=body.compliance, pressure=load)


class Case(NamedTuple):
    """A surface at rest under a load [Pa] and a voltage [V]."""

    surface: Surface
    load: float
    voltage: float
    rest: Rest

    @property
    def borne(self):
        """Pressure [Pa] that the law's contact bears: load and attraction."""
        return self.load + self.rest.mean_attraction

    @property
    def reduced(self):
        slope = self.surface.roughness.rms_slope(self.surface.periods)
        return self.borne / (self.surface.modulus * slope)

    def share(self, factor=1.0):
        """Contact share of the law, with a factor to its pressure."""
        return float(contact_fraction(factor * self.reduced, modulus=1.0, slope=1.0))

    def plates(self):
        thickness = self.surface.electrical_thickness
        return float(local_pull(self.voltage, electrical_thickness=thickness, gap=self.rest.mean_gap))

    def gaussian(self, share):
        """Attraction [Pa] of Gaussian gaps with the solver's mean gap and a share."""
        gaps = gaussian_gaps(mean_gap=self.rest.mean_gap, touching=share)
        thickness = self.surface.electrical_thickness
        pull = mean_pull(self.voltage, electrical_thickness=thickness, gaps=gaps, spots=PullingSpots())
        return float(pull.total)


def surfaces():
    """Return surfaces with all of rms height, Hurst exponent, range of waves, modulus and layer varied together."""
    for at in range(SURFACES):
        rms = 0.5e-6 * 60 ** (at / (SURFACES - 1))
        longest = 1e-3 * (rms / 5e-6) ** 0.5
        yield Surface(
            SelfAffine(
                rms=rms,
                hurst=0.5 + 0.1 * (3 * at % 5),
                longest=longest,
                roll_off=longest / (2, 4)[at // 2 % 2],
                shortest=longest / (16, 32)[at // 3 % 2],
            ),
            modulus=(0.3e6, 1e6, 3e6)[at * 2 % 3],
            electrical_thickness=(1e-6, 3e-6, 10e-6)[at // 4],
            seed=at,
        )


def followed(surface, load):
    """Return the cases of rising voltage, up to where the contact falls or the grid does not resolve the attraction."""
    contact, start, found = surface.loaded(load), None, []
    for pull in PULLS:
        voltage = surface.electrical_thickness * (2 * load * pull / eps0) ** 0.5
        attraction = MaxwellStress(voltage=voltage, electrical_thickness=surface.electrical_thickness)
        rest = contact.rest(attraction if voltage else None, start=start)
        if rest.fell or rest.steepness > 1:
            return found, "falls" if rest.fell else "grid"
        start = rest.gap
        found.append(Case(surface, load, voltage, rest))
    return found, "end"
