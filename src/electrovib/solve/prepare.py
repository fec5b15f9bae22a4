"""A scenario as a function of a few of its parameters, which computes again only what they touch."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.changes import stored_changes
from electrovib.core.errors import InputError
from electrovib.core.numbers import with_numbers
from electrovib.core.paths import quantity_at, value_at
from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.solve.expanded import OF_ELECTRICS, Expanded
from electrovib.solve.quantities import answer
from electrovib.solve.quantities.answer import numbers
from electrovib.solve.quantities.names import DEFAULTS, read_name
from electrovib.solve.quantities.resolve import solved

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Real
    from electrovib.solve.quantities import Answer


def prepare(
    scenario: Source,
    *,
    free: Sequence[str],
    quantities: Sequence[str] = DEFAULTS,
) -> Prepared:
    """Make a scenario ready to be computed again and again with a few other numbers in it.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        Everything that stays, as for `electrovib.load`.
    free : sequence of str
        Dotted paths of the parameters that vary, for instance ``["stack.gap.thickness", "friction.coefficient"]``.
    quantities : sequence of str
        Numbers to give, as ``electrovib run --quantity`` names them: ``"mean electrostatic_force"``.

    Returns
    -------
    Prepared
        A function of these parameters.

    Raises
    ------
    InputError
        Every path and every quantity that is not there, with the nearest name.
    """
    return Prepared(read_scenario(scenario), free=free, quantities=quantities)


class Prepared:
    """A scenario as a function of some of its parameters.

    Parameters
    ----------
    scenario : Scenario
        Everything that stays.
    free : sequence of str
        Dotted paths of physical parameters, in the order in which a sequence of numbers gives them.
    quantities : sequence of str
        Names of numbers.

    Raises
    ------
    InputError
        Every path and every quantity that is not there, with the nearest name.

    Notes
    -----
    Parts of the scenario that hold no changed number stay the same objects, and what was computed from them alone is
    kept: the drive's pieces, the modes of the stack unless a layer, the circuit or the contact area changes, and the
    attraction unless one of these, the drive, the law, the load or the motion changes. Nothing electrical is computed
    again where only friction, fingertip or rig vary. The numbers are those of `electrovib.sweep`, without its judgement
    of how far to believe them, which `judged` gives.
    """

    def __init__(
        self, scenario: Scenario, *, free: Sequence[str], quantities: Sequence[str] = DEFAULTS
    ) -> None:
        problems: list[str] = []
        layers = tuple(scenario.stack.layers)
        self._names, self.free = [], tuple(free)
        for path in self.free:
            try:
                quantity_at(scenario, path)
            except InputError as error:
                problems += error.problems
        for text in quantities:
            try:
                self._names.append(read_name(" ".join(text.split()), layers))
            except InputError as error:
                problems += error.problems
        problems += [
            f"free: '{path}' is named twice" for path in {p for p in self.free if self.free.count(p) > 1}
        ]
        if problems:
            raise InputError(problems)
        begin = {path: value_at(scenario, path) for path in self.free}
        self.base = scenario.replace(begin) if begin else scenario
        self.begin = begin
        self._last: Expanded | None = None
        self._run: Expanded | None = None

    @property
    def quantities(self) -> tuple[str, ...]:
        """Names of the numbers that a call gives."""
        return tuple(each.name for each in self._names)

    def scenario(self, values: Mapping[str, float] | Sequence[float]) -> Scenario:
        """Give the scenario at a point.

        Parameters
        ----------
        values : mapping of str to float, or sequence of float
            By path, those left out as in the base; or all in the order of `free`. In SI.

        Returns
        -------
        Scenario
            Validated; it shares with the last one what did not change.

        Raises
        ------
        InputError
            If a path is not free, or a value is outside its range.
        """
        point, problems = stored_changes(self.base, self._point(values))
        if problems:
            raise InputError(problems)
        last = self._last.scenario if self._last is not None else self.base
        changed = {path: value for path, value in point.items() if _leaf(last, path) != value}
        return with_numbers(last, changed) if changed else last

    def __call__(self, values: Mapping[str, ArrayLike] | ArrayLike) -> dict[str, Any]:
        """Compute the quantities at one point, or at many.

        Parameters
        ----------
        values : mapping of str to array_like, or array_like, shape (free, ...)
            By path, or in the order of `free`; numbers, or arrays that are broadcast against each other. In SI.

        Returns
        -------
        dict of str to float or ndarray
            Each quantity in its unit, an array where arrays were given.

        Raises
        ------
        InputError
            If a path is not free, a value is outside its range, or models do not go together.
        """
        given = self._columns(values)
        columns = np.broadcast_arrays(*[np.asarray(each, dtype=float) for each in given.values()])
        if not columns or columns[0].ndim == 0:
            return dict(self._numbers({path: float(each) for path, each in zip(given, columns, strict=True)}))
        points = zip(*[column.ravel().tolist() for column in columns], strict=True)
        rows = [self._numbers(dict(zip(given, point, strict=True))) for point in points]
        shape = columns[0].shape
        return {name: np.array([row[name] for row in rows]).reshape(shape) for name in self.quantities}

    def signals(
        self,
        values: Mapping[str, float] | Sequence[float],
        *,
        names: Sequence[str] = ("electrostatic_force",),
        time: ArrayLike | None = None,
    ) -> dict[str, Real]:
        """Compute whole signals at a point.

        Parameters
        ----------
        values : mapping of str to float, or sequence of float
            As for `scenario`, in SI.
        names : sequence of str
            Signals over time.
        time : array_like, shape (n,), optional
            Increasing, >= 0 [s]; by default what the scenario's time grid says.

        Returns
        -------
        dict of str to ndarray, shape (n,) or (layers, n)
            Each in its unit, with ``time`` [s].

        Raises
        ------
        InputError
            If there is no such signal, or as for a call.
        """
        member = self.scenario(values)
        times = None if time is None else np.asarray(time, dtype=float)
        self._run = Expanded(member, times, before=self._run)
        record = self._run.at(self._run.times, wanted=names)
        missing = [name for name in names if name not in record.signals]
        if missing:
            known = ", ".join(sorted(record.signals))
            raise InputError(f"signals: this scenario has no '{missing[0]}'. Known: {known}.")
        return {"time": record.times} | {name: record.signals[name][1] for name in names}

    def judged(self, values: Mapping[str, float] | Sequence[float]) -> Answer:
        """Compute the quantities at a point, with how far to believe them.

        Parameters
        ----------
        values : mapping of str to float, or sequence of float
            As for `scenario`, in SI.

        Returns
        -------
        Answer
            Values, errors, solver and diagnostics.

        Raises
        ------
        InputError
            As for a call.
        """
        return answer(solved(self.scenario(values)), self._names)

    def _numbers(self, point: Mapping[str, float]) -> dict[str, float]:
        mechanics = not {each.signal for each in self._names} <= OF_ELECTRICS
        self._last = solved(self.scenario(point), before=self._last, mechanics=mechanics)
        found, _, _ = numbers(self._last, self._names, alone=True)
        return found

    def _columns(self, values: Mapping[str, Any] | Any) -> dict[str, Any]:
        if isinstance(values, Mapping):
            return dict(values)
        given = list(values)
        if len(given) != len(self.free):
            raise InputError(
                f"values: {len(given)} given, {len(self.free)} expected, one for each of {', '.join(self.free)}"
            )
        return dict(zip(self.free, given, strict=True))

    def _point(self, values: Mapping[str, float] | Sequence[float]) -> dict[str, float]:
        given = self._columns(values)
        foreign = [path for path in given if path not in self.begin]
        if foreign:
            raise InputError(f"{foreign[0]}: is not free; free are {', '.join(self.free)}")
        return self.begin | given


def _leaf(model: Any, path: str) -> Any:
    """Look a number up without writing the whole model as tables."""
    for key in path.split("."):
        model = model[int(key)] if isinstance(model, tuple) else getattr(model, key)
    return model
