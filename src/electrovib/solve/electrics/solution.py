"""What an electrical solver is asked for, the response that it finds, and the methods that there are."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from electrovib.core.constants import eps0
from electrovib.physics.stack import INTERFACE
from electrovib.solve.stack.expand import Surroundings
from electrovib.solve.stack.harmonics import drive_mean
from electrovib.solve.stack.keys import AmplitudeOf, DisplacementOf, FieldOf, Key, amplitudes_among
from electrovib.solve.stack.transfer import Transfer, integral_weight

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping

    from electrovib.core.arrays import Indices, Real
    from electrovib.scenario import Scenario
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
"""Signals with one number at each time that a solver may compute."""
OF_LAYERS: Final = {"field": FieldOf, "displacement": DisplacementOf}
"""Signals with one number for each layer at each time."""


STRETCH: Final = 1 << 15
"""Times of a long record that are computed together, so that what is made of them is made in the cache."""


@dataclass(frozen=True, kw_only=True)
class Method:
    """The method of a solver.

    Parameters
    ----------
    name : str
        Name in the Trace.
    by_modes : bool
        Whether the response at any time follows from the modes of the stack at little cost, and is linear in the drive.
    each_alone : bool
        Whether it computes any quantity that is linear in a voltage without the others.
    is_marched : bool
        Whether it integrates over time steps; a second evaluation then takes as long as the first.
    by_regimes : bool
        Whether its steps are regimes, each in closed form, so that only the values at their ends are worth a second run.
    numbers : int
        Numbers that such a method computes at least after each corner of the drive and in each of its cycles.
    holds_steps : bool
        Whether it holds these numbers for all steps at once.
    """

    name: str
    by_modes: bool = False
    each_alone: bool = False
    is_marched: bool = False
    by_regimes: bool = False
    numbers: int = 0
    holds_steps: bool = False


TRANSIENT: Final = Method(name="transient", by_modes=True, each_alone=True)
PERIODIC: Final = Method(name="periodic", by_modes=True, each_alone=True)
CURRENT_DRIVE: Final = Method(name="current drive", by_modes=True)
ONE_SINE: Final = Method(name="one sine", by_modes=True)
RENEWAL: Final = Method(name="renewal")
"""A mean over places, each with a modal response; not linear where it is the mean of a square."""
LEAK: Final = Method(name="nonlinear branch", is_marched=True, numbers=7000, holds_steps=True)
MOVING_GAP: Final = Method(name="moving gap", is_marched=True, numbers=14_000, holds_steps=True)
LIMITED: Final = Method(name="amplifier", is_marched=True, by_regimes=True, numbers=500)
NONLINEAR: Final = Method(name="nonlinear", is_marched=True, numbers=400)


@dataclass(frozen=True, kw_only=True)
class Question:
    """The input of an electrical solver.

    Parameters
    ----------
    scenario : Scenario
        The experiment.
    section : ModalSection
        Its stack per unit of the drive, without leaks.
    times : ndarray, shape (n,)
        Increasing, >= 0 [s].
    wanted : callable
        Returns the wanted quantities of a section that are linear in the drive, ``stack_voltage`` among them.
    """

    scenario: Scenario
    section: ModalSection
    times: Real
    wanted: Callable[[ModalSection], dict[Key, Transfer]]

    @property
    def settled(self) -> bool:
        """Whether the periodic state is asked for."""
        return self.scenario.time.settled


@dataclass(frozen=True, kw_only=True)
class Solution:
    """Response of the stack to a drive over time.

    Parameters
    ----------
    found : dict of Key to ndarray, shape (n,)
        Voltages, currents, fields, displacements, and amplitudes of the law, each in its unit.
    method : Method
        The method of the solver.
    reason : str
        Why this solver ran, and its accuracy.
    force : ndarray, shape (n,), optional
        Attraction [N], where it was asked for.
    of_layers : mapping of str to ndarray, shape (layers, n)
        Fields and displacements of all layers, where those in `found` are rows of one array.
    pull : ndarray, shape (n,), optional
        Attraction per area [Pa], where it does not follow from the amplitudes in `found`: a mean over places.
    errors : mapping of str to float
        Estimated errors [1] and numbers of events, by their names in the Trace.
    events : tuple of float
        Located times [s]: an amplifier reaches a limit, a gap a kink.
    kinks : tuple of float
        Times between the corners of the drive at which an amplifier enters or leaves one of its limits, voltage or current
        [s]; quantities of the response are taken piecewise between them.
    steps : int
        Number of steps of the finest time integration.
    """

    found: dict[Any, Real]
    method: Method
    reason: str
    force: Real | None = None
    of_layers: Mapping[str, Real] = field(default_factory=dict)
    pull: Real | None = None
    errors: Mapping[str, float] = field(default_factory=dict)
    events: tuple[float, ...] = ()
    kinks: tuple[float, ...] = ()
    steps: int = 0

    @property
    def attraction(self) -> Real:
        """Attraction [N]."""
        if self.force is None:
            raise ValueError("no attraction was asked for")
        return self.force

    def amplitudes(self) -> dict[str, Real]:
        """Return the arguments of the law's pressure."""
        return amplitudes_among(self.found)

    def at(self, places: Indices | slice) -> Solution:
        """Return the response at some of its times."""
        found = {key: row[..., places] for key, row in self.found.items()}
        return replace(self, found=found, force=self.attraction[places], of_layers={})

    def how(self) -> dict[str, Any]:
        """Return solver, reason and errors as attributes of a Trace."""
        return {"solver": self.method.name, "solver_reason": self.reason, **self.errors}

    def signals(self, names: tuple[str, ...]) -> dict[str, Any]:
        """Return the computed quantities as signals of a Trace."""
        signals: dict[str, Any] = {
            name: (("time",), self.found[name]) for name in ACROSS if name in self.found
        }
        for quantity, key in OF_LAYERS.items():
            if all(key(name) in self.found for name in names):
                rows = self.of_layers.get(quantity)
                rows = np.array([self.found[key(name)] for name in names]) if rows is None else rows
                signals[quantity] = (("layer", "time"), rows)
        if self.force is not None:
            signals["electrostatic_force"] = ("time",), self.force
        return signals


