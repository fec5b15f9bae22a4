"""The systematic error of an impedance analyser: declared, or measured with a resistor of known value."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from electrovib.core.errors import InputError
from electrovib.recordings.importing.phase_offset import CERTAIN
from electrovib.recordings.spectra.material import shift_of
from electrovib.recordings.spectra.parts import fit_parallel_part

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Complex, Real
    from electrovib.recordings.spectra.material import MaterialFit


@dataclass(frozen=True, kw_only=True)
class InstrumentError:
    """The systematic error of an impedance, common to all frequencies.

    Parameters
    ----------
    gain : float
        Standard uncertainty of the modulus over the modulus, dimensionless; that of area and thickness may be part of it.
    phase : float
        Standard uncertainty of the phase [rad].
    fixture_capacitance : float
        Capacitance in parallel with the known resistor, that of fixture and leads [F]; 0 where it is not measured, or less than
        5 standard deviations.
    words : str
        Where they are from.
    """

    gain: float = 0.0
    phase: float = 0.0
    fixture_capacitance: float = 0.0
    words: str = ""

    def __post_init__(self) -> None:
        """Refuse what is no uncertainty."""
        problems = [
            f"systematic {name} = {value}: expected 0 or more, and less than 1"
            for name, value in (("gain", self.gain), ("phase", self.phase))
            if not (math.isfinite(value) and 0 <= value < 1)
        ]
        if problems:
            raise InputError(problems)

    def deviations(
        self, fit: MaterialFit, frequency: Real, permittivity: Complex, *, noise: ArrayLike | None
    ) -> dict[str, float]:
        """Return the standard deviation of each parameter of a material by the error of the instrument.

        Parameters
        ----------
        fit : MaterialFit
            The fit.
        frequency : ndarray, shape (n,)
            Hz, as it was fitted.
        permittivity : ndarray of complex, shape (n,)
            Relative permittivity, as it was fitted.
        noise : array_like or None
            As it was fitted.

        Returns
        -------
        deviations : dict of str to float
            Dotted path to the standard deviation, in SI: the root of the sum of squares of that by the modulus and that by the
            phase, each by the derivative of the estimate. It does not average out with more data.
        """
        found = dict.fromkeys(fit.estimate.values, 0.0)
        for size, exponent in ((self.gain, 1.0), (self.phase, 1.0j)):
            if size:
                factor = cmath.exp(exponent * size)
                shift = shift_of(fit, frequency, permittivity, factor=factor, noise=noise)
                found = {path: math.hypot(value, shift[path]) for path, value in found.items()}
        return found


def error_by_resistor(frequency: ArrayLike, impedance: ArrayLike, *, resistance: float) -> InstrumentError:
    """Measure the systematic error of an instrument with a resistor of known value.

    Parameters
    ----------
    frequency : array_like, shape (n,)
        Hz, above 0, at least 8.
    impedance : array_like of complex, shape (n,)
        ohm, measured.
    resistance : float
        Known value [ohm], above 0.

    Returns
    -------
    error : InstrumentError
        The relative deviation of the measured resistance, the phase at vanishing frequency, and the capacitance in parallel.

    Raises
    ------
    InputError
        If the calibration is bad, as `fit_parallel_part` judges it.
    """
    if not (math.isfinite(resistance) and resistance > 0):
        raise InputError(f"resistance = {resistance}: expected more than 0 ohm")
    found = fit_parallel_part(frequency, impedance)
    gain = abs(found.resistance / resistance - 1)
    phase = abs(found.estimate.values["phase_offset"])
    certain = found.capacitance > CERTAIN * found.estimate.standard_deviations["capacitance"]
    return InstrumentError(
        gain=gain,
        phase=phase,
        fixture_capacitance=found.capacitance if certain else 0.0,
        words=f"a resistor of {resistance:.6g} ohm measured as {found.resistance:.6g} ohm, with a phase offset of"
        f" {math.degrees(phase):.2g} degrees",
    )
