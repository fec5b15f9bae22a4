"""Files that are dropped on the page, fits to them, and files that a visitor takes away."""

import tempfile

import numpy as np
import pytest

import electrovib as ev
from electrovib.apps.explorer import reading, runner
from electrovib.apps.explorer.computed import compute
from electrovib.apps.explorer.page.plots import paragraphs
from electrovib.apps.explorer.reading import (
    MOST_FREE,
    RunningFit,
    fittable,
    read_upload,
    read_uploaded_scenario,
    shown_name,
)
from electrovib.apps.explorer.session import DOWNLOADS
from electrovib.core.errors import ElectrovibError, InputError

FIG6 = "vezzoli_2014/fig6"
FILM = "stack.insulator.thickness"
TABLE = b"time (s),CH1 (N)\n" + b"\n".join(b"%.6f,%.6f" % (t / 1e3, t * t / 1e4) for t in range(50))


@pytest.fixture(scope="module")
def shown():
    return compute(ev.load(FIG6))


@pytest.fixture(scope="module")
def content(shown, blank):
    with blank():
        return {each.name: each.make(shown) for each in DOWNLOADS}


@pytest.fixture
def scratch(tmp_path, monkeypatch):
    """The folder for temporary files, which is empty after a test."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    yield tmp_path
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def here(monkeypatch):
    """Read in this process, without the second that another one takes to start."""
    monkeypatch.setattr("electrovib.apps.explorer.reading.read_apart", reading.read_here)
    monkeypatch.setattr("electrovib.apps.explorer.reading.read_tables_apart", reading.read_tables_here)


def test_what_is_taken_away_reads_back(content, shown, tmp_path):
    for name in ("scenario.toml", "trace.nc"):
        (tmp_path / name).write_bytes(content[name])
    assert ev.load(tmp_path / "scenario.toml") == shown.scenario
    assert read_uploaded_scenario("mine.toml", content["scenario.toml"]) == shown.scenario
    force = ev.open_trace(tmp_path / "trace.nc").electrostatic_force
    np.testing.assert_array_equal(force, shown.trace.electrostatic_force)
    assert b"electrostatic_force [N]" in content["trace.csv"]
    assert content["figures.png"].startswith(b"\x89PNG")
    assert b"<svg" in content["figures.svg"]
    assert b"Validity" in content["report.html"]
    assert b"@inproceedings{" in content["references.bib"] or b"@article{" in content["references.bib"]
    assert b"Vezzoli" in content["references.bib"]


def test_a_trace_of_ours_names_its_signals_and_a_sweep_is_no_recording(content, scratch, tmp_path, here):
    assert "electrostatic_force" in read_upload("trace.nc", content["trace.nc"]).trace
    found = ev.sweep(FIG6, {"drive.high": [100.0, 200.0]}, quantity=["peak electrostatic_force"])
    ev.save(found, tmp_path / "sweep.nc")
    sweep = (tmp_path / "sweep.nc").read_bytes()
    (tmp_path / "sweep.nc").unlink()
    with pytest.raises(ElectrovibError):
        read_upload("sweep.nc", sweep)


def test_columns_are_listed_and_become_signals_scaled_as_the_visitor_states(scratch, here):
    """Before, the page had no field for the scale, so that a force in V was refused."""
    found = read_upload("scope.csv", TABLE)
    assert found.trace is None
    assert [(each.name, each.unit) for each in found.recorded.channels] == [("time", "s"), ("CH1", "N")]
    heading = found.recorded.channels[1].name
    trace = read_upload("scope.csv", TABLE, {"lateral_force_measured": heading}).trace
    assert trace.lateral_force_measured.values[-1] == pytest.approx(49**2 / 1e4, rel=1e-5)
    volts, signal = TABLE.replace(b"(N)", b"(V)"), {"lateral_force": "CH1"}
    scaled = read_upload("scope.csv", volts, signal, scale={"lateral_force": "1.5 N/V"}).trace.lateral_force
    np.testing.assert_allclose(scaled, 1.5e-4 * np.arange(50) ** 2, rtol=1e-6)
    for table, columns, words in (
        (TABLE, {"lateral_force_measured": "CH9"}, "CH9"),
        (TABLE, {"lateral_force_measured": f"{heading} [V]"}, heading),
        (volts, signal, "a force is needed"),
    ):
        with pytest.raises(InputError, match=words):
            read_upload("scope.csv", table, columns)


SUFFIXES = ("csv", "nc", "mat", "isf", "wav", "npy", "tdms", "xlsx", "trc", "s1p")
NAMES = [*(f"a.{each}" for each in SUFFIXES), "../../a.csv", "/etc/evil.csv", "a\x00.csv", "a", "x" * 300]
OBJECTS = b"{'descr': '|O', 'fortran_order': False, 'shape': (3,), }"


def _damaged(seed):
    rng = np.random.default_rng(seed)
    kinds = [
        b"",
        bytes(rng.integers(0, 256, 400, dtype=np.uint8)),
        TABLE[: int(rng.integers(1, 40))],
        b"time,volts\n1,2\n1,x\n",
        b"\x89HDF\r\n\x1a\n" + bytes(rng.integers(0, 256, 200, dtype=np.uint8)),
        b"CDF\x01" + bytes(60),
        b"\x93NUMPY\x01\x00v\x00" + OBJECTS + b" " * 40,
        b"RIFF" + bytes(40),
        b"PK\x03\x04" + bytes(100),
        b"MATLAB 5.0 MAT-file" + bytes(120),
        b"<script>alert(1)</script>",
        "sökande;\xff".encode("latin-1") * 20,
    ]
    return NAMES[seed % len(NAMES)], kinds[seed % len(kinds)]


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


def test_names_of_uploads_are_shown_as_one_short_line():
    for name, expected in (("C:\\fake\\a.csv", "a.csv"), ("../../a.csv", "a.csv"), ("", "the file")):
        assert shown_name(name) == expected
    assert "\n" not in shown_name("a\nb\x00\u202e.csv")
    long = shown_name("x" * 300 + ".csv")
    assert (len(long), long[-4:]) == (runner.LONGEST_NAME, ".csv")


SINE = {"model": "Sine", "amplitude": 1, "frequency": 100}


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "missing"),
        (b"\xff\xfe", "."),
        (b"schema = 1", "."),
        (b"schema = 1\ndrive = {", "not valid TOML"),
        (b'schema = 1\ndrive = { model = "Sampled", file = "/etc/passwd" }', "names a file"),
        (b'stack = { insulator = { material = { model = "Tabulated", file = "a.csv" } } }', "names a file"),
        (b"a = " + b"[" * 5000, "."),
        (b"x = 1\n" * 1000, "."),
        (b'drive = "os.system"', "."),
        (b"schema = 1979-05-27", "schema"),
        (b"a = " + b"9" * 5000, "."),
        (b"#" * (runner.LARGEST_SCENARIO + 1), r"at most 0\.5 MB"),
    ],
    ids=lambda each: str(each)[:30],
)
def test_malformed_and_large_scenarios_give_a_sentence(content, words, here):
    with pytest.raises(InputError, match=words):
        read_uploaded_scenario("mine.toml", content)


def test_large_files_wide_tables_and_long_drives_are_refused(monkeypatch, here):
    wide = b"\n".join(b",".join(b"%d" % n for n in range(runner.MOST_COLUMNS + 1)) for _ in range(3))
    for content, words in (
        (bytes(runner.LARGEST_UPLOAD + 1), "at most 20 MB"),
        (wide, "at most 200 columns"),
        (b"time,force\n" + b"1," * 20_000 + b"\n1,2\n", "a line of 40001 letters"),
        (b"t," + b"a" * (runner.LONGEST_NAME + 1) + b"\n1,2\n2,3\n", "has 121 letters"),
    ):
        with pytest.raises(InputError, match=words):
            read_upload("a.csv", content)
    assert len(read_upload("a.csv", wide.replace(b"0,1,", b"1,")).recorded.channels) == runner.MOST_COLUMNS
    drives = [SINE] * (runner.MOST_PARAMETERS // 4)
    many = ev.load(FIG6).replace({"drive": {"model": "Sum", "drives": drives}})
    with pytest.raises(InputError, match="scenarios of at most 400"):
        read_uploaded_scenario("a.toml", many.to_toml().encode())
    assert runner.MOST_VALUES >= 1_000_000
    monkeypatch.setattr(runner, "MOST_VALUES", 60)
    with pytest.raises(InputError, match="more than a page reads"):
        read_upload("a.csv", TABLE)


@pytest.mark.slow  # three processes are started
def test_another_process_returns_what_this_one_reads(content, tmp_path):
    trace, path = tmp_path / "trace.nc", tmp_path / "scope.csv"
    trace.write_bytes(content["trace.nc"])
    path.write_bytes(TABLE)
    assert reading.read_apart(trace).identical(reading.read_here(trace))
    columns = {"lateral_force_measured": "CH1"}
    assert reading.read_apart(path, columns, title="t").equals(reading.read_here(path, columns, title="t"))
    there, here = reading.read_apart(path), reading.read_here(path)
    for name in ("time", "step", "start", "attributes"):
        assert getattr(there, name) == getattr(here, name)
    for mine, its in zip(here.channels, there.channels, strict=True):
        assert (mine.name, mine.unit) == (its.name, its.unit)
        np.testing.assert_array_equal(mine.values, its.values)


@pytest.mark.slow
def test_a_text_that_the_parser_never_ends_is_given_up(scratch):
    with pytest.raises(InputError, match="computing"):
        read_uploaded_scenario("a.toml", b"a." * 240_000 + b"a = 1")


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


def test_a_fit_finds_the_parameter_shows_its_progress_and_can_be_cancelled(shown):
    trace = ev.simulate(shown.scenario.replace({FILM: 80e-6}), time=np.linspace(0, 0.27, 300))
    noise = 1e-5 * np.random.default_rng(1).normal(size=300)
    measured = trace[["electrostatic_force"]].assign(electrostatic_force=trace.electrostatic_force + noise)
    running = RunningFit(shown.scenario, measured, [FILM])
    result = running.run()
    (row,) = result.rows
    assert row.lower < 80e-6 < row.upper
    assert running.evaluations > 1
    assert FILM in paragraphs(result.document.sentences)
    running = RunningFit(shown.scenario, measured, [FILM])
    running.cancel()
    with pytest.raises(InputError, match="cancelled"):
        running.run()
    for count in (0, MOST_FREE + 1):
        with pytest.raises(InputError, match="one to 6 at once"):
            RunningFit(shown.scenario, measured, ["x"] * count)


def test_parameters_that_change_no_signal_are_not_offered_to_fit():
    scenario = ev.load(FIG6).replace({"limits.voltage": 500})
    parts = {path.partition(".")[0] for path in fittable(scenario)}
    assert {"drive", "stack", "contact", "friction"} <= parts
    assert not parts & {"perception", "limits", "time", "frequency"}
