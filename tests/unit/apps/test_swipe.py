"""Swipes on the command line: from a Trace, and from a file of an instrument with the calibration of its channels."""

import csv
import re
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.core.errors import InputError
from electrovib.core.trace import make_trace

FRICTION, LOAD, RATE = 0.4, 0.5, 2e3
RIG = """
lateral = { column = "lateral", sensitivity = "0.5 N/V" }
normal = { column = "normal", sensitivity = "-0.25 N/V" }
encoder = { column = "counts", step = "1 um" }
clock = { model = "EvenSamples", rate = "2 kHz" }
"""
SHARED = Path(__file__).parents[3].parent / "shared" / "data" / "tribometer" / "finger_swipe.mat"


def forces(*, swipes=1, rail=np.inf, seed=1):
    """Times, normal and lateral force and position of swipes of 80 mm at 40 mm/s, with zeros that do not drift."""
    rng, parts = np.random.default_rng(seed), []
    time = np.arange(round(6 * RATE)) / RATE
    for number in range(swipes):
        load = LOAD * np.interp(time, [1.5, 1.6, 4.7, 4.8], [0, 1, 1, 0])
        slides = np.interp(time, [2.2, 2.25, 4.2, 4.25], [0, 1, 1, 0])
        position = np.interp(time, [2.2, 4.2], [0, 80e-3])
        lateral = FRICTION * load * slides + 2e-3 * rng.standard_normal(time.size)
        normal = load + 2e-3 * rng.standard_normal(time.size)
        parts.append((time + 6 * number, np.minimum(normal, rail), lateral, position + 80e-3 * number))
    return [np.concatenate(each) for each in zip(*parts, strict=True)]


def trace_file(path, **options):
    time, normal, lateral, position = forces(**options)
    speed = np.gradient(position, time)
    signals = {"normal_force_measured": normal, "lateral_force_measured": lateral, "sliding_speed": speed}
    make_trace({name: (("time",), values) for name, values in signals.items()}, {"time": time}, {}).to_netcdf(
        path
    )
    return str(path)


def instrument_file(path, **options):
    _, normal, lateral, position = forces(**options)
    table = np.column_stack([normal / -0.25, lateral / 0.5, np.rint(position / 1e-6)])
    np.savetxt(path, table, delimiter=",", header="normal (V),lateral (V),counts", comments="")
    path.with_name("rig.toml").write_text(RIG)
    return [str(path), "--recipe", str(path.with_name("rig.toml"))]


def ran(*arguments):
    return CliRunner().invoke(app, ["times", "--swipes", *arguments])


def numbers(folder):
    lines = (folder / "swipes.csv").read_text().splitlines()
    rows = csv.DictReader(line for line in lines if not line.startswith("#"))
    return {(row["group"], row["name"]): row for row in rows}


def test_both_doors_give_the_friction_of_the_record(tmp_path):
    doors = [trace_file(tmp_path / "swipe.nc")], instrument_file(tmp_path / "swipe.csv")
    for arguments, name in zip(doors, ("trace", "file"), strict=True):
        result = ran(*arguments, "-o", str(tmp_path / name))
        assert result.exit_code == 0, result.output
        found = numbers(tmp_path / name)
        friction = found["swipe", "friction"]
        assert float(friction["lower"]) < FRICTION < float(friction["upper"])
        assert float(friction["value"]) == pytest.approx(FRICTION, rel=5e-3)
        assert float(found["swipe", "normal force"]["value"]) == pytest.approx(LOAD, rel=2e-3)
        assert float(found["swipe", "lateral force"]["value"]) == pytest.approx(FRICTION * LOAD, rel=5e-3)
        assert float(found["swipe", "speed"]["value"]) == pytest.approx(40e-3, rel=1e-3)
        assert float(found["swipe", "distance"]["value"]) == pytest.approx(80e-3, rel=2e-2)
        shown = re.search(r"friction: ([\d.]+), 95 % interval ([\d.]+) to ([\d.]+)", result.output)
        ends = [float(friction[name]) for name in ("value", "lower", "upper")]
        assert [float(each) for each in shown.groups()] == pytest.approx(ends, abs=1e-5)
        page = (tmp_path / name / "report.html").read_text()
        assert "<svg" in page
        assert "Choice of the zero" in page
    swipe = ev.reduce_swipe(doors[0][0])
    assert repr(swipe.friction.value) == numbers(tmp_path / "trace")["swipe", "friction"]["value"]


