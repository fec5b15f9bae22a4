"""A resistor and a capacitor in parallel, measured, and the constant phase error of the instrument that they show."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.constants import eps0
from electrovib.core.errors import InputError, refuse
from electrovib.physics.kramers_kronig import kramers_kronig_residual
from electrovib.recordings.fit.least_squares import FreeParameter, LeastSquaresEstimate

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Complex, Real

LARGEST_PHASE_OFFSET: Final = math.radians(1.0)
"""Phase at vanishing frequency beyond which a calibration is refused; a resistor has none."""
CERTAIN: Final = 5.0
"""Standard deviations beyond which an offset or a row is no accident."""
LARGEST_RESIDUAL: Final = 0.05
"""Relative root mean square of what a resistor and a capacitor miss beyond which the spectrum is that of something else."""
_NO_SUPPORT: Final = 10.0
"""Difference of the criterion of Akaike beyond which the data leave a causal part no support."""
_WIDEST: Final = math.radians(45.0)
_LEAST_CONDUCTANCE: Final = 1e-15
_LEAST_CAPACITANCE: Final = 1e-18
_FEWEST: Final = 8
_FEWEST_KEPT: Final = 0.8


def fit_parallel_part(frequency: ArrayLike, impedance: ArrayLike) -> ParallelPart:
    """Fit a resistor and a capacitor in parallel to an impedance spectrum, and judge the calibration by it.

    Z = R exp(j phi)/(1 + j w R C): the constant phase phi is the calibration's. A pair of R and C alone
    absorbs part of it with a small residual, and gives a wrong C. Rows far from the others are left out. A
    phase that does not vanish at low frequency is refused.
    """
    grid, data = np.asarray(frequency, dtype=float), np.asarray(impedance, dtype=complex)
    if grid.ndim != 1 or grid.shape != data.shape or grid.size < _FEWEST:
        raise InputError(f"frequency, impedance: expected two rows of the same length, {_FEWEST} or more")
    if not (np.isfinite(grid).all() and (grid > 0).all() and np.isfinite(data).all() and (data != 0).all()):
        raise InputError("frequency, impedance: expected finite numbers, frequencies and moduli above 0")
    found = ParallelPart.of(grid, data)
    problems = []
    if found.has_phase_offset:
        problems.append(
            f"impedance: the phase tends to {math.degrees(found.phase_offset):.3g} degrees at low frequency, where that of a"
            f" resistor vanishes; more than {math.degrees(LARGEST_PHASE_OFFSET):g} degree is a bad calibration, and the"
            f" {found.capacitance:.3g} F found here would be wrong: calibrate with a resistor of the same size and measure again"
        )
    if found.residual > LARGEST_RESIDUAL:
        problems.append(
            f"impedance: a resistor and a capacitor in parallel miss it by {found.residual:.2g} of its modulus, more than"
            f" {LARGEST_RESIDUAL:g}: it is another part"
        )
    refuse(problems)
    return found


@dataclass(frozen=True, kw_only=True)
class ParallelPart:
    """A resistor [ohm] and a capacitor [F, leads included] in parallel, measured with a constant error of the phase [rad].

    By least squares of the relative deviation; `missed` is that of each row, complex. Rows far from the
    others are left out of `kept`.
    """

    frequency: Real
    kept: np.ndarray
    resistance: float
    capacitance: float
    phase_offset: float
    missed: Complex

    @classmethod
    def of(cls, frequency: Real, impedance: Complex) -> ParallelPart:
        """Search the phase; for each phase the best resistor and capacitor are known."""
        from scipy.optimize import minimize_scalar

        kept = np.ones(frequency.size, bool)
        for _ in range(3):

            def squares(phase: float, kept: np.ndarray = kept) -> float:
                return cls._at(frequency, impedance, kept, phase).mean_square

            found = minimize_scalar(
                squares, bounds=(-_WIDEST, _WIDEST), method="bounded", options={"xatol": 1e-8}
            )
            best = cls._at(frequency, impedance, kept, float(found.x))
            size = np.abs(best.missed)
            kept = size <= CERTAIN * max(1.4826 * float(np.median(size[kept])), 1e-6)
            if (kept == best.kept).all():
                break
        return best

    @classmethod
    def _at(cls, frequency: Real, impedance: Complex, kept: np.ndarray, phase: float) -> ParallelPart:
        turned, weight = np.exp(1j * phase) / impedance, np.abs(impedance)
        turns = 2 * math.pi * frequency
        conductance = np.sum((turned.real * weight**2)[kept]) / np.sum((weight**2)[kept])
        capacitance = np.sum((turned.imag * turns * weight**2)[kept]) / np.sum((turns * weight)[kept] ** 2)
        conductance, capacitance = max(conductance, _LEAST_CONDUCTANCE), max(capacitance, _LEAST_CAPACITANCE)
        return cls(
            frequency=frequency, kept=kept,
            resistance=float(1 / conductance), capacitance=float(capacitance), phase_offset=phase,
            missed=(turned - conductance - 1j * turns * capacitance) * weight,
        )  # fmt: skip

    @property
    def mean_square(self) -> float:
        """Mean square of the relative deviation of the rows that are kept."""
        return float(np.mean(np.abs(self.missed[self.kept]) ** 2))

    @property
    def residual(self) -> float:
        """Relative root mean square of the impedance that the part misses, offset included."""
        return math.sqrt(self.mean_square)

    @property
    def estimate(self) -> LeastSquaresEstimate:
        """The parameters with their covariance, by the derivatives of the logarithm of the impedance."""
        turns, missed = 2j * math.pi * self.frequency[self.kept], self.missed[self.kept]
        loaded = 1 + turns * self.resistance * self.capacitance
        slopes = np.stack(
            [1 / (self.resistance * loaded), -turns * self.resistance / loaded, np.full(turns.size, 1j)], 1
        )
        values = {name: getattr(self, name) for name in ("resistance", "capacitance", "phase_offset")}
        found = LeastSquaresEstimate(
            values=values, sum_of_squares=math.nan, count=0, noise_is_known=False, evaluations=0, converged=True
        )  # fmt: skip
        left, slopes = (np.concatenate([each.real, each.imag]) for each in (missed, slopes))
        return found.judged(left, slopes, {name: FreeParameter(start=at) for name, at in values.items()})

    @property
    def has_phase_offset(self) -> bool:
        """Whether the constant phase is larger than a calibration may leave, and no accident."""
        deviation = self.estimate.standard_deviations["phase_offset"]
        return abs(self.phase_offset) > max(LARGEST_PHASE_OFFSET, CERTAIN * deviation)


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
    part = ParallelPart.of(frequency, impedance)
    kept, count = part.kept, int(np.count_nonzero(part.kept))
    if kept.mean() < _FEWEST_KEPT or count < _FEWEST:
        return None
    misfit = math.sqrt(part.mean_square * count / (count - 1.5))  # by three parameters of complex numbers
    if misfit > LARGEST_RESIDUAL or not part.has_phase_offset:
        return None
    chosen, grid = 1 / impedance[kept], frequency[kept]
    try:
        inconsistent = kramers_kronig_residual(grid, chosen.imag / (2 * math.pi * grid * eps0), chosen.real)
    except InputError:
        return None
    if 4 * count * math.log(inconsistent / misfit) <= _NO_SUPPORT:
        return None
    return PhaseOffset(phase=part.phase_offset, misfit=misfit, inconsistent=inconsistent)
