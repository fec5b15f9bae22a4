"""A scenario as a function of a few of its parameters, solved for one set of values after the other."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError, gathered, refuse
from electrovib.core.model import Model
from electrovib.core.paths import quantity_at, value_at, with_numbers
from electrovib.core.signals import SIGNALS, without
from electrovib.core.tables import is_stored_as_given, stored_changes
from electrovib.solve.electrics.over_frequency import capacitance, over_frequency
from electrovib.solve.expanded import Expanded
from electrovib.solve.stack.expand import phasors

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Real
    from electrovib.core.quantity import Quantity
    from electrovib.scenario import Scenario


KERNEL: Final = "one scenario at a time"
"""Kernel that is stated where no kernel over fingers is used."""
_MECHANICAL: Final = frozenset({"friction", "finger", "rig"})
"""Parts of a scenario on which no electrical quantity depends."""
_KEPT: Final = 3
"""Number of electrical responses that are kept: a search returns to the point at which it computed derivatives."""


class ParametricScenario:
    """A scenario as a function of the parameters at the dotted paths `free`, for one set of values after the other.

    Parts of the scenario without a changed value stay the same objects, and results that depend on them alone are kept.
    Mistakes in the paths are reported together with other `problems`.
    """

    def __init__(self, scenario: Scenario, free: Sequence[str], problems: Sequence[str] = ()) -> None:
        found: list[str] = []
        self.free = tuple(free)
        self.declared: dict[str, Quantity] = {}
        for path in self.free:
            with gathered(found):
                self.declared[path] = quantity_at(scenario, path)
        found += [
            f"free: '{path}' is named twice" for path in {p for p in self.free if self.free.count(p) > 1}
        ]
        refuse([*found, *problems])
        begin = {path: value_at(scenario, path) for path in self.free}
        self._plain = {path for path in self.free if is_stored_as_given(scenario, path, Model)}
        self.base = scenario if len(self._plain) == len(self.free) else scenario.replace(begin)
        self.begin = begin
        self._recent = self.base
        self._made: Expanded | None = None
        self._kept: OrderedDict[tuple[float, ...], Expanded] = OrderedDict()

    def scenario(self, values: Mapping[str, float] | Sequence[float]) -> Scenario:
        """Return the scenario for given values of the free parameters."""
        point = self._by_stored_path(self.begin | self.by_path(values))
        last = self._recent
        changed = {path: value for path, value in point.items() if value_of(last, path) != value}
        if changed:
            self._recent = with_numbers(last, changed)
        return self._recent

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
        times = member.time.times(member.drive) if time is None else np.asarray(time, dtype=float)
        found: dict[str, tuple[Any, Any]] = {}
        if "capacitance" in names:
            found |= capacitance(member, times)
        if others := {*names} - {"capacitance"}:
            expanded = self._expanded(member, self.by_path(values), times if band is None else band)
            found |= expanded.at(times, wanted=others).signals
        if missing := [name for name in names if name not in found]:
            raise InputError(without(missing[0], expanded.at(times).signals if others else found))
        return {"time": times} | {name: np.asarray(found[name][1]) for name in names}

    def of_many(
        self, draws: Mapping[str, Real], *, names: Sequence[str], time: Real | None, band: Real | None = None
    ) -> dict[str, Any]:
        """Compute signals for many values of the free parameters (cases,), one after the other, over frequency without times."""
        columns, rows = {path: values.tolist() for path, values in draws.items()}, []
        for case, values in enumerate(zip(*columns.values(), strict=True)):
            point = dict(zip(columns, values, strict=True))
            try:
                if time is None:
                    member = self.scenario(point)
                    found = over_frequency(member, phasors(member, member.frequency.frequencies()))
                    rows.append({name: found[name][1] for name in names})
                else:
                    rows.append(self.signals(point, names=names, time=time, band=band))
            except InputError as error:
                raise of_finger(error, case, point) from error
        return {name: np.stack([row[name] for row in rows]) for name in names}

    def _expanded(self, member: Scenario, values: dict[str, float], band: Real) -> Expanded:
        """Return the modes of a scenario, with the response of the stack that was kept for the same electrical values."""
        if self._made is not None and not np.array_equal(self._made.times, band):
            self._kept.clear()
        point = self.begin | values
        key = tuple(point[path] for path in self.free if path.split(".")[0] not in _MECHANICAL)
        found = self._kept.pop(key, None)
        if found is None:
            found = Expanded(member, band, before=self._made)
        elif found.scenario is not member:
            found = found.before(member)
        self._kept[key] = self._made = found
        if len(self._kept) > _KEPT:
            self._kept.popitem(last=False)
        return found

    def _by_stored_path(self, point: Mapping[str, float]) -> dict[str, float]:
        """Return values by the paths of the parameters that the models store."""
        others = {path: value for path, value in point.items() if path not in self._plain}
        changes, problems = stored_changes(self.base, others)
        refuse(problems)
        return changes | {path: point[path] for path in self.free if path in self._plain}

    def by_path(self, values: Mapping[str, Any] | Any) -> dict[str, Any]:
        """Return values by path; a sequence has one for each free parameter, in their order."""
        if isinstance(values, Mapping):
            if foreign := [path for path in values if path not in self.free]:
                listed = ", ".join(self.free)
                raise InputError(f"{foreign[0]}: not a free parameter; the free parameters are {listed}")
            return dict(values)
        given = list(values)
        if len(given) != len(self.free):
            raise InputError(
                f"values: {len(given)} given, {len(self.free)} expected, one for each of {', '.join(self.free)}"
            )
        return dict(zip(self.free, given, strict=True))


def of_finger(error: InputError, finger: int, point: Mapping[str, float]) -> InputError:
    """Return the error of one finger, with its index and its values."""
    listed = ", ".join(f"{path} = {value:.6g}" for path, value in point.items())
    return InputError(f"{problem} (finger {finger} of the call: {listed})" for problem in error.problems)


def over_which(names: Sequence[str]) -> str:
    """Return whether signals are over time or over frequency."""
    axes = {SIGNALS[name].dims[-1] for name in names}
    if len(axes) != 1:
        what = "signals over time and signals over frequency" if axes else "no signal"
        raise InputError(f"signals = {', '.join(names)}: {what}; ask for one kind in a call")
    return axes.pop()


def value_of(model: Any, path: str) -> Any:
    """Return what a model has at a dotted path of stored parameters."""
    for key in path.split("."):
        model = model[int(key)] if isinstance(model, tuple) else getattr(model, key)
    return model
