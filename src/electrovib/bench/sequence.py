"""The order of a run: nothing is enabled before every setting was read back; and what every end does after 0 V."""

from __future__ import annotations

import json
import os
import sys
import tempfile
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

from electrovib.bench.drivers.hp_33120a import mismatches
from electrovib.bench.drivers.tektronix_tds3014b import RECORD
from electrovib.bench.link import BenchError
from electrovib.bench.settings import ForceInput
from electrovib.core.errors import ElectrovibError, printable
from electrovib.core.signals import make_trace
from electrovib.core.units import format_quantity
from electrovib.exports.save import save
from electrovib.solve.quantities.answer import of_record
from electrovib.solve.simulate import provenance

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    import xarray
    from numpy.typing import NDArray

    from electrovib.bench.link import BenchClock
    from electrovib.bench.plan import BenchPlan
    from electrovib.bench.settings import Instruments


_LONGEST_NUMBER: Final = 26
_LONGEST_TEXTS: Final = 100_000
"""Bytes that a number with its comma, and the texts of a record, take at most."""
_POLL: Final = 0.02
_MARGIN: Final = 5.0
"""Time beyond that of the record after which an oscilloscope that does not finish counts as failed [s]."""


@dataclass
class RunRecord:
    """What a run has read so far; it is saved also when the run is stopped.

    `steps` were begun; `instruments` are their identities, `settings` those read back last, by query. `time`
    (n,) [s] after the trigger and `channels`, by role plate voltage [V], current [A] or force [N], each (n,),
    belong to the `burst`, which is empty before the first; `statements` are the results of the comparisons.
    """

    steps: list[str] = field(default_factory=list)
    instruments: dict[str, str] = field(default_factory=dict)
    settings: dict[str, str] = field(default_factory=dict)
    burst: str = ""
    time: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    channels: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    statements: list[str] = field(default_factory=list)


