"""A stop at any moment of a run, also inside an import: 0 V, output off, the sentence, and the data; only then anything else."""

import errno
import itertools
import json
import os
import signal
import subprocess
import sys
import tempfile
import weakref

import numpy as np
import pytest

import electrovib as ev
from electrovib.bench import run, sequence
from electrovib.bench.link import BenchError, BenchStopped, Link
from electrovib.bench.sequence import STEPS
from electrovib.bench.settings import Instruments
from electrovib.bench.twin.generator import TwinInstrument

SCENARIO = "vezzoli_2014/fig6"
SIGNALS = {"SIGINT": KeyboardInterrupt, "SIGTERM": BenchStopped, "SIGHUP": BenchStopped}
BY_HAND = "simulated: the generator is at 0 V; SWITCH THE HIGH VOLTAGE OFF BY HAND"
DISABLED = "simulated: the generator is at 0 V, and the high voltage is disabled"
END = {
    "0 V": (Instruments, "to_zero"), "sentence": (run, "tell"), "as read": (sequence, "_kept"), "Trace": (sequence, "trace_of"),
    "save": (sequence, "save"), "close": (Link, "close"),
}  # fmt: skip
"""What the end of a run calls."""


class Late(BaseException):
    """A signal that reached the process after the run had given its handlers back."""


@pytest.fixture
def played(tmp_path, twin_in_place, at_zero):
    """Run on the simulated bench among handlers of the process; return what was raised or returned, and the twin."""

    def late(number, _):
        raise Late(signal.Signals(number).name)

    def call(*, with_enable=True, output="t.nc", report=None):
        twins = twin_in_place(with_enable=with_enable)
        before = {number: signal.signal(number, late) for number in map(signal.Signals.__getitem__, SIGNALS)}
        path = None if output is None else tmp_path / output
        try:
            found = ev.run_bench(SCENARIO, simulate=True, output=path, report=report)
        except BaseException as error:  # noqa: BLE001  # also a signal
            found = error
        finally:
            for number, former in before.items():
                signal.signal(number, former)
        assert at_zero(twins[0])
        return found, twins[0]

    return call


def moments():
    """Every moment with SIGTERM, and the most dangerous ones and the end with every signal; the others are slow."""
    for name in SIGNALS:
        for moment in (*STEPS, *END):
            quick = moment in END or moment in {"enable", "full burst"}
            marks = [] if quick and name == "SIGINT" else [pytest.mark.slow]
            yield pytest.param(name, moment, marks=marks)


@pytest.mark.parametrize(("name", "moment"), list(moments()))
def test_a_stop_ends_with_0_v_the_sentence_and_the_data(played, tmp_path, monkeypatch, capsys, name, moment):
    seen = []

    def stop(at):
        seen.append(at)
        if at == moment and (at in STEPS or STEPS[-1] in seen):  # the end is rehearsed before the first step
            os.kill(os.getpid(), signal.Signals[name])

    def injected(at, original):
        def call(*arguments, **named):
            stop(at)
            return original(*arguments, **named)

        return call

    for at, (owner, function) in END.items():
        monkeypatch.setattr(owner, function, injected(at, getattr(owner, function)))
    found, twin = played(report=stop)
    assert not twin.plant.is_on
    said = capsys.readouterr().err
    assert DISABLED in said
    if moment not in STEPS:
        assert seen.pop() == "sentence", "that the run was complete, after everything else"
    assert [at for at in dict.fromkeys(reversed(seen)) if at in END] == list(reversed(END)), "in this order"
    if moment in STEPS:
        assert type(found) is SIGNALS[name]
        assert f"stopped in the step '{moment}'" in str(found)
        assert json.loads(ev.open_trace(tmp_path / "t.incomplete.nc").attrs["steps"])[-1] == moment
    else:  # everything was played: the signal is sent again once the data are saved
        assert isinstance(found, Late)
        assert str(found) == name
        assert ev.open_trace(tmp_path / "t.nc").attrs["complete"] == 1
        assert f"the data: {tmp_path / 't.nc'}" in said
    assert not list(tmp_path.glob("*.raw.*")), "the Trace holds what was read"


