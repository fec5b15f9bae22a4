"""What a scenario predicts for recordings, as one vector over the unknown numbers, its derivatives, and the residuals."""

from __future__ import annotations

import dataclasses
import functools
import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import ElectrovibError, InputError
from electrovib.core.paths import quantity_at, value_at
from electrovib.recordings.fit.least_squares import FreeParameter
from electrovib.recordings.fit.measured import MeasuredTrace, Observed, observed
from electrovib.solve.electrics.over_frequency import over_frequency
from electrovib.solve.mechanics.lateral import INDEPENDENT, proportional_to_friction
from electrovib.solve.one_by_one import ParametricScenario
from electrovib.solve.stack.expand import phasors

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario

STEP: Final = 1e-6
"""Relative step of the one-sided derivatives: truncation and rounding are both below 1e-6 of them."""
_DECADES: Final = 100.0
"""Ratio of the declared bounds from which a positive parameter is searched by its logarithm."""


@dataclass(frozen=True)
class Unknown:
    """One number that a fit looks for.

    `name` is the dotted path with the session where it varies; `path` that of a parameter, or the signal of
    an offset; `session` is empty if all share it. `record` and `column` are the recording and the signal of
    an offset; else -1.
    """

    name: str
    path: str
    session: str = ""
    record: int = -1
    column: int = -1

    @property
    def is_offset(self) -> bool:
        """Whether it is the zero of a signal."""
        return self.record >= 0