@dataclass
class BurstSequence:
    """Plays a plan on instruments, step by step.

    `confirm` asks the operator to do something and returns whether it was confirmed; it is used without an
    enable line. `check` raises if the process was asked to end; it is called before anything that raises the
    voltage, and while waiting. `report` is called with the name of each step before it begins.
    """

    plan: BenchPlan
    instruments: Instruments
    clock: BenchClock
    confirm: Callable[[str], bool]
    check: Callable[[], None]
    report: Callable[[str], object]
    record: RunRecord = field(default_factory=RunRecord)
    _resolution: dict[int, float] = field(default_factory=dict)
    _length: float = 0.0
    _burst_name: str = ""

    def play(self) -> RunRecord:
        """Run all steps in their order up to the first deviation, which leaves the bench in the state of that step."""
        for name, work in self.work.items():
            self._begin(name)
            work(self)
        return self.record

    def _begin(self, name: str) -> None:
        self.record.steps.append(name)
        self.report(name)
        self.check()

    def _identify(self) -> None:
        instruments = self.instruments
        self.record.instruments["generator"] = instruments.generator.identify()
        self.record.instruments["oscilloscope"] = instruments.oscilloscope.identify()

    def _switch(self, *, on: bool) -> None:
        """Enable or disable the high voltage, by the enable line or by the operator."""
        self.check()
        enable = self.instruments.enable
        if enable is not None:
            (enable.enable if on else enable.disable)()
            return
        words = f"Switch the high voltage {'ON' if on else 'OFF'}, take your hand off the switch, and confirm"
        if not self.confirm(words):
            raise BenchError(f"the operator did not confirm: '{words}'")

    def _download(self) -> None:
        plan = self.plan
        self.instruments.generator.download(plan.codes, plan.duration, plan.fraction * plan.amplitude)

    def _set_oscilloscope(self, fraction: float) -> None:
        oscilloscope = self.instruments.oscilloscope
        self._length = oscilloscope.set_time(self.plan.duration)
        for channel, (low, high) in self.plan.ranges(fraction).items():
            self._resolution[channel] = oscilloscope.set_channel(channel, low, high)
        oscilloscope.finish_settings()

    def _read_back(self, fraction: float) -> None:
        plan, generator, oscilloscope = self.plan, self.instruments.generator, self.instruments.oscilloscope
        played = generator.expected(plan.codes.size, plan.duration, fraction * plan.amplitude)
        recorded = oscilloscope.expected(plan.duration, plan.ranges(fraction))
        found = generator.link.answers(played) | oscilloscope.link.answers(recorded)
        self.record.settings |= found
        if wrong := mismatches(found, played | recorded):
            raise BenchError(f"a setting does not read back: {'; '.join(wrong)}")

    def _burst(self, name: str, fraction: float) -> None:
        """Play one burst and read the voltage back, and the current where it is recorded.

        All settings are read again just before the trigger. With an enable line its state is read while the
        burst runs, and the high voltage is disabled before the record is transferred.
        """
        oscilloscope, enable = self.instruments.oscilloscope, self.instruments.enable
        self._read_back(fraction)
        oscilloscope.start()
        self._wait(oscilloscope.is_ready, "is not ready for the trigger")
        self.check()
        self.instruments.generator.trigger()
        self._wait(self._is_recorded, "has not recorded the burst")
        if enable is not None:
            enable.disable()
        self._burst_name = name
        self._read("voltage")
        refuse_beyond(self.plan, self.record, "voltage", self._step("voltage"))
        if "current" in self.plan.settings.channels():
            self._read("current")
            refuse_beyond(self.plan, self.record, "current", self._step("current"))

    def _is_recorded(self) -> bool:
        """Return whether the record is complete, after the state of the enable line was read."""
        if self.instruments.enable is not None:
            self.instruments.enable.confirm()
        return self.instruments.oscilloscope.is_done()

    def _compare_low(self) -> None:
        fraction, step = self.plan.fraction, self._step("voltage")
        self.record.statements += compare(self.plan, self.record, fraction=fraction, step=step)
        refuse_scaled(self.plan, self.record, fraction=fraction, step=step)

    def _raise(self) -> None:
        """Set the full amplitude with the high voltage disabled: its attenuators switch with glitches."""
        self._switch(on=False)
        self.instruments.generator.set_amplitude(self.plan.amplitude)
        self._set_oscilloscope(1.0)
        self._read_back(1.0)
        self._switch(on=True)

    def _read_records(self) -> None:
        self.record.statements += compare(self.plan, self.record, fraction=1.0, step=self._step("voltage"))
        for name in self.plan.settings.channels():
            if name not in self.record.channels:
                self._read(name)
            self.record.statements += beyond_range(self.plan, self.record, name)

    def _read(self, name: str) -> None:
        """Read the record of a channel in its own quantity."""
        channel = self.plan.settings.channels()[name]
        times, voltages = self.instruments.oscilloscope.record(channel.input)
        if (
            self.record.burst != self._burst_name
        ):  # the record of the burst before is kept until there is a new one
            self.record.burst, self.record.channels = self._burst_name, {}
        self.record.time = times
        self.record.channels[name] = channel.quantity(voltages)

    def _step(self, name: str) -> float:
        """Return the difference of two readings of a channel in its own quantity."""
        channel = self.plan.settings.channels()[name]
        return channel.size(self._resolution[channel.input])

    def _wait(self, done: Callable[[], bool], why: str) -> None:
        end = self.clock.now() + self._length + _MARGIN
        while not done():
            self.check()
            if self.clock.now() > end:
                waited = format_quantity(self._length + _MARGIN, "s", digits=3)
                raise BenchError(f"the oscilloscope {why} after {waited}")
            self.clock.sleep(_POLL)

    work: ClassVar[Mapping[str, Callable[[BurstSequence], object]]] = {
        "identify": _identify,
        "disable": lambda self: self._switch(on=False),
        "zero": lambda self: self.instruments.generator.zero(),
        "burst mode": lambda self: self.instruments.generator.set_burst(),
        "bus trigger": lambda self: self.instruments.generator.set_trigger(),
        "high-impedance load": lambda self: self.instruments.generator.set_load(),
        "waveform": _download,
        "oscilloscope": lambda self: self._set_oscilloscope(self.plan.fraction),
        "read back": lambda self: self._read_back(self.plan.fraction),
        "enable": lambda self: self._switch(on=True),
        "low-voltage burst": lambda self: self._burst("low-voltage burst", self.plan.fraction),
        "compare": _compare_low,
        "raise": _raise,
        "full burst": lambda self: self._burst("full burst", 1.0),
        "records": _read_records,
    }
    """The steps in their order."""


