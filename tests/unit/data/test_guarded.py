"""Readers in a process of their own: what they hand over, and every reason for which they are stopped."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io
from damaged_records import whole_files

from electrovib.core.budget import content_allowed, megabytes, memory_allowed
from electrovib.core.errors import DataFileError, NoColumnError
from electrovib.core.signals import make_trace
from electrovib.data.guarded import GuardedReading, Reader, ReaderLimits, read_guarded
from electrovib.data.readers import hdf5 as netcdf
from electrovib.data.registry import read_columns, read_recorded
from electrovib.data.traces import load_nc, open_trace, save_mat, save_nc

WANTED = {"t": ("time", "s"), "v": ("voltage", "V")}
MODULE = """
import os, signal, sys, time
import numpy as np
from electrovib.core.errors import DataFileError, NoColumnError
from electrovib.core.signals import make_trace
def numbers(path, times):
    print("a library that prints")
    yield "text", ["é", {"a": times}]
    yield "array", np.arange(5.0)[::2] * times
    yield "none", np.empty((0, 3), np.complex128)
    yield "single", np.array(7, ">i4")
def problem(path):
    yield "array", np.arange(5.0)
    raise DataFileError([f"{path}: one", f"{path}: two"])
def lacking(path):
    yield "a", 1
    raise NoColumnError("has no column 'w'", path=path, column="w")
def fault(path):
    yield "a", 1
    raise ZeroDivisionError("of the library\\nmore")
def endless(path):
    yield "a", 1
    while True:
        pass
def waits(path):
    time.sleep(60)
    yield "a", 1
def greedy(path):
    yield "size", len(bytearray(400_000_000))
def generous(path):
    while True:
        yield "block", np.zeros(1_000_000)
def wordy(path):
    yield "text", "x" * 40_000_000
def crashes(path):
    yield "a", 1
    os.abort()
def leaves(path):
    yield "a", 1
    os._exit(0)
def texts(path):
    yield "a", np.array(["a", "b"])
def objects(path):
    yield "a", np.array([None, {}])
