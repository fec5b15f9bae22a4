"""Sweeps: what is asked for is read, every case solved on its own, and all of them put into one Dataset."""

from __future__ import annotations

import functools
import itertools
import json
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.budget import BudgetError
from electrovib.core.diagnostics import STATES, Diagnostic
from electrovib.core.errors import ElectrovibError, InputError, Problem, gathered, refuse
from electrovib.core.mistakes import shown
from electrovib.core.paths import quantity_at, with_numbers
from electrovib.core.signals import FORMAT, stamp
from electrovib.core.tables import stored_changes
from electrovib.core.units import expected, format_quantity, number_in
from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.solve.diagnostics.assumptions import sampling
from electrovib.solve.effort import counted
from electrovib.solve.meter import Meter, measured
from electrovib.solve.quantities.cases import answers
from electrovib.solve.quantities.names import DEFAULTS, Named, read_name
from electrovib.solve.quantities.resolve import window
from electrovib.solve.simulate import provenance, simulate
from electrovib.studies.perceive import perceive
from electrovib.studies.widths import HIGHEST_LEVEL, LEVEL, LOWEST_LEVEL

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    import xarray

    from electrovib.solve.quantities.answer import QuantityNumbers


CASE_NUMBERS: Final = 5000
"""Numbers that a case takes at least, its scenario included."""
MOST_PROBLEMS: Final = 10
"""Largest number of reported problems of cases that cannot be made."""


