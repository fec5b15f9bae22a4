"""Values at a frequency: signals of a Trace over frequency, a capacitance, and a law that knows magnitudes only."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import NotCausalError
from electrovib.scenario import Scenario
from electrovib.solve.electrics.attraction import mean_force, total_pull
from electrovib.solve.electrics.solution import ONE_SINE, Solution
from electrovib.solve.stack.expand import behind_amplifier, per_volt_of, phasors
from electrovib.solve.stack.harmonics import count_harmonics, spectrum
from electrovib.solve.stack.keys import AmplitudeOf, amplitudes_among
from electrovib.solve.stack.modes import stacked
from electrovib.solve.stack.section import PhasorSection

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.force import ForceLaw
    from electrovib.solve.electrics.solution import Question
    from electrovib.solve.stack.keys import Key
    from electrovib.solve.stack.transfer import Column


OVER_FREQUENCY: Final = frozenset(
    {"mean_force", "impedance", "field_gain", "effective_voltage_gain", "permittivity"}
)
"""Signals over frequency."""


def over_frequency(
    scenario: Scenario,
    section: PhasorSection,
    *,
    amplitude: Column | None = None,
    wanted: frozenset[str] = OVER_FREQUENCY,
) -> dict[str, Any]:
    """Compute signals over frequency; a number of the scenario may be a column with one value for each case.

    `amplitude` is the largest value of the drive, by default that of the scenario.
    """
    frequency, found = section.frequency, dict[str, Any]()
    if "mean_force" in wanted:
        largest = scenario.drive.largest() if amplitude is None else amplitude
        force = mean_force(scenario, behind_amplifier(scenario, section), amplitude=largest)
        found["mean_force"] = (("frequency",), force)
    if wanted <= found.keys():
        return found
    plate = per_volt_of(scenario, frequency)
    per_volt = behind_amplifier(scenario, plate)
    layers = per_volt.layers.values()
    effective = scenario.force.effective_voltage(per_volt)
    if effective is not None:
        found["effective_voltage_gain"] = (("frequency",), effective)
    gains = [np.asarray(state.field * state.thickness) for state in layers]
    permittivities = [state.material.complex_permittivity(frequency) for state in layers]
    found["field_gain"] = (("layer", "frequency"), stacked(gains))
    found["impedance"] = (("frequency",), 1 / (plate.current_density * scenario.contact_area))
    found["permittivity"] = (("layer", "frequency"), stacked(permittivities))
    return found


def sine_of(scenario: Scenario) -> Real | None:
    """Return the frequency [Hz] of the single sine at which a scenario has a capacitance, shape (1,); else None."""
    if count_harmonics(scenario.drive) is None or scenario.motion.moved_gap or scenario.contact.closing:
        return None
    frequencies, tones = spectrum(scenario.drive, harmonics=1)
    found = frequencies[(frequencies > 0) & (tones != 0)]
    return found if found.size == 1 else None


def capacitance(scenario: Scenario, times: Real) -> dict[str, tuple[tuple[str], Real]]:
    """Compute the capacitance that is in parallel with a conductance in the admittance seen by the drive.

    `times` (n,) [s].
    """
    frequency = sine_of(scenario)
    if frequency is None:
        return {}
    is_constant = scenario.load.time_profile.is_constant
    area = scenario.contact.outline(scenario.load.forces(times[:1] if is_constant else times))
    admittance = area * per_volt_of(scenario, frequency, area=area).current_density
    found = admittance.imag / (2 * np.pi * frequency)
    return {"capacitance": (("time",), np.full(len(times), found[0]) if is_constant else found)}


def loudest_tone(scenario: Scenario) -> tuple[Real, complex]:
    """Return frequency [Hz] and complex amplitude of a drive of one harmonic; its other harmonics have no amplitude."""
    frequencies, tones = spectrum(scenario.drive, harmonics=1)
    loudest = int(np.argmax(np.abs(tones)))
    return frequencies[loudest : loudest + 1], tones[loudest]


def refuse_more_than_one_sine(scenario: Scenario) -> None:
    """Refuse a drive for which a law without a time-domain form has no response."""
    law, drive = scenario.force, scenario.drive
    settled = scenario.time.settled
    if not settled or count_harmonics(drive) != 1:
        raise NotCausalError(_refusal(law, drive.__class__.__name__, settled=settled))
    if loudest_tone(scenario)[0][0] == 0:
        raise NotCausalError(_refusal(law, "constant voltage", settled=settled))
    if scenario.circuit.supply.is_limited:
        raise NotCausalError(
            _refusal(law, f"{type(drive).__name__} behind an amplifier with limits", settled=settled)
        )


def of_one_sine(scenario: Scenario, frequency: Real, wave: Any) -> dict[Key, Any]:
    """Return the amplitudes of a law that is defined by magnitudes, under a `wave` (..., n) at a frequency (1,) [Hz]."""
    law, exact = scenario.force, behind_amplifier(scenario, phasors(scenario, frequency))
    found: dict[Key, Any] = {
        AmplitudeOf(name): np.real(value * wave) for name, value in law.amplitudes(exact).items()
    }
    effective = law.effective_voltage(exact)
    return found if effective is None else found | {"effective_voltage": np.real(effective * wave)}


def one_sine(question: Question, fields: Solution) -> Solution:
    """Compute the steady response to one sine by magnitudes, for a law without a time-domain form."""
    scenario, (frequency, tone) = question.scenario, loudest_tone(question.scenario)
    own = of_one_sine(scenario, frequency, tone * np.exp(2j * np.pi * frequency[0] * question.times))
    law = type(scenario.force).__name__
    return Solution(
        found=fields.found | {key: row for key, row in own.items() if not isinstance(key, AmplitudeOf)},
        method=ONE_SINE,
        reason=f"{law} is defined by magnitudes at one frequency: one sine in its steady state",
        pull=total_pull(scenario, amplitudes_among(own)),
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
