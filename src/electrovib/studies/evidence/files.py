"""Measurements by name: those that papers declare, and those of files, which a table of points becomes."""

from __future__ import annotations

import functools
import math
import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.discovery import find_offer
from electrovib.core.errors import InputError, Problem, gathered, located, nearest, refuse
from electrovib.core.parsing import read_toml_file
from electrovib.core.paths import quantity_at
from electrovib.core.units import format_quantity, parse_quantity
from electrovib.data.atomic import Form, unsigned
from electrovib.data.recorded import DataColumn, column_of
from electrovib.data.registry import read_recorded
from electrovib.scenario import Scenario, read_scenario
from electrovib.scenario.reading import paper_of_preset, without_schema
from electrovib.scenario.space.reading import flattened, read_number, read_space
from electrovib.scenario.toml import SCHEMA
from electrovib.studies.evidence.entries import (
    COLUMNS,
    IN_PLACE_OF_VALUES,
    Entries,
    entries_of,
    parts,
    publication_files,
    tables_of,
)
from electrovib.studies.evidence.measurement import Measurement, check_unit, divisor, unit_of
from electrovib.studies.evidence.predicted import candidates
from electrovib.studies.evidence.quantities import QUANTITIES, ComputedQuantity


def of_range(given: Sequence[float]) -> Real:
    """Return the geometric mean of a printed range (1,)."""
    if len(given) != 2 or not 0 < given[0] < given[1]:
        raise InputError("expected the least and the largest value, above 0", path="printed_range")
    return np.array([np.sqrt(given[0] * given[1])])


def of_runs(given: Sequence[Sequence[float]], least: float) -> tuple[Real, Real]:
    """Return mean and relative deviation, at least `least`, at each point (n,) of runs (runs, n)."""
    if len(given) < 2 or len({len(each) for each in given}) != 1:
        raise InputError("expected two or more rows of one length", path="runs")
    means = np.mean(given, axis=0)
    return means, np.maximum(np.std(given, axis=0, ddof=1) / means, least)


def of_devices(given: Sequence[float]) -> tuple[Real, Real]:
    """Return geometric mean and relative deviation of a log-normal distribution of devices, each (1,)."""
    if len(given) < 2 or min(given) <= 0:
        raise InputError("expected two or more values, above 0", path="devices")
    logs = np.log(given)
    return np.exp(logs.mean(keepdims=True)), np.sqrt(np.expm1(np.var(logs, ddof=1, keepdims=True)))


def of_line(given: Sequence[float], at: Sequence[float]) -> tuple[Real, Real]:
    """Return values and relative standard errors (n,) of a line with start, its error, slope and its error."""
    if len(given) != 4:
        raise InputError("expected start, its error, slope and its error, in SI", path="line")
    start, start_error, slope, slope_error = given
    values = start + slope * np.asarray(at)
    return values, np.hypot(start_error, slope_error * np.asarray(at)) / values


def measurements(word: str = "") -> dict[str, Measurement]:
    """Collect what publications, ours and those of other packages, have measured; or read a measurement of your own.

    Parameters
    ----------
    word : str
        Part of a name ``author_year/name``, a title or a group; all if empty; or a file (``.toml``) with one measurement or
        several; or a folder of such files, ``"lab/"``.

    Returns
    -------
    dict of str to Measurement
        By ``author_year/name``, or by the name of the file without its suffix, and where it has several ``file/name``.

    Raises
    ------
    InputError
        If no measurement has the word; the groups are listed. Of a file: every mistake at once.

    Examples
    --------
    >>> list(ev.measurements("israr_2006"))[:3]
    ['israr_2006/pen', 'israr_2006/pen_slope', 'israr_2006/cylinder']
    """
    path = Path(word)
    if word.endswith(("/", os.sep)):
        files = sorted(path.glob("*.toml"))
        if not files:
            raise InputError("a folder without files of measurements (.toml)", path=path)
        return {name: each for file in files for name, each in measurements(str(file)).items()}
    if path.suffix.lower() == ".toml":
        advice = "'electrovib import points.csv --as measurement -o mine.toml' writes one"
        return _of_file(read_toml_file(path, kind="a measurement", advice=advice), path)
    names = sorted(publication_files())
    known = {f"{name}/{key}": each for name in names for key, each in of_publication(name).items()}
    found = {
        name: each
        for name, each in known.items()
        if word.casefold() in f"{name} {each.title} {each.group} {each.on}".casefold()
    }
    if not found:
        groups = ", ".join(sorted({each.group for each in known.values()}))
        raise InputError(f"no measurement is called '{word}'. Groups that measured: {groups}")
    return found