STEPS: Final = tuple(BurstSequence.work)
"""Names of the steps in their order."""
_UNITS: Final = {"voltage": "V", "current": "A"}
READINGS: Final = 2.0
"""Readings of the oscilloscope by which a value may exceed a limit: its resolution and the noise of the last bit."""


def refuse_beyond(plan: BenchPlan, record: RunRecord, name: str, step: float) -> None:
    """Refuse a ``"voltage"`` of the plate, or a ``"current"``, whose peak or root mean square exceeds its limit.

    `step` is the difference of two readings [V or A].
    """
    unit = _UNITS[name]
    values = record.channels[name]
    during = (record.time >= 0) & (record.time <= plan.duration)
    reached = {
        name: float(np.max(np.abs(values))),
        f"rms_{name}": of_record("rms", record.time[during], values[during]),
    }
    for limited, value in reached.items():
        limit = getattr(plan.limits, limited)
        if limit is not None and not value <= limit + READINGS * step:
            raise BenchError(_beyond(record, limited.replace("_", " "), value, limit, step, unit=unit))


def refuse_scaled(plan: BenchPlan, record: RunRecord, *, fraction: float, step: float) -> None:
    """Refuse a full burst whose voltage would exceed its limit, by the voltage read back in the low-voltage burst.

    `fraction` is the peak of that burst over that of the full one, `step` the difference of two readings [V].
    """
    limit = plan.limits.voltage
    assert limit is not None
    reached, resolution = _scale(plan, record, fraction) * plan.peak, step / fraction
    if not reached <= limit + READINGS * resolution:
        scaled = _beyond(
            record, "voltage", reached, limit, resolution, unit="V", verb="scaled to the full burst reaches"
        )
        raise BenchError(f"{scaled}; the full burst is not played")


def _beyond(
    record: RunRecord, name: str, value: float, limit: float, step: float, *, unit: str, verb: str = "reached"
) -> str:
    return (
        f"in the {record.burst} the {name} read back {verb} {format_quantity(value, unit, digits=4)}, above its limit of"
        f" {format_quantity(limit, unit)} (resolution {format_quantity(step, unit, digits=2)})"
    )


def _scale(plan: BenchPlan, record: RunRecord, fraction: float) -> float:
    """Return the voltage that was read back over that of the plan, by least squares."""
    wanted = fraction * plan.voltage(record.time)
    power = float(np.dot(wanted, wanted))
    return float(np.dot(wanted, record.channels["voltage"])) / power if power > 0 else 0.0


def compare(plan: BenchPlan, record: RunRecord, *, fraction: float, step: float) -> list[str]:
    """Compare the voltage that was read back with the plan, and say what was found.

    A run is stopped if scale, shape, or the voltage before the burst differ by more than the tolerance of the
    bench. `fraction` is the peak of the burst over that of the full one, `step` the difference of two
    readings [V].
    """
    times, found = record.time, record.channels["voltage"]
    wanted, peak = fraction * plan.voltage(times), fraction * plan.peak
    tolerance = plan.settings.burst.tolerance
    rest = float(np.mean(found[times < 0])) if (times < 0).any() else float(found[0])
    scale = _scale(plan, record, fraction)
    error = float(np.sqrt(np.mean((found - wanted) ** 2))) / peak
    seen = f"{scale:.4g} times the plan, rms difference {100 * error:.2g} % of the peak"
    if abs(scale - 1) > tolerance:
        hint = (
            " Twice the plan is that of a generator set for a load of 50 ohm, or of another meaning of its amplitude."
            if abs(scale - 2) < 0.2
            else " Check amplifier.gain and oscilloscope.voltage.ratio."
        )
        raise BenchError(f"in the {record.burst} the voltage read back is {seen}.{hint}")
    if error > tolerance:
        raise BenchError(f"in the {record.burst} the voltage read back has another shape: {seen}")
    if abs(rest) > tolerance * peak + READINGS * step:
        raise BenchError(
            f"before the {record.burst} the plate is at {format_quantity(rest, 'V', digits=3)}, where 0 V was expected"
        )
    return [f"{record.burst}: voltage read back {seen}; {format_quantity(rest, 'V', digits=2)} before it"]