def test_a_set_speed_is_that_of_a_trace_without_motion(tmp_path):
    time, normal, lateral, _ = forces()
    trace = make_trace(
        {"normal_force": (("time",), normal), "lateral_force": (("time",), lateral)}, {"time": time}, {}
    )
    assert ev.reduce_swipe(trace, speed="40 mm/s").speed == pytest.approx(40e-3)
    assert ev.reduce_swipe(trace).speed is None
    with pytest.raises(InputError, match="sliding_speed; omit one"):
        ev.reduce_swipe(trace_file(tmp_path / "swipe.nc"), speed=0.04)


def test_each_of_several_swipes_has_its_rows(tmp_path):
    result = ran(trace_file(tmp_path / "two.nc", swipes=2), "-o", str(tmp_path / "out"))
    assert result.exit_code == 0, result.output
    assert "The recording holds 2 swipes." in result.output
    found = numbers(tmp_path / "out")
    for group in ("swipe 1", "swipe 2"):
        assert float(found[group, "friction"]["value"]) == pytest.approx(FRICTION, rel=5e-3)


def test_a_sensor_at_its_rail_is_one_sentence(tmp_path):
    result = ran(trace_file(tmp_path / "rail.nc", rail=0.45))
    assert result.exit_code == 1
    (problem,) = result.exception.problems
    assert "the sensor of the normal force is at its rail" in problem
    assert "cannot be determined" in problem


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["force.nc"], "needs a lateral force over time; the signals are normal_force"),
        (["swipe.csv", "--recipe", "rig.toml", "--trim", "60"], "trim = 60 %"),
        (["swipe.csv", "--recipe", "rig.toml", "--speed", "40 mm/s"], "states its speed too"),
        (["swipe.csv", "--recipe", "wrong.toml"], "encoder.step"),
        (["swipe.csv", "--recipe", "absent.toml"], "No such file"),
        (["swipe.nc", "--speed", "fast"], "speed = 'fast'"),
    ],
)
def test_mistakes_are_one_sentence(tmp_path, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    instrument_file(tmp_path / "swipe.csv")
    (tmp_path / "wrong.toml").write_text(RIG.replace("1 um", "1 kg"))
    time, normal, lateral, _ = forces()
    make_trace({"normal_force": (("time",), normal)}, {"time": time}, {}).to_netcdf("force.nc")
    both = {"normal_force": (("time",), normal), "lateral_force": (("time",), lateral)}
    make_trace(both, {"time": time}, {}).to_netcdf("swipe.nc")
    result = ran(*arguments)
    assert result.exit_code == 1
    assert len(result.exception.problems) == 1
    assert words in result.exception.problems[0]


@pytest.mark.skipif(not SHARED.exists(), reason="needs shared/data")
def test_a_recorded_swipe_gives_the_published_ranges(tmp_path):
    (tmp_path / "rig.toml").write_text(
        'lateral = { column = 0, sensitivity = "0.4444444 N/V" }\n'
        'normal = { column = 1, sensitivity = "-0.31 N/V" }\n'
        'encoder = { column = 4, step = "0.5 um" }\n'
        'clock = { model = "EvenSamples", rate = "10 kHz" }\n'
    )
    result = ran(str(SHARED), "--recipe", str(tmp_path / "rig.toml"), "-o", str(tmp_path / "out"))
    assert result.exit_code == 0, result.output
    found = numbers(tmp_path / "out")
    assert 0.523 <= float(found["swipe", "normal force"]["value"]) <= 0.530
    assert 0.34 <= float(found["swipe", "friction"]["value"]) <= 0.45
    assert float(found["swipe", "speed"]["value"]) == pytest.approx(40e-3, rel=0.02)
