"""Studies on a Dask cluster: real schedulers and workers on the loopback device."""

from __future__ import annotations

import json
import os
import pickle
import signal
import subprocess
import sys
import time
from contextlib import ExitStack, contextmanager

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.study.population.declared import DeclaredStudy, read_study

SPACE = {"stack.stratum_corneum.thickness": {"model": "Uniform", "low": "100 um", "high": "300 um"}}
SCENARIO = "vezzoli_2014/fig6"


def same(one, other):
    """Sums over fingers are formed tile by tile, and the tiles of a cluster are others: rounding differs."""
    for name in one.variables:
        np.testing.assert_allclose(one[name].values, other[name].values, rtol=1e-12, err_msg=name)


@contextmanager
def process(*arguments, **environment):
    command = [sys.executable, "-m", "dask", *arguments]
    begun = subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=os.environ | environment
    )
    try:
        yield begun
    finally:
        begun.kill()
        begun.wait(timeout=20)


@contextmanager
def cluster(folder, workers):
    """Start a scheduler and its workers; return its address and their processes."""
    file = folder / "scheduler.json"
    local = ["--host", "127.0.0.1"]
    with ExitStack() as stack:
        stack.enter_context(
            process("scheduler", *local, "--port", "0", "--no-dashboard", "--scheduler-file", str(file))
        )
        for _ in range(300):
            if file.exists():
                break
            time.sleep(0.1)
        address = json.loads(file.read_text())["address"]
        options = ["--nthreads", "1", "--no-nanny", "--no-dashboard", "--local-directory", str(folder)]
        yield (
            address,
            [stack.enter_context(process("worker", address, *local, *options)) for _ in range(workers)],
        )


def wait_for_workers(address, count):
    from distributed import Client

    with Client(address, set_as_default=False) as client:
        client.wait_for_workers(count, timeout=60)


@pytest.mark.slow
def test_a_worker_that_is_killed_costs_its_tasks_alone(tmp_path):
    asked = {"n": 500, "seed": 5, "exceed": "1 mN", "draws": True}
    amplifier = {"source_current": "20 uA", "stray_capacitance": "100 pF"}  # fingers are solved one by one
    scenario = ev.load(SCENARIO).replace({"time.samples": 100, "circuit.amplifier": amplifier})
    killed = []
    with cluster(tmp_path, 2) as (address, workers):
        wait_for_workers(address, 2)

        def progress(done, total):
            if done > 100 and not killed:
                workers[0].send_signal(signal.SIGKILL)
                killed.append(done)

        found = ev.study(
            scenario, SPACE, **asked, scheduler=address, output=tmp_path / "a.zarr", progress=progress
        )
        assert workers[0].wait(timeout=20) == -signal.SIGKILL
        assert workers[1].poll() is None
    assert killed
    assert killed[0] < 500
    same(found, ev.study(scenario, SPACE, **asked))


@pytest.mark.slow
def test_workers_of_this_machine_give_the_same_numbers():
    scenario = ev.load(SCENARIO).replace({"time.samples": 50})
    asked = {"n": 5000, "seed": 5}
    same(ev.study(scenario, SPACE, **asked, workers=2), ev.study(scenario, SPACE, **asked))


def test_a_scheduler_that_does_not_answer_is_an_error(monkeypatch):
    monkeypatch.setattr("electrovib.study.population.tiles._CONNECT", 0.5)
    with pytest.raises(InputError, match=r"scheduler = tcp://127.0.0.1:9: no answer"):
        ev.study(SCENARIO, SPACE, n=10, seed=1, scheduler="tcp://127.0.0.1:9")


@pytest.mark.slow
def test_an_address_that_cannot_be_used_is_answered_in_a_sentence_alone():
    """Dask prints a traceback, when a process ends, for a client that was never connected."""
    script = (
        "import electrovib as ev\n"
        "from electrovib.core.errors import InputError\n"
        "for address in ('nowhere', 'tls://127.0.0.1:9', 'http://x'):\n"
        "    try:\n"
        f"        ev.study({SCENARIO!r}, {SPACE!r}, n=10, seed=1, scheduler=address)\n"
        "    except InputError as error:\n"
        "        print(error)\n"
    )
    command = [sys.executable, "-c", script]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert [": no answer (" in line for line in done.stdout.splitlines()] == [True] * 3


@pytest.mark.parametrize(
    ("where", "words"),
    [
        ({"workers": 0}, "workers = 0: expected a number of processes"),
        ({"workers": True}, "workers = True"),
        ({"workers": 2, "scheduler": "tcp://a:1"}, "give one of them"),
    ],
)
def test_wrong_workers_are_refused(where, words):
    with pytest.raises(InputError, match=words):
        ev.study(SCENARIO, SPACE, n=10, seed=1, **where)


