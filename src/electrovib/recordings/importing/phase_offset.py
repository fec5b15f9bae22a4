"""A constant phase error of an impedance analyser, as the spectrum of a resistor shows it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.physics.kramers_kronig import kramers_kronig_residual

if TYPE_CHECKING:
    from electrovib.core.arrays import Complex, Real

LARGEST_PHASE_OFFSET: Final = math.radians(1.0)
"""Phase at vanishing frequency beyond which a calibration is refused; a resistor has none."""
CERTAIN: Final = 5.0
"""Standard deviations beyond which an offset or a row is no accident."""
_LARGEST_MISFIT: Final = 0.05
"""Relative root mean square of what a resistor and a capacitor miss beyond which the spectrum is that of something else."""
_NO_SUPPORT: Final = 10.0
"""Difference of the criterion of Akaike beyond which the data leave a causal part no support."""
_WIDEST: Final = math.radians(45.0)
_PARAMETERS: Final = 3
_FEWEST: Final = 8
_FEWEST_KEPT: Final = 0.8


@dataclass(frozen=True, kw_only=True)
class PhaseOffset:
    """A constant phase error [rad] of an instrument.

    `misfit` is the relative root mean square by which a resistor and a capacitor in parallel, turned by the
    phase, miss the spectrum; `inconsistent` that by which the same rows miss the Kramers-Kronig relations.
    """

    phase: float
    misfit: float
    inconsistent: float

    def sentence(self) -> str:
        """Return what the spectrum shows."""
        return (
            f"the spectrum is that of a resistor and a capacitor in parallel with a constant phase of"
            f" {math.degrees(self.phase):.3g} degrees (misfit {100 * self.misfit:.2g} %), which no resistor or capacitor has;"
            f" causal parts miss it by {100 * self.inconsistent:.2g} %"
        )


def phase_offset(frequency: Real, impedance: Complex) -> PhaseOffset | None:
    r"""Find a constant phase error in the impedance of a part that is a resistor and a capacitor in parallel; None without it.

    Fitted to the admittance by least squares of the relative deviation: :math:`Y = e^{-j\varphi}(1/R +
    j\omega C)`. A modulus that does not depend on the frequency excludes a phase: by the Kramers-Kronig
    relations, a phase of :math:`\varphi` belongs to a modulus proportional to :math:`\omega^{2\varphi/\pi}`.
    A causal part is excluded if the likelihood of the data under it, with the misfit of the Kramers-Kronig
    test, is lower by more than 10 in twice the logarithm. Rows far from the others are omitted; fewer than 8
    rows, and a phase of at most 1 degree or 5 standard deviations, show no error.
    """
    if frequency.size < _FEWEST or np.unique(frequency).size < frequency.size or not np.all(impedance):
        return None
    admittance = 1 / impedance
    kept = np.ones(frequency.size, bool)
    for _ in range(3):
        phase, missed = _fitted(frequency, admittance, kept)
        scatter = 1.4826 * float(np.median(missed[kept]))
        again = missed <= CERTAIN * max(scatter, 1e-9)
        if (again == kept).all():
            break
        kept = again
    if kept.mean() < _FEWEST_KEPT or kept.sum() < _FEWEST:
        return None
    misfit = math.sqrt(float(np.sum(missed[kept] ** 2)) / (np.count_nonzero(kept) - _PARAMETERS / 2))
    deviation = _deviation(frequency, admittance, kept, phase)
    if misfit > _LARGEST_MISFIT or abs(phase) <= max(LARGEST_PHASE_OFFSET, CERTAIN * deviation):
        return None
    chosen, grid = admittance[kept], frequency[kept]
    try:
        inconsistent = kramers_kronig_residual(grid, chosen.imag / (2 * math.pi * grid * eps0), chosen.real)
    except InputError:
        return None
    if 4 * np.count_nonzero(kept) * math.log(inconsistent / misfit) <= _NO_SUPPORT:
        return None
    return PhaseOffset(phase=phase, misfit=misfit, inconsistent=inconsistent)


def _missed(frequency: Real, admittance: Complex, kept: np.ndarray, phase: float) -> Real:
    """Return the relative deviation of each row from the best resistor and capacitor at a phase."""
    turned = admittance * np.exp(1j * phase)
    weight = 1 / np.abs(admittance)
    turns = 2 * math.pi * frequency
    conductance = np.sum((turned.real * weight**2)[kept]) / np.sum((weight**2)[kept])
    capacitance = np.sum((turned.imag * turns * weight**2)[kept]) / np.sum((turns**2 * weight**2)[kept])
    best = max(conductance, 0.0) + 1j * turns * max(capacitance, 0.0)
    return np.asarray(np.abs(turned - best) * weight)


def _fitted(frequency: Real, admittance: Complex, kept: np.ndarray) -> tuple[float, Real]:
    """Return the phase with the least misfit, and the relative deviation of each row."""
    from scipy.optimize import minimize_scalar

    found = minimize_scalar(
        lambda phase: float(np.sum(_missed(frequency, admittance, kept, phase)[kept] ** 2)),
        bounds=(-_WIDEST, _WIDEST),
        method="bounded",
        options={"xatol": 1e-6},
    )
    phase = float(found.x)
    return phase, _missed(frequency, admittance, kept, phase)


def _deviation(frequency: Real, admittance: Complex, kept: np.ndarray, phase: float) -> float:
    """Return the standard deviation of the phase, from the curvature of the sum of squares."""
    step = 1e-3
    below, at, above = (
        float(np.sum(_missed(frequency, admittance, kept, phase + turn)[kept] ** 2))
        for turn in (-step, 0.0, step)
    )
    curvature = (above - 2 * at + below) / step**2
    if curvature <= 0:
        return math.inf
    return math.sqrt(2 * at / (2 * np.count_nonzero(kept) - _PARAMETERS) / curvature)
