"""Account of a file, column by column; diagnostics of measured signals: range, missing and repeated samples, bandwidth."""

from __future__ import annotations

import json
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.units import format_quantity
from electrovib.recordings.recording import REPEATS, at_extreme, at_rail

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from electrovib.core.arrays import Complex, Real
    from electrovib.data.recorded import DataColumn, Recorded
    from electrovib.data.spectrum import MeasuredSpectrum

MOST_COLUMNS: Final = 60
_MOST_NOT_READ: Final = 20
_MOST_INDUCTIVE: Final = 0.9
"""Largest share of frequencies at which noise alone, about a resistor or a badly calibrated phase, makes a part inductive."""


def account_of(recorded: Recorded) -> dict[str, list[dict[str, Any]]]:
    """Return what is read of a file and what is not, whole, as the attribute ``columns_of_file`` of a Trace holds it."""
    return {
        "read": [_account(each) for each in recorded.channels],
        "not_read": [{"name": each.name, "why": each.why} for each in recorded.not_read],
    }


def _account(column: DataColumn) -> dict[str, Any]:
    """Return name, unit, type and number of rows of a column, and the first and the last of its numbers."""
    values, known = column.values, np.isfinite(column.values)
    missing = values.size - int(np.count_nonzero(known))
    ends = (
        (int(np.argmax(known)), values.size - 1 - int(np.argmax(known[::-1])))
        if missing < values.size
        else ()
    )
    first, last = [float(values[at]) for at in ends] or (None, None)
    return {
        "name": column.name, "unit": column.unit, "type": str(values.dtype), "rows": values.size, "missing": missing,
        "first": first, "last": last,
    }  # fmt: skip


def account_lines(recorded: Recorded, *, whole: bool = False) -> list[str]:
    """Write the account of a file, a line for each column and each thing that is not read; a long one cut unless `whole`."""
    columns = recorded.channels if whole else recorded.channels[:MOST_COLUMNS]
    lines = [f"  {number}  {_line(each, recorded)}" for number, each in enumerate(columns)]
    if more := len(recorded.channels) - len(columns):
        lines.append(f"  and {more} more")
    others = recorded.not_read if whole else recorded.not_read[:_MOST_NOT_READ]
    lines += [f"  not read: {each.name}: {each.why}" for each in others]
    if more := len(recorded.not_read) - len(others):
        lines.append(f"  not read either: {more} more")
    return lines


def _line(column: DataColumn, recorded: Recorded) -> str:
    about = _account(column)
    text = f"{column.name}  [{column.unit or 'unit not stated'}]  {about['rows']} rows of {about['type']}: "
    if about["first"] is None:
        return f"{text}no numbers"
    text += f"{about['first'] + 0.0:.6g} first, {about['last'] + 0.0:.6g} last"
    low, high = np.nanmin(column.values), np.nanmax(column.values)
    text += f", {low:.6g} to {high:.6g}" if {low, high} != {about["first"], about["last"]} else ""
    text += f", {about['missing']} missing" if about["missing"] else ""
    clock = recorded.clocks.get(column.name)
    own = (
        f", with the times of '{clock.time}'"
        if clock and clock.time
        else ", with times of its own"
        if clock
        else ""
    )
    return f"{text}{', the time' if column.name == recorded.time else own}"


def not_read_words(recorded: Recorded) -> list[str]:
    """Return the sentence that names what is not read, the first of many things; none if everything is."""
    others = recorded.not_read
    if not others:
        return []
    read = f"read: {recorded.attributes['table']}; " if "table" in recorded.attributes else ""
    named = "; ".join(f"{each.name} ({each.why})" for each in others[:_MOST_NOT_READ])
    more = f"; and {len(others) - _MOST_NOT_READ} more" if len(others) > _MOST_NOT_READ else ""
    return [f"{read}not read: {named}{more}"]


def told(history: Sequence[str], diagnostics: Iterable[Diagnostic]) -> dict[str, str]:
    """Return the attributes of a Trace that state how it came about and what is wrong with it."""
    return {
        "history": "\n".join(history),
        "validity": json.dumps([each.to_dict() for each in diagnostics]),
    }


def about_file(recorded: Recorded) -> list[Diagnostic]:
    """State which part of a file was read where it holds several, what was not read, and what its reader is not sure of."""
    about = recorded.attributes
    unsure = [Diagnostic("reader", "unknown", f"not sure is {about['unsure']}")] if "unsure" in about else []
    return unsure + [Diagnostic("rest of the file", "unknown", text) for text in not_read_words(recorded)]