@functools.cache
def of_publication(name: str) -> dict[str, Measurement]:
    """Read the measurements of one publication, author_year, by their own names."""
    found = _of_file(dict(tables_of(name)), publication_files()[name])
    return {key.rpartition("/")[2]: each for key, each in found.items()}


def _of_file(content: dict[str, Any], path: Path) -> dict[str, Measurement]:
    """Read the measurements of a file; mistakes in all of them are told together, of several with the name of the file."""
    name, found = path.with_suffix("").as_posix(), {}
    problems: list[str] = []
    calibrating: dict[str, list[str]] = {}
    with gathered(problems):
        for part, entries in parts(content).items():
            with gathered(problems, within=f"measurements.{part}" if part else ""):
                own = _with_files(without_schema(entries), lambda name: str(path.parent / name))
                stated = entries_of(own)
                key = f"{name}/{part}" if part else name
                found[key], calibrating[key] = _measurement(stated), stated.calibrated_by
    for key, by in calibrating.items() if not problems else ():
        part = key.removeprefix(name).removeprefix("/")
        with gathered(problems, within=f"measurements.{part}" if part else ""):
            found[key] = replace(found[key], calibrated_by=_named(by, path.stem, name, found))
            other = found.get(f"{name}/{found[key].same_as}", found[key])
            if found[key].same_as and (other is found[key] or other.values != found[key].values):
                why = "expected another measurement of this file with the same values"
                raise InputError(why, path="same_as", value=found[key].same_as)
    if "measurements" in content:
        told = map(Problem.read, problems)
        problems = [Problem(each.reason, path=f"{path.name}: {each.path}", value=each.value) for each in told]
    refuse(problems)
    return found


def _named(
    names: Sequence[str], stem: str, file: str, found: Mapping[str, Measurement]
) -> dict[str, Measurement]:
    """Return other measurements of a file, stem/name, by their names."""
    known = {key.removeprefix(f"{file}/"): each for key, each in found.items()}
    for name in names:
        if name not in known:
            why = f"no measurement of this file.{nearest(name, known)}"
            raise InputError(why, path="calibrated_by", value=name)
    return {f"{stem}/{name}": known[name] for name in names}


def _with_files(content: Mapping[str, Any], move: Callable[[str], str]) -> dict[str, Any]:
    """Return entries with every name of a file in them moved to another folder, that of the scenario included."""

    def moved(item: Any, key: str = "") -> Any:
        if isinstance(item, Mapping):
            return {name: moved(each, str(name)) for name, each in item.items()}
        return move(item) if isinstance(item, str) and key.rpartition(".")[2] == "file" else item

    found, scenario = moved(content), content.get("scenario")
    if isinstance(scenario, str) and not paper_of_preset(scenario):
        found["scenario"] = move(scenario)
    return dict(found)


def _computed(name: str) -> ComputedQuantity | None:
    """Return a quantity that a function computes, ours or a paper's as ``author_year/name``; None for one of a run."""
    if name in QUANTITIES:
        return QUANTITIES[name]
    found: ComputedQuantity | None = find_offer(name, ("quantities",)) if "/" in name else None
    return found


def _set_up(stated: Entries) -> tuple[Scenario, str, str]:
    """Return the set-up, the unit of the values, and that of the parameter that was varied."""
    scenario, problems = read_scenario(stated.scenario), list[str]()
    with located("changes"):
        scenario = scenario.replace(stated.changes)
    unit, of_over = stated.unit, "1"
    under = divisor(stated)
    if computed := _computed(stated.quantity):
        own = "1" if stated.per_changes else computed.unit
        if unit not in {"", own}:
            problems.append(f"unit = '{unit}': {stated.quantity} is in {own}")
        unit = own
    with gathered(problems):
        unit = unit or (unit_of(stated.quantity, under, scenario) if stated.scale == 1 else "")
        if not computed:
            check_unit(unit, stated.quantity, under, stated.scale, scenario)
    with gathered(problems, within="per_changes"):
        scenario.replace(stated.per_changes)
    try:
        of_over = quantity_at(scenario, stated.over).unit if stated.over else "1"
    except InputError as error:
        problems += [Problem(each.reason, path="over", value=stated.over) for each in error.problems]
    refuse(problems)
    return scenario, unit, of_over


