"""``electrovib times``: edges of a record, and swipes of a finger, with what is refused."""

import re
from pathlib import Path

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.core.signals import make_trace

pytestmark = pytest.mark.usefixtures("blank_pictures")

TAU = 6e-3


@pytest.fixture(scope="module")
def trace(tmp_path_factory):
    """Write a record with one rising and one falling edge of an exponential, and return its path."""
    folder, time = tmp_path_factory.mktemp("record"), np.arange(0, 1.0, 4e-4)
    rising, falling = (np.exp(-np.maximum(time - at, 0) / TAU) for at in (0.2, 0.6))
    force = np.where(time < 0.6, 1 - rising, falling)
    force += 0.01 * np.random.default_rng(0).standard_normal(time.size)
    volts = np.where((time > 0.2) & (time < 0.6), 100.0, 0.0)
    signals = {"lateral_force_measured": (("time",), force), "drive_voltage": (("time",), volts)}
    ev.save(make_trace(signals, {"time": time}, {}), folder / "force.nc")
    return f"times {folder / 'force.nc'} --quantity lateral_force_measured"


def test_the_table_states_times_with_intervals(trace, here, said, refused, table):
    out = said(f"{trace} -o found")
    for words in (r"rising +10-90 % time as recorded +13", r"falling +time constant \(exponential\) +6"):
        assert re.search(words, out)
    assert "95 % interval" in out
    assert {path.name for path in (here / "found").iterdir()} >= {"report.html", "times.csv"}
    assert (here / "found" / "times.csv").read_text().startswith("# electrovib table as CSV")
    rows = table(here / "found" / "times.csv")
    time = next(row for row in rows if row["group"] == "falling" and "of the fitted form" in row["name"])
    assert float(time["value"]) == pytest.approx(TAU * np.log(9), rel=0.02)
    assert float(time["lower"]) < TAU * np.log(9) < float(time["upper"])
    assert {row["unit"] for row in rows} == {"s"}
    page = (here / "found" / "report.html").read_text()
    assert "Falling edges" in page
    assert "Forms of relaxation of the rising edges" in page
    (here / "found" / "times.csv").write_text("mine")  # our own would be replaced
    assert "times.csv: exists already" in refused(f"{trace} -o found")


def test_the_drive_marks_the_edges_and_a_sensor_is_taken_out(trace, said):
    sensor = "--by drive_voltage --sensor 380Hz:3 --levels 20:80"
    out = said(f"{trace} {sensor} --edges falling")
    assert re.search("falling +delay", out)
    assert "20-80 % time of an instantaneous change through the sensor" in out
    assert "rising" not in out
    assert ev.Sensor(frequency=380.0, quality=3.0).shortest_time() == pytest.approx(0.489e-3, rel=1e-3)


@pytest.mark.parametrize(
    ("option", "words"),
    [
        ("--levels 90", "--levels 90"),
        ("--levels 90:10", "levels = "),
        ("--sensor fast", "sensor = fast"),
        ("--window soon", "--window"),
        ("--antiphase", "readback"),
    ],
)
def test_a_mistake_is_one_sentence_and_nothing_is_written(option, words, trace, refused):
    assert words in refused(f"{trace} {option} -o found")


FRICTION, LOAD, RATE = 0.4, 0.5, 2e3
RIG = """
lateral = { column = "lateral", sensitivity = "0.5 N/V" }
normal = { column = "normal", sensitivity = "-0.25 N/V" }
encoder = { column = "counts", step = "1 um" }
clock = { model = "EvenSamples", rate = "2 kHz" }
"""


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


def traced(name, time, **signals):
    trace = make_trace({each: (("time",), values) for each, values in signals.items()}, {"time": time}, {})
    trace.to_netcdf(name)
    return trace


def written(name, **options):
    """Write a Trace with a speed, and the file of the instrument with the same in counts and volts."""
    time, normal, lateral, position = forces(**options)
    speed = np.gradient(position, time)
    measured = {"normal_force_measured": normal, "lateral_force_measured": lateral, "sliding_speed": speed}
    traced(f"{name}.nc", time, **measured)
    counts = np.column_stack([normal / -0.25, lateral / 0.5, np.rint(position / 1e-6)])
    np.savetxt(f"{name}.csv", counts, delimiter=",", header="normal (V),lateral (V),counts", comments="")
    Path("rig.toml").write_text(RIG)


@pytest.fixture
def numbers(here, table):
    return lambda name: {(row["group"], row["name"]): row for row in table(here / name / "swipes.csv")}


def test_both_doors_give_the_friction_of_the_record(here, said, numbers):
    written("swipe")
    for door, name in (("swipe.nc", "trace"), ("swipe.csv --recipe rig.toml", "file")):
        out = said(f"times --swipes {door} -o {name}")
        found = numbers(name)
        friction = found["swipe", "friction"]
        assert float(friction["lower"]) < FRICTION < float(friction["upper"])
        for row, value, share in (
            ("friction", FRICTION, 5e-3),
            ("normal force", LOAD, 2e-3),
            ("lateral force", FRICTION * LOAD, 5e-3),
            ("speed", 40e-3, 1e-3),
            ("distance", 80e-3, 2e-2),
        ):
            assert float(found["swipe", row]["value"]) == pytest.approx(value, rel=share), row
        shown = re.search(r" friction +([\d.]+) +([\d.]+) to ([\d.]+)", out)
        ends = [float(friction[name]) for name in ("value", "lower", "upper")]
        assert [float(each) for each in shown.groups()] == pytest.approx(ends, abs=1e-5)
        page = (here / name / "report.html").read_text()
        assert "<svg" in page
        assert "Choice of the zero" in page
    assert repr(ev.reduce_swipe("swipe.nc").friction.value) == numbers("trace")["swipe", "friction"]["value"]


def test_a_set_speed_is_that_of_a_trace_without_motion(here):
    written("swipe")
    time, normal, lateral, _ = forces()
    trace = traced("still.nc", time, normal_force=normal, lateral_force=lateral)
    assert ev.reduce_swipe(trace, speed="40 mm/s").speed == pytest.approx(40e-3)
    assert ev.reduce_swipe(trace).speed is None
    with pytest.raises(InputError, match="sliding_speed; omit one"):
        ev.reduce_swipe("swipe.nc", speed=0.04)


def test_each_of_several_swipes_has_its_rows(said, numbers):
    written("two", swipes=2)
    assert "The recording holds 2 swipes." in said("times --swipes two.nc -o out")
    for group in ("swipe 1", "swipe 2"):
        assert float(numbers("out")[group, "friction"]["value"]) == pytest.approx(FRICTION, rel=5e-3)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("rail.nc", ["the sensor of the normal force is at its rail", "cannot be determined"]),
        ("force.nc", ["needs a lateral force over time; the signals are normal_force"]),
        ("swipe.csv --recipe rig.toml --speed '40 mm/s'", ["states its speed too"]),
        ("swipe.csv --recipe wrong.toml", ["encoder.step"]),
        ("swipe.csv --recipe absent.toml", ["No such file"]),
        ("still.nc --speed fast", ["speed = 'fast'"]),
    ],
)
def test_a_swipe_that_cannot_be_reduced_is_one_sentence(line, words, here, refused):
    written("rail", rail=0.45)
    written("swipe")
    (here / "wrong.toml").write_text(RIG.replace("1 um", "1 kg"))
    time, normal, lateral, _ = forces()
    traced("force.nc", time, normal_force=normal)
    traced("still.nc", time, normal_force=normal, lateral_force=lateral)
    err = refused(f"times --swipes {line}")
    assert err.count("\n") == 1
    assert all(word in err for word in words), err
