"""Signals of many fingers over frequency, in arrays over fingers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.paths import quantity_at, value_at
from electrovib.physics.contact import FixedArea
from electrovib.scenario import PeriodicState
from electrovib.solve.choice import chosen
from electrovib.solve.electrics.attraction import PHASES, attraction, total_pull
from electrovib.solve.electrics.solution import ONE_SINE, PERIODIC, TRANSIENT
from electrovib.solve.population.kernels import kernel_name
from electrovib.solve.population.together.accepted import refuse_columns
from electrovib.solve.population.together.amplitude import shared_drive
from electrovib.solve.population.together.arrays import check_values, with_columns
from electrovib.solve.population.together.mean_force import has_modal_mean_force, modal_mean_force
from electrovib.solve.population.together.phasors import ManyPhasors
from electrovib.solve.population.together.quadratic import is_quadratic
from electrovib.solve.population.together.refusal import NotTogetherError
from electrovib.solve.population.together.tile import FEWEST, of_scenario, padded

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from electrovib.core.arrays import Complex, Real
    from electrovib.scenario import Scenario

AT_ONCE: Final = (64, 1024)
"""Fingers in memory together: whose phasors, and whose modes are."""
OVER_FREQUENCY: Final = frozenset(
    {"mean_force", "impedance", "field_gain", "effective_voltage_gain", "permittivity"}
)
"""Signals over frequency that are computed together."""


class OverFrequency:
    """Fingers of a scenario with linear layers under a sine, in arrays over fingers and frequencies.

    Parameters
    ----------
    scenario : Scenario
        Experiment with the values that all fingers share.
    free : tuple of str
        Dotted paths of the parameters that differ between fingers.
    names : tuple of str
        Signals over frequency.
    frequency : ndarray, shape (n,)
        Frequencies [Hz].

    Raises
    ------
    NotTogetherError
        If arrays over fingers do not cover the scenario; with the reason.
    """

    def __init__(
        self, scenario: Scenario, free: tuple[str, ...], names: tuple[str, ...], frequency: Real
    ) -> None:
        self.scenario, self.free, self.names, self.frequency = scenario, free, names, frequency
        _refuse(scenario, free, names)
        self.is_quadratic = is_quadratic(scenario.force)
        self._quantities = {path: quantity_at(scenario, path) for path in free}
        self.kernel = kernel_name()
        self._per_drive = _largest_per_parameter(scenario, free)
        self._is_modal = names == ("mean_force",) and self.is_quadratic and has_modal_mean_force(scenario)
        if self._is_modal:
            try:
                self._of_modes({path: np.full(1, float(value_at(scenario, path))) for path in free})
            except (NotTogetherError, TypeError, ValueError):
                self._is_modal = False

    def signals(
        self,
        draws: Mapping[str, Real],
        *,
        out: Mapping[str, NDArray[Any]] | None = None,
    ) -> dict[str, Any]:
        """Return the signals of fingers."""
        check_values(self.scenario, self._quantities, draws)
        fingers = len(next(iter(draws.values())))
        tiles, at_once = [], AT_ONCE[self._is_modal]
        for begin in range(0, fingers, at_once):
            some = {path: values[begin : begin + at_once] for path, values in draws.items()}
            tiles.append(self._of_modes(some) if self._is_modal else self._of(some))
        return {
            name: np.concatenate(
                [tile[name] for tile in tiles], out=(out or {}).get(name), casting="same_kind"
            )
            for name in self.names
        }

    def _of_modes(self, draws: Mapping[str, Real]) -> dict[str, Any]:
        """Return the mean force of some fingers from modes, that of fingers of another form from phasors."""
        columns, count = padded(self.scenario, draws)
        inner = of_scenario(columns)
        found, regular = modal_mean_force(
            with_columns(self.scenario, inner),
            inner,
            self.frequency,
            rows=max(count, FEWEST),
            amplitude=self._amplitude(columns),
        )
        other = ~regular[:count]
        if np.any(other):
            found[:count][other] = self._of({path: values[other] for path, values in draws.items()})[
                "mean_force"
            ]
        return {"mean_force": found[:count]}

    def _of(self, draws: Mapping[str, Real]) -> dict[str, Any]:
        """Return the signals of some fingers."""
        columns, count = padded(self.scenario, draws)
        rows, inner = max(count, FEWEST), of_scenario(columns)
        scenario = with_columns(self.scenario, inner)
        section = ManyPhasors(scenario, tuple(inner), self.frequency)
        shape = rows, len(self.frequency)
        found = {}
        for name in self.names:
            if name in {"field_gain", "permittivity"}:
                layers = [
                    layer.field * layer.thickness
                    if name == "field_gain"
                    else layer.material.complex_permittivity(self.frequency)
                    for layer in (section[each] for each in section.names)
                ]
                found[name] = np.stack([np.broadcast_to(each, shape) for each in layers], axis=1)[:count]
            else:
                found[name] = np.broadcast_to(self._signal(name, scenario, section, columns), shape)[:count]
        return found

    def _signal(
        self, name: str, scenario: Scenario, section: ManyPhasors, columns: Mapping[str, Real]
    ) -> Real | Complex:
        """Return one signal without a dimension of layers."""
        if name == "impedance":
            return 1 / (section.current_density * scenario.contact_area)
        if name == "effective_voltage_gain":
            found: Complex | None = scenario.force.effective_voltage(section)  # type: ignore[arg-type]
            if found is None:
                raise NotTogetherError("the force law has no effective voltage")
            return found
        return self._mean_force(scenario, section, self._amplitude(columns))

    def _amplitude(self, columns: Mapping[str, Real]) -> Any:
        """Return the largest value of the drive [V], shared or a column."""
        if isinstance(self._per_drive, float):
            return self._per_drive
        path, share = self._per_drive
        return np.abs(columns[path]) * share

    def _mean_force(self, scenario: Scenario, section: ManyPhasors, amplitude: Any) -> Real:
        """Return the time mean of the attraction under a sine [N], as `attraction.mean_force` does."""
        phasors: dict[str, Complex] = scenario.force.amplitudes(section)  # type: ignore[arg-type]
        if self.is_quadratic and len(phasors) == 1:
            ((name, value),) = phasors.items()
            factor = attraction(scenario, total_pull(scenario, {name: np.ones((1, 1))}))
            return np.asarray(factor * (value.real**2 + value.imag**2) * amplitude**2 / 2)
        total: Any = 0.0
        for turn in np.exp(2j * np.pi * np.arange(PHASES) / PHASES).tolist():
            waves = {name: np.real(amplitude * value * turn) for name, value in phasors.items()}
            total = total + attraction(scenario, total_pull(scenario, waves))
        return np.asarray(total / PHASES)


def _refuse(scenario: Scenario, free: tuple[str, ...], names: tuple[str, ...]) -> None:
    """Refuse scenarios whose fingers are computed one by one."""
    foreign = [name for name in names if name not in OVER_FREQUENCY]
    if foreign:
        raise NotTogetherError(f"the signal {foreign[0]} is computed for one finger at a time")
    method = chosen(scenario).method
    if method not in {PERIODIC, TRANSIENT, ONE_SINE}:
        raise NotTogetherError(f"the electrical solver is '{method.name}'")
    if scenario.drive.quantity == "current" or any(layer.leak for layer in scenario.stack.layers.values()):
        raise NotTogetherError("the drive is a current, or a layer leaks")
    if scenario.circuit.amplifier is not None:
        raise NotTogetherError("there is an amplifier before the plate")
    if not isinstance(scenario.contact, FixedArea):
        raise NotTogetherError(
            f"the area of {type(scenario.contact).__name__} follows the force of each finger"
        )
    refuse_columns(scenario, free)


def _largest_per_parameter(scenario: Scenario, free: tuple[str, ...]) -> float | tuple[str, float]:
    """Return the largest value of the drive [V], or the path to which it is proportional and the factor."""
    of_drive = tuple(path for path in free if path.startswith("drive."))
    largest = scenario.drive.largest()
    if not of_drive:
        return largest
    settled = isinstance(scenario.time.initial_state, PeriodicState)
    drive = shared_drive(scenario, of_drive, scenario.time.times(scenario.drive), settled=settled)
    if drive.fixed is not None or len(drive.shares) != 1:
        raise NotTogetherError("the largest voltage is not proportional to one parameter of the drive")
    (path,) = drive.shares
    value = abs(float(value_at(scenario, path)))
    if not value:
        raise NotTogetherError("the largest voltage of the scenario is 0")
    return path, largest / value
