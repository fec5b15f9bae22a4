"""A drive played on a bench, real or simulated, and recorded."""

from __future__ import annotations

import hashlib
import logging
import signal
import tempfile
import threading
from contextlib import ExitStack, contextmanager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from electrovib.bench.link import BenchError, BenchStopped, SystemClock, connect
from electrovib.bench.plan import BenchPlan, make_plan
from electrovib.bench.sequence import (
    BurstSequence,
    incomplete,
    rehearse,
    remove,
    reserved,
    saved,
    tell,
)
from electrovib.bench.settings import BenchSettings, Instruments, read_settings
from electrovib.bench.twin.simulated import SimulatedBench
from electrovib.core.deprecation import former_value
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.core.files import inputs_noted
from electrovib.core.units import format_quantity
from electrovib.data.atomic import HeldError, held
from electrovib.exports.save import check_output
from electrovib.scenario import Source, read_scenario
from electrovib.scenario.space.relations import checked_seed

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping
    from types import FrameType

    import xarray

    from electrovib.bench.link import BenchClock, Connection

_LOG: Final = logging.getLogger("electrovib.bench")


def plan_bench(
    scenario: Source,
    *,
    bench: str | Path | Mapping[str, Any] | BenchSettings | None = None,
    set: Mapping[str, Any] | None = None,  # noqa: A002  # the name of the option
) -> BenchPlan:
    """Plan a run on a bench; nothing is sent to any instrument.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        Experiment, as for `electrovib.load`; its drive is what would be played.
    bench : str, Path, mapping or BenchSettings, optional
        Bench file, tables or settings; by default the set-up of Vezzoli et al. 2014.
    set : mapping of str to value, optional
        Changes of the scenario by dotted path.

    Returns
    -------
    BenchPlan
        Its `lines` state the plan in words.

    Raises
    ------
    InputError
        If the drive is not a finite voltage from 0 V to 0 V, or exceeds a limit, or a declaration for safety is missing.

    Examples
    --------
    >>> f"{1e3 * ev.plan_bench('vezzoli_2014/fig6').duration:.0f} ms"
    '272 ms'
    """
    return make_plan(read_scenario(scenario, changes=set), read_settings(bench))


def run_bench(
    scenario: Source,
    *,
    bench: str | Path | Mapping[str, Any] | BenchSettings | None = None,
    simulate: bool = False,
    arm: bool = False,
    finger: Source | None = None,
    seed: int = 0,
    set: Mapping[str, Any] | None = None,  # noqa: A002  # the name of the option
    output: str | Path | None = None,
    force: bool = False,
    confirm: Callable[[str], bool] | None = None,
) -> xarray.Dataset:
    """Play the drive of a scenario as one finite burst on a bench and record the forces.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        Experiment, as for `electrovib.load`; its drive, times the gain of its own amplifier, is the voltage of the plate.
    bench : str, Path, mapping or BenchSettings, optional
        Bench file, tables or settings; by default the set-up of Vezzoli et al. 2014.
    simulate : bool
        Whether simulated instruments are used, in simulated time.
    arm : bool
        Whether real instruments may be used; without it and without `simulate` nothing is played.
    finger : str, Path, mapping, Scenario or xarray.Dataset, optional
        The finger of the simulated set-up; by default that of the scenario.
    seed : int
        Seed of the noise of the simulated set-up.
    set : mapping of str to value, optional
        Changes of the scenario by dotted path.
    output : str or Path, optional
        Output file: ``.nc``, ``.csv`` or ``.mat``. A run that is stopped writes what it has to
        ``<name>.incomplete<suffix>`` instead.
    force : bool
        Whether a file that electrovib did not write may be replaced.
    confirm : callable, optional
        Asks the operator of a set-up without an enable line to do something, and returns whether it was confirmed.

    Returns
    -------
    xarray.Dataset
        A Trace from the trigger on, with instruments, settings as read back, limits, the current limiter declared, and how the
        bench was left (attribute ``left``, also printed): without an enable line, to be switched off by hand.

    Raises
    ------
    InputError
        Before anything is sent: if the plan is refused, or neither `simulate` nor `arm` is given.
    BenchError
        If the run was stopped; the message has the reason, the state of the bench, and the file with the data so far.

    Notes
    -----
    The bench is left at 0 V, and disabled where it has an enable line, after the end, an error, a lost connection, Ctrl-C,
    SIGTERM and SIGHUP. After SIGKILL the burst that is running ends at 0 V by itself. Software does not protect a person: the
    hardware that limits the current does.

    The logger ``electrovib.bench`` is told the name of each step before it begins.

    Examples
    --------
    >>> trace = ev.run_bench("vezzoli_2014/fig6", simulate=True)  # a simulated bench and finger
    >>> sorted(trace.data_vars)
    ['amplifier_current', 'drive_voltage', 'lateral_force', 'normal_force', 'plate_voltage']
    """
    checked_seed(seed)
    with inputs_noted() as inputs:
        plan = plan_bench(scenario, bench=bench, set=set)
        own = plan.scenario if finger is None else read_scenario(finger, changes=set)
    if simulate == arm:
        raise InputError(
            "give either simulate=True (--simulate) for a simulated set-up, or arm=True (--arm) for real instruments;"
            f" {'both were given' if arm else 'without them only the plan is shown'}"
        )
    if output is not None:
        check_output(output, {"time": 1}, inputs=inputs, force=force, shown=False)
        check_output(incomplete(Path(output)), {"time": 1}, inputs=inputs, force=force, shown=False)
    report = former_value("report", None) or _LOG.info
    if simulate:
        twin = SimulatedBench(plan.settings, own, seed=seed)
        run = BenchRun(plan, twin.connections, twin.clock, twin.operate, report)
        about: dict[str, Any] = {"simulated": 1, "seed": seed, "simulated_finger": own.to_json()}
        lock: Any = nullcontext("")
    else:
        if plan.settings.amplifier.enable is None and confirm is None:
            raise InputError(
                "amplifier.enable: without an enable line an operator has to confirm the steps; pass confirm, or add the line"
            )
        run = BenchRun(plan, None, SystemClock(), confirm or (lambda _: False), report)
        about, lock = {"simulated": 0}, one_process(plan.settings.resources)
    with lock as left:
        if left:
            run.notes.append(f"the last run on this bench was killed ({left})")
        return run.play(output=None if output is None else Path(output), force=force, about=about)


