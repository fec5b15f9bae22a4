"""Outputs are whole or not there, what is not ours or is an input is never replaced, and one process writes at a time."""

import errno
import os
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from pathlib import Path

import filelock
import pytest

from electrovib.core.errors import InputError
from electrovib.data import atomic
from electrovib.data.atomic import Form, HeldError, check_writable, held, is_ours, sign, unsigned, write_text
from electrovib.data.atomic import writing as writing_all


@contextmanager
def writing(place):
    """One output without a mark, which may replace anything."""
    with writing_all({place: None}, force=True) as temporaries:
        yield temporaries[place]


def test_new_file_takes_its_place_only_when_complete(tmp_path):
    place = tmp_path / "out.txt"
    place.write_text("old")
    with writing(place) as temporary:
        assert temporary.parent == tmp_path
        assert temporary.name.endswith(".partial")
        temporary.write_text("new")
        assert place.read_text() == "old"
    assert place.read_text() == "new"
    assert list(tmp_path.iterdir()) == [place]


FULL = OSError(errno.ENOSPC, "No space left on device")


@pytest.mark.parametrize("failure", [ValueError, KeyboardInterrupt, SystemExit, FULL])
@pytest.mark.parametrize("older", [True, False])
def test_interrupted_writing_of_several_files_leaves_things_as_they_were(tmp_path, failure, older):
    first, second = tmp_path / "a", tmp_path / "b"
    if older:
        first.write_text("old")

    def interrupted() -> None:
        with writing_all({first: None, second: None}, force=True) as temporaries:
            for temporary in temporaries.values():
                temporary.write_text("half")
            raise failure

    full = failure is FULL  # one sentence
    words = r"^[^\n]*: cannot be written: No space left[^\n]*$" if full else None
    with pytest.raises(InputError if full else failure, match=words):
        interrupted()
    assert [p.read_text() for p in tmp_path.iterdir()] == ["old"] * older


def test_fault_of_another_file_is_not_blamed_on_the_output(tmp_path):
    with pytest.raises(FileNotFoundError, match="other"), writing(tmp_path / "out.txt"):
        (tmp_path / "other").read_text()


def test_links_modes_line_ends_and_long_names_survive(tmp_path):
    target, link, place = tmp_path / "target", tmp_path / "link", tmp_path / ("µ" * 120)
    target.write_text("old")
    target.chmod(0o640)
    link.symlink_to(target)
    write_text(link, "µ\r\n\n", Form.PAGE, force=True)
    assert link.is_symlink()
    assert target.read_bytes() == "µ\r\n\n".encode()
    assert target.stat().st_mode & 0o777 == 0o640
    write_text(place, "x", Form.PAGE)
    assert set(tmp_path.iterdir()) == {target, link, place}


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("folder", "is a folder"),
        ("missing/out.nc", "missing' does not exist"),
        ("file/out.nc", "file' is not a folder"),
        ("pipe", "not an ordinary file"),
        ("n" * 300, "not a usable file name"),
        ("zero\0byte", "not a usable file name"),
    ],
)
def test_unwritable_outputs_are_told_beforehand(tmp_path, name, words):
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("")
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match=words) as caught:
        check_writable({tmp_path / name: None})
    assert len(caught.value.problems) == 1
    with pytest.raises(InputError, match=words), writing(tmp_path / name):
        pytest.fail("must not start")


def test_missing_permission(tmp_path, monkeypatch):
    place = tmp_path / "out.nc"
    monkeypatch.setattr(atomic.os, "access", lambda path, _: Path(path) != tmp_path)
    with pytest.raises(InputError, match="no permission to write"):
        check_writable({place: None}, force=True)
    place.write_text("")
    monkeypatch.setattr(atomic.os, "access", lambda path, _: Path(path) != place)
    with pytest.raises(InputError, match="write-protected"):
        check_writable({place: None}, force=True)


def test_all_problems_at_once_and_none(tmp_path):
    with pytest.raises(InputError) as caught:
        check_writable(dict.fromkeys([tmp_path / "no" / "a", tmp_path / "b", tmp_path]))
    assert len(caught.value.problems) == 2
    check_writable(dict.fromkeys([tmp_path / "a", tmp_path / "b"]))
    assert not list(tmp_path.iterdir())


