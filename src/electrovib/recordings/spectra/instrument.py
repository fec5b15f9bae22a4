"""The systematic error of an impedance analyser, and a resistor and a capacitor in parallel that measure it."""

from __future__ import annotations

import cmath
import dataclasses
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.recordings.fit.least_squares import FreeParameter, fit_function
from electrovib.recordings.importing.phase_offset import CERTAIN, LARGEST_PHASE_OFFSET
from electrovib.recordings.spectra.material import shift_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Complex, Real
    from electrovib.recordings.fit.least_squares import LeastSquaresEstimate
    from electrovib.recordings.spectra.material import MaterialFit


@dataclass(frozen=True, kw_only=True)
class InstrumentError:
    """The systematic error of an impedance, common to all frequencies, as standard uncertainties.

    - `gain`: of the modulus over the modulus; that of area and thickness may be part of it.
    - `phase`: of the phase [rad].
    - `fixture_capacitance`: capacitance in parallel with the known resistor, that of fixture and leads [F]; 0
      where it is not measured, or less than 5 standard deviations.
    - `fixture_uncertainty`: of the capacitance of fixture and leads at the sample [F].
    - `words`: where they are from.
    """

    gain: float = 0.0
    phase: float = 0.0
    fixture_capacitance: float = 0.0
    fixture_uncertainty: float = 0.0
    words: str = ""

    def __post_init__(self) -> None:
        problems = [
            f"systematic {name} = {value}: expected 0 or more, and less than 1"
            for name, value in (("gain", self.gain), ("phase", self.phase))
            if not (math.isfinite(value) and 0 <= value < 1)
        ]
        if problems:
            raise InputError(problems)

    def without_fixture(self) -> InstrumentError:
        """Return it for a sample whose fixture is known otherwise."""
        return dataclasses.replace(self, fixture_capacitance=0.0, fixture_uncertainty=0.0)

    def deviations(
        self,
        fit: MaterialFit,
        frequency: Real,
        permittivity: Complex,
        *,
        noise: ArrayLike | None,
        per_farad: ArrayLike = 0.0,
    ) -> dict[str, float]:
        """Return the standard deviation of each parameter of a material by the error of the instrument, by its path.

        It is the root of the sum of squares of those by the modulus, the phase and the fixture, each by the
        derivative of the estimate; it does not average out with more data. `per_farad` is the permittivity
        that one farad of the fixture makes at each row, 0 where a permittivity was measured.
        """
        found = dict.fromkeys(fit.estimate.values, 0.0)
        fixture = 1 + self.fixture_uncertainty * np.asarray(per_farad) / permittivity
        for factor in (cmath.exp(self.gain), cmath.exp(1j * self.phase), fixture):
            if np.any(factor != 1):
                shift = shift_of(fit, frequency, permittivity, factor=factor, noise=noise)
                found = {path: math.hypot(value, shift[path]) for path, value in found.items()}
        return found


def error_by_resistor(
    frequency: ArrayLike, impedance: ArrayLike, *, resistance: float, tolerance: float = 0.0
) -> InstrumentError:
    """Measure the systematic error of an instrument with a resistor of known value, at 8 or more frequencies.

    The known value is equally likely everywhere within its relative `tolerance`. The error is the relative
    deviation of the measured resistance, the phase at vanishing frequency, and the capacitance in parallel.
    The sample lies elsewhere in the fixture, with leads of its own: that capacitance is taken as uncertain by
    as much as itself.
    """
    if not (math.isfinite(resistance) and resistance > 0):
        raise InputError(f"resistance = {resistance}: expected more than 0 ohm")
    if not 0 <= tolerance < 1:
        raise InputError(f"tolerance = {tolerance}: expected 0 or more, and less than 1")
    found = fit_parallel_part(frequency, impedance)
    own = found.estimate.standard_deviations
    phase = abs(found.estimate.values["phase_offset"])
    certain = found.capacitance > CERTAIN * own["capacitance"]
    known = (
        f" known to {100 * tolerance:.3g} %"
        if tolerance
        else " whose tolerance is not stated and not counted"
    )
    return InstrumentError(
        gain=math.hypot(
            found.resistance / resistance - 1, own["resistance"] / resistance, tolerance / math.sqrt(3)
        ),
        phase=math.hypot(phase, own["phase_offset"]),
        fixture_capacitance=found.capacitance if certain else 0.0,
        fixture_uncertainty=math.hypot(found.capacitance, own["capacitance"]),
        words=f"a resistor of {resistance:.6g} ohm{known} measured as {found.resistance:.6g} ohm, with a phase offset of"
        f" {math.degrees(phase):.2g} degrees and {found.capacitance:.3g} F in parallel",
    )


LARGEST_RESIDUAL: Final = 0.05
"""Relative root mean square of what the part misses beyond which it is not that part."""
_FEWEST: Final = 8
_LEAST_CAPACITANCE: Final = 1e-18


