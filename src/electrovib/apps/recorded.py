"""Recordings as a fit takes them: their files or Traces, and what is known of all of them."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from electrovib.core.errors import ElectrovibError, InputError
from electrovib.data.traces import open_trace
from electrovib.recordings.fit.measured import MeasuredTrace
from electrovib.recordings.recording import CalibrationError

if TYPE_CHECKING:
    import xarray

    Recorded: TypeAlias = str | Path | MeasuredTrace | xarray.Dataset


@dataclass(frozen=True, kw_only=True)
class Recordings:
    """Recordings of one experiment, and what is known of all of them.

    What a `MeasuredTrace` states of itself counts before what is stated here.

    Parameters
    ----------
    traces : str, Path, MeasuredTrace or xarray.Dataset, or a sequence of them
        Files of Traces, or Traces, with signals over time or frequency.
    quantity : sequence of str, optional
        Only these signals are fitted; by default all that the recordings hold and the scenario predicts.
    noise : mapping of str to float, optional
        Standard deviation of a signal in its unit, of an impedance relative to its modulus; it is estimated where absent.
    zero : sequence of str
        Signals whose zero is unknown and is fitted.
    gain_error, zero_error : mapping of str to float, optional
        Relative standard uncertainty of the gain of a sensor by its signal, and that of its zero in the unit of the signal: gives
        each estimate a systematic error beside the statistical one. By default that of the attributes of an imported signal.
    session : mapping of str to str, optional
        File of a recording to the session to which it belongs; by default each file is a session of its own where
        parameters vary.
    keep : sequence of str
        ``"drive"``, ``"load"`` and ``"motion"``: parts that are taken from the scenario although a recording holds its own.
    settings : mapping of str to value, optional
        Settings under which all were recorded, by dotted path; a recording that contradicts one is refused.
    """

    traces: Sequence[Recorded] | Recorded
    quantity: Sequence[str] | None = None
    noise: Mapping[str, float] = field(default_factory=dict)
    zero: Sequence[str] = ()
    gain_error: Mapping[str, float] = field(default_factory=dict)
    zero_error: Mapping[str, float] = field(default_factory=dict)
    session: Mapping[str, str] = field(default_factory=dict)
    keep: Sequence[str] = ()
    settings: Mapping[str, Any] = field(default_factory=dict)

    @property
    def calibration(self) -> dict[str, CalibrationError]:
        """Return the stated errors of gain and zero by signal."""
        gains, zeros = self.gain_error, self.zero_error
        return {
            name: CalibrationError(gain=gains.get(name, 0.0), zero=zeros.get(name, 0.0))
            for name in dict.fromkeys([*gains, *zeros])
        }

    @property
    def opened(self) -> list[MeasuredTrace | FailedRecording]:
        """Open each recording, and name it by its file or by its place."""
        given = self.traces if isinstance(self.traces, Sequence) else [self.traces]
        given = [given] if isinstance(given, str) else given
        return [_opened(each, number) for number, each in enumerate(given, start=1)]

    def described(self, measured: Sequence[MeasuredTrace], *, varying: bool = False) -> list[MeasuredTrace]:
        """Give each recording a name of its own, and put what is known of all into those that have these signals.

        Parameters
        ----------
        measured : sequence of MeasuredTrace
            The recordings that could be opened.
        varying : bool
            Whether parameters vary between sessions: a recording of no session is one of its own then.

        Returns
        -------
        list of MeasuredTrace
            The same recordings, in their order.
        """
        names = [each.name for each in measured]
        names = [
            f"{name} ({number})" if names.count(name) > 1 else name
            for number, name in enumerate(names, start=1)
        ]
        sessions = {Path(file).name: session for file, session in self.session.items()}
        if unknown := [name for name in sessions if name not in names]:
            raise InputError(f"session: '{unknown[0]}' is none of the recordings: {', '.join(names)}")
        held = {str(name) for each in measured for name in each.trace.data_vars}
        errors = self.calibration
        if absent := [name for name in (*self.noise, *self.zero, *errors) if measured and name not in held]:
            listed = ", ".join(sorted(held))
            raise InputError(f"'{absent[0]}': no recording has this signal; they have {listed}")
        found = []
        for each, name in zip(measured, names, strict=True):
            own = set(map(str, each.trace.data_vars))
            adjusted = dataclasses.replace(
                each,
                name=name,
                changes=dict(self.settings) | dict(each.changes),
                noise={one: value for one, value in self.noise.items() if one in own} | dict(each.noise),
                offsets=list(dict.fromkeys([*each.offsets, *(one for one in self.zero if one in own)])),
                session=sessions.get(name, each.session or (name if varying else "")),
                calibration={one: error for one, error in errors.items() if one in own}
                | dict(each.calibration),
            )
            found.append(adjusted)
        return found


@dataclass(frozen=True)
class FailedRecording:
    """A recording that cannot be read, and why."""

    name: str
    problems: tuple[Any, ...]


def _opened(recording: Recorded, number: int) -> MeasuredTrace | FailedRecording:
    if isinstance(recording, MeasuredTrace):
        return recording
    if not isinstance(recording, (str, Path)):
        return MeasuredTrace(trace=recording, name=f"recording {number}")
    name = Path(recording).name
    try:
        return MeasuredTrace(trace=open_trace(recording), name=name)
    except ElectrovibError as error:
        return FailedRecording(name, tuple(error.problems))


def as_recordings(given: Recordings | Sequence[Recorded] | Recorded) -> Recordings:
    """Return recordings of which nothing more is known than their Traces, or those that are given."""
    return given if isinstance(given, Recordings) else Recordings(traces=given)