class Prediction:
    """The predictions for several recordings as a function of the unknown numbers, which begin at `start` or the scenario."""

    def __init__(
        self,
        scenario: Scenario,
        measured: Sequence[MeasuredTrace],
        *,
        free: Sequence[str],
        varying: Sequence[str] = (),
        signals: Sequence[str] | None = None,
        start: Mapping[str, float] | None = None,
    ) -> None:
        if not measured:
            raise InputError("a fit needs at least one recording")
        if foreign := [path for path in varying if path not in free]:
            raise InputError(f"{foreign[0]}: varies between sessions, but is not among the free parameters")
        self.measured = tuple(measured)
        self.columns: tuple[tuple[Observed, ...], ...] = tuple(observed(each, signals) for each in measured)
        self.prepared = tuple(
            ParametricScenario(scenario.replace(each.changes) if each.changes else scenario, free)
            for each in measured
        )
        self.unknowns = tuple(self._unknowns(free, varying))
        if len({each.name for each in self.unknowns}) < len(self.unknowns):
            raise InputError("two recordings have the same name: give each its own")
        self.free = {each.name: self._parameter(each, start or {}) for each in self.unknowns}
        self._last: tuple[object, Real] | None = None
        self._linear: dict[str, NDArray[np.bool_] | None] = {}

    @functools.cached_property
    def _predicted(self) -> Callable[..., tuple[NDArray[Any], ...]]:
        """Predictions that keep the last ones, of which those of other recordings do not change with each trial."""
        return functools.lru_cache(maxsize=2 * len(self.measured) + 2)(self._of_record)

    def __getstate__(self) -> dict[str, Any]:
        """Return what is pickled or copied: all but what is remembered."""
        return {name: each for name, each in vars(self).items() if name != "_predicted"}

    def pieces(self) -> Iterator[tuple[int, int, Observed, slice]]:
        """Number each signal by recording and place there, and give it with its rows in one row of all data."""
        end = 0
        for record, columns in enumerate(self.columns):
            for column, each in enumerate(columns):
                begin, end = end, end + each.size
                yield record, column, each, slice(begin, end)

    @property
    def data(self) -> Real:
        """All data in one row, of complex ones the real parts and then the imaginary parts, shape (n,)."""
        return np.concatenate([_flat(each.y) for column in self.columns for each in column])

    def _unknowns(self, free: Sequence[str], varying: Sequence[str]) -> list[Unknown]:
        sessions = list(dict.fromkeys(each.session for each in self.measured))
        if varying and len(sessions) < 2:
            raise InputError(
                f"{varying[0]}: varies between sessions, but all recordings are of one: name the sessions"
            )
        found = [Unknown(path, path) for path in free if path not in varying]
        found += [Unknown(f"{path} [{name}]", path, name) for path in varying for name in sessions]
        for at, columns in enumerate(self.columns):
            found += [
                Unknown(f"{self.measured[at].name}: zero of {each.signal}", each.signal, "", at, column)
                for column, each in enumerate(columns)
                if each.offset
            ]
        return found

    def _parameter(self, unknown: Unknown, start: Mapping[str, float]) -> FreeParameter:
        if unknown.is_offset:
            return FreeParameter(start=0.0)
        base = self.prepared[0].base
        declared = quantity_at(base, unknown.path)
        given = start.get(unknown.path, value_at(base, unknown.path))
        if given is None:
            raise InputError("has no value to begin with: give it one in the scenario", path=unknown.path)
        begin = float(given)
        if begin == 0 == declared.low:
            raise InputError(
                f"is 0, which gives the search no scale: begin above 0, with start = {{'{unknown.path}': ...}}",
                path=unknown.path,
            )
        decades = declared.high > _DECADES * max(declared.low, begin if declared.low == 0 else declared.low)
        return FreeParameter(
            start=begin,
            lower=declared.low,
            upper=declared.high,
            logarithmic=begin > 0 and declared.low >= 0 and decades,
        )

    def point(self, record: int, values: Mapping[str, float]) -> dict[str, float]:
        """Parameters of the scenario of one recording, by dotted path in SI."""
        session = self.measured[record].session
        return {
            each.path: values[each.name]
            for each in self.unknowns
            if not each.is_offset and each.session in ("", session)
        }

    def __call__(self, values: Mapping[str, float]) -> Real:
        """Predict all data, in the order of `data`."""
        rows = []
        for at in range(len(self.measured)):
            shift = {each.column: values[each.name] for each in self.unknowns if each.record == at}
            rows += [
                _flat(row + shift.get(column, 0.0))
                for column, row in enumerate(self._predicted(at, tuple(self.point(at, values).items())))
            ]
        return np.concatenate(rows)

    def rescale(self, values: Mapping[str, float]) -> float:
        """Take the scale of a noise that is proportional to a signal from its prediction; return the largest relative change.

        A scale from the data would be correlated with their noise, and bias the estimates.
        """

        def rescaled(column: Observed, row: NDArray[Any]) -> Observed:
            scale = np.abs(row)
            return (
                dataclasses.replace(column, scale=scale) if column.relative and (scale > 0).all() else column
            )

        before, found = self.columns, []
        for at, columns in enumerate(before):
            rows = self._predicted(at, tuple(self.point(at, values).items()))
            found.append(tuple(map(rescaled, columns, rows)))
        self.columns = tuple(found)
        pairs = zip(itertools.chain(*found), itertools.chain(*before), strict=True)
        return max(float(np.max(np.abs(new.scale / old.scale - 1))) for new, old in pairs)

    def _of_record(self, at: int, point: tuple[tuple[str, float], ...]) -> tuple[NDArray[Any], ...]:
        """Predict the signals of one recording; not a number where the models refuse the values."""
        prepared, columns = self.prepared[at], self.columns[at]
        found: dict[int, NDArray[Any]] = {}
        for axis in dict.fromkeys(each.axis for each in columns):
            there, stamps, names = along(columns, axis)
            if axis == "time":
                rows: Mapping[str, NDArray[Any]] = prepared.signals(dict(point), names=names, time=stamps)
            else:
                rows = signals_over_frequency(prepared.scenario(dict(point)), stamps, names)
            for number in there:
                each = columns[number]
                row = np.asarray(rows[each.signal])
                found[number] = row if row.size == each.x.size else row[np.searchsorted(stamps, each.x)]
        return tuple(found[number] for number in range(len(columns)))

    def derivatives(self, values: Mapping[str, float], *, names: Sequence[str] | None = None) -> Real:
        """Differentiate all predictions after the unknowns, shape (n, unknowns), in the order of `unknowns`."""
        wanted = [each for each in self.unknowns if names is None or each.name in names]
        key = (tuple(values.items()), tuple(each.name for each in wanted))
        if self._last is not None and self._last[0] == key:
            return self._last[1]
        base = self(values)
        found = np.zeros((base.size, len(wanted)))
        for number, unknown in enumerate(wanted):
            begin = values[unknown.name]
            linear = self.linear_rows(unknown)
            if linear is not None and (unknown.is_offset or begin > 0):
                found[linear, number] = 1.0 if unknown.is_offset else self.alone(values, linear) / begin
                continue
            step = STEP * (abs(begin) or 1.0)
            moved = begin + step if begin + step <= self.free[unknown.name].upper else begin - step
            found[:, number] = (self(dict(values) | {unknown.name: moved}) - base) / (moved - begin)
        self._last = (key, found)
        return found

    def alone(self, values: Mapping[str, float], rows: NDArray[np.bool_]) -> Real:
        """Return the predictions of the data `rows` without unknown zeros."""
        zeros = {each.name: 0.0 for each in self.unknowns if each.is_offset}
        return self(dict(values) | zeros)[rows]

    def linear_rows(self, unknown: Unknown) -> NDArray[np.bool_] | None:
        """Return the data that are linear in an unknown, where all others are independent of it; None if there are none."""
        if unknown.name not in self._linear:
            self._linear[unknown.name] = (
                self._rows(unknown) if unknown.is_offset else self._proportional_rows(unknown)
            )
        return self._linear[unknown.name]

    def _proportional_rows(self, unknown: Unknown) -> NDArray[np.bool_] | None:
        marks = np.zeros(self.data.size, bool)
        for record, _, each, rows in self.pieces():
            concerned = unknown.session in ("", self.measured[record].session)
            scaled = proportional_to_friction(self.prepared[record].base, unknown.path)
            if concerned and not (scaled and each.signal in scaled | INDEPENDENT):
                return None
            marks[rows] = concerned and each.signal in scaled
        return marks

    def _rows(self, unknown: Unknown) -> NDArray[np.bool_]:
        """Mark the real parts of the data of the signal that an offset belongs to."""
        marks = np.zeros(self.data.size, bool)
        for record, column, each, rows in self.pieces():
            if (record, column) == (unknown.record, unknown.column):
                marks[rows.start : rows.start + each.x.size] = True
        return marks


