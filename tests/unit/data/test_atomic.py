"""Outputs are whole or not there."""

import errno
import os
import time
from contextlib import contextmanager
from pathlib import Path

import pytest

from electrovib.core.errors import InputError
from electrovib.data import atomic
from electrovib.data.atomic import check_writable, write_text
from electrovib.data.atomic import writing as writing_all
from electrovib.data.marks import Form


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


@pytest.mark.parametrize("failure", [ValueError, KeyboardInterrupt, SystemExit])
@pytest.mark.parametrize("older", [True, False])
def test_interrupted_write_leaves_things_as_they_were(tmp_path, failure, older):
    place = tmp_path / "out.txt"
    if older:
        place.write_text("old")

    def interrupted() -> None:
        with writing(place) as temporary:
            temporary.write_text("half")
            raise failure

    with pytest.raises(failure):
        interrupted()
    assert [p.read_text() for p in tmp_path.iterdir()] == ["old"] * older


def test_full_disk_is_one_sentence(tmp_path):
    place = tmp_path / "out.txt"
    with (
        pytest.raises(InputError, match=r"out\.txt: cannot be written: No space left") as caught,
        writing(place),
    ):
        raise OSError(errno.ENOSPC, "No space left on device")
    assert "\n" not in str(caught.value)
    assert not list(tmp_path.iterdir())


def test_fault_of_another_file_is_not_blamed_on_the_output(tmp_path):
    with pytest.raises(FileNotFoundError, match="other"), writing(tmp_path / "out.txt"):
        (tmp_path / "other").read_text()


def test_several_outputs_change_together(tmp_path):
    first, second = tmp_path / "a", tmp_path / "b"
    first.write_text("old")

    def second_fails() -> None:
        with writing_all({first: None, second: None}, force=True) as temporaries:
            for temporary in temporaries.values():
                temporary.write_text("new")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        second_fails()
    assert first.read_text() == "old"
    assert list(tmp_path.iterdir()) == [first]


def test_link_and_mode_survive(tmp_path):
    target, link = tmp_path / "target", tmp_path / "link"
    target.write_text("old")
    target.chmod(0o640)
    link.symlink_to(target)
    write_text(link, "µ\n", Form.PAGE, force=True)
    assert link.is_symlink()
    assert target.read_bytes() == "µ\n".encode()
    assert target.stat().st_mode & 0o777 == 0o640


def test_text_keeps_its_line_ends(tmp_path):
    write_text(tmp_path / "x", "a\r\nb\n", Form.PAGE)
    assert (tmp_path / "x").read_bytes() == b"a\r\nb\n"


def test_long_names_are_no_trouble(tmp_path):
    place = tmp_path / ("µ" * 120)
    write_text(place, "x", Form.PAGE)
    assert list(tmp_path.iterdir()) == [place]


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
