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
    """One damped oscillation, fitted from `start` after the reference on, by natural frequency [Hz] and quality factor."""

    start: float
    frequency: Interval
    quality: Interval


@dataclass(frozen=True, kw_only=True)
class MeasuredRing:
    """Resonance, quality factor and drift of a damped oscillation after an impact or a release, at the time `reference`.

    - `form`: ``one mode``, ``one drifting mode`` or ``two modes``: the simplest whose criterion is at most 2
      above the lowest.
    - `level`: level about which the signal oscillates: ``constant``, ``linear`` or ``exponential`` in time,
      chosen likewise.
    - `criteria`: BIC of each form over the lowest; infinite for a form that was rejected.
    - `parameters`: of the best form: ``frequency`` [Hz] and ``quality`` of the mode that lasts longer, at the
      start of the section for a drifting one; ``drift`` [Hz/s] of a drifting mode; ``level_time_constant``
      [s] of an exponential level; ``early_frequency`` and ``early_quality`` of the mode that decays sooner.
    - `drift`: rate of change of the frequency of one drifting mode [Hz/s], whichever form is best.
    - `sections`: one mode fitted from later and later starts.
    - `misfit`: rms of the residual over the noise at the end of the record.
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
    """Damped oscillations after all impacts of a record, at least one, and why other impacts were not measured."""

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
