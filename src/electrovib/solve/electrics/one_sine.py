"""One sine in its steady state, for a law that gives magnitudes at one frequency only."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import NotCausalError
from electrovib.scenario import PeriodicState
from electrovib.solve.electrics.attraction import total_pull
from electrovib.solve.electrics.methods import ONE_SINE
from electrovib.solve.electrics.solution import Solution
from electrovib.solve.stack.expand import behind_amplifier, phasors
from electrovib.solve.stack.harmonics import count_harmonics, spectrum

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.force import ForceLaw
    from electrovib.scenario import Scenario
    from electrovib.solve.electrics.solution import Question


def _loudest_tone(scenario: Scenario) -> tuple[Real, complex]:
    """Return frequency [Hz] and complex amplitude of a drive of one harmonic; its other harmonics have no amplitude."""
    frequencies, tones = spectrum(scenario.drive, harmonics=1)
    loudest = int(np.argmax(np.abs(tones)))
    return frequencies[loudest : loudest + 1], tones[loudest]


def refuse_more_than_one_sine(scenario: Scenario) -> None:
    """Refuse a drive for which a law without a time-domain form has no response."""
    law, drive = scenario.force, scenario.drive
    settled = isinstance(scenario.time.initial_state, PeriodicState)
    if not settled or count_harmonics(drive) != 1:
        raise NotCausalError(_refusal(law, drive.__class__.__name__, settled=settled))
    if _loudest_tone(scenario)[0][0] == 0:
        raise NotCausalError(_refusal(law, "constant voltage", settled=settled))
    if scenario.circuit.amplifier is not None and scenario.circuit.amplifier.is_limited:
        raise NotCausalError(
            _refusal(law, f"{type(drive).__name__} behind an amplifier with limits", settled=settled)
        )


def one_sine(question: Question, fields: Solution) -> Solution:
    """Compute the steady response to one sine by magnitudes, for a law without a time-domain form."""
    scenario, times = question.scenario, question.times
    law, (frequency, tone) = scenario.force, _loudest_tone(scenario)
    exact = behind_amplifier(scenario, phasors(scenario, frequency))
    wave = tone * np.exp(2j * np.pi * frequency[0] * times)
    given = {name: np.real(value[0] * wave) for name, value in law.amplitudes(exact).items()}
    found = dict(fields.found)
    effective = law.effective_voltage(exact)
    if effective is not None:
        found["effective_voltage"] = np.real(effective[0] * wave)
    return Solution(
        found=found,
        method=ONE_SINE,
        reason=f"{type(law).__name__} is defined by magnitudes at one frequency: one sine in its steady state",
        pull=total_pull(scenario, given),
    )


def _refusal(law: ForceLaw, drive: str, *, settled: bool) -> str:
    """Return the message that a law has no causal form, and what to use instead."""
    what = f"the harmonics of a {drive}" if settled else f"a {drive} from rest"
    return (
        f"force = {type(law).__name__}: it gives the magnitude of a response at one frequency and is not causal: with a"
        f" dispersive skin its response to {what} would begin before the drive. Use"
        f" {law.instead or 'a causal law'}, or drive it with one Sine from"
        ' time.initial_state = { model = "PeriodicState" }'
    )
