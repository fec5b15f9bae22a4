"""Files that are dropped on the page, and files that a visitor takes away."""

from __future__ import annotations

import io
import tempfile
import zipfile
from pathlib import Path

import numpy as np
import pytest

import electrovib as ev
from electrovib.apps.explorer import reading
from electrovib.apps.explorer.computed import compute
from electrovib.apps.explorer.downloads import DOWNLOADS
from electrovib.apps.explorer.fitting import MOST_FREE, RunningFit, fittable
from electrovib.apps.explorer.limits import (
    LARGEST_SCENARIO,
    LARGEST_UPLOAD,
    LONGEST_NAME,
    MOST_COLUMNS,
    MOST_PARAMETERS,
    MOST_VALUES,
)
from electrovib.apps.explorer.page.words import fit_words
from electrovib.apps.explorer.reading import named, read_upload, read_uploaded_scenario, shown_name
from electrovib.core.errors import ElectrovibError, InputError

FIG6 = "vezzoli_2014/fig6"
TABLE = b"time (s),CH1 (N)\n" + b"\n".join(b"%.6f,%.6f" % (t / 1e3, t * t / 1e4) for t in range(50))


@pytest.fixture(scope="module")
def shown():
    return compute(ev.load(FIG6))


@pytest.fixture(scope="module")
def content(shown):
    return {each.name: each.make(shown) for each in DOWNLOADS}


@pytest.fixture
def scratch(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


@pytest.fixture
def here(monkeypatch):
    """Read in this process, without the second that another one takes to start."""
    monkeypatch.setattr("electrovib.apps.explorer.reading.read_apart", reading.read_here)
    monkeypatch.setattr("electrovib.apps.explorer.reading.read_tables_apart", reading.read_tables_here)


def test_the_scenario_reads_back(content, shown, tmp_path):
    path = tmp_path / "scenario.toml"
    path.write_bytes(content["scenario.toml"])
    assert ev.load(path) == shown.scenario
    assert read_uploaded_scenario("mine.toml", content["scenario.toml"]) == shown.scenario


def test_the_trace_reads_back(content, shown, tmp_path):
    path = tmp_path / "trace.nc"
    path.write_bytes(content["trace.nc"])
    np.testing.assert_array_equal(ev.open_trace(path).electrostatic_force, shown.trace.electrostatic_force)
    with zipfile.ZipFile(io.BytesIO(content["trace.zip"])) as packed:
        packed.extractall(tmp_path / "csv")
        assert all(name.endswith(".csv") for name in packed.namelist())
        assert len(packed.namelist()) >= 2


def test_pictures_report_and_references(content):
    assert content["figures.png"].startswith(b"\x89PNG")
    assert b"<svg" in content["figures.svg"]
    assert b"Validity" in content["report.html"]
    assert b"@inproceedings{" in content["references.bib"] or b"@article{" in content["references.bib"]
    assert b"Vezzoli" in content["references.bib"]


def test_a_trace_of_ours_names_its_signals(content, scratch):
    found = read_upload("trace.nc", content["trace.nc"])
    assert "electrostatic_force" in found.trace
    assert list(scratch.iterdir()) == []


def test_columns_are_listed_and_become_signals(scratch, here):
    found = read_upload("scope.csv", TABLE)
    assert found.trace is None
    assert [(each.name, each.unit) for each in found.recorded.channels] == [("time", "s"), ("CH1", "N")]
    heading = found.recorded.channels[1].name
    trace = named("scope.csv", TABLE, {"lateral_force_measured": heading}).trace
    assert trace.lateral_force_measured.values[-1] == pytest.approx(49**2 / 1e4, rel=1e-5)
    assert list(scratch.iterdir()) == []
    with pytest.raises(InputError, match="CH9"):
        named("scope.csv", TABLE, {"lateral_force_measured": "CH9"})
    with pytest.raises(InputError):
        named("scope.csv", TABLE, {"lateral_force_measured": f"{heading} [V]"})
    assert list(scratch.iterdir()) == []


def _damaged(seed):
    rng = np.random.default_rng(seed)
    names = [
        "a.csv",
        "a.nc",
        "a.mat",
        "a.isf",
        "a.wav",
        "a.npy",
        "a.tdms",
        "a.xlsx",
        "a.trc",
        "../../a.csv",
        "a",
        "a.s1p",
        "x" * 300,
    ]
    kinds = [
        b"",
        bytes(rng.integers(0, 256, 400, dtype=np.uint8)),
        TABLE[: int(rng.integers(1, 40))],
        b"time,volts\n1,2\n1,x\n",
        b"\x89HDF\r\n\x1a\n" + bytes(rng.integers(0, 256, 200, dtype=np.uint8)),
        b"CDF\x01" + bytes(60),
        b"\x93NUMPY\x01\x00v\x00{'descr': '|O', 'fortran_order': False, 'shape': (3,), }" + b" " * 40,
        b"RIFF" + bytes(40),
        b"PK\x03\x04" + bytes(100),
        b"MATLAB 5.0 MAT-file" + bytes(120),
        b"<script>alert(1)</script>",
        "sökande;\xff".encode("latin-1") * 20,
    ]
    return names[seed % len(names)], kinds[seed % len(kinds)]


@pytest.mark.parametrize(
    "seed", [pytest.param(seed, marks=pytest.mark.slow if seed >= 24 else ()) for seed in range(156)]
)
def test_malformed_recordings_give_a_sentence_and_leave_nothing(seed, scratch, here):
    name, content = _damaged(seed)
    try:
        found = read_upload(name, content)
    except ElectrovibError as error:
        assert str(error)
        assert str(scratch) not in str(error)
    else:
        assert found.recorded is not None or found.trace is not None
    assert list(scratch.iterdir()) == []


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\xff\xfe",
        b"schema = 1",
        b"schema = 1\ndrive = {",
        b'schema = 1\ndrive = { model = "Sampled", file = "/etc/passwd" }',
        b'stack = { insulator = { material = { model = "Tabulated", file = "a.csv" } } }',
        b"a = " + b"[" * 5000,
        b"x = 1\n" * 1000,
        b'drive = "os.system"',
        b"schema = 1979-05-27",
        b"a = " + b"9" * 5000,
    ],
)
def test_malformed_scenarios_give_a_sentence(content, here):
    with pytest.raises(InputError) as error:
        read_uploaded_scenario("mine.toml", content)
    assert str(error.value)


