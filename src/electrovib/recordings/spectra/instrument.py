"""The systematic error of an impedance analyser, and a resistor and a capacitor in parallel that measure it."""

from __future__ import annotations

import cmath
import dataclasses
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError
from electrovib.recordings.importing.parallel_part import CERTAIN, fit_parallel_part
from electrovib.recordings.spectra.material import shift_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Complex, Real
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