def beyond_range(plan: BenchPlan, record: RunRecord, name: str) -> list[str]:
    """State how many readings of a force channel lie beyond the range that is declared for it."""
    channel = plan.settings.channels()[name]
    if not isinstance(channel, ForceInput):
        return []
    values = record.channels[name]
    count = int(np.count_nonzero((values < channel.low) | (values > channel.high)))
    if not count:
        return []
    ends = " to ".join(format_quantity(end, "N") for end in (channel.low, channel.high))
    return [
        f"warning: {count} of {values.size} readings of the {name} force lie beyond {ends} (forces.{name}); they may be clipped"
    ]


def incomplete(path: Path) -> Path:
    """Return the file to which a run that is stopped writes what it has."""
    return path.with_name(f"{path.stem}.incomplete{path.suffix}")


def rehearse(plan: BenchPlan, output: Path | None, about: Mapping[str, str | int | float]) -> None:
    """Save a record of full length beside the output, before anything is enabled: the end works, and there is room."""
    times = np.linspace(0.0, plan.duration, RECORD)
    record = RunRecord(burst="rehearsal", time=times)
    record.channels = dict.fromkeys(plan.settings.channels(), times)
    beside = None if output is None else output.parent
    with tempfile.TemporaryDirectory(prefix=".rehearsal.", dir=beside) as folder:
        place = None if output is None else Path(folder, f"rehearsal{output.suffix}")
        trace, why = saved(plan, record, about, output=place, raw=reserved(plan, place))
    if trace is None:
        raise BenchError(why[0].replace(str(place), str(output)))


def reserved(plan: BenchPlan, output: Path | None) -> Path | None:
    """Make a file of blanks beside the output that holds the room for what is read."""
    if output is None:
        return None
    handle, name = tempfile.mkstemp(prefix=f"{output.stem}.raw.", suffix=".json", dir=output.parent)
    room = _LONGEST_NUMBER * RECORD * (1 + len(plan.settings.channels())) + _LONGEST_TEXTS
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(b" " * room)
            os.fsync(handle)
    except BaseException:
        remove(Path(name))
        raise
    return Path(name)


def tell(sentences: list[str]) -> None:
    """Print sentences on the screen, which may be closed by now."""
    for sentence in sentences:
        with suppress(OSError, ValueError):
            print(f"electrovib: {printable(sentence)}", file=sys.stderr, flush=True)


def saved(
    plan: BenchPlan,
    record: RunRecord,
    about: Mapping[str, str | int | float],
    *,
    output: Path | None,
    raw: Path | None,
    force: bool = False,
    stopped: str = "",
) -> tuple[xarray.Dataset | None, list[str]]:
    """Keep what was read as it is in the file `raw`, until it is saved as a Trace.

    The Trace is returned if it could be made and saved, and in words where the data are, or why not.
    `stopped` is why the run was stopped, empty for a complete one; the file is then that of `incomplete`.
    """
    if output is not None and stopped:
        output = incomplete(output)
    sentences = [] if raw is None else _kept(record, raw)
    written: list[Path] = []
    try:
        trace = trace_of(plan, record, about=about, stopped=stopped)
        if output is not None:
            written = save(trace, output, force=force)
    except Exception as error:  # noqa: BLE001  # what was read is kept, whatever fails
        return None, [f"the data could not be written as a Trace: {_reason(error)}", *sentences]
    remove(raw)
    which = "the data so far" if stopped else "the data"
    return trace, [f"{which}: {', '.join(map(str, written))}"] if written else []