_THREADS: Final = 2
"""Signals that are looked through at the same time."""
_FEWEST: Final = 32
"""Fewest samples from which repetition and bandwidth are judged."""
_REPEATED: Final = 0.001
"""Share of repeated rows from which on they are reported."""
_BEYOND_CHANCE: Final = 2.0
"""Factor beyond what noise and resolution explain from which on repeated rows are reported."""
_EDGES: Final = 20
"""Samples between steps of more than half the range, below which their harmonics beyond half the sampling rate matter."""
_FEW: Final = 8
"""Samples per period below which the form of an oscillation is not resolved."""
_STRONG: Final = 0.1
"""Share of the power near half the sampling rate from which on components above it are likely."""
_WEAK: Final = 0.01
_LONGER: Final = 5
"""Length of a run of equal readings, in units of the next longest one, from which on it is judged."""
_TURNS: Final = 0.3
"""Share of changes with another sign than the one before, from which on a signal has noise; of white noise it is 2/3."""
_UNEVEN: Final = 4.0
"""Length of a record over that of as many median intervals, beyond which no spectrum is computed."""
_MOST: Final = 2**17
"""Most samples from which repetition and bandwidth are judged; of a longer record, consecutive ones."""
_SHORT: Final = 2**14
"""Samples up to which a spectrum is fast whatever their number; a longer record is cut to a number of small factors."""
_EIGHT_EQUAL: Final = 255
"""Byte of eight pairs of equal successive readings; a run of ``_FEWEST / 2`` equal readings always holds such a byte."""
_PLAIN: Final = 200
"""Magnitude of the power of two up to which no square of a number overflows or vanishes."""


def about_parts(recorded: Recorded, spectrum: MeasuredSpectrum) -> list[Diagnostic]:
    """State which of several tables, and of several spectra in one of them, was read."""
    among = [Diagnostic("part of the file", "unknown", spectrum.among)] if spectrum.among else []
    return [*about_file(recorded), *among]


def about_reactance(impedance: Complex) -> list[Diagnostic]:
    """Warn of an impedance that is inductive at most frequencies: its imaginary part or phase is probably the negative one."""
    if (share := float(np.mean(impedance.imag > 0))) <= _MOST_INDUCTIVE:
        return []
    text = (
        f"the imaginary part is above 0, as of a coil, at {share:.0%} of the frequencies; skin, films and gaps are"
        " capacitors. If the instrument writes minus the phase or minus the imaginary part, state it"
        " (--set scale.phase=-1 or scale.imaginary=-1)"
    )
    return [Diagnostic("sign of the imaginary part", "warning", text, share, _MOST_INDUCTIVE, "1")]


def about_samples(time: Real, readings: Mapping[str, Real], *, held: bool = False) -> list[Diagnostic]:
    """Judge the samples of measured signals as they are in the file: sensor range, missing and repeated samples, aliasing.

    Of a record that is `held` between its rows only missing samples are judged.
    """
    seen = _seen(readings)
    found = []
    for name, each in seen.items():
        if lost := each.lost:
            text = f"{lost} of {time.size} samples of {name} are no numbers"
            found.append(Diagnostic(f"missing samples of {name}", "warning", text, float(lost), 0.0, "1"))
    if held:
        return found
    for name, each in seen.items():
        found += each.about_sensor(name)
    with ThreadPoolExecutor(_THREADS) as pool:
        for said in pool.map(lambda name: _spectral(name, time, seen[name]), seen):
            found += said
    middle = _middle(time.size)
    repeated = _repeated({name: each.values[middle] for name, each in seen.items()})
    return found + [_judged_on(each, middle, time.size) for each in repeated]


def about_sensors(readings: Mapping[str, Real]) -> list[Diagnostic]:
    """Judge whether sensors are at the end of their range, or stand still where noise would move them."""
    return [said for name, each in _seen(readings).items() for said in each.about_sensor(name)]


def _spectral(name: str, time: Real, seen: _Seen) -> list[Diagnostic]:
    """Judge the aliasing of a signal on the rows with its largest range, or on all where few of those are numbers."""
    values = seen.values
    for rows in (seen.liveliest, slice(0, values.size)):
        finite = np.isfinite(values[rows])
        if np.count_nonzero(finite) >= _FEWEST:
            said = _aliasing(name, time[rows][finite], values[rows][finite])
            return [_judged_on(said, rows, values.size)]
    return []


@dataclass(frozen=True, kw_only=True)
class _Seen:
    """The readings of a signal, and what one walk through them finds.

    `lost` are the readings that are no numbers, `liveliest` the rows of a long record in which the signal has its largest
    range; `is_plain` tells that neither end of its range repeats, and no run of equal readings is long enough to be
    judged, `is_safe` that no square of a reading overflows or vanishes.
    """

    values: Real
    lost: int
    liveliest: slice
    is_plain: bool
    is_safe: bool

    def about_sensor(self, name: str) -> list[Diagnostic]:
        """Judge whether the sensor is at the end of its range, or stands still where noise would move it."""
        if self.values.size - self.lost < _FEWEST:
            return []
        if self.is_plain:
            return [_within_range(name)]
        known = self.values[np.isfinite(self.values)]
        said = _range(name, known)
        return [said, *(_stuck(name, known) if said.state == "ok" else [])]


