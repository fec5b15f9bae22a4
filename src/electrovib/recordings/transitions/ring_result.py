"""Results of the measurement of damped oscillations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from electrovib.recordings.transitions.estimate import over_edges
from electrovib.recordings.transitions.statements import in_few

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real
    from electrovib.recordings.transitions.estimate import Interval


@dataclass(frozen=True, kw_only=True)
class RingSection:
    """One damped oscillation fitted from one start on.

    Parameters
    ----------
    start : float
        Time after the reference at which the section begins [s].
    frequency : Interval
        Natural frequency [Hz].
    quality : Interval
        Quality factor, dimensionless.
    """

    start: float
    frequency: Interval
    quality: Interval


@dataclass(frozen=True, kw_only=True)
class MeasuredRing:
    """Resonance, quality factor and drift of a damped oscillation after an impact or a release.

    Parameters
    ----------
    signal, unit : str
        Name of the signal and its unit.
    reference : float
        Time of the impact or release [s].
    form : str
        ``one mode``, ``one drifting mode`` or ``two modes``: the simplest whose criterion is at most 2 above the lowest.
    level : str
        Level about which the signal oscillates: ``constant``, ``linear`` or ``exponential`` in time, chosen likewise.
    criteria : mapping of str to float
        BIC of each form over the lowest, dimensionless; infinite for a form that was rejected.
    parameters : mapping of str to Interval
        Of the best form: ``frequency`` [Hz] and ``quality`` of the mode that lasts longer, at the start of the section for a
        drifting one; ``drift`` [Hz/s] of a drifting mode; ``level_time_constant`` [s] of an exponential level;
        ``early_frequency`` and ``early_quality`` of the mode that decays sooner.
    drift : Interval
        Rate of change of the frequency of one drifting mode [Hz/s], whichever form is best.
    sections : tuple of RingSection
        One mode fitted from later and later starts.
    time, values, model : ndarray, shape (n,)
        Samples after the reference [s], signal and best form, in the unit of the signal.
    misfit : float
        Rms of the residual over the noise at the end of the record, dimensionless.
    words : tuple of str
        Sentences about the result, warnings first.
    """

    signal: str
    unit: str
    reference: float
    form: str
    level: str
    criteria: Mapping[str, float]
    parameters: Mapping[str, Interval]
    drift: Interval
    sections: tuple[RingSection, ...]
    time: Real
    values: Real
    model: Real
    misfit: float
    words: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class MeasuredRings:
    """Damped oscillations after all impacts of a record.

    Parameters
    ----------
    rings : tuple of MeasuredRing
        In the order of time, at least one.
    skipped : tuple of str
        Why other impacts were not measured.
    """

    rings: tuple[MeasuredRing, ...]
    skipped: tuple[str, ...] = ()

    @property
    def frequency(self) -> Interval:
        """Natural frequency [Hz]: mean over the impacts by Student's t, or that of the only one."""
        return self._mean("frequency")

    @property
    def quality(self) -> Interval:
        """Quality factor, dimensionless: mean over the impacts by Student's t, or that of the only one."""
        return self._mean("quality")

    def _mean(self, name: str) -> Interval:
        return over_edges([each.parameters[name] for each in self.rings], of="impact")

    @property
    def words(self) -> tuple[str, ...]:
        """Sentences about the results, those of several impacts with the time of each in front."""
        if len(self.rings) == 1:
            return (*self.rings[0].words, *in_few(self.skipped))
        said = [
            f"{'Warning: ' * text.startswith('Warning')}impact at {each.reference:.6g} s: {text.removeprefix('Warning: ')}"
            for each in self.rings
            for text in each.words
        ]
        return (*sorted(said, key=lambda text: not text.startswith("Warning")), *in_few(self.skipped))