def _kept(record: RunRecord, raw: Path) -> list[str]:
    """Write what was read as numbers and texts into the room that is kept for it; say where it is, or why not."""
    try:
        text = json.dumps(asdict(record), default=np.ndarray.tolist).encode()
        with os.fdopen(
            os.open(raw, os.O_WRONLY | os.O_CREAT), "wb"
        ) as file:  # "wb" alone would give the room back
            file.write(text)
            file.truncate()
    except Exception as error:  # noqa: BLE001  # the Trace is tried in any case
        return [f"what was read could not be written either: {_reason(error)}"]
    return [f"what was read is kept as it is: {raw}"]


def remove(raw: Path | None) -> None:
    """Remove the file for what is read, where there is one."""
    if raw is not None:
        with suppress(OSError):
            raw.unlink()


def _reason(error: Exception) -> str:
    return (
        "; ".join(error.problems)
        if isinstance(error, ElectrovibError)
        else f"{type(error).__name__}: {error}"
    )


_TIMES: Final = 1001
"""Times at which the plan is written where nothing was recorded."""


def trace_of(
    plan: BenchPlan, record: RunRecord, *, about: Mapping[str, str | int | float], stopped: str = ""
) -> xarray.Dataset:
    """Make a Trace of a run from the trigger on, complete or, for the reason `stopped`, not.

    It has the planned ``drive_voltage``, and what was read back. The voltage before the trigger is stated in
    the attribute ``comparisons``.
    """
    after = record.time >= 0
    if after.any() and record.channels:
        times, fraction = record.time[after], plan.fraction if record.burst.startswith("low") else 1.0
        channels = {name: values[after] for name, values in record.channels.items()}
    else:
        times, fraction, channels = np.linspace(0.0, plan.duration, _TIMES), 1.0, {}
    names = _signals(plan)
    variables: dict[str, Any] = {"drive_voltage": (("time",), fraction * plan.voltage(times))}
    variables |= {names[name]: (("time",), values) for name, values in channels.items()}
    trace = make_trace(variables, {"time": times}, _attributes(plan, record, stopped) | dict(about))
    if "voltage" in channels:
        trace["plate_voltage"].attrs["calibration"] = (
            f"ratio {plan.settings.oscilloscope.voltage.ratio:g} V/V"
        )
    for name, force in (("lateral", plan.settings.forces.lateral), ("normal", plan.settings.forces.normal)):
        if force is not None and name in channels:
            trace[names[name]].attrs["calibration"] = f"{force.sensitivity:g} N/V, zero {force.zero:g} V"
    return trace


def _signals(plan: BenchPlan) -> dict[str, str]:
    """Return the name of the signal of each channel: with a rig the scenario predicts the readings of its sensors."""
    reading = "_measured" if plan.scenario.rig is not None else ""
    return {
        "voltage": "plate_voltage",
        "current": "amplifier_current",
        "lateral": f"lateral_force{reading}",
        "normal": f"normal_force{reading}",
    }


def _attributes(plan: BenchPlan, record: RunRecord, stopped: str) -> dict[str, Any]:
    limiter = plan.settings.current_limiter
    stated = provenance(plan.scenario)
    return {
        "title": f"Bench: {plan.scenario.titled()}",
        "electrovib": stated["electrovib"],
        "planned_scenario": stated["scenario"],
        "planned_scenario_hash": stated["scenario_hash"],
        "bench": json.dumps(plan.settings.to_dict()),
        "limits": json.dumps(plan.limits.to_dict()),
        "check": json.dumps(plan.check.to_dict()),
        "validity": json.dumps([each.to_dict() for each in plan.diagnostics]),
        "current_limiter": f"{limiter.name}, {limiter.current:g} A (declared, hardware)",
        "instruments": json.dumps(record.instruments),
        "settings": json.dumps(record.settings),
        "steps": json.dumps(record.steps),
        "burst": record.burst,
        "comparisons": json.dumps(record.statements),
        "resampling_error": plan.resampling_error,
        "complete": int(not stopped),
        "stopped": stopped,
    }