def _seen(readings: Mapping[str, Real]) -> dict[str, _Seen]:
    """Walk through the readings of several signals at the same time."""
    with ThreadPoolExecutor(_THREADS) as pool:
        return dict(zip(readings, pool.map(_safe, readings.values()), strict=True))


def _safe(values: Real) -> _Seen:
    """Walk through readings, divided by a power of two where their squares would overflow; infinities become NaN then."""
    seen = _walk(values)
    if seen.is_safe:
        return seen
    finite = np.where(np.isfinite(values), values, np.nan)
    largest = float(np.nanmax(np.abs(finite), initial=0.0))
    return _walk(np.ldexp(finite, -int(np.frexp(largest)[1])))


def _walk(values: Real) -> _Seen:
    """Walk through readings in blocks that fit into the cache of the processor."""
    lost, spans, is_safe, is_moving = 0, [], values.dtype == np.float64, True
    # of the readings and of their negatives: the least, and how often it occurs
    ends = [(np.inf, 0), (np.inf, 0)]
    for first in range(0, values.size, _MOST):
        block = values[first : first + _MOST]
        finite = np.isfinite(block)
        if gone := block.size - int(np.count_nonzero(finite)):
            is_safe &= bool(np.isnan(block[~finite]).all())
            block, lost = block[finite], lost + gone
        if not block.size:
            spans.append(-1.0)
            continue
        low, high = float(block.min()), float(block.max())
        spans.append(high - low)
        for at, (end, before) in enumerate(ends):
            least, often = (-high, block == high) if at else (low, block == low)
            if least <= end:
                ends[at] = least, int(np.count_nonzero(often)) + (before if least == end else 0)
        equal = np.packbits(block[1:] == block[:-1]) == _EIGHT_EQUAL
        is_moving &= not (equal.any() or (block[-8:] == block[-1]).all())  # a run may go on in the next block
    largest = max(abs(end) for end, _ in ends)
    return _Seen(
        values=values,
        lost=lost,
        liveliest=_liveliest(values, spans),
        is_plain=is_moving and max(often for _, often in ends) < REPEATS / 2,
        is_safe=is_safe and 2.0**-_PLAIN < largest < 2.0**_PLAIN,
    )


def _liveliest(values: Real, spans: list[float]) -> slice:
    """Return the rows of a long record in which a signal has its largest range; all rows of a short one."""
    if values.size <= _MOST:
        return slice(0, values.size)
    last = values[-_MOST:]
    spans[-1] = float(np.nan_to_num(np.fmax.reduce(last) - np.fmin.reduce(last), nan=-1.0))
    first = min(int(np.argmax(spans)) * _MOST, values.size - _MOST)
    return slice(first, first + _MOST)


def _middle(count: int) -> slice:
    """Return the rows in the middle of a long record; all rows of a short one."""
    first = max(0, count - _MOST) // 2
    return slice(first, first + min(count, _MOST))


def _judged_on(said: Diagnostic, rows: slice, count: int) -> Diagnostic:
    """Say of a diagnostic on which samples it was judged, if not on all."""
    judged = rows.stop - rows.start
    if judged == count:
        return said
    text = f"{said.text}; judged on {judged} of {count} samples, from sample {rows.start} on"
    return replace(said, text=text)


def _range(name: str, values: Real) -> Diagnostic:
    title, railed = f"sensor range of {name}", float(np.mean(at_rail(values)))
    if railed:
        text = f"the sensor of {name} is at its rail, or in a dead band, for {railed:.2%} of the samples: these values are bounds"
        return Diagnostic(title, "warning", text, railed, 0.0, "1")
    if not (share := float(np.mean(at_extreme(values)))):
        return _within_range(name)
    text = f"{share:.2%} of the samples of {name} are exactly its highest or lowest reading: the sensor is at its rail there"
    return Diagnostic(title, "unknown", f"{text}, or the signal is constant within the resolution")


def _within_range(name: str) -> Diagnostic:
    return Diagnostic(
        f"sensor range of {name}", "ok", f"no extreme reading of {name} repeats more often than others"
    )


