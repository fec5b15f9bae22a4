"""Levels at which a person feels a drive, by channel, and whether two drives can be discriminated."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, Final

from electrovib.core.answer import Answer, Document
from electrovib.core.deprecation import former_attribute
from electrovib.core.diagnostics import Diagnostic, diagnostics_of
from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.core.signals import is_trace
from electrovib.data.atomic import plain
from electrovib.data.traces import open_if_trace
from electrovib.physics.perception import (
    BEST_FREQUENCIES,
    RYU,
    UNVERIFIED_CORNER,
    ElasticViscousSkin,
    Pacinian,
    Perception,
    decibels,
    felt_amplitude,
)
from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.solve.quantities.answer import validity
from electrovib.studies import felt_spectrum, widths
from electrovib.studies.felt_spectrum import Stimulus
from electrovib.studies.widths import Width

SILENT: Final = 1e-9
"""Relative change of a force below which it counts as constant: rounding."""


def perceive(
    source: Source,
    *,
    set: Mapping[str, Any] | None = None,  # noqa: A002 - the name of the option
    perception: Perception | None = None,
) -> Percept:
    r"""Compute whether the force on a finger is felt, by which channel, and by how many decibels.

    Parameters
    ----------
    source : str, Path, mapping, Scenario or xarray.Dataset
        As for `electrovib.load`, or a measured Trace. A Trace that carries its scenario is computed again at the times
        that the spectrum needs; a measured one is taken as it is.
    set : mapping of str to value, optional
        Dotted path to value; ``perception.threshold`` and the like change the perception.
    perception : Perception, optional
        By default that of the scenario, else the default one.

    Returns
    -------
    percept : Percept
        Levels of the channels, relative level with its interval, and level above the detection threshold: that of the person,
        or published ones with their spread.

    Raises
    ------
    InputError
        For a path or value that does not fit, or a Trace without a signal to feel.
    NotCausalError
        If the force law has no response in time to this drive.

    Notes
    -----
    Spectrum F_k of the friction force, compliance C and weights w_c of the channels:

    .. math:: L_c = 20 \lg \sqrt{\sum_k (w_c(f_k)\,|C(f_k) F_k|)^2}, \qquad L = \max_c L_c

    relative to the level of a sine of force whose amplitude is half of the peak-to-peak force, at the best frequency of the
    most sensitive channel.

    Examples
    --------
    >>> found = ev.perceive("bau_2010/sine")
    >>> f"{found.sensation:.0f} dB above the threshold, within {found.uncertainty:.0f} dB"
    '63 dB above the threshold, within 21 dB'
    """
    changes = {path: value for path, value in (set or {}).items() if not _personal(path)}
    scenario, trace = _experiment(source, changes)
    person = perception or getattr(scenario, "perception", None) or Perception()
    person = _changed(person, {path: value for path, value in (set or {}).items() if _personal(path)})
    given = person.compliance or getattr(scenario, "finger", None)
    if scenario is not None:
        return perceived(scenario, person, diagnostics=validity(scenario))
    windows = felt_spectrum.measured_lines(trace, window=person.window)
    if windows[0].signal == "skin_displacement":
        given = None
    found = felt_spectrum.loudest(windows, person, given)
    title = str(trace.attrs.get("title", ""))
    return _percept(found, title=title, error=math.nan, diagnostics=tuple(diagnostics_of(trace)))


def perceived(scenario: Scenario, person: Perception, *, diagnostics: tuple[Diagnostic, ...]) -> Percept:
    """Compute what a person feels of a scenario that has been judged already."""
    found, error = _converged(scenario, person, person.compliance or scenario.finger)
    return _percept(found, title=scenario.titled(), error=error, diagnostics=diagnostics, scenario=scenario)


def _personal(path: str) -> bool:
    return path.partition(".")[0] == "perception"


def _experiment(source: Source, changes: Mapping[str, Any]) -> tuple[Scenario | None, Any]:
    found = open_if_trace(source)
    if is_trace(found) and not changes and not {"scenario", "over"} & set(found.attrs):
        return None, found
    return read_scenario(found, changes=changes), None


def _changed(person: Perception, changes: Mapping[str, Any]) -> Perception:
    """Change a perception by paths that begin with its name."""
    inner = {
        path.removeprefix("perception."): value for path, value in changes.items() if path != "perception"
    }
    try:
        if "perception" in changes:
            person = read_model(Perception, changes["perception"])
        return person.replace(inner) if inner else person
    except InputError as error:
        raise InputError(problem.within("perception") for problem in error.problems) from None


def _converged(scenario: Scenario, person: Perception, given: Any) -> tuple[Stimulus, float]:
    """Double the number of samples until the level is constant."""

    def felt(samples: int) -> Stimulus:
        windows = felt_spectrum.force_lines(scenario, window=person.window, samples=samples)
        return felt_spectrum.loudest(windows, person, given)

    samples = felt_spectrum.FEWEST
    found = felt(samples)
    while True:
        samples *= 2
        finer = felt(samples)
        moves = finer.lines.swing > SILENT * scenario.load.normal_force
        change = finer.level - found.level if moves else 0.0
        if abs(change) <= SETTLED or finer.lines.samples >= felt_spectrum.MOST:
            return finer, change
        found = finer


def _percept(
    felt: Stimulus,
    *,
    title: str,
    error: float,
    diagnostics: tuple[Diagnostic, ...],
    scenario: Scenario | None = None,
) -> Percept:
    person, found = felt.person, felt.lines
    channels = tuple(_felt(channel, felt) for channel in person.channels)
    top = max(channels, key=lambda each: each.level)
    alternatives = _alternatives(felt)
    values = [top.relative, *alternatives.values()]
    above = felt_spectrum.sensation_of(felt)
    sensation = None if above is None else (above.low + above.high) / 2
    uncertainty = None if above is None else (above.high - above.low) / 2
    return Percept(
        title=title,
        channels=channels,
        loudest=top.channel if math.isfinite(top.level) else "",
        level=top.level,
        unit="m" if felt.is_displacement or felt.skin is not None else "N",
        relative=top.relative,
        interval=(min(values), max(values)),
        alternatives=alternatives,
        best_frequency=person.most_sensitive().best(),
        sensation=sensation,
        uncertainty=uncertainty,
        felt_by="" if above is None else above.channel,
        left={} if above is None else above.left,
        verdict=verdict(sensation=sensation, uncertainty=uncertainty),
        difference_threshold=person.difference_threshold,
        swing=found.swing,
        spectrum=found,
        numerical_error=error,
        calibrated_on=felt_spectrum.stands_on(felt),
        diagnostics=diagnostics,
        widths=() if above is None else _widths(felt, above, scenario),
    )


def _widths(felt: Stimulus, above: felt_spectrum.Sensation, scenario: Scenario | None) -> tuple[Width, ...]:
    """Return by what a level is uncertain; the force of a measurement is known."""
    has_skin, ends = len(felt_spectrum.skins_of(felt)) == 1, (above.low, above.high)
    found = [widths.threshold_width(felt.person, ends, unit="dB", has_skin=has_skin)]
    if scenario is not None:
        factor, middle = widths.factor_of(scenario, widths.LEVEL), (above.low + above.high) / 2
        more = float(decibels(factor or 1.0))
        law = type(scenario.force).__name__
        found.append(widths.law_width(law, factor, (middle - more, middle + more), unit="dB"))
        ends, text = (above.low - more, above.high + more), ", ".join(each.name for each in found)
        found += [Width(name=widths.TOGETHER, text=text, interval=ends, unit="dB")] * (factor is not None)
    return (*found, widths.ONE_FINGER, widths.BETWEEN_PEOPLE)


def _felt(channel: Any, felt: Stimulus) -> Felt:
    level = float(decibels(felt_amplitude(channel, felt.lines.frequency, felt.moved)))
    return Felt(
        channel=type(channel).__name__,
        level=level,
        relative=level - float(decibels(felt.reference)) if felt.reference > 0 else -math.inf,
        status=channel.status,
        source=channel.reference,
    )


def _alternatives(felt: Stimulus) -> dict[str, float]:
    """Return the relative level under other assumptions that are as well founded [dB]."""
    person, cases = felt.person, dict[str, Stimulus]()
    low, high = BEST_FREQUENCIES
    moved = tuple(
        channel.replace({"best_frequency": high}) if channel == Pacinian() else channel
        for channel in person.channels
    )
    if moved != person.channels:
        other = person.model_copy(update={"channels": moved})
        cases[f"Pacinian channel best at {high:g} instead of {low:g} Hz"] = replace(felt, person=other)
    if len(person.channels) > 1:
        alone = person.model_copy(update={"channels": (person.most_sensitive(),)})
        cases[f"{type(person.most_sensitive()).__name__} channel alone"] = replace(felt, person=alone)
    if felt.skin is None and not felt.is_displacement:
        skin = ElasticViscousSkin(stiffness=1.0, corner=UNVERIFIED_CORNER)
        name = f"skin elastic to {UNVERIFIED_CORNER:g} Hz, then viscous (cited from memory, unverified)"
        cases[name] = replace(felt, skin=skin)
    if felt.reference == 0:
        return {}
    return {name: each.level - float(decibels(each.reference)) for name, each in cases.items()}


VERDICTS: Final = ("detectable", "not detectable", "within the uncertainty", "relative only")
SETTLED: Final = 0.01
"""Change of a level with twice the samples up to which it is not stated [dB]."""
_ANSWERS: Final = {
    "detectable": "felt",
    "not detectable": "not felt",
    "within the uncertainty": "felt or not: undecided within the spread",
}


@dataclass(frozen=True, kw_only=True)
class Felt:
    """Level of one channel.

    - `channel`: name of the model of the channel.
    - `level`: [dB re 1 m], or [dB re 1 N] where the displacement is taken as proportional to the force.
    - `relative`: level relative to a sine of equal force at the best frequency [dB].
    - `status`, `source`: of the weight.
    """

    channel: str
    level: float
    relative: float
    status: str
    source: str


@dataclass(frozen=True, kw_only=True, repr=False)
class Percept(Answer):
    """Levels at which a person feels a drive.

    - `channels`: in the order of `Perception.channels`; `loudest`: with the highest level, empty if nothing
      moves.
    - `level`, `unit`: of that channel [dB re 1 `unit`]; the unit is ``"m"``, or ``"N"`` without mechanics.
    - `relative`: level relative to a sine of force at `best_frequency` whose amplitude is half of the
      peak-to-peak force [dB].
    - `alternatives`: `relative` under other assumptions that are as well founded; `interval`: lowest and
      highest of all these [dB].
    - `best_frequency`: of the most sensitive channel [Hz].
    - `sensation`: level relative to the detection threshold, middle of its range [dB]; None where nothing
      moves, or no threshold is known.
    - `uncertainty`: half of that range [dB]: uncertainty of the threshold, and spread of the published values
      that are assumed.
    - `felt_by`: channel that is highest above its threshold; empty without a level above threshold.
    - `left`: what is assumed, ``perception.threshold`` or ``perception.compliance``, to the uncertainty that
      remains once it has been measured [dB]; empty if both are given.
    - `verdict`: one of `VERDICTS`.
    - `difference_threshold`: of the voltage amplitude [dB].
    - `swing`: half of the peak-to-peak value of the signal [N] or [m]; `spectrum`: as it was evaluated.
    - `numerical_error`: change of the level with twice the samples [dB]; NaN for a measurement.
    - `calibrated_on`: assumptions and sources of the levels.
    - `diagnostics`: of the scenario, or those that a measurement states.
    - `widths`: by what the level above threshold is uncertain, each named apart.
    """

    title: str
    channels: tuple[Felt, ...]
    loudest: str
    level: float
    unit: str
    relative: float
    interval: tuple[float, float]
    alternatives: Mapping[str, float]
    best_frequency: float
    sensation: float | None
    uncertainty: float | None
    felt_by: str
    left: Mapping[str, float]
    verdict: str
    difference_threshold: float
    swing: float
    spectrum: felt_spectrum.Lines
    numerical_error: float
    calibrated_on: tuple[str, ...]
    diagnostics: tuple[Diagnostic, ...]
    widths: tuple[Width, ...] = ()
    answer = former_attribute("answer", "headline", lambda self: self.headline)
    sentences = former_attribute("sentences", "document.sentences", lambda self: self._sentences)
    details = former_attribute("details", "document.remarks", lambda self: self._details)

    @property
    def headline(self) -> str:
        """Whether it is felt, by which channel, and by how much, with the spread of what is assumed."""
        if not self.loudest:
            return "not felt: nothing moves the skin"
        if self.sensation is None or self.uncertainty is None:
            return (
                f"felt or not: unknown without perception.threshold; strongest in the {self.loudest} channel"
            )
        low, high = self.sensation - self.uncertainty, self.sensation + self.uncertainty
        is_assumed = felt_spectrum.THRESHOLD in self.left
        whose = "published detection thresholds" if is_assumed else "the detection threshold"
        level = f"{self.sensation:+.1f} dB ({low:+.1f} to {high:+.1f} dB) relative to {whose}"
        return f"{_ANSWERS[self.verdict]}, {self.felt_by} channel: {level}"

    @property
    def to_measure(self) -> str:
        """What is assumed, and what measuring it would change; empty if nothing is assumed."""
        if not self.left:
            return ""
        words = {
            felt_spectrum.THRESHOLD: "a detection threshold",
            felt_spectrum.COMPLIANCE: "a compliance of the skin",
        }
        named = " and ".join(words[name] for name in self.left)
        rest = ", ".join(f"{name} of your own leaves +-{value:.1f} dB" for name, value in self.left.items())
        return f"assumed from publications: {named}; {rest}"

    @property
    def _sentences(self) -> list[str]:
        """Whether the drive is felt, by which channel and by how much, and what limits this answer."""
        texts = [self.title, self.headline, self.to_measure, *widths.sentences(self.widths[1:])]
        if abs(self.numerical_error) > SETTLED:
            texts.append(f"numerical error: {abs(self.numerical_error):.1g} dB")
        return [each for each in texts if each]

    @property
    def _details(self) -> list[str]:
        """What was evaluated, the level of every channel, other assumptions, and their sources."""
        lines = []
        if self.loudest:
            low, high = self.interval
            lines.append(
                f"strongest channel {self.loudest}: {_decibels(self.relative)} relative to a sine of equal force at"
                f" {self.best_frequency:g} Hz; {low:+.1f} to {high:+.1f} dB under other assumptions"
            )
        if abs(self.numerical_error) <= SETTLED:
            lines.append(f"numerical error: {abs(self.numerical_error):.1g} dB")
        status = " and ".join(dict.fromkeys(felt.status for felt in self.channels))
        signal, how = self.spectrum.signal.replace("_", " "), self.spectrum.how
        lines.append(f"evaluated: {signal}, {how}; channel weights: {status}, not measured")
        for felt in self.channels:
            level = f"{_decibels(felt.level)} re 1 {self.unit}" if math.isfinite(felt.level) else "nothing"
            relative = f", {_decibels(felt.relative)} relative" if math.isfinite(felt.relative) else ""
            lines.append(f"  {felt.channel}: {level}{relative} ({felt.status})")
        lines += [f"  {_decibels(value)} with {name}" for name, value in self.alternatives.items()]
        return [*lines, "assumptions:", *(f"  {text}" for text in self.calibrated_on)]

    @property
    def document(self) -> Document:
        """The sentences, and what they assume."""
        return Document(
            title=f"What is felt: {self.title or 'a scenario'}",
            sentences=self._sentences,
            diagnostics=self.diagnostics,
            remarks=self._details,
            brief=True,
        )

    def to_dict(self) -> dict[str, Any]:
        """Return numbers, texts and lists; a level of minus infinity becomes None."""
        found: dict[str, Any] = plain(asdict(self))
        return found


def _decibels(value: float) -> str:
    return f"{value:+.1f} dB"


@dataclass(frozen=True, kw_only=True, repr=False)
class Difference(Answer):
    """Difference of two percepts, and whether it is noticeable.

    - `difference`: level of the first relative to the second, as a change of the voltage amplitude [dB]: half
      that of the force.
    - `threshold`: difference threshold of the voltage amplitude [dB].
    - `noticeable`: whether the magnitude of the difference exceeds the threshold; `text`: the same in words,
      with the source of the threshold.
    - `diagnostics`: of both percepts.
    """

    difference: float
    threshold: float
    noticeable: bool
    text: str
    diagnostics: tuple[Diagnostic, ...]

    @property
    def document(self) -> Document:
        """Whether the difference is noticeable, and by which threshold."""
        return Document(
            title="Two drives compared by their strength", sentences=[self.text], diagnostics=self.diagnostics
        )


def verdict(*, sensation: float | None, uncertainty: float | None) -> str:
    """Compare a level above threshold [dB] with the uncertainty of the threshold [dB]; None is not calibrated."""
    if sensation is None or uncertainty is None:
        return "relative only"
    if abs(sensation) <= uncertainty:
        return "within the uncertainty"
    return "detectable" if sensation > 0 else "not detectable"


def compare_percepts(first: Percept, second: Percept) -> Difference:
    """Judge whether two drives can be discriminated by their strength.

    Parameters
    ----------
    first, second : Percept
        Percepts with levels in the same unit.

    Returns
    -------
    difference : Difference
        Difference as a change of the voltage amplitude. The attraction is proportional to the square of the voltage, so
        1.21 dB of voltage are 2.42 dB of level.

    Raises
    ------
    InputError
        If only one of them has mechanics, or if nothing moves in one of them.

    Examples
    --------
    >>> one, other = (ev.perceive("bau_2010/sine", set={"drive.amplitude": volts}) for volts in ("50 V", "60 V"))
    >>> ev.compare_percepts(one, other).noticeable
    True
    """
    if first.unit != second.unit:
        raise InputError(
            "levels of a force and of a displacement cannot be compared: add perception.compliance to both, or to neither"
        )
    if not (first.loudest and second.loudest):
        raise InputError("in one of the two nothing moves the skin, so there is no level to compare")
    difference = (first.level - second.level) / 2
    threshold = min(first.difference_threshold, second.difference_threshold)
    noticeable = abs(difference) > threshold
    text = (
        f"{difference:+.2f} dB of voltage amplitude, where the change of the force is proportional to its square, difference"
        f" threshold {threshold:g} dB:"
        f" {'can' if noticeable else 'cannot'} be discriminated by strength; 1.21 dB is from {RYU}, which does not state its"
        " quantity: taken as voltage amplitude"
    )
    if first.loudest != second.loudest:
        text += f"; felt by different channels ({first.loudest}, {second.loudest}), by which they may be discriminated"
    both = tuple(dict.fromkeys((*first.diagnostics, *second.diagnostics)))
    return Difference(
        difference=difference, threshold=threshold, noticeable=noticeable, text=text, diagnostics=both
    )
