"""TOML files of the user: no door opens a pipe, a device, a folder, a socket or what is too large."""

import os
import signal
import socket
import sys
import tomllib
from pathlib import Path

import pytest

import electrovib as ev
from electrovib.bench.settings import read_settings
from electrovib.core.errors import InputError
from electrovib.core.parsing import MOST_KEYS, read_toml
from electrovib.recordings.recording import recording_of
from electrovib.scenario.space.reading import tables_of
from electrovib.studies.check.result import limits_from
from electrovib.studies.texture.reading import read_texture

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="pipes and devices with names are of POSIX")
DOORS = {
    "scenario": ev.load,
    "bench": read_settings,
    "limits": limits_from,
    "space": tables_of,
    "texture": read_texture,
    "channels": lambda path: recording_of("a.csv", speed=None, channels=path),
}


def _socket(path):
    with socket.socket(socket.AF_UNIX) as each:
        each.bind(path.name)


def _large(path):
    path.touch()
    os.truncate(path, 64_000_001)


MADE = {
    "pipe": (os.mkfifo if hasattr(os, "mkfifo") else None, "not an ordinary file"),
    "device": (lambda path: path.symlink_to("/dev/zero"), "not an ordinary file"),
    "socket": (_socket, "not an ordinary file"),
    "folder": (Path.mkdir, "is a folder"),
    "large": (_large, "larger than 64 MB"),
}


@pytest.fixture
def soon():
    """End a test that waits for a pipe."""

    def late(*_):
        raise TimeoutError

    before = signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_REAL, 5.0)
    yield
    signal.setitimer(signal.ITIMER_REAL, 0.0)
    signal.signal(signal.SIGALRM, before)


@pytest.mark.parametrize("kind", MADE)
@pytest.mark.parametrize("door", DOORS)
@pytest.mark.usefixtures("soon")
def test_what_is_no_ordinary_file_is_refused(door, kind, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    make, words = MADE[kind]
    make(Path("a.toml"))
    with pytest.raises(InputError, match=rf"a\.toml: (is )?{words}"):
        DOORS[door]("a.toml")


def test_no_other_module_reads_a_file_as_toml():
    """Except files of the package, and the page, whose uploads are read in a process of their own."""
    folder = Path(ev.__file__).parent
    reading = {
        str(path.relative_to(folder))
        for path in folder.rglob("*.py")
        for text in [path.read_text(encoding="utf-8")]
        if "read_toml(" in text and (".read_bytes()" in text or ".open(" in text or ".read_text(" in text)
    }
    assert reading == {
        "core/parsing.py",
        "apps/cli/meant.py",
        "apps/explorer/reading.py",
        "apps/explorer/state.py",
        "bench/settings.py",
        "papers/__init__.py",
        "physics/safety.py",
        "physics/material/library/__init__.py",
        "studies/catalogue/found.py",
        "studies/surfaces.py",
        "scenario/space/shipped/__init__.py",
    }


@pytest.mark.parametrize("keys", ["k{} = 1\n", "[k{}]\n", "[[k.k{}]]\n", '"k{}" = "="\n'])
@pytest.mark.parametrize("name", DOORS)
def test_more_keys_than_any_file_has_are_refused_before_they_are_read(tmp_path, monkeypatch, name, keys):
    monkeypatch.setattr(tomllib, "loads", pytest.fail)
    path = tmp_path / "many.toml"
    path.write_text("".join(keys.format(number) for number in range(MOST_KEYS + 1)), encoding="utf-8")
    with pytest.raises(InputError, match="it has more than 10000 keys"):
        DOORS[name](str(path))


def test_a_million_numbers_are_one_key():
    rows = ",\n  ".join(f"[{number}, {number / 7}]" for number in range(20_000))
    assert len(read_toml(f"values = [\n  {rows}\n]")["values"]) == 20_000
    assert len(read_toml("".join(f"k{number} = 1\n" for number in range(MOST_KEYS)))) == MOST_KEYS