@pytest.mark.parametrize("broken", ["trace_of", "save"])
@pytest.mark.parametrize("step", ["compare", None])
def test_what_was_read_is_kept_where_no_trace_can_be_made(
    played, tmp_path, monkeypatch, capsys, broken, step
):
    def report(name):
        monkeypatch.setattr(sequence, broken, fail)
        if name == step:
            raise KeyboardInterrupt

    def fail(*_, **__):
        raise MemoryError("injected")

    found, _ = played(report=report, with_enable=False)
    assert type(found) is (KeyboardInterrupt if step else BenchError)
    assert BY_HAND in str(found)
    assert BY_HAND in capsys.readouterr().err
    (raw,) = tmp_path.iterdir()
    said = "; ".join(str(found).split("\n"))
    assert f"written as a Trace: MemoryError: injected; what was read is kept as it is: {raw}" in said
    content = json.loads(raw.read_text("utf-8"))
    assert content["burst"] == ("low-voltage burst" if step else "full burst")
    assert max(content["channels"]["voltage"]) == pytest.approx(20 if step else 1000, rel=0.1)
    assert len(content["time"]) == len(content["channels"]["voltage"])


def test_an_end_that_cannot_work_is_found_before_anything_is_sent(played, monkeypatch):
    def fail(*_, **__):
        raise ImportError("no netCDF here")

    monkeypatch.setattr(sequence, "save", fail)
    found, twin = played()
    assert type(found) is BenchError
    assert "no netCDF here" in str(found)
    assert not twin.generator.received


def full(*_, **__):
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


FULL = [(os, "fsync"), (tempfile, "mkdtemp"), (tempfile, "mkstemp"), (sequence, "save")]


@pytest.mark.parametrize(("what", "name"), FULL, ids=[name for _, name in FULL])
def test_on_a_full_disk_nothing_is_played(played, tmp_path, monkeypatch, what, name):
    monkeypatch.setattr(what, name, full)
    found, twin = played()
    assert type(found) is BenchError
    assert "No space left" in str(found)
    assert name == "save" or str(found).startswith(
        f"{tmp_path / 't.nc'}: the record cannot be written there: "
    )
    assert not twin.generator.received
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", [".nc", ".csv", ".mat"])
def test_a_disk_that_fills_during_the_burst_keeps_what_was_read(played, tmp_path, monkeypatch, suffix):
    rooms = []

    def report(step):
        rooms.extend(each.stat().st_size for each in tmp_path.iterdir())
        if step == "full burst":
            monkeypatch.setattr(sequence, "save", full)
            monkeypatch.setattr(tempfile, "mkstemp", full)

    found, _ = played(report=report, output=f"t{suffix}")
    assert type(found) is BenchError
    (raw,) = tmp_path.iterdir()
    assert f"what was read is kept as it is: {raw}" in str(found)
    content = json.loads(raw.read_text("utf-8"))
    assert max(content["channels"]["voltage"]) == pytest.approx(1000, rel=0.1)
    assert len(rooms) == len(STEPS)
    assert raw.stat().st_size < min(rooms)


def test_the_room_holds_the_longest_numbers(plan, tmp_path):
    room = sequence.reserved(plan(), tmp_path / "t.nc")
    size, numbers = room.stat().st_size, np.full(10_000, -1.2345678901234567e-100)
    record = sequence.RunRecord(steps=list(STEPS), settings={"WAVF?": "x" * 10_000}, time=numbers)
    record.channels = dict.fromkeys(plan().settings.channels(), numbers)
    sequence._kept(record, room)
    assert 0.5 * size < room.stat().st_size < size


def test_what_keeps_the_room_goes_where_no_instrument_answers(played, tmp_path, monkeypatch):
    def unreachable(*_):
        raise BenchError("no instrument answers")

    monkeypatch.setattr(Instruments, "of", unreachable)
    found, _ = played()
    assert "no instrument answers" in str(found)
    assert not list(tmp_path.iterdir())