@dataclass
class BenchRun:
    """One run: the sequence of steps, and what is done however it ends.

    Without `connections`, by role, it connects to the addresses of the bench file. `confirm` asks the
    operator; `report` is called with the name of each step.
    """

    plan: BenchPlan
    connections: Mapping[str, Connection] | None
    clock: BenchClock
    confirm: Callable[[str], bool]
    report: Callable[[str], object]
    notes: list[str] = field(default_factory=list)

    def play(
        self, *, output: Path | None, force: bool, about: Mapping[str, str | int | float]
    ) -> xarray.Dataset:
        """Play and record; whatever happens, take the bench to 0 V and save what was read."""
        about = dict(about) | ({"notes": "; ".join(self.notes)} if self.notes else {})
        with stopping_signals() as stops:
            instruments, raw = self._prepared(output, about, stops)
            sequence = BurstSequence(
                self.plan, instruments, self.clock, self.confirm, stops.check, self.report
            )
            stopped = _played(sequence, stops)
            failures = instruments.to_zero()
            left = self._left(failures, is_simulated=bool(about["simulated"]))
            tell(left)
            sentences = []
            if stopped is not None or failures:
                step = sequence.record.steps[-1] if sequence.record.steps else "connect"
                sentences = [f"stopped in the step '{step}': {_why(stopped)}", *left]
            about["left"] = "; ".join(left)
            why = "; ".join(sentences)
            trace, kept = saved(
                self.plan, sequence.record, about, output=output, raw=raw, force=force, stopped=why
            )
            instruments.close()
            if sentences or trace is None:
                raise _stopped(stopped, [*(sentences or left), *kept]) from stopped
            if stops.first is not None:  # the signal is sent again, and nothing is printed after it
                tell(["the run was complete when it was asked to end", *kept])
            return trace

    def _prepared(
        self, output: Path | None, about: Mapping[str, str | int | float], stops: Stops
    ) -> tuple[Instruments, Path | None]:
        """Rehearse the end, keep room for what is read, and connect; nothing is sent."""
        raw = None
        try:
            try:
                rehearse(self.plan, output, about)
                raw = reserved(self.plan, output)
            except OSError as error:
                why = f"the record cannot be written there: {error.strerror or error}; nothing was sent to an instrument"
                raise BenchError(why, path=output) from None
            connections = self.connections or connect(self.plan.settings.resources)
            return Instruments.of(self.plan.settings, connections), raw
        except BaseException as error:
            remove(raw)
            stopped = _asked(error, stops)
            if not isinstance(stopped, (KeyboardInterrupt, BenchStopped)):
                raise
            why = f"stopped before anything was sent to an instrument: {_why(stopped)}"
            as_it_was = "the bench is as it was: SWITCH THE HIGH VOLTAGE OFF BY HAND if it is on"
            raise _stopped(stopped, [why, as_it_was]) from stopped

    def _left(self, failures: list[str], *, is_simulated: bool) -> list[str]:
        """State how the bench was left."""
        where = "simulated: " if is_simulated else ""
        if not failures:
            by_hand = self.plan.settings.amplifier.enable is None
            enabled = (
                "; SWITCH THE HIGH VOLTAGE OFF BY HAND" if by_hand else ", and the high voltage is disabled"
            )
            return [f"{where}the generator is at 0 V{enabled}"]
        burst = format_quantity(self.plan.duration, "s", digits=3)
        return [
            *failures,
            f"{where}SWITCH THE HIGH VOLTAGE OFF BY HAND; a burst that was running has ended at 0 V within {burst}",
        ]