def test_large_files_are_refused(monkeypatch, here):
    with pytest.raises(InputError, match="at most 20 MB"):
        read_upload("a.csv", bytes(LARGEST_UPLOAD + 1))
    monkeypatch.setattr(reading, "MOST_VALUES", 60)
    with pytest.raises(InputError, match="more than a page reads"):
        read_upload("a.csv", TABLE)
    assert MOST_VALUES >= 1_000_000


def test_many_columns_and_long_headings_are_refused(here):
    wide = b"\n".join(b",".join(b"%d" % n for n in range(MOST_COLUMNS + 1)) for _ in range(3))
    with pytest.raises(InputError, match="at most 200 columns"):
        read_upload("a.csv", wide)
    assert len(read_upload("a.csv", wide.replace(b"0,1,", b"1,")).recorded.channels) == MOST_COLUMNS
    with pytest.raises(InputError, match="a line of 40001 letters"):
        read_upload("a.csv", b"time,force\n" + b"1," * 20_000 + b"\n1,2\n")
    named_columns = b"t," + b"a" * (LONGEST_NAME + 1) + b"\n1,2\n2,3\n"
    with pytest.raises(InputError, match="has 121 letters"):
        read_upload("a.csv", named_columns)


def test_names_of_files_are_shown_as_one_short_line():
    assert shown_name("C:\\fake\\a.csv") == "a.csv"
    assert shown_name("../../a.csv") == "a.csv"
    assert shown_name("") == "the file"
    assert "\n" not in shown_name("a\nb\x00\u202e.csv")
    assert len(shown_name("x" * 300 + ".csv")) == LONGEST_NAME
    assert shown_name("x" * 300 + ".csv").endswith(".csv")


