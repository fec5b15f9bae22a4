"""Level at which a finger feels a drive, by channel."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.diagnostics import diagnostics_of
from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.core.signals import is_trace
from electrovib.data.traces import open_if_trace
from electrovib.physics.perception import (
    BEST_FREQUENCIES,
    UNVERIFIED_CORNER,
    ElasticViscousSkin,
    Pacinian,
    Perception,
    decibels,
    felt_amplitude,
    strongest,
)
from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.solve.quantities.answer import validity
from electrovib.studies.felt_spectrum import FEWEST, MOST, Lines, force_lines, measured_lines
from electrovib.studies.percept import SETTLED, Felt, Percept, verdict
from electrovib.studies.sensation import sensation_of, stands_on

if TYPE_CHECKING:
    from electrovib.core.arrays import Complex, Real
    from electrovib.core.diagnostics import Diagnostic

Compliance = Callable[[Any], Any]

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
    """
    changes = {path: value for path, value in (set or {}).items() if not _personal(path)}
    scenario, trace = _experiment(source, changes)
    person = perception or getattr(scenario, "perception", None) or Perception()
    person = _changed(person, {path: value for path, value in (set or {}).items() if _personal(path)})
    given = person.compliance or getattr(scenario, "finger", None)
    if scenario is not None:
        found, error = _converged(scenario, person, given)
        return _percept(
            found, person, given, title=scenario.title, error=error, diagnostics=validity(scenario)
        )
    windows = measured_lines(trace, window=person.window)
    if windows[0].signal == "skin_displacement":
        given = None
    found = max(windows, key=lambda one: _level(one, person, given))
    title = str(trace.attrs.get("title", ""))
    stated = tuple(diagnostics_of(trace))
    return _percept(found, person, given, title=title, error=math.nan, diagnostics=stated)


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


def _compliance(given: Any) -> Compliance:
    if given is None:
        return lambda frequency: np.ones_like(np.asarray(frequency, dtype=float))
    found: Compliance = given.compliance
    return found


def _level(found: Lines, person: Perception, given: Any) -> float:
    moved = found.amplitude * np.abs(_compliance(given)(found.frequency))
    return float(decibels(strongest(person, found.frequency, moved)))


def _converged(scenario: Scenario, person: Perception, given: Any) -> tuple[Lines, float]:
    """Double the number of samples until the level is constant."""
    samples = FEWEST
    level = functools.partial(_level, person=person, given=given)
    found = max(force_lines(scenario, window=person.window, samples=samples), key=level)
    while True:
        samples *= 2
        finer = max(force_lines(scenario, window=person.window, samples=samples), key=level)
        change = level(finer) - level(found) if _moves(finer, scenario) else 0.0
        if abs(change) <= SETTLED or finer.samples >= MOST:
            return finer, change
        found = finer


def _moves(found: Lines, scenario: Scenario) -> bool:
    return found.swing > SILENT * scenario.load.normal_force


def felt_level(scenario: Scenario, person: Perception, *, samples: int = FEWEST) -> float:
    """Compute the amplitude of a sine at the best frequency that is felt as strongly [m, or N without mechanics]."""
    given = person.compliance or getattr(scenario, "finger", None)
    windows = force_lines(scenario, window=person.window, samples=samples)
    return float(10 ** (max(_level(found, person, given) for found in windows) / 20))


def _percept(
    found: Lines,
    person: Perception,
    given: Any,
    *,
    title: str,
    error: float,
    diagnostics: tuple[Diagnostic, ...],
) -> Percept:
    displaced = found.signal == "skin_displacement"
    reference = _reference(found, person, given)
    moved = found.amplitude * np.abs(_compliance(given)(found.frequency))
    channels = tuple(_felt(channel, found.frequency, moved, reference) for channel in person.channels)
    top = max(channels, key=lambda felt: felt.level)
    alternatives = _alternatives(found, person, given)
    values = [top.relative, *alternatives.values()]
    absolute = displaced or given is not None
    above = sensation_of(found, person, given)
    sensation = None if above is None else (above.low + above.high) / 2
    uncertainty = None if above is None else (above.high - above.low) / 2
    return Percept(
        title=title,
        channels=channels,
        loudest=top.channel if math.isfinite(top.level) else "",
        level=top.level,
        unit="m" if absolute else "N",
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
        calibrated_on=stands_on(found, person, given),
        diagnostics=diagnostics,
    )


def _reference(found: Lines, person: Perception, given: Any) -> float:
    """Return the felt amplitude of a sine of equal force at the best frequency."""
    best = np.array([person.most_sensitive().best()])
    moved = found.swing * np.abs(_compliance(given)(best))
    return strongest(person, best, moved)


def _felt(channel: Any, frequency: Real, moved: Complex | Real, reference: float) -> Felt:
    level = float(decibels(felt_amplitude(channel, frequency, moved)))
    relative = level - float(decibels(reference)) if reference > 0 else -math.inf
    return Felt(
        channel=type(channel).__name__,
        level=level,
        relative=relative,
        status=channel.status,
        source=channel.reference,
    )


def _alternatives(found: Lines, person: Perception, given: Any) -> dict[str, float]:
    """Return the relative level under other assumptions that are as well founded [dB]."""
    cases: dict[str, tuple[Perception, Any]] = {}
    low, high = BEST_FREQUENCIES
    moved = tuple(
        channel.replace({"best_frequency": high}) if channel == Pacinian() else channel
        for channel in person.channels
    )
    if moved != person.channels:
        cases[f"Pacinian channel best at {high:g} instead of {low:g} Hz"] = (
            person.model_copy(update={"channels": moved}),
            given,
        )
    if len(person.channels) > 1:
        alone = person.model_copy(update={"channels": (person.most_sensitive(),)})
        cases[f"{type(person.most_sensitive()).__name__} channel alone"] = (alone, given)
    if given is None and found.signal != "skin_displacement":
        skin = ElasticViscousSkin(stiffness=1.0, corner=UNVERIFIED_CORNER)
        cases[f"skin elastic to {UNVERIFIED_CORNER:g} Hz, then viscous (cited from memory, unverified)"] = (
            person,
            skin,
        )
    if _reference(found, person, given) == 0:
        return {}
    return {
        name: _level(found, other, skin) - float(decibels(_reference(found, other, skin)))
        for name, (other, skin) in cases.items()
    }
