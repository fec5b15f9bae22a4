"""Begin and end of a command: its imports, its budget, and Ctrl-C at any time."""

from __future__ import annotations

import contextlib
import signal
import subprocess
import sys
import time

import pytest

from electrovib.apps import start
from electrovib.apps.cli import main

RUN = [sys.executable, "-m", "electrovib", "run", "vezzoli_2014/fig6"]


@pytest.fixture
def cli(tmp_path, capsys, monkeypatch):
    """Return a function that runs a command in this process: exit code, output and error output."""
    monkeypatch.chdir(tmp_path)

    def call(*arguments):
        monkeypatch.setattr(sys, "argv", ["electrovib", *arguments])
        with pytest.raises(SystemExit) as stop:
            main()
        out, err = capsys.readouterr()
        return int(stop.value.code or 0), out, err

    return call


@pytest.mark.parametrize("command", ["run", "compare", "export"])
def test_every_command_refuses_what_takes_too_much(cli, command, tmp_path):
    output = [str(tmp_path / "netlist.cir")] if command == "export" else []
    scenario = ["vardar_2017/sine"] if command == "perceive" else ["vezzoli_2014/fig6"]
    code, _, err = cli("--budget", "1 us, 1 kB", command, *scenario, *output)
    assert code == 2
    assert "would take about" in err
    assert "allowed are 1e-06 s and 0.001 MB" in err
    assert not [*tmp_path.iterdir()]


def test_the_budget_may_stand_in_the_environment(cli, monkeypatch):
    monkeypatch.setenv("ELECTROVIB_BUDGET", "1 us")
    assert "allowed are 1e-06 s and 4 GB" in cli("run")[2]
    monkeypatch.delenv("ELECTROVIB_BUDGET")
    assert cli("run")[0] == 0


def test_a_budget_that_is_none_is_told(cli):
    code, _, err = cli("--budget", "a lot", "run")
    assert (code, err) == (
        2,
        "electrovib: --budget = a lot: expected a time above 0 such as '30 min', or a memory such as '8 GB'\n",
    )


def interrupted(after):
    """Return exit code and error output of a run that is interrupted some time [s] after its start."""
    process = subprocess.Popen(RUN, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    time.sleep(after)
    process.send_signal(signal.SIGINT)
    err = process.communicate(timeout=60)[1]
    return process.returncode, err


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="a signal to another process is a matter of POSIX")
def test_an_interrupt_is_answered_by_one_sentence_at_any_moment():
    """From the first import to the last line: a sentence, or nothing where the command was through.

    Either code is what a shell calls 130: Python itself ends by the signal where it met it in the import system.
    """
    begin = time.monotonic()
    subprocess.run(
        [sys.executable, "-c", "import typing, pathlib"], check=True
    )  # before that, Python itself reports it
    first = 0.05 + 2 * (time.monotonic() - begin)
    told = []
    for share in range(30):
        code, err = interrupted(first + 0.04 * share)
        assert code in (start.INTERRUPTED, -signal.SIGINT, 0), err
        assert err in (
            "",
            "electrovib: interrupted before anything was done\n",
            "electrovib: interrupted, nothing was left half written\n",
        )
        told.append(bool(err))
    assert any(told)


@pytest.mark.parametrize("is_interrupted", [True, False])
def test_an_import_that_turns_an_interrupt_into_an_error_is_answered_likewise(
    monkeypatch, capsys, is_interrupted
):
    def command_line():
        try:
            if is_interrupted:
                start._interrupt(signal.SIGINT, None)
        except KeyboardInterrupt:
            pass
        raise ImportError("numpy._core.multiarray failed to import")

    monkeypatch.setattr("electrovib.apps.cli.main", command_line)
    monkeypatch.setattr(start, "_INTERRUPTS", [])
    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGALRM)
    try:
        with pytest.raises(SystemExit if is_interrupted else ImportError) as stop:
            start.main()
    finally:
        signal.signal(signal.SIGINT, before[0])
        signal.signal(signal.SIGALRM, before[1])
    said = "electrovib: interrupted, nothing was left half written\n" if is_interrupted else ""
    assert capsys.readouterr().err == said
    if is_interrupted:
        assert stop.value.code == start.INTERRUPTED


def test_an_interrupt_that_a_callback_swallows_comes_again(monkeypatch):
    """Python only prints an exception of a callback: the interrupt would be lost."""
    monkeypatch.setattr(start, "_AGAIN", 0.05)
    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGALRM)
    try:
        with contextlib.suppress(KeyboardInterrupt):
            start._interrupt(signal.SIGINT, None)
        with pytest.raises(KeyboardInterrupt):
            time.sleep(5)
    finally:
        start._be_silent()
        signal.signal(signal.SIGINT, before[0])
        signal.signal(signal.SIGALRM, before[1])