def _stuck(name: str, values: Real) -> list[Diagnostic]:
    """Name the longest run of one reading where it is far longer than the noise and the other runs explain."""
    change = np.diff(values)
    edges = np.flatnonzero(np.concatenate([[True], change != 0, [True]]))
    lengths = np.diff(edges)
    longest, moves = int(np.argmax(lengths)), change[change != 0]
    others, count = np.delete(lengths, longest), int(lengths[longest])
    if moves.size < _FEWEST or np.mean(moves[1:] * moves[:-1] < 0) < _TURNS:
        return []
    allowed = _LONGER * int(others.max())
    if count < max(allowed, _FEWEST // 2):
        return []
    at = int(edges[longest])
    text = f"{name} stands still from sample {at} to {at + count - 1} and has noise elsewhere: its sensor is stuck there, or the"
    return [
        Diagnostic(
            f"stuck {name}",
            "warning",
            f"{text} noise is below its resolution",
            float(count),
            float(allowed),
            "1",
        )
    ]


def _repeated(readings: Mapping[str, Real]) -> list[Diagnostic]:
    """Judge whether whole rows repeat although a signal with noise is among them."""
    rows = np.array([values for values in readings.values() if np.isfinite(values).all()])
    if rows.size == 0 or rows.shape[1] < _FEWEST:
        return []
    change = np.diff(rows, axis=1)
    noisy = [_is_noisy(row) for row in change]
    if not any(noisy):
        text = "no signal has noise above its resolution, so repeated samples cannot be noticed"
        return [Diagnostic("repeated samples", "unknown", text)]
    share = float(np.mean((change == 0).all(axis=0)))
    chance = float(np.prod([_chance(row) for row in change]))
    text = f"{share:.2%} of the samples repeat the one before in every imported signal; noise and resolution explain {chance:.2%}"
    allowed = _REPEATED + _BEYOND_CHANCE * chance
    if share < allowed:
        return [Diagnostic("repeated samples", "ok", text)]
    more = "; the sensor may be read more often than it is updated" if share > 0.2 else ""
    return [Diagnostic("repeated samples", "warning", text + more, share, allowed, "1")]


def _chance(change: Real) -> float:
    """Return the share of equal successive samples that Gaussian noise rounded to the step of the converter has."""
    moves = np.abs(change[change != 0])
    if not moves.size:
        return 1.0
    scatter = float(np.median(moves)) / 0.6745
    return min(1.0, float(moves.min() / (np.sqrt(2 * np.pi) * scatter)))


def _is_noisy(change: Real) -> bool:
    """Return whether the changes of a signal are mostly larger than the step of its converter."""
    moves = np.abs(change[change != 0])
    return moves.size >= _FEWEST / 2 and float(np.median(moves)) > 2.5 * float(moves.min())


def _aliasing(name: str, time: Real, values: Real) -> Diagnostic:
    """Judge by the spectrum whether a signal may have components above half the sampling rate."""
    from scipy.fft import prev_fast_len, rfft

    title = f"aliasing of {name}"
    step = float(np.median(np.diff(time)))
    if not 0 < time[-1] - time[0] <= _UNEVEN * step * time.size:
        return Diagnostic(title, "unknown", f"the samples of {name} are too uneven in time for a spectrum")
    nyquist = format_quantity(0.5 / step, "Hz", digits=3)
    even = np.interp(np.arange(time[0], time[-1], step), time, values)
    even = even[: prev_fast_len(even.size, real=True)] if even.size > _SHORT else even
    even = (even - even.mean()) * np.hanning(even.size)
    power = np.abs(rfft(even)) ** 2
    total = float(power[1:].sum())
    if not total:
        return Diagnostic(title, "ok", f"{name} is constant")
    peak = int(np.argmax(power[1:])) + 1
    near = float(power[max(peak - 2, 1) : peak + 3].sum())
    high = float(power[3 * power.size // 4 :].sum()) / total
    frequency = peak / (even.size * step)
    per_period = 1 / (frequency * step)
    beyond = f"above {nyquist} appear at wrong frequencies"
    if near > total / 4 and per_period < _FEW:
        text = f"the strongest component of {name}, at {format_quantity(frequency, 'Hz', digits=4)}, has {per_period:.2g} samples"
        text += f" a period: its harmonics {beyond}, and so may the component itself"
        return Diagnostic(title, "warning", text, frequency, 1 / (_FEW * step), "Hz")
    low, top = np.quantile(values, [0.05, 0.95])
    jumps = int(np.count_nonzero(np.abs(np.diff(values)) > (top - low) / 2)) if top > low else 0
    if jumps > 2 and values.size / jumps < _EDGES and near > total / 4:
        every = f"every {values.size / jumps:.3g} samples"
        text = f"{name} changes by more than half its range between two samples, {every}: components {beyond}"
        return Diagnostic(title, "warning", text, jumps / (values.size * step), 1 / (_EDGES * step), "Hz")
    text = f"{high:.2g} of the power of {name} is in the upper quarter of the band below {nyquist}"
    text += (
        ": noise and components from above that frequency cannot be distinguished" if high > _STRONG else ""
    )
    return Diagnostic(title, "ok" if high < _WEAK else "unknown", text)