class Along(NamedTuple):
    """A response along a record.

    Parameters
    ----------
    through : callable
        Returns the response at the times of a stretch (slice); the stretches follow one another.
    at : callable
        Returns voltages, currents and fields at any other times [s], afterwards.
    stretch : int
        Number of times in a stretch.
    known : mapping of Key to ndarray, shape (n,)
        Rows that are known at all times beforehand.
    """

    through: Callable[[slice], Solution]
    at: Callable[[Real], dict[Key, Real]]
    stretch: int
    known: Mapping[Key, Real] = MappingProxyType({})


def linear_quantities(scenario: Scenario, section: Any) -> dict[Key, Any]:
    """Return everything in a result that is linear in the drive."""
    found = fields(scenario, section)
    if not scenario.force.causal:
        return found
    effective = scenario.force.effective_voltage(section)
    if effective is not None:
        found["effective_voltage"] = effective
    return found | amplitudes(scenario, section)


def some_quantities(scenario: Scenario, section: Any, *, asked: Collection[str]) -> dict[Key, Any]:
    """Return the arguments of the law's pressure, and what the signals that are asked for need."""
    if not asked:
        return amplitudes(scenario, section)
    kinds = [kind for name, kind in (("field", FieldOf), ("displacement", DisplacementOf)) if name in asked]
    face = FieldOf(scenario.stack.gap_name or INTERFACE) if "interface_field" in asked else None
    found = linear_quantities(scenario, section)
    return {
        key: each
        for key, each in found.items()
        if key in asked or key == face or isinstance(key, (AmplitudeOf, *kinds))
    }


def amplitudes(scenario: Scenario, section: Any) -> dict[Key, Any]:
    """Return the arguments of the law's pressure."""
    return {AmplitudeOf(name): value for name, value in scenario.force.amplitudes(section).items()}


def fields(scenario: Scenario, section: Any) -> dict[Key, Any]:
    """Return voltage, current, fields and displacements, without quantities of the law."""
    wanted: dict[Key, Any] = {
        "stack_voltage": section.voltage,
        "current": section.current_density * Surroundings.of(scenario).area,
    }
    for name in section.names:
        wanted[FieldOf(name)] = section[name].field
        wanted[DisplacementOf(name)] = section[name].displacement
    if scenario.stack.gap_name is None:
        displacement = section.interface_displacement
        if not (isinstance(displacement, Transfer) and _grown_without_end(scenario, displacement)):
            wanted[FieldOf(INTERFACE)] = displacement * (1 / eps0)
    return wanted


def _grown_without_end(scenario: Scenario, displacement: Transfer) -> bool:
    """Return whether the interface charge is unbounded: a mean voltage over conducting layers in the periodic state."""
    settled = scenario.time.settled
    return settled and bool(np.any(integral_weight(displacement)) and drive_mean(scenario.drive))


def name_interface(scenario: Scenario, found: dict[Key, Real]) -> None:
    """Store the field at the interface under the name of its signal, where it was computed."""
    name = FieldOf(scenario.stack.gap_name or INTERFACE)
    if name in found:
        found["interface_field"] = found[name]