def _measurement(stated: Entries) -> Measurement:
    """Build the measurement; mistakes in its parts are refused together."""
    scenario, unit, of_over = _set_up(stated)
    of_values, of_at, problems = list[str](), list[str](), list[str]()
    at: tuple[float, ...] = ()
    calibrated_at: tuple[float, ...] = ()
    with gathered(of_at):
        at = _numbers("at", stated.at, of_over) if stated.over else ()
        for each in at:
            scenario.replace({stated.over: each})
        calibrated_at = _numbers("calibrated_at", stated.calibrated_at, of_over)
    with gathered(of_values):
        values, spread = _values(stated, unit, at)
    unknown = flattened(stated.unknown)
    with gathered(problems, within="unknown"):
        if unknown:
            read_space(scenario, {"space": unknown})
    refuse([*of_values, *of_at, *problems])
    of_model: dict[str, dict[str, Any]] = {}
    for path, table in flattened(stated.of_model).items():
        model, _, inner = path.partition(".")
        if not inner or not (table is False or isinstance(table, Mapping)):
            raise InputError(
                f"of_model.{path}: expected MODEL.PATH with a table, or false for a layer that it replaces"
            )
        of_model.setdefault(model, {})[inner] = table or None
    computed = _computed(stated.quantity)
    made = {
        "scenario": scenario, "quantity": computed.compute if computed else stated.quantity, "unit": unit, "values": values,
        "spread": spread, "at": at, "unknown": unknown, "of_model": of_model, "made": tuple(stated.made),
        "calibrated_at": calibrated_at, "calibrated_by": {},
    }  # fmt: skip
    if stated.line and not stated.error_of:
        made["error_of"] = f"line of {stated.title}"
    found = Measurement(**stated.model_dump(exclude={"changes", *IN_PLACE_OF_VALUES}) | made)
    known = candidates(found)
    if wrong := [name for name in (*of_model, *found.made) if name not in known]:
        raise InputError(f"{name}: no model of {found.judges}.{nearest(name, known)}" for name in wrong)
    return found


def _values(stated: Entries, unit: str, at: Sequence[float]) -> tuple[tuple[float, ...], ...]:
    """Return values and relative spread, of what is printed in another form too."""
    own, given = None, stated.spread
    if stated.printed_range:
        values = of_range(_numbers("printed_range", stated.printed_range, unit))
    elif stated.runs:
        rows = [_numbers("runs", each, unit) for each in stated.runs]
        values, own = of_runs(rows, *_numbers("spread", given or 0.0, "1"))
    elif stated.devices:
        values, own = of_devices(_numbers("devices", stated.devices, unit))
    elif stated.line:
        values, own = of_line(_numbers("line", stated.line, "1"), at)
    else:
        values = np.array(_numbers("values", stated.values, unit))
    found = tuple(values.tolist())
    if own is not None:
        return found, tuple(own.tolist())
    each_of = given if isinstance(given, list) else [given] * len(found)
    return found, tuple(_relative(*each, unit) for each in zip(each_of, found, strict=False))


def _numbers(name: str, given: Any, unit: str) -> tuple[float, ...]:
    found: tuple[float, ...] = read_number(name, given if isinstance(given, list) else [given], unit)
    return found


def _relative(given: Any, value: float, unit: str) -> float:
    """Read a spread: a share of the value, also in per cent, or a text in the unit of the value."""
    if isinstance(given, str):
        with suppress(ValueError):
            return parse_quantity(given, "1")
        return _numbers("spread", given, unit)[0] / value if value else math.nan
    return _numbers("spread", [given], "1")[0]


@dataclass(frozen=True, kw_only=True)
class ImportedMeasurement:
    """A measurement made of a table of points, with its entries as they are written and a sentence about its origin."""

    measurement: Measurement
    entries: Mapping[str, Any]
    history: str

    def to_toml(self) -> str:
        """Write the file that `measurements` and `electrovib.evidence` read."""
        import tomlkit

        ordered = sorted(self.entries.items(), key=lambda each: isinstance(each[1], Mapping))
        head = [unsigned(Form.MEASUREMENT), " ".join(self.history.split())]
        return "".join(f"# {line}\n" for line in head) + tomlkit.dumps({"schema": SCHEMA, **dict(ordered)})

    @property
    def lines(self) -> list[str]:
        """Title, origin, and each point with its spread."""
        each = self.measurement
        of_over = quantity_at(each.scenario, each.over).unit
        points = zip(each.at, each.values, each.spread, strict=True)
        return [
            f"{each.title}: {each.named}",
            self.history,
            *(
                f"{each.over} = {format_quantity(at, of_over)}: {format_quantity(value, each.unit)}, spread"
                f" {100 * spread:.3g} %"
                for at, value, spread in points
            ),
        ]


