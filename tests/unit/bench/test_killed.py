"""A bench whose instruments are another process: the plate after SIGKILL and SIGTERM, and the lock."""

import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import pytest
import tomlkit

import electrovib as ev
from electrovib.bench.link import BenchError, Link, connect
from electrovib.bench.run import one_process

SERVER = str(Path(__file__).with_name("served_twin.py"))
SCENARIO = "vezzoli_2014/fig6"
BURST = 0.272
pytestmark = pytest.mark.slow
PATIENCE = 60.0
"""Longest time for which a process of these tests lives [s]."""


@contextmanager
def process(*arguments, **options):
    """Start a Python process that ends with the block, however the block ends."""
    streams = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    started = subprocess.Popen([sys.executable, *arguments], **streams, text=True, bufsize=1, **options)
    try:
        yield started
    finally:
        if started.poll() is None:
            started.kill()
        started.communicate(timeout=20)


@contextmanager
def served(tmp_path, *, with_enable=True):
    """Serve a simulated bench in a process of its own; yield its bench file and a link to its state."""
    content = ev.plan_bench(SCENARIO).settings.to_dict()
    enable = {"on": "OUTP ON", "off": "OUTP OFF", "state": "OUTP?"}
    content["amplifier"]["enable"] = enable if with_enable else None
    file = tmp_path / "bench.toml"
    write(file, content)
    server = (SERVER, str(file), SCENARIO, "--seconds", str(PATIENCE))
    with process(*server) as twin:
        addresses = {}
        for line in twin.stdout:
            if line.strip() == "ready":
                break
            role, _, address = line.strip().partition(": ")
            addresses[role] = address
        content["generator"]["resource"] = addresses["generator"]
        content["oscilloscope"]["resource"] = addresses["oscilloscope"]
        if with_enable:
            content["amplifier"]["enable"]["resource"] = addresses["enable line"]
        write(file, content)
        link = Link("state", connect({"state": addresses["state"]})["state"])
        try:
            yield file, link
        finally:
            link.close()


def write(file, content):
    def clean(value):
        return {k: clean(v) for k, v in value.items() if v is not None} if isinstance(value, dict) else value

    file.write_text(tomlkit.dumps({"schema": 1, **clean(content)}), encoding="utf-8")


@contextmanager
def playing(file, tmp_path):
    """Run the command on the real instruments of a bench file, up to the trigger of the full burst."""
    command = ("-m", "electrovib", "bench", "run", SCENARIO, "--bench", str(file), "--arm", "-o", "t.nc")
    with process(*command, cwd=tmp_path) as run:
        for line in run.stdout:
            if line.strip() == "step: full burst":
                break
        yield run


def wait_for(condition, limit=30.0):
    end = time.monotonic() + limit
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.005)
    return False


def test_after_sigkill_the_plate_is_at_0_v_within_one_burst(tmp_path):
    with served(tmp_path) as (file, state), playing(file, tmp_path) as run:
        assert wait_for(lambda: state.ask_number("PLATE?") > 100), "the burst has begun"
        run.kill()
        killed = time.monotonic()
        run.wait(timeout=20)
        time.sleep(max(killed + BURST - time.monotonic(), 0.0))
        assert state.ask_number("PLATE?") == 0
        time.sleep(0.1)
        assert state.ask_number("PLATE?") == 0
        # nothing was left to disable it: the finite burst is what protects
        assert state.ask("ENABLED?") == "1"
        with one_process(ev.plan_bench(SCENARIO, bench=file).settings.resources) as left:
            assert left.startswith("running, process ")  # the lock of a killed process is free, and says so


@pytest.mark.parametrize(
    ("number", "code", "words"),
    [
        (signal.SIGTERM, 143, "stopped in the step 'full burst': the process was asked to end (SIGTERM)"),
        (signal.SIGINT, 130, "interrupted by the operator"),
    ],
)
def test_a_signal_during_the_burst_ends_at_0_v_and_disabled(tmp_path, number, code, words):
    with served(tmp_path) as (file, state), playing(file, tmp_path) as run:
        assert wait_for(lambda: state.ask_number("PLATE?") > 100)
        run.send_signal(number)
        out, _ = run.communicate(timeout=30)
        assert run.returncode == code, out
        assert words in out
        assert state.ask_number("PLATE?") == 0
        assert state.ask("ENABLED?") == "0"
        assert ev.open_trace(tmp_path / "t.incomplete.nc").attrs["burst"] == "low-voltage burst"


def test_real_instruments_are_played_over_sockets_and_a_second_process_is_refused(tmp_path):
    with served(tmp_path, with_enable=False) as (file, state):
        resources = ev.plan_bench(SCENARIO, bench=file).settings.resources
        asked = []

        def operator(words):
            asked.append(words)
            state.write(f"OPERATE {words.partition(',')[0]}")
            return True

        with one_process(resources), pytest.raises(BenchError, match="another process uses this bench"):
            ev.run_bench(SCENARIO, bench=file, arm=True, confirm=operator)
        assert not asked
        trace = ev.run_bench(SCENARIO, bench=file, arm=True, confirm=operator)
        assert len(asked) == 4  # off, on, off for the change of amplitude, on
        assert float(trace.plate_voltage.max()) == pytest.approx(1000, rel=0.01)
        assert trace.attrs["simulated"] == 0
        assert state.ask_number("PLATE?") == 0