def _flat(values: NDArray[Any]) -> Real:
    return np.concatenate([values.real, values.imag]) if np.iscomplexobj(values) else np.asarray(values)


def along(columns: Sequence[Observed], axis: str) -> tuple[list[int], Real, list[str]]:
    """Return which signals are over one axis, all values of that axis, increasing [s or Hz], and the names of the signals."""
    there = [number for number, each in enumerate(columns) if each.axis == axis]
    stamps = [columns[number].x for number in there]
    same = all(each is stamps[0] or np.array_equal(each, stamps[0]) for each in stamps[1:])
    names = list(dict.fromkeys(columns[number].signal for number in there))
    return there, stamps[0] if same else np.unique(np.concatenate(stamps)), names


def signals_over_frequency(
    scenario: Scenario, frequency: Real, names: Sequence[str]
) -> dict[str, NDArray[Any]]:
    """Predict signals over frequency, exactly, for the materials as declared."""
    variables = over_frequency(scenario, phasors(scenario, frequency))
    absent = [name for name in names if name not in variables or variables[name][0] != ("frequency",)]
    if absent:
        known = ", ".join(name for name, (dims, _) in variables.items() if dims == ("frequency",))
        raise ElectrovibError(
            f"'{absent[0]}' is not predicted over frequency by this scenario. Known: {known}."
        )
    return {name: np.asarray(variables[name][1]) for name in names}


@dataclass(frozen=True, kw_only=True)
class Residuals:
    """What is left of one signal of one recording; `noise` is the standard deviation over the scale of the data."""

    recording: str
    observed: Observed
    predicted: Real | NDArray[np.complex128]
    noise: float

    @property
    def values(self) -> Real | NDArray[np.complex128]:
        """Data less prediction, shape (n,), in the signal's unit."""
        return np.asarray(self.observed.y - self.predicted)

    @property
    def root_mean_square(self) -> float:
        """Of the residuals over the scale of the data, of each part where they are complex."""
        return float(np.sqrt(np.mean(np.abs(self.values / self.observed.scale) ** 2) / self.observed.parts))


def residuals_of(
    prediction: Prediction, values: Mapping[str, float], noise: Sequence[float]
) -> list[Residuals]:
    """Collect the residuals of every signal of every recording."""
    found = prediction(values)
    residuals = []
    for (record, _, each, rows), sigma in zip(prediction.pieces(), noise, strict=True):
        own, name = found[rows], prediction.measured[record].name
        row: Real | NDArray[np.complex128] = own
        if each.parts == 2:
            row = own[: each.x.size] + 1j * own[each.x.size :]
        residuals.append(Residuals(recording=name, observed=each, predicted=row, noise=sigma))
    return residuals
