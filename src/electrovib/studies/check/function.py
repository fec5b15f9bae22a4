"""Comparison of a drive in a scenario with declared limits, with breakdown and with published currents."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from electrovib.core.errors import InputError
from electrovib.core.status import UNVERIFIED
from electrovib.core.units import format_quantity
from electrovib.physics.body_current import NOT_A_CLAIM, THRESHOLDS, CurrentThreshold
from electrovib.physics.limits import MEAN_SQUARES, WORDS
from electrovib.scenario import Source, read_scenario
from electrovib.studies.check.declared import (
    DeclaredLimit,
    LimitsSource,
    limits_from,
    limits_of,
    refuse_unlimited,
    strictest,
)
from electrovib.studies.check.drive import DriveSource, with_drive
from electrovib.studies.check.result import FAIL, PASS, UNKNOWN, CheckNumber, CheckResult, CheckRow
from electrovib.studies.check.rows import ONLY_DECLARED, breakdown_row, limit_row
from electrovib.studies.check.values import CheckedValues, checked_values

if TYPE_CHECKING:
    from electrovib.scenario import Scenario

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
    """
    source: Any = drive if scenario is None else scenario
    own: Any = None if scenario is None else drive
    found = read_scenario(source, changes=set)
    return checked(with_drive(found, own), limits=limits, name=_name(own))


def checked(
    scenario: Scenario, *, limits: LimitsSource | Sequence[LimitsSource] = None, name: str = _OWN_DRIVE
) -> CheckResult:
    """Compare the drive of a scenario with the declared limits and with breakdown."""
    declared = declared_limits(scenario, limits)
    values = checked_values(scenario)
    return CheckResult(
        title=f"{name} in: {scenario.title or 'a scenario without a title'}",
        duration=values.end,
        rows=_rows(scenario, values, declared),
        comparisons=tuple(_comparison(each, values) for each in THRESHOLDS),
        numbers=_numbers(values, declared),
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
    refuse_unlimited(declared, what=what)
    result = checked(scenario, limits=limits, name=name)
    result.refuse(consequence)
    _refuse_demanded(scenario, declared["voltage"], result.duration, consequence)
    return result


def _refuse_demanded(scenario: Scenario, limit: DeclaredLimit, end: float, consequence: str) -> None:
    """Refuse a drive that only the amplifier holds within the largest voltage."""
    amplifier = scenario.circuit.amplifier
    if amplifier is None or scenario.drive.quantity != "voltage":
        return
    demanded = abs(amplifier.gain) * scenario.drive.largest(end)
    if demanded > limit.value:
        raise InputError(
            f"the drive times the gain of the amplifier reaches {format_quantity(demanded, 'V', digits=6)}, above"
            f" {format_quantity(limit.value, 'V', digits=6)}: {limit.source}. What saturation, current limit and bandwidth of the"
            f" amplifier (circuit.amplifier) leave of it does not count. {consequence}"
        )


def declared_limits(
    scenario: Scenario, limits: LimitsSource | Sequence[LimitsSource] = None
) -> dict[str, DeclaredLimit]:
    """Combine the limits of a scenario with further ones."""
    several = limits if isinstance(limits, Sequence) and not isinstance(limits, str) else [limits]
    return strictest([limits_of(scenario), *(limits_from(each) for each in several)])


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
            if name in declared or name not in ONLY_DECLARED
        ),
        *(breakdown_row(each) for each in values.breakdown),
    )


def _limit_row(name: str, values: CheckedValues, limit: DeclaredLimit | None, scenario: Scenario) -> CheckRow:
    """Return the row of a declared limit, or that of a quantity without one."""
    words = WORDS[name]
    if scenario.circuit.amplifier is None:
        contact = (
            "current into the contact (no stray capacitance is declared: circuit.amplifier.stray_capacitance)"
        )
        words = words.replace("current into plate, stray capacitance and finger", contact)
    return limit_row(name, values.largest[name], limit, words=words)


def _comparison(threshold: CurrentThreshold, values: CheckedValues) -> CheckRow:
    """Return the row of a published current; within an unverified one the state is unknown."""
    number = values.largest[threshold.of] if threshold.statistic == "peak" else values.rms[threshold.of]
    if math.isnan(number) and math.isinf(values.largest[threshold.of]):
        number = math.inf
    value = None if math.isnan(number) else number
    state = UNKNOWN if value is None else FAIL if value > threshold.value else PASS
    doubtful = threshold.status == UNVERIFIED and state == PASS
    what = f"{threshold.statistic} {threshold.of.replace('_', ' ')}"
    return CheckRow(
        quantity=what,
        value=value,
        limit=threshold.value,
        unit="A",
        source=f"{threshold.name} ({threshold.source}; {threshold.status}): {threshold.conditions}",
        state=UNKNOWN if doubtful else state,
        text=f"{what} compared with {format_quantity(threshold.value, 'A')}: {threshold.name}",
    )


def _numbers(values: CheckedValues, declared: Mapping[str, DeclaredLimit]) -> tuple[CheckNumber, ...]:
    """Return the values whose limit is not declared or does not exist."""
    units = {"rms_voltage": "V", "rms_current": "A", "rms_body_current": "A", "slew_rate": "V/s"}
    found = {f"rms_{name}": value for name, value in values.rms.items()}
    found["slew_rate"] = values.largest["slew_rate"]
    return tuple(
        CheckNumber(
            quantity=name.replace("_", " "), value=None if math.isnan(found[name]) else found[name], unit=unit
        )
        for name, unit in units.items()
        if name not in declared
    )


def _notes(scenario: Scenario, end: float) -> tuple[str, ...]:
    amplifier = scenario.circuit.amplifier
    notes = ["Values are those of the model; a value at exactly its limit passes. No value is clipped."]
    if scenario.drive.duration > end * (1 + 1e-9):
        checked_to, lasts = (format_quantity(each, "s", digits=4) for each in (end, scenario.drive.duration))
        notes.append(f"Checked up to {checked_to} (time.duration) only; the drive lasts {lasts}.")
    if amplifier is None or amplifier.stray_capacitance == 0:
        notes.append(
            "No stray capacitance of plate and cable is declared (circuit.amplifier.stray_capacitance): the current that"
            " charges it is missing, so the current and the stored energy of the real set-up are larger."
        )
    if scenario.circuit.return_path.second_contact(1.0):
        notes.append("The body current is that through the finger from one contact to the other.")
    return (*notes, NOT_A_CLAIM)
