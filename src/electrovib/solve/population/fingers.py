"""A scenario as a function of values that differ from finger to finger, for many fingers in one call."""

from __future__ import annotations

import functools
from threading import Lock
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import ElectrovibError, InputError, nearest
from electrovib.core.signals import SIGNALS
from electrovib.scenario import Source, read_scenario
from electrovib.solve.choice import refuse_unsolved
from electrovib.solve.electrics.over_frequency import over_frequency
from electrovib.solve.one_by_one import KERNEL as ALONE
from electrovib.solve.one_by_one import ParametricScenario, over_which
from electrovib.solve.population.arrays import (
    OF_LAW,
    DrivenBy,
    asked_of,
    below,
    has_modes,
    of_factors,
    over_time,
    per_unit,
    refuse_beyond_arrays,
    some_of,
)
from electrovib.solve.population.columns import check_values, debye_of, shared_reductions, with_columns
from electrovib.solve.population.drive import SharedDrive, shared_drive
from electrovib.solve.stack.expand import Surroundings, modes_of, phasors
from electrovib.solve.stack.harmonics import refuse_unrepeated
from electrovib.solve.stack.modes import is_there
from electrovib.solve.stack.transfer import NotInArraysError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Indices, Real
    from electrovib.scenario import Scenario
    from electrovib.solve.stack.keys import Key
    from electrovib.solve.stack.transfer import Transfer

TOGETHER: Final = "together: arrays over fingers (linear layers, a fixed gap, friction without memory)"
"""Method that is stated where fingers are computed in arrays."""
KERNEL: Final = f"numpy {np.__version__}"
"""What computes fingers in arrays, with the version on which the last bits of results depend."""
GRIDS: Final = ("time", "frequency")
"""Parts of a scenario that are the same for all fingers."""
STACKS: Final = 1024
"""Fingers whose modes are in memory together."""
RESPONSES: Final = 1 << 19
"""Numbers of the responses in memory together, about."""
FEWEST: Final = 64
"""Smallest number of fingers whose responses are computed together."""
AGREE: Final = 1e-11
"""Largest difference over the peak of a signal; a formula that is no formula of one finger differs by more."""
SCALED: Final = 1e-6
"""The same where a permittivity is scaled: the least squares of the scaled one end elsewhere within their own error, 1e-5."""
_NUDGE: Final = 0.05
_FAINT: Final = 1e-9
"""Share of the largest value that is compared for a parameter whose value is 0."""


