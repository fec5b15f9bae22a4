"""The wanted quantity as a function of what is free or drawn, and the free parameter and its range, read from texts."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeAlias

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.budget import BudgetError, allowed, budget
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import LONGEST_QUOTED, ElectrovibError, InputError, gathered, shortened
from electrovib.core.paths import quantity_at, value_at
from electrovib.core.quantity import Quantity
from electrovib.core.units import expected, format_quantity, parse_quantity
from electrovib.scenario import Scenario
from electrovib.solve.effort import last_time
from electrovib.solve.meter import clock
from electrovib.solve.population.fingers import TOGETHER
from electrovib.solve.prepare import Prepared
from electrovib.studies.sweep import felt, read_quantities

WantSource: TypeAlias = "str | Mapping[str, str | float | Sequence[str | float]]"
"""A wanted quantity as text, or its name with its value or its band."""
FreeSource: TypeAlias = "str | Mapping[str, str | Sequence[str | float] | None]"
"""The path of a parameter as text, with its range or without, or the path with the ends of the range."""
_ANY = "final "
"""A statistic with which the name of a signal is read."""
_EXAMPLE = "'mean electrostatic_force = 50 mN'"


@dataclass(frozen=True, kw_only=True)
class Wanted:
    """A quantity with its wanted value, and the parameter that is free, each in its SI unit.

    Of the quantity are `name`, `unit`, `value`, its largest value `upper` where a band is wanted, and `at`, the time of a
    signal that is wanted at one time; of the parameter its value `begin` in the scenario and the range.
    """

    name: str
    unit: str
    value: float
    upper: float
    is_felt: bool
    at: float | None
    free: str
    declared: Quantity
    begin: float
    low: float
    high: float

    @property
    def signal(self) -> tuple[str, str]:
        """Signal and layer of a quantity at one time; the layer is empty where the signal has none."""
        signal, _, layer = self.name.partition(" at ")[0].partition(" in ")
        return signal, layer

    def quantity(self, value: float) -> str:
        """Write a value of the quantity."""
        return format_quantity(value, self.unit) if self.unit != "dB" else f"{value:.6g} dB"

    def amplitude(self, value: float | Real) -> Any:
        """Return what is proportional to a force: a value of the quantity, or the amplitude that a level [dB] stands for."""
        return 10.0 ** (value / 20) if self.unit == "dB" else value

    def with_force(self, value: float, factor: float) -> float:
        """Return the value that is needed of the law where the force is so many times as large as the law gives."""
        return value - 20 * math.log10(factor) if self.unit == "dB" else value / factor

    def parameter(self, value: float) -> str:
        """Write a value of the free parameter."""
        return format_quantity(value, self.declared.unit)

    def free_numbers(self) -> dict[str, Any]:
        """Return the free parameter and its range as a table."""
        return {
            "path": self.free,
            "unit": self.declared.unit,
            "in_the_scenario": self.begin,
            "low": self.low,
            "high": self.high,
        }


def read_wanted(scenario: Scenario, *, want: WantSource, free: FreeSource, banded: bool = False) -> Wanted:
    """Read what is wanted of which parameter, and report every mistake at once.

    The quantity is one of a sweep, or a signal at one time: ``"electrostatic_force at 20 ms = 1 mN"``. If `banded`, at least
    the value is wanted, or a band: ``"mean electrostatic_force = 20 mN:60 mN"``.
    """
    problems: list[str] = []
    name, unit, ends, is_felt, at = "", "1", (math.nan, math.inf), False, None
    with gathered(problems):
        name, value = _parted(want, banded=banded)
        statistic, at = _timed(scenario, name)
        asked = read_quantities(scenario, [statistic])
        (statistic, (unit, _)), is_felt = next(iter(asked.units.items())), bool(asked.felt)
        name = statistic if at is None else f"{statistic.removeprefix(_ANY)} at {format_quantity(at, 's')}"
        ends = _band(value, unit, f"want: {name}", banded=banded)
    path, declared, begin, searched = "", None, math.nan, (math.nan, math.nan)
    with gathered(problems):
        path, between = _free(free)
        declared, begin = _parameter(scenario, path)
        searched = (declared.low, declared.high) if between is None else _ends(between, path, declared)
    if problems or declared is None:
        raise InputError(problems)
    return Wanted(
        name=name,
        unit=unit,
        value=ends[0],
        upper=ends[1],
        is_felt=is_felt,
        at=at,
        free=path,
        declared=declared,
        begin=begin,
        low=searched[0],
        high=searched[1],
    )


def _numbers(source: Any, unit: str, path: str) -> list[float]:
    """Read a number, or several of a text ``LOW:HIGH`` or a sequence, in SI."""
    several = list(source) if isinstance(source, Sequence) else [source]
    parts = [each.strip() for each in source.split(":")] if isinstance(source, str) else several
    return [read_number(each, unit, path) for each in parts]


def _band(value: Any, unit: str, path: str, *, banded: bool) -> tuple[float, float]:
    """Return the smallest and the largest wanted value; of a single value the largest is infinite."""
    found = _numbers(value, unit, path) if banded else [read_number(value, unit, path)]
    if len(found) == 1:
        return found[0], math.inf
    if len(found) != 2 or not found[0] < found[1]:
        why = "expected LOW:HIGH, for instance '20 mN:60 mN'"
        raise InputError(why, path=path, value=shortened(str(value), LONGEST_QUOTED))
    return found[0], found[1]


def _parted(want: WantSource, *, banded: bool) -> tuple[str, Any]:
    """Return name and value of what is wanted."""
    why = f"expected one quantity and its value, for instance {_EXAMPLE}"
    name, value = _pair(want.replace(">=", "=") if banded and isinstance(want, str) else want, "want", why)
    if not name or value in (None, "") or (isinstance(want, str) and "=" in value):
        raise InputError(why, path="want", value=_quoted(want))
    return name, value


def _pair(source: Any, option: str, why: str) -> tuple[str, Any]:
    """Return a name and what belongs to it, of a text ``name = value``, or of a table with one entry; None where nothing does."""
    if isinstance(source, str):
        name, sign, value = (part.strip() for part in source.partition("="))
        return " ".join(name.split()), value if sign else None
    if isinstance(source, Mapping) and len(source) == 1 and all(isinstance(name, str) for name in source):
        return next(iter(source.items()))
    raise InputError(why, path=option, value=_quoted(source))


def _quoted(source: Any) -> str:
    return shortened(source if isinstance(source, str) else repr(source), LONGEST_QUOTED)


def _timed(scenario: Scenario, name: str) -> tuple[str, float | None]:
    """Return a statistic of the signal that is meant, and the time at which it is wanted; None without a time."""
    signal, at, text = name.partition(" at ")
    if not at:
        return name, None
    try:
        time, last = parse_quantity(text, "s"), last_time(scenario)
    except ValueError:
        why = (
            "expected a time, for instance '20 ms'; at a frequency, set drive.frequency of a sine and name a statistic,"
            " for instance 'mean electrostatic_force'"
        )
        raise InputError(why, path=f"want: {signal} at", value=shortened(text, LONGEST_QUOTED)) from None
    if not 0 <= time <= last:
        why = f"expected a time from 0 s to the end of the run, {format_quantity(last, 's')}; time.duration sets it"
        raise InputError(why, path=f"want: {signal} at", value=text)
    return f"{_ANY}{signal}", time


def read_number(value: Any, unit: str, path: str) -> float:
    """Read a finite number in SI, a text with its unit, or a level in dB."""
    why, number = "", math.nan
    try:
        if unit == "dB":
            number = float(str(value).strip().removesuffix("dB"))
        else:
            number = parse_quantity(value, unit) if isinstance(value, str) else float(value)
    except (TypeError, ValueError) as error:
        why = str(error) if isinstance(value, str) else ""
    if isinstance(value, bool) or not math.isfinite(number):
        why = "expected a level in dB, for instance '6 dB'" if unit == "dB" else why or expected(unit)
        raise InputError(why, path=path, value=_quoted(value))
    return number


def _free(source: FreeSource) -> tuple[str, str | Sequence[str | float] | None]:
    """Return the path of the free parameter, and the range in which it is sought; None for its own."""
    why = "expected the dotted path of one parameter, for instance 'drive.amplitude', or 'drive.amplitude=10V:400V'"
    path, between = _pair(source, "free", why)
    if not isinstance(between, str | Sequence | None):
        raise InputError(why, path="free", value=_quoted(source))
    return path, between


def _parameter(scenario: Scenario, free: str) -> tuple[Quantity, float]:
    declared = quantity_at(scenario, free)
    if free.startswith("frequency."):
        why = "the frequencies of the output are no input of a quantity; choose another parameter, for instance drive.frequency"
        raise InputError(why, path=free)
    begin = value_at(scenario, free)
    if begin is None:
        raise InputError(
            f"the scenario gives it no value; add one by --set {free}=VALUE, {declared.range(' to ')}",
            path=free,
        )
    return declared, float(begin)


def _ends(between: str | Sequence[str | float], free: str, declared: Quantity) -> tuple[float, float]:
    """Return the ends of a given range within the declared one."""
    ends = _numbers(between, declared.unit, free)
    why = "expected two values, the smaller first"
    if len(ends) != 2:
        low, high = (format_quantity(each, declared.unit) for each in (declared.low, declared.high))
        why = f"expected PATH=LOW:HIGH, for instance {free}={low}:{high}"
    elif declared.low <= ends[0] < ends[1] <= declared.high:
        return ends[0], ends[1]
    allowed = f"{why}; {free} allows {declared.range(' to ')}"
    raise InputError(allowed, path="free", value=f"{free}={_quoted(between)}")


_LEAST: Final = 5.0
"""Computing time that every evaluation may take [s]."""
_MORE: Final = 5.0
"""Computing time that an evaluation may take, over that of the scenario as it is."""


class Evaluation:
    """The wanted quantity as a function of the parameters at the dotted paths `free`; all others keep their values."""

    def __init__(self, scenario: Scenario, wanted: Wanted, free: tuple[str, ...]) -> None:
        self.wanted = wanted
        signal, layer = wanted.signal
        name = wanted.name if wanted.at is None else f"peak {signal}" + (f" in {layer}" if layer else "")
        self.prepared = Prepared(scenario, free=free, quantity=[] if wanted.is_felt else [name])

    @functools.cached_property
    def most(self) -> float:
        """Computing time that an evaluation may take [s]; of the scenario as it is one is made, which may take the budget."""
        began = clock()
        try:
            self._at({path: value for path, value in self.prepared.begin.items() if value is not None})
        except BudgetError:
            raise
        except ElectrovibError:  # each evaluation states why it cannot be made
            pass
        return min(allowed().time, max(_LEAST, _MORE * (clock() - began)))

    def __call__(self, values: Mapping[str, float]) -> float:
        """Compute the quantity for values in SI by path; NaN where it is not known."""
        most = self.most
        try:
            with budget(time=most):
                return self._at({path: float(value) for path, value in values.items()})
        except BudgetError as error:  # of this evaluation, not of the design
            raise InputError(error.problems) from None

    def of_many(
        self, draws: Mapping[str, Real], *, progress: Callable[[int, int], None] | None = None
    ) -> Real | None:
        """Compute the quantity of many points in arrays; None without arrays, or where one is refused or not known."""
        if self.wanted.is_felt or self.wanted.at is not None or self.prepared.method != TOGETHER:
            return None
        try:
            found: Real = self.prepared(draws, progress=progress)[self.wanted.name]
        except BudgetError:
            raise
        except ElectrovibError:
            return None
        return None if np.isnan(found).any() else found

    def _at(self, point: dict[str, float]) -> float:
        wanted, prepared = self.wanted, self.prepared
        if wanted.is_felt:
            return felt(wanted.name, prepared.scenario(point))[0]
        if wanted.at is None:
            return float(prepared(point)[wanted.name])
        signal, layer = wanted.signal
        values = prepared.signals(point, names=[signal], time=[wanted.at])[signal]
        return float(values[list(prepared.base.stack.layers).index(layer)][0] if layer else values[0])

    def scenario(self, values: Mapping[str, float]) -> Scenario:
        """Return the scenario with these values."""
        return self.prepared.scenario(values)

    def warnings(self, values: Mapping[str, float]) -> list[Diagnostic]:
        """Return the diagnostics of the quantity with these values that are not ``ok``, breakdown and limits included."""
        if self.wanted.is_felt:
            found = felt(self.wanted.name, self.scenario(values))[1]
        else:
            found = list(self.prepared.judged(values).diagnostics)
        return [each for each in found if each.state != "ok"]
