"""Begin and end of a command: its budget, and Ctrl-C at any time."""

import contextlib
import os
import re
import signal
import subprocess
import sys
import time
import urllib.request

import pytest

from electrovib.apps import run as runs
from electrovib.apps import start

RUN = [sys.executable, "-m", "electrovib", "run", "vezzoli_2014/fig6"]
NOTHING_LEFT = "electrovib: interrupted, nothing was left half written\n"


def test_every_command_refuses_what_takes_too_much_by_option_or_environment(refused, said, monkeypatch):
    for command in ("run vezzoli_2014/fig6", "compare vezzoli_2014/fig6", "export vezzoli_2014/fig6 a.cir"):
        err = refused(f"--budget '1 us, 1 kB' {command}")
        assert "would take about" in err
        assert "allowed are 1e-06 s and 0.001 MB" in err
    monkeypatch.setenv("ELECTROVIB_BUDGET", "1 us")
    assert "allowed are 1e-06 s and 4 GB" in refused("run")
    monkeypatch.delenv("ELECTROVIB_BUDGET")
    said("run")
    sentence = "--budget = a lot: expected a time above 0 such as '30 min', or a memory such as '8 GB'"
    assert refused("--budget 'a lot' run") == f"electrovib: {sentence}\n"


def test_an_interrupt_is_told_and_leaves_nothing(cli, here, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(runs, "simulate", interrupted)
    assert cli("run -o out.nc") == (130, "", NOTHING_LEFT)
    assert list(here.iterdir()) == []


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="a signal to another process is a matter of POSIX")
def test_an_interrupt_is_answered_by_one_sentence_at_any_moment():
    """From the first import to the last line: a sentence, or nothing where the command was through.

    Either code is what a shell calls 130: Python itself ends by the signal where it met it in the import system.
    """
    begin, told = time.monotonic(), []
    # before that, Python itself reports it
    subprocess.run([sys.executable, "-c", "import typing, pathlib"], check=True)
    first = 0.05 + 2 * (time.monotonic() - begin)
    for share in range(30):
        process = subprocess.Popen(RUN, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        time.sleep(first + 0.04 * share)
        process.send_signal(signal.SIGINT)
        err = process.communicate(timeout=60)[1]
        assert process.returncode in (start.INTERRUPTED, -signal.SIGINT, 0), err
        assert err in ("", "electrovib: interrupted before anything was done\n", NOTHING_LEFT)
        told.append(bool(err))
    assert any(told)


@pytest.fixture
def signals_kept():
    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGALRM)
    yield
    start._be_silent()
    signal.signal(signal.SIGINT, before[0])
    signal.signal(signal.SIGALRM, before[1])


@pytest.mark.parametrize("is_interrupted", [True, False])
def test_an_import_that_turns_an_interrupt_into_an_error_is_answered_likewise(
    monkeypatch, capsys, signals_kept, is_interrupted
):
    def command_line():
        with contextlib.suppress(KeyboardInterrupt):
            if is_interrupted:
                start._interrupt(signal.SIGINT, None)
        raise ImportError("numpy._core.multiarray failed to import")

    monkeypatch.setattr("electrovib.apps.cli.main", command_line)
    monkeypatch.setattr(start, "_INTERRUPTS", [])
    with pytest.raises(SystemExit if is_interrupted else ImportError) as stop:
        start.main()
    assert capsys.readouterr().err == (NOTHING_LEFT if is_interrupted else "")
    assert not is_interrupted or stop.value.code == start.INTERRUPTED


def test_an_interrupt_that_a_callback_swallows_comes_again(monkeypatch, signals_kept):
    """Python only prints an exception of a callback: the interrupt would be lost."""
    monkeypatch.setattr(start, "_AGAIN", 0.05)
    with contextlib.suppress(KeyboardInterrupt):
        start._interrupt(signal.SIGINT, None)
    with pytest.raises(KeyboardInterrupt):
        time.sleep(5)


@pytest.mark.slow
def test_page_ends_with_a_sentence_and_without_a_fault():
    pytest.importorskip("nicegui")
    command = [sys.executable, "-m", "electrovib", "explore", "bau_2010/sine", "--no-browser"]
    ours = {"PYTEST_CURRENT_TEST", "PYTHONUNBUFFERED"}
    plain = {name: value for name, value in os.environ.items() if name not in ours}
    page = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=plain)
    address = re.search(r"http://\S+", page.stdout.readline())
    for _ in range(100):
        try:
            urllib.request.urlopen(address[0], timeout=20).read()
            break
        except OSError:
            time.sleep(0.2)
    page.send_signal(signal.SIGINT)
    out, err = page.communicate(timeout=30)
    assert (page.returncode, out, err) == (0, "The page is closed.\n", "")