def test_what_a_killed_process_left_goes_with_the_next_save_a_day_later(tmp_path):
    path = tmp_path / "out.toml"
    old, new = (tmp_path / f".out.toml.{name}.partial" for name in ("aaaaaaaa", "bbbbbbbb"))
    for left in (old, new):
        left.write_text("half")
    day = time.time() - 2 * 86400
    os.utime(old, (day, day))
    write_text(path, "whole\n", Form.SCENARIO)
    assert sorted(each.name for each in tmp_path.iterdir()) == [new.name, path.name]


FORMS = list(Form)


def marked(form: Form, *, more: str = "") -> str:
    return f"first\n# {unsigned(form)}\n{more}last\n"


@pytest.mark.parametrize("form", FORMS)
def test_what_is_written_in_a_form_is_ours_in_this_form_only(tmp_path, form):
    path = tmp_path / "x"
    write_text(path, marked(form), form)
    assert [other for other in FORMS if is_ours(path, other)] == [form]
    assert unsigned(form) not in path.read_text()
    assert path.read_text().startswith(f"first\n# electrovib {form}, checksum ")


def test_changed_added_and_cut_content_makes_it_the_users(tmp_path):
    path = tmp_path / "x"
    write_text(path, marked(Form.PAGE), Form.PAGE)
    whole = path.read_bytes()
    flipped = [whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1 :] for at in range(len(whole))]
    for changed in (*flipped, whole + b"\n", whole[:-1], whole[1:], b""):
        path.write_bytes(changed)
        assert not is_ours(path, Form.PAGE)


@pytest.mark.parametrize("size", [0, 10, 1 << 20, (1 << 20) + 200])
def test_content_of_any_length_counts(tmp_path, size):
    path = tmp_path / "x"
    write_text(path, marked(Form.TABLE, more="7" * size), Form.TABLE)
    assert is_ours(path, Form.TABLE)
    path.write_text(path.read_text().replace("last", "lost"))
    assert not is_ours(path, Form.TABLE)


def test_a_mark_without_its_checksum_is_nobodys(tmp_path):
    path = tmp_path / "x"
    path.write_text(marked(Form.PAGE))
    assert not is_ours(path, Form.PAGE)
    assert not is_ours(tmp_path / "none", Form.PAGE)
    assert not is_ours(tmp_path, Form.PAGE)
    path.write_text("no mark")
    sign(path, Form.PAGE)
    assert path.read_text() == "no mark"


def test_a_file_that_is_not_ours_is_kept(tmp_path):
    path = tmp_path / "x"
    path.write_text("older")
    words = r"x: exists already and is no HTML page that electrovib wrote.*another name.*--force"
    with pytest.raises(InputError, match=words):
        check_writable({path: Form.PAGE})
    with pytest.raises(InputError, match=words):
        write_text(path, marked(Form.PAGE), Form.PAGE)
    with pytest.raises(InputError, match="somebody else's"), writing_all({path: None}):
        pytest.fail("must not start")
    assert path.read_text() == "older"
    write_text(path, marked(Form.PAGE), Form.PAGE, force=True)
    assert is_ours(path, Form.PAGE)
    write_text(path, marked(Form.PAGE, more="newer"), Form.PAGE)
    assert "newer" in path.read_text()
    with pytest.raises(InputError, match="is no netlist that"):
        check_writable({path: Form.NETLIST})


def test_an_input_is_never_replaced_and_two_outputs_are_two_files(tmp_path):
    path, link, hard = (tmp_path / name for name in ("x", "link", "hard"))
    write_text(path, marked(Form.PAGE), Form.PAGE)
    link.symlink_to(path)
    hard.hardlink_to(path)
    (tmp_path / "sub").mkdir()
    for output in (path, link, hard, tmp_path / "sub" / ".." / "x"):
        with pytest.raises(InputError, match=r"is an input, read as .*another name"):
            check_writable({output: Form.PAGE}, inputs=[tmp_path / "gone", path], force=True)
    check_writable({path: Form.PAGE}, inputs=[tmp_path / "gone"])
    (tmp_path / "b").symlink_to(tmp_path / "a")
    with pytest.raises(InputError, match="is the same file as the output"):
        check_writable({tmp_path / "a": None, tmp_path / "b": None})


HOLD = """
import errno, sys, time
from pathlib import Path
import filelock
from electrovib.data.atomic import held

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
