"""A scenario as a function of a few of its parameters, which recomputes only what depends on them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.changes import is_stored_as_given, stored_changes, stored_path
from electrovib.core.errors import InputError
from electrovib.core.model import Model
from electrovib.core.numbers import with_numbers
from electrovib.core.paths import quantity_at, value_at
from electrovib.core.signals import without
from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.solve.expanded import OF_ELECTRICS, Expanded
from electrovib.solve.quantities import answer
from electrovib.solve.quantities.answer import numbers, validity
from electrovib.solve.quantities.names import DEFAULTS, read_name
from electrovib.solve.quantities.resolve import solved

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Real
    from electrovib.core.diagnostics import Diagnostic
    from electrovib.solve.quantities import Answer


def prepare(
    scenario: Source,
    *,
    free: Sequence[str],
    quantities: Sequence[str] = DEFAULTS,
) -> Prepared:
    """Prepare a scenario for repeated evaluation with other values of a few parameters.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        Experiment with the values that stay fixed, as for `electrovib.load`.
    free : sequence of str
        Dotted paths of the parameters that vary, for instance ``["stack.gap.thickness", "friction.coefficient"]``.
    quantities : sequence of str
        Quantities to return, as ``electrovib run --quantity`` names them: ``"mean electrostatic_force"``.

    Returns
    -------
    Prepared
        A function of these parameters.

    Raises
    ------
    InputError
        If a path or a quantity does not exist; names all of them, each with the nearest name.
    """
    return Prepared(read_scenario(scenario), free=free, quantities=quantities)


class Prepared:
    """A scenario as a function of some of its parameters.

    Parameters
    ----------
    scenario : Scenario
        Experiment with the values that stay fixed.
    free : sequence of str
        Dotted paths of physical parameters, in the order of the values given as a sequence.
    quantities : sequence of str
        Names of the quantities to return.

    Raises
    ------
    InputError
        If a path or a quantity does not exist; names all of them, each with the nearest name.

    Notes
    -----
    Parts of the scenario without a changed value stay the same objects, and results that depend on them alone are
    kept: the pieces of the drive, the modes of the stack unless a layer, the circuit or the contact area changes, and the
    attraction unless one of these, the drive, the law, the load or the motion changes. No electrical quantity is
    recomputed where only friction, fingertip or rig vary. The values are those of `electrovib.sweep`. They are not judged
    as they are computed: `diagnostics` judges the last of them, and `judged` any.
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
        stored = {path: stored_path(scenario, path) for path in self.free}
        plain = all(is_stored_as_given(scenario, path, Model) for path in stored.values())
        self.base = scenario if plain else scenario.replace(begin)
        self.begin = begin
        self._stored = stored if plain and len(set(stored.values())) == len(stored) else None
        self._recent = self.base
        self._last: Expanded | None = None
        self._run: Expanded | None = None

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Diagnostics of the scenario with the values for which it was made last, at first with its own."""
        return validity(self._recent)

    @property
    def quantities(self) -> tuple[str, ...]:
        """Names of the quantities that a call returns."""
        return tuple(each.name for each in self._names)

    def scenario(self, values: Mapping[str, float] | Sequence[float]) -> Scenario:
        """Return the scenario for given values of the free parameters."""
        point = self._by_stored_path(self._point(values))
        last = self._recent
        changed = {path: value for path, value in point.items() if _leaf(last, path) != value}
        if changed:
            self._recent = with_numbers(last, changed)
        return self._recent

    def __call__(self, values: Mapping[str, ArrayLike] | ArrayLike) -> dict[str, Any]:
        """Compute the quantities for one set of values of the free parameters, or for many."""
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
        band: Real | None = None,
    ) -> dict[str, Real]:
        """Compute signals over time for given values of the free parameters.

        `time` (n,) [s] are the output times, by default those of the scenario; `band` (m,) [s] those of a run over whose band
        the materials are reduced.
        """
        member = self.scenario(values)
        times = None if time is None else np.asarray(time, dtype=float)
        self._run = Expanded(member, times if band is None else band, before=self._run)
        record = self._run.at(self._run.times if times is None else times, wanted=names)
        missing = [name for name in names if name not in record.signals]
        if missing:
            raise InputError(without(missing[0], record.signals))
        return {"time": record.times} | {name: record.signals[name][1] for name in names}

    def judged(self, values: Mapping[str, float] | Sequence[float]) -> Answer:
        """Compute the quantities for given values of the free parameters, with their diagnostics."""
        return answer(solved(self.scenario(values)), self._names)

    def _numbers(self, point: Mapping[str, float]) -> dict[str, float]:
        mechanics = not {each.signal for each in self._names} <= OF_ELECTRICS
        self._last = solved(self.scenario(point), before=self._last, mechanics=mechanics)
        found, _, _ = numbers(self._last, self._names, alone=True)
        return found

    def _by_stored_path(self, point: Mapping[str, float]) -> dict[str, float]:
        """Return values by the paths of the parameters that the models store."""
        if self._stored is not None:
            return {self._stored[path]: value for path, value in point.items()}
        changes, problems = stored_changes(self.base, point)
        if problems:
            raise InputError(problems)
        return changes

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
            raise InputError(
                f"{foreign[0]}: not a free parameter; the free parameters are {', '.join(self.free)}"
            )
        return self.begin | given


def _leaf(model: Any, path: str) -> Any:
    """Return the number at a dotted path, without converting the whole model to tables."""
    for key in path.split("."):
        model = model[int(key)] if isinstance(model, tuple) else getattr(model, key)
    return model