class Population:
    """Signals of many fingers, each the scenario with its own values of a few parameters.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        Experiment with the values that all fingers share.
    free : sequence of str
        Dotted paths of the parameters that differ between fingers.
    signals : sequence of str
        Names of the signals, all over time or all over frequency.
    time : array_like, shape (n,), optional
        Output times, increasing, >= 0 [s]; by default those of the scenario's time grid.
    band : ndarray, shape (m,), optional
        Times over whose band materials are reduced to Debye terms [s]; by default the output times.
    compared : bool
        Whether arrays were found to agree with fingers one by one before, at other times.

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
    drive : SharedDrive or None
        The drive of all fingers as a sum; None where each has times or frequencies of its own, and where none is needed.

    Raises
    ------
    InputError
        If a path or a signal does not exist, or a parameter cannot differ between fingers; names all of them.

    Notes
    -----
    The numbers of a finger do not depend on the other fingers in a call, to rounding.
    """

    def __init__(
        self,
        scenario: Source,
        free: Sequence[str],
        signals: Sequence[str] = ("electrostatic_force",),
        time: ArrayLike | None = None,
        *,
        band: Real | None = None,
        compared: bool = False,
    ) -> None:
        self.free = (free,) if isinstance(free, str) else tuple(free)
        self.names = (signals,) if isinstance(signals, str) else tuple(signals)
        self.scenario = scenario = read_scenario(scenario)
        self.prepared, self._band = ParametricScenario(scenario, self.free, self._problems()), band
        refuse_unsolved(scenario)
        self.time: Real | None = None
        self.frequency: Real | None = None
        if over_which(self.names) == "time":
            self.time = scenario.time.times(scenario.drive) if time is None else _checked(time)
        elif time is None:
            self.frequency = scenario.frequency.frequencies()
        else:
            raise InputError("time: signals over frequency have no output times; omit it")
        self._lock = Lock()  # one scenario at a time is prepared for fingers that are solved one by one
        self.method, self.kernel = TOGETHER, KERNEL
        self.drive: SharedDrive | None = None
        try:
            self._prepare()
            if not compared:
                self._compare()
        except NotInArraysError as reason:
            self.method, self.kernel = f"one by one: {reason}", ALONE

    def _problems(self) -> list[str]:
        """Return which signals do not exist, and which parameters cannot differ between fingers."""
        found = [
            f"signals = '{name}': not a signal.{nearest(name, SIGNALS)}"
            for name in self.names
            if name not in SIGNALS or not SIGNALS[name].dims
        ]
        found += [
            f"{path}: the grid is the same for all fingers; choose another parameter"
            for path in self.free
            if path.partition(".")[0] in GRIDS
        ]
        return (
            found if self.free else [*found, "free: name at least one parameter that differs between fingers"]
        )

    @property
    def shares_times(self) -> bool:
        """Whether the drives of all fingers have the same times and frequencies, where signals are over time."""
        return self.method != TOGETHER or self.drive is not None

    def signals(self, draws: Mapping[str, ArrayLike]) -> dict[str, Any]:
        """Compute the signals of fingers."""
        columns, found = self.columns(draws), dict[str, Any]()
        count = len(next(iter(columns.values())))
        for fingers, rows in self.parts(columns):
            for name, each in rows.items():
                if name not in found:
                    found[name] = np.empty((count, *each.shape[1:]), each.dtype)
                found[name][fingers] = each
        return {name: found[name] for name in self.names}

    def parts(self, draws: Mapping[str, ArrayLike]) -> Iterator[tuple[Any, dict[str, Any]]]:
        """Yield the indices and the signals of some fingers after the other; several threads may do so at once."""
        columns = self.columns(draws)
        if self.method != TOGETHER:
            yield slice(None), self._alone(columns)
            return
        check_values(self.scenario, self.prepared.declared, columns)
        for fingers in _of_one_form(columns):
            for begin in range(0, len(fingers), STACKS):
                left = fingers[begin : begin + STACKS]
                _, stacks = self._stacks({path: values[left] for path, values in columns.items()})
                if stacks is not None:  # those with one stack beside each other
                    left = left[np.argsort(stacks, kind="stable")]
                some = {path: values[left] for path, values in columns.items()}
                try:
                    for rows, size in self._in_arrays(some, len(left)):
                        yield _range(left[:size]), rows
                        left = left[size:]
                except NotInArraysError:  # fingers with fewer modes among others
                    with self._lock:
                        rows = self._alone({path: values[left] for path, values in columns.items()})
                    yield _range(left), rows

    def columns(self, draws: Mapping[str, ArrayLike]) -> dict[str, Real]:
        """Return the values of all free parameters for each finger."""
        given = {
            path: np.atleast_1d(np.asarray(values, dtype=float))
            for path, values in self.prepared.by_path(draws).items()
        }
        shapes = {values.shape for values in given.values()}
        if len(shapes) != 1 or any(len(shape) != 1 or not shape[0] for shape in shapes):
            counts = ", ".join(f"{path} has {values.shape}" for path, values in given.items())
            raise InputError(
                f"draws: one value for each finger is needed in every array, and at least one finger; {counts or 'none given'}"
            )
        count = shapes.pop()
        begin = self.prepared.begin
        return {path: given[path] if path in given else np.full(count, begin[path]) for path in self.free}

    def asked(self, member: Scenario) -> dict[Key, Transfer]:
        """Return the linear quantities that the signals need, of a scenario with columns."""
        if not has_modes(member, self.names):
            return {}
        return asked_of(member, modes_of(member, debye_of(member, self._reduced, self.free)), self.names)

    def _alone(self, columns: Mapping[str, Real]) -> dict[str, Any]:
        """Return the signals of fingers, each computed by itself."""
        return self.prepared.of_many(columns, names=self.names, time=self.time, band=self._band)

    def _prepare(self) -> None:
        """Compute what fingers in arrays share; refused where arrays do not cover the scenario or what differs."""
        scenario, free, time = self.scenario, self.free, self.time
        refuse_beyond_arrays(scenario, free, self.names)
        begin = self.prepared.begin
        if absent := [path for path in free if not isinstance(begin[path], float)]:
            raise NotInArraysError(f"{absent[0]} has no value in the scenario")
        of_drive = {path: begin[path] for path in free if path.startswith("drive.")}
        band = time if self._band is None else self._band
        self._largest: Any = scenario.drive.largest() if time is None else 0.0
        if time is not None or of_drive:
            try:
                self.drive = shared_drive(scenario, of_drive)
            except NotInArraysError:  # each finger may have a drive of its own
                if time is None or not scenario.force.causal:
                    raise
        if time is None and self.drive is not None:
            self._largest = _largest_per_parameter(scenario, self.drive, begin)
        self._reduced = {}
        if band is not None and has_modes(scenario, self.names):
            self._reduced = shared_reductions(scenario, free, band)
        if self._reduced and self.drive is None:
            raise NotInArraysError(
                "the band over which materials are reduced follows from the drive of each finger"
            )

    def _in_arrays(self, draws: Mapping[str, Real], count: int) -> Iterator[tuple[dict[str, Any], int]]:
        """Yield the signals of some fingers after the other, and how many these are."""
        columns = {path: np.ascontiguousarray(each, dtype=float)[:, None] for path, each in draws.items()}
        inner = {path: column for path, column in columns.items() if not path.startswith("drive.")}
        first_of, stacks = self._stacks(draws)
        asked = self.asked(
            with_columns(self.scenario, {path: each[first_of] for path, each in inner.items()})
        )
        outputs = self.frequency if self.time is None else self.time
        assert outputs is not None
        parts = self._linear(asked, columns, count, stacks, block=max(FEWEST, RESPONSES // len(outputs)))
        for part, driven, known in parts:
            some = with_columns(self.scenario, {path: each[part] for path, each in inner.items()})
            with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
                found = (
                    self._over_frequency(some, {path: each[part] for path, each in columns.items()})
                    if self.time is None
                    else over_time(some, known, driven, self.time, self.names)
                )
            size = part.stop - part.start
            for name, each in found.items():
                axes = len(SIGNALS[name].dims)
                found[name] = np.broadcast_to(each, (size, *each.shape[each.ndim - axes :]))
            yield found, size

    def _linear(
        self,
        asked: Mapping[Key, Transfer],
        columns: Mapping[str, Real],
        count: int,
        stacks: Indices | None,
        *,
        block: int,
    ) -> Iterator[tuple[slice, list[tuple[slice, DrivenBy]], dict[Key, Real]]]:
        """Yield ranges of fingers, those of a stack beside each other, with their drive and linear quantities."""
        if self.time is None:
            for part in _ranges(0, count, block):
                yield part, [], {}
            return
        settled = self.scenario.time.settled
        if self.drive is None:
            for part in _ranges(0, count, block):
                driven = self._own_drives({path: each[part] for path, each in columns.items()})
                some = some_of(asked, part)
                rows = [
                    per_unit(some_of(some, own), {"": parts}, self.time, settled=settled)
                    for own, ((_, parts),) in driven
                ]
                yield part, driven, {key: below([each[key][0] for each in rows]) for key in asked}
            return
        drives = self.drive
        if any(np.any(each.free) for each in asked.values()):
            drives = {"": ()} | drives  # initial charges respond to no drive
        stacks = np.arange(count) if stacks is None else stacks
        for own in _ranges(0, int(stacks[-1]) + 1, block):
            with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
                unit = per_unit(some_of(asked, own), drives, self.time, settled=settled)
            begin, end = np.searchsorted(stacks, (own.start, own.stop)).tolist()
            for part in _ranges(begin, end, block):
                factors = [columns[path][part] if path else 1.0 for path in drives]
                driven = [(slice(None), list(zip(factors, drives.values(), strict=True)))]
                yield part, driven, of_factors(unit, factors, _range(stacks[part] - own.start))

    def _stacks(self, draws: Mapping[str, Real]) -> tuple[Any, Indices | None]:
        """Return a finger for each stack, as they appear, and the stack of each finger; None where nobody shares one.

        With a factor of the drive it is one for each finger at least, so that the last bits do not depend on the others.
        """
        if self.time is None or self.drive is None:
            return slice(None), None
        outside = ("drive.", "friction.", *(("contact.", "load.") if self._is_per_area else ()))
        others = [values for path, values in draws.items() if not path.startswith(outside)]
        rows = np.stack(others, axis=1) if others else np.zeros((len(next(iter(draws.values()))), 1))
        _, first_of, stacks = np.unique(rows, axis=0, return_index=True, return_inverse=True)
        if len(first_of) == len(rows) and not any(self.drive):
            return slice(None), None
        order = np.argsort(first_of)
        return first_of[order], np.argsort(order)[stacks.reshape(-1)]

    @functools.cached_property
    def _is_per_area(self) -> bool:
        """Whether the signals need linear quantities that are the same for any area: nothing but layers is in series."""
        around = Surroundings.of(self.scenario)
        in_series = (around.second, around.element.elastance, around.element.resistance)
        return (
            OF_LAW.issuperset(self.names)
            and self.scenario.drive.quantity == "voltage"
            and not any(path.startswith("circuit.") for path in self.free)
            and not any(map(is_there, in_series))
        )

    def _own_drives(self, columns: Mapping[str, Real]) -> list[tuple[slice, DrivenBy]]:
        """Return the drive of each finger, which has times or frequencies of its own."""
        found: list[tuple[slice, DrivenBy]] = []
        mine = {path: values[:, 0].tolist() for path, values in columns.items() if path.startswith("drive.")}
        for finger, values in enumerate(zip(*mine.values(), strict=True)):
            with self._lock:
                drive = self.prepared.scenario(dict(zip(mine, values, strict=True))).drive
            if self.scenario.time.settled:
                refuse_unrepeated(drive)
            found.append((slice(finger, finger + 1), [(1.0, drive.parts())]))
        return found

    def _over_frequency(self, member: Scenario, columns: Mapping[str, Real]) -> dict[str, Any]:
        """Return the signals over frequency of some fingers."""
        largest: Any = self._largest
        if not isinstance(largest, float):
            largest = np.abs(columns[largest[0]]) * largest[1]
        assert self.frequency is not None
        exact = phasors(member, self.frequency)
        found = over_frequency(member, exact, amplitude=largest, wanted=frozenset(self.names))
        if missing := [name for name in self.names if name not in found]:
            raise NotInArraysError(f"the scenario has no {missing[0]}")
        return {name: found[name][1] for name in self.names}

    def _compare(self) -> None:
        """Refuse arrays whose fingers differ from the same fingers one by one."""
        draws = self._two()
        try:
            expected = self._alone(draws)
        except ElectrovibError as error:
            raise NotInArraysError(
                f"not all values next to those of the scenario are allowed: {error}"
            ) from None
        try:
            ((found, _),) = self._in_arrays(draws, 2)
        except (TypeError, ValueError, AttributeError, AssertionError) as error:
            raise NotInArraysError(
                f"a formula of the scenario does not run on arrays ({type(error).__name__})"
            ) from None
        is_scaled = any(each.is_scaled for each in self._reduced.values())
        limit = SCALED if is_scaled else AGREE
        for name, rows in expected.items():
            for mine, its in zip(found[name], rows, strict=True):
                if not _agree(mine, its, limit):
                    raise NotInArraysError(f"{name} in arrays differs from that of one finger")

    def _two(self) -> dict[str, Real]:
        """Return the values of the scenario, and values next to them within the ranges."""
        found = {}
        for path, value in self.prepared.begin.items():
            quantity = self.prepared.declared[path]
            step = _NUDGE * abs(value) or _FAINT * max(abs(quantity.low), abs(quantity.high))
            begin = value or step  # a number of 0 may give fewer modes than others
            found[path] = np.array([begin, begin - step if begin + step > quantity.high else begin + step])
        return found


def _largest_per_parameter(
    scenario: Scenario, drive: SharedDrive, begin: Mapping[str, float]
) -> tuple[str, float]:
    """Return the path to which the largest value of the drive [V] is proportional, and the factor."""
    path, *others = drive
    if others or not path:
        raise NotInArraysError("the largest voltage is not proportional to one parameter of the drive")
    if not begin[path]:
        raise NotInArraysError("the largest voltage of the scenario is 0")
    return path, scenario.drive.largest() / abs(begin[path])


def _of_one_form(draws: Mapping[str, Real]) -> list[Any]:
    """Return groups of fingers whose values of 0 are those of the same parameters: these may have fewer modes."""
    zero = np.array([values == 0 for values in draws.values()])
    if not zero.any():
        return [np.arange(zero.shape[1])]
    _, group = np.unique(zero, axis=1, return_inverse=True)
    group = group.reshape(-1)
    return [np.flatnonzero(group == each) for each in range(int(group.max()) + 1)]


def _ranges(begin: int, end: int, size: int) -> list[slice]:
    """Return ranges of at most some indices, one after the other."""
    return [slice(first, min(first + size, end)) for first in range(begin, end, size)]


def _range(fingers: Any) -> Any:
    """Return indices as a range where they are one: it is written faster than a list."""
    first, stop = int(fingers[0]), int(fingers[-1]) + 1
    return slice(first, stop) if np.array_equal(fingers, np.arange(first, stop)) else fingers


def _agree(mine: Any, its: Any, limit: float) -> bool:
    """Return whether the signals of one finger agree, NaN included."""
    unknown = np.isnan(its)
    if mine.shape != its.shape or not np.array_equal(unknown, np.isnan(mine)):
        return False
    peak = float(np.max(np.abs(its[~unknown]), initial=0.0))
    return bool(np.all(np.abs(mine[~unknown] - its[~unknown]) <= limit * peak))


def _checked(time: ArrayLike) -> Real:
    """Return output times as an array; refuse times that are not increasing from 0 or later."""
    times = np.array(time, dtype=float)
    if times.ndim != 1 or not times.size or not (times[0] >= 0 and np.all(np.diff(times) > 0)):
        raise InputError("time: expected increasing output times from 0 s or later, at least one")
    if not np.isfinite(times[-1]):
        raise InputError("time: expected finite output times")
    return times
