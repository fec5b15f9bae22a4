"""A simulated recording of the scenario of a page, in which one parameter differs, for a visitor who has no recording."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.apps.explorer.pictures import EXAMPLE
from electrovib.apps.explorer.reading import fittable, read_upload
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.core.paths import value_at
from electrovib.core.signals import SIGNALS
from electrovib.view.units import pretty_quantity

if TYPE_CHECKING:
    import xarray
    from numpy.typing import NDArray

    from electrovib.apps.explorer.computed import Computed
    from electrovib.scenario import Scenario

HIDDEN: Final = (
    "stack.gap.thickness",
    "stack.stratum_corneum.thickness",
    "stack.insulator.thickness",
    "friction.coefficient",
    "contact.area",
)
"""Parameters that may differ, the first one first that the signal shows clearly."""
MEASURED: Final = ("lateral_force_measured", "lateral_force", "electrostatic_force")
"""Signals that may be recorded, as an instrument would, the first one first that varies."""
FACTOR: Final = 1.3
"""Ratio of the hidden value to that of the scenario."""
NOISE: Final = 0.015
"""Standard deviation of the noise, over the difference between the largest and the smallest value of the signal."""
_CLEAR: Final = 2.0
"""Root mean square of what the hidden value changes, over that of the noise, from which it is clear."""
_CONSTANT: Final = 1e-3
"""Part of its largest value by which a signal varies at least; the noise of any other is a part of its value."""
SEED: Final = 29


@dataclass(frozen=True)
class Example:
    """A simulated recording as a file (CSV) with one `signal`; `path` had the hidden `value` [SI], in `unit`.

    `name` is what it is called wherever it is shown.
    """

    name: str
    content: bytes
    signal: str
    path: str
    value: float
    unit: str

    @property
    def remark(self) -> str:
        """What was hidden, as the page states it after a fit."""
        value = pretty_quantity(self.value, self.unit, digits=4)
        return f"The example was simulated with {self.path} = {value}."

    def read(self) -> xarray.Dataset:
        """Read it as a file that a visitor drops."""
        found = read_upload(f"{EXAMPLE}).csv", self.content, {self.signal: self.signal})
        assert found.trace is not None
        return found.trace.assign_attrs(title=self.name)


def example(shown: Computed, name: str) -> Example:
    """Simulate a recording of the scenario as it is shown, with one parameter of `HIDDEN` increased and with noise.

    `name` is that of the scenario. A scenario is refused that has no signal over time of `MEASURED`, or none that
    a parameter changes clearly.
    """
    times, signal = shown.values("time"), _signal(shown)
    even = np.linspace(times[0], times[-1], times.size)  # as an instrument samples
    before = _sampled(shown.scenario, signal, even)
    noise = NOISE * _scale(before)
    for path in HIDDEN:
        if path not in fittable(shown.scenario):
            continue
        value = float(f"{FACTOR * value_at(shown.scenario, path):.3g}")
        try:
            after = _sampled(shown.scenario.replace({path: value}), signal, even)
        except ElectrovibError:  # beyond the declared range
            continue
        if np.sqrt(np.mean((after - before) ** 2)) >= _CLEAR * noise:
            words = f"{EXAMPLE}: {name} with one value changed and noise)"
            units = {each: quantity.unit for each, _, quantity in shown.scenario.parameters()}
            return Example(words, _written(even, after, noise, signal), signal, path, value, units[path])
    raise InputError(
        f"There is no example for this scenario: none of {', '.join(HIDDEN)} changes its {_plain(signal)} clearly."
        " Choose another scenario."
    )


def _signal(shown: Computed) -> str:
    """Return the signal that is recorded: the first one that varies, else the first one that is not 0."""
    known = [each for each in MEASURED if shown.has(each) and np.isfinite(shown.values(each)).all()]
    varying = [
        each for each in known if np.ptp(shown.values(each)) > _CONSTANT * _largest(shown.values(each))
    ]
    for each in (*varying, *known):
        if _largest(shown.values(each)) > 0:
            return each
    raise InputError(
        f"There is no example for this scenario: it has no {' or '.join(map(_plain, MEASURED))} over time."
        " Choose another scenario."
    )


def _largest(values: NDArray[Any]) -> float:
    return float(np.abs(values).max())


def _scale(values: NDArray[Any]) -> float:
    """Return the size of a signal to which its noise is relative."""
    largest, range_ = _largest(values), float(np.ptp(values))
    return range_ if range_ > _CONSTANT * largest else largest


def _sampled(scenario: Scenario, signal: str, time: NDArray[Any]) -> NDArray[Any]:
    from electrovib.solve.simulate import simulate

    return np.asarray(simulate(scenario, time=time)[signal].values)


def _written(time: NDArray[Any], values: NDArray[Any], noise: float, signal: str) -> bytes:
    """Write a file with the noise of an instrument."""
    noisy = values + noise * np.random.default_rng(SEED).normal(size=values.size)
    rows = (f"{at:.9g},{each:.7g}" for at, each in zip(time, noisy, strict=True))
    return "\n".join([f"time (s),{signal} ({SIGNALS[signal].unit})", *rows]).encode()


def _plain(name: str) -> str:
    return name.replace("_", " ")
