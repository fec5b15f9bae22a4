"""A full disk, a limit of file size, and a kill at any moment: what was there before is there still."""

import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from unittest.mock import MagicMock

import numpy as np
import pytest
import xarray

import electrovib as ev
from electrovib.core.answer import Curve, Panel
from electrovib.core.errors import InputError
from electrovib.core.signals import make_trace
from electrovib.data.atomic import Form, is_ours, writing
from electrovib.studies.reproduction import Reproduction
from electrovib.view import pages, report

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
        pages._write(reproduction(size, seed), Path("out"))
    elif name == "a.html":
        ev.report(trace(5, seed), name, title=str(seed) * size)
    elif name == "a.cir":
        ev.export("vezzoli_2014/fig6", name, set={"drive.high": float(seed + 1)})
    elif name == "a.toml":
        ev.init(ev.load("vezzoli_2014/fig6").replace({"drive.high": float(seed + 1)}), output=name)
    else:
        ev.save(trace(size, seed), name)


@pytest.fixture(autouse=True)
def here(monkeypatch, tmp_path):
    """A folder of its own. Drawing takes the time, and is not the point here."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(report, "figures", lambda *_: [])
    monkeypatch.setattr(pages, "to_png", lambda *_, **__: b"PNG" * 2000)
    monkeypatch.setattr(pages, "to_svg", lambda *_, **__: f"<svg>{'line' * 2000}</svg>")
    monkeypatch.setattr(pages, "drawn", MagicMock())


def visible() -> dict[str, bytes]:
    """What a person sees in this folder, but for what fills the disk."""
    files = [path for path in sorted(Path().rglob("*")) if path.is_file()]
    return {str(path): path.read_bytes() for path in files if path.suffix not in ("", ".partial")}


@pytest.fixture
def small_disk(tmp_path):
    """A disk of 256 kB."""
    place = tmp_path / "disk"
    place.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=256k", "tmpfs", str(place)]
    if subprocess.run(command, check=False, capture_output=True).returncode:
        pytest.skip("no permission to mount a small disk: not a device that can be filled")
    yield place
    os.chdir(tmp_path)
    subprocess.run(["umount", str(place)], check=True)


@contextmanager
def full_disk() -> Iterator[None]:
    ballast = Path("ballast")
    with ballast.open("wb", buffering=0) as file, suppress(OSError):
        while file.write(b"x" * 4096):
            pass
    yield
    ballast.unlink()


@contextmanager
def limit_of_size() -> Iterator[None]:
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (700, limits[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)


HINDRANCES = {"No space left on device": full_disk, "File too large": limit_of_size}


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("words", HINDRANCES)
def test_what_hinders_writing_is_told_and_the_next_save_works(words, name, request):
    if HINDRANCES[words] is full_disk:
        os.chdir(request.getfixturevalue("small_disk"))
    write(name, 50, 1)
    before = visible()
    with HINDRANCES[words]():
        with pytest.raises(InputError, match=f"cannot be written: {words}") as caught:
            write(name, 50, 2)
        assert visible() == before
    assert len(caught.value.problems) == 1
    assert not list(Path().rglob("*.partial"))
    write(name, 50, 2)
    assert visible() != before


def test_a_full_disk_on_the_command_line_is_one_line(small_disk):
    """The crash of the HDF5 library came at the end of the interpreter, so a whole process is looked at."""
    command = ["run", "--set", "time.samples=20000", "-o", str(small_disk / "a.nc")]
    run = [sys.executable, "-m", "electrovib", *command]
    done = subprocess.run(run, capture_output=True, text=True, check=False)
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


def touching(do: Callable[[], object]) -> Callable[..., None]:
    """Give a `Path.touch` that does something before."""
    touch = Path.touch
    return lambda self, **more: (do(), touch(self, **more))


def write_and_tell(name: str, seed: int, tell: int) -> None:
    """Write, and say when the first file is opened; then wait to be killed."""
    Path.touch = touching(lambda: os.write(tell, b"x"))
    write(name, 2000, seed)
    time.sleep(60)


def time_of_writing(name: str) -> float:
    """Seconds from the first temporary file to the end."""
    begun: list[float] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Path, "touch", touching(lambda: begun.append(time.monotonic())))
        write(name, 2000, 1)
    return time.monotonic() - begun[0]


def check_whole(name: str) -> None:
    """A file is whole if its checksum is right, and a Trace if it can be loaded and holds its own numbers."""
    forms = {"a.html": Form.PAGE, "a.cir": Form.NETLIST, "a.toml": Form.SCENARIO, "a.csv": Form.TABLE}
    if name in forms:
        assert is_ours(Path(name), forms[name])
    elif name == "out":
        assert is_ours(Path("out/report.html"), Form.PAGE)
        names = {"fig1.svg", "fig1.png", "fig1.csv", "numbers.json", "report.html"}
        assert {path.name for path in Path("out").iterdir() if path.suffix != ".partial"} == names
    else:
        is_version(name, size=2000)


def is_version(path: str, *, size: int, seed: int | None = None) -> None:
    """A Trace holds the numbers of one version: of a seed, or of its own."""
    found = ev.open_trace(path)
    expected = trace(size, found.attrs["seed"] if seed is None else seed)
    xarray.testing.assert_identical(found, expected)


@pytest.mark.parametrize("name", NAMES)
def test_a_kill_leaves_a_whole_file(name):
    killed_while_writing(name, (0.2, 0.9))


@pytest.mark.slow
def test_kills_at_a_hundred_random_moments_leave_whole_files():
    moments = np.random.default_rng(8).uniform(0, 1.2, (len(NAMES), 100))
    caught = {name: killed_while_writing(name, own) for name, own in zip(NAMES, moments, strict=True)}
    print(caught)
    assert sum(caught.values()) > 20


def ends_in_a_child(
    do: Callable[[], object], *, replaced: Callable[[str, int], bool] = lambda *_: False
) -> None:
    """Do something in a child of this process, which ends at once after a file took its place: by name and number."""
    child = os.fork()
    if child == 0:
        replace, calls = Path.replace, []

        def counted(self, target):
            replace(self, target)
            calls.append(target)
            if replaced(Path(target).name, len(calls)):
                end()

        Path.replace = counted
        do()
        os._exit(3)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7


def end(*_, **__):
    os._exit(7)


POINTS = ("touch", "half", "before fsync", "after fsync", "between", "after")


@pytest.mark.parametrize("point", POINTS)
def test_a_kill_at_a_chosen_moment_leaves_older_or_newer(point):
    for file in ("a", "b"):
        Path(file).write_text("older")
    count = {"between": 1, "after": 2}.get(point)
    ends_in_a_child(lambda: write_until(point), replaced=lambda _, number: number == count)
    expected = {"between": ["newer", "older"], "after": ["newer", "newer"]}
    assert [Path(file).read_text() for file in ("a", "b")] == expected.get(point, ["older", "older"])


def write_until(point: str) -> None:
    fsync = os.fsync
    if point == "touch":
        Path.touch = end
    elif point == "before fsync":
        os.fsync = end
    elif point == "after fsync":
        os.fsync = lambda number: (fsync(number), end())
    with writing({Path("a"): None, Path("b"): None}, force=True) as temporaries:
        for temporary in temporaries.values():
            with temporary.open("w") as file:
                file.write("new")
                file.flush()
                if point == "half":
                    end()
                file.write("er")


def test_a_reproduction_that_was_killed_between_its_files_is_replaced_by_the_next():
    write("out", 50, 1)
    ends_in_a_child(lambda: write("out", 50, 2), replaced=lambda name, _: name == "fig1.csv")
    write("out", 50, 3)
    Path("out/fig1.csv").write_text("mine")
    with pytest.raises(InputError, match=r"fig1\.csv: exists already"):
        write("out", 50, 4)


@pytest.mark.parametrize("at", [1, 2, 3])
def test_an_interrupt_between_two_files_of_one_save_waits(at, monkeypatch):
    """Ctrl-C never leaves one file of the older save beside one of the newer."""
    replace, calls = Path.replace, []

    def interrupted(self, target):
        calls.append(target)
        if len(calls) == at:
            raise KeyboardInterrupt
        return replace(self, target)

    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt) if at < 3 else nullcontext():
        patch.setattr(Path, "replace", interrupted)
        write_until("the end")
    assert [Path(name).read_text() for name in ("a", "b")] == ["newer", "newer"]
    assert not list(Path().glob(".*"))