def declared(scenario=SCENARIO, space=SPACE, **changes):
    asked = {"n": 10, "seed": 1, "signal": "electrostatic_force", "percentiles": (5, 95), "exceed": "5 mN"}
    return read_study(scenario, space, **asked | {"draws": False, "budget_memory": "1 GB"} | changes)


@pytest.mark.parametrize(("scenario", "space"), [(SCENARIO, SPACE), ("vezzoli_2014/fig6_gap", "fingers")])
def test_a_study_travels_as_text(scenario, space):
    one = declared(scenario, space)
    text = one.to_text()
    content = json.loads(text)
    assert content["scenario"].startswith("schema = 1")
    assert "[space." in content["space"]
    other = DeclaredStudy.from_text(text)
    assert other.identity() == one.identity()
    for path, values in one.space.draw(1, 0, 50).items():
        np.testing.assert_array_equal(other.space.draw(1, 0, 50)[path], values)


def test_a_measured_drive_travels_without_its_file(tmp_path):
    file = tmp_path / "drive.csv"
    file.write_text("time [ms],voltage [V]\n0,0\n5,300.1\n40,300\n45,0\n80,0\n")
    scenario = ev.load(SCENARIO, changes={"drive": {"model": "Sampled", "file": str(file)}})
    text = declared(scenario).to_text()
    file.unlink()
    assert DeclaredStudy.from_text(text).scenario == scenario


def test_a_worker_with_other_versions_is_refused():
    from electrovib.study.population.tiles import tile_on_worker

    found = tile_on_worker(declared().to_text(), 0, 4, {"electrovib": "0.1.0", "numpy": "1.0"})
    assert "instead of 1.0" in found.problems[0]


@pytest.mark.parametrize("exceed", [(), "0.3 mN"])
def test_a_worker_sends_no_signals_beyond_the_memory(exceed):
    """It sends moments, counts and a histogram, which are those of the fingers."""
    from electrovib.study.population.fingers import Collected, Evaluator
    from electrovib.study.population.tiles import tile_on_worker

    one = Evaluator(declared(n=3000, budget_memory="20 kB", exceed=exceed, percentiles=(50,)))
    sent = tile_on_worker(one.declared.to_text(), 0, 3000, {})
    assert not sent.rows
    assert len(pickle.dumps(sent)) < 4 * one.samples * 3000 + 2**25
    found, expected = (Collected(one, hold=False) for _ in range(2))
    found.add(sent)
    expected.add(one.tile(0, 3000))
    for key, values in expected.statistics["electrostatic_force"].arrays().items():
        if key not in {"pages", "bins"}:
            other = found.statistics["electrostatic_force"].arrays()[key]
            np.testing.assert_allclose(other, values, rtol=1e-12)
    quantiles = [
        each.statistics["electrostatic_force"].histogram.quantiles([0.5]) for each in (found, expected)
    ]
    np.testing.assert_array_equal(*quantiles)


@pytest.mark.slow
def test_the_models_of_a_user_are_imported_from_their_file_by_a_worker(tmp_path):
    from electrovib.core.own_models import use_models
    from electrovib.study.population.result import computing_versions

    file = tmp_path / "law_of_a_study.py"
    file.write_text(
        "from electrovib.core.constants import VACUUM_PERMITTIVITY\n"
        "from electrovib.physics.force import ForceLaw\n\n\n"
        "class HalvedByUser(ForceLaw):\n"
        '    """Half the Maxwell stress."""\n\n'
        "    def pressure(self, E):\n"
        "        return VACUUM_PERMITTIVITY * E**2 / 4\n"
    )
    use_models(file)
    scenario = ev.load("vezzoli_2014/fig6_gap", changes={"force.model": "HalvedByUser", "time.samples": 10})
    (tmp_path / "study.json").write_text(declared(scenario, n=40).to_text())
    script = (
        "import json, pathlib, sys\n"
        "from electrovib.study.population.tiles import tile_on_worker\n"
        "text, versions = pathlib.Path(sys.argv[1]).read_text(), json.loads(sys.argv[2])\n"
        "print(repr(tile_on_worker(text, 0, 40, versions).statistics['electrostatic_force'].mean[-1]))"
    )
    command = [sys.executable, "-c", script, str(tmp_path / "study.json"), json.dumps(computing_versions())]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    here = ev.study(scenario, SPACE, n=40, seed=1)["electrostatic_force_mean"].values[-1]
    assert float(done.stdout.removeprefix("np.float64(").strip(")\n")) == here
