"""A full disk, a limit of file size, and a kill at any moment: what was there before is there still."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Iterable
from pathlib import Path
from unittest.mock import MagicMock

import numpy as np
import pytest
import xarray

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.core.trace import make_trace
from electrovib.data.atomic import writing
from electrovib.data.marks import Form, is_ours
from electrovib.study.reproduction import Curve, Panel, Reproduction
from electrovib.view import report, reproduce, svg

NAMES = ("a.nc", "a.csv", "a.mat", "a.html", "a.cir", "a.toml", "out")
"""One output of each kind; the last is the folder of a reproduced paper."""


def trace(size: int, seed: int) -> xarray.Dataset:
    values = np.random.default_rng(seed).normal(size=size)
    grids = {"time": np.arange(size) / size, "frequency": np.arange(1.0, size + 1)}
    signals = {"drive_voltage": (("time",), values), "impedance": (("frequency",), values * 1j)}
    return make_trace(signals, grids, {"seed": seed, "title": f"number {seed}"})


def reproduction(size: int, seed: int) -> Reproduction:
    curve = Curve(label="a", x=np.arange(float(size)), y=np.random.default_rng(seed).normal(size=size))
    panel = Panel(id="fig1", title="1", caption="One.", x=("time", "s"), y=("force", "N"), curves=(curve,))
    return Reproduction(paper="nobody_2099", citation="", rows=(), panels=(panel,))


def write(name: str, size: int, seed: int) -> None:
    """Write one version of an output; each seed makes another."""
    if name == "out":
        reproduce._write(reproduction(size, seed), Path("out"))
    elif name == "a.html":
        ev.report(trace(5, seed), name, title=str(seed) * size)
    elif name == "a.cir":
        ev.export("vezzoli_2014/fig6", name, set={"drive.high": float(seed + 1)})
    elif name == "a.toml":
        ev.init(ev.load("vezzoli_2014/fig6").replace({"drive.high": float(seed + 1)}), output=name)
    else:
        ev.save(trace(size, seed), name)


@pytest.fixture(autouse=True)
def without_figures(monkeypatch):
    """Drawing takes the time, and is not the point here."""
    monkeypatch.setattr(report, "figures", lambda *_: [])
    monkeypatch.setattr(svg, "to_png", lambda *_, **__: b"PNG" * 2000)
    monkeypatch.setattr(svg, "to_svg", lambda *_, **__: f"<svg>{'line' * 2000}</svg>")
    monkeypatch.setattr(reproduce, "drawn", MagicMock())


def visible(folder: Path) -> dict[str, bytes]:
    """What a person sees in a folder."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and not path.name.endswith(".partial")
    }


@pytest.fixture
def small_disk(tmp_path):
    """A disk of 256 kB."""
    place = tmp_path / "disk"
    place.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=256k", "tmpfs", str(place)], check=False, capture_output=True
    )
    if mounted.returncode:
        pytest.skip("no permission to mount a small disk: not a device that can be filled")
    yield place
    subprocess.run(["umount", str(place)], check=True)


@pytest.mark.parametrize("name", NAMES)
def test_a_full_disk_is_told_and_the_next_save_works(name, small_disk, monkeypatch):
    monkeypatch.chdir(small_disk)
    write(name, 50, 1)
    ballast = small_disk / "ballast"
    with ballast.open("wb", buffering=0) as file:
        try:
            while file.write(b"x" * 4096):
                pass
        except OSError:
            pass
    before = visible(small_disk)
    with pytest.raises(InputError, match="cannot be written: No space left on device") as caught:
        write(name, 50, 2)
    assert len(caught.value.problems) == 1
    assert visible(small_disk) == before
    assert not list(small_disk.rglob("*.partial"))
    ballast.unlink()
    write(name, 50, 2)
    assert visible(small_disk) != before
    monkeypatch.undo()


