"""Comparison of a drive in a scenario, as it is or as it is played, with limits, breakdown and published currents."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, TypeAlias

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.citation import UNVERIFIED
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError, NoColumnError, NoHeadingsError
from electrovib.core.files import note_input
from electrovib.core.model import read_model
from electrovib.core.samples import Samples
from electrovib.core.units import format_quantity
from electrovib.data.recorded import Recorded
from electrovib.data.registry import read_columns, read_recorded
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.sampled import Held, Sampled
from electrovib.physics.limits import MEAN_SQUARES, WORDS
from electrovib.physics.safety import NOT_A_CLAIM, THRESHOLDS, CurrentThreshold
from electrovib.scenario import Scenario, Source, TimeGrid, read_part, read_scenario
from electrovib.solve.diagnostics import judge
from electrovib.solve.expanded import OF_ELECTRICS, Expanded
from electrovib.solve.quantities.answer import MEAN_SQUARED, root_mean_squares
from electrovib.studies.check import amplifier, result
from electrovib.studies.check.result import CheckResult, CheckRow, DeclaredLimit, LimitsSource

_OWN_DRIVE = "the drive of the scenario"


def check(
    drive: DriveSource | Source,
    scenario: Source | None = None,
    *,
    limits: LimitsSource | Sequence[LimitsSource] = None,
    set: Mapping[str, Any] | None = None,  # noqa: A002 - the name of the option
) -> CheckResult:
    """Compare a drive in a scenario with the declared limits and with breakdown.

    Parameters
    ----------
    drive : str, Path, mapping, Drive or None
        A file with columns of time [s] and voltage [V], a table of a drive, a Drive, or None for that of the scenario.
        Given alone, it is the scenario.
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        As for `electrovib.load`.
    limits : str, Path, mapping, Limits, LimitsFrom, or a list of them, optional
        Further limits beside those of the scenario; the strictest counts.
    set : mapping of str to value, optional
        Dotted path to value, put into the scenario.

    Returns
    -------
    CheckResult
        A row for each limit. A value at exactly its limit passes.

    Raises
    ------
    InputError
        If an input cannot be read, or models cannot be combined.
    NotCausalError
        If the force law has no response in time to this drive.

    Notes
    -----
    The values are those of the model, from time 0 to the last output time: a stray capacitance that is not declared counts
    as 0, and a fault of the amplifier or of the insulator is not part of it. Largest values between output times are sought
    at the corners of the drive, after them and through its oscillations.

    Examples
    --------
    >>> found = ev.check("bau_2010/sine", limits={"voltage": "120 V", "current": "10 mA"})
    >>> found.state, round(found.value("peak voltage"))
    ('unknown', 100)
    """
    source: Any = drive if scenario is None else scenario
    own: Any = None if scenario is None else drive
    found = read_scenario(source, changes=set)
    return checked(with_drive(found, own), limits=limits, name=_name(own))


def checked(
    scenario: Scenario,
    *,
    limits: LimitsSource | Sequence[LimitsSource] = None,
    name: str = _OWN_DRIVE,
) -> CheckResult:
    """Compare the drive of a scenario with the declared limits and with breakdown."""
    declared = declared_limits(scenario, limits)
    values = checked_values(scenario)
    asked = asked_values(scenario, values)
    return CheckResult(
        title=f"{name} in: {title}" if (title := scenario.titled()) else name,
        duration=values.end,
        rows=(
            *_rows(scenario, values, declared),
            *amplifier.asked_rows(scenario, asked),
            *amplifier.slew_rows(scenario, asked),
            *_rest_rows(scenario, values.end),
        ),
        comparisons=tuple(_comparison(each, values) for each in THRESHOLDS),
        numbers=(*_numbers(values, declared), *amplifier.asked_numbers(asked)),
        notes=_notes(scenario, values.end),
        scenario=scenario,
    )


def holds_limits(scenario: Scenario, declared: Mapping[str, DeclaredLimit]) -> bool:
    """Return whether a drive holds declared limits and breakdown, without a value that is not needed for the answer."""
    values = checked_values(scenario, mean_squares=any(name in declared for name in MEAN_SQUARES))
    return not any(row.is_refused for row in _rows(scenario, values, declared))


def cleared_for_output(
    scenario: Scenario,
    *,
    limits: LimitsSource | Sequence[LimitsSource] = None,
    what: str = "a waveform that can be played",
    name: str = _OWN_DRIVE,
    consequence: str = "Nothing was written",
) -> CheckResult:
    """Check a drive that is about to be written or played, or refuse it.

    It is refused unless the largest voltage and the largest current are declared; for every limit that is
    exceeded or could not be compared; and if the drive times the gain exceeds the largest voltage, whatever
    saturation, current limit and bandwidth of the amplifier leave of it. Nothing is ever clipped.
    """
    declared = declared_limits(scenario, limits)
    result.refuse_unlimited(declared, what=what)
    found = checked(scenario, limits=limits, name=name)
    found.refuse(consequence)
    refuse_demanded(scenario, declared["voltage"], found.duration, consequence)
    return found


def refuse_demanded(
    scenario: Scenario, limit: DeclaredLimit, end: float, consequence: str, *, start: float = 0.0
) -> None:
    """Refuse a drive that only the amplifier, or what is left out between samples, holds within the largest voltage."""
    if scenario.drive.quantity != "voltage":
        return
    demanded = abs(scenario.circuit.supply.gain) * max(map(abs, scenario.drive.extremes(start, end)))
    if demanded > limit.value:
        raise InputError(
            f"the drive times the gain of the amplifier reaches {format_quantity(demanded, 'V', digits=6)}, above"
            f" {format_quantity(limit.value, 'V', digits=6)}: {limit.source}. What saturation, current limit and bandwidth of the"
            f" amplifier (circuit.amplifier), or samples that miss a peak, leave of it does not count. {consequence}"
        )


def declared_limits(
    scenario: Scenario, limits: LimitsSource | Sequence[LimitsSource] = None
) -> dict[str, DeclaredLimit]:
    """Combine the limits of a scenario with further ones."""
    further = (result.limits_from(each) for each in several_limits(limits))
    return result.strictest([result.limits_of(scenario), *further])


def several_limits(limits: LimitsSource | Sequence[LimitsSource]) -> tuple[LimitsSource, ...]:
    """Return limits of one place, or of several, as a sequence of places."""
    if isinstance(limits, Sequence) and not isinstance(limits, str):
        return tuple(limits)
    return () if limits is None else (limits,)


def _name(drive: object) -> str:
    if drive is None:
        return _OWN_DRIVE
    return str(drive) if isinstance(drive, str | Path) else "the given drive"


def _rows(
    scenario: Scenario, values: CheckedValues, declared: Mapping[str, DeclaredLimit]
) -> tuple[CheckRow, ...]:
    """Return a row for each limit, and one for each strength that breakdown is judged by."""
    return (
        *(
            _limit_row(name, values, declared.get(name), scenario)
            for name in WORDS
            if name in declared or name not in result.ONLY_DECLARED
        ),
        *(result.breakdown_row(each) for each in values.breakdown),
    )


def _limit_row(name: str, values: CheckedValues, limit: DeclaredLimit | None, scenario: Scenario) -> CheckRow:
    """Return the row of a declared limit, or that of a quantity without one."""
    words = WORDS[name]
    if scenario.circuit.amplifier is None:
        contact = (
            "current into the contact (no stray capacitance is declared: circuit.amplifier.stray_capacitance)"
        )
        words = words.replace("current into plate, stray capacitance and finger", contact)
    return result.limit_row(name, values.largest[name], limit, words=words)


def _rest_rows(scenario: Scenario, end: float) -> list[CheckRow]:
    """Return a row where the drive is larger after the last output time, in its duration or its period, than up to it."""
    drive, whole = scenario.drive, max(scenario.drive.duration, scenario.drive.period or 0.0)
    largest = drive.largest(whole)
    if scenario.time.settled or end >= whole or largest <= drive.largest(end) * (1 + judge.ROUNDED):
        return []
    unit = "A" if drive.quantity == "current" else "V"
    reached, checked_to, lasts = (
        format_quantity(each, of, digits=4) for each, of in ((largest, unit), (end, "s"), (whole, "s"))
    )
    return [
        CheckRow(
            quantity="drive after the checked time",
            value=largest,
            limit=None,
            unit=unit,
            source="time.duration",
            state=result.UNKNOWN,
            text=f"the drive reaches {reached} within {lasts}, and only {checked_to} of it was checked",
            remedy=f"set time.duration to {lasts}",
        )
    ]


def _comparison(threshold: CurrentThreshold, values: CheckedValues) -> CheckRow:
    """Return the row of a published current; within an unverified one the state is unknown."""
    number = values.largest[threshold.of] if threshold.statistic == "peak" else values.rms[threshold.of]
    if math.isnan(number) and math.isinf(values.largest[threshold.of]):
        number = math.inf
    value = None if math.isnan(number) else number
    state = result.state_at(value, threshold.value)
    doubtful = threshold.status == UNVERIFIED and state == result.PASS
    what = f"{threshold.statistic} {threshold.of.replace('_', ' ')}"
    return CheckRow(
        quantity=what,
        value=value,
        limit=threshold.value,
        unit="A",
        source=f"{threshold.name} ({threshold.source}; {threshold.status}): {threshold.conditions}",
        state=result.UNKNOWN if doubtful else state,
        text=f"{what} compared with {format_quantity(threshold.value, 'A')}: {threshold.name}",
    )


def _numbers(values: CheckedValues, declared: Mapping[str, DeclaredLimit]) -> tuple[result.CheckNumber, ...]:
    """Return the values whose limit is not declared or does not exist."""
    units = {"rms_voltage": "V", "rms_current": "A", "rms_body_current": "A", "slew_rate": "V/s"}
    found = {f"rms_{name}": value for name, value in values.rms.items()}
    found["slew_rate"] = values.largest["slew_rate"]
    return tuple(
        result.CheckNumber.of(name.replace("_", " "), found[name], unit)
        for name, unit in units.items()
        if name not in declared
    )


def _notes(scenario: Scenario, end: float) -> tuple[str, ...]:
    supply = scenario.circuit.amplifier
    notes = ["Values are those of the model; a value at exactly its limit passes. No value is clipped."]
    if scenario.drive.duration > end * (1 + 1e-9):
        checked_to, lasts = (format_quantity(each, "s", digits=4) for each in (end, scenario.drive.duration))
        notes.append(f"Checked up to {checked_to} (time.duration) only; the drive lasts {lasts}.")
    if supply is None or supply.stray_capacitance == 0:
        notes.append(
            "No stray capacitance of plate and cable is declared (circuit.amplifier.stray_capacitance): the current that"
            " charges it is missing, so the current and the stored energy of the real set-up are larger."
        )
    if scenario.stack.gap_name is not None:
        notes.append(
            "Current, charge and energy are those of the gap as declared; where a ridge or sweat closes it, they are larger."
        )
    if scenario.circuit.return_path.second_contact(1.0):
        notes.append("The body current is that through the finger from one contact to the other.")
    return (*notes, NOT_A_CLAIM)


_SHORTEST: Final = 1e-9
"""Shortest edge that is sought, over the interval between two samples."""
_RESISTANCES: Final = (1.0, 1e10)
"""Range in which a series resistor is sought [ohm]."""
_CLOSE: Final = 1.01
"""Ratio of the bounds at which a search ends."""


def cleared_as_played(
    scenario: Scenario,
    *,
    times: Real,
    voltages: Real,
    edge: float | None,
    declare: str,
    limits: LimitsSource | Sequence[LimitsSource] = None,
    what: str,
    name: str,
    consequence: str = "Nothing was written",
) -> CheckResult:
    """Check samples that are held from one to the next, or refuse them with the filter or resistor that helps.

    The samples are evenly spaced from 0. `edge` is the height of a step over its steepest slope [s], at most
    their interval; None is 0, with `declare` in the message.
    """
    interval, declared = float(np.min(np.diff(times))), declared_limits(scenario, limits)

    def under(lasting: float, resistance: float | None = None) -> Scenario:
        table = {"samples": sampled(times, voltages), "edge": min(lasting, interval)}
        found = with_drive(scenario, read_model(Held, table))
        return found if resistance is None else found.replace({"circuit.source_resistance": resistance})

    def holds(lasting: float, resistance: float | None = None) -> bool:
        return holds_limits(under(lasting, resistance), declared)

    try:
        return cleared_for_output(
            under(edge or 0.0), limits=limits, what=what, name=name, consequence=consequence
        )
    except InputError as error:
        if not holds(interval):
            raise
        played = "no edge is declared, so that they follow each other as steps"
        if edge is not None:
            played = f"the declared edge takes {format_quantity(edge, 's', digits=4)}"
        shortest = _smallest(holds, _SHORTEST * interval, interval)
        pole = _two_digits(1 / (2 * math.pi * shortest), math.floor)
        held, takes = (format_quantity(each, "s", digits=4) for each in (interval, shortest))
        remedy = (
            f"{name} are held for {held} each, and {played}. A filter in front of the plate whose edge takes at least {takes},"
            f" such as one pole at {format_quantity(pole, 'Hz', digits=3)} or below, would hold the limits"
        )
        resistance = _smallest(lambda value: holds(edge or 0.0, value), *_RESISTANCES)
        if resistance < _RESISTANCES[1]:
            remedy += (
                f"; so would a resistor of {format_quantity(resistance, 'ohm', digits=3)} between amplifier and plate"
                " (circuit.source_resistance)"
            )
        raise InputError([*error.problems, f"{remedy}. {declare}"]) from None


def _smallest(holds: Callable[[float], bool], low: float, high: float) -> float:
    """Return the smallest value that holds the limits, rounded up to two digits; the highest if none below it does."""
    if not holds(high):
        return high
    top = high
    while high > _CLOSE * low:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if holds(middle) else (middle, high)
    return min(_two_digits(high, math.ceil), top)


def _two_digits(value: float, rounding: Callable[[float], int]) -> float:
    step = 10.0 ** (math.floor(math.log10(value)) - 1)
    return rounding(value / step) * step


@dataclass(frozen=True)
class CheckedValues:
    """Values of a run by the name of their limit; NaN where not known, infinite where they have no bound."""

    largest: dict[str, float]
    rms: dict[str, float]
    breakdown: list[Diagnostic]
    end: float
    currents: tuple[float, float]
    """Largest current out of the amplifier and into it, both positive [A]."""


def checked_values(scenario: Scenario, *, mean_squares: bool = True) -> CheckedValues:
    """Solve a scenario for the values of limits; root mean squares, which take most of the time, can be left out."""
    expanded = Expanded(scenario, mechanics=False)
    record = expanded.at(expanded.times, closely=True, wanted=OF_ELECTRICS)
    assert record.peaks is not None
    peaks, end = record.peaks, float(expanded.times[-1])
    reached = judge.largest_values(scenario, expanded.section, peaks)
    reached["slew_rate"] = judge.slew_rate(scenario, end)
    largest = {name: judge.largest_of(reached, name) for name in WORDS}
    known = [name for name in MEAN_SQUARED if mean_squares and math.isfinite(largest[name])]
    rms = dict.fromkeys(MEAN_SQUARED, math.nan) | root_mean_squares(expanded, peaks, known)
    found = judge.stack_diagnostics(scenario, peaks)
    return CheckedValues(
        largest=largest | {name: rms[name.removeprefix("rms_")] for name in MEAN_SQUARES},
        rms=rms,
        breakdown=[each for each in found if each.name.startswith(result.BREAKDOWN)],
        end=end,
        currents=judge.largest_currents(peaks, largest["current"]),
    )


def asked_values(scenario: Scenario, values: CheckedValues | None = None) -> CheckedValues:
    """Return what the drive asks of the amplifier: the `values` of a run whose amplifier has no largest voltage and current."""
    free = amplifier.without_its_limits(scenario, amplifier.LARGEST)
    if free is scenario and values is not None:
        return values
    return checked_values(free, mean_squares=values is not None)


DriveSource: TypeAlias = "str | Path | Mapping[str, Any] | Drive | None"
"""A file of samples, a table of a drive, a Drive, or None for the drive of the scenario."""
COLUMNS = (("time", "voltage"), ("time", "drive_voltage"))
"""Headings of time and voltage that are tried in a file, in this order."""
_READ_DIRECTLY = (".csv", ".txt", ".tsv", ".npy", ".nc", ".mat")


def with_drive(scenario: Scenario, drive: DriveSource) -> Scenario:
    """Put another drive into a scenario, from rest and over its whole duration; None leaves the scenario as it is."""
    if drive is None:
        return scenario
    return scenario.model_copy(update={"drive": read_drive(drive), "time": TimeGrid()})


def read_drive(source: str | Path | Mapping[str, Any] | Drive) -> Drive:
    """Read a drive from a file, a table or itself; a file has columns of time [s] and voltage [V], without NaN."""
    if isinstance(source, Drive):
        return source
    if isinstance(source, Mapping):
        return read_part(Drive, dict(source))  # type: ignore[type-abstract]
    if not isinstance(source, str | Path):
        raise InputError(f"expected a file, a table or a Drive, not a {type(source).__name__}", path="drive")
    path = Path(source)
    if path.suffix.lower() == ".toml":
        raise InputError("has no columns; for the drive of a scenario give the scenario alone", path=path)
    if path.suffix.lower() not in _READ_DIRECTLY:
        return sampled(*_channels(path), path=path)
    return sampled(**first_columns(path, COLUMNS, {"time": "s", "voltage": "V"}), path=path)


def sampled(time: Real, voltage: Real, *, path: str | Path = "") -> Drive:
    """Return a drive of straight lines between samples [s, V]; `path` names the file in messages."""
    try:
        return read_model(Sampled, {"time_samples": Samples(time), "voltage_samples": Samples(voltage)})
    except InputError as error:
        if not path or len(error.problems) > 1:
            raise
        raise InputError(error.problems[0].reason, path=path) from None


def first_columns(path: Path, forms: Sequence[Sequence[str]], units: Mapping[str, str]) -> dict[str, Real]:
    """Read the columns of the first headings that a file has, or of a file without headings its first two, in SI by name.

    `units` has the name and the unit of each column, in the order of the headings in each of `forms`.
    """
    note_input(path)
    faults: list[NoColumnError] = []
    for form in forms:
        try:
            wanted = zip(form, units.items(), strict=False)
            return read_columns(path, {name: (heading, unit) for heading, (name, unit) in wanted})
        except NoHeadingsError:  # which is a kind of the next one
            (first, unit), (second, other) = list(units.items())[:2]
            return read_columns(path, {first: (0, unit), second: (1, other)})
        except NoColumnError as error:
            faults.append(error)
    raise faults[0]


def _channels(path: Path) -> tuple[Real, Real]:
    """Return times and voltages of a record of an instrument that has one channel in volts."""
    note_input(path)
    recorded: Recorded = read_recorded(path)
    time = recorded.times()
    if time is None:
        raise InputError(
            "states no times of its samples; write it as CSV with the columns time and voltage", path=path
        )
    stamped = [each.unit.strip().lower() for each in recorded.channels if each.name == recorded.time]
    if any(unit not in {"", "s", "sec", "second", "seconds"} for unit in stamped):
        raise InputError(
            f"has times in '{stamped[0]}'; write it as CSV with the columns time and voltage", path=path
        )
    channels = [each for each in recorded.channels if each.name != recorded.time]
    volts = [each for each in channels if each.unit.strip().lower() in {"v", "volt", "volts"}]
    if len(volts) != 1:
        listed = ", ".join(f"'{each.name}' [{each.unit or 'no unit'}]" for each in channels)
        raise InputError(
            f"a drive is one channel in volts, and the file has {listed}; write the voltage as CSV with the columns time and"
            " voltage",
            path=path,
        )
    return np.asarray(time, dtype=float), np.asarray(volts[0].values, dtype=float)
