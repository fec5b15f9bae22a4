"""The electrical answer over time: fields of every layer, and the attraction the law makes of them."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.constants import eps0
from electrovib.core.errors import NotCausalError
from electrovib.physics.interface import INTERFACE
from electrovib.scenario import PeriodicState, Scenario
from electrovib.solve.electrics.linear.periodic import count_harmonics, spectrum
from electrovib.solve.electrics.respond import AMPLITUDE, refuse_unsolved, respond
from electrovib.solve.stack.expand import Surroundings, attraction, behind_amplifier, phasors, total_pull
from electrovib.solve.stack.integrator import drive_mean, integral_weight
from electrovib.solve.stack.transfer import Transfer

if TYPE_CHECKING:
    from electrovib.core.arrays import Indices, Real
    from electrovib.physics.force import ForceLaw
    from electrovib.solve.stack.section import ModalSection

ACROSS = (
    "drive_voltage",
    "drive_current",
    "plate_voltage",
    "stack_voltage",
    "effective_voltage",
    "interface_field",
    "amplifier_current",
    "current",
    "gap",
)
"""Signals of one number at a time that a solver may give."""


@dataclass(frozen=True)
class Electrical:
    """What a drive does to the stack over time.

    Parameters
    ----------
    found : dict of str to ndarray
        Voltages, currents, and ``field NAME`` and ``displacement NAME`` of every layer, each of shape (n,).
    force : ndarray, shape (n,)
        Attraction [N].
    choice : dict
        Solver and reason, and of a march its error.
    """

    found: dict[str, Real]
    force: Real
    choice: dict[str, Any]

    def at(self, places: Indices) -> Electrical:
        """Give the answer at some of its times alone."""
        found = {name: row[places] for name, row in self.found.items()}
        return Electrical(found, self.force[places], self.choice)

    def signals(self, section: ModalSection) -> dict[str, Any]:
        """Name what was found as signals of a Trace: dimensions and values, layers from plate to finger."""
        signals: dict[str, Any] = {
            name: (("time",), self.found[name]) for name in ACROSS if name in self.found
        }
        for quantity in ("field", "displacement"):
            rows = np.array([self.found[f"{quantity} {name}"] for name in section.names])
            signals[quantity] = (("layer", "time"), rows)
        return signals | {"electrostatic_force": (("time",), self.force)}


def electrical(
    scenario: Scenario, section: ModalSection, times: Real, *, force_alone: bool = False
) -> Electrical:
    """Compute fields and attraction over time.

    Parameters
    ----------
    scenario : Scenario
        Everything.
    section : ModalSection
        Its stack as modes.
    times : ndarray, shape (n,)
        Increasing, >= 0 [s].
    force_alone : bool
        Leave out what the attraction does not need, where the solver allows it.

    Returns
    -------
    Electrical
        At these times.

    Raises
    ------
    NotCausalError
        If the force law has no response in time but the drive is not one sine in its steady state.
    InputError
        If models do not go together.
    """
    if not scenario.force.causal:
        return _one_sine(scenario, section, times)
    plain = scenario.drive.quantity == "voltage" and scenario.circuit.amplifier is None
    plain = plain and all(layer.leak is None for layer in scenario.stack.layers.values())
    wanted = functools.partial(_amplitudes if force_alone and plain else linear_quantities, scenario)
    around = Surroundings.of(scenario)
    found, choice, pull = respond(
        scenario, section, wanted, times, element=around.element, second=around.second
    )
    _name_interface(scenario, found)
    given = {key.removeprefix(AMPLITUDE): row for key, row in found.items() if key.startswith(AMPLITUDE)}
    if pull is None:
        pull = total_pull(scenario, given)
    return Electrical(found, attraction(scenario, pull, times), choice)


def refuse_unsolved_electrics(scenario: Scenario) -> None:
    """Refuse what no electrical solver takes; costs nothing, so that it can be told before any work.

    Parameters
    ----------
    scenario : Scenario
        Everything.

    Raises
    ------
    NotCausalError
        If the force law has no response in time but the drive is not one sine in its steady state.
    InputError
        If models do not go together.
    """
    if not scenario.force.causal:
        _refuse_more_than_one_sine(scenario)
    refuse_unsolved(scenario, second=Surroundings.of(scenario).second)


def fields_alone(scenario: Scenario, section: ModalSection, times: Real) -> dict[str, Real]:
    """Compute voltages, currents and the fields of every layer, and no attraction.

    Parameters
    ----------
    scenario, section, times
        As for `electrical`.

    Returns
    -------
    dict of str to ndarray, shape (n,)
        As `Electrical.found`, without what belongs to the force law.
    """
    around = Surroundings.of(scenario)
    wanted = functools.partial(_of_layers, scenario)
    found = respond(scenario, section, wanted, times, element=around.element, second=around.second).found
    _name_interface(scenario, found)
    return found


def linear_quantities(scenario: Scenario, section: Any) -> dict[str, Any]:
    """Name everything in a result that is linear in the drive.

    Parameters
    ----------
    scenario : Scenario
        Law, contact and circuit.
    section : ModalSection or PhasorSection
        The stack.

    Returns
    -------
    dict of str to Transfer or ndarray
        Voltages, current, fields and displacements, and what a causal law makes of them.
    """
    found = _of_layers(scenario, section)
    if not scenario.force.causal:
        return found
    effective = scenario.force.effective_voltage(section)
    if effective is not None:
        found["effective_voltage"] = effective
    return found | _amplitudes(scenario, section)


def _amplitudes(scenario: Scenario, section: Any) -> dict[str, Any]:
    return {f"{AMPLITUDE}{name}": value for name, value in scenario.force.amplitudes(section).items()}


def _of_layers(scenario: Scenario, section: Any) -> dict[str, Any]:
    wanted = {
        "stack_voltage": section.voltage,
        "current": section.current_density * Surroundings.of(scenario).area,
    }
    for name in section.names:
        wanted[f"field {name}"] = section[name].field
        wanted[f"displacement {name}"] = section[name].displacement
    if scenario.stack.gap_name is None:
        displacement = section.interface_displacement
        if not (isinstance(displacement, Transfer) and _grown_without_end(scenario, displacement)):
            wanted[f"field {INTERFACE}"] = displacement * (1 / eps0)
    return wanted


def _grown_without_end(scenario: Scenario, displacement: Transfer) -> bool:
    """Tell whether charge has flown to the interface for ever: a mean voltage over layers that all conduct."""
    settled = isinstance(scenario.time.initial_state, PeriodicState)
    return settled and bool(integral_weight(displacement)) and bool(drive_mean(scenario.drive))


def _name_interface(scenario: Scenario, found: dict[str, Real]) -> None:
    """Give the field at the interface the name of its signal, where it was found."""
    name = f"field {scenario.stack.gap_name or INTERFACE}"
    if name in found:
        found["interface_field"] = found[name]


def _loudest_tone(scenario: Scenario) -> tuple[Real, complex]:
    """Frequency [Hz] and amplitude of a drive of one harmonic; the others are there with no amplitude."""
    frequencies, tones = spectrum(scenario.drive, harmonics=1)
    loudest = int(np.argmax(np.abs(tones)))
    return frequencies[loudest : loudest + 1], tones[loudest]


def _refuse_more_than_one_sine(scenario: Scenario) -> None:
    """Refuse what a law without a time-domain form does not answer."""
    law, drive = scenario.force, scenario.drive
    settled = isinstance(scenario.time.initial_state, PeriodicState)
    if not settled or count_harmonics(drive) != 1:
        raise NotCausalError(refusal(law, drive.__class__.__name__, settled=settled))
    if _loudest_tone(scenario)[0][0] == 0:
        raise NotCausalError(refusal(law, "constant voltage", settled=settled))
    if scenario.circuit.amplifier is not None and scenario.circuit.amplifier.is_limited:
        raise NotCausalError(
            refusal(law, f"{type(drive).__name__} behind an amplifier with limits", settled=settled)
        )


def _one_sine(scenario: Scenario, section: ModalSection, times: Real) -> Electrical:
    """Steady state under one sine by magnitudes, for a law without a time-domain form."""
    _refuse_more_than_one_sine(scenario)
    law, (frequency, tone) = scenario.force, _loudest_tone(scenario)
    exact = behind_amplifier(scenario, phasors(scenario, frequency))
    wave = tone * np.exp(2j * np.pi * frequency[0] * times)
    given = {name: np.real(value[0] * wave) for name, value in law.amplitudes(exact).items()}
    found = fields_alone(scenario, section, times)
    effective = law.effective_voltage(exact)
    if effective is not None:
        found["effective_voltage"] = np.real(effective[0] * wave)
    choice = {
        "solver": "one sine",
        "solver_reason": f"{type(law).__name__} gives magnitudes at one frequency only: one sine in its steady state",
    }
    return Electrical(found, attraction(scenario, total_pull(scenario, given), times), choice)


def refusal(law: ForceLaw, drive: str, *, settled: bool) -> str:
    """Say why a law without a causal form cannot answer, and what to use instead."""
    what = f"the harmonics of a {drive}" if settled else f"a {drive} from rest"
    return (
        f"force = {type(law).__name__}: it gives the size of a response at one frequency and is not causal: with a"
        f" dispersive skin it would answer {what} before the drive begins. Use"
        f" {law.instead or 'a causal law'}, or drive it with one Sine from"
        ' time.initial_state = { model = "PeriodicState" }'
    )