@pytest.mark.parametrize("name", NAMES)
def test_a_limit_of_file_size_is_told_and_the_next_save_works(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write(name, 50, 1)
    before = visible(tmp_path)
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (700, hard))
    try:
        with pytest.raises(InputError, match="cannot be written: File too large"):
            write(name, 50, 2)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert visible(tmp_path) == before
    assert not list(tmp_path.rglob("*.partial"))
    write(name, 50, 2)
    assert visible(tmp_path) != before


def test_a_full_disk_on_the_command_line_is_one_line(small_disk, tmp_path):
    """The crash of the HDF5 library came at the end of the interpreter, so a whole process is looked at."""
    arguments = ["run", "--set", "time.samples=20000", "-o", str(small_disk / "a.nc")]
    done = subprocess.run(
        [sys.executable, "-m", "electrovib", *arguments], capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert done.stderr == f"electrovib: {small_disk / 'a.nc'}: cannot be written: No space left on device.\n"
    assert list(small_disk.iterdir()) == []


def killed_while_writing(name: str, moments: Iterable[float]) -> int:
    """Kill a process at shares of the time that its files are open; tell how often it had not finished."""
    write(name, 2000, 1)
    span = time_of_writing(name)
    caught = 0
    for seed, moment in enumerate(moments, start=2):
        begun, tell = os.pipe()
        child = os.fork()
        if child == 0:
            write_and_tell(name, seed, tell)
        os.read(begun, 1)
        time.sleep(moment * span)
        os.kill(child, signal.SIGKILL)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -signal.SIGKILL
        os.close(begun)
        os.close(tell)
        check_whole(name)
        left = list(Path().rglob("*.partial"))
        caught += bool(left)
        if left:
            write(name, 2000, 1)  # what was left is not needed any more
        for file in left:
            file.unlink()
    return caught


def write_and_tell(name: str, seed: int, tell: int) -> None:
    """Write, and say when the first file is opened; then wait to be killed."""
    touch = Path.touch
    Path.touch = lambda self, **more: (os.write(tell, b"x"), touch(self, **more))
    write(name, 2000, seed)
    time.sleep(60)


def time_of_writing(name: str) -> float:
    """Seconds from the first temporary file to the end."""
    begun: list[float] = []
    with pytest.MonkeyPatch.context() as patch:
        touch = Path.touch
        patch.setattr(
            Path, "touch", lambda self, **more: (begun.append(time.monotonic()), touch(self, **more))
        )
        write(name, 2000, 1)
    return time.monotonic() - begun[0]


def check_whole(name: str) -> None:
    """A file is whole if its checksum is right, and a Trace if it can be loaded and holds its own numbers."""
    forms = {"a.html": Form.PAGE, "a.cir": Form.NETLIST, "a.toml": Form.SCENARIO}
    if name in forms:
        assert is_ours(Path(name), forms[name])
    elif name == "out":
        assert is_ours(Path("out/report.html"), Form.PAGE)
        names = {"fig1.svg", "fig1.png", "fig1.csv", "numbers.json", "report.html"}
        assert {path.name for path in Path("out").iterdir() if path.suffix != ".partial"} == names
    else:
        found = ev.open_trace(name)
        expected = trace(2000, found.attrs["seed"])
        np.testing.assert_array_equal(found.drive_voltage, expected.drive_voltage)
        np.testing.assert_array_equal(found.impedance, expected.impedance)


@pytest.mark.parametrize("name", NAMES)
def test_a_kill_leaves_a_whole_file(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    killed_while_writing(name, (0.2, 0.9))


@pytest.mark.slow
def test_kills_at_a_hundred_random_moments_leave_whole_files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    moments = np.random.default_rng(8).uniform(0, 1.2, (len(NAMES), 100))
    caught = {name: killed_while_writing(name, own) for name, own in zip(NAMES, moments, strict=True)}
    print(caught)
    assert sum(caught.values()) > 20


POINTS = ("touch", "half", "before fsync", "after fsync", "between", "after")


@pytest.mark.parametrize("point", POINTS)
def test_a_kill_at_a_chosen_moment_leaves_older_or_newer(point, tmp_path):
    """In a child of this process, which ends at once at the moment that is named."""
    files = [tmp_path / "a", tmp_path / "b"]
    for file in files:
        file.write_text("older")
    child = os.fork()
    if child == 0:
        end_at(point, files)
        os._exit(3)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
    there = [file.read_text() for file in files]
    expected = {"between": ["newer", "older"], "after": ["newer", "newer"]}
    assert there == expected.get(point, ["older", "older"])


def end_at(point: str, files: list[Path]) -> None:
    def end(*_, **__):
        os._exit(7)

    replace, calls = Path.replace, []

    def counted(self, target):
        replace(self, target)
        calls.append(target)
        if len(calls) == {"between": 1, "after": 2}.get(point):
            end()

    Path.replace = counted
    if point == "touch":
        Path.touch = end
    fsync = os.fsync
    if point == "before fsync":
        os.fsync = end
    if point == "after fsync":
        os.fsync = lambda number: (fsync(number), end())
    with writing(dict.fromkeys(files), force=True) as temporaries:
        for temporary in temporaries.values():
            with temporary.open("w") as file:
                file.write("new")
                file.flush()
                if point == "half":
                    end()
                file.write("er")


def test_a_kill_between_the_two_files_of_a_trace_leaves_the_newer_one(tmp_path):
    """The main file comes first; what belongs to it is found where the killed process left it."""
    path = tmp_path / "a.csv"
    ev.save(trace(50, 1), path)
    child = os.fork()
    if child == 0:
        replace = Path.replace
        Path.replace = lambda self, target: (replace(self, target), os._exit(7))
        ev.save(trace(50, 2), path)
        os._exit(3)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
    xarray.testing.assert_identical(ev.open_trace(path), trace(50, 2))
    for left in tmp_path.glob(".*"):
        left.write_text("half")
    with pytest.raises(InputError, match=r"a\.frequency\.csv: is of another save"):
        ev.open_trace(path)
    ev.save(trace(50, 3), path)
    xarray.testing.assert_identical(ev.open_trace(path), trace(50, 3))


def test_a_reproduction_that_was_killed_between_its_files_is_replaced_by_the_next(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write("out", 50, 1)
    child = os.fork()
    if child == 0:
        replace = Path.replace
        Path.replace = lambda self, target: (
            replace(self, target),
            os._exit(7) if target.name == "fig1.csv" else 0,
        )
        write("out", 50, 2)
        os._exit(3)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
    write("out", 50, 3)
    (tmp_path / "out" / "fig1.csv").write_text("mine")
    with pytest.raises(InputError, match=r"fig1\.csv: exists already"):
        write("out", 50, 4)


@pytest.mark.parametrize("at", [1, 2, 3])
def test_an_interrupt_between_two_files_of_one_save_waits(at, tmp_path, monkeypatch):
    """Ctrl-C never leaves one file of the older save beside one of the newer."""
    ev.save(trace(50, 1), tmp_path / "a.csv")
    replace, calls = Path.replace, []

    def interrupted(self, target):
        calls.append(target)
        if len(calls) == at:
            raise KeyboardInterrupt
        return replace(self, target)

    monkeypatch.setattr(Path, "replace", interrupted)
    if at < 3:
        with pytest.raises(KeyboardInterrupt):
            ev.save(trace(50, 2), tmp_path / "a.csv")
    else:
        ev.save(trace(50, 2), tmp_path / "a.csv")
    monkeypatch.undo()
    found = ev.open_trace(tmp_path / "a.csv")
    np.testing.assert_array_equal(found.drive_voltage, trace(50, 2).drive_voltage)
    np.testing.assert_array_equal(found.impedance, trace(50, 2).impedance)
    assert not list(tmp_path.glob(".*"))
