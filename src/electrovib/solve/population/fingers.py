"""A scenario as a function of values that differ from finger to finger, for many fingers in one call."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError, gathered, nearest, refuse
from electrovib.core.paths import quantity_at
from electrovib.core.signals import SIGNALS
from electrovib.scenario import Source, read_scenario
from electrovib.solve.choice import refuse_unsolved
from electrovib.solve.one_by_one import KERNEL, ParametricScenario, over_which
from electrovib.solve.population.arrays import Arrays
from electrovib.solve.population.kernels import kernel_name
from electrovib.solve.stack.transfer import NotInArraysError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario

TOGETHER: Final = (
    "together: arrays over fingers (linear layers, a fixed gap, a drive of straight pieces or sines, friction without"
    " memory)"
)
"""Method that is stated where fingers are computed in arrays."""
GRIDS: Final = ("time", "frequency")
"""Parts of a scenario that are the same for all fingers."""


def population(
    scenario: Source,
    free: Sequence[str],
    signals: Sequence[str] = ("electrostatic_force",),
    time: ArrayLike | None = None,
) -> Population:
    """Prepare a scenario for many fingers that differ in a few parameters.

    `time` (n,) [s].
    """
    return Population(read_scenario(scenario), free=free, signals=signals, time=time)


class Population:
    """Signals of many fingers, each the scenario with its own values of a few parameters.

    Parameters
    ----------
    scenario : Scenario
        Experiment with the values that all fingers share.
    free : sequence of str
        Dotted paths of the parameters that differ between fingers.
    signals : sequence of str
        Names of the signals, all over time or all over frequency.
    time : array_like, shape (n,), optional
        Output times, increasing, >= 0 [s]; by default those of the scenario's time grid.
    band : ndarray, shape (m,), optional
        Times over whose band materials are reduced to Debye terms [s]; by default the output times.

    Attributes
    ----------
    method : str
        How the fingers are computed, together or one by one, and why.
    kernel : str
        Kernel over fingers on which the last bits of the numbers depend.
    free, names : tuple of str
        Paths that differ between fingers; signals.
    time : ndarray, shape (n,), or None
        Output times [s]; None for signals over frequency.
    frequency : ndarray, shape (n,), or None
        Frequencies [Hz]; None for signals over time.

    Raises
    ------
    InputError
        As for `population`.

    Notes
    -----
    The numbers of a finger do not depend on the other fingers in a call, to rounding.
    """

    def __init__(
        self,
        scenario: Scenario,
        *,
        free: Sequence[str],
        signals: Sequence[str] = ("electrostatic_force",),
        time: ArrayLike | None = None,
        band: Real | None = None,
    ) -> None:
        self.free = (free,) if isinstance(free, str) else tuple(free)
        self.names = (signals,) if isinstance(signals, str) else tuple(signals)
        _refuse(scenario, self.free, self.names)
        refuse_unsolved(scenario)
        self.scenario = scenario
        self.time: Real | None = None
        self.frequency: Real | None = None
        if over_which(self.names) == "time":
            self.time = scenario.time.times(scenario.drive) if time is None else _checked(time)
        elif time is None:
            self.frequency = scenario.frequency.frequencies()
        else:
            raise InputError("time: signals over frequency have no output times; omit it")
        self.prepared, self._band = ParametricScenario(scenario, self.free), band
        self.method, self.kernel = TOGETHER, kernel_name()
        self._together: Arrays | None = None
        try:
            self._together = Arrays(scenario, self.prepared, self.names, self.time, band)
        except NotInArraysError as reason:
            self.method, self.kernel = f"one by one: {reason}", KERNEL

    @property
    def shares_times(self) -> bool:
        """Whether the drives of all fingers have the same times and frequencies, where signals are over time."""
        return self._together is None or self._together.drive is not None

    def signals(self, draws: Mapping[str, ArrayLike]) -> dict[str, Any]:
        """Compute the signals of fingers."""
        columns = self.columns(draws)
        return self._alone(columns) if self._together is None else self._together.signals(columns)

    def parts(self, draws: Mapping[str, ArrayLike]) -> Iterator[tuple[Any, dict[str, Any]]]:
        """Yield the indices and the signals of some fingers after the other; several threads may do so at once."""
        columns = self.columns(draws)
        if self._together is None:
            yield slice(None), self._alone(columns)
        else:
            yield from self._together.parts(columns)

    def _alone(self, columns: Mapping[str, Real]) -> dict[str, Any]:
        """Return the signals of fingers, each computed by itself."""
        return self.prepared.of_many(columns, names=self.names, time=self.time, band=self._band)

    def columns(self, draws: Mapping[str, ArrayLike]) -> dict[str, Real]:
        """Return the values of all free parameters for each finger."""
        foreign = [path for path in draws if path not in self.free]
        if foreign:
            listed = ", ".join(self.free)
            raise InputError(f"{foreign[0]}: not a free parameter; the free parameters are {listed}")
        given = {path: np.atleast_1d(np.asarray(values, dtype=float)) for path, values in draws.items()}
        shapes = {values.shape for values in given.values()}
        if len(shapes) != 1 or any(len(shape) != 1 or not shape[0] for shape in shapes):
            counts = ", ".join(f"{path} has {values.shape}" for path, values in given.items())
            raise InputError(
                f"draws: one value for each finger is needed in every array, and at least one finger; {counts or 'none given'}"
            )
        count = shapes.pop()
        begin = self.prepared.begin
        return {path: given[path] if path in given else np.full(count, begin[path]) for path in self.free}


def _checked(time: ArrayLike) -> Real:
    """Return output times as an array; refuse times that are not increasing from 0 or later."""
    times = np.array(time, dtype=float)
    if times.ndim != 1 or not times.size or not (times[0] >= 0 and np.all(np.diff(times) > 0)):
        raise InputError("time: expected increasing output times from 0 s or later, at least one")
    if not np.isfinite(times[-1]):
        raise InputError("time: expected finite output times")
    return times


def _refuse(scenario: Scenario, free: tuple[str, ...], names: tuple[str, ...]) -> None:
    """Refuse unknown signals, grids that differ between fingers, and parameters without a value; all at once."""
    problems: list[str] = [
        f"signals = '{name}': not a signal.{nearest(name, SIGNALS)}"
        for name in names
        if name not in SIGNALS or not SIGNALS[name].dims
    ]
    problems += [
        f"{path}: the grid is the same for all fingers; choose another parameter"
        for path in free
        if path.partition(".")[0] in GRIDS
    ]
    for path in free:
        with gathered(problems):
            quantity_at(scenario, path)
    if not free:
        problems.append("free: name at least one parameter that differs between fingers")
    refuse(problems)
