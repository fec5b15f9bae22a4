"""One period of the contact on a grid: between pressure and displacement by Fourier transforms, exact or in single precision.

Transforms in single precision serve where an approximate answer is enough: for corrections that the exact operator then
judges, and for preconditioners. The attraction is a local potential of the gap. One correction is solved by conjugate gradients
in single precision, preconditioned, and within a radius where the energy is not convex.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from electrovib.core.arrays import Numbers, Real
from electrovib.core.errors import InputError
from electrovib.physics.roughness import local_pull

WORKERS = 2
"""Threads of a transform."""
LEVELLING = 2.0
"""Compliance of the mean in `roughly`, over that of the longest wave: the mean is held by the places of contact."""

Compliance = Callable[[Real], Real]
"""Displacement per pressure [m/Pa] at wave numbers [1/m]."""


class Cell:
    """A periodic grid of a shape, its periods [m], the compliance, and the stiffness of a spring behind the mean [Pa/m].

    `soft` and `stiff` are displacement per pressure and its inverse at the wave numbers of a real transform.
    `exact` and `single` count transforms there and back.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        periods: tuple[float, float],
        compliance: Compliance,
        *,
        spring: float = 0.0,
    ) -> None:
        self.shape, self.periods = shape, periods
        self._compliance, self._spring = compliance, spring
        steps = [2 * math.pi * length / period for length, period in zip(shape, periods, strict=True)]
        wavenumber = np.hypot(
            steps[0] * np.fft.fftfreq(shape[0])[:, None], steps[1] * np.fft.rfftfreq(shape[1])[None, :]
        )
        wavenumber[0, 0] = 1.0
        self.soft = compliance(wavenumber)
        self.stiff = 1 / self.soft
        self.soft[0, 0], self.stiff[0, 0] = 0.0, spring
        self._soft, self._stiff, self._levelled = (
            each.astype(np.float32) for each in (self.soft, self.stiff, self.soft)
        )
        softest = LEVELLING * float(self.soft.max())
        self._levelled[0, 0] = 1 / spring if spring * softest > 1 else softest
        self.exact = self.single = 0.0

    def coarser(self) -> Cell:
        """The same period on every other point."""
        rows, columns = self.shape
        return Cell((rows // 2, columns // 2), self.periods, self._compliance, spring=self._spring)

    def displacement(self, pressure: Real) -> Real:
        """Return the displacement into the body under a pressure, with mean 0."""
        self.exact += 1
        return self._through(pressure, self.soft)

    def pressure(self, displacement: Real) -> Real:
        """Return the pressure of a displacement, with the mean that the spring gives."""
        self.exact += 1
        return self._through(displacement, self.stiff)

    def displacement_roughly(self, pressure: Numbers) -> Numbers:
        """Return `displacement` in single precision."""
        self.single += 1
        return self._through(pressure, self._soft)

    def pressure_roughly(self, displacement: Numbers) -> Numbers:
        """Return `pressure` in single precision."""
        self.single += 1
        return self._through(displacement, self._stiff)

    def levelled(self, pressure: Numbers) -> Numbers:
        """Return a displacement in single precision whose mean follows the mean pressure: a preconditioner."""
        self.single += 1
        return self._through(pressure, self._levelled)

    def _through(self, field: Numbers, factors: Numbers) -> Numbers:
        from scipy.fft import irfft2, rfft2

        waves = rfft2(field, workers=WORKERS)
        waves *= factors
        found: Numbers = irfft2(waves, s=self.shape, workers=WORKERS, overwrite_x=True)
        return found


class Local(NamedTuple):
    """Energy per area [J/m2], its derivative over the gap, which is the attraction [Pa], and the derivative of that [Pa/m]."""

    energy: Real
    stress: Real
    slope: Real


Attraction = Callable[[Real], Local]
"""Of a gap [m], 0 or more."""


@dataclass(frozen=True, kw_only=True)
class MaxwellStress:
    """Plates in series at each place: layers with a sum of T/eps [m] above 0, a gap, and a voltage [V] held across both.

    Valid where the gap varies over lengths that are long compared with gap and layers.
    """

    voltage: float
    electrical_thickness: float

    def __post_init__(self) -> None:
        """Refuse what makes the attraction infinite."""
        if not 0 < self.electrical_thickness < np.inf:
            raise InputError(
                f"electrical_thickness = {self.electrical_thickness}: the sum of thickness over permittivity of the layers is"
                " finite and above 0, for instance 1e-6 m"
            )
        if not np.isfinite(self.voltage):
            raise InputError(f"voltage = {self.voltage}: a voltage is finite, for instance 100 V")

    def __call__(self, gap: Real) -> Local:
        """Return the energy -eps0 V^2/2/(g + h0), voltage held, and its derivatives."""
        reach = gap + self.electrical_thickness
        stress = local_pull(self.voltage, electrical_thickness=self.electrical_thickness, gap=gap)
        return Local(-stress * reach, stress, -2 * stress / reach)


REDUCTION = 0.1
"""A correction is refined until its remainder has fallen to this: what it improves is judged anew after it."""
MOST = 20
"""Steps of one correction."""


class Correction(NamedTuple):
    """A correction, its length in the preconditioner's norm, and the first preconditioned remainder, which tells the error.

    `bounded` where it ends at the radius, `concave` where the energy curves downwards along its last direction.
    """

    step: Numbers
    length: float
    first: Numbers
    bounded: bool
    concave: bool


def correction(
    operator: Callable[[Numbers], Numbers],
    preconditioner: Callable[[Numbers], Numbers],
    remainder: Numbers,
    *,
    radius: float = math.inf,
    worth: Callable[[Numbers], bool] = lambda _: True,
) -> Correction:
    """Solve operator x = remainder roughly, by preconditioned conjugate gradients that end at the radius (Steihaug).

    Nothing is solved where the first preconditioned remainder is not `worth` it. Without a radius it ends before a direction
    along which the energy is not convex.
    """
    step = np.zeros_like(remainder)
    first = shape = preconditioner(remainder)
    begin = fall = float(np.vdot(remainder, shape))
    direction, along, across, length = shape, fall, 0.0, 0.0
    if not worth(first):
        return Correction(step, 0.0, first, bounded=False, concave=False)
    for _ in range(MOST):
        if fall <= REDUCTION**2 * begin:
            break
        answer = operator(direction)
        curvature = float(np.vdot(direction, answer))
        factor = fall / curvature if curvature > 0 else math.inf
        if curvature <= 0 or length + factor * (2 * across + factor * along) > radius**2:
            if math.isfinite(radius):
                to_edge = (math.sqrt(across**2 + along * (radius**2 - length)) - across) / along
                step += np.float32(to_edge) * direction
            return Correction(step, radius, first, bounded=True, concave=curvature <= 0)
        step += np.float32(factor) * direction
        length += factor * (2 * across + factor * along)
        former, remainder = remainder, remainder - np.float32(factor) * answer
        shape = preconditioner(remainder)
        before, fall = fall, float(np.vdot(remainder, shape))
        turn = max((fall - float(np.vdot(former, shape))) / before, 0.0)
        across = turn * (across + factor * along)
        along = fall + turn**2 * along
        direction = shape + np.float32(turn) * direction
    return Correction(step, math.sqrt(max(length, 0.0)), first, bounded=False, concave=False)