"""


@pytest.fixture
def reader(tmp_path, monkeypatch):
    (tmp_path / "foreign_format.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    return lambda name: Reader(f"foreign_format:{name}", (), "a file of this test")


@pytest.fixture
def path(tmp_path):
    found = tmp_path / "record.bin"
    found.write_bytes(b"content")
    return found


SMALL = {"memory": 64 * 2**20, "content": 32 * 2**20, "processor_time": 2.0, "waiting_time": 20.0}


def test_arrays_and_texts_arrive_as_they_are(reader, path):
    found = read_guarded(reader("numbers"), path, times=3)
    assert list(found) == ["text", "array", "none", "single"]
    assert found["text"] == ["é", {"a": 3}]
    np.testing.assert_array_equal(found["array"], [0.0, 6.0, 12.0])
    assert (found["none"].shape, found["none"].dtype) == ((0, 3), np.complex128)
    assert (found["single"].dtype.str, found["single"].item(), found["single"].shape) == (">i4", 7, ())


@pytest.mark.parametrize(
    ("name", "limits", "words"),
    [
        ("problem", {}, "record.bin: one\n.*record.bin: two"),
        ("fault", {}, r"is damaged or not a file of this test \(of the library\)"),
        ("endless", {"processor_time": 0.0}, "is damaged: reading it did not end within 0 s of computing. Copy it again"),
        ("waits", {"waiting_time": 0.4}, "reading it took more than 0 s and was stopped. Copy it again"),
        ("greedy", {}, "packed too tightly: 7e-06 MB would unfold to more than 33.6 MB"),
        ("generous", {}, "packed too tightly"),
        ("wordy", {}, "packed too tightly"),
        ("crashes", {}, "its reader crashed .exit code"),
        ("leaves", {}, "its reader crashed .exit code 0"),
        ("objects", {}, "damaged"),
        ("texts", {}, "damaged or not a file of this test .it holds no numbers"),
        ("no_such_function", {}, "its reader crashed"),
    ],
)  # fmt: skip
def test_what_goes_wrong_is_one_error_that_names_the_file(reader, path, name, limits, words):
    with pytest.raises(DataFileError, match=f"(?s){words}") as caught:
        read_guarded(reader(name), path, limits=ReaderLimits(**SMALL | limits))
    assert all(problem.startswith(str(path)) and "\n" not in problem for problem in caught.value.problems)


def test_a_column_that_is_missing_is_named(reader, path):
    with pytest.raises(NoColumnError, match=r"record\.bin: has no column 'w'") as caught:
        read_guarded(reader("lacking"), path)
    assert caught.value.column == "w"


def test_limits_follow_the_size_of_the_file(path):
    assert ReaderLimits.for_file(path) == ReaderLimits(
        memory=64 * 2**20 + 70, content=32 * 2**20 + 35, processor_time=3 + 7e-7, waiting_time=10 * (3 + 7e-7)
    )
    assert (memory_allowed(100), content_allowed(100)) == (64 * 2**20 + 1000, 32 * 2**20 + 500)
    assert (megabytes(1_500_000), megabytes(2_500_000_000)) == ("1.5 MB", "2.5 GB")


def test_nothing_is_left_behind_and_files_that_are_none_are_not_opened(reader, path, tmp_path):
    with GuardedReading(reader("waits"), path) as reading:
        process = reading._process
        assert process.poll() is None
    assert process.poll() is not None
    assert not reading._clock.is_alive() or reading._clock.finished.is_set()
    (tmp_path / "empty").touch()
    os.mkfifo(tmp_path / "pipe")
    for name, words in {"empty": "is empty", "pipe": "not an ordinary", "no": "no such file"}.items():
        with pytest.raises(DataFileError, match=words):
            GuardedReading(reader("numbers"), tmp_path / name)


def script(folder, text):
    """A Python of its own that sees the reader of this test."""
    start = f"import sys\nsys.path.insert(0, {str(folder)!r})\n"
    start += "from pathlib import Path\nfrom electrovib.data.guarded import Reader, read_guarded\n"
    return [sys.executable, "-c", start + text]


def running(text):
    """Whether a process has this text in its command line."""
    for place in Path("/proc").iterdir():
        if place.name.isdigit():
            try:
                if text.encode() in (place / "cmdline").read_bytes():
                    return True
            except OSError:
                continue
    return False


def environment(*folders):
    return os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, [*map(str, folders), *sys.path]))}


@pytest.mark.skipif(not Path("/proc/self/cmdline").exists(), reason="device: needs a list of processes")
@pytest.mark.parametrize("name", ["waits", pytest.param("endless", marks=pytest.mark.slow)])
def test_ctrl_c_ends_it_at_once(reader, path, tmp_path, name):
    own = tmp_path / "python"
    own.symlink_to(sys.executable)  # so that the processes of this test can be told from others
    text = f"print('on', flush=True)\nread_guarded(Reader('foreign_format:{name}', (), 'x'), Path({str(path)!r}))"
    command = script(tmp_path, f"sys.executable = {str(own)!r}\n" + text)
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "start_new_session": True}
    with subprocess.Popen(command, env=environment(), **pipes) as process:
        process.stdout.readline()
        begin = time.monotonic()
        while not running(str(own)) and time.monotonic() < begin + 20:
            time.sleep(0.02)
        time.sleep(0.3)
        os.killpg(process.pid, signal.SIGINT)
        said = process.communicate(timeout=4)[1]  # far less than the limits of the reader
    assert b"KeyboardInterrupt" in said
    assert not running(str(own))


def test_with_closed_standard_streams(reader, path, tmp_path):
    text = f"found = read_guarded(Reader('foreign_format:numbers', (), 'x'), Path({str(path)!r}), times=2)\n"
    text += f"Path({str(tmp_path / 'found')!r}).write_text(str(found['array'].tolist()))"
    command = script(tmp_path, text)
    close = "import os, subprocess, sys; os.closerange(0, 3); os.execv(sys.argv[1], sys.argv[1:])"
    subprocess.run([sys.executable, "-c", close, *command], check=False, timeout=60)
    assert (tmp_path / "found").read_text() == "[0.0, 4.0, 8.0]"


# -------------------------------------------------------------------------- files that were read before


def hdf5(path, **content):
    with h5py.File(path, "w") as file:
        for name, values in ({"time": np.arange(4.0), "voltage": np.arange(4.0)} | content).items():
            if isinstance(values, dict):
                file.create_dataset(name, **values)
            else:
                file[name] = values
    return path


LINK = "'voltage' is a link to another place"


@pytest.mark.parametrize(
    ("voltage", "words"),
    [
        ({"shape": (300_000_000,), "dtype": "f8"}, "'voltage' declares 300000000 numbers and holds none"),
        ({"shape": (3_000_000,), "dtype": "f8"}, "'voltage' declares 3000000 numbers and holds none"),
        ({"shape": (8,), "dtype": "f8", "external": [("secret", 0, 64)]}, LINK),
        (h5py.ExternalLink("secret", "/x"), LINK),
        (h5py.SoftLink("/time"), LINK),
    ],
)
def test_hdf5_that_took_memory_or_read_other_files(tmp_path, voltage, words):
    (tmp_path / "secret").write_bytes(bytes(range(64)))
    path = hdf5(tmp_path / "a.nc", voltage=voltage)
    with pytest.raises(DataFileError, match=words):
        read_columns(path, WANTED)
    found = read_columns(path, {"t": WANTED["t"]})  # what does not concern the columns asked for is no matter
    np.testing.assert_array_equal(found["t"], np.arange(4.0))
    with pytest.raises(DataFileError, match=r"a link to another place|is not a Trace|holds none|declares"):
        load_nc(path)


def test_virtual_numbers_are_not_followed(tmp_path):
    hdf5(tmp_path / "b.nc")
    layout = h5py.VirtualLayout(shape=(4,), dtype="f8")
    layout[:] = h5py.VirtualSource(str(tmp_path / "b.nc"), "time", shape=(4,))
    with h5py.File(tmp_path / "a.nc", "w") as file:
        file.create_virtual_dataset("voltage", layout)
        file["time"] = np.arange(4.0)
    with pytest.raises(DataFileError, match="a link to another place"):
        read_columns(tmp_path / "a.nc", WANTED)


@pytest.mark.parametrize("suffix", [".nc", ".mat"])
def test_a_packed_file_that_unfolds_to_hundreds_of_megabytes(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    with h5py.File(path, "w") as file:
        for name in ("time", "voltage"):
            options = {"shape": (10_000_000,), "dtype": "f8", "chunks": (1_000_000,), "compression": "gzip"}
            file.create_dataset(name, **options)[:1_000_000] = 1.0
    with pytest.raises(DataFileError, match="packed too tightly"):
        read_columns(path, WANTED)


def test_a_flipped_bit_that_looped_for_ever(tmp_path):
    """The free space of the heap of texts is said to be shorter than it is; the library then makes no headway."""
    path = tmp_path / "a.nc"
    save_nc(make_trace({"current": (("time",), [1.0, 2.0])}, {"time": [0.0, 1.0]}, {"note": "x"}), path)
    raw = bytearray(path.read_bytes())
    place = raw.index(b"GCOL") + 16
    while int.from_bytes(raw[place : place + 2], "little"):  # object 0 is the free space
        place += 16 + -(-int.from_bytes(raw[place + 8 : place + 16], "little") // 8) * 8
    raw[place + 9] ^= 2
    path.write_bytes(raw)
    with pytest.raises(DataFileError, match="did not end within 0 s of computing"):
        read_guarded(netcdf._READER, path, texts=True, limits=ReaderLimits(**SMALL | {"processor_time": 0.0}))


def test_missing_and_packed_numbers_of_netcdf(tmp_path):
    path = hdf5(tmp_path / "a.nc", voltage=np.array([1, -1, 250, 3], "i2"))
    packed = {"_FillValue": np.int16(-1), "scale_factor": 0.5, "add_offset": 100.0, "units": "mV"}
    with h5py.File(path, "r+") as file:
        file["voltage"].attrs.update(packed)
    with pytest.raises(DataFileError, match="nan is not a finite number"):
        read_columns(path, WANTED)
    found = read_columns(path, WANTED, missing=True)
    np.testing.assert_allclose(found["v"], [0.1005, np.nan, 0.225, 0.1015], rtol=1e-15)
    with h5py.File(path, "r+") as file:
        del file["voltage"].attrs["_FillValue"]
        file["voltage"].attrs["_Unsigned"] = "true"
    np.testing.assert_allclose(read_columns(path, WANTED)["v"][1], (65535 * 0.5 + 100) / 1e3, rtol=1e-15)


def test_a_flipped_byte_that_ends_the_interpreter(tmp_path):
    """SciPy writes numbers of a type that is not known to an address that is none."""
    scipy.io.savemat(tmp_path / "a.mat", {"voltage": np.arange(3.0)})
    raw = bytearray((tmp_path / "a.mat").read_bytes())
    place = raw.rindex(np.arange(3.0).tobytes()) - 8
    assert raw[place] == 9  # of doubles
    raw[place] = 0
    (tmp_path / "a.mat").write_bytes(raw)
    plain = f"import scipy.io; scipy.io.loadmat({str(tmp_path / 'a.mat')!r})"
    assert subprocess.run([sys.executable, "-c", plain], check=False).returncode == -signal.SIGSEGV
    with pytest.raises(DataFileError, match=r"its reader crashed \(exit code -11\)"):
        read_recorded(tmp_path / "a.mat")


ENDED_BY_DAMAGE = {"a.h5", "new.mat", "packed.mat", "plain.mat"}


@pytest.mark.parametrize("name", whole_files())
def test_only_hdf5_and_matlab_are_read_in_another_process(tmp_path, monkeypatch, name):
    """Of the other libraries none was ended or hung by any of 12 000 damaged files."""
    started = []
    popen = subprocess.Popen
    monkeypatch.setattr("subprocess.Popen", lambda *all, **more: started.append(1) or popen(*all, **more))
    (tmp_path / name).write_bytes(whole_files()[name])
    read_recorded(tmp_path / name)
    assert bool(started) == (name in ENDED_BY_DAMAGE)


@pytest.mark.parametrize(("name", "save"), [("a.nc", save_nc), ("a.mat", save_mat)])
def test_a_trace_with_its_checksum_is_known_to_be_whole_and_is_read_here(tmp_path, monkeypatch, name, save):
    trace = make_trace({"current": (("time",), [1.0, 2.0])}, {"time": [0.0, 1.0]}, {"note": "x"})
    save(trace, tmp_path / name)
    with monkeypatch.context() as patch:
        patch.setattr("subprocess.Popen", None)
        assert open_trace(tmp_path / name).identical(trace)
        with pytest.raises(TypeError):
            read_recorded(tmp_path / name)  # which does not look for a checksum


# ------------------------------------------------------------------------------- damaged at random


DAMAGE = [sys.executable, "-W", "error", str(Path(__file__).parents[3] / "benchmarks" / "damaged_files.py")]
TEXTS = "columns.csv,wide.tsv,blanks.txt,columns.npy,fields.npy,classic.nc"
NATIVE = "trace.nc,columns.nc,new.mat,packed.mat,plain.mat,trace.mat"


@pytest.mark.slow
@pytest.mark.parametrize(("count", "kinds"), [(800, TEXTS), (200, "scenario.toml,plain.toml"), (20, NATIVE)])
def test_many_damaged_files_are_read_or_refused(count, kinds):
    command = [*DAMAGE, str(count), "--seed", "2", "--kinds", kinds]
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=590, check=False, env=environment()
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count("files:") == len(kinds.split(","))


@pytest.mark.slow
def test_the_damaging_script_notices_a_crash_and_a_wrong_exception(tmp_path):
    """A reader that raises something else makes it fail."""
    (tmp_path / "sitecustomize.py").write_text(
        "import electrovib.data.registry as columns\nolder = columns.read_columns\n"
        "def read(path, wanted):\n    found = older(path, wanted)\n"
        "    if found['v'][0] != 0: raise KeyError('x')\n    return found\ncolumns.read_columns = read\n"
    )
    command = [*DAMAGE, "60", "--kinds", "columns.npy"]
    places = environment(tmp_path)
    done = subprocess.run(command, capture_output=True, text=True, timeout=100, check=False, env=places)
    assert done.returncode == 1
    assert "KeyError" in done.stdout
