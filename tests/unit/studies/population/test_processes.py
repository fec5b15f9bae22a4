"""Studies in several processes: real schedulers and workers on the loopback device, and processes that are killed."""

import json
import os
import pickle
import random
import signal
import subprocess
import sys
import time
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.deprecation import former_values
from electrovib.core.own_models import use_models
from electrovib.studies.population import study
from electrovib.studies.population.declared import DeclaredStudy, read_study
from electrovib.studies.population.result import computing_versions
from electrovib.studies.population.tiles import Collected, Evaluator, tile_on_worker

SPACE = {"stack.stratum_corneum.thickness": {"model": "Uniform", "low": "100 um", "high": "300 um"}}
SCENARIO = "vezzoli_2014/fig6"


def same(one, other):
    """Sums over fingers are formed tile by tile, and the tiles of a cluster are others: rounding differs."""
    for name in one.variables:
        np.testing.assert_allclose(one[name].values, other[name].values, rtol=1e-12, err_msg=name)


@contextmanager
def process(*arguments):
    command = [sys.executable, "-m", "dask", *arguments]
    begun = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield begun
    finally:
        begun.kill()
        begun.wait(timeout=20)


@contextmanager
def cluster(folder, count):
    """Start a scheduler and its workers; return its address and their processes."""
    from distributed import Client

    file, local = folder / "scheduler.json", ["--host", "127.0.0.1", "--no-dashboard"]
    options = ["--nthreads", "1", "--no-nanny", "--local-directory", str(folder)]
    with ExitStack() as stack:
        stack.enter_context(process("scheduler", *local, "--port", "0", "--scheduler-file", str(file)))
        for _ in range(300):
            if file.exists():
                break
            time.sleep(0.1)
        address = json.loads(file.read_text())["address"]
        workers = [process("worker", address, *local, *options) for _ in range(count)]
        started = [stack.enter_context(each) for each in workers]
        with Client(address, set_as_default=False) as client:
            client.wait_for_workers(count, timeout=60)
        yield address, started


@pytest.mark.slow
def test_a_worker_that_is_killed_costs_its_tasks_alone(tmp_path):
    asked = {"n": 500, "seed": 5, "exceed": "1 mN", "records": True}
    amplifier = {"source_current": "20 uA", "stray_capacitance": "100 pF"}  # fingers are solved one by one
    scenario = ev.load(SCENARIO).replace({"time.samples": 100, "circuit.amplifier": amplifier})
    killed = []
    with cluster(tmp_path, 2) as (address, workers):

        def progress(done, total):
            if done > 100 and not killed:
                workers[0].send_signal(signal.SIGKILL)
                killed.append(done)

        with former_values(progress=progress):
            found = study(scenario, SPACE, **asked, workers=address, output=tmp_path / "a.zarr")
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


@pytest.mark.slow
def test_an_address_that_cannot_be_used_is_answered_in_a_sentence_alone():
    """Dask prints a traceback, when a process ends, for a client that was never connected."""
    script = (
        "import electrovib as ev\n"
        "from electrovib.core.errors import InputError\n"
        "for address in ('nowhere:1', 'tls://127.0.0.1:9', 'http://x'):\n"
        "    try:\n"
        f"        ev.study({SCENARIO!r}, {SPACE!r}, n=10, seed=1, workers=address)\n"
        "    except InputError as error:\n"
        "        print(error)\n"
    )
    command = [sys.executable, "-c", script]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert [": no answer (" in line for line in done.stdout.splitlines()] == [True] * 3


def declared(scenario=SCENARIO, space=SPACE, **changes):
    asked = {"n": 10, "seed": 1, "quantity": "electrostatic_force", "percentiles": (5, 95), "exceed": "5 mN"}
    return read_study(scenario, space, **asked | {"records": False, "budget_memory": "1 GB"} | changes)


@pytest.mark.parametrize(("scenario", "space"), [(SCENARIO, SPACE), ("vezzoli_2014/fig6_gap", "fingers")])
def test_a_study_travels_as_text(scenario, space):
    one = declared(scenario, space)
    content = json.loads(one.to_text())
    assert content["scenario"].startswith("schema = 1")
    assert "[space." in content["space"]
    other = DeclaredStudy.from_text(one.to_text())
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


