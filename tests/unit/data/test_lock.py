"""One process at a time: what a lock says, and that it ends with its process."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
import time
from contextlib import suppress

import filelock
import pytest

from electrovib.data.lock import HeldError, held

HOLD = """
import errno, sys, time
from pathlib import Path
import filelock
from electrovib.data.lock import held

def without(self, *_, **__):
    raise OSError(errno.ENOLCK, "No locks available")

if sys.argv[2] == "none":
    filelock.FileLock.acquire = without
with held(Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(60)
"""


@pytest.fixture(params=["of the system", "none"])
def locks(request, monkeypatch):
    """Locks of the operating system, and a file system without them."""

    def without(self, *_, **__):
        raise OSError(errno.ENOLCK, "No locks available")

    if request.param == "none":
        monkeypatch.setattr(filelock.FileLock, "acquire", without)
    return request.param


def test_the_lock_of_a_killed_process_is_free_and_says_who_held_it(tmp_path, locks):
    lock = tmp_path / ".lock"
    command = [sys.executable, "-c", HOLD, str(lock), locks]
    holder = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        assert holder.stdout.readline() == "held\n"
        for _ in range(2):  # to ask who holds it does not change the answer
            begun = time.monotonic()
            with pytest.raises(HeldError, match=f"process {holder.pid} on "), held(lock):
                pass
            assert time.monotonic() - begun < 5.0
    finally:
        holder.kill()
        holder.wait()
        holder.stdout.close()
    with held(lock) as left:
        assert left.startswith(f"process {holder.pid} on ")
        assert lock.exists()
    assert not list(tmp_path.iterdir())


@pytest.mark.usefixtures("locks")
def test_a_lock_is_released_whatever_happens_within(tmp_path):
    with pytest.raises(KeyError), held(tmp_path / ".lock"):
        raise KeyError
    assert not list(tmp_path.iterdir())
    with held(tmp_path / ".lock") as left:
        assert left == ""
        with pytest.raises(HeldError, match=f"process {os.getpid()} on "), held(tmp_path / ".lock"):
            pass
    with held(tmp_path / ".lock"):
        pass


def test_a_link_is_not_followed(tmp_path):
    (tmp_path / "mine").write_text("mine")
    (tmp_path / ".lock").symlink_to(tmp_path / "mine")
    with pytest.raises(OSError, match="symbolic links"), held(tmp_path / ".lock"):
        pass
    assert (tmp_path / "mine").read_text() == "mine"


@pytest.mark.parametrize("fails", [False, True])
def test_nothing_is_held_after_the_block(tmp_path, monkeypatch, fails):
    """Not even by an object that is not collected."""
    taken, acquire = [], filelock.FileLock.acquire

    def noted(self, *arguments, **options):
        taken.append(self)
        return acquire(self, *arguments, **options)

    monkeypatch.setattr(filelock.FileLock, "acquire", noted)
    with suppress(KeyError), held(tmp_path / ".lock"):
        assert taken[0].is_locked
        if fails:
            raise KeyError
    assert not taken[0].is_locked