def import_measurement(
    path: str | Path,
    columns: Mapping[str, str],
    *,
    folder: str | Path = "",
    reader: str = "",
    delimiter: str | None = None,
    decimal_comma: bool | None = None,
    part: str | None = None,
    **entries: Any,
) -> ImportedMeasurement:
    """Import a table of measured points as a measurement, by which laws are judged.

    Parameters
    ----------
    path : str or Path
        Any file that a reader takes, with a row for each point.
    columns : mapping of str to str
        ``value``, ``at`` and ``spread`` to the heading of a column, with a unit where the file states none. A spread in per
        cent is one over the value; the entry `spread` takes its place where it is the same for all.
    folder : str or Path
        Folder of the file that is written, to which the names of files in it become relative.
    reader, delimiter, decimal_comma, part
        As for `electrovib.import_file`.
    **entries
        What else the file of a measurement holds, as `Measurement` describes it; the names of files are relative to the
        working folder.

    Returns
    -------
    ImportedMeasurement
        The measurement, and its text as TOML.

    Raises
    ------
    InputError
        If something is missing or does not fit, all mistakes of a kind at once.
    """
    place = Path(path)
    if wrong := [name for name in columns if name not in COLUMNS]:
        raise InputError(
            f"columns.{name}: no column of a measurement.{nearest(name, COLUMNS)}" for name in wrong
        )
    content = {name: each for name, each in entries.items() if name != "schema"}
    stated = entries_of(content, columns)
    _, unit, of_over = _set_up(stated)
    _named(stated.calibrated_by, "", "", {})
    recorded = read_recorded(
        place, reader=reader, delimiter=delimiter, decimal_comma=decimal_comma, part=part
    )
    chosen = {name: column_of(recorded, each, option=f"columns.{name}") for name, each in columns.items()}
    values = _positive(chosen["value"], place, unit)
    content["values"] = _written(values, unit)
    content["at"] = _written(_in_si(chosen["at"], place, of_over, "at"), of_over)
    if "spread" in chosen:
        content["spread"] = _written(_spread(chosen["spread"], place, unit, values), "1")
    origin = ", ".join(f"{COLUMNS[name]} from '{each.name}' [{each.unit}]" for name, each in chosen.items())
    return ImportedMeasurement(
        measurement=_measurement(entries_of(content)),
        entries=_with_files(content, lambda name: os.path.relpath(name, folder or ".")),
        history=f"{len(values)} points of {place.name}: {origin}",
    )


def _written(numbers: Real, unit: str) -> list[str] | list[float]:
    """Write numbers with their unit in twelve digits, which is more than is measured."""
    if unit == "1":
        return [float(f"{each:.12g}") for each in numbers.tolist()]
    return [format_quantity(each, unit, digits=12) for each in numbers.tolist()]


def _in_si(column: DataColumn, path: Path, unit: str, name: str, *, or_else: str = "") -> Real:
    if not column.unit and unit != "1":
        raise InputError(
            f"columns.{name} = {column.name}: the file states no unit; write it behind the name: '{column.name} [{unit}]'"
            f"{or_else}"
        )
    return column.in_si(path, unit)


def _positive(column: DataColumn, path: Path, unit: str) -> Real:
    found = _in_si(column, path, unit, "value")
    bad = found[found <= 0]
    if bad.size:
        raise InputError(
            f"columns.value = {column.name}: {bad.size} of {found.size} values are not above 0, the first is"
            f" {format_quantity(float(bad[0]), unit)}; a law is judged by the logarithm of the value: leave such points out, or"
            " take a quantity that is positive, such as a swing or a peak"
        )
    return found


def _spread(column: DataColumn, path: Path, unit: str, values: Real) -> Real:
    """Return a spread over the value: of a column in per cent or in the unit of the value."""
    if column.unit == "%":
        return column.in_si(path, "1")
    in_share = f", or '{column.name} [%]' for one over the value"
    return _in_si(column, path, unit, "spread", or_else=in_share) / values