def test_large_scenarios_are_refused(here):
    with pytest.raises(InputError, match=r"at most 0\.5 MB"):
        read_uploaded_scenario("a.toml", b"#" * (LARGEST_SCENARIO + 1))
    sine = {"model": "Sine", "amplitude": 1, "frequency": 100}
    many = ev.load(FIG6).replace({"drive": {"model": "Sum", "drives": [sine] * (MOST_PARAMETERS // 4)}})
    with pytest.raises(InputError, match="scenarios of at most 400"):
        read_uploaded_scenario("a.toml", many.to_toml().encode())


@pytest.mark.slow  # three processes are started
def test_another_process_returns_what_this_one_reads(content, tmp_path, scratch):
    path = tmp_path / "trace.nc"
    path.write_bytes(content["trace.nc"])
    assert reading.read_apart(path).identical(reading.read_here(path))
    path = tmp_path / "scope.csv"
    path.write_bytes(TABLE)
    columns = {"lateral_force_measured": "CH1"}
    assert reading.read_apart(path, columns, title="t").equals(reading.read_here(path, columns, title="t"))
    there, here = reading.read_apart(path), reading.read_here(path)
    assert (there.time, there.step, there.start, there.attributes) == (
        here.time, here.step, here.start, here.attributes,
    )  # fmt: skip
    for mine, its in zip(here.channels, there.channels, strict=True):
        assert (mine.name, mine.unit) == (its.name, its.unit)
        np.testing.assert_array_equal(mine.values, its.values)


@pytest.mark.slow
def test_a_text_that_the_parser_never_ends_is_given_up(scratch):
    with pytest.raises(InputError, match="computing"):
        read_uploaded_scenario("a.toml", b"a." * 240_000 + b"a = 1")
    assert list(scratch.iterdir()) == []


@pytest.mark.slow
@pytest.mark.parametrize("do", ["memory", "file", "time"])
def test_the_limits_of_the_other_process_hold(do, tmp_path, monkeypatch):
    path = tmp_path / f"{do}.csv"
    path.write_bytes(TABLE)
    reader = reading.Reader("tests.unit.apps.explorer.greedy:contents", ("numpy",), "a recording")
    monkeypatch.setattr(reading, "_READER", reader)
    quick = reading.ReaderLimits(memory=300_000_000, content=1000, processor_time=2.0, waiting_time=20.0)
    monkeypatch.setattr(reading, "LIMITS", quick)
    with pytest.raises(ElectrovibError, match=r"packed too tightly|damaged|computing"):
        reading.read_apart(path)
    assert sum(each.stat().st_size for each in tmp_path.iterdir()) == len(TABLE)


def test_a_sweep_is_no_recording(tmp_path, here):
    found = ev.sweep(FIG6, {"drive.high": [100.0, 200.0]}, quantities=["peak electrostatic_force"])
    ev.save(found, tmp_path / "sweep.nc")
    with pytest.raises(ElectrovibError):
        read_upload("sweep.nc", (tmp_path / "sweep.nc").read_bytes())


def _measured(shown):
    trace = ev.simulate(
        shown.scenario.replace({"stack.insulator.thickness": 80e-6}), time=np.linspace(0, 0.27, 300)
    )
    noise = 1e-5 * np.random.default_rng(1).normal(size=300)
    return trace[["electrostatic_force"]].assign(electrostatic_force=trace.electrostatic_force + noise)


def test_a_fit_finds_the_parameter_and_shows_its_progress(shown):
    running = RunningFit(shown.scenario, _measured(shown), ["stack.insulator.thickness"])
    result = running.run()
    (row,) = result.rows
    assert row.lower < 80e-6 < row.upper
    assert running.evaluations > 1
    assert "stack.insulator.thickness" in fit_words(result)


def test_a_fit_is_cancelled(shown):
    running = RunningFit(shown.scenario, _measured(shown), ["stack.insulator.thickness"])
    running.cancel()
    with pytest.raises(InputError, match="cancelled"):
        running.run()


@pytest.mark.parametrize("count", [0, MOST_FREE + 1])
def test_too_few_and_too_many_parameters(shown, count):
    with pytest.raises(InputError, match="one to 6 at once"):
        RunningFit(shown.scenario, _measured(shown), ["x"] * count)


def test_names_of_uploads_never_reach_the_file_system(scratch, here):
    for name in ("../../../evil.csv", "/etc/evil.csv", "a\x00.csv", "con.csv.", "a.c/sv", "." * 300):
        try:
            read_upload(name, TABLE)
        except ElectrovibError as error:
            assert str(error)
    assert list(scratch.iterdir()) == []
    assert not Path("/etc/evil.csv").exists()


def test_parameters_that_change_no_signal_are_not_offered_to_fit():
    scenario = ev.load("vezzoli_2014/fig6").replace({"limits.voltage": 500})
    parts = {path.partition(".")[0] for path in fittable(scenario)}
    assert {"drive", "stack", "contact", "friction"} <= parts
    assert not parts & {"perception", "limits", "time", "frequency"}


def test_a_sensor_is_scaled_as_the_visitor_states(here):
    """Before, the page had no field for it, so that a force in V was refused."""
    content = b"time (s),CH1 (V)\n" + b"\n".join(b"%.6f,%.6f" % (t / 1e3, t * t / 1e4) for t in range(50))
    found = named("scope.csv", content, {"lateral_force": "CH1"}, scale={"lateral_force": "1.5 N/V"})
    np.testing.assert_allclose(found.trace.lateral_force, 1.5e-4 * np.arange(50) ** 2, rtol=1e-6)
    with pytest.raises(ElectrovibError, match="a force is needed"):
        named("scope.csv", content, {"lateral_force": "CH1"})