def sweep(
    scenario: Source,
    over: Sequence[str] | Mapping[str, Sequence[float] | Real],
    *,
    quantity: Sequence[str] | None = None,
    records: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> xarray.Dataset:
    """Solve a scenario at every combination of the values of some parameters, and return numbers for each case.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        Scenario of all cases, as for `electrovib.load`.
    over : sequence of str, or mapping of str to sequence of float
        ``"path=from:to:n"``, ``"path=from:to:nlog"``, or dotted path to values, in SI or such as ``"100 V"``; several paths
        give every combination, none the scenario itself.
    quantity : sequence of str, optional
        ``peak``, ``maximum``, ``minimum``, ``swing``, ``mean``, ``rms`` or ``final`` of a signal, as in ``"peak field in
        gap"``; or ``"detection level"``, with ``"lowest"`` or ``"highest"`` for the spread of thresholds. By default peak
        and mean of the attraction, swing of the friction, peak of the current.
    records : bool
        Keep the Trace of each case too.
    progress : callable, optional
        Function of the number of cases that are solved and of all cases.

    Returns
    -------
    table : xarray.Dataset
        A dimension, named by its path, for each parameter, and a variable for each quantity. With `records` the signals
        over time run along ``sample`` too: each case has its own times, in ``time``, and NaN after its end. A quantity is
        taken over one period of a periodic state, else over the whole time, whatever the output times; its attribute
        ``numerical_error`` is relative to the largest value of the signal.

    Raises
    ------
    InputError
        For every value out of range and every unknown quantity; for a case that cannot be solved, with its values.
    BudgetError
        If all would take more than `electrovib.budget` allows: at once where it can be counted, else after the first cases.

    Examples
    --------
    >>> found = ev.sweep("bau_2010/sine", {"drive.amplitude": ["40 V", "80 V"]})
    >>> found["mean electrostatic_force"].values.round(4)
    array([0.031 , 0.1239])
    """
    return _dataset(sweep_cases(scenario, over, quantity=quantity, records=records, progress=progress))


@dataclass(frozen=True)
class Cases:
    """Cases of a sweep, of which the last path of `axes` runs fastest, each with its own diagnostics."""

    scenario: Scenario
    axes: dict[str, Real]
    asked: Asked
    cases: list[Case]
    records: bool


@measured()
def sweep_cases(
    scenario: Source,
    over: Sequence[str] | Mapping[str, Sequence[float] | Real],
    *,
    quantity: Sequence[str] | None = None,
    records: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> Cases:
    """Solve the cases of `sweep`, and return each with its diagnostics."""
    scenario = read_scenario(scenario)
    axes, asked = _checked(scenario, over, DEFAULTS if quantity is None else quantity, records=records)
    report = _metered(scenario, axes, records=records).reporting(progress)
    points = [
        {path: float(value) for path, value in zip(axes, values, strict=True)}
        for values in itertools.product(*axes.values())
    ]
    cases, members = [], _scenarios(scenario, points)
    found = answers(members, asked.solved)
    for done, (point, member) in enumerate(zip(points, members, strict=True)):
        report(done, len(points))
        try:
            cases.append(_solved(point, member, next(found), asked, records=records))
        except ElectrovibError as error:
            where = f" (at {point_words(scenario, point)})" if point else ""
            kind = BudgetError if isinstance(error, BudgetError) else InputError
            raise kind(problem.followed_by(where) for problem in error.problems) from None
    return Cases(scenario, axes, asked, cases, records)


def _metered(scenario: Scenario, axes: Mapping[str, Real], *, records: bool) -> Meter:
    """Return the meter of the cases; more than the memory holds are refused before the first is solved."""
    count = math.prod(len(values) for values in axes.values())
    numbers = CASE_NUMBERS + (max(work.memory for work in counted(scenario)) / 8 if records else 0.0)
    every = " x ".join(f"{len(values)} values of {path}" for path, values in axes.items())
    of = f"{count:.3g} cases, {every}"
    return Meter.of_cases("this sweep", of, count, numbers=numbers, remedy="sweep fewer values")


def _checked(
    scenario: Scenario, over: Sequence[str] | Mapping[str, Any], names: Sequence[str], *, records: bool
) -> tuple[dict[str, Real], Asked]:
    """Read values and names before any case is solved, and report all mistakes at once."""
    axes, asked, problems = dict[str, Real](), Asked((), (), {}), list[str]()
    with gathered(problems):
        asked = read_quantities(scenario, names)
    with gathered(problems):
        axes = parse_over(scenario, over)
    shared = "with records, all cases share the grid of frequencies"
    problems += [f"over '{path}': {shared}" for path in over if records and path.startswith("frequency.")]
    refuse(problems)
    return axes, asked


def _numbers(scenario: Scenario, over: Mapping[str, Any]) -> dict[str, Real]:
    """Return the values of each swept parameter in SI; texts are read with their units."""
    found, problems = dict[str, Real](), list[str]()
    for path, values in over.items():
        unit, numbers = "1", list[float]()
        with gathered(problems):
            unit = quantity_at(scenario, path).unit
        if np.ndim(values) != 1 or not len(values):
            problems.append(f"over '{path}': {_VALUES}")
            continue
        for value in values:
            try:
                numbers.append(number_in(unit, path, value))
            except InputError:
                problems.append(Problem(expected(unit), path=path, value=shown(value)))
        found[path] = np.asarray(numbers)
    if problems:
        raise InputError(problems[:MOST_PROBLEMS])
    return found


def _scenarios(scenario: Scenario, points: Sequence[Mapping[str, float]]) -> list[Scenario]:
    """Make every case before the first is solved, so that a value out of range is refused at once."""
    try:
        return _sharing(scenario, points)
    except InputError:
        problems = list[str]()
        for point in points:
            with gathered(problems):
                scenario.replace(point)
        several = list(dict.fromkeys(problems))
        first, more = several[:MOST_PROBLEMS], len(several) - MOST_PROBLEMS
        raise InputError(first + [f"and {more} more like these"] * (more > 0)) from None


def _sharing(scenario: Scenario, points: Sequence[Mapping[str, float]]) -> list[Scenario]:
    """Make every case; those that differ in their drive alone share all other parts."""
    if not points[0]:
        return [scenario]
    points = [_stored(scenario, point) for point in points]
    base, found = scenario.replace(points[0]), []
    if base.moisture is not None:  # which sets parameters itself
        return [scenario.replace(point) for point in points]
    others: dict[tuple[float, ...], Scenario] = {}
    for point in points:
        of_drive = {path: value for path, value in point.items() if path.startswith("drive.")}
        rest = {path: value for path, value in point.items() if path not in of_drive}
        key = tuple(rest.values())
        if key not in others:
            others[key] = with_numbers(base, rest) if rest else base
        found.append(with_numbers(others[key], of_drive) if of_drive else others[key])
    return found


def _stored(scenario: Scenario, point: Mapping[str, float]) -> dict[str, float]:
    """Return the values of a case by the parameters that the scenario stores, not those of another case."""
    found, problems = stored_changes(scenario, point)
    refuse(problems)
    return found


def _solved(
    point: Mapping[str, float], member: Scenario, found: QuantityNumbers, asked: Asked, *, records: bool
) -> Case:
    values, diagnostics = dict(found.values), list(found.diagnostics)
    for name in asked.felt:
        values[name], spoken = felt(name, member)
        diagnostics += spoken
    record = None
    if records:
        record = simulate(member)
        diagnostics += sampling(member.drive, record["time"].values)
    return Case(
        at=point, values=values, errors=found.errors, how=found.how, diagnostics=diagnostics, record=record
    )


def point_words(scenario: Scenario, point: Mapping[str, float]) -> str:
    """Write the values of a case."""
    shown = (
        f"{path} = {format_quantity(value, quantity_at(scenario, path).unit, digits=4)}"
        for path, value in point.items()
    )
    return ", ".join(shown)


_RANGE = re.compile(r"([^=]+)=(.+):(.+):(\d+)(log)?")
_VALUES = (
    "expected a sequence of at least one number in SI units, for instance numpy.geomspace(1e-6, 1e-4, 10)"
)
_FORM = "expected PATH=FROM:TO:N or PATH=FROM:TO:Nlog, for instance drive.rise=1ms:100ms:30log"


def parse_over(scenario: Scenario, over: Sequence[str] | Mapping[str, Any]) -> dict[str, Real]:
    """Read ``path=from:to:n``, ``path=from:to:nlog`` (even in the logarithm), or values by path, as values in SI by path."""
    if isinstance(over, Mapping):
        return _numbers(scenario, over)
    found: dict[str, Real] = {}
    problems: list[str] = []
    for text in over:
        with gathered(problems):
            path, values = _parse_one(scenario, text)
            if path in found:
                problems.append(f"--over {text}: '{path}' is swept twice")
            found[path] = values
    refuse(problems)
    return found


def _parse_one(scenario: Scenario, text: str) -> tuple[str, Real]:
    match = _RANGE.fullmatch(text.strip())
    if match is None:
        raise InputError(f"--over {text}: {_FORM}")
    path, count = match[1].strip(), int(match[4])
    quantity = quantity_at(scenario, path)
    if path.startswith("frequency."):
        raise InputError(f"--over {path}: all cases share the grid of frequencies; use --set")
    if not 2 <= count <= 10**5:
        raise InputError(f"--over {text}: n must be a whole number from 2 to 100000")
    ends = [number_in(quantity.unit, f"--over {path}", end) for end in (match[2], match[3])]
    if match[5] and min(ends) <= 0:
        raise InputError(f"--over {text}: a logarithmic range needs both ends above 0")
    spacing = np.geomspace if match[5] else np.linspace
    return path, spacing(ends[0], ends[1], count)


@dataclass(frozen=True)
class Asked:
    """Quantities of the solution and of perception, and unit and meaning of each in the given order."""

    solved: tuple[Named, ...]
    felt: tuple[str, ...]
    units: dict[str, tuple[str, str]]


def read_quantities(scenario: Scenario, names: Sequence[str]) -> Asked:
    """Read the names of quantities."""
    solved: list[Named] = []
    units: dict[str, tuple[str, str]] = {}
    problems: list[str] = []
    layers = tuple(scenario.stack.layers)
    for text in [names] if isinstance(names, str) else names:
        plain = " ".join(text.split())
        if plain in FELT:
            units[plain] = FELT[plain]
            continue
        with gathered(problems):
            named = read_name(plain, layers, others=FELT)
            units[named.name] = named.unit, named.meaning
            solved.append(named)
    refuse(problems)
    return Asked(tuple(dict.fromkeys(solved)), tuple(each for each in units if each in FELT), units)


FELT: Final = {
    LEVEL: ("dB", "level of the most excited channel above its threshold"),
    LOWEST_LEVEL: ("dB", "lowest level that the spread of thresholds and skins allows"),
    HIGHEST_LEVEL: ("dB", "highest level that the spread of thresholds and skins allows"),
    "relative level": ("dB", "level relative to a sine of equal force at the best frequency"),
}
"""Unit and meaning of each quantity, by name."""


def felt(name: str, scenario: Scenario) -> tuple[float, list[Diagnostic]]:
    """Compute a quantity of perception [dB]: minus infinity where nothing moves, NaN where no threshold is known."""
    found = perceive(scenario)
    if name == "relative level":
        return found.relative, []
    if not found.loudest:
        return -math.inf, []
    sign = {LOWEST_LEVEL: -1, HIGHEST_LEVEL: 1}.get(name, 0)
    value = math.nan if found.sensation is None else found.sensation + sign * (found.uncertainty or 0.0)
    text = f"{found.headline}; {found.to_measure}" if found.to_measure else ""
    return value, [Diagnostic(LEVEL, "unknown", text)] if text else []


LARGEST: Final = (
    "reduction_error",
    "transfer_error",
    "attraction_error",
    "step_error",
    "quadrature_error",
    "mechanics_error",
    "energy_residual",
    "events",
    "friction_events",
)
"""Attributes of which a sweep keeps the largest."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """One case of a sweep.

    `errors` are relative to the largest value of each signal; `how` states solver, reason, errors and events.
    """

    at: Mapping[str, float]
    values: Mapping[str, float]
    errors: Mapping[str, float]
    how: Mapping[str, Any]
    diagnostics: Sequence[Diagnostic]
    record: xarray.Dataset | None = None


def _dataset(found: Cases) -> xarray.Dataset:
    """Assemble the cases of a sweep, as `electrovib.sweep` returns them."""
    import xarray

    cases, axes = found.cases, found.axes
    shape = tuple(len(values) for values in axes.values())
    variables: dict[str, Any] = {}
    for name, (unit, meaning) in found.asked.units.items():
        about: dict[str, Any] = {"units": unit, "long_name": meaning}
        missed = [case.errors[name] for case in cases if name in case.errors]
        if missed:
            about["numerical_error"] = float(np.max(missed))
        values = np.array([case.values[name] for case in cases]).reshape(shape)
        variables[name] = (tuple(axes), values, about)
    for path, along in axes.items():
        quantity = quantity_at(found.scenario, path)
        variables[path] = (path, along, {"units": quantity.unit, "long_name": quantity.doc})
    if found.records:
        variables |= _records([case.record for case in cases if case.record is not None], tuple(axes), shape)
    whole = xarray.Dataset(variables, attrs=_attributes(found))
    return stamp(whole.set_coords(["time"]) if found.records else whole)


def _attributes(found: Cases) -> dict[str, Any]:
    """Return the swept parameters, the methods and the validity as attributes."""
    cases, words = found.cases, functools.partial(point_words, found.scenario)
    checks = over_all([(case.at, case.diagnostics) for case in cases], words=words)
    about = {"format": FORMAT} | provenance(found.scenario)
    about |= {
        "over": json.dumps({path: values.tolist() for path, values in found.axes.items()}),
        "quantities": json.dumps(list(found.asked.units)),
        "taken_over": window(found.scenario)[1],
        "records": int(found.records),
        "validity": json.dumps(checks),
    }
    for name in ("solver", "solver_reason"):
        about[name] = "; ".join(dict.fromkeys(str(case.how[name]) for case in cases))
    for name in LARGEST:
        values = [case.how[name] for case in cases if name in case.how]
        if values:
            about[name] = max(values)
    return about


def _records(
    traces: Sequence[xarray.Dataset], paths: tuple[str, ...], shape: tuple[int, ...]
) -> dict[str, Any]:
    """Stack records along ``sample``, each with its own times and NaN after its end."""
    longest, first = max(trace.sizes["time"] for trace in traces), traces[0]

    def stacked(name: str) -> tuple[Any, Real]:
        rows = [trace[name].variable.to_base_variable() for trace in traces]
        if "time" in rows[0].dims:
            rows = [row.pad(time=(0, longest - row.sizes["time"])) for row in rows]
        dims = ("sample" if dim == "time" else dim for dim in rows[0].dims)
        return (*paths, *dims), np.stack([row.values for row in rows]).reshape(shape + rows[0].shape)

    shared = {name: (name, first[name].values) for name in ("frequency", "layer") if name in first.coords}
    return {str(name): stacked(str(name)) for name in (*first.data_vars, "time")} | shared


SAME: Final = 1e-9
"""Relative difference up to which two values count as equal: rounding."""
Judged: TypeAlias = "tuple[Mapping[str, float], Sequence[Diagnostic]]"
"""Values of the swept parameters of a case, and its diagnostics."""


def over_all(cases: Sequence[Judged], *, words: Callable[[Mapping[str, float]], str]) -> list[dict[str, Any]]:
    """Keep of each diagnostic the case with the largest value relative to the limit.

    Each has ``at``, the parameters of that case, and ``cases``, the number in its state; diagnostics of one
    name are identified by their order, and one that was judged in some cases only has two entries.
    """
    found: dict[tuple[str, int], list[tuple[Mapping[str, float], Diagnostic]]] = {}
    for at, diagnostics in cases:
        seen: dict[str, int] = {}
        for diagnostic in diagnostics:
            place = seen[diagnostic.name] = seen.get(diagnostic.name, -1) + 1
            found.setdefault((diagnostic.name, place), []).append((at, diagnostic))
    return [one for group in found.values() for one in _of_one_check(group, len(cases), words)]


def _of_one_check(
    group: Sequence[tuple[Mapping[str, float], Diagnostic]],
    count: int,
    words: Callable[[Mapping[str, float]], str],
) -> list[dict[str, Any]]:
    entries = []
    measured = [pair for pair in group if pair[1].value is not None and pair[1].limit is not None]
    if measured:
        at, worst = max(measured, key=lambda pair: share_of_limit(pair[1]))
        alike = sum(other.state == worst.state for _, other in measured)
        most, least = share_of_limit(worst), min(share_of_limit(other) for _, other in measured)
        tail = f"; largest at {words(at)}"
        if count == 1 or (len(measured) == count and most - least <= SAME * abs(most)):
            tail = f"; the same in all {count} cases" if count > 1 else ""
        elif worst.state == "warning":
            tail += f", warning in {alike} of {count} cases"
        entries.append(_entry(worst, at, alike, tail))
    plain = [pair for pair in group if pair[1].value is None or pair[1].limit is None]
    plain = [pair for pair in plain if not measured or pair[1].state != "ok"]
    if plain:
        at, worst = max(plain, key=lambda pair: STATES.index(pair[1].state))
        texts = [each.text for _, each in plain if each.state == worst.state]
        if len(texts) < count:
            tail = f"; in {len(texts)} of {count} cases, the first at {words(at)}"
        else:
            tail = "" if len(set(texts)) == 1 else f"; in all cases, this is the one at {words(at)}"
        entries.append(_entry(worst, at, len(texts), tail))
    return entries


def _entry(diagnostic: Diagnostic, at: Mapping[str, float], cases: int, tail: str) -> dict[str, Any]:
    return diagnostic.to_dict() | {"text": diagnostic.text + tail, "at": dict(at), "cases": cases}


def share_of_limit(diagnostic: Diagnostic) -> float:
    """Return value over limit of a diagnostic that has both, dimensionless; minus infinity for NaN."""
    assert diagnostic.value is not None
    assert diagnostic.limit is not None
    if math.isnan(diagnostic.value) or math.isnan(diagnostic.limit):
        return -math.inf
    if diagnostic.limit == 0:
        return math.inf if diagnostic.value > 0 else 0.0
    return diagnostic.value / diagnostic.limit