@dataclass(frozen=True, kw_only=True)
class ParallelPart:
    """A resistor and a capacitor in parallel, measured; the capacitance is without that of the leads.

    - `estimate`: of ``resistance`` [ohm], ``capacitance`` [F, leads included] and ``phase_offset`` [rad].
    - `residual`: relative root mean square of the impedance that the part misses, offset included.
    - `left_out`: frequencies of rows that are far from the others [Hz].
    - `systematic_error`: relative error of the capacitance that the phase offset of the instrument makes at
      the middle of the band.
    """

    resistance: float
    capacitance: float
    estimate: LeastSquaresEstimate
    residual: float
    left_out: Real
    systematic_error: float


def fit_parallel_part(
    frequency: ArrayLike, impedance: ArrayLike, *, stray_capacitance: float = 0.0
) -> ParallelPart:
    """Fit a resistor and a capacitor in parallel to an impedance spectrum, and judge the calibration by it.

    Z = R exp(j phi)/(1 + j w R C): the constant phase phi is the calibration's. A pair of R and C alone
    absorbs part of it with a small residual, and gives a wrong C. `stray_capacitance`, that which a bare
    resistor in the same leads gives, is taken off. A phase that does not vanish at low frequency is refused.
    """
    grid, data = np.asarray(frequency, dtype=float), np.asarray(impedance, dtype=complex)
    if grid.ndim != 1 or grid.shape != data.shape or grid.size < _FEWEST:
        raise InputError(f"frequency, impedance: expected two rows of the same length, {_FEWEST} or more")
    if not (np.isfinite(grid).all() and (grid > 0).all() and np.isfinite(data).all() and (data != 0).all()):
        raise InputError("frequency, impedance: expected finite numbers, frequencies and moduli above 0")
    kept = np.ones(grid.size, bool)
    for _ in range(3):
        estimate = _estimate(grid[kept], data[kept])
        missed = np.abs(np.log(data / _model(grid, estimate.values)))
        scatter = float(np.median(missed[kept])) * 1.4826
        again = missed <= CERTAIN * max(scatter, 1e-6)
        if (again == kept).all():
            break
        kept = again
    found = ParallelPart(
        resistance=estimate.values["resistance"],
        capacitance=estimate.values["capacitance"] - stray_capacitance,
        estimate=estimate,
        residual=float(np.sqrt(np.mean(missed[kept] ** 2))),
        left_out=grid[~kept],
        systematic_error=_systematic(grid[kept], estimate.values),
    )
    _refuse_a_bad_calibration(found)
    return found


def _model(frequency: Real, values: Mapping[str, float]) -> Complex:
    loaded = 1 + 2j * math.pi * frequency * values["resistance"] * values["capacitance"]
    return np.asarray(values["resistance"] * np.exp(1j * values["phase_offset"]) / loaded)


def _estimate(grid: Real, data: Complex) -> LeastSquaresEstimate:
    free = {
        "resistance": FreeParameter(
            start=float(np.abs(data).max()), lower=1e-3, upper=1e15, logarithmic=True
        ),
        "capacitance": FreeParameter(
            start=max(float(np.median(np.imag(1 / data) / (2 * math.pi * grid))), 1e-15),
            lower=_LEAST_CAPACITANCE,
            upper=1.0,
            logarithmic=True,
        ),
        "phase_offset": FreeParameter(start=0.0),
    }
    return fit_function(
        lambda x, **at: np.log(_model(x, at) / data), grid, np.zeros(grid.size, complex), start=free
    )


def _systematic(grid: Real, values: Mapping[str, float]) -> float:
    """Relative error of the capacitance by a phase that is wrong by the offset, at the middle of the band."""
    middle = 2 * math.pi * math.exp(float(np.mean(np.log(grid))))
    angle = math.atan(middle * values["resistance"] * values["capacitance"])
    return abs(values["phase_offset"]) / max(math.sin(angle) * math.cos(angle), 1e-12)


def _refuse_a_bad_calibration(found: ParallelPart) -> None:
    problems = []
    offset = found.estimate.values["phase_offset"]
    certain = CERTAIN * found.estimate.standard_deviations["phase_offset"]
    if abs(offset) > max(LARGEST_PHASE_OFFSET, certain):
        problems.append(
            f"impedance: the phase tends to {math.degrees(offset):.3g} degrees at low frequency, where that of a resistor"
            f" vanishes; more than {math.degrees(LARGEST_PHASE_OFFSET):g} degree is a bad calibration, and the"
            f" {found.capacitance:.3g} F found here would be wrong: calibrate with a resistor of the same size and measure again"
        )
    if found.residual > LARGEST_RESIDUAL:
        problems.append(
            f"impedance: a resistor and a capacitor in parallel miss it by {found.residual:.2g} of its modulus, more than"
            f" {LARGEST_RESIDUAL:g}: it is another part"
        )
    if problems:
        raise InputError(problems)