def _played(sequence: BurstSequence, stops: Stops) -> BaseException | None:
    """Play, and hold all signals from then on; return what stopped it."""
    stopped: BaseException | None = None
    try:
        try:
            sequence.play()
        except BaseException as error:  # noqa: BLE001  # every end leads to 0 V
            stopped = error
        stops.is_held = True
    except BaseException as error:  # noqa: BLE001  # a signal before it was held; there is no second one
        stops.is_held = True
        stopped = stopped or error
    return stopped and _asked(stopped, stops)


def _asked(error: BaseException, stops: Stops) -> BaseException:
    """Return the exception of the signal that an error follows from, as of an import that was interrupted, or the error."""
    asked = stops.error()
    if asked is None or isinstance(error, type(asked)):
        return error
    asked.__cause__ = error
    return asked


def _why(error: BaseException | None) -> str:
    if error is None:
        return "the run was complete, but its end could not be confirmed"
    if isinstance(error, ElectrovibError):
        return "; ".join(error.problems)
    if isinstance(error, (BenchStopped, KeyboardInterrupt)):
        by = f"the process was asked to end ({error})" if str(error) else "interrupted by the operator"
        return by if error.__cause__ is None else f"{by}; {_why(error.__cause__)}"
    return f"an unexpected error, {type(error).__name__}: {error}"


def _stopped(error: BaseException | None, sentences: list[str]) -> BaseException:
    if isinstance(error, KeyboardInterrupt):
        return KeyboardInterrupt("; ".join(sentences))
    if isinstance(error, BenchStopped):
        return BenchStopped("; ".join(sentences))
    return BenchError(sentences)


def lock_file(resources: Mapping[str, str]) -> Path:
    """Return the file of the lock of a bench with these addresses."""
    key = hashlib.sha256("\n".join(sorted(resources.values())).encode()).hexdigest()[:16]
    return Path(tempfile.gettempdir()) / f"electrovib-bench-{key}.lock"


@contextmanager
def one_process(resources: Mapping[str, str]) -> Iterator[str]:
    """Hold the lock of a bench; yield what a run that was killed left, or ""."""
    path = lock_file(resources)
    with ExitStack() as stack:
        try:
            left = stack.enter_context(held(path))
        except HeldError as error:
            who = f"{error}, " if str(error) else ""
            raise BenchError(
                f"another process uses this bench ({who}lock {path}); wait until it has ended, there is no option to override"
                " this"
            ) from None
        yield f"running, {left}" if left else ""


_STOPPING: Final = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")
_REPEATED: Final = "SIGALRM"
"""The command line repeats an interrupt by it."""


class Stops:
    """What has asked the process to end while a bench is in use: the first signal raises once, later ones only wait.

    An exception in a signal handler can be lost: Python only prints what a callback raises, and a compiled
    library whose import is interrupted raises an ImportError instead. So the signal is kept too, and `check`
    raises for it again.
    """

    def __init__(self) -> None:
        self.first: signal.Signals | None = None
        self.is_held = False

    def received(self, number: int, frame: FrameType | None) -> None:
        """Keep the first signal and raise for it, unless signals are held."""
        del frame
        if self.first is None:
            self.first = signal.Signals(number)
            self.check()

    def check(self) -> None:
        """Raise if the process was asked to end."""
        error = self.error()
        if error is not None and not self.is_held:
            raise error

    def error(self) -> KeyboardInterrupt | BenchStopped | None:
        """Return the exception of the first signal, or None."""
        if self.first is None:
            return None
        return KeyboardInterrupt() if self.first == signal.SIGINT else BenchStopped(self.first.name)


@contextmanager
def stopping_signals() -> Iterator[Stops]:
    """Raise KeyboardInterrupt or `BenchStopped` at the first signal that asks the process to end, and keep it.

    With `is_held` set nothing is raised any more. A signal that came then, or whose exception was lost, is
    sent again after the block, unless the block raises. Only the main thread receives signals; in another one
    nothing is changed.
    """
    stops = Stops()
    if threading.current_thread() is not threading.main_thread():
        yield stops
        return
    known = [getattr(signal, name) for name in (*_STOPPING, _REPEATED) if hasattr(signal, name)]
    before = {number: signal.getsignal(number) for number in known}
    repeated = before.get(getattr(signal, _REPEATED, None))

    def again(number: int, frame: FrameType | None) -> None:
        if not stops.is_held and callable(repeated):
            repeated(number, frame)

    try:
        for number in known:
            signal.signal(number, again if number.name == _REPEATED else stops.received)
        yield stops
    finally:
        for number, former in reversed(before.items()):  # SIGINT last: its handler may raise at once
            signal.signal(number, former)
    if stops.first is not None:
        signal.raise_signal(stops.first)