@pytest.mark.parametrize("exceed", [(), "0.3 mN"])
def test_a_worker_sends_no_signals_beyond_the_memory_and_one_of_other_versions_nothing(exceed):
    """It sends moments, counts and a histogram, which are those of the fingers."""
    one = Evaluator(declared(n=3000, budget_memory="20 kB", exceed=exceed, percentiles=(50,)))
    text = one.declared.to_text()
    sent = tile_on_worker(text, 0, 3000, {})
    assert not sent.rows
    assert len(pickle.dumps(sent)) < 4 * one.samples * 3000 + 2**25
    collected = [Collected(one, hold=False) for _ in range(2)]
    for each, part in zip(collected, (sent, one.tile(0, 3000)), strict=True):
        each.add(part)
    found, expected = (each.statistics["electrostatic_force"] for each in collected)
    arrays = found.arrays()
    for key, values in expected.arrays().items():
        if key not in {"pages", "bins"}:
            np.testing.assert_allclose(arrays[key], values, rtol=1e-12)
    np.testing.assert_array_equal(*(each.histogram.quantiles([0.5]) for each in (found, expected)))
    refused = tile_on_worker(text, 0, 4, computing_versions() | {"numpy": "1.0"})
    assert "instead of 1.0" in refused.problems[0]


@pytest.mark.slow
def test_the_models_of_a_user_are_imported_from_their_file_by_a_worker(tmp_path):
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
        "from electrovib.studies.population.tiles import tile_on_worker\n"
        "text, versions = pathlib.Path(sys.argv[1]).read_text(), json.loads(sys.argv[2])\n"
        "print(float(tile_on_worker(text, 0, 40, versions).statistics['electrostatic_force'].mean[-1]))"
    )
    command = [sys.executable, "-c", script, str(tmp_path / "study.json"), json.dumps(computing_versions())]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    here = ev.study(scenario, SPACE, n=40, seed=1)["electrostatic_force_mean"].values[-1]
    assert float(done.stdout) == here


# a study whose process is killed at random progress, again and again

FINGERS = 40 * 1024
DRIVER = """
import sys, time
import electrovib.solve.population
from electrovib.studies.population import run, tiles
from stand_in_population import SPACE, StandInPopulation, stand_in

class Slow(StandInPopulation):
    def signals(self, draws, **_):
        time.sleep(2e-5 * len(next(iter(draws.values()))))
        return super().signals(draws)

electrovib.solve.population.Population = lambda scenario, free, signals: Slow(signals=signals)
tiles.TileSizes.measured = lambda self, fingers, seconds: setattr(self, "wanted", 256)
run.PAUSE = 0.02
from electrovib.core.deprecation import former_values

path, fingers, memory, draws = sys.argv[1], int(sys.argv[2]), sys.argv[3], sys.argv[4] == "draws"

def progress(done, total):
    print(done, flush=True)

asked = {"n": fingers, "seed": 3, "exceed": "1 mN", "records": draws}
with former_values(budget_memory=memory, progress=progress):
    run.study("vezzoli_2014/fig6", SPACE, **asked, output=path)
"""


def begun(path, *asked):
    places = [os.environ.get("PYTHONPATH", ""), str(Path(__file__).parents[3] / "reference")]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(places)}
    command = [sys.executable, "-c", DRIVER, str(path), str(FINGERS), *asked]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment)


@pytest.mark.slow
@pytest.mark.parametrize("asked", [("1 GB", "no draws"), ("1 MB", "draws")])
def test_a_study_that_is_killed_again_and_again_ends_with_the_same_numbers(tmp_path, asked, content):
    finished = begun(tmp_path / "reference.zarr", *asked)
    finished.communicate(timeout=120)
    assert finished.returncode == 0
    generator, starts, kills = random.Random(12), [], 0
    path = tmp_path / "killed.zarr"
    while kills < 5:
        with begun(path, *asked) as process:
            starts.append(int(process.stdout.readline()))
            end = starts[-1] + generator.randrange(1, 12000)
            for line in process.stdout:
                if int(line) >= min(end, FINGERS - 256):
                    break
            time.sleep(generator.random() * 0.01)  # between two reports, and within a write
            process.kill()
        kills += 1
        if starts[-1] > FINGERS - 12000:
            break
    with begun(path, *asked) as process:
        starts.append(int(process.stdout.readline()))
        process.communicate(timeout=120)
        assert process.returncode == 0
    assert kills >= 3
    assert starts == sorted(starts)
    assert starts[-1] > 0
    assert set(content(path)) == set(content(tmp_path / "reference.zarr"))
    found = ev.open_study(path)
    assert found.attrs["fingers"] == FINGERS
    same(found, ev.open_study(tmp_path / "reference.zarr"))
