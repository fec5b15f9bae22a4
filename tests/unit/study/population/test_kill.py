"""A study whose process is killed at random progress, again and again."""

from __future__ import annotations

import os
import random
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import electrovib as ev

FINGERS = 40 * 1024
DRIVER = """
import sys, time
import electrovib.solve.population
from electrovib.study.population import run, tiles
from stand_in_population import SPACE, StandInPopulation, stand_in

class Slow(StandInPopulation):
    def signals(self, draws, **_):
        time.sleep(2e-5 * len(next(iter(draws.values()))))
        return super().signals(draws)

electrovib.solve.population.population = lambda scenario, free, signals: Slow(signals=signals)
tiles.TileSizes.measured = lambda self, fingers, seconds: setattr(self, "wanted", 256)
run.PAUSE = 0.02
import electrovib as ev

path, fingers, memory, draws = sys.argv[1], int(sys.argv[2]), sys.argv[3], sys.argv[4] == "draws"

def progress(done, total):
    print(done, flush=True)

asked = {"n": fingers, "seed": 3, "exceed": "1 mN", "draws": draws, "budget_memory": memory}
ev.study("vezzoli_2014/fig6", SPACE, **asked, output=path, progress=progress)
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
    found, expected = ev.open_study(path), ev.open_study(tmp_path / "reference.zarr")
    assert found.attrs["fingers"] == FINGERS
    for name in expected.variables:  # sums over fingers are formed tile by tile: rounding differs
        np.testing.assert_allclose(found[name].values, expected[name].values, rtol=1e-12, err_msg=name)