def lost(name):
    """Send a signal whose exception Python only prints: it is raised in a callback of the collection of an object."""

    class Object:
        pass

    kept = Object()
    reference = weakref.ref(kept, lambda _: [os.kill(os.getpid(), signal.Signals[name]), sum(range(10))])
    del kept
    assert reference() is None


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("name", SIGNALS)
def test_a_stop_whose_exception_is_lost_ends_the_run_in_the_same_step(played, name):
    found, twin = played(report=lambda step: lost(name) if step == "full burst" else None)
    assert type(found) is SIGNALS[name]
    assert "stopped in the step 'full burst'" in str(found)
    assert twin.generator.received.count("*TRG") == 1
    assert not twin.plant.is_on


def test_an_import_that_fails_because_it_is_interrupted_is_an_interrupt(played):
    def report(step):
        if step == "enable":
            try:
                os.kill(os.getpid(), signal.SIGINT)
            except KeyboardInterrupt:
                raise ImportError("a compiled library") from None

    found, _ = played(report=report)
    assert type(found) is KeyboardInterrupt
    assert "interrupted by the operator; an unexpected error, ImportError: a compiled library" in str(found)


@pytest.mark.parametrize(("with_enable", "sentence"), [(True, DISABLED), (False, BY_HAND)])
def test_a_complete_run_states_how_the_bench_was_left(played, monkeypatch, capsys, with_enable, sentence):
    """Connections that cannot be closed change nothing."""

    def fail(_):
        raise RuntimeError("the session is invalid")

    monkeypatch.setattr(TwinInstrument, "close", fail)
    found, twin = played(with_enable=with_enable, output=None)
    assert (found.attrs["complete"], found.attrs["left"]) == (1, sentence)
    switched = [on for _, on in twin.plant._switched]
    assert switched.count(True) == 2
    assert (True, True) not in itertools.pairwise(switched), "off while the amplitude changes"
    assert f"electrovib: {sentence}\n" in capsys.readouterr().err


STOPPED = """
import os, signal, sys
from electrovib.bench import sequence

moment, number, seen = sys.argv[1], int(sys.argv[2]), []
begin = sequence.BurstSequence._begin


class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == moment and (seen or name != "cftime"):
            os.kill(os.getpid(), number)


def begun(run, name):
    begin(run, name)
    seen.append(name)
    if name == moment:
        os.kill(os.getpid(), number)


sys.meta_path.insert(0, Finder())
sequence.BurstSequence._begin = begun
sys.argv[:] = ["electrovib", "bench", "run", *sys.argv[3:]]
from electrovib.apps import start
start.main()
"""
"""The command, with a signal in an import or a step."""
BEFORE = ("pandas._libs.lib", "xarray.core", "h5netcdf", "h5py._hl.files")
"""Modules that the end needs."""


@pytest.mark.parametrize(
    ("name", "moment"),
    [
        pytest.param(
            name, moment, marks=() if (name, moment) == ("SIGINT", "full burst") else pytest.mark.slow
        )
        for name in SIGNALS
        for moment in (*BEFORE, "cftime", "full burst")
    ],
)
def test_the_last_line_of_a_stopped_command_states_the_bench_and_the_data(tmp_path, name, moment):
    """All that the end needs is imported before anything is sent; what is imported later (cftime) is stopped as a step is."""
    arguments = [SCENARIO, "--simulate", "-o", "t.nc"]
    number = signal.Signals[name].value
    done = subprocess.run(
        [sys.executable, "-c", STOPPED, moment, str(number), *arguments],
        cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    assert done.returncode == (130 if name == "SIGINT" else 143), done.stderr
    last = done.stderr.splitlines()[-1]
    assert "half written" not in done.stderr
    if moment in BEFORE:
        assert "stopped before anything was sent to an instrument" in last
        assert last.endswith("the bench is as it was: SWITCH THE HIGH VOLTAGE OFF BY HAND if it is on")
        assert "step: " not in done.stdout
        assert not list(tmp_path.iterdir())
        return
    assert "stopped in the step '" in last
    assert last.endswith(f"{BY_HAND}; the data so far: t.incomplete.nc")
    assert ev.open_trace(tmp_path / "t.incomplete.nc").attrs["left"] == BY_HAND
